//! Conversion between watts and lumens.
//!
//! Light is radiometric in Glanz: a lane of a [`Spectrum`] holds W, W/m^2, W/sr or W/(m^2 sr). A photometric value
//! is the luminance (CIE Y) of that spectrum times [`LUMINOUS_EFFICACY`].

use crate::{Spectrum, Wavelengths};

/// Lumens per watt at 540 THz, K_cd: exact by the definition of the candela (@bipm2019). For a [`Spectrum`] it
/// multiplies the luminance, so that a watt of white light counts as a watt at the peak of the eye's sensitivity, as
/// usual in renderers.
pub const LUMINOUS_EFFICACY: f64 = 683.0;

/// Photometric value of a spectrum: lm, lm/m^2, cd or cd/m^2 for W, W/m^2, W/sr or W/(m^2 sr).
#[must_use]
pub fn photometric(radiometric: Spectrum, wavelengths: &Wavelengths) -> f64 {
    LUMINOUS_EFFICACY * f64::from(radiometric.luminance(wavelengths))
}

/// The factor that gives the spectrum `shape` the photometric value `target`; `None` if `shape` has no positive,
/// finite luminance.
#[must_use]
pub fn scale_to_photometric(shape: Spectrum, wavelengths: &Wavelengths, target: f64) -> Option<f64> {
    let unscaled = photometric(shape, wavelengths);
    (unscaled > 0.0 && unscaled.is_finite()).then(|| target / unscaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_watt_of_white_is_683_lumens() {
        let lumens = photometric(Spectrum::ONE, &Wavelengths::Rgb);
        assert!((lumens - 683.0).abs() < 1e-3, "{lumens}");
    }

    #[test]
    fn scaled_spectrum_has_the_wanted_photometric_value() {
        let shape = Spectrum::from_rgb([0.3, 0.1, 2.0]);
        let factor = scale_to_photometric(shape, &Wavelengths::Rgb, 1000.0).unwrap();
        let lumens = photometric(shape * factor as f32, &Wavelengths::Rgb);
        assert!((lumens - 1000.0).abs() < 1e-3, "{lumens}");
        assert_eq!(scale_to_photometric(Spectrum::BLACK, &Wavelengths::Rgb, 1.0), None);
    }
}
