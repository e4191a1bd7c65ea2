#![doc = include_str!("../README.md")]
//!
//! # Modules
//! - [`Receivers`] are grids of cells on surfaces of a scene; [`add_walls`] puts the scene into a room of them;
//! - [`trace()`] traces particles from the lights and sums their flux in a [`Tally`];
//! - [`integrate::Reflections`] integrates over emitters and their images in mirrors, deterministically;
//! - [`combine()`] adds what reaches the receivers in other ways, by paths that start there and by particles, as a [`LightDivision`] says;
//! - [`optimize::optimize()`] moves free numbers of a scene until the reflected light is as wanted;
//! - [`under_overcast_sky`] replaces the light of a scene by daylight, for [`DaylightFactors`];
//! - a [`LuxMap`] holds the illuminance in the cells of a receiver, with errors;
//! - a [`FluxBalance`] holds the emitted, absorbed and lost flux, a [`FarField`] the intensity of light that leaves the scene, by direction
//!   ([`adapted_grid`] chooses the angles), and [`escaped_rays`] passes on its rays;
//! - [`planning`] holds the figures of planners after standards: glare, cylindrical illuminance, verdicts;
//! - [`report`] turns them into tables, pictures, contours and pages.

pub mod balance;
pub mod combine;
pub mod daylight;
mod division;
mod escaped_rays;
pub mod far_field;
mod gather;
pub mod integrate;
pub mod lux_map;
mod lux_parts;
pub mod optimize;
pub mod planning;
pub mod receiver;
mod replicates;
pub mod report;
pub mod room;
mod state;
pub mod tally;
pub mod trace;

pub use balance::FluxBalance;
pub use combine::{CombinedLight, CombinedOutcome, combine};
pub use daylight::{DaylightFactors, under_overcast_sky};
pub use division::LightDivision;
pub use escaped_rays::{EscapedRay, escaped_rays};
pub use far_field::{AngleStep, AngleStepError, FarField, FarFieldGrid, FarFieldResolution, FarFieldSummary};
pub use lux_map::{LuxMap, LuxStatistics, LuxSummary};
pub use lux_parts::IntegratedLux;
pub use receiver::{GridResolution, Receiver, ReceiverError, ReceiverHit, ReceiverRequest, Receivers};
pub use replicates::ReplicateEstimate;
pub use room::add_walls;
pub use tally::Tally;
pub use trace::{ThreadsError, TraceGoal, TraceOutcome, TraceSettings, adapted_grid, trace};
