//! From scene light to the bytes of a display.

use crate::rgb::{luminance, srgb_byte};

/// Curve that compresses linear light into the range of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ToneCurve {
    /// No compression: light is clipped at 1.
    #[default]
    Linear,
    /// `Y / (1 + Y)` of the luminance Y, colour ratios kept (@reinhard2002 equation 3).
    Reinhard,
    /// A filmic S-curve for each channel: the rational fit to the ACES reference transform of @narkowicz2016, with
    /// his factor of 0.6 on the input, which gives the exposure of the transform itself.
    Filmic,
}

/// Exposure and tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tone {
    /// Light is multiplied by 2 to this power before the curve.
    pub exposure_stops: f32,
    /// The curve.
    pub curve: ToneCurve,
}

impl Tone {
    /// Linear display light in [0, 1] for linear scene light. Negative light and NaN become 0, infinite light 1.
    #[must_use]
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let gain = self.exposure_stops.exp2();
        let exposed = rgb.map(|x| if x > 0.0 { (x * gain).min(f32::MAX) } else { 0.0 });
        let shown = match self.curve {
            ToneCurve::Linear => exposed,
            ToneCurve::Reinhard => {
                let y = luminance(exposed.map(f64::from));
                exposed.map(|x| (f64::from(x) / (1.0 + y)) as f32)
            }
            ToneCurve::Filmic => exposed.map(filmic),
        };
        shown.map(|x| x.clamp(0.0, 1.0))
    }

    /// The three sRGB bytes for linear scene light, rounded to nearest.
    #[must_use]
    pub fn to_srgb8(&self, rgb: [f32; 3]) -> [u8; 3] {
        self.apply(rgb).map(srgb_byte)
    }
}

/// The curve of @narkowicz2016, in `f64`, which holds the square of any `f32`.
fn filmic(x: f32) -> f32 {
    let x = 0.6 * f64::from(x);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tone(exposure_stops: f32, curve: ToneCurve) -> Tone {
        Tone { exposure_stops, curve }
    }

    #[test]
    fn linear_curve_encodes_light_below_one_as_srgb() {
        // 1.055 * 0.5^(1/2.4) - 0.055 = 0.735357, times 255 = 187.516, rounded.
        assert_eq!(Tone::default().to_srgb8([0.0, 0.5, 1.0]), [0, 188, 255]);
    }

    #[test]
    fn one_stop_doubles_the_light() {
        let dark = tone(0.0, ToneCurve::Linear).to_srgb8([0.1, 0.2, 0.4]);
        let bright = tone(1.0, ToneCurve::Linear).to_srgb8([0.05, 0.1, 0.2]);
        assert_eq!(dark, bright);
    }

    #[test]
    fn negative_light_and_nan_become_black_and_infinite_light_white() {
        for curve in [ToneCurve::Linear, ToneCurve::Filmic] {
            assert_eq!(tone(0.0, curve).to_srgb8([f32::NAN, f32::NEG_INFINITY, f32::INFINITY]), [0, 0, 255]);
        }
        assert_eq!(tone(0.0, ToneCurve::Reinhard).to_srgb8([f32::INFINITY; 3]), [255; 3]);
        assert_eq!(tone(200.0, ToneCurve::Linear).to_srgb8([0.0, 1e-3, 1.0]), [0, 255, 255]);
    }

    #[test]
    fn reinhard_maps_luminance_one_to_one_half_and_keeps_colour_ratios() {
        let grey = tone(0.0, ToneCurve::Reinhard).apply([1.0; 3]);
        assert!((grey[0] - 0.5).abs() < 1e-6);
        let [r, g, _] = tone(0.0, ToneCurve::Reinhard).apply([0.4, 0.2, 0.1]);
        assert!((r / g - 2.0).abs() < 1e-6);
    }

    #[test]
    fn filmic_curve_rises_from_black_to_white() {
        let mut last = -1.0;
        for i in 0..200 {
            let [y, ..] = tone(0.0, ToneCurve::Filmic).apply([i as f32 * 0.05; 3]);
            assert!(y >= last && y <= 1.0);
            last = y;
        }
        assert_eq!(tone(0.0, ToneCurve::Filmic).apply([0.0; 3]), [0.0; 3]);
        // At x = 1: u = 0.6, u (2.51 u + 0.03) / (u (2.43 u + 0.59) + 0.14) = 0.9216 / 1.3688.
        assert!((filmic(1.0) - 0.673_290_5).abs() < 1e-5, "{}", filmic(1.0));
    }
}
