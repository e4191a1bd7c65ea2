#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! - [`spectrum`]: [`Spectrum`], light or reflectance along one path, a few `f32` lanes whose meaning is given by [`Wavelengths`]; [`LaneChoice`], a random choice between them;
//! - [`sampled_wavelengths`]: [`SampledWavelengths`], random wavelengths of one path, with colours as smooth spectra there;
//! - [`emission_spectrum`]: [`EmissionSpectrum`], the spectrum of a light whose values are colours;
//! - [`distribution`]: [`SpectralDistribution`], a function of the wavelength: a constant, a colour, a black body, measured samples;
//! - [`named`]: metals, glasses and illuminants with a name; [`cie`]: tables of the standard observer and illuminants;
//! - [`rgb`]: conversion between CIE XYZ, linear Rec. 709 and sRGB; [`units`]: between watts and lumens;
//! - [`intensity`]: candela over directions, the light of luminaires;
//! - [`sky`]: the clear sky and the sun;
//! - [`white_balance`]: adaptation of colours to what looks white;
//! - [`pixels`]: [`Pixels`], a picture of named planes; [`tone`]: [`Tone`], from scene light to the bytes of a display;
//! - [`compare`](mod@compare), [`flip`]: errors of a picture against a reference.

pub mod cie;
pub mod compare;
pub mod distribution;
pub mod emission_spectrum;
pub mod flip;
pub mod intensity;
mod lane_choice;
pub mod named;
pub mod pixels;
pub mod rgb;
mod rgb_primaries;
pub mod sampled_wavelengths;
pub mod sky;
pub mod spectrum;
pub mod tone;
pub mod units;
pub mod white_balance;

pub use compare::{CompareError, PictureComparison};
pub use distribution::{SpectralDistribution, SpectralSamples, SpectrumError};
pub use emission_spectrum::EmissionSpectrum;
pub use flip::FlipMap;
pub use lane_choice::LaneChoice;
pub use pixels::{Channel, Pixels, PixelsError};
pub use sampled_wavelengths::SampledWavelengths;
pub use sky::{ClearSky, SkyError};
pub use spectrum::{Spectrum, Wavelengths};
pub use tone::{Tone, ToneCurve};
