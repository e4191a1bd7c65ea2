#![doc = include_str!("../README.md")]
//!
//! # Modules
//! - [`Receivers`] are grids of cells on surfaces of a scene; [`add_walls`] puts the scene into a room of them;
//! - [`trace()`] sends particles from the lamps and counts what they bring, in a [`Tally`];
//! - [`integrate::Reflections`] integrates over lamps and their images in mirrors, without chance;
//! - a [`LuxMap`] holds illuminance over the cells of a receiver, with errors;
//! - a [`FluxBalance`] says where the light went, a [`FarField`] in which directions it left the scene;
//! - [`report`] tells people and programs of them: tables, pictures, contours, pages.

pub mod balance;
pub mod far_field;
pub mod integrate;
pub mod lux_map;
pub mod receiver;
pub mod report;
pub mod room;
mod state;
pub mod tally;
pub mod trace;

pub use balance::FluxBalance;
pub use far_field::{FarField, FarFieldGrid};
pub use lux_map::{LuxMap, LuxSummary};
pub use receiver::{GridResolution, Receiver, ReceiverError, ReceiverRequest, Receivers};
pub use room::add_walls;
pub use tally::Tally;
pub use trace::{ThreadsError, TraceGoal, TraceOutcome, TraceSettings, trace};
