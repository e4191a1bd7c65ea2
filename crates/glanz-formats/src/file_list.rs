//! The files that a scene needs, without the scene.

use std::path::PathBuf;

use glanz_scene::Diagnostics;

/// The files that a scene needs.
#[derive(Clone, Debug)]
pub struct SceneFileList {
    /// By path; the scene file is one of them.
    pub files: Vec<SceneFile>,
    /// Messages of reading the files that name others. With an error the list may be incomplete; missing files are no errors here.
    pub diagnostics: Diagnostics,
}

/// A file that a scene needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// The path by which it is read; of a missing file, that in the folder of the scene.
    pub path: PathBuf,
    /// What it holds.
    pub kind: FileKind,
    /// Whether it is there and, if it names others, can be read.
    pub exists: bool,
}

/// What a file of a scene holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileKind {
    /// The scene or model itself, or an included scene.
    Scene,
    /// A model with files of its own, in glTF.
    Model,
    /// A CAD model.
    Cad,
    /// Triangles, or lists of patches.
    Mesh,
    /// Vertices and indices of a model.
    Buffer,
    /// Materials of a model.
    Materials,
    /// A picture.
    Picture,
    /// The light of a luminaire: candela distribution or rays.
    Luminaire,
    /// Values by wavelength.
    Spectrum,
    /// The lenses of a camera.
    Lens,
}

impl FileKind {
    /// Its name, in one word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Model => "model",
            Self::Cad => "cad",
            Self::Mesh => "mesh",
            Self::Buffer => "buffer",
            Self::Materials => "materials",
            Self::Picture => "picture",
            Self::Luminaire => "luminaire",
            Self::Spectrum => "spectrum",
            Self::Lens => "lens",
        }
    }

    /// Whether such a file names others, or is needed to find them.
    pub(crate) fn names_files(self) -> bool {
        matches!(self, Self::Scene | Self::Model | Self::Buffer | Self::Materials | Self::Luminaire)
    }
}
