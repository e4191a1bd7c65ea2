//! Parts of patches while the surface is built, with bounds on their deviation from parallelograms.

use std::ops::Sub;

use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec3};

use super::control_net;
use super::parameter_rect::DyadicRect;
use crate::bezier::bernstein::BernsteinCoefficient;

/// A parallelogram with a thickness: for (s, t) in [-1, 1]^2 the point of the leaf is within `thickness` of
/// `center + s along_u + t along_v`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThickParallelogram {
    pub(super) center: DVec3,
    /// Half of the derivative by u, which runs from 0 to 1 over the leaf.
    pub(super) along_u: DVec3,
    /// The same for v.
    pub(super) along_v: DVec3,
    /// Metres.
    pub(super) thickness: f64,
    /// Sum of the squared bounds on the deviation of the half derivatives from `along_u` and `along_v`.
    pub(super) tangent_deviation_squared: f64,
    /// Bound on half of the second derivative in any direction of (s, t): a linear step of length h is off by at most
    /// `curvature_bound` h^2.
    pub(super) curvature_bound: f64,
}

/// A leaf while the surface is built.
#[derive(Clone, Debug)]
pub(super) struct LeafBuilder {
    pub(super) parallelogram: ThickParallelogram,
    pub(super) bounds: Bounds3,
    pub(super) subpatch: u32,
    pub(super) part: DyadicRect,
    pub(super) degrees: (usize, usize),
    pub(super) net: Vec<DVec4>,
    /// Whether a trimming curve crosses it.
    pub(super) crossed: bool,
}

fn largest(vectors: impl Iterator<Item = DVec3>) -> f64 {
    vectors.fold(0.0, |most: f64, v| most.max(v.length()))
}

impl ThickParallelogram {
    /// The parallelogram of a net of `degrees`.
    pub(super) fn new(points: &[DVec4], degrees: (usize, usize)) -> Self {
        let middle = control_net::second_order_jet(points, degrees, 0.5, 0.5);
        let (center, a, b) = (middle.s, middle.su * 0.5, middle.sv * 0.5);
        // With S = X / W, D = S - center - s a - t b is N / W: its derivatives are (N_s - D W_s) / W, (N_ss - 2 D_s W_s - D W_ss) / W and so on.
        let ([n, n_s, n_t, n_ss, n_st, n_tt], [_, w_s, w_t, w_ss, w_st, w_tt]) =
            if points.iter().all(|p| p.w == 1.0) {
                let residual = residual(points, degrees, center, a, b);
                (derivative_bounds(&residual, degrees, DVec3::length_squared), [0.0; 6])
            } else {
                // Squares of small or large weights would not be numbers.
                let least = points.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
                let points: Vec<DVec4> = points.iter().map(|p| *p * least.recip()).collect();
                let (numerator, higher) = numerator(&points, degrees, center, a, b);
                let weights: Vec<f64> = points.iter().map(|p| p.w).collect();
                let of_weights = derivative_bounds(&weights, degrees, |w| w * w);
                (derivative_bounds(&numerator, higher, DVec3::length_squared), of_weights)
            };
        // The least weight is 1.
        let thickness = n;
        let (m_a, m_b) = (n_s + thickness * w_s, n_t + thickness * w_t);
        // Halves of the pure second derivatives.
        let ss = n_ss + m_a * w_s + thickness * w_ss;
        let tt = n_tt + m_b * w_t + thickness * w_tt;
        let st = n_st + m_a * w_t + m_b * w_s + thickness * w_st;
        // Along (x, y) of length 1, x^2 ss + y^2 tt is at most the larger of both, and |x y| at most 1/2.
        let curvature_bound = ss.max(tt) + 0.5 * st;
        // The thickness is rounded, as is the net of the leaf.
        let size = largest(points.iter().map(|p| p.truncate() / p.w));
        let thickness = thickness * (1.0 + 1e-12) + gamma(64) * size;
        Self {
            center,
            along_u: a,
            along_v: b,
            thickness,
            tangent_deviation_squared: (m_a * m_a + m_b * m_b) * (1.0 + 1e-12),
            curvature_bound,
        }
    }

    /// The Jacobian deviation: a bound on the relative change of the Jacobian, projected along the normal.
    pub(super) fn jacobian_deviation(&self) -> f64 {
        let area = self.along_u.cross(self.along_v).length_squared();
        (self.tangent_deviation_squared * (self.along_u.length_squared() + self.along_v.length_squared())
            / area)
            .sqrt()
    }

    /// A box around the parallelogram and its thickness.
    pub(super) fn bounds(&self) -> Bounds3 {
        let half = self.along_u.abs() + self.along_v.abs() + DVec3::splat(self.thickness);
        Bounds3::new(self.center - half, self.center + half)
    }
}

/// Coefficients of a polynomial patch less `center + s a + t b`.
fn residual(points: &[DVec4], (p, q): (usize, usize), center: DVec3, a: DVec3, b: DVec3) -> Vec<DVec3> {
    let along = |i: usize, degree: usize| 2.0 * i as f64 / degree as f64 - 1.0;
    let rows = points.chunks_exact(q + 1).enumerate();
    let row = |(i, row): (usize, &[DVec4])| {
        let by_s = a * along(i, p);
        row.iter()
            .enumerate()
            .map(|(j, point)| point.truncate() - center - by_s - b * along(j, q))
            .collect::<Vec<_>>()
    };
    rows.flat_map(row).collect()
}

/// Coefficients of `X - (center + s a + t b) W` for a rational patch X / W, and their degrees, one higher than those of the patch.
fn numerator(
    points: &[DVec4],
    (p, q): (usize, usize),
    center: DVec3,
    a: DVec3,
    b: DVec3,
) -> (Vec<DVec3>, (usize, usize)) {
    let mut numerator = vec![DVec3::ZERO; (p + 2) * (q + 2)];
    for (i, row) in points.chunks_exact(q + 1).enumerate() {
        for (j, point) in row.iter().enumerate() {
            // About the centre, so that cancellation is least.
            let here = point.truncate() - center * point.w;
            for (k, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                // The product with Bernstein polynomials of degree 1.
                let share = |k: usize, i: usize, degree: usize| {
                    (if k == 0 { degree + 1 - i } else { i + 1 }) as f64 / (degree + 1) as f64
                };
                let corner = a * (2.0 * k as f64 - 1.0) + b * (2.0 * l as f64 - 1.0);
                numerator[(i + k) * (q + 2) + j + l] +=
                    (here - corner * point.w) * (share(k, i, p) * share(l, j, q));
            }
        }
    }
    (numerator, (p + 1, q + 1))
}

/// Bounds on a polynomial in s and t over [-1, 1]^2 and its derivatives by s, t, s s, s t and t t, the pure second ones halved: the largest
/// of their Bernstein coefficients.
fn derivative_bounds<T: BernsteinCoefficient + Sub<Output = T>>(
    coefficients: &[T],
    (p, q): (usize, usize),
    length_squared: impl Fn(T) -> f64,
) -> [f64; 6] {
    let at = |i: usize, j: usize| coefficients[i * (q + 1) + j];
    let (dp, dq) = (0.5 * p as f64, 0.5 * q as f64);
    let (ddp, ddq) = (0.25 * dp * (p as f64 - 1.0), 0.25 * dq * (q as f64 - 1.0));
    let mut most = [0.0_f64; 6];
    let mut meet = |k: usize, v: T| most[k] = most[k].max(length_squared(v));
    for i in 0..=p {
        for j in 0..=q {
            let here = at(i, j);
            meet(0, here);
            if i < p {
                meet(1, (at(i + 1, j) - here) * dp);
            }
            if j < q {
                meet(2, (at(i, j + 1) - here) * dq);
            }
            if i + 2 <= p {
                meet(3, (at(i + 2, j) - at(i + 1, j) * 2.0 + here) * ddp);
            }
            if i < p && j < q {
                meet(4, (at(i + 1, j + 1) - at(i + 1, j) - at(i, j + 1) + here) * (dp * dq));
            }
            if j + 2 <= q {
                meet(5, (at(i, j + 2) - at(i, j + 1) * 2.0 + here) * ddq);
            }
        }
    }
    most.map(f64::sqrt)
}

/// Whether all control points lie on a line to within the rounding of the net.
pub(super) fn is_line(points: &[DVec4]) -> bool {
    let spatial = || points.iter().map(|p| p.truncate() / p.w);
    let farthest = |from: DVec3| {
        spatial()
            .fold(from, |far, p| if p.distance_squared(from) > far.distance_squared(from) { p } else { far })
    };
    let Some(first) = spatial().next() else { return true };
    let start = farthest(first);
    let direction = (farthest(start) - start).normalize_or_zero();
    let rounding = gamma(16) * largest(spatial());
    spatial().all(|p| {
        let from = p - start;
        (from - direction * from.dot(direction)).length() <= rounding
    })
}

impl LeafBuilder {
    pub(super) fn new(subpatch: u32, part: DyadicRect, net: Vec<DVec4>, degrees: (usize, usize)) -> Self {
        let parallelogram = ThickParallelogram::new(&net, degrees);
        let hull = net.iter().fold(Bounds3::EMPTY, |b, p| b.including(p.truncate() / p.w));
        // Both contain the leaf. The thickness covers the rounding of the net, which the hull does not.
        let size = hull.min.abs().max(hull.max.abs()).max_element();
        let pad = DVec3::splat(gamma(64) * size);
        let thick = parallelogram.bounds();
        let bounds = Bounds3::new((hull.min - pad).max(thick.min), (hull.max + pad).min(thick.max));
        Self { parallelogram, bounds, subpatch, part, degrees, net, crossed: false }
    }

    /// Parts and nets of its halves along the direction in which it is more curved.
    pub(super) fn halves(&self) -> [(DyadicRect, Vec<DVec4>); 2] {
        self.halves_across(is_more_curved_along_u(&self.net, self.degrees))
    }

    /// The halves, along either direction, of which the sum of the Jacobian deviations is less. Narrower sectors of a cone keep its deviation; of two
    /// shorter ones, only that at the apex does.
    pub(super) fn less_deviating_halves(&self) -> [(DyadicRect, Vec<DVec4>); 2] {
        let by_curvature = is_more_curved_along_u(&self.net, self.degrees);
        let [first, second] = [by_curvature, !by_curvature].map(|across_u| self.halves_across(across_u));
        let [of_first, of_second] = [&first, &second].map(|halves| -> f64 {
            halves
                .iter()
                .map(|(_, net)| ThickParallelogram::new(net, self.degrees).jacobian_deviation())
                .sum()
        });
        // NaN, of a half without area, is above every sum.
        if of_second < of_first || (of_first.is_nan() && !of_second.is_nan()) { second } else { first }
    }

    fn halves_across(&self, across_u: bool) -> [(DyadicRect, Vec<DVec4>); 2] {
        let [low, high] = control_net::split(&self.net, self.degrees, across_u);
        let [below, above] = self.part.halves(across_u);
        [(below, low), (above, high)]
    }
}

/// Whether the control polygons along u are more curved than those along v; where neither is curved, whether they are longer.
pub(super) fn is_more_curved_along_u(points: &[DVec4], (p, q): (usize, usize)) -> bool {
    let at = |i: usize, j: usize| {
        let point = points[i * (q + 1) + j];
        point.truncate() / point.w
    };
    let (mut u, mut v) = ([0.0_f64; 2], [0.0_f64; 2]);
    for i in 0..=p {
        for j in 0..=q {
            if i >= 1 {
                u[0] = u[0].max((at(i, j) - at(i - 1, j)).length() * p as f64);
            }
            if j >= 1 {
                v[0] = v[0].max((at(i, j) - at(i, j - 1)).length() * q as f64);
            }
            if i >= 2 {
                let second = at(i, j) - at(i - 1, j) * 2.0 + at(i - 2, j);
                u[1] = u[1].max(second.length() * (p * (p - 1)) as f64);
            }
            if j >= 2 {
                let second = at(i, j) - at(i, j - 1) * 2.0 + at(i, j - 2);
                v[1] = v[1].max(second.length() * (q * (q - 1)) as f64);
            }
        }
    }
    // A twisted patch without curved lines is halved along its longer side.
    u[1] + 1e-3 * u[0] >= v[1] + 1e-3 * v[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curvature_bound_of_a_quadratic_patch_is_exact() {
        // Bernstein coefficients of 1, x and x^2 over [-1, 1].
        let (one, line, square) = ([1.0; 3], [-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
        // Half of the second derivative is largest along an axis, except for s t: 1/2, on the diagonals.
        for (terms, expected) in [
            (vec![(square, one, 1.0)], 1.0),
            (vec![(one, square, 1.0)], 1.0),
            (vec![(square, one, 1.0), (one, square, 1.0)], 1.0),
            (vec![(square, one, 1.0), (one, square, -1.0)], 1.0),
            (vec![(line, line, 1.0)], 0.5),
        ] {
            let point = |i: usize, j: usize| {
                let z = terms.iter().map(|(by_s, by_t, sign)| by_s[i] * by_t[j] * sign).sum();
                DVec3::new(line[i], line[j], z).extend(1.0)
            };
            let net: Vec<DVec4> = (0..9).map(|k| point(k / 3, k % 3)).collect();
            let bound = ThickParallelogram::new(&net, (2, 2)).curvature_bound;
            assert!((bound - expected).abs() < 1e-14, "{bound} of {expected}");
        }
    }

    #[test]
    fn sector_of_a_cone_becomes_shorter() {
        let apex = DVec4::new(0.0, 0.0, 0.0, 1.0);
        let arc = [[1.0, 0.0], [1.0, 0.5], [0.7, 1.0]].map(|[x, y]| DVec4::new(x, y, 1.0, 1.0));
        let net = [[apex; 3], arc].concat();
        let leaf = LeafBuilder::new(0, DyadicRect::WHOLE, net, (1, 2));
        let widths = |[(low, _), _]: [(DyadicRect, Vec<DVec4>); 2]| low.width().to_array();
        assert_eq!(widths(leaf.halves()), [1.0, 0.5]);
        assert_eq!(widths(leaf.less_deviating_halves()), [0.5, 1.0]);
    }

    #[test]
    fn bounds_do_not_depend_on_a_factor_of_all_weights() {
        let net: Vec<DVec4> = (0..9)
            .map(|k| {
                let (x, y, w) = (f64::from(k / 3), f64::from(k % 3), 1.0 + 0.25 * f64::from(k % 2));
                (DVec3::new(x, y, x * y) * w).extend(w)
            })
            .collect();
        let bounds = |exponent: i32| {
            let scaled: Vec<DVec4> = net.iter().map(|p| *p * 2.0_f64.powi(exponent)).collect();
            let bounds = ThickParallelogram::new(&scaled, (2, 2));
            [bounds.thickness, bounds.tangent_deviation_squared, bounds.curvature_bound]
        };
        let expected = bounds(0);
        assert!(expected.iter().all(|bound| *bound > 0.01 && *bound < 100.0), "{expected:?}");
        assert_eq!([bounds(-560), bounds(560)], [expected; 2]);
    }

    #[test]
    fn bounds_of_a_rational_patch_hold_and_are_not_far_off() {
        for degrees in [(2, 2), (3, 5), (5, 4), (1, 6)] {
            let (p, q) = degrees;
            let net = (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))).map(|(i, j)| {
                let (x, y) = (i as f64 / p as f64, j as f64 / q as f64);
                let w = 1.0 + 0.3 * ((5 * i + 3 * j) as f64).sin();
                (DVec3::new(7.0 + 0.1 * x, 0.1 * y, 0.05 * (3.0 * x + 2.0 * y).sin()) * w).extend(w)
            });
            let bounds = ThickParallelogram::new(&net.clone().collect::<Vec<_>>(), degrees);
            let net: Vec<DVec4> = net.collect();
            let mut most = [0.0_f64; 3];
            for (i, j) in (0..=32).flat_map(|i| (0..=32).map(move |j| (i, j))) {
                let (u, v) = (f64::from(i) / 32.0, f64::from(j) / 32.0);
                let jet = control_net::second_order_jet(&net, degrees, u, v);
                let flat =
                    bounds.center + bounds.along_u * (2.0 * u - 1.0) + bounds.along_v * (2.0 * v - 1.0);
                let off =
                    [jet.su * 0.5 - bounds.along_u, jet.sv * 0.5 - bounds.along_v].map(DVec3::length_squared);
                // Half of the second derivative by (s, t) in the direction in which it is largest, at least.
                let turned =
                    |x: f64, y: f64| (jet.suu * (x * x) + jet.suv * (2.0 * x * y) + jet.svv * (y * y)) / 8.0;
                let curved = (0..16).map(|k| f64::from(k) * std::f64::consts::PI / 16.0);
                let curved = largest(curved.map(|angle| turned(angle.cos(), angle.sin())));
                let here = [(jet.s - flat).length(), off[0] + off[1], curved];
                for (most, x) in most.iter_mut().zip(here) {
                    *most = most.max(x);
                }
            }
            let limits = [bounds.thickness, bounds.tangent_deviation_squared, bounds.curvature_bound];
            for (most, limit) in most.into_iter().zip(limits) {
                assert!(most <= limit && limit <= 100.0 * most, "{degrees:?}: {most} of {limit}");
            }
        }
    }
}
