//! Multiresolution analyses: nested spaces V^0, V^1, ... on [0, 1], and the wavelets between them.
//!
//! [`MultiResolution`] has the scaling bases of Haar or of B-splines with semiorthogonal wavelets of minimal support, and a
//! [`FilterBank`] between neighbouring levels; it transforms coefficients along one axis.
//!
//! # Source
//! @pietrek2001 appendix C.

mod analysis;
mod filter_bank;
mod wavelets;

pub use analysis::MultiResolution;
pub use filter_bank::FilterBank;
