//! Sequences, warps and discrete densities for Monte Carlo integration.
//!
//! - [`sampler`]: [`PixelSampler`] hands out the numbers of one sample of one pixel, dimension by dimension;
//! - [`sequence`]: the scrambled Sobol' points behind it; [`hash`]: the counter-based hashes behind those;
//! - [`warp`]: uniform numbers to disks, hemispheres, cones, triangles, lobes, with densities and inverses;
//! - [`discrete`]: choices by weight and piecewise constant densities;
//! - [`mis`]: the weights of multiple importance sampling;
//! - [`statistics`]: chi-square, for those who test samplers.
//!
//! Nothing here has a state: the same arguments give the same numbers, on any thread, in any order.
//!
//! The share of the unit square under a quarter of a circle is pi / 4:
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

pub mod discrete;
pub mod hash;
pub mod mis;
pub mod sampler;
pub mod sequence;
pub mod statistics;
pub mod warp;

pub use discrete::{AliasTable, Choice, PiecewiseConstant1, PiecewiseConstant2, WeightsError};
pub use sampler::{PixelSampler, SamplerKind};
