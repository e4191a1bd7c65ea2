//! How much light arrives where: lux on receivers, from lamps and by way of mirrors (document 000 chapter 4).
//!
//! - a [`LuxMap`] holds illuminance over the cells of a receiver, with errors, and a [`FluxBalance`] where light went;
//! - [`report`] tells people and programs of them: tables, pictures, contours, pages.

pub mod balance;
pub mod lux_map;
pub mod report;

pub use balance::FluxBalance;
pub use lux_map::{LuxMap, LuxSummary};
