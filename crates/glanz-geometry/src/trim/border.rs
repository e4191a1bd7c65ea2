//! Distances across curves on surfaces.

use glanz_math::{DVec2, DVec3};

/// Distance in space, metres, between a curve on a surface and the curve beside it whose distance in parameters is 1. `du` and `dv`: the derivatives of
/// the surface by the parameters, metres; `along`: direction of the curve in parameters.
///
/// It is the area of the parallelogram of both derivatives over the length in space of a unit of the curve. Next to a pole, where a parallel has no length, it
/// remains the distance of parallels; that of meridians vanishes.
#[must_use]
pub fn scale_across([du, dv]: [DVec3; 2], along: DVec2) -> f64 {
    let along = along.normalize_or(DVec2::X);
    let (on_curve, across) = (du * along.x + dv * along.y, dv * along.x - du * along.y);
    // Where the curve stands still, up to the rounding of derivatives, it has no direction.
    if on_curve.length() <= f64::EPSILON.sqrt() * across.length() {
        return across.length();
    }
    let skew = across.dot(on_curve) / on_curve.length_squared();
    (across - skew * on_curve).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_across_a_curve_is_the_distance_of_its_neighbours() {
        let (du, dv) = (DVec3::X * 3.0, DVec3::Y * 0.5);
        assert_eq!(scale_across([du, dv], DVec2::X * 7.0), 0.5);
        assert_eq!(scale_across([du, dv], DVec2::Y), 3.0);
        // Lines u + v = c are 1 / sqrt 2 apart in parameters per unit of c: in space x / 3 + 2 y = c.
        let apart = (1.0 / 9.0 + 4.0_f64).sqrt().recip() * 2.0_f64.sqrt();
        assert!((scale_across([du, dv], DVec2::new(1.0, -1.0)) - apart).abs() < 1e-15);
        // Sheared parameters: lines of constant v are as far apart as before.
        assert!((scale_across([du, dv + 10.0 * du], DVec2::X) - 0.5).abs() < 1e-14);
        // At a pole.
        assert_eq!(scale_across([DVec3::ZERO, dv], DVec2::X), 0.5);
        assert_eq!(scale_across([1e-15 * dv, dv], DVec2::X), 0.5);
        assert_eq!(scale_across([DVec3::ZERO, dv], DVec2::Y), 0.0);
    }
}
