#![doc = include_str!("../README.md")]
//!
//! # Modules
//! - [`Integrator`]s estimate the radiance along camera rays; [`INTEGRATORS`] is the table of them;
//! - a [`Filter`] places samples around a pixel;
//! - a [`Film`] sums samples exactly ([`glanz_sampling::exact`]): the picture depends on the set of samples, not on
//!   threads, passes, interruptions or machines;
//! - [`render()`] exposes a film, and reports to a [`RenderSink`];
//! - a [`PhotonMap`] holds light that arrives by mirror or glass, for pictures of caustics;
//! - a [`ParticleTracer`] traces particles from lights, an [`IrradianceTracer`] paths from points, for illuminance;
//! - a [`Guide`] holds the densities of incident light that guided integrators sample;
//! - an [`EdgeLayer`] holds lines along the edges of the scene, which lie over the picture;
//! - a [`Checkpoint`] is a file of a film with its [`PictureIdentity`]; [`merge()`] joins several, a [`FilmJoin`] from their files.

pub mod aov;
mod channels;
pub mod checkpoint;
pub mod codec;
mod edges;
pub mod film;
pub mod filter;
pub mod guide;
pub mod identity;
pub mod integrator;
pub mod merge;
pub mod noise;
pub mod particle;
mod passes;
pub mod photon;
pub mod pixel;
pub mod pixel_rect;
pub mod progress;
pub mod ranges;
pub mod render;
pub mod sample_plan;
pub mod sensor;
mod splat;
mod weighted_sums;
mod word_merge;

pub use aov::{Aov, AovSet};
pub use channels::channel_names;
pub use checkpoint::{Checkpoint, CheckpointError, CheckpointHead};
pub use edges::{EdgeLayer, EdgeStyle, MAX_EDGES};
pub use film::{Film, FilmError, FilmFormat};
pub use filter::{Filter, FilterError};
pub use guide::{GridError, GridGuide, Guide, GuideFileError, GuideSize, Training};
pub use identity::PictureIdentity;
pub use integrator::{
    BRANCHING_LIMIT, Context, ContextOptions, Counters, INTEGRATORS, Integrator, IntegratorEntry,
    IntegratorError, IntegratorSettings, IrradianceTracer, KnownLight, StoredLight,
};
pub use merge::{FilmJoin, MergeChecks, MergeError, merge};
pub use noise::NoiseLevel;
pub use particle::{Arrival, LightRoute, ParticleFate, ParticlePath, ParticleTracer};
pub use photon::{PHOTON_LIMIT, PhotonMap, PhotonTracer};
pub use pixel::{FirstHit, Rejects};
pub use pixel_rect::PixelRect;
pub use progress::{FinishedTile, RenderSink, TileSink};
pub use ranges::{NumberRanges, OverlapError, ParticleRanges, SampleRanges};
pub use render::{RenderError, RenderOutcome, RenderSettings, render};
pub use sample_plan::{MissingSamples, SamplePlan};
pub use sensor::{FilmSensor, SensorError};
