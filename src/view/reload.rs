//! GLSL that changes while what it draws is shown.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant, SystemTime};

use sha2::{Digest, Sha256};

use crate::gpu::shader::{Module, Modules};

/// Compiles a module of a folder, on any thread: SPIR-V, or what is wrong, with file and line.
pub(super) type Compile = Arc<dyn Fn(&Path, Module) -> Result<Vec<u32>, String> + Send + Sync>;

/// SHA-256 in hexadecimal, by the file's name relative to the folder.
pub(super) type Hashes = BTreeMap<String, String>;

type Outcome = Result<Vec<(Module, Vec<u32>)>, String>;

/// Watches a folder of GLSL, and compiles the modules whose sources have changed.
pub(super) struct Reload {
    glsl: PathBuf,
    compile: Compile,
    /// Of the sources that modules are compiled from now.
    compiled: Hashes,
    /// Of the files as they were last looked at.
    found: Hashes,
    /// When they had been written then, and how long they were.
    stamps: BTreeMap<String, (Option<SystemTime>, u64)>,
    modules: Modules,
    worker: Option<Receiver<(Hashes, Outcome)>>,
    /// When to look next.
    due: Instant,
}

/// Files are looked at so often.
const EVERY: Duration = Duration::from_millis(400);

impl Reload {
    /// Of a folder; what the program has built in was compiled from files with these hashes.
    pub(super) fn new(glsl: PathBuf, built: Hashes, compile: Compile) -> Self {
        Self {
            glsl,
            compile,
            found: built.clone(),
            compiled: built,
            stamps: BTreeMap::new(),
            modules: Modules::default(),
            worker: None,
            due: Instant::now(),
        }
    }

    /// Has the files looked at with the next [`Self::poll`].
    pub(super) fn look_now(&mut self) {
        self.due = Instant::now();
    }

    /// Whether the files are yet to be looked at, or something is being compiled.
    pub(super) fn is_busy(&self) -> bool {
        self.worker.is_some() || self.due <= Instant::now()
    }

    /// Looks at times, and has compiled what has changed; what came of it, once: all modules, or why they stay as they are.
    pub(super) fn poll(&mut self) -> Option<Result<Modules, String>> {
        if let Some(worker) = &self.worker {
            let (hashes, outcome) = match worker.try_recv() {
                Ok(done) => done,
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => (Hashes::new(), Err("the compiler panicked".into())),
            };
            self.worker = None;
            return Some(outcome.map(|modules| {
                self.compiled = hashes;
                self.modules = self.modules.with(modules);
                self.modules.clone()
            }));
        }
        if self.due > Instant::now() {
            return None;
        }
        self.due = Instant::now() + EVERY;
        if !self.look() {
            return None;
        }
        let changed: BTreeSet<_> = self
            .found
            .iter()
            .filter(|(name, hash)| self.compiled.get(*name) != Some(hash))
            .map(|(name, _)| name.clone())
            .collect();
        let mut stale = Module::ALL.to_vec();
        stale.retain(|module| {
            sources(&self.glsl, module.source()).iter().any(|source| changed.contains(source))
        });
        if stale.is_empty() {
            self.compiled.clone_from(&self.found);
            return None;
        }
        // Constants that the program has too are built into it.
        if let Some(shared) = changed.get(SHARED) {
            let told =
                format!("{shared} has changed, and the program has its numbers built in: build it again");
            return Some(Err(told));
        }
        let (sender, receiver) = channel();
        let (glsl, compile, hashes) = (self.glsl.clone(), Arc::clone(&self.compile), self.found.clone());
        std::thread::spawn(move || {
            let compiled = stale.into_iter().map(|module| Ok((module, compile(&glsl, module)?)));
            // A window that was closed wants it no more.
            let _ = sender.send((hashes, compiled.collect()));
        });
        self.worker = Some(receiver);
        None
    }

    /// Whether a file is another than when it was last looked at.
    fn look(&mut self) -> bool {
        let mut has_changed = false;
        let mut folders = vec![self.glsl.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
                let path = entry.path();
                let Ok(metadata) = fs::metadata(&path) else { continue };
                if metadata.is_dir() {
                    folders.push(path);
                    continue;
                }
                let is_source = path.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e == *known));
                let name = path.strip_prefix(&self.glsl).ok().and_then(Path::to_str).filter(|_| is_source);
                let Some(name) = name else { continue };
                let stamp = (metadata.modified().ok(), metadata.len());
                if self.stamps.insert(name.to_owned(), stamp) == Some(stamp) {
                    continue;
                }
                let Ok(bytes) = fs::read(&path) else { continue };
                let hash = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
                has_changed |= self.found.insert(name.to_owned(), hash.clone()) != Some(hash);
            }
        }
        has_changed
    }
}

const EXTENSIONS: [&str; 5] = ["vert", "frag", "comp", "glsl", "h"];
const SHARED: &str = "shared.h";

/// A file and what it includes, directly or not.
fn sources(glsl: &Path, source: &str) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut left = vec![source.to_owned()];
    while let Some(source) = left.pop() {
        let text = fs::read_to_string(glsl.join(&source)).unwrap_or_default();
        if all.insert(source) {
            let quoted =
                |line: &str| Some(line.trim().strip_prefix("#include")?.split('"').nth(1)?.to_owned());
            left.extend(text.lines().filter_map(quoted));
        }
    }
    all
}

#[cfg(feature = "shader-compiler")]
mod with_compiler {
    use super::super::app::App;
    use super::*;
    use crate::gpu::shader::compile;

    impl Reload {
        /// Compiles by the compiler that this build has.
        pub(in crate::view) fn of_folder(glsl: PathBuf) -> Self {
            let manifest = include_str!("../../glsl/spirv/manifest.json");
            let manifest: serde_json::Value = serde_json::from_str(manifest).unwrap_or_default();
            let built = serde_json::from_value(manifest["sources"].clone()).unwrap_or_default();
            Self::new(glsl, built, Arc::new(|glsl, module| Ok(compile(glsl, module)?.spirv)))
        }
    }

    impl App {
        /// Draws with modules that were compiled, or with those before.
        pub(in crate::view) fn take_modules(&mut self) {
            let Some(outcome) = self.reload.as_mut().and_then(Reload::poll) else { return };
            let Some(open) = &mut self.open else { return };
            let modules = match outcome {
                Ok(modules) => modules,
                Err(problem) => return self.tell_text(&problem),
            };
            let (scene, options) = (self.world.scene(), &self.viewer.options);
            match open.frames.set_modules(modules, scene, options, &self.compare) {
                Ok(()) => self.message.borrow_mut().clear(),
                Err(error) => self.tell(&error),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// A folder whose files say `bad` where they do not compile, and what was compiled.
    struct Bench {
        folder: tempfile::TempDir,
        reload: Reload,
        compiled: Arc<Mutex<Vec<&'static str>>>,
    }

    impl Bench {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
            for module in Module::ALL {
                write(module.source(), "#include \"common.glsl\"\n");
            }
            write("tonemap.frag", "#include \"common.glsl\"\n#include \"curve.glsl\"\n");
            write("curve.glsl", "#include \"common.glsl\"\ngood\n");
            write("common.glsl", "good\n");
            write("shared.h", "#define ONE 1\n");
            let compiled = Arc::<Mutex<Vec<&'static str>>>::default();
            let log = Arc::clone(&compiled);
            let compile = move |glsl: &Path, module: Module| {
                log.lock().unwrap().push(module.name());
                let text = |source: &String| fs::read_to_string(glsl.join(source)).unwrap();
                let all: Vec<_> = sources(glsl, module.source()).into_iter().map(|s| (text(&s), s)).collect();
                match all.iter().find(|(text, _)| text.contains("bad")) {
                    Some((_, source)) => Err(format!("{source}:1: error: bad")),
                    None => Ok(vec![all.iter().map(|(text, _)| text.len() as u32).sum()]),
                }
            };
            let mut reload = Reload::new(folder.path().to_owned(), Hashes::new(), Arc::new(compile));
            reload.look();
            reload.compiled.clone_from(&reload.found);
            Self { folder, reload, compiled }
        }

        /// What comes of a file's new text, and the modules that were compiled for it.
        fn write(&mut self, name: &str, text: &str) -> (Option<Result<Modules, String>>, Vec<&'static str>) {
            fs::write(self.folder.path().join(name), text).unwrap();
            self.reload.look_now();
            let mut outcome = None;
            while outcome.is_none() && self.reload.is_busy() {
                outcome = self.reload.poll();
            }
            (outcome, std::mem::take(&mut *self.compiled.lock().unwrap()))
        }
    }

    #[test]
    fn what_includes_a_file_that_changed_is_compiled_and_what_is_broken_stays_as_it_was() {
        let mut bench = Bench::new();
        let tonemap = |outcome: &Option<Result<Modules, String>>| match outcome {
            Some(Ok(modules)) => modules.spirv(Module::Tonemap).unwrap().to_vec(),
            other => panic!("{other:?}"),
        };
        let (outcome, compiled) = bench.write("curve.glsl", "better\n");
        assert_eq!(compiled, ["tonemap.frag", "tonemap_samples.frag"]);
        let first = tonemap(&outcome);
        assert_eq!(first.len(), 1, "it is the one that was compiled");
        let modules = outcome.unwrap().unwrap();
        assert_eq!(modules.spirv(Module::Sky).unwrap(), Module::Sky.spirv().unwrap(), "others are as built");
        let (outcome, _) = bench.write("curve.glsl", "bad\n");
        assert_eq!(outcome.unwrap().unwrap_err(), "curve.glsl:1: error: bad");
        let (outcome, compiled) = bench.write("curve.glsl", "bad\n");
        assert!(outcome.is_none() && compiled.is_empty(), "it is told once");
        // What else changes meanwhile does not hide it.
        let (outcome, _) = bench.write("sky.frag", "good\n");
        assert_eq!(outcome.unwrap().unwrap_err(), "curve.glsl:1: error: bad");
        let (outcome, compiled) = bench.write("curve.glsl", "better\n");
        assert_eq!(compiled, ["sky.frag"], "the curve is again what is drawn");
        assert_eq!(tonemap(&outcome), first);
        let (outcome, compiled) = bench.write("common.glsl", "longer than before\n");
        assert_eq!(compiled.len(), Module::ALL.len() - 1, "all but the sky");
        assert!(tonemap(&outcome)[0] > first[0]);
        let (outcome, compiled) = bench.write("unused.glsl", "bad\n");
        assert!(outcome.is_none() && compiled.is_empty());
    }

    #[test]
    fn numbers_that_the_program_shares_are_not_compiled_alone() {
        let mut bench = Bench::new();
        bench.write("sky.frag", "#include \"shared.h\"\n").0.unwrap().unwrap();
        let (outcome, compiled) = bench.write("shared.h", "#define ONE 2\n");
        let told = outcome.unwrap().unwrap_err();
        assert!(told.contains("build it again") && compiled.is_empty(), "{told}");
    }
}
