//! Errors of the engine.
//!
//! One file in spite of its length: one noun, a variant per fault with its sentence, and the conversions from the errors of all crates.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glanz_job::{
    BudgetError, CheckpointLockError, IdentityMismatch, Interrupted, IoFault, JobPart, ScratchFileError,
};
use glanz_scene::description::GuideSettings;
#[cfg(feature = "formats")]
use glanz_scene::tessellation::TessellationError;
use glanz_scene::{Diagnostic, Diagnostics, SceneError, Severity};
use glanz_transport::codec::EnvelopeError;
use glanz_transport::{CheckpointError, FilmError, GridError, GuideFileError, RenderError};

use crate::merge::JoinError;
use crate::render::Picture;

/// Error of the engine: the facts, without advice.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene that was refused, with the places of the faults in its file.
    #[error("{}", .0.to_string().trim_end())]
    Scene(Diagnostics),
    /// A model, which has no lights, for a job that needs them.
    #[error("{name}: a model has no lights; {job} needs a scene")]
    NoScene {
        /// Name of the model.
        name: String,
        /// The job.
        job: &'static str,
    },
    /// A scene where a model is needed.
    #[error("{name}: a scene cannot be written as a scene file; only models can")]
    NoModel {
        /// Name of the scene.
        name: String,
    },
    /// A file that cannot be read or written, or has the wrong content.
    #[error("{}: {fault}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The fault.
        fault: FileFault,
    },
    /// A guide for an integrator that has none.
    #[error("the integrator \"{integrator}\" has no guide")]
    NoGuide {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// Stored light for an integrator that computes light itself.
    #[error("the integrator \"{integrator}\" shows no stored light")]
    NoStoredLight {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// No stored light for an integrator that shows it: this library was built without the feature `radiosity`.
    #[error("the integrator \"{integrator}\" needs stored light")]
    LightRequired {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// A number of branches for an integrator that does not use it.
    #[error("the integrator \"{integrator}\" has no number of branches")]
    Branching {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// Light sampling is disabled for an integrator that always samples lights.
    #[error("the integrator \"{integrator}\" samples all lights")]
    LightSampling {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// Samples beyond those planned, of a sampler that divides the pixel by their number.
    #[error("samples {}..{} go beyond the {planned} of each pixel", range.start, range.end)]
    SampleRange {
        /// The requested samples.
        range: Range<u32>,
        /// Number of samples planned per pixel.
        planned: u32,
        /// Name of the sampler.
        sampler: &'static str,
    },
    /// Samples out of order for an integrator that learns or a picture with a noise level, whose samples depend on earlier ones.
    #[error("samples depend on earlier ones and are taken in order; the next is {next}")]
    SampleOrder {
        /// First requested sample.
        start: u32,
        /// The next sample in order.
        next: u32,
    },
    /// Parts of a picture for an integrator that learns or a picture with a noise level, whose samples depend on earlier ones.
    #[error("samples depend on earlier ones, so that they cannot be divided into parts")]
    OrderedParts,
    /// More parts than samples.
    #[error("the samples {}..{} of each pixel make at most {} parts", samples.start, samples.end, samples.len())]
    Parts {
        /// The requested part.
        part: JobPart,
        /// The samples to divide.
        samples: Range<u32>,
    },
    /// A part of a computation that has none.
    #[error("{what} is one computation, which has no parts")]
    Indivisible {
        /// The computation.
        what: &'static str,
    },
    /// A part of a job that does not end after a number of samples or particles.
    #[error(
        "a part is a share of a number of samples or particles, which has to be given, without a time or an error"
    )]
    PartGoal,
    /// A film of the requested size cannot be created.
    #[error("the picture cannot be rendered: {0}")]
    Film(FilmError),
    /// The render loop ended without a picture.
    #[error("the render stopped: {0}")]
    Render(RenderError),
    /// Parts that cannot be joined.
    #[error(transparent)]
    Join(Box<JoinError>),
    /// A guide that cannot be created.
    #[error(transparent)]
    Guide(#[from] GridError),
    /// The picture is complete, but its checkpoint or its guide was not written, or its noise was not removed.
    #[error("{error}")]
    Unsaved {
        /// The picture, which can still be saved.
        picture: Box<Picture>,
        /// The error.
        error: Box<Error>,
    },
    /// A noise level out of range.
    #[error("the noise level is {error}; it must be from 0.000001 to 1")]
    NoiseLevel {
        /// The relative standard error.
        error: f64,
    },
    /// A noise level for an integrator whose samples depend on other pixels.
    #[error(
        "the integrator \"{integrator}\" cannot take more samples in some parts of the picture than in others"
    )]
    NoiseOf {
        /// Name of the integrator.
        integrator: &'static str,
    },
    /// Noise that cannot be removed.
    #[cfg(feature = "denoise")]
    #[error(transparent)]
    Denoise(#[from] glanz_denoise::DenoiseError),
    /// Light maps that cannot be baked.
    #[cfg(feature = "radiosity")]
    #[error(transparent)]
    Bake(glanz_radiosity::bake::BakeError),
    /// A scene that cannot be divided into elements.
    #[cfg(feature = "radiosity")]
    #[error("the scene cannot be divided: {0}")]
    Elements(#[from] glanz_radiosity::elements::ElementError),
    /// Planes of numbers that are not a picture.
    #[error(transparent)]
    Pixels(#[from] glanz_light::PixelsError),
    /// A picture of a model that cannot be encoded.
    #[cfg(feature = "formats")]
    #[error("the model: {0}")]
    Image(#[from] glanz_formats::image::ImageError),
    /// Settings of triangles that are out of range.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Tessellation(TessellationError),
    /// A scene without shapes of which triangles could be made.
    #[cfg(feature = "formats")]
    #[error("{scene}: nothing in this scene can be made of triangles")]
    NoTriangles {
        /// Name of the scene.
        scene: String,
    },
    /// A scene without receivers.
    #[cfg(feature = "illumination")]
    #[error("{scene}: nothing in this scene receives light")]
    NoReceiver {
        /// Name of the scene.
        scene: String,
    },
    /// A scene without lights.
    #[cfg(feature = "illumination")]
    #[error("{scene}: nothing in this scene gives light")]
    NoLight {
        /// Name of the scene.
        scene: String,
    },
    /// More cells than can be counted.
    #[cfg(feature = "illumination")]
    #[error("{scene}: {cells} cells are more than {limit}")]
    Cells {
        /// Name of the scene.
        scene: String,
        /// Cells of all receivers.
        cells: usize,
        /// Largest number of cells.
        limit: usize,
    },
    /// A relative error too small to be reached.
    #[cfg(feature = "illumination")]
    #[error("a relative error of {error} is less than {smallest}, which no run reaches")]
    Accuracy {
        /// Requested relative standard error.
        error: f64,
        /// Smallest valid value.
        smallest: f64,
    },
    /// A shape that cannot receive light.
    #[cfg(feature = "illumination")]
    #[error("{scene}: {error}")]
    Receiver {
        /// Name of the scene.
        scene: String,
        /// The fault of the receiver.
        error: glanz_illumination::ReceiverError,
    },
    /// Lights that cannot be integrated.
    #[cfg(feature = "illumination")]
    #[error(transparent)]
    Integrate(#[from] glanz_illumination::integrate::IntegrateError),
    /// Figures of planners that cannot be computed.
    #[cfg(feature = "illumination")]
    #[error(transparent)]
    Planning(#[from] glanz_illumination::planning::PlanningError),
    /// A scene without a task for an inverse design, or with one that is not supported.
    #[cfg(feature = "illumination")]
    #[error("{scene}: {error}")]
    Optimize {
        /// Name of the scene.
        scene: String,
        /// The fault.
        error: Box<glanz_illumination::optimize::OptimizeError>,
    },
    /// Directions of light that were not counted.
    #[cfg(feature = "illumination")]
    #[error("the directions of light that leaves the scene are not counted; only traced particles have them")]
    NoFarField,
    /// A ray file of a calculation that does not end after a number of particles, or traces none.
    #[cfg(feature = "illumination")]
    #[error(
        "a ray file needs traced particles and their number as the only goal; this calculation has another goal, is a part, or traces none"
    )]
    RayGoal,
    /// A ray file of a calculation that does not keep its scene.
    #[cfg(feature = "illumination")]
    #[error("the calculation did not keep its scene for a ray file, or was interrupted")]
    NoRayFile,
    /// A rating by the direct light of an integration.
    #[cfg(feature = "illumination")]
    #[error(
        "integration leaves out the light between surfaces, without which a rating by standards would be wrong; choose another method"
    )]
    DirectRating,
    /// A rating by the light of the sky alone.
    #[cfg(feature = "illumination")]
    #[error(
        "requirements of standards are not those of light from the sky alone; leave out daylight, or the plan, the task and the maintenance factor"
    )]
    DaylightRating,
    /// A model that the page cannot show.
    #[cfg(feature = "viewer")]
    #[error(transparent)]
    Model(#[from] glanz_viewer::model::ModelError),
    /// Threads that cannot be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The job was cancelled before it had a result. Its checkpoint was written, if the job has checkpoints.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Fault of a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// It cannot be read or written.
    #[error("{}", IoFault::sentence(.0))]
    Io(#[from] io::Error),
    /// It cannot be created or replaced, as a check before the work has shown.
    #[error("cannot be written: {}", IoFault::sentence(.0))]
    NotWritable(io::Error),
    /// A folder that cannot be created.
    #[error("cannot be made: {}", IoFault::sentence(.0))]
    NotMade(io::Error),
    /// Its folder does not exist.
    #[error("there is no folder {}", .0.display())]
    NoFolder(PathBuf),
    /// It is an output that is an input of the same command.
    #[error("this is an input, which would be replaced; choose another name")]
    IsInput,
    /// It is another output of the same command.
    #[error("two outputs of the command are this file; choose another name")]
    IsOutput,
    /// It is a folder.
    #[error("this is a folder, not a file")]
    IsFolder,
    /// It is write-protected.
    #[error("this file is write-protected")]
    ReadOnly,
    /// It is not a regular file, which its format needs.
    #[error("this is a pipe or a device; a regular file is needed")]
    NotRegular,
    /// A checkpoint that exists, in a job that does not resume it.
    #[error("this checkpoint exists already")]
    Exists,
    /// A checkpoint that another process writes.
    #[error(transparent)]
    Lock(#[from] CheckpointLockError),
    /// Its extension is not that of a supported output format.
    #[error("no format for {0} has this extension")]
    Extension(&'static str),
    /// A format that cannot hold the triangles.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Tessellated(#[from] glanz_formats::tessellated::TessellatedError),
    /// A model that the scene language cannot describe.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    SceneText(#[from] glanz_formats::pbrt::PbrtWriteError),
    /// A scene file whose free numbers cannot be replaced.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Rewrite(#[from] glanz_formats::pbrt::RewriteError),
    /// Another kind or version of file, or a damaged one.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// It is undamaged, but its content is invalid.
    #[error("{0} makes no sense")]
    Content(&'static str),
    /// It is not a checkpoint of a picture.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// It is not a guide.
    #[error(transparent)]
    Guide(#[from] GuideFileError),
    /// A checkpoint of another job.
    #[error(transparent)]
    Identity(#[from] IdentityMismatch),
    /// A guide of another kind than the integrator's.
    #[error("this guide is {found}, not {wanted}")]
    GuideSettings {
        /// Its kind.
        found: GuideSettings,
        /// That of the integrator.
        wanted: GuideSettings,
    },
    /// Baked light of another scene or version.
    #[error("{0}")]
    OtherLight(IdentityMismatch),
    /// Baked light of which a part is missing.
    #[error("the bake of this light is not finished")]
    UnfinishedLight,
    /// A picture that cannot be encoded or decoded.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Image(#[from] glanz_formats::image::ImageError),
    /// A model that cannot be encoded.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Model(#[from] glanz_formats::glb::GlbError),
    /// Luminous intensities that do not form a distribution.
    #[error(transparent)]
    Intensity(#[from] glanz_light::intensity::IntensityError),
    /// A candela distribution that cannot be encoded.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Photometry(#[from] glanz_formats::photometry::write::PhotometryWriteError),
    /// A report that cannot be parsed.
    #[cfg(feature = "formats")]
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A picture that differs from the lux map listed in the report beside it.
    #[error("this is not the lux map that the report lists")]
    OtherLuxMap,
    /// Lux maps of other receivers than those of the scene.
    #[error("these lux maps are of other receivers than those of the scene")]
    OtherReceivers,
}

impl FileFault {
    /// Whether it is a file of another kind than one of Glanz's own.
    #[must_use]
    pub fn is_foreign(&self) -> bool {
        use EnvelopeError::Foreign;
        matches!(
            self,
            Self::Envelope(Foreign(_))
                | Self::Checkpoint(CheckpointError::Envelope(Foreign(_)))
                | Self::Guide(GuideFileError::Envelope(Foreign(_)))
        )
    }

    /// The fault as an error of the file `path`.
    pub(crate) fn of(self, path: &Path) -> Error {
        Error::File { path: path.to_owned(), fault: self }
    }
}

impl Error {
    /// The faults of reading a scene, or that it was cancelled.
    #[cfg(feature = "formats")]
    pub(crate) fn of_reading(diagnostics: Diagnostics) -> Self {
        match diagnostics.end() {
            Some(BudgetError::Interrupted) => Interrupted.into(),
            _ => Self::Scene(diagnostics),
        }
    }

    /// Whether options exclude each other, do not fit the scene, or name files that cannot serve for it.
    #[must_use]
    pub fn is_of_options(&self) -> bool {
        match self {
            Self::NoGuide { .. }
            | Self::NoStoredLight { .. }
            | Self::LightSampling { .. }
            | Self::Branching { .. }
            | Self::SampleRange { .. }
            | Self::SampleOrder { .. }
            | Self::OrderedParts
            | Self::Indivisible { .. }
            | Self::PartGoal
            | Self::Parts { .. }
            | Self::NoiseLevel { .. }
            | Self::NoiseOf { .. }
            | Self::NoModel { .. }
            | Self::Accuracy { .. } => true,
            Self::File { fault, .. } => {
                use FileFault::{Extension, IsInput, IsOutput, NotRegular};
                matches!(fault, Extension(_) | IsInput | IsOutput | NotRegular)
            }
            #[cfg(feature = "illumination")]
            Self::RayGoal | Self::NoRayFile => true,
            _ => false,
        }
    }

    /// An error of the file `path`.
    pub(crate) fn of_file<F: Into<FileFault>>(path: &Path) -> impl FnOnce(F) -> Self + '_ {
        move |fault| fault.into().of(path)
    }
}

impl From<JoinError> for Error {
    fn from(error: JoinError) -> Self {
        Self::Join(Box::new(error))
    }
}

impl From<SceneError> for Error {
    fn from(SceneError { location, kind }: SceneError) -> Self {
        let (file, message) = (String::new(), kind.to_string());
        let mut diagnostics = Diagnostics::default();
        diagnostics.push(Diagnostic {
            severity: Severity::Error,
            kind: "scene",
            file,
            location,
            message,
            excerpt: None,
            help: None,
        });
        Self::Scene(diagnostics)
    }
}

#[cfg(feature = "formats")]
impl From<TessellationError> for Error {
    fn from(error: TessellationError) -> Self {
        match error {
            TessellationError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Tessellation(error),
        }
    }
}

impl From<FilmError> for Error {
    fn from(error: FilmError) -> Self {
        match error {
            FilmError::Pixels(error) => Self::Pixels(error),
            error => Self::Film(error),
        }
    }
}

impl From<ScratchFileError> for Error {
    fn from(error: ScratchFileError) -> Self {
        Self::Film(error.into())
    }
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Guide(error) => Self::Guide(error),
            RenderError::Film(error) => Self::Film(error),
            RenderError::Threads(error) => Self::Threads(error),
            RenderError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Render(error),
        }
    }
}
