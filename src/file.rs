//! Files that are complete or not there at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::{Error, Result};

/// Writes `bytes` as the whole content of `path`.
///
/// The bytes go to a temporary file in the same folder, which then takes the place of `path`: whoever reads
/// `path` sees the old content or the new, never a part. A symbolic link stays and its target is replaced or
/// made; a device or pipe is written to directly.
///
/// # Errors
/// [`Error::Io`]; `path` is then as it was and no temporary file is left.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    stage(path, bytes)?.commit()
}

/// The first part of [`write_whole`]: the bytes are on the disk, but `path` is as it was until [`Staged::commit`].
///
/// # Errors
/// As [`write_whole`].
pub fn stage(path: &Path, bytes: &[u8]) -> Result<Staged> {
    let written = try_stage(path, bytes).map_err(|source| Error::io(path, "write", source))?;
    Ok(Staged { path: path.to_owned(), written })
}

/// A file that lacks its name only. Dropped, it is gone.
#[must_use = "without `commit` nothing is written"]
pub struct Staged {
    path: PathBuf,
    written: Written,
}

enum Written {
    /// To be renamed to the path beside it.
    Temporary(Temporary, PathBuf),
    /// Nothing yet: what is there is no file that could be replaced.
    Device(Vec<u8>),
}

impl Staged {
    /// Gives it its name.
    ///
    /// # Errors
    /// [`Error::Io`]; the path is then as it was.
    pub fn commit(self) -> Result<()> {
        let done = match self.written {
            Written::Temporary(mut temporary, target) => {
                fs::rename(&temporary.path, &target).map(|()| temporary.renamed = true)
            }
            Written::Device(bytes) => fs::write(&self.path, bytes),
        };
        done.map_err(|source| Error::io(&self.path, "write", source))
    }
}

/// Where this crate keeps what it can make again: `$XDG_CACHE_HOME/ontile`, or `~/.cache/ontile`; `None` without a home.
pub fn cache_folder() -> Option<PathBuf> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let caches = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(caches.join("ontile"))
}

fn try_stage(path: &Path, bytes: &[u8]) -> io::Result<Written> {
    let target = match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => return Ok(Written::Device(bytes.to_vec())),
        Ok(_) => fs::canonicalize(path)?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => match fs::read_link(path) {
            // A link to nothing: links in a circle are another kind of error, so this ends.
            Ok(target) => return try_stage(&path.with_file_name(target), bytes),
            Err(_) => path.to_owned(),
        },
        Err(e) => return Err(e),
    };
    let mut temporary = Temporary::create_beside(&target)?;
    temporary.file.write_all(bytes)?;
    Ok(Written::Temporary(temporary, target))
}

/// A file that goes away with its owner unless it got its final name.
struct Temporary {
    path: PathBuf,
    file: fs::File,
    renamed: bool,
}

impl Temporary {
    fn create_beside(target: &Path) -> io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        target.file_name().ok_or(io::ErrorKind::InvalidInput)?;
        loop {
            // Not made from the target's name, which may be as long as names can be.
            let count = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = target.with_file_name(format!(".ontile-{}-{count}.tmp", std::process::id()));
            match fs::File::create_new(&path) {
                Ok(file) => return Ok(Self { path, file, renamed: false }),
                // Left by a process that was killed and had the same number.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // The failure that led here is the one worth reporting.
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn writes_and_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, b"first, and longer").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_name_may_be_as_long_as_names_can_be() {
        let folder = tempfile::tempdir().unwrap();
        let name = "n".repeat(255);
        write_whole(&folder.path().join(&name), b"x").unwrap();
        assert_eq!(names(folder.path()), [name]);
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent/a.txt");
        let message = write_whole(&path, b"x").unwrap_err().to_string();
        assert!(message.contains("absent/a.txt: cannot write"), "{message}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_folder_in_the_way_stays_and_no_temporary_file_is_left() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("taken")).unwrap();
        write_whole(&folder.path().join("taken"), b"x").unwrap_err();
        assert_eq!(names(folder.path()), ["taken"]);
    }

    #[test]
    fn a_rename_that_fails_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut temporary = Temporary::create_beside(&folder.path().join("a.txt")).unwrap();
        temporary.file.write_all(b"half").unwrap();
        assert_eq!(names(folder.path()).len(), 1, "the temporary file is beside its target");
        drop(temporary);
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_stays_a_device() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, b"old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");

        let dangling = folder.path().join("dangling");
        std::os::unix::fs::symlink("made", &dangling).unwrap();
        write_whole(&dangling, b"new").unwrap();
        assert!(fs::symlink_metadata(&dangling).unwrap().is_symlink());
        assert_eq!(fs::read(folder.path().join("made")).unwrap(), b"new");

        let circle = folder.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        write_whole(&circle, b"new").unwrap_err();
        assert!(fs::symlink_metadata(&circle).unwrap().is_symlink());

        write_whole(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
