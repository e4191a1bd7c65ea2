//! How much light: spectra, colour, units, tone curves, pixel buffers and their comparison.

pub mod cie;
pub mod compare;
pub mod distribution;
pub mod flip;
pub mod pixels;
pub mod rgb;
pub mod spectrum;
pub mod tone;
pub mod units;

pub use distribution::{DistributionError, Samples, SpectralDistribution};
pub use pixels::{Channel, Pixels, PixelsError};
pub use spectrum::{Spectrum, Wavelengths};
pub use tone::{Tone, ToneCurve};
