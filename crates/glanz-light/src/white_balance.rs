//! Chromatic adaptation: what looks white.

use crate::cie::{FIRST_NM, OBSERVER, STEP_NM};
use crate::rgb::{RGB_TO_XYZ, XYZ_TO_RGB};

/// CIE XYZ to the responses of cones, sharpened (Bradford).
const XYZ_TO_CONES: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The inverse of [`XYZ_TO_CONES`].
const CONES_TO_XYZ: [[f64; 3]; 3] = [
    [0.986_992_905_466_712_1, -0.147_054_256_420_990_1, 0.159_962_651_663_731_25],
    [0.432_305_269_723_394_5, 0.518_360_271_536_777_6, 0.049_291_228_212_855_615],
    [-0.008_528_664_575_177_331, 0.040_042_821_654_084_86, 0.968_486_695_787_55],
];

/// Chromaticity of D65, white in Rec. 709.
const WHITE: [f64; 2] = [0.3127, 0.3290];

/// Second radiation constant by which colour temperatures are computed today over that of the definition of daylight.
const C2_RATIO: f64 = 1.4388 / 1.4380;

/// Second radiation constant, m K.
const C2: f64 = 1.4388e-2;

/// Temperature below which daylight is not defined, kelvin.
const COOLEST_DAYLIGHT: f64 = 4000.0;

/// Matrix of linear Rec. 709, row by row, that adapts a picture under light of this temperature to D65: such light becomes grey.
///
/// The light is CIE daylight, below 4000 K that of a black body. `None` for temperatures outside of 1000 to 25000 K.
///
/// # Source
/// The adaptation of von Kries in Bradford's cones, @lam1985 and @pharr2023 section 5.4.2; daylight: @cie015 section 4.1.2.
#[must_use]
pub fn white_balance(kelvin: f64) -> Option<[[f64; 3]; 3]> {
    if !(1000.0..=25_000.0).contains(&kelvin) {
        return None;
    }
    let [from, to] = [chromaticity(kelvin * C2_RATIO), WHITE].map(|[x, y]| {
        let xyz = [x / y, 1.0, (1.0 - x - y) / y];
        XYZ_TO_CONES.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
    });
    let mut gains = [[0.0; 3]; 3];
    (0..3).for_each(|i| gains[i][i] = to[i] / from[i]);
    let chain = [&CONES_TO_XYZ, &gains, &XYZ_TO_CONES, &RGB_TO_XYZ];
    Some(chain.into_iter().fold(XYZ_TO_RGB, |product, matrix| multiply(&product, matrix)))
}

/// Chromaticity of daylight, below 4000 K of a black body.
fn chromaticity(kelvin: f64) -> [f64; 2] {
    if kelvin < COOLEST_DAYLIGHT {
        let mut sum = [0.0; 3];
        for (i, observer) in OBSERVER.iter().enumerate() {
            let metres = 1e-9 * (FIRST_NM + STEP_NM * i as f64);
            // Relative to the exponent of 500 nm, so that nothing underflows.
            let shift = C2 / (500e-9 * kelvin);
            let power = (500e-9 / metres).powi(5) / ((C2 / (metres * kelvin) - shift).exp() - (-shift).exp());
            (0..3).for_each(|k| sum[k] += power * observer[k]);
        }
        let total: f64 = sum.iter().sum();
        return [sum[0] / total, sum[1] / total];
    }
    let t = 1e3 / kelvin;
    let x = if kelvin <= 7000.0 {
        ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244_063
    } else {
        ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237_040
    };
    [x, (-3.0 * x + 2.870) * x - 0.275]
}

fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| std::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rgb::xyz_to_rgb;

    #[test]
    fn chromaticities_are_those_of_the_standard_illuminants() {
        // CIE 015:2018 table 3: D50 at 5000 K and D65 at 6500 K by the old constant, A at 2856 K.
        for (kelvin, x, y) in [
            (5000.0 * C2_RATIO, 0.345_67, 0.358_51),
            (6500.0 * C2_RATIO, 0.312_72, 0.329_03),
            (2856.0, 0.447_58, 0.407_45),
        ] {
            let [found_x, found_y] = chromaticity(kelvin);
            assert!(
                (found_x - x).abs() < 2e-4 && (found_y - y).abs() < 2e-4,
                "{kelvin}: {found_x} {found_y}"
            );
        }
    }

    #[test]
    fn matrices_of_cones_are_inverses() {
        let product = multiply(&CONES_TO_XYZ, &XYZ_TO_CONES);
        for (i, row) in product.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-12, "{product:?}");
            }
        }
    }

    #[test]
    fn light_of_the_temperature_becomes_grey_of_the_same_luminance() {
        for kelvin in [1800.0, 3200.0, 5000.0, 9000.0] {
            let [x, y] = chromaticity(kelvin * C2_RATIO);
            let rgb = xyz_to_rgb([x / y, 1.0, (1.0 - x - y) / y]);
            let rows = white_balance(kelvin).unwrap();
            for row in rows {
                let value = row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2];
                // Rec. 709's (1, 1, 1) is the white of these digits.
                assert!((value - 1.0).abs() < 1e-9, "{kelvin}: {value}");
            }
        }
    }

    #[test]
    fn matrix_from_d50_to_d65_is_the_published_one() {
        // Lindbloom's Bradford matrix from D50 to D65 in XYZ, first row 0.9555766, -0.0230393, 0.0631636; in Rec. 709 its
        // effect on D50's white.
        let rows = white_balance(5000.0).unwrap();
        let xyz = [
            [0.955_576_6, -0.023_039_3, 0.063_163_6],
            [-0.028_289_5, 1.009_941_6, 0.021_007_7],
            [0.012_298_2, -0.020_483_0, 1.329_909_8],
        ];
        let expected = multiply(&multiply(&XYZ_TO_RGB, &xyz), &RGB_TO_XYZ);
        for (found, expected) in rows.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 2e-3, "{rows:?} {expected:?}");
        }
    }

    #[test]
    fn temperatures_out_of_range_have_no_matrix() {
        assert!(white_balance(999.0).is_none() && white_balance(f64::NAN).is_none());
        assert!(white_balance(25_001.0).is_none() && white_balance(6500.0).is_some());
    }
}
