//! Linear Rec. 709 red, green and blue: conversion to and from CIE XYZ and the sRGB transfer function.

use std::sync::LazyLock;

/// CIE XYZ to linear Rec. 709; the inverse of [`RGB_TO_XYZ`].
pub const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_969_941_904_522_6, -1.537_383_177_570_094, -0.498_610_760_293_003_4],
    [-0.969_243_636_280_879_6, 1.875_967_501_507_720_2, 0.041_555_057_407_175_59],
    [0.055_630_079_696_993_66, -0.203_976_958_888_976_52, 1.056_971_514_242_878_6],
];

/// Linear Rec. 709 to CIE XYZ: primaries (0.64, 0.33), (0.30, 0.60), (0.15, 0.06), white (0.3127, 0.3290), luminance
/// of white 1 (@iturbt709).
pub const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [0.412_390_799_265_959_34, 0.357_584_339_383_878, 0.180_480_788_401_834_3],
    [0.212_639_005_871_510_27, 0.715_168_678_767_756, 0.072_192_315_360_733_71],
    [0.019_330_818_715_591_82, 0.119_194_779_794_625_98, 0.950_532_152_249_660_7],
];

/// Linear Rec. 709 of a CIE XYZ colour; components may be negative outside the gamut.
#[must_use]
pub fn xyz_to_rgb(xyz: [f64; 3]) -> [f64; 3] {
    multiply(&XYZ_TO_RGB, xyz)
}

/// CIE XYZ of a linear Rec. 709 colour.
#[must_use]
pub fn rgb_to_xyz(rgb: [f64; 3]) -> [f64; 3] {
    multiply(&RGB_TO_XYZ, rgb)
}

/// CIE Y of a linear Rec. 709 colour; 1 for (1, 1, 1).
#[must_use]
pub fn luminance(rgb: [f64; 3]) -> f64 {
    let [r, g, b] = RGB_TO_XYZ[1];
    r * rgb[0] + g * rgb[1] + b * rgb[2]
}

/// sRGB value of linear light (IEC 61966-2-1, @srgb), continued as an odd function, not clipped.
#[must_use]
pub fn srgb_encode(linear: f32) -> f32 {
    let x = linear.abs();
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// The byte of [`srgb_encode`] times 255, rounded to nearest, for linear light; NaN and less than 0 give 0, more than 1 gives 255.
///
/// From a table: a search among 255 numbers is faster than a power.
#[must_use]
pub fn srgb_byte(linear: f32) -> u8 {
    /// The least linear light that is encoded as byte 1, 2, ...
    static LEAST: LazyLock<[f32; 255]> = LazyLock::new(|| {
        std::array::from_fn(|index| {
            // Positive numbers are in the order of their bits.
            let (mut below, mut least) = (0.0_f32.to_bits(), 1.0_f32.to_bits());
            while least - below > 1 {
                let middle = below + (least - below) / 2;
                let byte = (srgb_encode(f32::from_bits(middle)) * 255.0).round();
                *(if byte as usize > index { &mut least } else { &mut below }) = middle;
            }
            f32::from_bits(least)
        })
    });
    // At most 255, which fits.
    LEAST.partition_point(|&least| least <= linear) as u8
}

/// Linear light of an sRGB value; the inverse of [`srgb_encode`].
#[must_use]
pub fn srgb_decode(encoded: f32) -> f32 {
    let x = encoded.abs();
    let linear = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

fn multiply(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrix_maps_primaries_and_white_to_their_chromaticities() {
        let corners = [
            ([1.0, 0.0, 0.0], (0.64, 0.33)),
            ([0.0, 1.0, 0.0], (0.30, 0.60)),
            ([0.0, 0.0, 1.0], (0.15, 0.06)),
            ([1.0, 1.0, 1.0], (0.3127, 0.3290)),
        ];
        for (rgb, (x, y)) in corners {
            let xyz = rgb_to_xyz(rgb);
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[0] / sum - x).abs() < 1e-12 && (xyz[1] / sum - y).abs() < 1e-12, "{rgb:?}: {xyz:?}");
        }
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn matrices_are_inverses() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, -0.3, 7.0]] {
            let back = xyz_to_rgb(rgb_to_xyz(rgb));
            for i in 0..3 {
                assert!((back[i] - rgb[i]).abs() < 1e-13, "{rgb:?} becomes {back:?}");
            }
        }
    }

    #[test]
    fn transfer_function_has_its_standard_values() {
        // ((0.5 + 0.055) / 1.055)^2.4
        assert!((srgb_decode(0.5) - 0.214_041_14).abs() < 1e-7);
        assert!((srgb_encode(0.5) - 0.735_357).abs() < 1e-7);
        assert_eq!(srgb_encode(0.0), 0.0);
        assert!((srgb_encode(1.0) - 1.0).abs() < 1e-7);
        assert!((srgb_decode(1.0) - 1.0).abs() < 1e-7);
    }

    #[test]
    fn byte_is_the_rounded_value() {
        let rounded = |light: f32| (srgb_encode(light) * 255.0).round() as u8;
        for k in 0..=1_000_000_u32 {
            let light = k as f32 * 1e-6;
            assert_eq!(srgb_byte(light), rounded(light), "{light}");
        }
        // Where the byte changes: positive numbers are in the order of their bits.
        for byte in 1..=255_u8 {
            let threshold = srgb_decode((f32::from(byte) - 0.5) / 255.0).to_bits();
            let near: Vec<f32> = (threshold - 64..=threshold + 64).map(f32::from_bits).collect();
            for &light in &near {
                assert_eq!(srgb_byte(light), rounded(light), "{light:e}");
            }
            assert_eq!([srgb_byte(near[0]), srgb_byte(near[128])], [byte - 1, byte]);
        }
        assert_eq!([f32::NAN, -1.0, 2.0, f32::INFINITY].map(srgb_byte), [0, 0, 255, 255]);
    }

    #[test]
    fn bytes_round_trip() {
        for byte in 0..=255_u8 {
            let back = srgb_encode(srgb_decode(f32::from(byte) / 255.0)) * 255.0;
            assert_eq!(back.round() as u8, byte);
        }
    }

    #[test]
    fn transfer_function_is_odd() {
        for x in [0.001_f32, 0.2, 3.0] {
            assert_eq!(srgb_encode(-x), -srgb_encode(x));
            assert_eq!(srgb_decode(-x), -srgb_decode(x));
        }
    }
}
