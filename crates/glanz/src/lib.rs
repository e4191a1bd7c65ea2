#![doc = include_str!("../README.md")]
//!
//! # From a scene to a result
//! [`open`] reads a scene file, [`open_str`] a text, [`LoadedScene::from_description`] takes a description built in code. The
//! [`LoadedScene`] holds the warnings of reading and has four jobs, each a builder that ends with `run`:
//!
//! | job | result |
//! |---|---|
//! | [`LoadedScene::render`] | a [`Picture`]: pixels, picture files, a checkpoint |
//! | [`LoadedScene::bake`] | a [`BakeOutcome`]: light maps, and a model that shows them |
//! | [`LoadedScene::illuminate`] | an [`IlluminateOutcome`]: lux maps with errors, reports |
//! | [`LoadedScene::optimize`] | an [`OptimizedScene`], whose light is as wanted |
//!
//! [`LoadedScene::tessellate`] makes a [`MeshOutcome`] of it: triangles, to be saved as glTF, OBJ or PLY. [`LoadedScene::save_exact`] writes a model as
//! a scene file.
//!
//! Every job reports progress to a [`ProgressSink`](job::ProgressSink) and warnings as a [`JobEvent`], ends when its
//! [`CancelFlag`](job::CancelFlag) is raised, and saves its state in a checkpoint from which it resumes to the same bits.
//! [`merge`] joins the checkpoints of parts of a job. An [`Error`] states the facts; advice is left to the program.
//!
//! # The parts
//! The jobs use the following parts, which can be used alone: [`formats`] reads scene files into a
//! [`Description`](scene::Description), [`scene`] checks it and intersects rays, [`transport`] renders, [`radiosity`] and [`illumination`] compute the
//! light on surfaces. [`geometry`] has the surfaces and the hierarchy over their boxes, [`shading`] materials and textures, [`light`] spectra,
//! colour and pictures in memory, [`sampling`] sequences and densities, [`math`] vectors, transforms and roots of polynomials.
//! Lengths are metres and angles radians; positions are `f64`, light is `f32`, sums are exact.
//!
//! # Features
//! | feature | adds |
//! |---|---|
//! | `formats` | scene files, picture files, models |
//! | `denoise` | removal of noise from pictures and from views of the page, if Open Image Denoise is installed |
//! | `radiosity` | light maps, and the integrator that shows them |
//! | `illumination` | lux maps |
//! | `viewer` | the page that shows a scene, and its server (not among the defaults) |
//!
//! Without features the engine renders scenes that are built in code.

#[cfg(feature = "formats")]
mod axes;
#[cfg(feature = "radiosity")]
mod bake;
#[cfg(feature = "formats")]
mod convert;
mod error;
mod event;
pub mod file;
#[cfg(feature = "illumination")]
mod illuminate;
mod job_options;
#[cfg(all(feature = "denoise", feature = "viewer"))]
mod library_denoiser;
mod loaded_scene;
mod merge;
#[cfg(feature = "illumination")]
mod optimize;
#[cfg(feature = "viewer")]
mod overlay;
mod render;
mod running_job;
#[cfg(feature = "radiosity")]
pub use bake::{BakeBuilder, BakeOutcome, LightFile, LightState};
#[cfg(all(feature = "radiosity", feature = "formats"))]
pub use bake::{ModelFiles, ModelSettings, check_model_path, page_path};
#[cfg(feature = "formats")]
pub use convert::{ChordalDeviation, MeshOutcome, MeshSettings, SolidCounts, is_exact_path, material_path};
pub use error::{Error, FileFault};
pub use event::{JobEvent, ResumedState, Warning};
#[cfg(feature = "illumination")]
pub use illuminate::{
    IlluminateBuilder, IlluminateMethod, IlluminateOptions, IlluminateOutcome, JoinedTally,
};
#[cfg(feature = "viewer")]
pub use illuminate::{LuxFolder, PlacedLux, is_lux_folder, lux_folder_content_hash};
#[cfg(all(feature = "illumination", feature = "formats"))]
pub use illuminate::{
    SavedRays, check_far_field_path, check_ray_path, comparison_folders, comparison_paths, save_comparison,
};
pub use job_options::JobOptions;
#[cfg(all(feature = "denoise", feature = "viewer"))]
pub use library_denoiser::LibraryDenoiser;
pub use loaded_scene::LoadedScene;
pub use merge::{JoinError, MergeOptions, MergeOutcome, MissingPart, MissingParts, PartKind, merge};
#[cfg(feature = "illumination")]
pub use optimize::{OptimizeBuilder, OptimizedScene};
#[cfg(feature = "viewer")]
pub use overlay::LightOverlay;
#[cfg(feature = "formats")]
pub use render::picture_format;
pub use render::{
    Darkness, EdgeLines, MAX_LINE_WIDTH, Picture, RenderBuilder, RenderOptions, RenderPlan, RenderStatistics,
};

#[cfg(feature = "denoise")]
#[doc(inline)]
pub use glanz_denoise as denoise;
#[cfg(feature = "formats")]
#[doc(inline)]
pub use glanz_formats as formats;
#[doc(inline)]
pub use glanz_geometry as geometry;
#[cfg(feature = "illumination")]
#[doc(inline)]
pub use glanz_illumination as illumination;
#[doc(inline)]
pub use glanz_job as job;
#[doc(inline)]
pub use glanz_light as light;
#[doc(inline)]
pub use glanz_math as math;
#[cfg(feature = "radiosity")]
#[doc(inline)]
pub use glanz_radiosity as radiosity;
#[doc(inline)]
pub use glanz_report as report;
#[doc(inline)]
pub use glanz_sampling as sampling;
#[doc(inline)]
pub use glanz_scene as scene;
#[doc(inline)]
pub use glanz_shading as shading;
#[doc(inline)]
pub use glanz_transport as transport;
#[cfg(feature = "viewer")]
#[doc(inline)]
pub use glanz_viewer as viewer;

/// Reads the scene file `path`, and all files it refers to, within the [limits](job::ResourceLimits) of the machine.
///
/// # Errors
/// [`Error::Scene`] with the faults and their places.
#[cfg(feature = "formats")]
pub fn open(path: impl AsRef<std::path::Path>) -> Result<LoadedScene, Error> {
    open_with(path, &formats::Options::default())
}

/// As [`open`], with options: whether repairs are errors, where files are found, limits of what reading and preparing the scene may use, and a flag that ends it.
///
/// # Errors
/// [`Error::Scene`] with the faults and their places, or with the limit that was reached; [`Error::Interrupted`].
#[cfg(feature = "formats")]
pub fn open_with(
    path: impl AsRef<std::path::Path>,
    options: &formats::Options,
) -> Result<LoadedScene, Error> {
    let path = path.as_ref();
    let loaded = formats::load(path, options).map_err(Error::of_reading)?;
    Ok(LoadedScene::from_loaded(path.display().to_string(), loaded, options.strict))
}

/// Reads a scene from `text`. `name`: its name in messages. Files it refers to are found in [`formats::Options::folder`] only.
///
/// # Errors
/// [`Error::Scene`] with the faults and their places.
#[cfg(feature = "formats")]
pub fn open_str(name: &str, text: &str, options: &formats::Options) -> Result<LoadedScene, Error> {
    open_bytes(name, text.as_bytes().to_vec(), options)
}

/// As [`open_str`], of the bytes of a scene file or a model, whose content shows its format.
///
/// # Errors
/// [`Error::Scene`] with the faults and their places; [`Error::Interrupted`] if reading was cancelled.
#[cfg(feature = "formats")]
pub fn open_bytes(name: &str, bytes: Vec<u8>, options: &formats::Options) -> Result<LoadedScene, Error> {
    let loaded = formats::load_bytes(name, bytes, options).map_err(Error::of_reading)?;
    Ok(LoadedScene::from_loaded(name.to_owned(), loaded, options.strict))
}
