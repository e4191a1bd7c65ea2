//! How much light: spectra, colour, units, tone curves, pixel buffers and their comparison.
//!
//! - [`Spectrum`] is light or reflectance along one path: a few `f32` lanes whose meaning travels as [`Wavelengths`].
//!   Integrators, materials and lights do arithmetic with it and never read a lane.
//! - [`SpectralDistribution`] is what a scene states: a constant, a colour, a black body, measured samples. It becomes
//!   a `Spectrum` when the wavelengths are known. [`named`] has the metals, glasses and illuminants with a name,
//!   [`cie`] the tables behind it all.
//! - [`rgb`] converts between CIE XYZ, linear Rec. 709 and sRGB; [`units`] between watts and lumens.
//! - [`intensity`] is candela over directions, the light of luminaires.
//! - [`Pixels`] is a picture of named planes, [`Tone`] brings it to a display.
//! - [`compare`] and [`flip`] say how far a picture is from a reference.
//!
//! ```
//! use glanz_light::compare::{compare, RELATIVE_EPSILON};
//! use glanz_light::{named, Pixels, SpectralDistribution, Tone, Wavelengths};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A lamp of 2700 K with luminance 1 shines on a red wall.
//! let wavelengths = Wavelengths::Rgb;
//! let lamp = SpectralDistribution::try_blackbody(2700.0, 1.0)?;
//! let light = lamp.radiance(&wavelengths) * (1.0 / lamp.luminance());
//! let wall = SpectralDistribution::try_sampled(vec![(580.0, 0.1), (620.0, 0.8)])?;
//! let seen = light * wall.reflectance(&wavelengths);
//!
//! // Warmer than under daylight: more red, less blue.
//! let daylight = named::spectrum("stdillum-D65").ok_or("no daylight")?.radiance(&wavelengths);
//! let expected = daylight * wall.reflectance(&wavelengths);
//! let (seen, expected) = (seen.to_rgb(&wavelengths), expected.to_rgb(&wavelengths));
//! assert!(seen[0] > expected[0] && seen[2] < expected[2]);
//!
//! let test = Pixels::try_from_rgb(1, 1, &[seen])?;
//! let reference = Pixels::try_from_rgb(1, 1, &[expected])?;
//! assert!(compare(&test, &reference, RELATIVE_EPSILON)?.rmse > 0.1);
//! assert_eq!(Tone::default().picture_to_srgb8(&test).map(|bytes| bytes.len()), Some(3));
//! # Ok(())
//! # }
//! ```

pub mod cie;
pub mod compare;
pub mod distribution;
pub mod flip;
pub mod intensity;
pub mod named;
pub mod pixels;
pub mod rgb;
pub mod spectrum;
pub mod tone;
pub mod units;

pub use compare::{CompareError, Comparison};
pub use distribution::{DistributionError, Samples, SpectralDistribution};
pub use flip::FlipMap;
pub use pixels::{Channel, Pixels, PixelsError};
pub use spectrum::{Spectrum, Wavelengths};
pub use tone::{Tone, ToneCurve};
