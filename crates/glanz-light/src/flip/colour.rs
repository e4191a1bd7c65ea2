//! The colour spaces of FLIP.

/// Linear sRGB to CIE XYZ, as the rational numbers in the authors' program.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse of `TO_XYZ`.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// CIE XYZ of white.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of a linear colour, each over that of white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb);
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

/// Y, Cx, Cz: L*a*b* without its cube root, linear in light, so that it may be blurred.
pub(super) fn opponent_of(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The linear colour of Y, Cx, Cz.
pub(super) fn rgb_of_opponent([luma, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (luma + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    times(&FROM_XYZ, std::array::from_fn(|i| relative[i] * WHITE[i]))
}

/// CIE L*a*b*, with a* and b* weakened in the dark (Hunt effect).
pub(super) fn lab_with_hunt(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(rgb)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// HyAB distance: absolute difference of lightness plus Euclidean distance of a* and b*.
pub(super) fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    // The published matrices have nine decimals.
    fn opponent_space_round_trips() {
        for rgb in [[0.0; 3], [1.0; 3], [0.1, 0.7, 0.3]] {
            let back = rgb_of_opponent(opponent_of(rgb));
            assert!((0..3).all(|i| (back[i] - rgb[i]).abs() < 2e-7), "{rgb:?} {back:?}");
        }
    }

    #[test]
    fn white_has_lightness_100_and_black_0_without_colour() {
        for (grey, lightness) in [(1.0, 100.0), (0.0, 0.0)] {
            let [l, a, b] = lab_with_hunt([grey; 3]);
            assert!((l - lightness).abs() < 1e-6 && a.abs() < 1e-5 && b.abs() < 1e-5, "{l} {a} {b}");
        }
    }
}
