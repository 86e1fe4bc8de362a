//! The invariants of the source tree that a search can see.

use std::path::{Path, PathBuf};

/// Words that may occur in code only in some files.
struct Rule {
    what: &'static str,
    /// Where the rule holds: beginnings of paths.
    within: &'static [&'static str],
    /// Where it does not.
    except: &'static [&'static str],
    /// Identifiers, or beginnings of paths (`gltf::`).
    words: &'static [&'static str],
    /// A line that breaks it, and a file where it would.
    planted: (&'static str, &'static str),
}

const RULES: &[Rule] = &[
    Rule {
        what: "Vulkan is named only by the GPU side, the C interface and the error type",
        within: &["src/"],
        except: &["src/gpu/", "src/capi/", "src/error.rs"],
        words: &["ash", "vk"],
        planted: ("src/cli/info.rs", "use ash::vk;"),
    },
    Rule {
        what: "the plan knows no device",
        within: &["src/plan/"],
        except: &[],
        words: &["ash", "vk", "gpu"],
        planted: ("src/plan/mod.rs", "    fn format(self) -> crate::gpu::Format {"),
    },
    Rule {
        what: "the reference never looks at the GPU",
        within: &["src/reference/"],
        except: &[],
        words: &["ash", "vk", "gpu"],
        planted: ("src/reference/brdf.rs", "use crate::{gpu, plan};"),
    },
    Rule {
        what: "the scene knows nothing that comes after it",
        within: &["src/scene/"],
        except: &[],
        words: &["ash", "vk", "gpu", "plan", "reference"],
        planted: ("src/scene/mesh.rs", "use crate::plan::Needs;"),
    },
    Rule {
        what: "what a view sees follows from the scene alone",
        within: &["src/visible/"],
        except: &[],
        words: &["ash", "vk", "gpu", "plan", "reference"],
        planted: ("src/visible/frustum.rs", "use crate::gpu::View;"),
    },
    Rule {
        what: "only the loader names the glTF library",
        within: &["src/"],
        except: &["src/scene/gltf", "src/scene/mod.rs"],
        words: &["gltf::"],
        planted: ("src/cli/scene.rs", "let document = gltf::Gltf::open(path)?;"),
    },
    Rule {
        what: "unsafe code is the GPU side's, the C interface's and that of Android's entry",
        within: &["src/", "tools/"],
        except: &["src/gpu/", "src/capi/", "src/view/android.rs", "tools/android_apk/"],
        words: &["unsafe"],
        planted: ("src/picture.rs", "let texel = unsafe { *pixels.get_unchecked(i) };"),
    },
];

/// Package registries: what the tools install comes from the machine's own configuration.
const HOSTS: &[&str] = &[
    concat!("crates", ".io"),
    concat!("deb.debian", ".org"),
    concat!("snapshot.debian", ".org"),
    concat!("security.debian", ".org"),
    concat!("archive.ubuntu", ".com"),
    concat!("pypi", ".org"),
    concat!("npmjs", ".org"),
    concat!("proxy.golang", ".org"),
];

/// Longer files are read by nobody.
const MOST_LINES: usize = 450;

impl Rule {
    /// What breaks the rule in a file.
    fn broken_by(&self, path: &str, text: &str) -> Vec<String> {
        let begins = |prefixes: &[&str]| prefixes.iter().any(|p| path.starts_with(p));
        if !begins(self.within) || begins(self.except) || !path.ends_with(".rs") {
            return Vec::new();
        }
        let breaks = |line: &str| self.words.iter().any(|word| names(line, word));
        let lines = text.lines().enumerate().filter(|(_, line)| breaks(code(line)));
        lines.map(|(i, line)| format!("{path}:{}: {}: {}", i + 1, self.what, line.trim())).collect()
    }
}

/// The line without its comment.
fn code(line: &str) -> &str {
    line.split_once("//").map_or(line, |(code, _)| code)
}

/// Whether the line has this word, not as a part of another; `word` may end in `::`.
fn names(line: &str, word: &str) -> bool {
    let part_of_word = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(start, _)| {
        let [before, after] = [line[..start].chars().next_back(), line[start + word.len()..].chars().next()];
        !before.is_some_and(part_of_word) && (word.ends_with(':') || !after.is_some_and(part_of_word))
    })
}

fn too_long(path: &str, text: &str) -> Option<String> {
    const GENERATED: &str = "src/capi/ontile.h";
    let written = [".rs", ".glsl", ".vert", ".frag", ".c", ".h"].iter().any(|e| path.ends_with(e))
        || path.starts_with("tools/");
    let written = written && path != GENERATED;
    let lines = text.lines().count();
    (written && lines > MOST_LINES).then(|| format!("{path}: {lines} lines, {MOST_LINES} at most"))
}

fn names_registry(path: &str, text: &str) -> Vec<String> {
    // Cargo writes where packages came from.
    let hosts = HOSTS.iter().filter(|host| path != "Cargo.lock" && text.contains(**host));
    hosts.map(|host| format!("{path}: names the registry {host}")).collect()
}

fn problems(path: &str, text: &str) -> Vec<String> {
    let mut all: Vec<_> = RULES.iter().flat_map(|rule| rule.broken_by(path, text)).collect();
    all.extend(too_long(path, text));
    all.extend(names_registry(path, text));
    all
}

/// All text files with their paths from the repository's root.
fn files() -> Vec<(String, String)> {
    fn walk(folder: &Path, all: &mut Vec<PathBuf>) {
        let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        for path in entries.map(|entry| entry.expect("folders can be listed").path()) {
            if !path.is_dir() {
                all.push(path);
            } else if ![".git", "target"].iter().any(|skipped| path.ends_with(skipped)) {
                walk(&path, all);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    walk(root, &mut paths);
    paths.sort();
    let text = |path: PathBuf| {
        let text = String::from_utf8(std::fs::read(&path).ok()?).ok()?;
        Some((path.strip_prefix(root).expect("it is within").to_string_lossy().into_owned(), text))
    };
    paths.into_iter().filter_map(text).collect()
}

#[test]
fn the_source_keeps_its_invariants() {
    let files = files();
    for rule in RULES {
        let applies = |path: &str| rule.within.iter().any(|p| path.starts_with(p));
        assert!(files.iter().any(|(path, _)| applies(path)), "nothing to search: {}", rule.what);
        for exception in rule.except {
            assert!(files.iter().any(|(path, _)| path.starts_with(exception)), "{exception} does not exist");
        }
    }
    let broken: Vec<_> = files.iter().flat_map(|(path, text)| problems(path, text)).collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_rule_sees_what_breaks_it() {
    for rule in RULES {
        let (path, line) = rule.planted;
        assert_eq!(rule.broken_by(path, line).len(), 1, "not seen: {}", rule.what);
        let comment = format!("/// {line}");
        assert!(rule.broken_by(path, &comment).is_empty(), "a comment breaks: {}", rule.what);
        for exception in rule.except {
            let path = format!("{exception}x.rs");
            assert!(rule.broken_by(&path, line).is_empty(), "an exception breaks: {}", rule.what);
        }
    }
    assert!(
        !names("let gpu_frame_ms = vkCreate(hash);", "gpu")
            && !names("hash", "ash")
            && !names("vkCreate", "vk")
    );
    let long = "x\n".repeat(MOST_LINES + 1);
    assert!(too_long("src/lib.rs", &long).is_some() && too_long("assets/a.txt", &long).is_none());
    assert!(too_long("src/lib.rs", &long[2..]).is_none());
    for host in HOSTS {
        assert_eq!(names_registry("tools/test", &format!("curl https://{host}/")).len(), 1, "{host}");
    }
}
