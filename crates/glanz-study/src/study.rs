//! Definition of a study, and the table of all studies.

use std::path::PathBuf;
use std::time::Instant;

use glanz_formats::image::ImageError;
use glanz_formats::newell::NewellError;
use glanz_geometry::SurfaceError;
use glanz_illumination::integrate::IntegrateError;
use glanz_illumination::{ReceiverError, ThreadsError};
use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink, WriteError};
use glanz_light::{CompareError, PixelsError};
use glanz_radiosity::elements::ElementError;
use glanz_radiosity::reconstruct::ReconstructError;
use glanz_sampling::DensityError;
use glanz_scene::SceneError;
use glanz_transport::{FilmError, FilterError, IntegratorError, RenderError};

use crate::reconstruction::quadtree::QuadtreeError;
use crate::report::Report;
use crate::{bsdfs, densities, guiding, newton, reconstruction, reflector, solvers, tessellation};

/// A study: a question and the function that answers it.
#[derive(Debug)]
pub struct Study {
    /// Its name on the command line.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    /// The settings that it uses, besides the seed.
    pub options: &'static [StudyOption],
    /// Whether it caches its measurements in [`Settings::cache`].
    pub caches: bool,
    run: fn(&Settings, &mut StudyProgress<'_>) -> Result<Report, StudyError>,
}

/// Settings that only some studies use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyOption {
    /// [`Settings::rays`].
    Rays,
    /// [`Settings::size`].
    Size,
    /// [`Settings::triangles`].
    Triangles,
    /// [`Settings::rooms`].
    Rooms,
    /// [`Settings::methods`].
    Methods,
    /// [`Settings::samples`].
    Samples,
    /// [`Settings::references`].
    References,
    /// [`Settings::elements`].
    Elements,
    /// [`Settings::rounds`].
    Rounds,
    /// [`Settings::seconds`].
    Seconds,
    /// [`Settings::threads`].
    Threads,
    /// [`Settings::full`].
    Full,
}

/// All studies. A new one is a file and a line here.
static STUDIES: [Study; 8] = [
    Study {
        name: "bsdfs",
        description: "values of scattering models, densities of their samples, and what they give back of a white sky",
        options: &[],
        caches: false,
        run: bsdfs::run,
    },
    Study {
        name: "densities",
        description: "variance of integrals whose density learns from its own samples (document 003)",
        options: &[],
        caches: false,
        run: densities::run,
    },
    Study {
        name: "guiding",
        description: "speed-up of path tracing in rooms by densities that learn the incident light (document 003)",
        options: &[
            StudyOption::Rooms,
            StudyOption::Methods,
            StudyOption::Size,
            StudyOption::Samples,
            StudyOption::References,
            StudyOption::Rounds,
            StudyOption::Seconds,
            StudyOption::Threads,
            StudyOption::Full,
        ],
        caches: true,
        run: guiding::run,
    },
    Study {
        name: "newton",
        description: "roots that Newton's method finds, misses and invents, compared with the certified search (document 000)",
        options: &[StudyOption::Rays],
        caches: false,
        run: newton::run,
    },
    Study {
        name: "reconstruction",
        description: "light on a floor from one value per element, by six interpolations (document 003)",
        options: &[StudyOption::Size],
        caches: false,
        run: reconstruction::run,
    },
    Study {
        name: "reflector",
        description: "light of a lamp reflected by a freeform mirror, exact and as facets (document 000)",
        options: &[StudyOption::Rays, StudyOption::Threads],
        caches: false,
        run: reflector::run,
    },
    Study {
        name: "solvers",
        description: "time, memory and errors of radiosity solvers over the number of elements (document 003)",
        options: &[StudyOption::Rooms, StudyOption::Elements, StudyOption::Threads],
        caches: false,
        run: solvers::run,
    },
    Study {
        name: "tessellation",
        description: "time, memory and errors of triangles compared with the exact surface (document 002)",
        options: &[StudyOption::Size, StudyOption::Triangles],
        caches: false,
        run: tessellation::run,
    },
];

/// All studies.
#[must_use]
pub fn studies() -> &'static [Study] {
    &STUDIES
}

/// The study of this name.
#[must_use]
pub fn named(name: &str) -> Option<&'static Study> {
    STUDIES.iter().find(|study| study.name == name)
}

impl Study {
    /// Runs the study, in one thread unless [`Settings::threads`] is given; `sink` receives the progress.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`] if [`Settings::cancel`] was raised, [`StudyError::Setting`] for invalid settings; other
    /// variants for errors of the engine.
    pub fn run(&self, settings: &Settings, sink: &mut dyn ProgressSink) -> Result<Report, StudyError> {
        (self.run)(settings, &mut StudyProgress::new(sink))
    }
}

/// Settings of a study; `None` selects the study's default.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Random rays or particles, at least 1.
    pub rays: Option<u64>,
    /// Pictures: width and height, pixels.
    pub size: Option<[u32; 2]>,
    /// Numbers of triangles per surface, each twice a square.
    pub triangles: Option<Vec<u64>>,
    /// Scene files, or names of those in `scenes/rooms` of the working folder.
    pub rooms: Option<Vec<String>>,
    /// Methods to compare with `path`: `tree`, or grids by basis, cells and scale, such as `haar-8-3`.
    pub methods: Option<Vec<String>>,
    /// Samples per pixel at which curves end, a power of two.
    pub samples: Option<u32>,
    /// Samples per pixel of the reference pictures, at least 1.
    pub references: Option<u32>,
    /// Largest number of elements of a solution by form factors of all pairs, at least 1.
    pub elements: Option<u32>,
    /// Number of runs of each method, with different seeds; at least 1.
    pub rounds: Option<u32>,
    /// Render time of each picture of the side-by-side comparison, seconds, above 0.
    pub seconds: Option<f64>,
    /// Threads, at least 1.
    pub threads: Option<usize>,
    /// Whether to repeat all measurements of the document, which takes many hours.
    pub full: bool,
    /// Folder in which a study may cache results, to continue after an interruption.
    pub cache: Option<PathBuf>,
    /// Seed of random numbers.
    pub seed: u64,
    /// Ends the study when it is raised.
    pub cancel: CancelFlag,
}

/// Passes the progress of a study to its sink.
pub(crate) struct StudyProgress<'a> {
    sink: &'a mut dyn ProgressSink,
    begun: Instant,
}

impl<'a> StudyProgress<'a> {
    /// Progress of a study that begins now.
    pub(crate) fn new(sink: &'a mut dyn ProgressSink) -> Self {
        Self { sink, begun: Instant::now() }
    }

    /// Reports that `fraction` of the work, [0, 1], is done and `phase` comes next.
    pub(crate) fn report(&mut self, fraction: f64, phase: &str) {
        self.sink.on_progress(&JobProgress::by_work(phase, fraction, self.begun.elapsed()));
    }
}

/// Errors of a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The study was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// An invalid setting.
    #[error("{name} is {value}; it must be {needed}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: String,
        /// The valid values.
        needed: &'static str,
    },
    /// A scene file with faults.
    #[error("{0}")]
    Unreadable(String),
    /// A cached file that cannot be continued from.
    #[error("{path}: {why}; remove the file to start anew")]
    Cache {
        /// Its path.
        path: String,
        /// The fault.
        why: String,
    },
    /// A surface was refused.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A density was refused.
    #[error(transparent)]
    Density(#[from] DensityError),
    /// A scene was not divided.
    #[error(transparent)]
    Elements(#[from] ElementError),
    /// A floor was not divided.
    #[error(transparent)]
    Quadtree(#[from] QuadtreeError),
    /// Samples were not interpolated.
    #[error(transparent)]
    Reconstruct(#[from] ReconstructError),
    /// A list of patches was refused.
    #[error(transparent)]
    Patches(#[from] NewellError),
    /// A wall was not divided.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// Lamps that cannot be integrated.
    #[error(transparent)]
    Integrate(#[from] IntegrateError),
    /// Particles could not be sent.
    #[error(transparent)]
    Particles(#[from] ThreadsError),
    /// A scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A film was refused.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A filter was refused.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// An integrator was refused.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// A render failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture lacks a channel.
    #[error(transparent)]
    Pixels(#[from] PixelsError),
    /// Pictures cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A picture could not be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A file could not be written.
    #[error("{path}: {source}")]
    File {
        /// Its path.
        path: String,
        /// The fault.
        source: std::io::Error,
    },
}

impl From<WriteError> for StudyError {
    fn from(WriteError { path, source }: WriteError) -> Self {
        Self::File { path: path.display().to_string(), source }
    }
}

#[cfg(test)]
mod tests {
    use glanz_job::Silent;

    use super::*;

    #[test]
    fn studies_have_names_of_their_own_and_are_found_by_them() {
        for (i, study) in studies().iter().enumerate() {
            assert!(std::ptr::eq(named(study.name).unwrap(), study));
            assert!(studies()[..i].iter().all(|other| other.name != study.name));
            assert!(!study.description.contains('\n') && study.description.len() < 110);
        }
        assert!(named("alchemy").is_none());
    }

    #[test]
    fn a_raised_flag_ends_every_study() {
        let settings = Settings::default();
        settings.cancel.cancel();
        for study in studies() {
            let ended = study.run(&settings, &mut Silent);
            assert!(matches!(ended, Err(StudyError::Interrupted(_))), "{}", study.name);
        }
    }
}
