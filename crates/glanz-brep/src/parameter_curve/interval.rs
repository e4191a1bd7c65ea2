//! The distance of a curve on a carrier from an edge over one interval.

use std::cmp::Ordering;
use std::sync::LazyLock;

use glanz_math::{DVec2, DVec3};

use super::expansion::{JetPoint, on_carrier, plane_curve, space_curve, space_curve_and_tangent};
use super::jet::{Expansion, Jet, ORDER, TaylorSeries};
use crate::carrier::Carrier;
use crate::model::SplineCurve;

/// Halvings of an interval on which the bound on a polynomial is evaluated.
const HALVINGS: usize = 3;

/// Part of an interval, and of parameters, below which distances are not divided.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Three times the bound on the speed exceeds the sum of that of a piece and that of its continuation, as long as the continuation is
/// shorter than its length over four times the squared degree.
const OVERHANG_FACTOR: f64 = 3.0;

/// A parameter of the curve on the carrier and that of the edge to which it corresponds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ParameterPair {
    pub(super) curve: f64,
    pub(super) edge: f64,
}

/// The curves that are compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvePair<'a> {
    pub(super) carrier: &'a Carrier,
    pub(super) curve: &'a SplineCurve<DVec2>,
    pub(super) edge: &'a SplineCurve<DVec3>,
    /// Whether equal knots correspond.
    pub(super) same_parameter: bool,
}

/// An interval with a bound.
#[derive(Clone, Debug)]
pub(super) struct DeviationInterval {
    pub(super) ends: [ParameterPair; 2],
    /// Coefficients of the powers of x in [-1, 1] of the edge's parameter.
    edge_parameter: [f64; ORDER],
    /// Bound on the distance of corresponding points, metres.
    pub(super) bound: f64,
    /// The largest distance of sampled points, metres.
    pub(super) sampled: f64,
    /// Whether the bound is that of all pairs of points, since the interval has to be divided before jets can be used.
    pub(super) forced: bool,
    /// Where it is to be divided.
    pub(super) division: ParameterPair,
}

impl CurvePair<'_> {
    /// The point of the curve on the carrier.
    pub(super) fn point(&self, t: f64) -> DVec3 {
        self.carrier.point(self.curve.point(t))
    }

    /// The point of the curve on the carrier and its derivative.
    pub(super) fn on_carrier(&self, t: f64) -> [DVec3; 2] {
        let derivatives = self.curve.derivatives(t, 1);
        let [uv, d] = [0, 1].map(|k| derivatives.get(k).copied().unwrap_or(DVec2::NAN));
        let [point, du, dv] = self.carrier.point_and_tangents(uv);
        [point, du * d.x + dv * d.y]
    }

    /// The interval between two pairs, within which the curve has no knot.
    pub(super) fn interval(&self, ends: [ParameterPair; 2]) -> DeviationInterval {
        let [from, to] = ends.map(|end| end.edge);
        let mut edge_parameter = [0.0; ORDER];
        edge_parameter[..2].copy_from_slice(&[0.5 * (from + to), 0.5 * (to - from)]);
        let mut interval = DeviationInterval {
            ends,
            edge_parameter,
            bound: f64::INFINITY,
            sampled: 0.0,
            forced: false,
            division: ends[0],
        };
        if from.is_nan() || to.is_nan() || from > to {
            // Running back, the edge would not be covered in its order.
            return interval;
        }
        interval.division = interval.pair(0.0);
        if let Some(division) = self.edge_knot(ends) {
            return self.forced(DeviationInterval { division, ..interval });
        }
        let [from, to] = ends.map(|end| end.curve);
        let uv = plane_curve(self.curve, 0.5 * (from + to), 0.5 * (to - from));
        let on_carrier = on_carrier(self.carrier, &uv);
        interval.edge_parameter = self.improved(&on_carrier, &edge_parameter);
        let (center, argument) = split_constant(&interval.edge_parameter);
        let edge = space_curve(self.edge, center, &Jet::polynomial(&argument));
        let difference = [0, 1, 2].map(|i| on_carrier[i] - edge[i]);
        let (hull, sampled) = polynomial_bound(&difference);
        let remainder = DVec3::from(difference.map(|d| d.magnitude(ORDER))).length();
        let (overhang, division) = self.overhang(&interval, &uv);
        interval.bound = hull + remainder + overhang;
        // A knot of the carrier is only divided at while it matters.
        if let Some(division) = division.filter(|_| overhang > remainder) {
            interval.division = division;
        }
        if !interval.bound.is_finite() {
            return self.forced(interval);
        }
        interval.sampled = sampled;
        interval
    }

    /// The interval with a bound on the distance of any point of its part of the curve from any of its part of the edge: that of two
    /// points, and how far others are from these.
    fn forced(&self, interval: DeviationInterval) -> DeviationInterval {
        let middle = interval.ends.map(|end| end.curve);
        let center = self.curve.point(0.5 * (middle[0] + middle[1]));
        let [from, to] = interval.ends.map(|end| end.edge);
        let point = self.edge.point(0.5 * (from + to));
        let reach = [0, 1].map(|axis| {
            let [least, most] = self.hull(&interval, axis);
            largest([center[axis] - least, most - center[axis]])
        });
        let speeds = speed_bounds(self.carrier, center.y, reach[1]);
        let edge_reach = if to > from {
            self.edge.restrict([from, to]).map_or(f64::INFINITY, |part| {
                largest(part.control_points().iter().map(|h| (h.truncate() / h.w).distance(point)))
            })
        } else {
            0.0
        };
        let bound = self.carrier.point(center).distance(point)
            + speeds[0] * reach[0]
            + speeds[1] * reach[1]
            + edge_reach;
        let bound = if bound.is_nan() { f64::INFINITY } else { bound };
        DeviationInterval { bound, forced: true, ..interval }
    }

    /// One step of Newton's method for the parameter of the edge at which the difference is at right angles to the edge, with the same
    /// ends; the parameter as it is, if the step is not monotone.
    fn improved(&self, on_carrier: &JetPoint, parameter: &[f64; ORDER]) -> [f64; ORDER] {
        let (center, argument) = split_constant(parameter);
        let [edge, tangent] =
            space_curve_and_tangent(self.edge, center, &TaylorSeries::polynomial(&argument));
        let product = |a: &[TaylorSeries; 3], b: &[TaylorSeries; 3]| {
            a[0].times(&b[0]) + a[1].times(&b[1]) + a[2].times(&b[2])
        };
        let difference = [0, 1, 2].map(|i| on_carrier[i].middles - edge[i]);
        let TaylorSeries(step) = product(&difference, &tangent).times(&product(&tangent, &tangent).inverse());
        let mut improved: [f64; ORDER] = std::array::from_fn(|k| step[k]);
        let (even, odd): (f64, f64) =
            (improved.iter().step_by(2).sum(), improved.iter().skip(1).step_by(2).sum());
        improved[0] -= even;
        improved[1] -= odd;
        improved.iter_mut().zip(parameter).for_each(|(a, b)| *a += b);
        let slopes: [f64; ORDER] =
            std::array::from_fn(|k| (k + 1) as f64 * improved.get(k + 1).copied().unwrap_or(0.0));
        let rising =
            bernstein(&slopes.map(|slope| DVec3::new(slope, 0.0, 0.0))).iter().all(|slope| slope.x >= 0.0);
        if rising { improved } else { *parameter }
    }

    /// The division at the first knot of the edge between two pairs.
    pub(super) fn edge_knot(&self, [from, to]: [ParameterPair; 2]) -> Option<ParameterPair> {
        let knots = self.edge.knots().knots();
        // Knots at an end up to rounding are no division.
        let rounding = ROUNDING * (from.edge.abs() + to.edge.abs());
        let knot = *knots.get(knots.partition_point(|k| *k <= from.edge + rounding))?;
        (knot < to.edge - rounding).then(|| {
            let part = (knot - from.edge) / (to.edge - from.edge);
            ParameterPair { curve: from.curve + (to.curve - from.curve) * part, edge: knot }
        })
    }

    /// The smallest and the largest control point of the curve over an interval, u or v.
    fn hull(&self, interval: &DeviationInterval, axis: usize) -> [f64; 2] {
        let Ok(part) = self.curve.restrict(interval.ends.map(|end| end.curve)) else {
            return [f64::NEG_INFINITY, f64::INFINITY];
        };
        let values = part.control_points().iter().map(|p| p[axis] / p.z);
        let around = |[low, high]: [f64; 2], value: f64| {
            if value.is_nan() {
                return [f64::NEG_INFINITY, f64::INFINITY];
            }
            [low.min(value), high.max(value)]
        };
        values.fold([f64::INFINITY, f64::NEG_INFINITY], around)
    }

    /// Bound on the error of continuing the piece of a spline carrier over its knots, and where the curve crosses one.
    fn overhang(&self, interval: &DeviationInterval, uv: &[Jet; 2]) -> (f64, Option<ParameterPair>) {
        let Carrier::Spline(spline) = self.carrier else { return (0.0, None) };
        let center = DVec2::new(uv[0].center(), uv[1].center());
        let wrapped = spline.wrapped(center);
        let (speeds, degrees) = (spline.speed_bounds(), spline.degrees());
        let (mut error, mut division, mut farthest) = (0.0, None, 0.0);
        for axis in [0, 1] {
            let piece = spline.piece(axis, wrapped[axis]);
            let reach = uv[axis].spread();
            let reach = if reach.is_nan() { f64::INFINITY } else { reach };
            // Relative to the centre, which may be moved by a period.
            let [low, high] = piece.map(|knot| knot - wrapped[axis]);
            // A centre outside of a domain without period is clamped into it.
            let clamped = spline.periods()[axis].map_or((center[axis] - wrapped[axis]).abs(), |_| 0.0);
            let mut beyond = (low + reach).max(reach - high).max(0.0);
            if beyond > 0.0 {
                // The hull of control points, which is sharp where the curve is monotone.
                let [least, most] = self.hull(interval, axis).map(|value| value - center[axis]);
                beyond = (low - least).max(most - high).max(0.0);
            }
            if beyond == 0.0 && clamped == 0.0 {
                continue;
            }
            let limit = (piece[1] - piece[0]) / (4 * degrees[axis] * degrees[axis]) as f64;
            let over = beyond + clamped;
            error += if over < limit { OVERHANG_FACTOR * speeds[axis] * over } else { f64::INFINITY };
            if beyond > farthest {
                farthest = beyond;
                let t = |x: f64| interval.curve_at(x);
                let offset = |x: f64, knot: f64| self.curve.point(t(x))[axis] - center[axis] - knot;
                let crossed =
                    [low, high].into_iter().find(|knot| offset(-1.0, *knot) * offset(1.0, *knot) < 0.0);
                let crossing = crossed.map(|knot| root(|x| offset(x, knot)));
                division = crossing.filter(|x| x.abs() < 1.0 - ROUNDING).map(|x| interval.pair(x));
            }
        }
        (error, division)
    }
}

impl DeviationInterval {
    /// The parameter of the edge at x in [-1, 1].
    fn edge_at(&self, x: f64) -> f64 {
        self.edge_parameter.iter().rev().fold(0.0, |sum, a| sum * x + a)
    }

    /// The parameter of the curve at x in [-1, 1].
    fn curve_at(&self, x: f64) -> f64 {
        let [from, to] = self.ends.map(|end| end.curve);
        0.5 * (from + to) + 0.5 * (to - from) * x
    }

    /// The corresponding parameters at x in [-1, 1].
    fn pair(&self, x: f64) -> ParameterPair {
        let [from, to] = self.ends.map(|end| end.edge);
        ParameterPair { curve: self.curve_at(x), edge: self.edge_at(x).clamp(from, to.max(from)) }
    }
}

impl Ord for DeviationInterval {
    /// By the bounds.
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl PartialOrd for DeviationInterval {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for DeviationInterval {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for DeviationInterval {}

/// The largest of values, at least 0; NaN if one of them is, which `f64::max` would pass over.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, value| if most >= value || most.is_nan() { most } else { value })
}

/// Bounds on the speeds in u and v, at most `reach` from `v`.
fn speed_bounds(carrier: &Carrier, v: f64, reach: f64) -> [f64; 2] {
    match carrier {
        Carrier::Plane(_) => [1.0; 2],
        Carrier::Cylinder { radius, .. } => [*radius, 1.0],
        Carrier::Cone { radius, half_angle, .. } => {
            let slope = half_angle.tan();
            [(radius + v * slope).abs() + reach * slope, 1.0 / half_angle.cos()]
        }
        Carrier::Sphere { radius, .. } => [*radius; 2],
        Carrier::Torus { major_radius, minor_radius, .. } => [major_radius + minor_radius, *minor_radius],
        Carrier::Spline(spline) => spline.speed_bounds(),
    }
}

/// A zero in (-1, 1) of a function that changes its sign, by bisection.
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    let rising = f(1.0) >= 0.0;
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if (f(middle) >= 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// A polynomial as its value at 0 and the rest.
fn split_constant(polynomial: &[f64; ORDER]) -> (f64, [f64; ORDER]) {
    let mut rest = *polynomial;
    rest[0] = 0.0;
    (polynomial[0], rest)
}

/// A bound on the length of the polynomial of the middles of three jets over [-1, 1], and its largest length at samples.
///
/// Its Bernstein points on halves of halves converge to it quadratically.
fn polynomial_bound(jets: &[Jet; 3]) -> (f64, f64) {
    let powers: [DVec3; ORDER] = std::array::from_fn(|k| DVec3::from_array(jets.map(|jet| jet.middles.0[k])));
    let [hull, sampled] = squared_bound(&bernstein(&powers), HALVINGS);
    (hull.sqrt(), sampled.sqrt())
}

/// The squares of the largest lengths of the Bernstein points of all parts after this many halvings, and of the ends of parts.
fn squared_bound(row: &[DVec3; ORDER], halvings: usize) -> [f64; 2] {
    if halvings == 0 {
        let ends = [row[0], row[ORDER - 1]].into_iter();
        return [largest(row.iter().map(|p| p.length_squared())), largest(ends.map(DVec3::length_squared))];
    }
    let [first, second] = halves(row).map(|half| squared_bound(&half, halvings - 1));
    [0, 1].map(|k| largest([first[k], second[k]]))
}

/// The Bernstein coefficients on [-1, 1] of powers: row i has those with which the powers of x contribute to coefficient i.
///
/// With x = 2 s - 1, `x^k = ((s - (1 - s)))^k` is the product of k lines from -1 to 1; its polar form at i ones and n - i zeros is the mean
/// over the choices of k arguments of the product of their values, plus or minus one.
static BERNSTEIN: LazyLock<[[f64; ORDER]; ORDER]> = LazyLock::new(|| {
    let n = ORDER - 1;
    let factor = |i: usize, k: usize| {
        // Of the k chosen, m are zeros, at which the line is -1.
        let mean = (0..=k).map(|m| {
            let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
            sign * binomial(n - i, m) * binomial(i, k - m)
        });
        mean.sum::<f64>() / binomial(n, k)
    };
    std::array::from_fn(|i| std::array::from_fn(|k| factor(i, k)))
});

/// Bernstein coefficients on [-1, 1] of a polynomial given by coefficients of powers.
fn bernstein(powers: &[DVec3]) -> [DVec3; ORDER] {
    BERNSTEIN.map(|row| powers.iter().zip(row).map(|(power, factor)| *power * factor).sum())
}

fn binomial(n: usize, k: usize) -> f64 {
    if k > n { 0.0 } else { (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64) }
}

fn halves(row: &[DVec3; ORDER]) -> [[DVec3; ORDER]; 2] {
    let (mut first, mut second) = (*row, *row);
    for (i, point) in first.iter_mut().enumerate() {
        *point = second[0];
        for j in 0..ORDER - 1 - i {
            second[j] = (second[j] + second[j + 1]) * 0.5;
        }
    }
    [first, second]
}
