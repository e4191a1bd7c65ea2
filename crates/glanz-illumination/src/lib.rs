//! How much light arrives where: lux on receivers, from lamps and by way of mirrors (document 000 chapter 4).
//!
//! - a [`LuxMap`] holds illuminance over the cells of a receiver, with errors;
//! - [`integrate::Reflections`] integrates over lamps and their images in mirrors, without chance.

pub mod integrate;
pub mod lux_map;

pub use lux_map::{LuxMap, LuxSummary};
