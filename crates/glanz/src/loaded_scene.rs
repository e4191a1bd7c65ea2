//! A scene that was read or described, ready for its jobs.

use std::fmt::{self, Write};

#[cfg(feature = "formats")]
use glanz_formats::cad::CadReport;
use glanz_job::{
    BudgetError, CancelFlag, ContentHash, Interrupted, Resource, ResourceBudget, ResourceLimits,
};
use glanz_scene::studio::{StudioSettings, add_studio};
use glanz_scene::{
    Description, Diagnostic, Diagnostics, Location, Scene, SceneError, SceneErrorKind, SceneWarning, Severity,
};

use crate::error::Error;
use crate::event::Warning;
use crate::render::RenderBuilder;

/// Kind of the diagnostics that arise after reading.
const KIND: &str = "scene";

/// A scene from a file, a text or code, with the diagnostics of reading it.
///
/// A job consumes the scene, so that a large one is not stored twice; clone it for several jobs.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    name: String,
    pub(crate) description: Description,
    /// Hash of the bytes of all files; `None` for a description built in code.
    content_hash: Option<u128>,
    #[cfg(feature = "formats")]
    sources: glanz_formats::Sources,
    diagnostics: Diagnostics,
    strict: bool,
    /// Of a model to which no studio has been added yet.
    studio: Option<StudioSettings>,
    #[cfg(feature = "formats")]
    cad: Option<CadReport>,
    /// What reading has used; preparing the scene goes on from there.
    budget: ResourceBudget,
    /// Memory that the job needs beside the scene, bytes.
    reserved: u64,
}

impl LoadedScene {
    /// A scene described in code. `name`: its name in messages and reports.
    #[must_use]
    pub fn from_description(name: impl Into<String>, description: Description) -> Self {
        Self {
            name: name.into(),
            description,
            content_hash: None,
            #[cfg(feature = "formats")]
            sources: glanz_formats::Sources::default(),
            diagnostics: Diagnostics::default(),
            strict: false,
            studio: None,
            #[cfg(feature = "formats")]
            cad: None,
            budget: ResourceBudget::default(),
            reserved: 0,
        }
    }

    #[cfg(feature = "formats")]
    pub(crate) fn from_loaded(name: String, loaded: glanz_formats::Loaded, strict: bool) -> Self {
        let glanz_formats::Loaded { description, diagnostics, content_hash, sources, studio, cad, budget } =
            loaded;
        Self {
            name,
            description,
            content_hash: Some(content_hash),
            sources,
            diagnostics,
            strict,
            studio,
            cad,
            budget,
            reserved: 0,
        }
    }

    /// Whether a part of the scene that has to be repaired or left out is an error, also when the scene is resolved.
    #[must_use]
    pub fn strict(mut self, strict: bool) -> Self {
        self.strict = strict;
        self
    }

    /// The paths of all files on disk that were read.
    #[cfg(feature = "formats")]
    #[must_use]
    pub fn paths(&self) -> &[std::path::PathBuf] {
        self.sources.paths()
    }

    /// The name of the file, or the given name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The scene as plain data.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The scene as plain data, for changes; after a change, checkpoints and baked light of the file no longer match.
    pub fn description_mut(&mut self) -> &mut Description {
        self.content_hash = None;
        &mut self.description
    }

    /// Makes the description a model, which has no camera and light of its own: a render adds a studio with these settings.
    #[must_use]
    pub fn studio(mut self, settings: StudioSettings) -> Self {
        self.studio = Some(settings);
        self
    }

    /// Settings of the studio of a model, to which a render adds camera, ground and light; `None` for a scene.
    #[must_use]
    pub fn studio_settings(&self) -> Option<&StudioSettings> {
        self.studio.as_ref()
    }

    /// Adds the studio to a model, fitted to the present size of its film.
    pub(crate) fn furnish(&mut self) {
        let Some(settings) = self.studio.take() else { return };
        add_studio(&mut self.description, &settings);
        self.content_hash = self.content_hash.map(|hash| {
            let mut both = ContentHash::default();
            both.add_file(&hash.to_le_bytes());
            both.add_file(format!("{settings:?}").as_bytes());
            both.value()
        });
    }

    /// Refuses a model: `job` needs the lights of a scene.
    pub(crate) fn check_scene(&self, job: &'static str) -> Result<(), Error> {
        match self.studio {
            Some(_) => Err(Error::NoScene { name: self.name.clone(), job }),
            None => Ok(()),
        }
    }

    /// Limits of what preparing the scene for a job may use, those of reading if this is not called, and the flag that ends [`LoadedScene::resolve`]; a job ends by its
    /// own flag. The memory that reading has used counts.
    #[must_use]
    pub fn limits(mut self, limits: ResourceLimits, cancel: CancelFlag) -> Self {
        self.budget = self.budget.for_next_step_within(limits, cancel);
        self
    }

    /// Warnings from reading.
    #[must_use]
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// Of a CAD file, the outcome for each of its faces.
    #[cfg(feature = "formats")]
    #[must_use]
    pub fn cad(&self) -> Option<&CadReport> {
        self.cad.as_ref()
    }

    /// Content hash of the scene: of the bytes of its files, or of its description.
    #[must_use]
    pub fn content_hash(&self) -> u128 {
        self.content_hash.unwrap_or_else(|| {
            let mut text = HashedText::default();
            // Hashing cannot fail.
            let _ = write!(text, "{:?}", self.description);
            text.0.value()
        })
    }

    /// Memory that reading the scene has left of its limit, bytes.
    pub(crate) fn memory_left(&self) -> u64 {
        self.budget.limits().memory.saturating_sub(self.budget.used(Resource::Memory))
    }

    /// Leaves `bytes` of the memory for the job when the scene is resolved.
    pub(crate) fn reserve(&mut self, bytes: u64) {
        self.reserved = bytes;
    }

    /// Resolves the scene for ray queries; returns it with its warnings. Of a model, these are its surfaces alone.
    ///
    /// # Errors
    /// [`Error::Scene`] if the description is not a scene, a limit was reached ([`Diagnostics::limit`]), or a warning arose from a [strict](LoadedScene::strict) one.
    pub fn resolve(self) -> Result<(Scene, Vec<Warning>), Error> {
        let cancel = self.budget.cancel().clone();
        self.resolve_for(&cancel)
    }

    /// What reading has used, with the limits of later steps.
    pub(crate) fn budget(&self) -> &ResourceBudget {
        &self.budget
    }

    /// As [`LoadedScene::resolve`], for a job with this flag.
    pub(crate) fn resolve_for(mut self, cancel: &CancelFlag) -> Result<(Scene, Vec<Warning>), Error> {
        let description = std::mem::take(&mut self.description);
        let budget = self.budget.for_next_step().with_cancel(cancel.clone());
        let reserved = budget.spend(Resource::Memory, self.reserved);
        let reserved =
            reserved.map_err(|error| SceneError { location: None, kind: SceneErrorKind::Budget(error) });
        let resolved = reserved.and_then(|()| Scene::resolve_with(description, &budget));
        let (scene, warnings) = resolved.map_err(|SceneError { location, kind }| match kind {
            SceneErrorKind::Budget(BudgetError::Interrupted) => Interrupted.into(),
            SceneErrorKind::Budget(end) => Error::Scene(self.ended(location, end)),
            kind => self.fault(location, kind.to_string()),
        })?;
        let severity = if self.strict { Severity::Error } else { Severity::Warning };
        let mut diagnostics = Diagnostics::default();
        for SceneWarning { location, message } in warnings {
            if diagnostics.admit(severity, KIND) {
                diagnostics.push_admitted(self.diagnostic(severity, location, message));
            }
        }
        if diagnostics.has_errors() {
            return Err(Error::Scene(diagnostics));
        }
        let omitted = diagnostics.omitted().map(|(_, _, count)| Warning::SceneOmitted { count });
        Ok((scene, diagnostics.iter().cloned().map(Warning::Scene).chain(omitted).collect()))
    }

    /// The scene without shapes and lights.
    #[cfg(feature = "formats")]
    pub(crate) fn without_shapes(&self) -> Self {
        let Description { camera, film, images, textures, materials, .. } = &self.description;
        let description = Description {
            camera: camera.clone(),
            film: film.clone(),
            images: images.clone(),
            textures: textures.clone(),
            materials: materials.clone(),
            ..Description::default()
        };
        let bare = Self::from_description(self.name.clone(), description).strict(self.strict);
        Self { sources: self.sources.clone(), budget: self.budget.clone(), ..bare }
    }

    /// Builder of a render of the scene.
    pub fn render<'a>(self) -> RenderBuilder<'a> {
        RenderBuilder::new(self)
    }

    /// Builder of a bake of the scene.
    #[cfg(feature = "radiosity")]
    pub fn bake<'a>(self) -> crate::bake::BakeBuilder<'a> {
        crate::bake::BakeBuilder::new(self)
    }

    /// Builder of a calculation of illuminance on the receivers of the scene.
    #[cfg(feature = "illumination")]
    pub fn illuminate<'a>(self) -> crate::illuminate::IlluminateBuilder<'a> {
        crate::illuminate::IlluminateBuilder::new(self)
    }

    /// Builder of an inverse design: its free numbers are moved until its light is as wanted.
    #[cfg(feature = "illumination")]
    pub fn optimize<'a>(self) -> crate::optimize::OptimizeBuilder<'a> {
        crate::optimize::OptimizeBuilder::new(self)
    }

    /// The files that were read.
    #[cfg(all(feature = "formats", feature = "illumination"))]
    pub(crate) fn sources(&self) -> &glanz_formats::Sources {
        &self.sources
    }

    /// An error at a place of the scene.
    pub(crate) fn fault(&self, location: Option<Location>, message: String) -> Error {
        let mut diagnostics = Diagnostics::default();
        diagnostics.push(self.diagnostic(Severity::Error, location, message));
        Error::Scene(diagnostics)
    }

    #[cfg(feature = "formats")]
    fn diagnostic(&self, severity: Severity, location: Option<Location>, message: String) -> Diagnostic {
        self.sources.diagnostic(severity, KIND, location, message)
    }

    #[cfg(not(feature = "formats"))]
    fn diagnostic(&self, severity: Severity, location: Option<Location>, message: String) -> Diagnostic {
        let file = String::new();
        Diagnostic { severity, kind: KIND, file, location, message, excerpt: None, help: None }
    }

    /// The message that resolving the scene has ended.
    #[cfg(feature = "formats")]
    fn ended(&self, location: Option<Location>, end: BudgetError) -> Diagnostics {
        self.sources.end_of_resolving(location, end)
    }

    #[cfg(not(feature = "formats"))]
    fn ended(&self, location: Option<Location>, end: BudgetError) -> Diagnostics {
        let plain = self.diagnostic(Severity::Error, location, end.to_string());
        Diagnostics::of_end(Diagnostic { kind: end.kind(), help: end.help(), ..plain }, end)
    }
}

/// A text of which only the hash is stored.
#[derive(Default)]
struct HashedText(ContentHash);

impl Write for HashedText {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.add(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use glanz_job::LimitError;

    use super::*;

    #[test]
    fn new_limits_count_the_memory_that_reading_has_used() {
        let scene = LoadedScene::from_description("empty", Description::default());
        scene.budget.spend(Resource::Memory, 600).unwrap();
        let limits = ResourceLimits { memory: 1000, ..ResourceLimits::default() };
        assert_eq!(scene.limits(limits, CancelFlag::default()).memory_left(), 400);
    }

    #[test]
    fn ends_have_their_kinds_with_readers_and_without() {
        let scene = LoadedScene::from_description("empty", Description::default());
        let limit = LimitError { resource: Resource::Objects, limit: 1, needed: None };
        for (end, kind) in [
            (BudgetError::Limit(limit), "limit"),
            (BudgetError::Interrupted, "interrupted"),
            (BudgetError::TemporaryFile { kind: ErrorKind::StorageFull, code: None }, "temporary-file"),
        ] {
            let ended = scene.ended(None, end);
            assert_eq!(ended.end(), Some(end));
            assert_eq!(ended.iter().map(|diagnostic| diagnostic.kind).collect::<Vec<_>>(), [kind]);
        }
    }
}
