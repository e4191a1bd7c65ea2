//! How much light: spectra, colour, units, tone curves, pixel buffers and their comparison.

pub mod pixels;
pub mod spectrum;

pub use pixels::{Channel, Pixels, PixelsError};
pub use spectrum::{Spectrum, Wavelengths};
