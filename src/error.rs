//! The one error type. Every message names what failed, where, and what to do about it.

use std::path::{Path, PathBuf};

/// Why an operation of this crate failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file's content cannot be used.
    #[error("{}: {element}: {problem}; {remedy}", path.display())]
    Input {
        /// The file that was read.
        path: PathBuf,
        /// The element inside the file, e.g. `meshes[2].primitives[0].attributes.POSITION`.
        element: String,
        /// What is wrong with it.
        problem: String,
        /// What the user can do.
        remedy: String,
    },
    /// A file cannot be read or written.
    #[error("{}: cannot {action}: {source}{}", path.display(), io_remedy(action, source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What was attempted, as a verb: `read`, `write`, `create`.
        action: &'static str,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The plan or the device cannot do what was asked for.
    #[error("{what}; {remedy}")]
    Unsupported {
        /// What is missing.
        what: String,
        /// What the user can do.
        remedy: String,
    },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}{}", vulkan_remedy(*result))]
    Vulkan {
        /// The Vulkan function's name.
        call: &'static str,
        /// What it returned.
        result: ash::vk::Result,
    },
}

/// `std::result::Result` with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`Error::Input`].
    pub fn input(
        path: &Path,
        element: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Input {
            path: path.to_owned(),
            element: element.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// An [`Error::Io`].
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, source }
    }

    /// An [`Error::Unsupported`].
    pub fn unsupported(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into(), remedy: remedy.into() }
    }
}

/// What to do about the operating system's reasons; those that this crate gives say it themselves.
fn io_remedy(action: &str, source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind as K;
    if source.get_ref().is_some() {
        return "";
    }
    match (source.kind(), action) {
        (K::NotFound, "read") => "; name a file that is there",
        (K::NotFound, _) => "; make its folder first",
        (K::PermissionDenied, "read") => "; name a file that you may read",
        (K::PermissionDenied | K::ReadOnlyFilesystem, _) => "; name a place that you may write to",
        (K::AlreadyExists, _) => "; a file has that name: name another place",
        (K::NotADirectory, _) => "; a part of its path is a file: correct the path",
        (K::IsADirectory, _) => "; it is a folder: name a file",
        (K::StorageFull | K::QuotaExceeded, _) => "; make room there, or write elsewhere",
        _ => "",
    }
}

fn vulkan_remedy(result: ash::vk::Result) -> &'static str {
    use ash::vk::Result as R;
    match result {
        R::ERROR_OUT_OF_DEVICE_MEMORY => "; render at a smaller --size or free memory on the device",
        R::ERROR_OUT_OF_HOST_MEMORY => "; free memory on this machine",
        R::ERROR_DEVICE_LOST => "; the driver gave up: run again with --validate to see why",
        R::ERROR_INCOMPATIBLE_DRIVER | R::ERROR_INITIALIZATION_FAILED => {
            "; install a Vulkan driver (on Debian: apt-get install mesa-vulkan-drivers)"
        }
        R::ERROR_LAYER_NOT_PRESENT => {
            "; install the validation layer (on Debian: apt-get install vulkan-validationlayers)"
        }
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Error as IoError;

    #[test]
    fn what_the_system_refuses_comes_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        std::fs::write(at.join("file"), "").unwrap();
        let of = |action, source: IoError| Error::io(Path::new("a"), action, source).to_string();
        for (error, remedy) in [
            (of("read", std::fs::read(at.join("absent")).unwrap_err()), "; name a file that is there"),
            (of("write", std::fs::write(at.join("absent/a"), "").unwrap_err()), "; make its folder first"),
            (of("create", std::fs::create_dir(at.join("file")).unwrap_err()), "name another place"),
            (of("read", std::fs::read(at.join("file/a")).unwrap_err()), "correct the path"),
            (of("write", std::io::ErrorKind::StorageFull.into()), "; make room there, or write elsewhere"),
            (
                of("write", std::io::ErrorKind::PermissionDenied.into()),
                "; name a place that you may write to",
            ),
        ] {
            assert!(error.starts_with("a: cannot ") && error.ends_with(remedy), "{error}");
        }
        let own = of("write", IoError::new(std::io::ErrorKind::NotFound, "its folder is gone; make it"));
        assert!(own.ends_with("its folder is gone; make it"), "{own}");
    }
}
