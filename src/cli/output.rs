//! Where a file may be written.

use std::fs;
use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use ontile::{Error, Result};

/// Checks before long work that `path` can be written to and is none of the files that the run also needs.
pub fn check(path: &Path, others: &[&Path]) -> Result<()> {
    let refused = |kind, why: &str| Err(Error::io(path, "write", IoError::new(kind, why)));
    if !folder(path).is_dir() {
        return refused(ErrorKind::NotFound, "its folder does not exist; make it first");
    }
    if path.is_dir() {
        return refused(ErrorKind::IsADirectory, "it is a folder; name a file");
    }
    // What devices and pipes are given is not lost by writing to them again.
    let is_replaced = fs::metadata(path).map_or(true, |found| found.is_file());
    let other = others.iter().find(|other| location(other) == location(path));
    match other {
        Some(other) if is_replaced => {
            let why =
                format!("it would replace {}, which this run needs; name another file", other.display());
            refused(ErrorKind::AlreadyExists, &why)
        }
        _ => Ok(()),
    }
}

/// The same for all names of one file, also of one that is yet to be made.
fn location(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| {
        let folder = fs::canonicalize(folder(path)).unwrap_or_else(|_| folder(path).to_owned());
        folder.join(path.file_name().unwrap_or_default())
    })
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
