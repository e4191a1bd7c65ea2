//! A room with its scene, and the renders in it.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use glanz_sampling::SamplerKind;
use glanz_scene::Scene;
use glanz_scene::description::{FilterDescription, IntegratorDescription, LightKind};
use glanz_transport::{
    Film, FilmFormat, FilmSensor, Filter, Guide, Integrator, IntegratorSettings, PictureIdentity,
    RenderOutcome, RenderSettings, RenderSink, render,
};

use super::method::RenderMethod;
use crate::clock::{Stopwatch, TimeScope};
use crate::rooms::{self, RoomFile};
use crate::study::{Settings, StudyError};

/// A room to render.
pub(super) struct GuidingRoom<'a> {
    /// The file's name without folder and extension.
    pub(super) name: String,
    pub(super) size: [u32; 2],
    pub(super) threads: usize,
    settings: &'a Settings,
    scene: Scene,
    integrator: IntegratorDescription,
    filter: FilterDescription,
    hash: u128,
}

/// Setup of a render: integrator, seed and guide.
#[derive(Clone, Debug)]
pub(super) struct RenderSetup {
    pub(super) integrator: IntegratorSettings,
    pub(super) seed: u64,
    /// A frozen guide.
    pub(super) guide: Option<Arc<Guide>>,
}

/// A film after further samples, with their processor time.
pub(super) struct RenderProgress {
    pub(super) outcome: RenderOutcome,
    /// Time of all processors.
    pub(super) processors: Duration,
}

impl<'a> GuidingRoom<'a> {
    /// Reads the room `named`: a scene file, or the name of one in `scenes/rooms`.
    ///
    /// # Errors
    /// A file that cannot be read as a scene, or has lights that paths cannot find by chance.
    pub(super) fn read(
        named: &str,
        size: [u32; 2],
        threads: usize,
        settings: &'a Settings,
    ) -> Result<Self, StudyError> {
        let RoomFile { path, name, loaded } = rooms::read(named)?;
        let mut description = loaded.description;
        if description.lights.iter().any(|light| !matches!(light.kind, LightKind::Infinite)) {
            return Err(StudyError::Setting {
                name: "rooms",
                value: path.display().to_string(),
                needed: "lit by surfaces alone, because without light sampling no path finds point and distant lights",
            });
        }
        description.film.resolution = size;
        let (integrator, filter) = (description.integrator.clone(), description.filter);
        let (scene, _) = Scene::resolve(description)?;
        let hash = loaded.content_hash;
        Ok(Self { name, size, threads, settings, scene, integrator, filter, hash })
    }

    /// Name and size, for files; the content hash distinguishes rooms of the same name.
    pub(super) fn label(&self) -> String {
        let [width, height] = self.size;
        format!("{}-{width}x{height}-{:08x}", self.name, self.hash >> 96)
    }

    /// The setup of `method` with or without light sampling.
    ///
    /// # Errors
    /// [`StudyError::Integrator`].
    pub(super) fn setup(
        &self,
        method: &RenderMethod,
        lights: bool,
        seed: u64,
    ) -> Result<RenderSetup, StudyError> {
        let integrator = IntegratorSettings::resolve(&method.described(&self.integrator, lights))?;
        Ok(RenderSetup { integrator, seed, guide: None })
    }

    /// The identity of a picture with this setup.
    ///
    /// # Errors
    /// [`StudyError::Filter`].
    pub(super) fn identity(&self, setup: &RenderSetup) -> Result<PictureIdentity, StudyError> {
        let signed = Filter::try_new(&self.filter)?.is_signed();
        let passes = setup.integrator.is_guided() && setup.guide.is_none();
        Ok(PictureIdentity {
            scene: self.hash,
            film: FilmFormat { signed, passes, ..FilmFormat::plain(self.size) },
            filter: self.filter,
            integrator: setup.integrator,
            sampler: SamplerKind::Sobol,
            seed: setup.seed,
            samples_per_pixel: 1,
            guide: None,
            version: glanz_job::current_version(),
        })
    }

    /// An empty film for a picture with this setup.
    ///
    /// # Errors
    /// [`StudyError::Filter`], [`StudyError::Film`].
    pub(super) fn film(&self, setup: &RenderSetup) -> Result<Film, StudyError> {
        Ok(Film::try_new(self.identity(setup)?.film)?)
    }

    /// Renders the samples that `film` lacks.
    ///
    /// # Errors
    /// Those of [`render()`], and [`StudyError::Interrupted`]; see [`RenderProgress::complete`].
    pub(super) fn render(
        &self,
        setup: &RenderSetup,
        film: Film,
        samples: Range<u32>,
        limit: Option<Duration>,
        sink: &mut dyn RenderSink,
    ) -> Result<RenderProgress, StudyError> {
        let integrator: Box<dyn Integrator> = match &setup.guide {
            Some(guide) => setup.integrator.build_with_guide(guide.clone()),
            None => setup.integrator.build(),
        };
        let settings = RenderSettings {
            filter: Filter::try_new(&self.filter)?,
            sensor: FilmSensor::default(),
            sampler: SamplerKind::Sobol,
            seed: setup.seed,
            samples_per_pixel: 1,
            samples,
            threads: self.threads,
            spectral: false,
            time_limit: limit,
        };
        let watch = Stopwatch::start(TimeScope::Process);
        let outcome = render(&self.scene, integrator.as_ref(), &settings, film, sink, &self.settings.cancel)?;
        Ok(RenderProgress { outcome, processors: watch.elapsed() })
    }
}

impl RenderProgress {
    /// Itself, unless it was cancelled.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`].
    pub(super) fn complete(self) -> Result<Self, StudyError> {
        self.outcome.end.check()?;
        Ok(self)
    }
}
