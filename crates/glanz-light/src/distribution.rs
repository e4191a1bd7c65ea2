//! Spectra as functions of the wavelength, as scene descriptions give them.

use std::sync::Arc;

use crate::cie;
use crate::rgb::{luminance, xyz_to_rgb};
use crate::spectrum::{Spectrum, Wavelengths};

/// Errors of making spectra.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// No sample was given.
    #[error("a sampled spectrum has no samples; at least one is needed")]
    Empty,
    /// A wavelength or a value is infinite or NaN.
    #[error("sample {index} of a spectrum is {value} at {nm} nm; both must be finite")]
    NotFinite {
        /// Counted from zero.
        index: usize,
        /// Its wavelength, nm.
        nm: f32,
        /// Its value.
        value: f32,
    },
    /// A wavelength is not above the one before it.
    #[error(
        "sample {index} of a spectrum is at {nm} nm, the one before at {before} nm; wavelengths must ascend"
    )]
    Order {
        /// Counted from zero.
        index: usize,
        /// Its wavelength, nm.
        nm: f32,
        /// The wavelength before, nm.
        before: f32,
    },
    /// The temperature of a black body is not positive and finite.
    #[error("the temperature of a black body is {0} K; it must be positive and finite")]
    Temperature(f32),
    /// The scale of a black body is not finite.
    #[error("the scale of a black body is {0}; it must be finite")]
    Scale(f32),
}

/// Values at ascending wavelengths, linear between them, constant beyond the first and the last.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralSamples(Arc<[(f32, f32)]>);

impl SpectralSamples {
    /// `points`: wavelength in nm and value, at least one, wavelengths ascending.
    ///
    /// # Errors
    /// [`SpectrumError::Empty`], [`SpectrumError::NotFinite`] or [`SpectrumError::Order`].
    pub fn try_new(points: impl Into<Arc<[(f32, f32)]>>) -> Result<Self, SpectrumError> {
        let points = points.into();
        if points.is_empty() {
            return Err(SpectrumError::Empty);
        }
        let mut before = f32::NEG_INFINITY;
        for (index, &(nm, value)) in points.iter().enumerate() {
            if !nm.is_finite() || !value.is_finite() {
                return Err(SpectrumError::NotFinite { index, nm, value });
            }
            if nm <= before {
                return Err(SpectrumError::Order { index, nm, before });
            }
            before = nm;
        }
        Ok(Self(points))
    }

    /// Wavelength in nm and value of each sample, ascending.
    #[must_use]
    pub fn points(&self) -> &[(f32, f32)] {
        &self.0
    }

    /// The value at `nm`.
    #[must_use]
    pub fn at(&self, nm: f64) -> f64 {
        let after = self.0.partition_point(|&(w, _)| f64::from(w) <= nm);
        match (after.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(after)) {
            (Some(&(w0, v0)), Some(&(w1, v1))) => {
                let t = (nm - f64::from(w0)) / (f64::from(w1) - f64::from(w0));
                f64::from(v0) + t * (f64::from(v1) - f64::from(v0))
            }
            (Some(&(_, v)), None) | (None, Some(&(_, v))) => f64::from(v),
            (None, None) => 0.0,
        }
    }

    /// Smallest and largest value.
    #[must_use]
    pub fn range(&self) -> (f32, f32) {
        self.0.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), &(_, v)| (lo.min(v), hi.max(v)))
    }

    /// Whether the value is the same at every wavelength.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        let (low, high) = self.range();
        low == high
    }

    /// Every value times `factor`.
    ///
    /// # Errors
    /// [`SpectrumError::NotFinite`] if a product is out of the range of `f32`.
    pub fn scaled(&self, factor: f32) -> Result<Self, SpectrumError> {
        Self::try_new(self.0.iter().map(|&(w, v)| (w, v * factor)).collect::<Arc<[_]>>())
    }
}

/// A function of the wavelength, independent of the [`Wavelengths`] at which a path carries light.
///
/// It becomes a [`Spectrum`] as a reflectance ([`reflectance`](Self::reflectance)), as emitted light
/// ([`radiance`](Self::radiance)) or as any other quantity, such as an index of refraction
/// ([`unbounded`](Self::unbounded)). Their RGB values differ: those of a reflectance are measured under daylight.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SpectralDistribution {
    /// The same value at every wavelength: grey as a reflectance, white (D65) as light.
    Constant(f32),
    /// Linear Rec. 709 red, green and blue.
    Rgb([f32; 3]),
    /// The light of a black body.
    Blackbody {
        /// Temperature, K; no light unless it is positive.
        kelvin: f32,
        /// Value at the wavelength where the spectrum peaks.
        scale: f32,
    },
    /// Values at wavelengths.
    Sampled(SpectralSamples),
}

impl Default for SpectralDistribution {
    fn default() -> Self {
        Self::Constant(0.0)
    }
}

impl From<f32> for SpectralDistribution {
    fn from(value: f32) -> Self {
        Self::Constant(value)
    }
}

impl From<[f32; 3]> for SpectralDistribution {
    /// Linear Rec. 709.
    fn from(rgb: [f32; 3]) -> Self {
        Self::Rgb(rgb)
    }
}

impl SpectralDistribution {
    /// A sampled spectrum; see [`SpectralSamples::try_new`].
    ///
    /// # Errors
    /// Those of [`SpectralSamples::try_new`].
    pub fn try_sampled(points: impl Into<Arc<[(f32, f32)]>>) -> Result<Self, SpectrumError> {
        SpectralSamples::try_new(points).map(Self::Sampled)
    }

    /// The light of a black body of `kelvin`, with the value `scale` where it peaks.
    ///
    /// # Errors
    /// [`SpectrumError::Temperature`] unless `kelvin` is positive and finite, [`SpectrumError::Scale`] unless
    /// `scale` is finite.
    pub fn try_blackbody(kelvin: f32, scale: f32) -> Result<Self, SpectrumError> {
        if !(kelvin > 0.0 && kelvin.is_finite()) {
            return Err(SpectrumError::Temperature(kelvin));
        }
        if !scale.is_finite() {
            return Err(SpectrumError::Scale(scale));
        }
        Ok(Self::Blackbody { kelvin, scale })
    }

    /// The fraction of light reflected or transmitted, in [0, 1].
    ///
    /// At sampled wavelengths the values there; a colour becomes a smooth spectrum ([`Spectrum::upsampled`]).
    /// In RGB the response of each band under daylight D65, so that a flat spectrum is grey of its value.
    #[must_use]
    pub fn reflectance(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.unbounded(wavelengths).clamp(0.0, 1.0)
    }

    /// A quantity without upper bound, such as an index of refraction or an absorption.
    ///
    /// In RGB as [`reflectance`](Self::reflectance), but clamped to the range of the samples instead of [0, 1]: the
    /// bands of Rec. 709 have negative weights at some wavelengths, which must not make an index negative.
    #[must_use]
    pub fn unbounded(&self, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Sampled(sampled) => match self {
                Self::Constant(value) => Spectrum::splat(*value),
                Self::Rgb(rgb) => sampled.upsampled(Spectrum::from_rgb(*rgb)),
                Self::Blackbody { .. } | Self::Sampled(_) => sampled.evaluate(|nm| self.at(nm)),
            },
            Wavelengths::Rgb => Spectrum::from_rgb(match self {
                Self::Constant(value) => [*value; 3],
                Self::Rgb(rgb) => *rgb,
                Self::Blackbody { .. } => to_f32(under_daylight(|nm| self.at(nm), &[])),
                Self::Sampled(samples) => {
                    let (low, high) = samples.range();
                    to_f32(under_daylight(|nm| samples.at(nm), samples.points())).map(|x| x.clamp(low, high))
                }
            }),
        }
    }

    /// Emitted light, in the unit of the values.
    ///
    /// At sampled wavelengths the values there; a colour becomes a smooth spectrum ([`Spectrum::upsampled_light`]).
    /// In RGB the colour that the CIE 1931 observer sees, as linear Rec. 709, divided by the integral of the
    /// luminosity function: light of the value 1 at every wavelength has the luminance 1. Components may be negative
    /// where a pure colour lies outside Rec. 709.
    ///
    /// # Source
    /// @pbrt3 section 5.2.2 (`FromSampled`); departure: the product of spectrum and observer, both piecewise linear, is
    /// integrated exactly.
    #[must_use]
    pub fn radiance(&self, wavelengths: &Wavelengths) -> Spectrum {
        match wavelengths {
            Wavelengths::Sampled(sampled) => match self {
                Self::Constant(_) | Self::Rgb(_) => self.unbounded(wavelengths) * sampled.daylight(),
                Self::Blackbody { .. } | Self::Sampled(_) => sampled.evaluate(|nm| self.at(nm)),
            },
            Wavelengths::Rgb => Spectrum::from_rgb(match self {
                Self::Constant(value) => [*value; 3],
                Self::Rgb(rgb) => *rgb,
                Self::Blackbody { .. } | Self::Sampled(_) => to_f32(xyz_to_rgb(self.xyz())),
            }),
        }
    }

    /// Whether its values are given by wavelength, not only by colour.
    #[must_use]
    pub fn is_spectral(&self) -> bool {
        matches!(self, Self::Blackbody { .. } | Self::Sampled(_))
    }

    /// The value at `nm` of a spectrum that is given by wavelength; 0 of others.
    fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Constant(_) | Self::Rgb(_) => 0.0,
            Self::Blackbody { kelvin, scale } => {
                f64::from(*scale) * blackbody(nm, *kelvin, blackbody_peak_nm(*kelvin))
            }
            Self::Sampled(samples) => samples.at(nm),
        }
    }

    /// Luminance (CIE Y) of the emitted light: 1 for the value 1 at every wavelength.
    #[must_use]
    pub fn luminance(&self) -> f32 {
        (match self {
            Self::Constant(value) => f64::from(*value),
            Self::Rgb(rgb) => luminance(rgb.map(f64::from)),
            Self::Blackbody { .. } | Self::Sampled(_) => self.xyz()[1],
        }) as f32
    }

    /// CIE XYZ of the light of a spectrum that is given by wavelength, divided by the integral of the luminosity function.
    fn xyz(&self) -> [f64; 3] {
        let knots = match self {
            Self::Sampled(samples) => samples.points(),
            _ => &[],
        };
        let sums = integrate(|nm| cie::observer(nm).map(|c| c * self.at(nm)), knots);
        sums.map(|sum| sum / cie::Y_INTEGRAL)
    }
}

/// Planck's law over its value at `peak_nm`; 0 for a body so cold that both underflow.
pub(crate) fn blackbody(nm: f64, kelvin: f32, peak_nm: f64) -> f64 {
    let ratio = planck(nm, f64::from(kelvin)) / planck(peak_nm, f64::from(kelvin));
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Wien's displacement law (@codata2018), nm; infinite for a temperature that is not positive.
pub(crate) fn blackbody_peak_nm(kelvin: f32) -> f64 {
    if kelvin > 0.0 { 2.897_771_955e6 / f64::from(kelvin) } else { f64::INFINITY }
}

/// Planck's law up to a factor, with the second radiation constant of @codata2018 in nm K.
fn planck(nm: f64, kelvin: f64) -> f64 {
    let x = 1.438_776_877e7 / (nm * kelvin);
    1.0 / (nm.powi(5) * x.exp_m1())
}

/// Means of `f` in the three Rec. 709 bands under D65.
fn under_daylight(f: impl Fn(f64) -> f64, knots: &[(f32, f32)]) -> [f64; 3] {
    let weight = |nm: f64| xyz_to_rgb(cie::observer(nm)).map(|band| cie::d65(nm) * band);
    let sum = integrate(|nm| weight(nm).map(|w| w * f(nm)), knots);
    let white = integrate(weight, &[]);
    std::array::from_fn(|i| sum[i] / white[i])
}

/// Integral over the CIE range of a function that is a polynomial of degree 3 or less between the entries of the
/// tables and `knots` (a product of up to three piecewise linear functions is); exact for those by Simpson's rule, for
/// smooth functions accurate to the fourth power of 5 nm over their scale.
pub(crate) fn integrate(f: impl Fn(f64) -> [f64; 3], knots: &[(f32, f32)]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut add = |a: f64, b: f64| {
        let (fa, fm, fb) = (f(a), f(0.5 * (a + b)), f(b));
        for i in 0..3 {
            sum[i] += (b - a) / 6.0 * (fa[i] + 4.0 * fm[i] + fb[i]);
        }
    };
    let mut inner = knots.iter().map(|k| f64::from(k.0)).skip_while(|&nm| nm <= cie::FIRST_NM).peekable();
    let mut from = cie::FIRST_NM;
    for step in 1..cie::COUNT {
        let to = cie::FIRST_NM + cie::STEP_NM * step as f64;
        while let Some(nm) = inner.next_if(|&nm| nm < to) {
            add(from, nm);
            from = nm;
        }
        add(from, to);
        from = to;
    }
    sum
}

fn to_f32(values: [f64; 3]) -> [f32; 3] {
    values.map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RGB: Wavelengths = Wavelengths::Rgb;

    fn close(found: [f32; 3], expected: [f64; 3], tolerance: f64) {
        for i in 0..3 {
            assert!(
                (f64::from(found[i]) - expected[i]).abs() <= tolerance,
                "{found:?}, expected {expected:?}"
            );
        }
    }

    fn chromaticity(s: &SpectralDistribution) -> (f64, f64) {
        let [x, y, z] = s.xyz();
        (x / (x + y + z), y / (x + y + z))
    }

    #[test]
    fn flat_reflectance_is_grey_of_its_value() {
        for value in [0.0, 0.18, 1.0] {
            let flat = SpectralDistribution::try_sampled(vec![(400.0, value), (700.0, value)]).unwrap();
            close(flat.reflectance(&RGB).to_rgb(&RGB), [f64::from(value); 3], 1e-7);
            assert_eq!(flat.reflectance(&RGB).to_rgb(&RGB)[0], flat.unbounded(&RGB).to_rgb(&RGB)[0]);
        }
        let flat = SpectralDistribution::try_sampled(vec![(550.0, 1.5)]).unwrap();
        close(flat.unbounded(&RGB).to_rgb(&RGB), [1.5; 3], 1e-6);
        close(flat.reflectance(&RGB).to_rgb(&RGB), [1.0; 3], 0.0);
    }

    #[test]
    fn light_of_one_everywhere_has_luminance_one_and_the_equal_energy_colour() {
        let flat = SpectralDistribution::try_sampled(vec![(360.0, 1.0), (830.0, 1.0)]).unwrap();
        assert!((flat.luminance() - 1.0).abs() < 1e-6);
        let (x, y) = chromaticity(&flat);
        // CIE 15: illuminant E at 1 nm is (0.33331, 0.33334).
        assert!((x - 1.0 / 3.0).abs() < 1e-4 && (y - 1.0 / 3.0).abs() < 1e-4, "{x} {y}");
    }

    #[test]
    fn daylight_table_is_white() {
        let points: Vec<(f32, f32)> =
            (0..cie::COUNT).map(|i| (cie::FIRST_NM as f32 + 5.0 * i as f32, cie::D65[i] as f32)).collect();
        let light = SpectralDistribution::try_sampled(points).unwrap();
        let y = f64::from(light.luminance());
        close((light.radiance(&RGB) * (1.0 / y) as f32).to_rgb(&RGB), [1.0; 3], 2e-3);
    }

    #[test]
    fn black_body_colours_lie_on_the_planckian_locus() {
        // Temperature and (x, y) of the Planckian locus, Wyszecki and Stiles (1982), table 1(3.11), rounded; with
        // c2 = 1.4388e-2 m K.
        for (kelvin, x, y) in [(2856.0, 0.4475, 0.4074), (5000.0, 0.3451, 0.3516), (6500.0, 0.3135, 0.3237)] {
            let (fx, fy) = chromaticity(&SpectralDistribution::try_blackbody(kelvin, 1.0).unwrap());
            assert!((fx - x).abs() < 3e-4 && (fy - y).abs() < 3e-4, "{kelvin} K: {fx} {fy}");
        }
    }

    #[test]
    fn black_body_peaks_at_its_scale() {
        for kelvin in [1000.0_f32, 4000.0, 20_000.0] {
            let peak = blackbody_peak_nm(kelvin);
            assert_eq!(blackbody(peak, kelvin, peak), 1.0);
            assert!(
                blackbody(peak * 1.001, kelvin, peak) < 1.0 && blackbody(peak * 0.999, kelvin, peak) < 1.0
            );
        }
    }

    #[test]
    fn black_body_at_absolute_zero_is_dark() {
        for kelvin in [0.0, -5.0, f32::NAN, 1e-30, 1e-3] {
            let body = SpectralDistribution::Blackbody { kelvin, scale: 1.0 };
            assert_eq!(body.radiance(&RGB), Spectrum::BLACK, "{kelvin}");
        }
        assert_eq!(SpectralDistribution::try_blackbody(0.0, 1.0), Err(SpectrumError::Temperature(0.0)));
        assert!(SpectralDistribution::try_blackbody(f32::NAN, 1.0).is_err());
        assert!(SpectralDistribution::try_blackbody(3000.0, f32::INFINITY).is_err());
    }

    #[test]
    fn narrow_spike_between_two_table_entries_is_integrated() {
        // A triangle of width 2 nm and height 1 at 552.5 nm has area 1; the observer is (almost) constant there.
        let spike =
            SpectralDistribution::try_sampled(vec![(551.5, 0.0), (552.5, 1.0), (553.5, 0.0)]).unwrap();
        let [_, y, _] = cie::observer(552.5);
        assert!((f64::from(spike.luminance()) - y / cie::Y_INTEGRAL).abs() < 1e-9);
    }

    #[test]
    fn sampled_spectrum_is_linear_between_and_constant_beyond_its_samples() {
        let samples = SpectralSamples::try_new(vec![(400.0, 1.0), (500.0, 3.0)]).unwrap();
        for (nm, value) in [(300.0, 1.0), (400.0, 1.0), (425.0, 1.5), (500.0, 3.0), (900.0, 3.0)] {
            assert_eq!(samples.at(nm), value);
        }
        assert_eq!(samples.scaled(2.0).unwrap().at(450.0), 4.0);
        assert!(samples.scaled(f32::MAX).is_err());
    }

    #[test]
    fn unordered_and_infinite_samples_are_refused() {
        assert_eq!(SpectralSamples::try_new(vec![]), Err(SpectrumError::Empty));
        assert_eq!(
            SpectralSamples::try_new(vec![(500.0, 1.0), (500.0, 1.0)]),
            Err(SpectrumError::Order { index: 1, nm: 500.0, before: 500.0 })
        );
        assert!(matches!(
            SpectralSamples::try_new(vec![(500.0, f32::NAN)]),
            Err(SpectrumError::NotFinite { index: 0, .. })
        ));
        assert!(SpectralSamples::try_new(vec![(f32::INFINITY, 1.0)]).is_err());
    }

    #[test]
    fn index_of_a_steep_spectrum_stays_inside_its_range() {
        let step = SpectralDistribution::try_sampled(vec![(570.0, 5.0), (600.0, 0.1)]).unwrap();
        for value in step.unbounded(&RGB).to_rgb(&RGB) {
            assert!((0.1..=5.0).contains(&value));
        }
        let red = SpectralDistribution::try_sampled(vec![(590.0, 0.0), (600.0, 1.0)]).unwrap();
        let [r, g, b] = red.reflectance(&RGB).to_rgb(&RGB);
        assert!(r > 0.9 && g < 0.1 && b < 0.05, "{r} {g} {b}");
    }

    #[test]
    fn constants_and_colours_pass_unchanged() {
        let colour = SpectralDistribution::Rgb([0.2, 1.5, -0.1]);
        assert_eq!(colour.radiance(&RGB).to_rgb(&RGB), [0.2, 1.5, -0.1]);
        assert_eq!(colour.unbounded(&RGB).to_rgb(&RGB), [0.2, 1.5, -0.1]);
        assert_eq!(colour.reflectance(&RGB).to_rgb(&RGB), [0.2, 1.0, 0.0]);
        assert_eq!(SpectralDistribution::Constant(3.0).radiance(&RGB).to_rgb(&RGB), [3.0; 3]);
        assert_eq!(SpectralDistribution::Constant(3.0).luminance(), 3.0);
    }
}
