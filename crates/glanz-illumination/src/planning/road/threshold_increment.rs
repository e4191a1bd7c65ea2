//! Disability glare: veiling luminance and threshold increment.

use glanz_math::DVec3;

use crate::planning::luminaire::PlacedLuminaire;

/// Age of the observer of EN 13201, years.
pub const OBSERVER_AGE: f64 = 23.0;

/// Angles from the line of sight, degrees: of the small-angle formula from the first, of the usual one from the second to the third.
const GLARE_ANGLES: [f64; 3] = [0.1, 1.5, 60.0];

/// The threshold increment of an observer who moves along a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThresholdIncrement {
    /// Largest threshold increment, per cent.
    pub percent: f64,
    /// Its veiling luminance, cd/m^2.
    pub veiling_luminance: f64,
    /// Place of the observer along the road, metres.
    pub station: f64,
}

/// Equivalent veiling luminance, cd/m^2, of luminaires for an eye at this point with a unit line of sight.
///
/// ```text
/// 1.5 to 60 degrees   Lv = sum of 9.86 (1 + (A / 66.4)^4) E / theta^2
/// 0.1 to 1.5 degrees  Lv = sum of (10 / theta^3 + 5 / theta^2 (1 + (A / 62.5)^4)) E
/// ```
///
/// with the illuminance E, lx, of each luminaire on a plane across the line of sight, its angle theta from it, degrees, and the age A, years. At 23 years the first is 10 E / theta^2.
/// Luminaires at other angles do not count.
///
/// # Source
/// @cie146 (not available) and EN 13201-3:2015, as secondary literature has them.
#[must_use]
pub fn veiling_luminance(luminaires: &[PlacedLuminaire], eye: DVec3, sight: DVec3, age: f64) -> f64 {
    let of_luminaire = |luminaire: &PlacedLuminaire| {
        let offset = luminaire.position - eye;
        let theta = offset.angle_between(sight).to_degrees();
        let squared = offset.length_squared();
        let lux = luminaire.intensity_towards(eye) * theta.to_radians().cos() / squared;
        if (GLARE_ANGLES[1]..=GLARE_ANGLES[2]).contains(&theta) {
            9.86 * (1.0 + (age / 66.4).powi(4)) * lux / (theta * theta)
        } else if (GLARE_ANGLES[0]..GLARE_ANGLES[1]).contains(&theta) {
            (10.0 / theta.powi(3) + 5.0 / theta.powi(2) * (1.0 + (age / 62.5).powi(4))) * lux
        } else {
            0.0
        }
    };
    luminaires.iter().map(of_luminaire).sum()
}

/// Threshold increment, per cent, for a veiling luminance and the mean luminance of the road, cd/m^2; infinite on a dark road.
#[must_use]
pub fn threshold_increment(veiling: f64, mean: f64) -> f64 {
    if veiling == 0.0 {
        0.0
    } else if mean <= 5.0 {
        65.0 * veiling / mean.powf(0.8)
    } else {
        95.0 * veiling / mean.powf(1.05)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::{downlight, uniform};

    #[test]
    fn veiling_luminance_agrees_with_the_calculation_by_hand() {
        // docs/lighting.md, "Threshold increment": 5000 cd, 8.5 m above the eye and 40 m ahead; the line of sight is 1 degree down.
        // theta = atan(8.5 / 40) + 1 = 12.997 degrees, r^2 = 1672.25 m^2, E = 5000 cos 12.997 / 1672.25 = 2.9134 lx, Lv = 10.002 * 2.9134 / 12.997^2 = 0.17251 cd/m^2,
        // TI = 65 * 0.17251 / 1 = 11.21 %.
        let luminaire = downlight(uniform(5000.0), DVec3::new(40.0, 0.0, 10.0));
        let (sin, cos) = 1.0_f64.to_radians().sin_cos();
        let (eye, sight) = (DVec3::new(0.0, 0.0, 1.5), DVec3::new(cos, 0.0, -sin));
        let veiling = veiling_luminance(std::slice::from_ref(&luminaire), eye, sight, OBSERVER_AGE);
        assert!((veiling - 0.172_51).abs() < 2e-5, "{veiling}");
        assert!((threshold_increment(veiling, 1.0) - 11.213).abs() < 0.002);
        // 2 cd/m^2: 2^-0.8; 10 cd/m^2: the other formula.
        assert!((threshold_increment(0.2, 2.0) - 13.0 * 0.574_349).abs() < 1e-4);
        assert!((threshold_increment(0.2, 10.0) - 19.0 * 0.089_125).abs() < 1e-4);
        assert_eq!((threshold_increment(0.0, 0.0), threshold_increment(0.1, 0.0)), (0.0, f64::INFINITY));
    }

    #[test]
    fn angles_decide_on_the_formula() {
        // 1000 lx across the line of sight, at these angles.
        let at = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let luminaire = downlight(uniform(1000.0 / cos), DVec3::new(cos, 0.0, sin));
            veiling_luminance(&[luminaire], DVec3::ZERO, DVec3::X, 62.5)
        };
        // Age 62.5: 1 + (62.5 / 66.4)^4 = 1.784960, and 2 for small angles.
        for (degrees, expected) in [
            (0.05, 0.0),
            (1.0, 1000.0 * (10.0 + 5.0 * 2.0)),
            (10.0, 1000.0 * 9.86 * 1.784_96 / 100.0),
            (61.0, 0.0),
        ] {
            let found = at(degrees);
            assert!((found - expected).abs() < 1e-4 * expected + 1e-12, "{degrees}: {found}, {expected}");
        }
    }
}
