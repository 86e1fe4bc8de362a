//! Prefiltered environments kept between runs.

use std::fs;
use std::path::PathBuf;

use sha2::{Digest, Sha256};

use super::file::VERSION;
use super::panorama::Panorama;
use super::prefiltered::Prefiltered;
use super::texel::TexelFormat;
use crate::{Error, Result, file};

/// Goes up with every change of the filters' results.
const FILTER_VERSION: u32 = 1;

/// A folder of prefiltered environments, one file for each content and choice of parameters. What is in it can be
/// deleted at any time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// In this folder, which is made when something is kept.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// The user's: see [`file::cache_folder`]. `None` without one.
    pub fn of_user() -> Option<Self> {
        file::cache_folder().map(Self::new)
    }

    /// The file for these inputs of [`Prefiltered::new`].
    pub fn path(&self, panorama: &Panorama, face_size: u32, format: TexelFormat) -> PathBuf {
        let mut hash = Sha256::new();
        for number in [VERSION, FILTER_VERSION, face_size, panorama.width(), panorama.height()] {
            hash.update(number.to_le_bytes());
        }
        hash.update(format.name());
        for texel in panorama.texels() {
            hash.update(texel.to_array().map(f32::to_le_bytes).as_flattened());
        }
        let name: String = hash.finalize()[..16].iter().map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(format!("environment-{name}.ktx2"))
    }

    fn keep(&self, path: &std::path::Path, prefiltered: &Prefiltered) -> Result<()> {
        fs::create_dir_all(&self.folder).map_err(|e| Error::io(&self.folder, "create", e))?;
        prefiltered.write(path)
    }
}

/// [`Prefiltered::new`], or what it gave in an earlier run. A file that is missing or damaged is made again; one that
/// cannot be written costs only the time of the next run, so that is logged and no more.
///
/// # Panics
/// As [`Prefiltered::new`].
pub fn cached(
    panorama: &Panorama,
    face_size: u32,
    format: TexelFormat,
    cache: Option<&Cache>,
) -> Prefiltered {
    let Some(cache) = cache else { return Prefiltered::new(panorama, face_size, format) };
    let path = cache.path(panorama, face_size, format);
    let kept = fs::read(&path).ok().and_then(|bytes| Prefiltered::from_ktx2(&bytes).ok());
    let fits = |kept: &Prefiltered| kept.face_size == face_size && kept.format == format;
    kept.filter(fits).unwrap_or_else(|| {
        let made = Prefiltered::new(panorama, face_size, format);
        if let Err(e) = cache.keep(&path, &made) {
            log::warn!("the prefiltered environment is not kept: {e}");
        }
        made
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn panorama(brightness: f32) -> Panorama {
        let texels = (0..32 * 16).map(|i| Vec3::new(i as f32, 1.0, 2.0) * brightness).collect();
        Panorama::new(32, 16, texels).unwrap()
    }

    #[test]
    fn what_was_made_once_is_read_and_what_is_damaged_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path().join("new"));
        let format = TexelFormat::E5B9G9R9;
        let fresh = Prefiltered::new(&panorama(1.0), 16, format);
        assert_eq!(cached(&panorama(1.0), 16, format, Some(&cache)), fresh);

        let path = cache.path(&panorama(1.0), 16, format);
        let bytes = fs::read(&path).unwrap();
        // A file that is whole but says something else proves that files are read.
        let other = Prefiltered::new(&panorama(0.5), 16, format);
        other.write(&path).unwrap();
        assert_eq!(cached(&panorama(1.0), 16, format, Some(&cache)), other);

        for at in [0, 20, 300, bytes.len() / 2, bytes.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x08;
            for content in [damaged, bytes[..at].to_vec()] {
                fs::write(&path, content).unwrap();
                assert_eq!(cached(&panorama(1.0), 16, format, Some(&cache)), fresh, "byte {at}");
                assert_eq!(fs::read(&path).unwrap(), bytes, "byte {at}: not repaired");
            }
        }
    }

    #[test]
    fn every_input_has_a_file_of_its_own() {
        let cache = Cache::new("folder".into());
        let mut paths = vec![
            cache.path(&panorama(1.0), 16, TexelFormat::E5B9G9R9),
            cache.path(&panorama(1.5), 16, TexelFormat::E5B9G9R9),
            cache.path(&panorama(1.0), 32, TexelFormat::E5B9G9R9),
            cache.path(&panorama(1.0), 16, TexelFormat::Rgbm),
        ];
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), 4);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_failure() {
        let made = cached(&panorama(1.0), 16, TexelFormat::Rgbm, Some(&Cache::new("/dev/null/x".into())));
        assert_eq!(made, Prefiltered::new(&panorama(1.0), 16, TexelFormat::Rgbm));
    }
}
