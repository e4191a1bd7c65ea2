//! Inverse design: scenes whose free numbers are moved until their light is as wanted.

mod state_file;

use std::path::Path;

use glanz_illumination::optimize::{
    OptimizeError, OptimizeOutcome, OptimizeSettings, OptimizeState, optimize,
};

use crate::error::Error;
use crate::event::{JobEvent, ResumedState};
use crate::file;
use crate::job_options::{JobOptions, job_methods};
use crate::loaded_scene::LoadedScene;
use crate::running_job::JobSink;
use state_file::{StateFile, StateIdentity};

/// Builder of an inverse design.
#[must_use = "nothing is moved before `run`"]
pub struct OptimizeBuilder<'a> {
    scene: LoadedScene,
    settings: OptimizeSettings,
    job: JobOptions<'a>,
}

/// A scene after its inverse design.
#[derive(Clone, Debug)]
pub struct OptimizedScene {
    scene: LoadedScene,
    outcome: OptimizeOutcome,
}

impl<'a> OptimizeBuilder<'a> {
    pub(crate) fn new(scene: LoadedScene) -> Self {
        Self { scene, settings: OptimizeSettings::default(), job: JobOptions::default() }
    }

    /// Replaces the settings.
    pub fn settings(mut self, settings: OptimizeSettings) -> Self {
        self.settings = settings;
        self
    }

    /// Replaces the options that every job takes.
    pub fn job(mut self, options: JobOptions<'a>) -> Self {
        self.job = options;
        self
    }

    job_methods!('a, job);

    /// Moves the free numbers. A cancelled job returns the best ones so far.
    ///
    /// # Errors
    /// [`Error::Scene`] for a description that is not a scene, [`Error::Optimize`] for one without a design or with parts that are not supported, or if a displaced scene reaches a limit,
    /// [`Error::Film`] for pictures in a temporary file that cannot be read, [`Error::File`] for a checkpoint that cannot be read or written.
    pub fn run(self) -> Result<OptimizedScene, Error> {
        let Self { scene, settings, job } = self;
        scene.check_scene("optimize")?;
        let mut job = job.start();
        job.claim_checkpoint()?;
        let warnings = scene.clone().resolve_for(&job.options.cancel)?.1;
        warnings.into_iter().for_each(|warning| job.warn(warning));
        let identity = StateIdentity::new(&scene, &settings);
        let state = match job.resumed() {
            Some(path) => {
                let state = StateFile::from_bytes(&path, &file::read(&path)?, &identity)?;
                let steps = ResumedState::Steps { done: state.iterations, wanted: settings.iterations };
                job.emit(JobEvent::Resumed { path: &path, state: &steps });
                Some(state)
            }
            None => None,
        };
        let description = scene.description();
        let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
        let write = |path: &Path, state: &OptimizeState| StateFile::write(path, &identity, state);
        let outcome = job.in_pool(|job| {
            let mut sink = JobSink::new(job, path.clone(), write);
            let searched = optimize(description, &settings, state, &mut sink, &cancel, scene.budget());
            searched.map_err(|error| optimize_error(&scene, error))
        })?;
        if let Some(path) = &path {
            StateFile::write(path, &identity, &outcome.state)?;
        }
        Ok(OptimizedScene { scene, outcome })
    }
}

fn optimize_error(scene: &LoadedScene, error: OptimizeError) -> Error {
    match error {
        OptimizeError::Textures(error) => error.into(),
        OptimizeError::NoLight => Error::NoLight { scene: scene.name().to_owned() },
        error => Error::Optimize { scene: scene.name().to_owned(), error: Box::new(error) },
    }
}

impl OptimizedScene {
    /// What was found.
    #[must_use]
    pub fn outcome(&self) -> &OptimizeOutcome {
        &self.outcome
    }

    /// The scene with the displacements found, for further jobs.
    #[must_use]
    pub fn displaced(&self) -> LoadedScene {
        let mut scene = self.scene.clone();
        let displaced = scene.description().displaced(&self.outcome.displacements);
        *scene.description_mut() = displaced;
        scene
    }

    /// Whether the scene file has changed since it was read; [`OptimizedScene::save`] writes it as it was.
    #[cfg(feature = "formats")]
    #[must_use]
    pub fn scene_has_changed(&self) -> bool {
        self.scene.sources().scene_has_changed()
    }

    /// Writes the scene file, as it was when it was read, with the numbers found in place of the free ones.
    ///
    /// # Errors
    /// [`Error::File`].
    #[cfg(feature = "formats")]
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let variables = &self.scene.description().design.variables;
        let bytes =
            glanz_formats::pbrt::rewrite(self.scene.sources(), variables, &self.outcome.displacements);
        file::write(path, &bytes.map_err(Error::of_file(path))?)
    }
}
