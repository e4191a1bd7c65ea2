//! Evaluation of cubic patches by routines of fixed size, so that general routines do not slow down the iterations.

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_math::{DVec3, glam::DVec4};

/// A point and its derivatives by u and v.
pub(super) type Linear = (DVec3, DVec3, DVec3);

/// A rational bicubic patch: homogeneous control points, those of equal u side by side.
#[derive(Clone, Debug)]
pub(super) struct FixedBicubic([[DVec4; 4]; 4]);

impl FixedBicubic {
    /// `None` unless the patch is bicubic.
    pub(super) fn of(patch: &TensorPatch) -> Option<Self> {
        let (rows, rest) = patch.control_points().as_chunks::<4>();
        (patch.degrees() == (3, 3) && rest.is_empty()).then_some(())?;
        Some(Self(<[[DVec4; 4]; 4]>::try_from(rows).ok()?))
    }

    pub(super) fn linear(&self, u: f64, v: f64) -> Linear {
        let ([bu, du], [bv, dv]) = (cubic(u), cubic(v));
        let (mut point, mut by_u, mut by_v) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
        for ((row, b), d) in self.0.iter().zip(bu).zip(du) {
            let value = sum(row, &bv);
            point += value * b;
            by_u += value * d;
            by_v += sum(row, &dv) * b;
        }
        let per = 1.0 / point.w;
        let at = point.truncate() * per;
        let rise = |d: DVec4| (d.truncate() - at * d.w) * per;
        (at, rise(by_u), rise(by_v))
    }

    pub(super) fn point(&self, u: f64, v: f64) -> DVec3 {
        let ([bu, _], [bv, _]) = (cubic(u), cubic(v));
        let point: DVec4 = self.0.iter().zip(bu).map(|(row, b)| sum(row, &bv) * b).sum();
        point.truncate() / point.w
    }
}

fn sum(row: &[DVec4; 4], [a, b, c, d]: &[f64; 4]) -> DVec4 {
    (row[0] * *a + row[1] * *b) + (row[2] * *c + row[3] * *d)
}

/// Cubic Bernstein polynomials and their derivatives.
fn cubic(x: f64) -> [[f64; 4]; 2] {
    let y = 1.0 - x;
    let (xx, xy, yy) = (x * x, x * y, y * y);
    [
        [yy * y, 3.0 * yy * x, 3.0 * y * xx, xx * x],
        [-3.0 * yy, 3.0 * (yy - 2.0 * xy), 3.0 * (2.0 * xy - xx), 3.0 * xx],
    ]
}

/// A polynomial cubic triangle: control points in the order of [`TrianglePatch`]; u = s, v = t.
#[derive(Clone, Debug)]
pub(super) struct CubicTriangle([DVec3; 10]);

impl CubicTriangle {
    /// `None` unless the patch is cubic and polynomial.
    pub(super) fn of(patch: &TrianglePatch) -> Option<Self> {
        let points = <[DVec4; 10]>::try_from(patch.control_points()).ok()?;
        points.iter().all(|p| p.w == 1.0).then_some(Self(points.map(DVec4::truncate)))
    }

    /// The first two steps of de Casteljau's algorithm in one: the corners of the tangent plane's triangle.
    fn corners(&self, u: f64, v: f64) -> [DVec3; 3] {
        let (r, s, t) = (1.0 - u - v, u, v);
        let quadratic = [r * r, 2.0 * r * s, 2.0 * r * t, s * s, 2.0 * s * t, t * t];
        let p = &self.0;
        [
            [p[0], p[1], p[2], p[3], p[4], p[5]],
            [p[1], p[3], p[4], p[6], p[7], p[8]],
            [p[2], p[4], p[5], p[7], p[8], p[9]],
        ]
        .map(|net| net.into_iter().zip(quadratic).map(|(p, b)| p * b).sum())
    }

    pub(super) fn linear(&self, u: f64, v: f64) -> Linear {
        let [a, b, c] = self.corners(u, v);
        (a * (1.0 - u - v) + b * u + c * v, 3.0 * (b - a), 3.0 * (c - a))
    }

    pub(super) fn point(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c] = self.corners(u, v);
        a * (1.0 - u - v) + b * u + c * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::newton::patches::{Shape, groups};

    #[test]
    fn fixed_size_and_general_evaluation_agree() {
        for target in groups().unwrap().iter().flat_map(|g| &g.targets) {
            // Also outside of the domain, where iterations go.
            for (u, v) in [(0.2, 0.3), (0.0, 1.0), (0.5, 0.5), (-0.3, 0.7), (1.2, 0.4)] {
                let (fast, general, point) = match &target.shape {
                    Shape::Tensor(patch, fast) => {
                        (fast.linear(u, v), patch.point_and_tangents(u, v), fast.point(u, v))
                    }
                    Shape::Triangle(patch, fast) => {
                        (fast.linear(u, v), patch.point_and_tangents(u, v), fast.point(u, v))
                    }
                };
                let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-12 * target.size();
                assert!(near(fast.0, general.0) && near(fast.0, point));
                assert!(near(fast.1, general.1) && near(fast.2, general.2), "{fast:?} {general:?}");
            }
        }
    }
}
