//! How much light arrives where: lux on receivers, from lamps and by way of mirrors (document 000 chapter 4).
//!
//! - a [`LuxMap`] holds illuminance over the cells of a receiver, with errors;
//! - [`report`] has what is told of them written with.

pub mod lux_map;
pub mod report;

pub use lux_map::{LuxMap, LuxSummary};
