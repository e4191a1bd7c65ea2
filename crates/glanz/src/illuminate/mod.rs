//! Illuminance on the receivers of a scene: lux maps and their files.

mod combined_file;
mod combining;
mod design;
mod facts;
#[cfg(feature = "formats")]
mod far_field_file;
#[cfg(feature = "formats")]
mod files;
mod integrating;
#[cfg(feature = "viewer")]
mod lux_folder;
mod outcome;
mod planning;
#[cfg(feature = "formats")]
mod ray_file;
mod tally_file;
mod tally_join;
mod tracing;

use std::io::Read;
use std::path::Path;
#[cfg(feature = "formats")]
use std::path::PathBuf;
use std::sync::Arc;

use glanz_illumination::planning::{MaintenanceFactor, PlanningRequest, PlanningSettings};
use glanz_illumination::{FarFieldResolution, GridResolution, TraceGoal};
use glanz_job::{JobEnd, JobPart};
use glanz_math::DVec3;

use crate::error::Error;
use crate::event::JobEvent;
#[cfg(feature = "formats")]
use crate::file::FileUses;
use crate::job_options::{JobOptions, job_methods};
use crate::loaded_scene::LoadedScene;
use crate::running_job::RunningJob;
use design::Design;
use tally_file::TallyFile;

#[cfg(feature = "formats")]
pub use far_field_file::check_far_field_path;
#[cfg(feature = "formats")]
pub use files::{comparison_folders, comparison_paths, save_comparison};
#[cfg(feature = "viewer")]
pub use lux_folder::{LuxFolder, PlacedLux, is_lux_folder, lux_folder_content_hash};
pub use outcome::IlluminateOutcome;
#[cfg(feature = "formats")]
pub use ray_file::{SavedRays, check_ray_path};
pub use tally_join::JoinedTally;
pub(crate) use tally_join::join;

/// Default relative standard error at which a run ends.
const USUAL_ERROR: f64 = 0.01;

/// Smallest valid goal of the relative standard error.
const SMALLEST_ERROR: f64 = 1e-6;

/// Method of computing the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IlluminateMethod {
    /// Each part of the light by the method that is best at it: integration of direct light and of light after reflection in one mirror, paths from the
    /// cells for light between other surfaces, particles for caustics. A calculation with a number of particles, a part of one, and one that counts the light that
    /// leaves the scene, is [`Trace`](IlluminateMethod::Trace).
    #[default]
    Auto,
    /// Particles from the lights: all light.
    Trace,
    /// Deterministic integration over the images of lights in mirrors: direct light and light after reflection in one mirror.
    Integrate,
    /// Integration and particles, with their difference.
    Both,
}

impl IlluminateMethod {
    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Trace => "trace",
            Self::Integrate => "integrate",
            Self::Both => "both",
        }
    }
}

/// Builder of a calculation of illuminance.
#[must_use = "nothing is calculated before `run`"]
pub struct IlluminateBuilder<'a> {
    scene: LoadedScene,
    title: Option<String>,
    options: IlluminateOptions,
    plan: Option<PlanningRequest>,
    planning: PlanningSettings,
    ray_file: bool,
    /// The folder of the results, and the files of the command.
    #[cfg(feature = "formats")]
    results: Option<(PathBuf, FileUses)>,
    job: JobOptions<'a>,
}

/// Settings of a calculation of illuminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IlluminateOptions {
    /// Adds the walls of a box from the origin to this size, metres: six receivers that absorb all light.
    pub room: Option<DVec3>,
    /// Size of the cells of receivers that do not specify it themselves.
    pub resolution: GridResolution,
    /// Method of computing the light.
    pub method: IlluminateMethod,
    /// End of the calculation; by default a relative standard error of 0.01. Errors below 1e-6 are refused.
    pub goal: TraceGoal,
    /// Traces only this part of the particles of the goal, from which [`merge`](crate::merge) joins the whole. An error with another goal and
    /// another method.
    pub part: Option<JobPart>,
    /// Relative error of the integration in every cell; by [`IlluminateMethod::Auto`], half of the error of the goal if it has one.
    pub tolerance: f64,
    /// Replaces all light of the scene by an overcast sky, and adds daylight factors to the report. An error with a plan, a task or a maintenance factor.
    pub daylight: bool,
    /// Angles by which the light that leaves the scene is counted, see [`IlluminateOutcome::save_far_field`]; `None`: it is not.
    pub far_field: Option<FarFieldResolution>,
    /// Seed of the particles; another seed gives another, independent result.
    pub seed: u64,
    /// Largest number of scattering events of a particle.
    pub max_depth: u32,
}

impl Default for IlluminateOptions {
    /// Particles until the error is 0.01, with 64 cells along the longer side of each receiver.
    fn default() -> Self {
        Self {
            room: None,
            resolution: GridResolution::Longer(64),
            method: IlluminateMethod::default(),
            goal: TraceGoal::default(),
            part: None,
            tolerance: 0.01,
            daylight: false,
            far_field: None,
            seed: 0,
            max_depth: 1000,
        }
    }
}

impl IlluminateOptions {
    /// The relative error of the integration that applies.
    fn integration_tolerance(&self) -> f64 {
        let goal = self.goal.error.filter(|_| self.method == IlluminateMethod::Auto);
        goal.map_or(self.tolerance, |goal| 0.5 * goal)
    }
}

impl<'a> IlluminateBuilder<'a> {
    pub(crate) fn new(scene: LoadedScene) -> Self {
        let (options, job) = (IlluminateOptions::default(), JobOptions::default());
        Self {
            scene,
            title: None,
            options,
            plan: None,
            planning: PlanningSettings::default(),
            ray_file: false,
            #[cfg(feature = "formats")]
            results: None,
            job,
        }
    }

    /// Title of the reports, such as the name of the project; the name of the scene's file without extension unless set.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Rates this by standards ([`LuxReport::plan`](glanz_illumination::report::LuxReport::plan)); by default, zones and observers that the scene declares are rated.
    pub fn plan(mut self, request: PlanningRequest) -> Self {
        self.plan = Some(request);
        self
    }

    /// Task, maintenance factor and accuracy of ratings.
    pub fn planning(mut self, settings: PlanningSettings) -> Self {
        self.planning = settings;
        self
    }

    /// Replaces all options.
    pub fn options(mut self, options: IlluminateOptions) -> Self {
        self.options = options;
        self
    }

    /// Adds the walls of a box from the origin to `size`, metres: six receivers that absorb all light.
    pub fn room(mut self, size: DVec3) -> Self {
        self.options.room = Some(size);
        self
    }

    /// Computes light by `method`; by the best for each part of it unless set.
    pub fn method(mut self, method: IlluminateMethod) -> Self {
        self.options.method = method;
        self
    }

    /// Ends after `count` particles.
    pub fn particles(mut self, count: u64) -> Self {
        self.options.goal.particles = Some(count);
        self
    }

    /// Traces only this part of the particles, into the checkpoint; [`merge`](crate::merge) joins all parts.
    pub fn part(mut self, part: JobPart) -> Self {
        self.options.part = Some(part);
        self
    }

    /// Ends at this relative standard error of the brightest and of the darkest cell and of the mean of every receiver, at least 1e-6; see
    /// [`TraceGoal::error`].
    pub fn relative_error(mut self, error: f64) -> Self {
        self.options.goal.error = Some(error);
        self
    }

    /// Seeds the particles; another seed gives another, independent result.
    pub fn seed(mut self, seed: u64) -> Self {
        self.options.seed = seed;
        self
    }

    /// Whether the result keeps the scene for [`IlluminateOutcome::save_ray_file`], which needs a number of particles; no receiver is needed then.
    #[cfg(feature = "formats")]
    pub fn ray_file(mut self, keep: bool) -> Self {
        self.ray_file = keep;
        self
    }

    /// Refuses the calculation, before it computes light, if a file that [`IlluminateOutcome::save`] writes into `folder` is an input or another output among
    /// `files`.
    #[cfg(feature = "formats")]
    pub fn check_results(mut self, folder: impl Into<PathBuf>, files: FileUses) -> Self {
        self.results = Some((folder.into(), files));
        self
    }

    /// Replaces the options that every job takes.
    pub fn job(mut self, options: JobOptions<'a>) -> Self {
        self.job = options;
        self
    }

    job_methods!('a, job);

    /// Calculates.
    ///
    /// A cancelled calculation returns the result of its particles so far, if there are any.
    ///
    /// # Errors
    /// [`Error::Scene`] for a description that is not a scene, [`Error::File`] for a checkpoint that cannot be read or written,
    /// [`Error::NoReceiver`], [`Error::NoLight`], [`Error::Cells`], [`Error::Receiver`], [`Error::Accuracy`], [`Error::NoFarField`] and [`Error::Integrate`]; [`Error::RayGoal`] for a ray file without a number of particles;
    /// [`Error::Planning`] and [`Error::DirectRating`] for figures of planners; [`Error::DaylightRating`] for a plan, a task or a maintenance factor with daylight;
    /// [`Error::PartGoal`] and [`Error::Indivisible`] for a part without a number of particles, or of an integration.
    pub fn run(self) -> Result<IlluminateOutcome, Error> {
        #[cfg(feature = "formats")]
        let results = self.results;
        let Self { scene, title, mut options, plan, planning: settings, ray_file, job, .. } = self;
        scene.check_scene("illuminate")?;
        let mut job = job.start();
        if let Some(error) = options.goal.error.filter(|error| *error < SMALLEST_ERROR) {
            return Err(Error::Accuracy { error, smallest: SMALLEST_ERROR });
        }
        let only_particles =
            matches!(options.goal, TraceGoal { particles: Some(_), time: None, error: None });
        if ray_file
            && (!only_particles || options.part.is_some() || options.method == IlluminateMethod::Integrate)
        {
            return Err(Error::RayGoal);
        }
        if options.part.is_some() {
            if !matches!(options.method, IlluminateMethod::Auto | IlluminateMethod::Trace) {
                return Err(Error::Indivisible { what: "the integration over mirrors" });
            }
            if !only_particles {
                return Err(Error::PartGoal);
            }
        }
        if options.far_field.is_some() && options.method == IlluminateMethod::Integrate {
            return Err(Error::NoFarField);
        }
        if options.goal == TraceGoal::default() {
            options.goal.error = Some(USUAL_ERROR);
        }
        job.claim_checkpoint()?;
        if options.method == IlluminateMethod::Auto && is_by_particles(&options, &job) {
            options.method = IlluminateMethod::Trace;
        }
        settings.maintenance.value().map_err(|error| Error::Planning(error.into()))?;
        let is_judged = plan.is_some() || settings.task.is_some();
        if options.daylight && (is_judged || settings.maintenance != MaintenanceFactor::default()) {
            return Err(Error::DaylightRating);
        }
        let needs_receivers = options.far_field.is_none() && !ray_file;
        let design = Design { title, ..Design::new(scene, options, needs_receivers, &mut job)? };
        #[cfg(feature = "formats")]
        if let Some((folder, mut uses)) = results {
            let mut paths = files::result_paths(&folder, &design.receivers, design.options.method);
            paths.try_for_each(|path| uses.add_result(&path))?;
        }
        let request = plan.unwrap_or_else(|| design.declared_plan());
        if is_judged && !request.is_empty() && options.method == IlluminateMethod::Integrate {
            return Err(Error::DirectRating);
        }
        let (receivers, cells) = (design.receivers.as_slice().len(), design.receivers.cell_count());
        job.emit(JobEvent::IlluminateStarted { receivers, cells });
        let mut outcome = design.illuminate(&mut job)?;
        if needs_receivers && let Some(balance) = &outcome.report.balance {
            design.warn_of_escaped_flux(balance, &mut job);
        }
        outcome.report.planning = settings.clone();
        // Requirements of standards are not those of light from the sky alone.
        if !request.is_empty() && options.part.is_none() && !options.daylight {
            planning::rate(&design, &request, &settings, &mut outcome, &mut job)?;
        }
        outcome.design = (ray_file && outcome.end == JobEnd::Complete).then(|| Arc::new(design));
        outcome.warnings = job.warnings;
        Ok(outcome)
    }
}

/// Whether a calculation without a method is one of particles: if it has a number of them, counts the light that leaves the scene, or is resumed from one of
/// particles.
fn is_by_particles(options: &IlluminateOptions, job: &RunningJob<'_>) -> bool {
    if options.goal.particles.is_some() || options.part.is_some() || options.far_field.is_some() {
        return true;
    }
    let resumed = job.options.checkpoint.as_deref().filter(|path| job.options.resume && path.exists());
    let begins_as_tally = |path: &Path| {
        let mut start = [0; 8];
        let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
        read.is_ok() && TallyFile::is_begun_by(&start)
    };
    resumed.is_some_and(begins_as_tally)
}
