//! Files that hold what a test expects.

use std::path::{Path, PathBuf};

/// The variable that makes tests rewrite what they expect.
const UPDATE: &str = "ONTILE_UPDATE";

/// Expected files of one folder, and what was wrong with them. Ask [`Self::finish`] at the end.
#[must_use = "`finish` fails the test"]
pub struct Expected {
    folder: PathBuf,
    update: bool,
    problems: Vec<String>,
}

impl Expected {
    /// The files in `tests/FOLDER`; rewritten if `ONTILE_UPDATE` is set.
    pub fn in_folder(folder: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
        Self::new(&folder, std::env::var_os(UPDATE).is_some_and(|value| !value.is_empty()))
    }

    /// The files in any folder.
    pub fn new(folder: &Path, update: bool) -> Self {
        Self { folder: folder.to_owned(), update, problems: Vec::new() }
    }

    /// Compares `actual` with a file's content by `difference`, which says what is wrong, if anything.
    ///
    /// A missing file is a problem. With the update on, the file is written if it differs, and that is a problem too:
    /// nobody has looked at it yet.
    pub fn check(&mut self, name: &str, actual: &[u8], difference: impl Fn(&[u8]) -> Option<String>) {
        let path = self.folder.join(name);
        let wrong = match std::fs::read(&path) {
            Ok(expected) => difference(&expected),
            Err(error) => Some(format!("{error}; {UPDATE}=1 writes it")),
        };
        let Some(wrong) = wrong else { return };
        if self.update {
            std::fs::write(&path, actual).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            self.problems.push(format!("{}: rewritten; look at it, then run again", path.display()));
        } else {
            self.problems.push(format!("{}: {wrong}", path.display()));
        }
    }

    /// A file that nothing expects any more is a problem; `names` are those that were checked.
    pub fn nothing_else(&mut self, names: &[String]) {
        let entries = std::fs::read_dir(&self.folder).expect("the folder of expected files");
        for entry in entries.map(|e| e.expect("it can be listed")) {
            let name = entry.file_name().to_string_lossy().into_owned();
            if !names.contains(&name) {
                self.problems.push(format!("{}: no test expects it", entry.path().display()));
            }
        }
    }

    /// What was wrong.
    pub fn problems(&self) -> &[String] {
        &self.problems
    }

    /// # Panics
    ///
    /// If anything was wrong.
    pub fn finish(self) {
        assert!(self.problems.is_empty(), "{}", self.problems.join("\n"));
    }
}
