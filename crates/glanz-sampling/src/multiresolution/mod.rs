//! Multiresolution analyses: nested spaces V^0, V^1, ... on [0, 1], and the wavelets between them.
//!
//! [`MultiResolution`] holds Haar's or B-splines' scaling bases with semiorthogonal wavelets of minimal support and a
//! [`Step`] of filters between neighbouring levels; it transforms coefficients along one axis. [`plane`] has the two ways to
//! do so along two.
//!
//! # Source
//! @pietrek2001 appendix C.

mod analysis;
pub mod plane;
mod step;
mod wavelets;

pub use analysis::MultiResolution;
pub use step::Step;
