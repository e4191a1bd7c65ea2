//! What the readers of models share: the description, messages, other files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glanz_job::{Resource, ResourceBudget};
use glanz_scene::description::{FileId, GeometryDescription, MaterialDescription, ShapeDescription};
use glanz_scene::studio::{CAD_GREY, StudioSettings, UpAxis, cad_material};
use glanz_scene::{Description, Diagnostic, Diagnostics, Location, Severity};
use glanz_shading::texture::MipMap;

use super::picture::{PictureContent, read_picture};
use crate::cad::CadReport;
use crate::file_list::FileKind;
use crate::finder::{FileFinder, FindError, entry_bytes};
use crate::registry::{Loaded, Options};
use crate::source::{Sources, end_of_reading};

/// State of a reader of a model. Material 0 of its description is grey.
pub(crate) struct ModelReader {
    pub(crate) description: Description,
    pub(crate) diagnostics: Diagnostics,
    pub(crate) sources: Sources,
    pub(crate) file: FileId,
    pub(crate) finder: FileFinder,
    /// The file, if it is one that a scene names.
    asking: Option<PathBuf>,
    pub(crate) cad: Option<CadReport>,
    /// Whether a substitute is an error.
    strict: bool,
    /// Whether the model has a camera.
    pub(crate) own_camera: bool,
    /// Whether the model has light.
    pub(crate) own_light: bool,
}

impl ModelReader {
    /// A reader of the file with these bytes.
    ///
    /// # Errors
    /// A message, if the folder to which it is confined does not exist.
    pub(crate) fn new(
        name: &str,
        path: Option<&Path>,
        bytes: &Arc<[u8]>,
        options: &Options,
        budget: &ResourceBudget,
    ) -> Result<Self, Diagnostics> {
        let finder = FileFinder::of_scene(name, path, bytes, options, budget)?;
        let mut sources = Sources::default();
        let file = sources.open(name, path, bytes);
        let grey = MaterialDescription::from(cad_material(CAD_GREY, 0.0));
        let description =
            Description { files: vec![name.to_owned()], materials: vec![grey], ..Description::default() };
        Ok(Self { sources, file, strict: options.strict, ..Self::within(description, finder, None) })
    }

    /// A reader of a file at a path that a scene names. It adds to what there is.
    pub(crate) fn within(description: Description, finder: FileFinder, path: Option<&Path>) -> Self {
        Self {
            description,
            diagnostics: Diagnostics::default(),
            sources: Sources::default(),
            file: FileId(0),
            finder,
            asking: path.map(Path::to_owned),
            cad: None,
            strict: false,
            own_camera: false,
            own_light: false,
        }
    }

    /// The model, which gets from a studio what it lacks.
    ///
    /// # Errors
    /// The messages, if one of them is an error.
    pub(crate) fn finish(mut self, up: UpAxis, options: &Options) -> Result<Loaded, Diagnostics> {
        if self.diagnostics.has_errors() {
            return Err(self.diagnostics);
        }
        self.sources.close(self.file);
        self.sources.set_paths(self.finder.paths());
        let given = &options.studio;
        let [own_camera, own_light] = [self.own_camera, self.own_light];
        let studio = StudioSettings { up: given.up.or(Some(up)), own_camera, own_light, ..given.clone() };
        Ok(Loaded {
            description: self.description,
            diagnostics: self.diagnostics,
            content_hash: self.finder.hash.value(),
            sources: self.sources,
            studio: (!studio.is_superfluous()).then_some(studio),
            cad: self.cad,
            budget: self.finder.budget,
        })
    }

    pub(crate) fn add(&mut self, geometry: GeometryDescription) {
        self.description.world.shapes.push(ShapeDescription::from(geometry));
    }

    /// Takes an entry of a list of the description off the budget. A failure stays in the budget, and ends reading.
    pub(crate) fn spend_entry<T>(&self, name: &str) {
        let _ = self.finder.budget.spend(Resource::Memory, entry_bytes::<T>(name));
    }

    /// `place`: line and column from 1, if the message is about a place in a text.
    pub(crate) fn report(
        &mut self,
        severity: Severity,
        kind: &'static str,
        place: Option<(u32, u32)>,
        message: String,
    ) {
        let location = place.map(|(line, column)| Location { file: self.file, line, column });
        // Whatever a reader makes of a budget that is used up, that is the reason.
        if let Some(end) = self.finder.budget.failure() {
            if self.diagnostics.end().is_none() {
                let plain = self.sources.diagnostic(Severity::Error, kind, location, String::new());
                let Diagnostic { kind, message, help, file, .. } = end_of_reading(plain.file.clone(), end);
                self.diagnostics =
                    Diagnostics::of_end(Diagnostic { kind, message, help, file, ..plain }, end);
            }
            return;
        }
        if self.diagnostics.admit(severity, kind) {
            self.diagnostics.push_admitted(self.sources.diagnostic(severity, kind, location, message));
        }
    }

    pub(crate) fn error(&mut self, kind: &'static str, place: Option<(u32, u32)>, message: String) {
        self.report(Severity::Error, kind, place, message);
    }

    /// Reports that something was replaced by a substitute or left out; an error in strict mode.
    pub(crate) fn stand_in(&mut self, kind: &'static str, place: Option<(u32, u32)>, message: String) {
        let severity = if self.strict { Severity::Error } else { Severity::Warning };
        self.report(severity, kind, place, message);
    }

    fn path(&self, name: &str) -> Result<PathBuf, (String, bool)> {
        self.finder.locate(name, self.asking.as_deref()).map_err(|fault| problem(name, fault))
    }

    /// Adds a file to those that the model needs, whether it is there or not.
    pub(crate) fn name_file(&mut self, name: &str, kind: FileKind) {
        // If it is missing, the list has it as such.
        let _ = self.finder.find(name, self.asking.as_deref(), kind);
    }

    /// The path of a file to which the model refers with links resolved: the same for all of its names.
    ///
    /// # Errors
    /// The problem as a sentence, and whether the model is not allowed to read the file.
    pub(crate) fn real_path(&self, name: &str) -> Result<PathBuf, (String, bool)> {
        self.path(name).map(|path| std::fs::canonicalize(&path).unwrap_or(path))
    }

    /// The bytes of a file to which the model refers.
    ///
    /// # Errors
    /// As of [`ModelReader::real_path`].
    pub(crate) fn read_file(&mut self, name: &str, kind: FileKind) -> Result<Vec<u8>, (String, bool)> {
        let found = self.finder.find(name, self.asking.as_deref(), kind);
        let path = found.map_err(|fault| problem(name, fault))?;
        let bytes = self.finder.read(&path, kind);
        let bytes = bytes.map_err(|error| (format!("file {name:?} cannot be read: {error}"), false))?;
        Ok(bytes)
    }

    /// The content of a picture for a texture.
    ///
    /// # Errors
    /// The problem.
    pub(crate) fn picture(&mut self, bytes: &[u8], content: PictureContent) -> Result<MipMap, String> {
        let (pixels, _memory) = read_picture(bytes, content, &self.finder.budget)?;
        self.finder.picture(&pixels)
    }
}

/// The problem of a file as a sentence, and whether the model is not allowed to read it.
fn problem(name: &str, fault: FindError) -> (String, bool) {
    (format!("file {name:?} {}; {}", fault.what(), fault.help()), fault == FindError::Outside)
}
