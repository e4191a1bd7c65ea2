//! Spherical triangles: solid angles and uniform directions.

use glanz_math::{DVec2, DVec3};

/// The directions from a point to a triangle.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    /// Unit directions to the corners.
    corners: [DVec3; 3],
    /// Steradians.
    solid_angle: f64,
}

impl SphericalTriangle {
    /// The triangle with corners in these directions, of any length above 0; the order does not matter.
    ///
    /// # Source
    /// @vanoosterom1983.
    #[must_use]
    pub fn new(towards: [DVec3; 3]) -> Self {
        let corners @ [a, b, c] = towards.map(DVec3::normalize);
        let volume = a.dot(b.cross(c)).abs();
        let solid_angle = 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        Self { corners, solid_angle }
    }

    /// Steradians, at most 2 pi; 0 if the corners lie in a plane with the origin and not around it, NaN if one is at the origin.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A unit direction, uniform by solid angle, from a number uniform in [0, 1)^2; `None` if the solid angle is 0 up to rounding.
    ///
    /// # Source
    /// @arvo1995: the side from the first corner to the second and `xi.x` give a part of the triangle by its area, `xi.y` a direction on its third side.
    #[must_use]
    pub fn sample(&self, xi: DVec2) -> Option<DVec3> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (a.cross(b), a.cross(c));
        let alpha = ab.cross(ac).length().atan2(ab.dot(ac));
        let (sin_alpha, cos_alpha) = alpha.sin_cos();
        // Of the area of the part minus the angle at the first corner.
        let (s, t) = (xi.x * self.solid_angle - alpha).sin_cos();
        let (u, v) = (t - cos_alpha, s + sin_alpha * a.dot(b));
        let denominator = (v * s + u * t) * sin_alpha;
        let cos_side = ((v * t - u * s) * cos_alpha - v) / denominator;
        if !cos_side.is_finite() {
            return None;
        }
        let cos_side = cos_side.clamp(-1.0, 1.0);
        let third = cos_side * a + (1.0 - cos_side * cos_side).sqrt() * across(c, a)?;
        // The height above the second corner, 1 - cos of the angle to it, is uniform.
        let cos_angle = 1.0 - xi.y * (1.0 - third.dot(b));
        let direction = cos_angle * b + (1.0 - cos_angle * cos_angle).max(0.0).sqrt() * across(third, b)?;
        direction.try_normalize()
    }
}

/// The unit direction across `axis` towards `to`.
fn across(to: DVec3, axis: DVec3) -> Option<DVec3> {
    (to - to.dot(axis) * axis).try_normalize()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::statistics::chi_square;
    use crate::{PixelSampler, SamplerKind};

    #[test]
    fn solid_angles_are_those_of_closed_forms() {
        let octant = SphericalTriangle::new([DVec3::X, DVec3::Y * 2.0, DVec3::Z * 0.1]);
        assert!((octant.solid_angle() - 0.5 * PI).abs() < 1e-14);
        // A face of a cube is a sixth of the sphere, half of it a twelfth.
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let half = SphericalTriangle::new([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)]);
        assert!((half.solid_angle() - PI / 3.0).abs() < 1e-14);
        // Small ones are flat.
        let small = SphericalTriangle::new([corner(0.0, 0.0), corner(1e-6, 0.0), corner(0.0, 1e-6)]);
        assert!((small.solid_angle() / 0.5e-12 - 1.0).abs() < 1e-6);
        assert_eq!(SphericalTriangle::new([DVec3::X, DVec3::Y, DVec3::X + DVec3::Y]).solid_angle(), 0.0);
    }

    /// Triangles of all sizes, with an obtuse and a narrow one.
    fn triangles() -> [[DVec3; 3]; 4] {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        [
            [DVec3::X, DVec3::Y, DVec3::Z],
            [at(-3.0, -1.0, 0.2), at(4.0, -1.0, 0.2), at(0.0, 5.0, 0.1)],
            [at(0.3, 0.1, 1.0), at(0.31, 0.1, 1.0), at(0.3, 0.12, 1.0)],
            [at(-2.0, 0.0, 1.0), at(2.0, 0.0, 1.0), at(0.3, 0.01, 1.0)],
        ]
    }

    fn grid(side: u32) -> impl Iterator<Item = DVec2> {
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side).flat_map(move |i| (0..side).map(move |j| DVec2::new(at(i), at(j))))
    }

    #[test]
    fn mean_of_directions_is_lamberts_vector() {
        for towards in triangles() {
            let triangle = SphericalTriangle::new(towards);
            let corners = towards.map(DVec3::normalize);
            // The integral of the direction over a spherical polygon: half of the sum of the angles of its sides, along the normals of their planes.
            let side = |i: usize| {
                let normal = corners[i].cross(corners[(i + 1) % 3]);
                normal.normalize() * normal.length().atan2(corners[i].dot(corners[(i + 1) % 3]))
            };
            let integral = 0.5 * (side(0) + side(1) + side(2));
            let sign = integral.dot(corners[0] + corners[1] + corners[2]).signum();
            let expected = sign * integral / triangle.solid_angle();
            let side = 128;
            let sum: DVec3 = grid(side).map(|xi| triangle.sample(xi).unwrap()).sum();
            let mean = sum / f64::from(side * side);
            // The midpoint rule, with a root at the first corner.
            assert!(mean.distance(expected) < 2e-4, "{towards:?}: {mean} {expected}");
        }
    }

    #[test]
    fn directions_are_uniform_in_the_parts_of_a_triangle() {
        for towards in triangles() {
            let [a, b, c] = towards;
            let (ab, bc, ca) = (a + b, b + c, c + a);
            let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            let inside = |[a, b, c]: [DVec3; 3], w: DVec3| {
                let sides = [a.cross(b).dot(w), b.cross(c).dot(w), c.cross(a).dot(w)];
                sides.iter().all(|&x| x >= 0.0) || sides.iter().all(|&x| x <= 0.0)
            };
            let triangle = SphericalTriangle::new(towards);
            let count = 4000_u32;
            let mut found = [0; 4];
            for i in 0..count {
                let xi = PixelSampler::new(SamplerKind::Independent, count, 3, [0, 0], i).next_2d();
                let w = triangle.sample(xi).unwrap();
                assert!((w.length() - 1.0).abs() < 1e-14);
                if let Some(part) = parts.iter().position(|&part| inside(part, w)) {
                    found[part] += 1;
                }
            }
            assert!(found.iter().sum::<u64>() >= u64::from(count) - 4, "{found:?} of {count}");
            let solid_angles = parts.map(|part| SphericalTriangle::new(part).solid_angle());
            let whole: f64 = solid_angles.iter().sum();
            assert!((whole / triangle.solid_angle() - 1.0).abs() < 1e-9);
            let expected = solid_angles.map(|part| part / whole * f64::from(count));
            // One fair test in 10^4 fails.
            assert!(chi_square(&found, &expected).p_value > 1e-4, "{found:?} {expected:?}");
        }
    }
}
