//! Random wavelengths of one path.

use std::sync::LazyLock;

use crate::cie;
use crate::distribution::integrate;
use crate::rgb::xyz_to_rgb;
use crate::rgb_primaries::RED_BLUE;
use crate::spectrum::{LANES, Spectrum};

/// Where the density of wavelengths is largest, nm, and its reciprocal width, 1/nm.
const CENTER_NM: f64 = 538.0;
const SHARPNESS: f64 = 0.0072;

/// [`LANES`] wavelengths at equal distances of their distribution function, all of one random number: the first is the hero.
///
/// Their density follows the sensitivity of the eye (@radziszewski2009, as @pharr2023 section 4.5.4); the rotation is that of @wilkie2014.
/// The values that lanes need of the tables are stored with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledWavelengths {
    nm: [f32; LANES],
    /// Reflectance of the red and the blue primary.
    red: Spectrum,
    blue: Spectrum,
    /// D65 of luminance 1.
    daylight: Spectrum,
    /// Weights of the lanes for red, green and blue: sensitivity over density and number of lanes.
    bands: [[f32; LANES]; 3],
}

/// Functions of the wavelength at the entries of the tables of [`cie`].
struct ObserverTable {
    /// Sensitivity of red, green and blue to light, 1/nm, scaled so that white is D65; daylight; red and blue primary.
    rows: Vec<[f64; 6]>,
}

static TABLE: LazyLock<ObserverTable> = LazyLock::new(ObserverTable::new);

impl ObserverTable {
    fn new() -> Self {
        let band = |nm: f64| xyz_to_rgb(cie::observer(nm));
        // The table's D65 and the white of Rec. 709, whose chromaticity has four digits, differ by 4e-4: grey shall be grey.
        let white = integrate(|nm| band(nm).map(|w| w * cie::d65(nm)), &[]);
        let luminance = integrate(|nm| cie::observer(nm).map(|c| c * cie::d65(nm)), &[])[1];
        let [rw, gw, bw] = white.map(|w| w * cie::Y_INTEGRAL / luminance);
        let row = |(index, (&power, &[red, blue])): (u32, (&f64, &[f64; 2]))| {
            let [r, g, b] = band(cie::FIRST_NM + cie::STEP_NM * f64::from(index));
            let daylight = power * cie::Y_INTEGRAL / luminance;
            [r / rw, g / gw, b / bw, daylight, red, blue]
        };
        Self { rows: (0..).zip(cie::D65.iter().zip(&RED_BLUE)).map(row).collect() }
    }

    fn at(&self, nm: f64) -> [f64; 6] {
        let rows = cie::locate(nm).and_then(|(i, t)| Some((self.rows.get(i)?, self.rows.get(i + 1)?, t)));
        rows.map_or([0.0; 6], |(a, b, t)| std::array::from_fn(|k| a[k] + t * (b[k] - a[k])))
    }
}

impl SampledWavelengths {
    /// The wavelengths of a number `xi` in [0, 1), in [360, 830] nm.
    #[must_use]
    pub fn sample(xi: f64) -> Self {
        let end = |nm: f64| (SHARPNESS * (nm - CENTER_NM)).tanh();
        let (low, high) = (end(cie::FIRST_NM), end(cie::LAST_NM));
        let mut sampled = Self {
            nm: [0.0; LANES],
            red: Spectrum::BLACK,
            blue: Spectrum::BLACK,
            daylight: Spectrum::BLACK,
            bands: [[0.0; LANES]; 3],
        };
        for lane in 0..LANES {
            let t = low + (xi + lane as f64 / LANES as f64).fract() * (high - low);
            let nm = (CENTER_NM + t.atanh() / SHARPNESS).clamp(cie::FIRST_NM, cie::LAST_NM);
            let density = SHARPNESS * (1.0 - t * t) / (high - low);
            let [r, g, b, daylight, red, blue] = TABLE.at(nm);
            sampled.nm[lane] = nm as f32;
            sampled.red.0[lane] = red as f32;
            sampled.blue.0[lane] = blue as f32;
            sampled.daylight.0[lane] = daylight as f32;
            for (row, weight) in sampled.bands.iter_mut().zip([r, g, b]) {
                row[lane] = (weight / (density * LANES as f64)) as f32;
            }
        }
        sampled
    }

    /// The wavelengths, nm.
    #[must_use]
    pub fn nm(&self) -> [f32; LANES] {
        self.nm
    }

    /// A function of the wavelength in nm at the wavelengths.
    pub(crate) fn evaluate(&self, f: impl Fn(f64) -> f64) -> Spectrum {
        Spectrum(self.nm.map(|nm| f(f64::from(nm)) as f32))
    }

    /// D65 of luminance 1.
    pub(crate) fn daylight(&self) -> Spectrum {
        self.daylight
    }

    /// See [`Spectrum::upsampled`].
    pub(crate) fn upsampled(&self, rgb: Spectrum) -> Spectrum {
        let [r, g, b, _] = rgb.0;
        // Exact for grey.
        Spectrum::splat(g) + self.red * (r - g) + self.blue * (b - g)
    }

    /// See [`Spectrum::to_rgb`].
    pub(crate) fn rgb(&self, light: Spectrum) -> [f32; 3] {
        self.bands.map(|weights| weights.iter().zip(light.0).map(|(weight, value)| weight * value).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SpectralDistribution, Wavelengths, named};

    const COUNT: u32 = 4096;

    fn all() -> impl Iterator<Item = Wavelengths> {
        (0..COUNT).map(|i| {
            Wavelengths::Sampled(SampledWavelengths::sample((f64::from(i) + 0.5) / f64::from(COUNT)))
        })
    }

    /// The mean colour of `light` over all wavelengths.
    fn mean(light: impl Fn(&Wavelengths) -> Spectrum) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for wavelengths in all() {
            let rgb = light(&wavelengths).to_rgb(&wavelengths);
            (0..3).for_each(|i| sum[i] += f64::from(rgb[i]) / f64::from(COUNT));
        }
        sum
    }

    fn assert_close(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() <= tolerance), "{found:?} {expected:?}");
    }

    /// Colours over the cube.
    fn colors() -> impl Iterator<Item = [f32; 3]> {
        (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|level| [0.0, 0.31, 1.0][level]))
    }

    #[test]
    fn distribution_of_wavelengths_is_the_published_one() {
        // The density of pbrt-v4's `VisibleWavelengthsPDF`, summed by the midpoint rule.
        let density = |nm: f64| 0.003_939_804_2 / (0.0072 * (nm - 538.0)).cosh().powi(2);
        for end in [400.0_f64, 450.0, 538.0, 600.0, 700.0] {
            let steps = 10_000;
            let width = (end - 360.0) / f64::from(steps);
            let expected: f64 =
                (0..steps).map(|i| density(360.0 + (f64::from(i) + 0.5) * width) * width).sum();
            for lane in 0..LANES {
                let below = |wavelengths: &Wavelengths| match wavelengths {
                    Wavelengths::Sampled(sampled) => f64::from(sampled.nm()[lane]) < end,
                    Wavelengths::Rgb => false,
                };
                let found = all().filter(below).count() as f64 / f64::from(COUNT);
                assert!((found - expected).abs() < 1e-3, "{end} nm, lane {lane}: {found} {expected}");
            }
        }
    }

    #[test]
    fn primaries_are_reflectances() {
        for [red, blue] in RED_BLUE {
            assert!(red >= 0.0 && blue >= 0.0 && red + blue <= 1.0, "{red} {blue}");
        }
        for wavelengths in all() {
            for color in colors() {
                let lanes = Spectrum::from_rgb(color).upsampled(&wavelengths).0;
                assert!(lanes.iter().all(|x| (-1e-6..=1.000_001).contains(x)), "{color:?} {lanes:?}");
            }
            assert_eq!(Spectrum::from_rgb([0.7; 3]).upsampled(&wavelengths), Spectrum::splat(0.7));
        }
    }

    #[test]
    fn colors_return_from_their_spectra_under_daylight() {
        // By sums over the wavelength that know only the tables of observer and daylight.
        let sum = |f: &dyn Fn(f64) -> f64| {
            let mut xyz = [0.0; 3];
            for i in 0..4700 {
                let nm = 360.05 + 0.1 * f64::from(i);
                let light = f(nm) * cie::d65(nm);
                cie::observer(nm).iter().zip(&mut xyz).for_each(|(c, sum)| *sum += c * light);
            }
            xyz
        };
        let white = sum(&|_| 1.0)[1];
        for color in colors() {
            let [r, g, b] = color.map(f64::from);
            let reflectance = |nm| {
                let [.., red, blue] = TABLE.at(nm);
                r * red + g * (1.0 - red - blue) + b * blue
            };
            let expected = color.map(f64::from);
            assert_close(xyz_to_rgb(sum(&reflectance)).map(|x| x / white), expected, 1e-3);
            assert_close(mean(|w| Spectrum::from_rgb(color).upsampled_light(w)), expected, 1e-4);
        }
    }

    #[test]
    fn spectra_have_the_colors_that_they_have_as_rgb() {
        let rgb = |spectrum: Spectrum| spectrum.to_rgb(&Wavelengths::Rgb).map(f64::from);
        for name in ["stdillum-A", "stdillum-D50", "stdillum-F2", "stdillum-F11"] {
            let light = named::spectrum(name).unwrap();
            assert_close(mean(|w| light.radiance(w)), rgb(light.radiance(&Wavelengths::Rgb)), 2e-3);
        }
        let body = SpectralDistribution::try_blackbody(3000.0, 2.0).unwrap();
        assert_close(mean(|w| body.radiance(w)), rgb(body.radiance(&Wavelengths::Rgb)), 2e-3);
        let slope = SpectralDistribution::try_sampled(vec![(400.0, 0.2), (700.0, 0.7)]).unwrap();
        let white = SpectralDistribution::Constant(1.0);
        let found = mean(|w| slope.reflectance(w) * white.radiance(w));
        assert_close(found, rgb(slope.reflectance(&Wavelengths::Rgb)), 2e-3);
        assert_close(mean(|w| white.radiance(w)), [1.0; 3], 1e-4);
    }

    #[test]
    fn hero_alone_has_the_same_mean() {
        let light = named::spectrum("stdillum-A").unwrap();
        let all_lanes = mean(|w| light.radiance(w));
        assert_close(mean(|w| light.radiance(w).hero_alone()), all_lanes, 1e-3);
    }
}
