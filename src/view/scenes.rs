//! The scenes that can be opened from within the window.

use std::path::{Path, PathBuf};

use egui::Ui;

use super::app::App;
use crate::{Error, Result};

/// What there is to open, as it was when it was looked at.
#[derive(Debug, Default)]
pub(super) struct Scenes {
    files: Vec<PathBuf>,
    /// The scene that was open then.
    beside: Option<PathBuf>,
}

/// What the panel asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SceneWish {
    /// Looks again.
    Look,
    /// Opens the n-th.
    Open(usize),
}

/// Whether a file's name is that of a scene.
pub(super) fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"))
}

/// The scene files of a folder, by name; none of one that cannot be read.
pub(super) fn of_folder(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> =
        entries.map(|e| e.path()).filter(|path| is_scene(path) && path.is_file()).collect();
    files.sort();
    files
}

/// The scene files beside a scene.
pub(super) fn beside(scene: &Path) -> Vec<PathBuf> {
    match scene.parent() {
        Some(folder) if folder.as_os_str().is_empty() => {
            let strip = |path: PathBuf| path.strip_prefix(".").map(Path::to_owned).unwrap_or(path);
            of_folder(Path::new(".")).into_iter().map(strip).collect()
        }
        Some(folder) => of_folder(folder),
        None => Vec::new(),
    }
}

impl Scenes {
    /// A file a line.
    pub(super) fn to_text(&self) -> String {
        self.files.iter().map(|file| format!("{}\n", file.display())).collect()
    }

    /// Its part of the interface; `open` is the scene that is shown.
    pub(super) fn panel(&self, ui: &mut Ui, open: &Path) -> Option<SceneWish> {
        let mut wish = None;
        for (index, file) in self.files.iter().enumerate() {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let label = ui.selectable_label(file == open, name);
            if label.on_hover_text(file.to_string_lossy()).clicked() {
                wish = Some(SceneWish::Open(index));
            }
        }
        if ui.button("look again").clicked() {
            wish = Some(SceneWish::Look);
        }
        wish
    }
}

impl App {
    /// Looks at what there is to open, if another scene was opened since.
    pub(super) fn look_for_scenes(&mut self, anyway: bool) {
        let open = &self.viewer.scene;
        if anyway || self.scenes.beside.as_ref() != Some(open) {
            self.scenes = Scenes { files: (self.viewer.list)(open), beside: Some(open.clone()) };
        }
    }

    /// Does what the panel asks for.
    pub(super) fn set_scene(&mut self, wish: SceneWish) -> Result<()> {
        let SceneWish::Open(index) = wish else {
            self.look_for_scenes(true);
            return Ok(());
        };
        let Some(path) = self.scenes.files.get(index).cloned() else {
            let problem = format!("there is no scene {index} to open");
            let remedy =
                format!("name one below {}, the number of those that are listed", self.scenes.files.len());
            return Err(Error::unsupported(problem, remedy));
        };
        self.load(&path);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scene_files_of_the_folder_are_listed_by_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.glb", "a.gltf", "A.GLB", "notes.txt", "a.bin", ".hidden"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        std::fs::create_dir(folder.path().join("folder.glb")).unwrap();
        let found = beside(&folder.path().join("b.glb"));
        assert_eq!(found, ["A.GLB", "a.gltf", "b.glb"].map(|name| folder.path().join(name)));
        assert!(beside(&folder.path().join("none/b.glb")).is_empty());
        // The tests run in the package's folder.
        assert_eq!(beside(Path::new("Cargo.toml")), of_folder(Path::new(".")));
        assert!(beside(Path::new("/")).is_empty());
    }
}
