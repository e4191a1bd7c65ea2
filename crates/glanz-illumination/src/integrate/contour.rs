//! Projected solid angles by integrals along borders.
//!
//! The irradiance of a point by a surface of uniform radiance L is L times the projected solid angle of the part of the surface above the horizon. The
//! projected solid angle is half the integral of n . (r x dr) / |r|^2 around this part, where r is the vector from the point to the border of the part
//! (@howell2011 section 5.5, after Lambert).

use glanz_math::DVec3;

use super::rule::{integral, sharpened};

/// Accuracy of integrals along arcs, relative to the sum of the absolute values.
const ACCURACY: f64 = 1e-13;
/// Largest number of bisections of an arc.
const DEEPEST: u32 = 30;
/// Smallest number of pieces in which an arc is integrated.
const PIECES: u32 = 6;

/// A point and the unit normal of the surface there.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReceivingPoint {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

impl ReceivingPoint {
    fn height(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }

    /// Twice the contribution of an edge: the angle that it subtends, times the cosine between the normal of the receiver and that of the plane through
    /// the point and the edge.
    fn edge(&self, a: DVec3, b: DVec3) -> f64 {
        let (a, b) = (a - self.point, b - self.point);
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 { sine.atan2(a.dot(b)) * cross.dot(self.normal) / sine } else { 0.0 }
    }

    /// Projected solid angle of a flat polygon, from either side, sr.
    pub(super) fn of_polygon(&self, corners: &[DVec3]) -> f64 {
        let mut sum = 0.0;
        let mut ends: Option<[DVec3; 2]> = None;
        // The part of each side above the horizon; a side along the horizon, perpendicular to the normal, closes the polygon.
        for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (at_a, at_b) = (self.height(a), self.height(b));
            if at_a <= 0.0 && at_b <= 0.0 {
                continue;
            }
            let cut = || a.lerp(b, at_a / (at_a - at_b));
            let (from, to) = (if at_a <= 0.0 { cut() } else { a }, if at_b <= 0.0 { cut() } else { b });
            sum += self.edge(from, to);
            let [leaves, enters] = ends.unwrap_or([to, from]);
            ends = Some([if at_b <= 0.0 { to } else { leaves }, if at_a <= 0.0 { from } else { enters }]);
        }
        if corners.iter().any(|&c| self.height(c) <= 0.0)
            && let Some([leaves, enters]) = ends
        {
            sum += self.edge(leaves, enters);
        }
        0.5 * sum.abs()
    }

    /// Projected solid angle of a disk, from either side, sr.
    pub(super) fn of_disk(&self, center: DVec3, normal: DVec3, radius: f64) -> f64 {
        let (x, y) = normal.any_orthonormal_pair();
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            center + radius * (cos * x + sin * y)
        };
        // The height over the horizon is h + a cos(angle - middle).
        let height = self.height(center);
        let (a, b) = (radius * x.dot(self.normal), radius * y.dot(self.normal));
        let swing = a.hypot(b);
        if height <= -swing {
            return 0.0;
        }
        let half = if height >= swing { std::f64::consts::PI } else { (-height / swing).acos() };
        let middle = b.atan2(a);
        let slope = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let r = at(angle) - self.point;
            r.cross(radius * (cos * y - sin * x)).dot(self.normal) / r.length_squared()
        };
        let pieces = (0..PIECES).map(|i| {
            let stop = |i: u32| middle + half * (2.0 * f64::from(i) / f64::from(PIECES) - 1.0);
            arc(&slope, [stop(i), stop(i + 1)], DEEPEST)
        });
        let mut sum: f64 = pieces.sum();
        if height < swing {
            sum += self.edge(at(middle + half), at(middle - half));
        }
        0.5 * sum.abs()
    }
}

/// The integral of a smooth function; the range is halved until two rules agree.
fn arc(f: &impl Fn(f64) -> f64, range: [f64; 2], depth: u32) -> f64 {
    let mut content = 0.0;
    let pair = integral(range, |t| {
        let value = f(t);
        content += value.abs();
        value
    });
    let content = content / 7.0 * (range[1] - range[0]);
    let error = sharpened((pair.fine - pair.coarse).abs(), content);
    if depth == 0 || error <= ACCURACY * content {
        return pair.fine;
    }
    let middle = 0.5 * (range[0] + range[1]);
    arc(f, [range[0], middle], depth - 1) + arc(f, [middle, range[1]], depth - 1)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const UP: ReceivingPoint = ReceivingPoint { point: DVec3::ZERO, normal: DVec3::Z };

    #[test]
    fn disk_above_is_the_square_of_the_sine() {
        for radius in [1e-3, 0.3, 1.0, 50.0] {
            let seen = UP.of_disk(DVec3::Z, -DVec3::Z, radius);
            // A disk parallel to the receiver, centred above it: pi R^2 / (R^2 + h^2).
            let expected = PI * radius * radius / (radius * radius + 1.0);
            assert!((seen - expected).abs() < 1e-9 * expected, "{radius}: {seen} {expected}");
        }
    }

    #[test]
    fn halves_of_a_disk_cut_by_the_horizon() {
        // A disk with its middle on the horizon, facing the receiver: half of a cone of half angle s about the horizon. With Snyder's formula for
        // a sphere at 90 degrees, (s - sin s cos s) is its projected solid angle; the disk of radius tan s at distance 1 fills the cone.
        for s in [0.01_f64, 0.4, 1.2] {
            let seen = UP.of_disk(DVec3::X, DVec3::X, s.tan());
            let expected = s - s.sin() * s.cos();
            assert!((seen - expected).abs() < 1e-9 * expected, "{s}: {seen} {expected}");
        }
        assert_eq!(UP.of_disk(-DVec3::Z, DVec3::Z, 0.5), 0.0);
    }

    #[test]
    fn polygon_is_cut_by_the_horizon() {
        // A square on the wall x = 1 from z = -1 to 1 and y = -1 to 1: only the upper half is above the horizon.
        let square =
            |low: f64| [(-1.0, low), (1.0, low), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| DVec3::new(1.0, y, z));
        let whole = UP.of_polygon(&square(-1.0));
        let upper = UP.of_polygon(&square(0.0));
        assert!((whole - upper).abs() < 1e-14);
        // Two rectangles with a common edge at a right angle, from a point at the edge's middle (@howell2011, factor B-4):
        // (1/2 pi) (atan(1/y) - y / sqrt(x^2 + y^2) atan(1 / sqrt(x^2 + y^2))) per half, with y = distance / width, x = height / width.
        let root = 2.0_f64.sqrt();
        let expected = (1.0_f64.atan() - (1.0 / root).atan() / root).abs();
        assert!((upper - expected).abs() < 1e-12, "{upper} {expected}");
        // From both sides, and nothing from below.
        let reversed: Vec<DVec3> = square(0.0).into_iter().rev().collect();
        assert!((UP.of_polygon(&reversed) - upper).abs() < 1e-14);
        assert_eq!(UP.of_polygon(&square(0.0).map(|p| p - 3.0 * DVec3::Z)), 0.0);
    }
}
