//! Bounds on rounding errors.
//!
//! Every hit has an error box that provably contains the true point; secondary rays start at the edge of that box instead of at a
//! tuned epsilon. The bounds follow @higham2002 chapter 3.

use crate::DVec3;

/// Unit roundoff of `f64`: half the distance from 1 to the next number.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;

/// Bound on the relative error of `n` chained roundings: `n u / (1 - n u)`.
///
/// # Source
/// @higham2002 lemma 3.1.
#[must_use]
pub const fn gamma(n: u32) -> f64 {
    let nu = n as f64 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// Moves `point` out of its error box, to the side of the surface that `direction` points to.
///
/// `error` is the absolute error of `point` per axis, `normal` the geometric unit normal of the surface. The distance of the
/// result from the tangent plane is at least the extent of the box along the normal, and every coordinate is rounded away from
/// the surface.
///
/// # Source
/// @pharr2023 section 6.8.6.
#[inline]
#[must_use]
pub fn offset_origin(point: DVec3, error: DVec3, normal: DVec3, direction: DVec3) -> DVec3 {
    let distance = normal.abs().dot(error);
    let side = if direction.dot(normal) < 0.0 { -1.0 } else { 1.0 };
    let offset = normal * (distance * side);
    let moved = point + offset;
    // |x| 2^-52 is between one and two units in the last place of x: enough to undo the rounding of the sum.
    moved + moved.abs() * f64::EPSILON * DVec3::ONE.copysign(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_bounds_a_long_product() {
        // 0.1 is not representable: (1 + u)^n stays below 1 + gamma(n).
        let n = 1000;
        assert!(gamma(n) > n as f64 * UNIT_ROUNDOFF);
        assert!(gamma(n) < 1.001 * n as f64 * UNIT_ROUNDOFF);
    }

    #[test]
    fn offset_origin_leaves_the_error_box_on_the_side_of_the_direction() {
        let point = DVec3::new(1.0, -2.0, 3.0);
        let error = DVec3::splat(1e-12);
        let normal = DVec3::new(1.0, 1.0, 1.0).normalize();
        for direction in [normal, -normal] {
            let origin = offset_origin(point, error, normal, direction);
            let extent = normal.abs().dot(error);
            assert!((origin - point).dot(direction) >= extent);
        }
    }
}
