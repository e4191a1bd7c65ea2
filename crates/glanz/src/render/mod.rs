//! Rendering: pictures of a scene, and their files.

mod darkness;
#[cfg(feature = "denoise")]
mod denoised;
mod edges;
mod guide_file;
mod picture;
#[cfg(feature = "formats")]
mod picture_files;
mod plan;
#[cfg(feature = "radiosity")]
mod stored;

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use glanz_job::{JobEnd, JobIdentity, JobPart};
use glanz_sampling::SamplerKind;
use glanz_scene::Scene;
use glanz_scene::description::GuideSettings;
use glanz_transport::{
    AovSet, Checkpoint, CheckpointHead, Film, Integrator, Rejects, RenderError, RenderOutcome, RenderSink,
    render,
};

use crate::error::Error;
use crate::event::{JobEvent, ResumedState, Warning};
use crate::file;
use crate::job_options::{JobOptions, job_methods};
use crate::loaded_scene::LoadedScene;
use crate::running_job::{JobSink, RunningJob};

pub use darkness::Darkness;
#[cfg(all(feature = "denoise", feature = "viewer"))]
pub(crate) use denoised::noisy_picture;
pub use edges::{EdgeLines, MAX_LINE_WIDTH};
pub use picture::{Picture, RenderStatistics};
#[cfg(feature = "formats")]
pub use picture_files::picture_format;
pub use plan::RenderPlan;

/// Settings of a render; the defaults are those of the scene.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Name of the integrator, one of [`INTEGRATORS`](glanz_transport::INTEGRATORS).
    pub integrator: Option<String>,
    /// Width and height of the full picture, pixels.
    pub size: Option<[u32; 2]>,
    /// Distribution of the samples.
    pub sampler: Option<SamplerKind>,
    /// Seed of the samples; another seed gives another, independent picture.
    pub seed: Option<u64>,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Relative standard error at which the tiles of the picture take no more samples, from 10^-6 to 1, see [`glanz_transport::noise`]. The
    /// number of samples is then a limit; without one it is 65536, or as many as fit into the time. Adds the channel of the variance. An error for integrators whose samples depend on other pixels.
    pub noise: Option<f64>,
    /// Renders only these samples of every pixel, as a part of a picture that [`merge`](crate::merge) joins.
    pub sample_range: Option<Range<u32>>,
    /// Renders only this part of the samples, or of [`RenderOptions::sample_range`], as a part of a picture that [`merge`](crate::merge) joins. It keeps its
    /// noise. An error for an integrator that learns without [`RenderOptions::guide_input`], with a noise level, and with a time limit.
    pub part: Option<JobPart>,
    /// Renders as many samples as fit into this wall time of the render loop, at least one, instead of a fixed number.
    pub time_limit: Option<Duration>,
    /// Whether lights are sampled at every hit; otherwise paths find them by chance.
    pub light_sampling: Option<bool>,
    /// Renders with four wavelengths per path instead of red, green and blue, whatever the scene says.
    pub spectral: bool,
    /// Number of paths into which a camera ray divides at its first rough surface, from 1 to
    /// [`BRANCHING_LIMIT`](glanz_transport::BRANCHING_LIMIT): of the integrators `path`, by default 1, and `distributed`, by default 8. An
    /// error for all others.
    pub branching: Option<u32>,
    /// Kind of guide that the integrator `guided` learns.
    pub guide: Option<GuideSettings>,
    /// File of a guide from which directions are sampled, without learning (integrator `guided`).
    pub guide_input: Option<PathBuf>,
    /// File for the guide learnt in the last complete pass (integrator `guided`).
    pub guide_output: Option<PathBuf>,
    /// Checkpoint of a finished bake, whose light is used instead of baking (integrator `radiosity`).
    #[cfg(feature = "radiosity")]
    pub light_input: Option<PathBuf>,
    /// Memory that the sums of all pixels may take, bytes: those of a larger picture are in a temporary file, of which some rows are in memory at a time. An error for
    /// a larger picture of an integrator that learns or connects light to the film, with a noise level, and if noise is removed. `None`: half of what the scene leaves of its [limit](LoadedScene::limits), or
    /// all of it for a picture that must be in memory.
    pub film_memory: Option<u64>,
    /// Channels beside the colour.
    pub aovs: AovSet,
    /// Lines over the picture along the feature edges of CAD models that were read with [their edges](glanz_scene::description::EdgeDescription);
    /// `None`: no lines.
    pub edges: Option<EdgeLines>,
    /// Whether noise is removed from the finished picture, by Open Image Denoise. Adds the channels of albedo and shading normals.
    #[cfg(feature = "denoise")]
    pub denoise: bool,
}

/// Builder of a render.
///
/// It prepares the film for the integrator, learns or reads its guide, and bakes or reads the light that it shows.
#[must_use = "nothing is rendered before `run`"]
pub struct RenderBuilder<'a> {
    scene: LoadedScene,
    options: RenderOptions,
    job: JobOptions<'a>,
}

impl<'a> RenderBuilder<'a> {
    pub(crate) fn new(scene: LoadedScene) -> Self {
        Self { scene, options: RenderOptions::default(), job: JobOptions::default() }
    }

    /// Replaces all options.
    pub fn options(mut self, options: RenderOptions) -> Self {
        self.options = options;
        self
    }

    /// Uses the integrator `name` of [`INTEGRATORS`](glanz_transport::INTEGRATORS).
    pub fn integrator(mut self, name: impl Into<String>) -> Self {
        self.options.integrator = Some(name.into());
        self
    }

    /// Renders `count` samples per pixel.
    pub fn samples(mut self, count: u32) -> Self {
        self.options.samples = Some(count);
        self
    }

    /// Renders a picture of this width and height, pixels.
    pub fn size(mut self, size: [u32; 2]) -> Self {
        self.options.size = Some(size);
        self
    }

    /// Seeds the samples; another seed gives another, independent picture.
    pub fn seed(mut self, seed: u64) -> Self {
        self.options.seed = Some(seed);
        self
    }

    /// Adds channels beside the colour.
    pub fn aovs(mut self, aovs: AovSet) -> Self {
        self.options.aovs = aovs;
        self
    }

    /// Replaces the options that every job takes.
    pub fn job(mut self, options: JobOptions<'a>) -> Self {
        self.job = options;
        self
    }

    job_methods!('a, job);

    /// Renders.
    ///
    /// A cancelled render returns a picture with the samples so far, if there is one.
    ///
    /// # Errors
    /// [`Error::Scene`] for a description that is not a scene, [`Error::File`] for files that cannot be read or written, the
    /// variants named after settings for those that contradict one another; [`Error::Unsaved`] holds the picture.
    pub fn run(self) -> Result<Picture, Error> {
        let Self { mut scene, options, job } = self;
        let mut job = job.start();
        job.claim_checkpoint()?;
        options.guide_output.as_deref().map_or(Ok(()), file::check_writable)?;
        #[cfg(feature = "denoise")]
        let denoiser =
            (options.denoise && options.part.is_none()).then(glanz_denoise::Denoiser::load).transpose()?;
        let plan = RenderPlan::new(&options, &mut scene, &job.options)?;
        let film = starting_film(&plan, &mut job)?;
        scene.reserve(memory_of(&film, plan.film_memory)?);
        let (scene, warnings) = scene.resolve_for(&job.options.cancel)?;
        warnings.into_iter().for_each(|warning| job.warn(warning));
        let settings = &plan.identity.integrator;
        if scene.has_media() && !settings.sees_media() {
            job.warn(Warning::MediaLeftOut { what: format!("the integrator {:?}", settings.name()) });
        }
        let has_light = !scene.lights().is_empty() || settings.sees_media() && scene.has_emissive_media();
        if !has_light {
            job.warn(Warning::NoLight);
        }
        if settings.has_photons() && (settings.spectral || scene.has_media()) {
            job.warn(Warning::NoPhotons);
        }
        job.options.cancel.check()?;
        job.emit(JobEvent::RenderStarted(&plan));
        let lines = match plan.edges {
            Some(style) => edges::layer(&scene, &plan.identity.film, style, &mut job)?,
            None => None,
        };
        let film = film.with_edges(lines)?;
        let integrator = plan.integrator(&scene, &mut job)?;
        let outcome = expose(&scene, integrator.as_ref(), &plan, film, &mut job)?;
        // Before rays that look for the reason of a black picture.
        let undecided = scene.undecided();
        // A scene without light has a warning of its own.
        if outcome.end != JobEnd::Interrupted
            && has_light
            && let Some(reason) = Darkness::of(&outcome.film, &scene, plan.identity.integrator.light_sampling)
        {
            job.warn(Warning::Black { reason });
        }
        let picture = finish(plan, outcome, undecided, options.guide_output.as_deref(), &mut job)?;
        #[cfg(feature = "denoise")]
        let picture = match denoiser {
            Some(denoiser) => denoised::denoise(picture, &denoiser, &mut job)?,
            None => picture,
        };
        Ok(picture)
    }
}

/// Memory that the film takes, bytes; `limit`: that which it may take.
fn memory_of(film: &Film, limit: u64) -> Result<u64, Error> {
    let needed = film.format().words()?.saturating_mul(8);
    // Of a film in a file, some rows are in memory at a time.
    Ok(if film.is_in_file() { needed.min(limit / 4) } else { needed })
}

/// The film of the checkpoint to resume, or an empty one.
fn starting_film(plan: &RenderPlan, job: &mut RunningJob<'_>) -> Result<Film, Error> {
    let Some(path) = job.resumed() else {
        let mut film = Film::try_new_within(plan.identity.film, plan.film_memory)?;
        film.add_plans(plan.part_of.clone());
        return Ok(film);
    };
    let mut file = File::open(&path).map_err(Error::of_file(&path))?;
    let head = CheckpointHead::read(&mut file).map_err(Error::of_file(&path))?;
    // Before the sums, which may be large, and need not fit this job's memory.
    head.identity.check(&plan.identity).map_err(Error::of_file(&path))?;
    let mut checkpoint =
        Checkpoint::read_sums(head, file, plan.film_memory).map_err(Error::of_file(&path))?;
    let is_counted = plan.time_limit.is_none() && plan.identity.film.noise.is_none();
    let wanted = is_counted.then(|| plan.samples.clone());
    let state = &ResumedState::Samples { done: checkpoint.film.samples().clone(), wanted };
    job.emit(JobEvent::Resumed { path: &path, state });
    checkpoint.film.add_plans(plan.part_of.clone());
    Ok(checkpoint.film)
}

fn expose(
    scene: &Scene,
    integrator: &dyn Integrator,
    plan: &RenderPlan,
    film: Film,
    job: &mut RunningJob<'_>,
) -> Result<RenderOutcome, Error> {
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let write =
        |path: &Path, film: &Film| file::write_with(path, |out| Checkpoint::write(&plan.identity, film, out));
    let mut sink = JobSink::new(job, path, write);
    let outcome = render(scene, integrator, &plan.settings(), film, &mut sink, &cancel);
    outcome.map_err(|error| match error {
        RenderError::Order { next } => Error::SampleOrder { start: plan.samples.start, next },
        error => error.into(),
    })
}

fn finish(
    plan: RenderPlan,
    outcome: RenderOutcome,
    undecided: u64,
    guide: Option<&Path>,
    job: &mut RunningJob<'_>,
) -> Result<Picture, Error> {
    let RenderOutcome { film, end, elapsed, counters, samples } = outcome;
    if film.samples().is_empty() {
        end.check()?;
    }
    let Rejects { dropped, cut } = film.rejects();
    let counts = [
        (dropped, Warning::Dropped { samples: dropped }),
        (cut, Warning::Cut { samples: cut }),
        (undecided, Warning::Undecided { rays: undecided }),
        (film.open_tiles(), Warning::NoiseAboveLevel { tiles: film.open_tiles() }),
    ];
    counts.into_iter().filter(|(count, _)| *count > 0).for_each(|(_, warning)| job.warn(warning));
    let threads = plan.threads;
    let statistics = RenderStatistics { end, elapsed, counters, samples, undecided, threads };
    let picture = Picture::new(plan.identity, film, statistics, std::mem::take(&mut job.warnings));
    // The checkpoint is written first, because it takes longest to compute again.
    let checkpoint = job.options.checkpoint.as_deref();
    let saved = checkpoint.map_or(Ok(()), |path| picture.save_checkpoint(path));
    match saved.and(guide.map_or(Ok(()), |path| picture.save_guide(path))) {
        Ok(()) => Ok(picture),
        Err(error) => Err(Error::Unsaved { picture: Box::new(picture), error: Box::new(error) }),
    }
}

impl<W: FnMut(&Path, &Film) -> Result<(), Error>> RenderSink for JobSink<'_, '_, W> {}

#[cfg(test)]
mod tests {
    use glanz_scene::SceneBuilder;

    use super::*;
    use crate::error::FileFault;

    #[test]
    fn checkpoint_of_another_integrator_is_refused_before_its_sums_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let description = SceneBuilder::new().resolution(2, 2).describe().unwrap();
        let scene = LoadedScene::from_description("empty", description);
        // The sums of one that learns cannot be in a file.
        scene.clone().render().integrator("guided").samples(1).checkpoint(path.clone()).run().unwrap();
        let options = RenderOptions {
            integrator: Some("path".to_owned()),
            samples: Some(1),
            film_memory: Some(0),
            ..RenderOptions::default()
        };
        let refused = scene.render().options(options).checkpoint(path).resume(true).run();
        assert!(matches!(refused, Err(Error::File { fault: FileFault::Identity(_), .. })));
    }
}
