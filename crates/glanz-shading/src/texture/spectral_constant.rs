//! Spectra by wavelength that are the same everywhere.

use glanz_light::{SpectralDistribution, Spectrum, Wavelengths};

/// A spectrum that a scene gives by wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralConstant {
    /// Its values in RGB: as a reflectance, or without upper bound.
    pub rgb: Spectrum,
    /// Its values by wavelength.
    pub distribution: SpectralDistribution,
}

impl SpectralConstant {
    /// Its values at `wavelengths`: in RGB those of [`SpectralConstant::rgb`], else those of the distribution, not clamped.
    #[must_use]
    pub fn at(&self, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Rgb => self.rgb,
            _ => self.distribution.unbounded(wavelengths),
        }
    }
}
