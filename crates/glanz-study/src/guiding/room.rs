//! A room with its scene, and what is rendered in it.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use glanz_sampling::SamplerKind;
use glanz_scene::Scene;
use glanz_scene::description::{FilterDescription, IntegratorDescription, LightKind};
use glanz_transport::{
    Film, FilmFormat, Filter, Guide, Integrator, IntegratorSettings, PictureIdentity, RenderOutcome,
    RenderSettings, RenderSink, render,
};

use super::method::Method;
use crate::clock::{Of, Stopwatch};
use crate::rooms::{self, Read};
use crate::study::{Settings, StudyError};

/// A room to render.
pub(super) struct Room<'a> {
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

/// One way to take samples of a room.
#[derive(Clone, Debug)]
pub(super) struct Way {
    pub(super) integrator: IntegratorSettings,
    pub(super) seed: u64,
    /// A guide that does not learn.
    pub(super) guide: Option<Arc<Guide>>,
}

/// A film that was exposed further, and what that took.
pub(super) struct Exposed {
    pub(super) outcome: RenderOutcome,
    /// Time of all processors.
    pub(super) processors: Duration,
}

impl<'a> Room<'a> {
    /// Reads the room `named`: a scene file, or the name of one in `scenes/rooms`.
    ///
    /// # Errors
    /// A file that is no scene, or has lights that paths cannot find by chance.
    pub(super) fn read(
        named: &str,
        size: [u32; 2],
        threads: usize,
        settings: &'a Settings,
    ) -> Result<Self, StudyError> {
        let Read { path, name, loaded } = rooms::read(named)?;
        let mut description = loaded.description;
        if description.lights.iter().any(|light| !matches!(light.kind, LightKind::Infinite)) {
            return Err(StudyError::Setting {
                name: "rooms",
                value: path.display().to_string(),
                needed: "lit by surfaces alone: without light sampling no path finds lights that are points or directions",
            });
        }
        description.film.resolution = size;
        let (integrator, filter) = (description.integrator.clone(), description.filter);
        let (scene, _) = Scene::resolve(description)?;
        let hash = loaded.content_hash;
        Ok(Self { name, size, threads, settings, scene, integrator, filter, hash })
    }

    /// Name and size, for files; the scene's fingerprint keeps rooms of one name apart.
    pub(super) fn label(&self) -> String {
        let [width, height] = self.size;
        format!("{}-{width}x{height}-{:08x}", self.name, self.hash >> 96)
    }

    /// `method` with or without light sampling.
    ///
    /// # Errors
    /// An integrator that is refused.
    pub(super) fn way(&self, method: &Method, lights: bool, seed: u64) -> Result<Way, StudyError> {
        let integrator = IntegratorSettings::resolve(&method.described(&self.integrator, lights))?;
        Ok(Way { integrator, seed, guide: None })
    }

    /// What a picture taken this way depends on.
    ///
    /// # Errors
    /// A filter that is refused.
    pub(super) fn identity(&self, way: &Way) -> Result<PictureIdentity, StudyError> {
        let signed = Filter::try_new(&self.filter)?.is_signed();
        let passes = way.integrator.is_guided() && way.guide.is_none();
        Ok(PictureIdentity {
            scene: self.hash,
            film: FilmFormat { signed, passes, ..FilmFormat::plain(self.size) },
            filter: self.filter,
            integrator: way.integrator,
            sampler: SamplerKind::Sobol,
            seed: way.seed,
            samples_per_pixel: 1,
            guide: None,
            version: glanz_job::current_version(),
        })
    }

    /// An empty film for pictures taken this way.
    ///
    /// # Errors
    /// A filter or a film that is refused.
    pub(super) fn film(&self, way: &Way) -> Result<Film, StudyError> {
        Ok(Film::try_new(self.identity(way)?.film)?)
    }

    /// Takes the samples that `film` does not have yet.
    ///
    /// # Errors
    /// Those of [`render()`], and an end that was wanted; see [`Exposed::complete`].
    pub(super) fn expose(
        &self,
        way: &Way,
        film: Film,
        samples: Range<u32>,
        limit: Option<Duration>,
        sink: &mut dyn RenderSink,
    ) -> Result<Exposed, StudyError> {
        let integrator: Box<dyn Integrator> = match &way.guide {
            Some(guide) => way.integrator.build_with_guide(guide.clone()),
            None => way.integrator.build(),
        };
        let settings = RenderSettings {
            filter: Filter::try_new(&self.filter)?,
            sampler: SamplerKind::Sobol,
            seed: way.seed,
            samples_per_pixel: 1,
            samples,
            threads: self.threads,
            time_limit: limit,
        };
        let watch = Stopwatch::start(Of::Process);
        let outcome = render(&self.scene, integrator.as_ref(), &settings, film, sink, &self.settings.cancel)?;
        Ok(Exposed { outcome, processors: watch.elapsed() })
    }
}

impl Exposed {
    /// Itself, unless it was cancelled.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`].
    pub(super) fn complete(self) -> Result<Self, StudyError> {
        self.outcome.end.check()?;
        Ok(self)
    }
}
