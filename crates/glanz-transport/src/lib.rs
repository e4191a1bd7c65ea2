//! From a scene to a picture: film, filters, integrators, and the loop that brings them together.
//!
//! - [`Integrator`]s estimate the radiance along camera rays; [`INTEGRATORS`] is the table of them;
//! - a [`Filter`] says where around a pixel a sample lies;
//! - a [`Film`] adds samples up, exactly ([`glanz_sampling::exact`]): the picture depends on which samples were taken, not on
//!   threads, passes, interruptions or machines;
//! - [`render()`] exposes a film, telling a [`Progress`] about it;
//! - [`send_particle()`] sends light from lamps, for all who count what arrives;
//! - a [`Guide`] tells integrators that learn where light comes from;
//! - a [`Checkpoint`] is a film in a file with the [`PictureIdentity`] it belongs to; [`merge()`] joins several.
//!
//! A white sphere in a white sky cannot be told from the sky:
//! ```
//! use glanz_job::{CancelFlag, Silent};
//!
//! use glanz_sampling::SamplerKind;
//! use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};
//! use glanz_scene::{Scene, SceneBuilder};
//! use glanz_transport::{Film, FilmFormat, Filter, IntegratorSettings, RenderSettings, render};
//!
//! let description = SceneBuilder::new()
//!     .resolution(16, 16)
//!     .shape(ShapeDescription::sphere(1.0).translated([0.0, 0.0, 3.0]), MaterialKind::diffuse(1.0))
//!     .light(LightDescription::infinite(1.0))
//!     .describe()?;
//! let filter = Filter::try_new(&description.filter)?;
//! let integrator = IntegratorSettings::resolve(&description.integrator)?.build();
//! let film = Film::try_new(FilmFormat::plain(description.film.resolution))?;
//! let (scene, _) = Scene::resolve(description)?;
//! let settings = RenderSettings {
//!     filter,
//!     sampler: SamplerKind::Sobol,
//!     seed: 0,
//!     samples_per_pixel: 4,
//!     samples: 0..4,
//!     threads: 1,
//!     time_limit: None,
//! };
//! let outcome = render(&scene, integrator.as_ref(), &settings, film, &mut Silent, &CancelFlag::default())?;
//! let picture = outcome.film.to_pixels()?;
//! assert!(picture.channel("G").ok_or("no G")?.iter().all(|g| (g - 1.0).abs() < 1e-5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod aov;
mod channels;
pub mod checkpoint;
pub mod codec;
pub mod film;
pub mod filter;
pub mod guide;
pub mod identity;
pub mod integrator;
pub mod merge;
pub mod particle;
mod passes;
pub mod pixel;
pub mod pixel_rect;
pub mod progress;
pub mod ranges;
pub mod render;
mod splat;
mod weighted_sums;

pub use aov::{Aov, AovSet};
pub use checkpoint::{Checkpoint, CheckpointError};
pub use film::{Film, FilmError, FilmFormat};
pub use filter::{Filter, FilterError};
pub use guide::{GridError, GridGuide, Guide, GuideFileError, GuideSize, Training};
pub use identity::PictureIdentity;
pub use integrator::{
    Context, ContextOptions, Counters, INTEGRATORS, Integrator, IntegratorEntry, IntegratorError,
    IntegratorSettings, StoredLight,
};
pub use merge::{MergeError, merge};
pub use particle::{Arrival, ParticleFate, ParticlePath, send_particle};
pub use pixel::{FirstHit, Rejects};
pub use pixel_rect::PixelRect;
pub use progress::{FinishedTile, RenderSink, TileSink};
pub use ranges::{OverlapError, SampleRanges};
pub use render::{RenderError, RenderOutcome, RenderSettings, render};
