//! Sums of noise as textures of numbers.

use super::noise::{fractal_sum, turbulence};
use super::{TextureMapping, TexturePoint};

/// The kinds of sums of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FractalKind {
    /// Sum of octaves: fractional Brownian motion.
    Fbm {
        /// Number of octaves.
        octaves: u32,
        /// Factor between the amplitudes of octaves.
        roughness: f64,
    },
    /// Sum of absolute values of octaves, with creases.
    Wrinkled {
        /// Number of octaves.
        octaves: u32,
        /// Factor between the amplitudes of octaves.
        roughness: f64,
    },
    /// Waves on water whose height varies with the strength of the wind.
    Windy,
}

/// A sum of noise in space.
///
/// # Source
/// @pbrt4 `FBmTexture`, `WrinkledTexture`, `WindyTexture`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fractal {
    /// The kind of sum.
    pub kind: FractalKind,
    /// Coordinates; one unit is the period of the first octave.
    pub mapping: TextureMapping,
}

impl Fractal {
    /// The value at a point, of either sign.
    #[must_use]
    pub fn evaluate(&self, at: &TexturePoint) -> f32 {
        let position = self.mapping.coordinates(at).position;
        let value = match self.kind {
            FractalKind::Fbm { octaves, roughness } => fractal_sum(position, roughness, octaves),
            FractalKind::Wrinkled { octaves, roughness } => turbulence(position, roughness, octaves),
            FractalKind::Windy => {
                let wind = fractal_sum(0.1 * position, 0.5, 3);
                wind.abs() * fractal_sum(position, 0.5, 6)
            }
        };
        value as f32
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::{DVec2, DVec3, Transform};

    use super::*;

    fn means(kind: FractalKind) -> (f64, f64) {
        let to_texture = Transform::translate(DVec3::new(0.2, 0.3, 0.4));
        let fractal = Fractal { kind, mapping: TextureMapping::Solid { to_texture } };
        // Irrational steps: a lattice of rank one in the period of the noise.
        let count = 40_000;
        let sum = (0..count).map(f64::from).fold((0.0, 0.0), |(sum, squares), i| {
            let p = 256.0
                * DVec3::new((0.819_172_5 * i).fract(), (0.671_043_6 * i).fract(), (0.549_700_5 * i).fract());
            let value = f64::from(fractal.evaluate(&TexturePoint::new(DVec2::ZERO, p)));
            (sum + value, squares + value * value)
        });
        (sum.0 / f64::from(count), sum.1 / f64::from(count))
    }

    /// The variance of the noise: each corner of a cell contributes the mean square of its gradient's product with the offset from it, times
    /// the square of its weight, and gradients of different corners are independent. The squares of a gradient's components have the sum 2.
    /// Per axis, with the weight w of the far corner, `a` is the mean of (1 - w)^2 and `b` that of t^2 (1 - w)^2: eight corners give 8 * 2 a^2 b.
    #[test]
    fn sums_have_the_mean_and_variance_of_independent_octaves() {
        let integrate = |f: &dyn Fn(f64) -> f64| {
            (0..1000).map(|i| f((f64::from(i) + 0.5) / 1000.0)).sum::<f64>() / 1000.0
        };
        let w = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let a = integrate(&|t| (1.0 - w(t)).powi(2));
        let b = integrate(&|t| (t * (1.0 - w(t))).powi(2));
        let variance = 16.0 * a * a * b;
        let (mean, square) = means(FractalKind::Fbm { octaves: 1, roughness: 0.5 });
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((square / variance - 1.0).abs() < 0.05, "{square} {variance}");
        // Octaves add their variances: 1 + 1/4 + 1/16.
        let (mean, square) = means(FractalKind::Fbm { octaves: 3, roughness: 0.5 });
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((square / (variance * 1.3125) - 1.0).abs() < 0.05, "{square} {variance}");
        // Turbulence of one octave is its absolute value, with its square, and 0.2 of the next one: E (x + 0.1)^2.
        let (mean, square) = means(FractalKind::Wrinkled { octaves: 1, roughness: 0.5 });
        let absolute = mean - 0.1;
        assert!((square / (variance + 0.2 * absolute + 0.01) - 1.0).abs() < 0.05, "{square}");
        assert!((0.2..0.23).contains(&absolute), "{absolute}");
        // Of wind and waves, which are almost independent: the product.
        let (mean, _) = means(FractalKind::Windy);
        assert!(mean.abs() < 0.01, "{mean}");
    }
}
