//! Control nets of lower degree for the leaves of patches of high degree.
//!
//! A small part of a patch of degree 20 is one of lower degree to within rounding. The search by subdivision begins with these control points:
//! restricting 441 of them to the leaf, and finding the lower degree, took half the time of a hard ray.

use glanz_math::glam::DVec4;

use super::cell_coefficients;
use super::degree_reduction;
use super::net_search::HomogeneousNet;
use super::parameter_rect::DyadicRect;
use super::ray_space::{RaySpace, SurfaceFrame};

/// Degree, in one direction, from which leaves have reduced nets. These take 1 to 2 kB a leaf; for lower degrees, which are more
/// frequent, they would save less.
const LEAST_DEGREE: usize = 12;

/// Largest distance of a reduced net from the leaf across a ray, relative to [`RaySpace::noise`]: about that by which lower degrees may be off in
/// the cells of a ray.
const MOST_ERROR: f64 = 2.0;

/// Control points of a leaf, of lower degrees than its patch.
#[derive(Clone, Debug)]
pub(super) struct ReducedNet {
    pub(super) degrees: (usize, usize),
    /// Bound on its distance from the leaf across a ray, relative to [`RaySpace::noise`].
    error: f64,
    /// Homogeneous control points, that of (i, j) at j (p + 1) + i.
    points: Box<[DVec4]>,
}

impl ReducedNet {
    /// The reduced net of a part of `net`; `None` if its degrees are low or cannot be reduced.
    pub(super) fn new(net: &HomogeneousNet<'_>, part: DyadicRect, frame: &SurfaceFrame) -> Option<Self> {
        let HomogeneousNet { degrees, points, rational } = *net;
        if degrees.0.max(degrees.1) < LEAST_DEGREE {
            return None;
        }
        let [relative, size] = frame.rounding();
        let mut cells: Vec<f64> = (0..3).flat_map(|k| points.iter().map(move |point| point[k])).collect();
        if rational {
            // As long as the coordinates, so that errors of both count alike.
            cells.extend(points.iter().map(|point| size * point.w));
        }
        cell_coefficients::restrict(&mut cells, degrees, part);
        // The noise of a ray is `relative` times the sum of `size` and its largest coordinate o; a distance has the errors of three coordinates,
        // and those of o times the weight.
        let least = points.iter().fold(f64::INFINITY, |least, point| least.min(point.w));
        let unit = relative * size * least / 3.0_f64.sqrt();
        let lists = if rational { 4 } else { 3 };
        let (mut lower, mut error) = (degrees, 0.0);
        for along_x in [true, false] {
            let most = 0.5 * MOST_ERROR * unit;
            if let Some((found, off)) = degree_reduction::reduce(&mut cells, 0, lower, along_x, most, lists) {
                (lower, error) = (found, error + off / unit);
            }
        }
        if lower == degrees {
            return None;
        }
        let n = (lower.0 + 1) * (lower.1 + 1);
        let weight = |k: usize| if rational { cells[3 * n + k] / size } else { 1.0 };
        let point = |k: usize| DVec4::new(cells[k], cells[n + k], cells[2 * n + k], weight(k));
        Some(Self { degrees: lower, error, points: (0..n).map(point).collect() })
    }

    /// Fills `cells` with the Bernstein coefficients of the signed distances, times weight, from both planes through the ray, and those of
    /// the weights if `rational`. Returns the bound on their errors per weight.
    pub(super) fn project(&self, rational: bool, space: &RaySpace, cells: &mut Vec<f64>) -> f64 {
        space.project_net(&self.points, rational, cells);
        (2.0 + self.error) * space.noise
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.points)
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::{Bounds3, DVec3, Ray};

    use super::*;
    use crate::bezier::bernstein::binomial;

    /// The sum of coefficients that stand at the positions that `index` gives.
    fn sum(
        points: &[DVec4],
        (p, q): (usize, usize),
        index: impl Fn(usize, usize) -> usize,
        x: f64,
        y: f64,
    ) -> DVec4 {
        let basis =
            |n: usize, i: usize, x: f64| binomial(n, i) * x.powi(i as i32) * (1.0 - x).powi((n - i) as i32);
        let pairs = (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j)));
        pairs.map(|(i, j)| points[index(i, j)] * (basis(p, i, x) * basis(q, j, y))).sum()
    }

    #[test]
    fn distances_from_a_ray_are_those_of_the_leaf_to_a_part_of_the_noise() {
        for (degrees, rational) in [((14, 14), false), ((12, 2), false), ((2, 14), true), ((14, 12), true)] {
            let (p, q) = degrees;
            // (x, y, x^2 + y^2), divided by 1 + x / 2 if rational.
            let square = |k: usize, n: usize| (k * k.saturating_sub(1)) as f64 / (n * (n - 1)) as f64;
            let points: Vec<DVec4> = (0..(p + 1) * (q + 1))
                .map(|k| {
                    let (i, j) = (k / (q + 1), k % (q + 1));
                    let (x, y) = (i as f64 / p as f64, j as f64 / q as f64);
                    let w = if rational { 1.0 + 0.5 * x } else { 1.0 };
                    DVec4::new(x, y, square(i, p) + square(j, q), w)
                })
                .collect();
            let bounds = Bounds3::from_points(points.iter().map(|h| h.truncate() / h.w));
            let frame = SurfaceFrame::new(&bounds, 2.0, degrees);
            let net = HomogeneousNet { degrees, points: &points, rational };
            let part = [true, false, true, false, true, false, true, false]
                .into_iter()
                .fold(DyadicRect::WHOLE, |part, across_u| part.halves(across_u)[usize::from(across_u)]);
            let reduced = ReducedNet::new(&net, part, &frame).unwrap_or_else(|| panic!("{degrees:?}"));
            let (m, n) = reduced.degrees;
            assert!(5 * (m + 1) * (n + 1) <= 4 * (p + 1) * (q + 1), "{degrees:?}: {m} {n}");
            let mut most = 0.0_f64;
            for k in 1..=100 {
                let turn = |rate: f64| (rate * f64::from(k)).sin();
                let origin = DVec3::new(4.0 * turn(1.1), 5.0 * turn(2.1), 3.0 * turn(1.7));
                let ray = Ray::new(origin, DVec3::new(turn(0.7), turn(2.9), turn(1.9)));
                let space = frame.ray_space(&ray);
                let (x, y) = (turn(3.7).abs(), turn(4.3).abs());
                let at = part.at(glanz_math::DVec2::new(x, y));
                let exact = sum(&points, degrees, |i, j| i * (q + 1) + j, at.x, at.y);
                let lower = sum(&reduced.points, (m, n), |i, j| j * (m + 1) + i, x, y);
                for axis in space.axes {
                    let distance = |h: DVec4| axis.dot(h.truncate() - space.line.origin * h.w) / exact.w;
                    most = most.max((distance(exact) - distance(lower)).abs() / space.noise);
                }
            }
            // What is more is the rounding of these sums.
            assert!(most <= reduced.error + 0.05, "{degrees:?}: {most}");
            assert!(reduced.error <= MOST_ERROR, "{degrees:?}: {}", reduced.error);
        }
    }

    #[test]
    fn nets_of_low_degree_are_not_stored() {
        let points = vec![DVec4::ONE; 144];
        let frame = SurfaceFrame::new(&Bounds3::new(DVec3::ZERO, DVec3::ONE), 1.0, (11, 11));
        let net = HomogeneousNet { degrees: (11, 11), points: &points, rational: false };
        assert!(ReducedNet::new(&net, DyadicRect::WHOLE, &frame).is_none());
    }
}
