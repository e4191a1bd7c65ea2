#![doc = include_str!("../README.md")]

pub mod boundary;
pub mod carrier;
pub mod curve;
pub mod error;
pub mod model;

pub use carrier::{Carrier, CarrierConversion, CarrierProjection, Pole};
pub use curve::EdgeCurve;
pub use error::BrepError;
