//! Marble.

use glanz_light::Spectrum;

use super::noise::fractal_sum;
use super::{TextureMapping, TexturePoint};

/// Colours of the layers, the control points of a curve of cubic segments, each of which begins one point later than the one before.
const COLORS: [[f32; 3]; 9] = [
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.5, 0.5, 0.5],
    [0.6, 0.59, 0.58],
    [0.58, 0.58, 0.6],
    [0.58, 0.58, 0.6],
    [0.2, 0.2, 0.33],
    [0.58, 0.58, 0.6],
];

/// Number of the segments.
const SEGMENTS: usize = COLORS.len() - 3;

/// Factor on the colours, for more contrast.
const CONTRAST: f32 = 1.5;

/// Layers along y, displaced by noise.
///
/// # Source
/// @pbrt4 `MarbleTexture`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marble {
    /// Number of octaves of the noise.
    pub octaves: u32,
    /// Factor between the amplitudes of octaves.
    pub roughness: f64,
    /// Factor on the coordinates; two pi units are a layer.
    pub scale: f64,
    /// Factor on the displacement.
    pub variation: f64,
    /// Coordinates.
    pub mapping: TextureMapping,
}

impl Marble {
    /// The colour at a point.
    #[must_use]
    pub fn evaluate(&self, at: &TexturePoint) -> Spectrum {
        let p = self.scale * self.mapping.coordinates(at).position;
        let displacement = self.variation * fractal_sum(p, self.roughness, self.octaves);
        Spectrum::from_rgb(layer_color(0.5 + 0.5 * (p.y + displacement).sin()))
    }
}

/// The colour at `t` in [0, 1] of the curve; NaN gives its begin.
fn layer_color(t: f64) -> [f32; 3] {
    let place = t.max(0.0) * SEGMENTS as f64;
    let first = (place.floor() as usize).min(SEGMENTS - 1);
    let t = (place - first as f64) as f32;
    // De Casteljau's algorithm.
    let mut points: [[f32; 3]; 4] = std::array::from_fn(|i| COLORS[first + i]);
    for count in (1..4).rev() {
        for i in 0..count {
            points[i] = std::array::from_fn(|k| (1.0 - t) * points[i][k] + t * points[i + 1][k]);
        }
    }
    points[0].map(|x| CONTRAST * x)
}

#[cfg(test)]
mod tests {
    use glanz_light::Wavelengths;
    use glanz_math::{DVec2, DVec3, Transform};

    use super::*;

    fn marble(variation: f64, y: f64) -> [f32; 3] {
        let mapping = TextureMapping::Solid { to_texture: Transform::IDENTITY };
        let marble = Marble { octaves: 8, roughness: 0.5, scale: 2.0, variation, mapping };
        marble.evaluate(&TexturePoint::new(DVec2::ZERO, DVec3::new(0.3, y, 0.7))).to_rgb(&Wavelengths::Rgb)
    }

    fn assert_close(found: [f32; 3], expected: [f32; 3]) {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - 1.5 * b).abs() < 1e-5),
            "{found:?} {expected:?}"
        );
    }

    #[test]
    fn layers_without_variation_are_the_curve_of_the_sine() {
        use std::f64::consts::FRAC_PI_4;
        // sin = -1 and 1: the ends of the first and of the last segment; sin = 0: the begin of the fourth.
        assert_close(marble(0.0, -FRAC_PI_4), COLORS[0]);
        assert_close(marble(0.0, FRAC_PI_4), COLORS[8]);
        assert_close(marble(0.0, 0.0), COLORS[3]);
        // sin = 5/6, the middle of the last segment: (c5 + 3 c6 + 3 c7 + c8) / 8.
        let middle =
            [(0.58 * 5.0 + 0.2 * 3.0) / 8.0, (0.58 * 5.0 + 0.2 * 3.0) / 8.0, (0.6 * 5.0 + 0.33 * 3.0) / 8.0];
        assert_close(marble(0.0, 0.5 * (5.0_f64 / 6.0).asin()), middle);
        assert_ne!(marble(0.5, 0.1), marble(0.0, 0.1));
        assert!(marble(f64::NAN, f64::INFINITY).iter().all(|x| x.is_finite()));
    }
}
