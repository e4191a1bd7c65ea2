//! Sine and cosine without the range reduction of the library.

use std::f64::consts::TAU;

/// Sine and cosine of an angle between -pi/4 and pi/4, to two units in the last place.
///
/// A fifth of the instructions of the library's function, which reduces any angle first.
///
/// # Source
/// The minimax polynomials of @fdlibm, `k_sin.c` and `k_cos.c`; the cosine is summed as in FreeBSD's `msun`.
#[inline]
#[must_use]
pub fn sin_cos_of_eighth(x: f64) -> (f64, f64) {
    let z = x * x;
    let r = 8.333_333_333_322_49e-3
        + z * (-1.984_126_982_985_795e-4
            + z * (2.755_731_370_707_006_8e-6
                + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)));
    let sin = x + z * x * (-1.666_666_666_666_663_2e-1 + z * r);
    let r = z
        * (4.166_666_666_666_66e-2
            + z * (-1.388_888_888_887_411e-3
                + z * (2.480_158_728_947_673e-5
                    + z * (-2.755_731_435_139_066_3e-7
                        + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11)))));
    let half = 0.5 * z;
    let w = 1.0 - half;
    (sin, w + (((1.0 - w) - half) + z * r))
}

/// Sine and cosine of the angle 2 pi `turn`, with `turn` in [0, 1], to two units in the last place of 1.
#[inline]
#[must_use]
pub fn sin_cos_of_turn(turn: f64) -> (f64, f64) {
    // The rest after the nearest quarter is exact, up to the last bit next to an eighth.
    let quarter = (4.0 * turn + 0.5) as u32;
    debug_assert!((-0.125..=1.125).contains(&turn), "a turn of {turn}");
    let (s, c) = sin_cos_of_eighth(TAU * (turn - 0.25 * f64::from(quarter)));
    let (s, c) = if quarter & 1 == 0 { (s, c) } else { (c, -s) };
    if quarter & 2 == 0 { (s, c) } else { (-s, -c) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_library_to_two_units_in_the_last_place() {
        let close = |a: f64, b: f64| (a - b).abs() <= f64::EPSILON * b.abs();
        for k in -100_000..=100_000 {
            let x = FRAC_PI_4 * 1e-5 * f64::from(k);
            let ((s, c), (sin, cos)) = (sin_cos_of_eighth(x), x.sin_cos());
            assert!(close(s, sin) && close(c, cos), "{x}: {s} {c}");
        }
        for k in 0..=100_000 {
            let turn = 1e-5 * f64::from(k);
            let ((s, c), (sin, cos)) = (sin_cos_of_turn(turn), (TAU * turn).sin_cos());
            // The library's angle carries the rounding of the product.
            assert!((s - sin).hypot(c - cos) < 1e-15 && (s * s + c * c - 1.0).abs() < 1e-15, "{turn}");
        }
        assert_eq!(
            [0.0, 0.25, 0.5, 1.0].map(sin_cos_of_turn),
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)]
        );
    }
}
