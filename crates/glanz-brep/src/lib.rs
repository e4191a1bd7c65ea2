#![doc = include_str!("../README.md")]

pub mod boundary;
pub mod curve;
pub mod error;
pub mod model;

pub use curve::EdgeCurve;
pub use error::BrepError;
