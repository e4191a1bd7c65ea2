//! Recognition of the format of a scene file, and reading.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glanz_job::{BudgetError, CancelFlag, ResourceBudget, ResourceLimits};
use glanz_scene::studio::{StudioSettings, UpAxis};
use glanz_scene::{Description, Diagnostic, Diagnostics, Severity};

use crate::cad::CadReport;
use crate::content_kind::ContentKind;
use crate::file_list::SceneFileList;
use crate::finder::{read_file, spend_file};
use crate::source::{MISSING_FILE, Sources, end_of_reading};
use crate::{gltf, iges, model, obj, pbrt, rib, stl};

/// Settings of the readers.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Treats every substitute as an error. Up to 20 errors are collected.
    pub strict: bool,
    /// Folder for the files that the scene names; by default that of the scene file.
    pub folder: Option<PathBuf>,
    /// Refuses files outside of this folder, for scenes from untrusted users: names that are absolute or contain `..`,
    /// and links that lead outside. Messages then name files relative to the folder.
    ///
    /// These users must not be able to change the folder while it is read. Pictures are then always whole in memory.
    pub confined: bool,
    /// Camera, ground and light for models, which have none of their own.
    pub studio: StudioSettings,
    /// Whether the edges of CAD models are sampled, for [`EdgeDescription`](glanz_scene::description::EdgeDescription)s.
    pub edges: bool,
    /// Limits of what reading may use; each call has a budget of its own.
    pub limits: ResourceLimits,
    /// Flag that ends reading.
    pub cancel: CancelFlag,
}

impl Options {
    /// The budget of one call.
    fn budget(&self) -> ResourceBudget {
        ResourceBudget::new(self.limits.clone(), self.cancel.clone())
    }
}

/// A scene that was read.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene as plain data.
    pub description: Description,
    /// Warnings.
    pub diagnostics: Diagnostics,
    /// Hash of the bytes of all files, see [`glanz_job::ContentHash`].
    pub content_hash: u128,
    /// The sources, for later messages about positions in the files.
    pub sources: Sources,
    /// Of a model, which has no camera and light of its own, the settings for [`add_studio`](glanz_scene::studio::add_studio): those of the options, with the
    /// upward axis of the format if they have none. `None` for a scene.
    pub studio: Option<StudioSettings>,
    /// Of a CAD file, the outcome for each of its faces.
    pub cad: Option<CadReport>,
    /// What was used of the limits, for the steps after reading.
    pub budget: ResourceBudget,
}

/// A format, recognised by content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneFormat {
    /// pbrt's scene language.
    Pbrt,
    /// Surfaces alone.
    Model(ModelFormat),
}

/// A format of files of surfaces, without camera and light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModelFormat {
    /// Meshes: see [`crate::ply`].
    Ply,
    /// Patches in RenderMan's scene files: see [`crate::rib`].
    Rib,
    /// Lists of bicubic patches: see [`crate::newell`].
    Newell,
    /// CAD models: see [`crate::step`].
    Step,
    /// CAD models: see [`crate::iges`].
    Iges,
    /// Triangles: see [`crate::stl`].
    Stl,
    /// Polygons and freeform surfaces with materials: see [`crate::obj`].
    Obj,
    /// Scenes and models in glTF 2.0, with materials, and perhaps a camera and lights.
    Gltf,
}

impl ModelFormat {
    /// The format whose files have an extension, in lower case.
    fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "gltf" | "glb" => Self::Gltf,
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            "stl" => Self::Stl,
            "rib" => Self::Rib,
            "step" | "stp" | "p21" => Self::Step,
            "igs" | "iges" => Self::Iges,
            _ => return None,
        })
    }

    /// The upward axis of its models, by custom.
    pub(crate) fn up(self) -> UpAxis {
        match self {
            Self::Ply | Self::Obj | Self::Gltf => UpAxis::Y,
            Self::Rib | Self::Newell | Self::Step | Self::Iges | Self::Stl => UpAxis::Z,
        }
    }
}

/// Usual extensions of files of models, in lower case.
pub const MODEL_EXTENSIONS: [&str; 11] =
    ["gltf", "glb", "obj", "ply", "stl", "rib", "step", "stp", "p21", "igs", "iges"];

impl SceneFormat {
    /// Recognises a format by the content of a file.
    ///
    /// # Errors
    /// A description of the actual format.
    pub fn recognise(bytes: &[u8]) -> Result<Self, String> {
        Self::of_file(bytes, None)
    }

    /// The format of a file, by its content, else by its extension.
    fn of_file(bytes: &[u8], path: Option<&Path>) -> Result<Self, String> {
        let extension = path.and_then(Path::extension).and_then(|e| e.to_str()).unwrap_or_default();
        let content = Self::from_content(bytes).map_err(|kind| match kind {
            Some(kind @ ContentKind::Foreign(_)) => format!("{kind}, which is not read"),
            Some(kind) => format!("{kind}, not a scene"),
            None => "empty".to_owned(),
        });
        match (content?, extension.to_ascii_lowercase().as_str()) {
            (Some(format), _) => Ok(format),
            (None, "stl") => Ok(Self::Model(ModelFormat::Stl)),
            (None, "obj") => Ok(Self::Model(ModelFormat::Obj)),
            (None, _) if is_binary(bytes) => Err("not in a known scene format".to_owned()),
            (None, extension) => match ModelFormat::of_extension(extension) {
                Some(format) if !pbrt::begins(bytes) => {
                    Err(format!("neither {}, as its name says, nor a scene", format.described()))
                }
                _ => Ok(Self::Pbrt),
            },
        }
    }

    /// The format whose signature or statements a file has; `None`: it may be a scene, or a model without either.
    ///
    /// # Errors
    /// What it is instead of a scene; `None` if it is empty.
    pub(crate) fn from_content(bytes: &[u8]) -> Result<Option<Self>, Option<ContentKind>> {
        let model = |format| Ok(Some(Self::Model(format)));
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return model(ModelFormat::Ply);
        }
        if bytes.trim_ascii_start().starts_with(b"ISO-10303-21") {
            return model(ModelFormat::Step);
        }
        if iges::is_iges(bytes) {
            return model(ModelFormat::Iges);
        }
        if gltf::is_gltf(bytes) {
            return model(ModelFormat::Gltf);
        }
        if stl::is_stl(bytes) {
            return model(ModelFormat::Stl);
        }
        if bytes.iter().all(u8::is_ascii_whitespace) {
            return Err(None);
        }
        if is_binary(bytes) {
            return ContentKind::of_other(bytes).map_or(Ok(None), |kind| Err(Some(kind)));
        }
        // Files of RIB and other texts begin alike.
        if obj::is_obj(bytes) {
            return model(ModelFormat::Obj);
        }
        if rib::has_surface(bytes) {
            return model(ModelFormat::Rib);
        }
        match ContentKind::of_other(bytes) {
            // Lines of numbers in a scene or a list may look like those of a luminaire.
            Some(ContentKind::Luminaire(_)) if pbrt::begins(bytes) => {}
            Some(ContentKind::Luminaire("EULUMDAT")) if begins_with_count(bytes) => {}
            Some(kind) => return Err(Some(kind)),
            None => {}
        }
        if bytes.trim_ascii_start().first().is_some_and(u8::is_ascii_digit) {
            return model(ModelFormat::Newell);
        }
        Ok(None)
    }
}

/// Whether the first line is a whole number, as in lists of patches.
fn begins_with_count(bytes: &[u8]) -> bool {
    let line = bytes.trim_ascii_start().split(|&b| b == b'\n').next().unwrap_or_default().trim_ascii_end();
    !line.is_empty() && line.iter().all(u8::is_ascii_digit)
}

/// Whether the beginning of a file is no text.
fn is_binary(bytes: &[u8]) -> bool {
    bytes.get(..bytes.len().min(4096)).unwrap_or_default().contains(&0)
}

/// One error about a file as a whole.
pub(crate) fn failure(name: &str, kind: &'static str, message: String) -> Diagnostics {
    let mut diagnostics = Diagnostics::default();
    diagnostics.push(Diagnostic {
        severity: Severity::Error,
        kind,
        file: name.to_owned(),
        location: None,
        message,
        excerpt: None,
        help: None,
    });
    diagnostics
}

/// Reads the scene file at `path` and all files it refers to.
///
/// # Errors
/// Diagnostics with at least one error.
pub fn load(path: &Path, options: &Options) -> Result<Loaded, Diagnostics> {
    let budget = options.budget();
    let (name, bytes) = read(path, options, &budget)?;
    load_named(&name, Some(path), bytes, options, &budget)
}

/// Lists the files that the scene file at `path` needs, with those that are missing. Reads only files that may name others.
///
/// # Errors
/// Diagnostics, if the scene file itself cannot be read, or a limit ends reading before the list is complete.
pub fn list_files(path: &Path, options: &Options) -> Result<SceneFileList, Diagnostics> {
    let budget = options.budget();
    let (name, bytes) = read(path, options, &budget)?;
    let list = match SceneFormat::of_file(&bytes, Some(path)) {
        Ok(SceneFormat::Pbrt) => pbrt::list_files(&name, path, bytes, options, &budget),
        Ok(SceneFormat::Model(format)) => model::list_files(format, &name, path, &bytes, options, &budget),
        Err(what) => Err(failure(&name, "format", format!("the file is {what}"))),
    };
    match (list, budget.failure()) {
        (list, None) => list,
        (Ok(list), Some(_)) if list.diagnostics.end().is_some() => Err(list.diagnostics),
        (Err(diagnostics), Some(_)) if diagnostics.end().is_some() => Err(diagnostics),
        (_, Some(end)) => Err(ended(&name, end)),
    }
}

/// The scene file: its name in messages, and its bytes.
fn read(path: &Path, options: &Options, budget: &ResourceBudget) -> Result<(String, Arc<[u8]>), Diagnostics> {
    let folder = options.folder.as_deref().or_else(|| path.parent());
    let shown = folder.filter(|_| options.confined).and_then(|folder| path.strip_prefix(folder).ok());
    let name = shown.unwrap_or(path).display().to_string();
    let unreadable = |what: String| failure(&name, MISSING_FILE, what);
    let metadata =
        std::fs::metadata(path).map_err(|error| unreadable(format!("the file cannot be read: {error}")))?;
    if !metadata.is_file() {
        return Err(unreadable("this is not a regular file".to_owned()));
    }
    if options.confined && !lies_in(path, folder) {
        return Err(unreadable("the file is outside the folder of the scene".to_owned()));
    }
    let bytes = read_file(path, budget).map_err(|error| match budget.failure() {
        Some(end) => ended(&name, end),
        None => unreadable(format!("the file cannot be read: {error}")),
    })?;
    Ok((name, bytes.into()))
}

/// The message that reading of a file has ended.
fn ended(name: &str, end: BudgetError) -> Diagnostics {
    Diagnostics::of_end(end_of_reading(name.to_owned(), end), end)
}

/// Whether `path`, with links resolved, is in `folder`.
fn lies_in(path: &Path, folder: Option<&Path>) -> bool {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    match (real(path), folder.and_then(real)) {
        (Some(path), Some(folder)) => path.starts_with(folder),
        _ => false,
    }
}

/// Reads a scene from memory. `name`: its name in messages. Files to which it refers are found in [`Options::folder`] only.
///
/// # Errors
/// Diagnostics with at least one error.
pub fn load_str(name: &str, text: &str, options: &Options) -> Result<Loaded, Diagnostics> {
    load_shared(name, Arc::from(text.as_bytes()), options)
}

/// As [`load_str`], of the bytes of a scene file or a model, whose content shows its format.
///
/// # Errors
/// Diagnostics with at least one error.
pub fn load_bytes(name: &str, bytes: Vec<u8>, options: &Options) -> Result<Loaded, Diagnostics> {
    load_shared(name, bytes.into(), options)
}

fn load_shared(name: &str, bytes: Arc<[u8]>, options: &Options) -> Result<Loaded, Diagnostics> {
    let budget = options.budget();
    spend_file(&budget, bytes.len() as u64).map_err(|end| ended(name, end))?;
    load_named(name, None, bytes, options, &budget)
}

fn load_named(
    name: &str,
    path: Option<&Path>,
    bytes: Arc<[u8]>,
    options: &Options,
    budget: &ResourceBudget,
) -> Result<Loaded, Diagnostics> {
    let loaded = match SceneFormat::of_file(&bytes, path) {
        Ok(SceneFormat::Pbrt) => pbrt::load(name, path, bytes, options, budget),
        Ok(SceneFormat::Model(format)) => model::load(format, name, path, &bytes, options, budget),
        Err(what) => Err(failure(name, "format", format!("the file is {what}"))),
    };
    match (loaded, budget.failure()) {
        (loaded, None) => loaded,
        (Err(diagnostics), Some(_)) if diagnostics.end().is_some() => Err(diagnostics),
        (_, Some(end)) => Err(ended(name, end)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_format_of_files_that_are_not_scenes() {
        for (bytes, message) in [
            (&b""[..], "error: x: the file is empty\n"),
            (b" \n\t", "error: x: the file is empty\n"),
            (b"ISO-10303-21;\n", "error: x: the file has no section DATA; it may be incomplete\n"),
            (b"\x89PNG\r\n\x1a\n", "error: x: the file is a picture (PNG), not a scene\n"),
            (b"Shape\0", "error: x: the file is not in a known scene format\n"),
        ] {
            let error = load_bytes("x", bytes.to_vec(), &Options::default()).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }

    #[test]
    fn models_are_recognised_by_content() {
        let model = |format| Ok(SceneFormat::Model(format));
        let iges = format!("{:<72}S      1\n", "Patch");
        for (bytes, format) in [
            (&b"ply\r\nformat"[..], model(ModelFormat::Ply)),
            (iges.as_bytes(), model(ModelFormat::Iges)),
            (b"glTF\x02\0\0\0", model(ModelFormat::Gltf)),
            (b"\n{ \"asset\"", model(ModelFormat::Gltf)),
            (b"# made by\n\nv 0 0 0\n", model(ModelFormat::Obj)),
            (b"solid x\n facet normal", model(ModelFormat::Stl)),
            (b"32\n1,2,3", model(ModelFormat::Newell)),
            (b"5\n1\n1\n1\n0\n19\n5\n", model(ModelFormat::Newell)),
            (b"LookAt\n1\n2\n3\n0\n1\n0\n0\n0\n1\n", Ok(SceneFormat::Pbrt)),
            (b"AttributeBegin\nPatch \"bicubic\" \"P\" [", model(ModelFormat::Rib)),
            (b"##RenderMan RIB\n# Shape\nTranslate 0 0 5 NuPatch 4", model(ModelFormat::Rib)),
            (b"Translate 0 0 5\nShape \"nurbs\" # Patch\n", Ok(SceneFormat::Pbrt)),
            (b"Include \"Patch\" Texture \"NuPatch # \"", Ok(SceneFormat::Pbrt)),
            (b"# Patch \"bilinear\"\nWorldBegin", Ok(SceneFormat::Pbrt)),
            (b"Patches", Ok(SceneFormat::Pbrt)),
        ] {
            assert_eq!(SceneFormat::recognise(bytes), format, "{}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn the_extension_decides_where_the_content_does_not() {
        let of = |bytes: &[u8], name: &str| SceneFormat::of_file(bytes, Some(Path::new(name))).ok();
        let model = |format| Some(SceneFormat::Model(format));
        // A binary file of one facet, with bytes after it.
        let mut facets = vec![0; 84 + 50 + 1];
        facets[80] = 1;
        assert_eq!(of(&facets, "a.STL"), model(ModelFormat::Stl));
        assert_eq!(of(&facets, "a.pbrt"), None);
        assert_eq!(of(b"# nothing\n", "a.obj"), model(ModelFormat::Obj));
        assert_eq!(of(b"v 1 2 3\n", "a.stl"), model(ModelFormat::Obj), "the content is clear");
        assert_eq!(of(b"# nothing\n", "a.pbrt"), Some(SceneFormat::Pbrt));
    }

    #[test]
    fn a_missing_scene_is_reported_by_name() {
        let error = load(Path::new("no/such/scene.pbrt"), &Options::default()).unwrap_err();
        assert!(error.to_string().starts_with("error: no/such/scene.pbrt: the file cannot be read: "));
        let error = load(Path::new("/"), &Options::default()).unwrap_err();
        assert_eq!(error.to_string(), "error: /: this is not a regular file\n");
    }

    #[test]
    fn content_hash_depends_on_the_bytes_and_not_on_the_name() {
        let of = |name, text| load_str(name, text, &Options::default()).unwrap().content_hash;
        assert_eq!(of("a", "WorldBegin"), of("b", "WorldBegin"));
        assert_ne!(of("a", "WorldBegin"), of("a", "WorldBegin "));
    }
}
