//! The spectrum of a light whose values are colours.

use crate::distribution::SpectralDistribution;
use crate::spectrum::{Spectrum, Wavelengths};

/// The spectrum of a light that is computed in RGB: colours of its description times factors, perhaps of a picture.
///
/// A light with a spectrum by wavelength emits that spectrum, times the smooth spectrum of the factors; any other the smooth spectrum of its
/// colour under daylight.
#[derive(Clone, Debug, Default)]
pub struct EmissionSpectrum {
    spectral: Option<SpectralEmission>,
}

/// A spectrum by wavelength and its colour.
#[derive(Clone, Debug)]
struct SpectralEmission {
    distribution: SpectralDistribution,
    /// Not negative.
    rgb: [f32; 3],
}

impl EmissionSpectrum {
    /// The spectrum of light that `distribution` describes.
    #[must_use]
    pub fn new(distribution: &SpectralDistribution) -> Self {
        let rgb = distribution.radiance(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb).map(|x| x.max(0.0));
        let has_color = rgb.iter().sum::<f32>() > 0.0;
        let distribution = Some(distribution).filter(|distribution| distribution.is_spectral() && has_color);
        Self { spectral: distribution.map(|d| SpectralEmission { distribution: d.clone(), rgb }) }
    }

    /// The light `rgb` of [`Wavelengths::Rgb`] at `wavelengths`.
    #[inline]
    #[must_use]
    pub fn at(&self, rgb: Spectrum, wavelengths: &Wavelengths) -> Spectrum {
        match (wavelengths, &self.spectral) {
            (Wavelengths::Rgb, _) => rgb,
            (_, None) => rgb.upsampled_light(wavelengths),
            (_, Some(spectral)) => spectral.at(rgb, wavelengths),
        }
    }
}

impl SpectralEmission {
    fn at(&self, light: Spectrum, wavelengths: &Wavelengths) -> Spectrum {
        let light = light.to_rgb(&Wavelengths::Rgb);
        let whole = light.iter().sum::<f32>() / self.rgb.iter().sum::<f32>();
        // A band that the spectrum lacks has no factor of its own.
        let factor = |i: usize| if self.rgb[i] > 0.0 { light[i] / self.rgb[i] } else { whole };
        let factors = Spectrum::from_rgb([factor(0), factor(1), factor(2)]);
        factors.upsampled(wavelengths) * self.distribution.radiance(wavelengths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SampledWavelengths;

    fn sampled() -> Wavelengths {
        Wavelengths::Sampled(SampledWavelengths::sample(0.37))
    }

    fn assert_equal(a: Spectrum, b: Spectrum) {
        assert!((a - b).map(|x| x.abs()).max_component() <= 1e-5 * b.max_component(), "{a:?} {b:?}");
    }

    #[test]
    fn factors_of_a_spectrum_scale_it_everywhere() {
        // 1500 K has a negative blue component, which lights do not have.
        for kelvin in [1500.0, 6000.0] {
            let body = SpectralDistribution::try_blackbody(kelvin, 1.0).unwrap();
            let color = body.radiance(&Wavelengths::Rgb).map(|x| x.max(0.0));
            let found = EmissionSpectrum::new(&body).at(color * 3.0, &sampled());
            assert_equal(found, body.radiance(&sampled()) * 3.0);
        }
    }

    #[test]
    fn pictures_tint_a_spectrum() {
        let body = SpectralDistribution::try_blackbody(3000.0, 1.0).unwrap();
        let tint = Spectrum::from_rgb([0.2, 0.5, 0.9]);
        let found = EmissionSpectrum::new(&body).at(body.radiance(&Wavelengths::Rgb) * tint, &sampled());
        assert_equal(found, body.radiance(&sampled()) * tint.upsampled(&sampled()));
    }

    #[test]
    fn colors_are_those_of_daylight() {
        let color = [0.3, 0.8, 0.1];
        let light = EmissionSpectrum::new(&SpectralDistribution::Rgb(color));
        let found = light.at(Spectrum::from_rgb(color), &sampled());
        assert_equal(found, SpectralDistribution::Rgb(color).radiance(&sampled()));
        assert_eq!(light.at(Spectrum::ONE, &Wavelengths::Rgb), Spectrum::ONE);
        let black = EmissionSpectrum::new(&SpectralDistribution::Constant(0.0));
        assert_eq!(black.at(Spectrum::BLACK, &sampled()), Spectrum::BLACK);
    }
}
