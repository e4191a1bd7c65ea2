#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! - [`sampler`]: [`PixelSampler`] generates the numbers of one sample of one pixel, dimension by dimension;
//! - [`sequence`]: scrambled Sobol' points; [`hash`]: counter-based random numbers;
//! - [`warp`]: maps from uniform numbers to disks, hemispheres, cones, triangles and lobes, with densities and inverses;
//! - [`SphericalTriangle`]: directions to a triangle, uniform by solid angle;
//! - [`discrete`]: choices by weight and piecewise constant densities;
//! - [`mis`]: the weights of multiple importance sampling;
//! - [`exact`]: sums that do not depend on the order of their terms;
//! - [`statistics`]: chi-square tests of samplers;
//! - [`basis`], [`multiresolution`]: bases of scaled densities on [0, 1], their duals, and wavelets;
//! - [`density`]: densities on the unit cube in such bases, fitted to their own samples from coarse to fine;
//! - [`integrate`](mod@integrate): integrals over the unit cube with their variances, in adaptive passes.
//!
//! There is no hidden state: the same arguments give the same numbers, on any thread, in any order. The fraction of the unit square
//! in a quarter of the unit disk is pi / 4:
//! ```
//! use glanz_sampling::{PixelSampler, SamplerKind};
//!
//! let samples = 1024;
//! let inside = (0..samples)
//!     .map(|i| PixelSampler::new(SamplerKind::Sobol, samples, 7, [3, 4], i).next_2d())
//!     .filter(|p| p.length_squared() < 1.0)
//!     .count();
//! let pi = 4.0 * inside as f64 / f64::from(samples);
//! assert!((pi - std::f64::consts::PI).abs() < 0.03);
//! ```

pub mod basis;
pub mod density;
pub mod discrete;
pub mod error;
pub mod exact;
pub mod hash;
pub mod integrate;
pub mod mis;
pub mod multiresolution;
pub mod sampler;
pub mod sequence;
mod spherical_triangle;
pub mod statistics;
pub mod warp;

#[cfg(test)]
mod reference;

pub use discrete::{AliasTable, DiscreteChoice, PiecewiseConstant1, PiecewiseConstant2, WeightsError};
pub use error::DensityError;
pub use sampler::{PixelSampler, SamplerKind};
pub use spherical_triangle::SphericalTriangle;
