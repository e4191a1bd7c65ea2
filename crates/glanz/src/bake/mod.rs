//! Baking: light maps of a scene, and models that show them.

mod light_file;
mod light_state;
#[cfg(feature = "formats")]
mod model;
#[cfg(feature = "formats")]
mod model_camera;
#[cfg(feature = "formats")]
mod model_files;
mod outcome;

use std::path::Path;
use std::time::Instant;

use glanz_radiosity::bake::{
    Atlas, BakeError, BakeMethod, BakePart, BakeSettings, BakeState, BakedLight, CoarseElements, LightMap,
    resume,
};
use glanz_radiosity::elements::{ElementSettings, Elements};
use glanz_scene::Scene;
use glanz_shading::Material;

use crate::error::Error;
use crate::event::{JobEvent, ResumedState, Warning};
use crate::job_options::{JobOptions, job_methods};
use crate::loaded_scene::LoadedScene;
use crate::running_job::{JobSink, RunningJob};
use light_file::{BakeStart, LightIdentity};

pub use light_file::LightFile;
pub use light_state::LightState;
pub(crate) use light_state::join;
#[cfg(feature = "formats")]
pub use model_files::{ModelFiles, ModelSettings, check_model_path, page_path};
pub use outcome::BakeOutcome;

/// Largest side of an element: metres, and relative to the diagonal of the scene.
const SIDE: f64 = 0.3;
const SIDE_OF_SCENE: f64 = 1.0 / 24.0;

/// Builder of a bake.
///
/// The light is computed by radiosity: mirrors, glass and glossy materials are treated as diffuse. With [`BakeMethod::Radiosity`],
/// light passes clear glass.
#[must_use = "nothing is baked before `run`"]
pub struct BakeBuilder<'a> {
    scene: LoadedScene,
    settings: BakeSettings,
    job: JobOptions<'a>,
}

impl<'a> BakeBuilder<'a> {
    pub(crate) fn new(scene: LoadedScene) -> Self {
        Self { scene, settings: BakeSettings::default(), job: JobOptions::default() }
    }

    /// Smallest density of the light maps, texels per metre; 50 unless set.
    pub fn density(mut self, texels_per_metre: f64) -> Self {
        self.settings.density = texels_per_metre;
        self
    }

    /// Number of rays that gather indirect light at a point; 512 unless set.
    pub fn rays(mut self, count: u32) -> Self {
        self.settings.rays = count;
        self
    }

    /// Method of computing light between surfaces; a final gather unless set.
    pub fn method(mut self, method: BakeMethod) -> Self {
        self.settings.method = method;
        self
    }

    /// Replaces the options that every job takes.
    pub fn job(mut self, options: JobOptions<'a>) -> Self {
        self.job = options;
        self
    }

    job_methods!('a, job);

    /// Bakes. A cancelled bake ends with [`Error::Interrupted`], after its checkpoint was written.
    ///
    /// # Errors
    /// [`Error::Scene`] for a description that is not a scene, [`Error::File`] for a checkpoint that cannot be read or written,
    /// [`Error::Elements`] and [`Error::Bake`] for more elements or texels than can be stored.
    pub fn run(self) -> Result<BakeOutcome, Error> {
        let Self { scene, settings, job } = self;
        scene.check_scene("bake")?;
        let mut job = job.start();
        job.claim_checkpoint()?;
        let identity = LightIdentity::new(scene.content_hash(), settings);
        #[cfg(feature = "formats")]
        let view = model_files::ModelView::of(&scene.description);
        let scene = resolved(scene, &mut job)?;
        let start = Instant::now();
        #[cfg(feature = "formats")]
        if view.camera(&scene.bounds()).is_none() {
            job.warn(Warning::CameraLeftOut);
        }
        let (maps, elements) = job.in_pool(|job| {
            let elements = started_elements(&scene, &settings, job)?;
            let count = elements.list.len();
            let maps = match start_of(&identity, &elements, job)? {
                BakeStart::Finished(maps) => maps,
                BakeStart::State(state) => baked_maps(state, &elements, &settings, Some(&identity), job)?,
            };
            Ok((maps, count))
        })?;
        let coarse = maps.iter().filter(|map| map.chart.is_coarse && !map.is_dark()).count();
        if coarse > 0 {
            job.warn(Warning::CoarseCharts { charts: coarse });
        }
        let (atlas, elapsed) = (Atlas::new(&maps), start.elapsed());
        Ok(BakeOutcome {
            scene,
            #[cfg(feature = "formats")]
            view,
            maps,
            atlas,
            elements,
            elapsed,
            warnings: job.warnings,
        })
    }
}

impl BakeBuilder<'_> {
    /// Bakes a part, into the checkpoint; [`merge`](crate::merge) joins all parts.
    ///
    /// It begins with the light of the file `light_input`, of joined parts that end with the direct light; without, it computes the direct
    /// light of all parts.
    ///
    /// # Errors
    /// Those of [`BakeBuilder::run`]; [`Error::Indivisible`] for [`BakeMethod::Radiosity`], [`Error::Join`] for finished light as its beginning.
    pub fn run_part(self, part: BakePart, light_input: Option<&Path>) -> Result<LightState, Error> {
        let Self { scene, settings, job } = self;
        scene.check_scene("bake")?;
        if settings.method != BakeMethod::Gather {
            return Err(Error::Indivisible { what: "the hierarchical solver" });
        }
        let mut job = job.start();
        job.claim_checkpoint()?;
        let identity = LightIdentity::new(scene.content_hash(), settings);
        let scene = resolved(scene, &mut job)?;
        job.in_pool(|job| {
            let elements = started_elements(&scene, &settings, job)?;
            light_state::computed(identity, &elements, &settings, part, light_input, job)
        })
    }
}

/// The scene of a bake.
fn resolved(scene: LoadedScene, job: &mut RunningJob<'_>) -> Result<Scene, Error> {
    let (scene, warnings) = scene.resolve_for(&job.options.cancel)?;
    warnings.into_iter().for_each(|warning| job.warn(warning));
    if scene.has_media() {
        job.warn(Warning::MediaLeftOut { what: "the bake".to_owned() });
    }
    if scene.lights().is_empty() {
        job.warn(Warning::NoLight);
    }
    Ok(scene)
}

/// The elements, with the event that the bake starts.
fn started_elements<'a>(
    scene: &'a Scene,
    settings: &BakeSettings,
    job: &mut RunningJob<'_>,
) -> Result<Elements<'a>, Error> {
    let elements = elements(scene, settings, job)?;
    job.emit(JobEvent::BakeStarted { density: settings.density, elements: elements.list.len() });
    Ok(elements)
}

/// The start of the bake: the checkpoint to resume, or an empty state.
fn start_of(
    identity: &LightIdentity,
    elements: &Elements<'_>,
    job: &mut RunningJob<'_>,
) -> Result<BakeStart, Error> {
    let Some(path) = job.resumed() else { return Ok(BakeStart::State(BakeState::default())) };
    let start = LightFile::read(&path)?.start(identity, elements)?;
    let state = match &start {
        BakeStart::Finished(_) => ResumedState::AllLight,
        BakeStart::State(state) => ResumedState::Places(state.points()),
    };
    job.emit(JobEvent::Resumed { path: &path, state: &state });
    Ok(start)
}

/// The elements of a scene for light maps; warns of differences from a path-traced picture.
pub(crate) fn elements<'a>(
    scene: &'a Scene,
    settings: &BakeSettings,
    job: &mut RunningJob<'_>,
) -> Result<Elements<'a>, Error> {
    let elements = divided(scene, settings.density)?;
    let is_exact = |material: &&Material| match material {
        Material::Diffuse { .. } | Material::Interface => true,
        // Elements of the solver let light pass clear glass.
        Material::Dielectric(glass) => {
            settings.method != BakeMethod::Gather && (glass.thin || glass.roughness.is_smooth())
        }
        _ => false,
    };
    let others = scene.materials().iter().filter(|material| !is_exact(material)).count();
    if others > 0 {
        job.warn(Warning::NotDiffuse { materials: others });
    }
    if elements.left_out > 0 {
        job.warn(Warning::LeftOut { surfaces: elements.left_out });
    }
    Ok(elements)
}

/// The elements of a scene for light maps of a density, texels per metre.
pub(crate) fn divided(scene: &Scene, density: f64) -> Result<Elements<'_>, Error> {
    let diagonal = scene.bounds().diagonal().length();
    let side = if diagonal > 0.0 { SIDE.min(SIDE_OF_SCENE * diagonal) } else { SIDE };
    let mut elements = Elements::new(scene, &ElementSettings { side })?;
    if density.is_finite() {
        elements.cut_at_walls(density)?;
    }
    Ok(elements)
}

/// Computes the light maps from a state. `identity`: that of the light in the job's checkpoint, if the checkpoint holds light.
pub(crate) fn baked_maps(
    state: BakeState,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    identity: Option<&LightIdentity>,
    job: &mut RunningJob<'_>,
) -> Result<Vec<LightMap>, Error> {
    let kept = identity.zip(job.options.checkpoint.clone());
    let (cancel, path) = (job.options.cancel.clone(), kept.as_ref().map(|(_, path)| path.clone()));
    let write = |path: &Path, state: &BakeState| {
        // Light that was reflected by texels which could not be read is not kept.
        elements.scene.check_textures()?;
        identity.map_or(Ok(()), |identity| light_file::write_state(path, identity, state))
    };
    let mut sink = JobSink::new(job, path, write);
    match resume(state, elements, settings, &mut sink, &cancel) {
        Ok(BakedLight { maps, coarse_elements }) => {
            elements.scene.check_textures()?;
            if let Some(CoarseElements { count, error, bound }) = coarse_elements {
                job.warn(Warning::CoarseElements { elements: count, error, bound });
            }
            // Written before all other files, because the light takes longest to compute again.
            if let Some((identity, path)) = kept {
                light_file::write_maps(&path, identity, &maps)?;
            }
            Ok(maps)
        }
        Err(BakeError::Interrupted(interrupted)) => sink.written.and(Err(interrupted.into())),
        Err(error) => Err(Error::Bake(error)),
    }
}
