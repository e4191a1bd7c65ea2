#![doc = include_str!("../README.md")]

pub mod boundary;
pub mod carrier;
pub mod curve;
pub mod error;
pub mod face;
pub mod model;
pub mod parameter_curve;
mod quadrature;

pub use carrier::{Carrier, CarrierConversion, CarrierProjection, Pole};
pub use curve::EdgeCurve;
pub use error::BrepError;
pub use parameter_curve::{EdgeParameterCurve, ParameterCurveSource, edge_on_carrier};
