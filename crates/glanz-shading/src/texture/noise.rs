//! Perlin's gradient noise and sums of its octaves.

use glanz_math::DVec3;

/// Perlin's permutation of 0..256, which pbrt uses as well, so that pictures agree.
///
/// # Source
/// @perlin2002, the reference implementation.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99,
    37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27,
    166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244,
    102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130,
    116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147,
    118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119,
    248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110,
    79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179,
    162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204, 176,
    115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78,
    66, 215, 61, 156, 180,
];

/// Factor between the frequencies of octaves. Less than 2, so that the zeros of the noise at integers do not coincide.
const LACUNARITY: f64 = 1.99;

/// Mean that pbrt assumes of the absolute value of the noise, for octaves that are left out.
const MEAN_ABSOLUTE: f64 = 0.2;

/// Largest number of octaves of a sum: beyond, features are as small as the rounding of coordinates of a few thousand.
pub const MAX_OCTAVES: u32 = 48;

/// Perlin's noise at a point: smooth, between -1 and 1, with mean 0; 0 at points of integers, and where a coordinate is not finite or so
/// large that it has no fraction.
///
/// # Source
/// @perlin2002; gradients as in @pbrt3, `Noise`.
#[must_use]
pub fn noise(p: DVec3) -> f64 {
    if !p.is_finite() {
        return 0.0;
    }
    let cell = p.floor();
    let d = p - cell;
    // Coordinates beyond the integers of f64 lie on them.
    let index = |x: f64| x.rem_euclid(256.0) as usize;
    let (x, y, z) = (index(cell.x), index(cell.y), index(cell.z));
    let at = |i: usize, j: usize, k: usize| {
        gradient(x + i, y + j, z + k, d - DVec3::new(i as f64, j as f64, k as f64))
    };
    let w = weight(d);
    let lerp = |t: f64, a: f64, b: f64| (1.0 - t) * a + t * b;
    let along_x = |j, k| lerp(w.x, at(0, j, k), at(1, j, k));
    let along_y = |k| lerp(w.y, along_x(0, k), along_x(1, k));
    lerp(w.z, along_y(0), along_y(1))
}

/// Product of the gradient at a corner of a cell with the offset `d` from it.
fn gradient(x: usize, y: usize, z: usize, d: DVec3) -> f64 {
    let permute = |i: usize| usize::from(PERMUTATION[i % 256]);
    let hash = permute(permute(permute(x) + y) + z) % 16;
    let in_plane = matches!(hash, 12 | 13);
    let u = if hash < 8 || in_plane { d.x } else { d.y };
    let v = if hash < 4 || in_plane { d.y } else { d.z };
    (if hash & 1 == 0 { u } else { -u }) + if hash & 2 == 0 { v } else { -v }
}

/// The weight of the far corner, with first and second derivatives that vanish at both.
fn weight(t: DVec3) -> DVec3 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Sum of octaves of the noise: fractional Brownian motion. `roughness`: factor between the amplitudes of octaves.
///
/// # Source
/// @pbrt3: `FBm`, without a filter.
#[must_use]
pub fn fractal_sum(p: DVec3, roughness: f64, octaves: u32) -> f64 {
    let (mut sum, mut frequency, mut amplitude) = (0.0, 1.0, 1.0);
    for _ in 0..octaves.min(MAX_OCTAVES) {
        sum += amplitude * noise(frequency * p);
        frequency *= LACUNARITY;
        amplitude *= roughness;
    }
    sum
}

/// As [`fractal_sum`], of absolute values: with creases. The first octave that is left out contributes its mean.
///
/// # Source
/// @pbrt3: `Turbulence`, without a filter.
#[must_use]
pub fn turbulence(p: DVec3, roughness: f64, octaves: u32) -> f64 {
    let (mut sum, mut frequency, mut amplitude) = (0.0, 1.0, 1.0);
    for _ in 0..octaves.min(MAX_OCTAVES) {
        sum += amplitude * noise(frequency * p).abs();
        frequency *= LACUNARITY;
        amplitude *= roughness;
    }
    sum + amplitude * MEAN_ABSOLUTE
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of another implementation, in another language, from the definition.
    #[test]
    fn values_are_those_of_the_definition() {
        for (p, expected) in [
            // Gradients at the corners of a cell, each times (+-1, +-1, +-1) / 2, with equal weights: a multiple of 1/8.
            ([0.5, 0.5, 0.5], -0.125),
            ([1.25, -3.75, 7.1], -0.13841960005187992),
            ([255.5, 255.25, 255.125], -0.5339758768677711),
            ([0.1, 0.2, 0.3], 0.35872104023613444),
            ([-100.3, 40.6, 2.9], 0.4674883149609979),
        ] {
            let found = noise(DVec3::from(p));
            assert!((found - expected).abs() < 1e-12, "{p:?}: {found}");
        }
        let sum = fractal_sum(DVec3::new(0.3, 0.7, -1.2), 0.5, 8);
        assert!((sum - 0.33473841186158776).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn noise_vanishes_at_integers_and_repeats_after_256() {
        for (x, y, z) in [(0.0, 0.0, 0.0), (3.0, -7.0, 255.0), (256.0, 1e6, -1e300)] {
            assert_eq!(noise(DVec3::new(x, y, z)), 0.0);
        }
        let p = DVec3::new(0.3, 1.6, -2.2);
        assert!((noise(p) - noise(p + DVec3::new(256.0, -512.0, 256.0))).abs() < 1e-12);
        for x in [f64::NAN, f64::INFINITY] {
            assert_eq!(noise(DVec3::new(x, 0.5, 0.5)), 0.0);
        }
    }

    #[test]
    fn gradient_of_noise_at_an_integer_is_that_of_its_corner() {
        // The corner (0, 0, 0): 151 = P(0), P(151) = 17, P(17) = 36, and 36 mod 16 = 4: x + z.
        let p = [0, 151, 17];
        assert_eq!(p.map(|i: usize| PERMUTATION[i]), [151, 17, 36]);
        let h = 1e-6;
        let derivative = |axis: DVec3| (noise(h * axis) - noise(-h * axis)) / (2.0 * h);
        // Behind the corner the weights of other cells still vanish to third order.
        for (axis, expected) in [(DVec3::X, 1.0), (DVec3::Y, 0.0), (DVec3::Z, 1.0)] {
            assert!((derivative(axis) - expected).abs() < 1e-6, "{axis}: {}", derivative(axis));
        }
    }

    #[test]
    fn octaves_that_are_left_out_count_by_their_mean_in_turbulence() {
        let p = DVec3::new(0.3, 0.7, -1.2);
        assert_eq!(turbulence(p, 0.5, 1), noise(p).abs() + 0.5 * 0.2);
        assert!(fractal_sum(p, 0.5, u32::MAX).is_finite());
    }
}
