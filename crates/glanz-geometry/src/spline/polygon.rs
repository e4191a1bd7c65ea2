//! Knots moved in and out of one row of control points: what curves and surfaces have in common.
//!
//! Every step goes from `a` to `b` by `a + (b - a) t`, so that coordinates and weights that are equal stay so to the
//! last bit.

use std::ops::Sub;

use super::knots::{KnotVector, clamped};
use crate::bezier::bernstein::Coefficient;
use crate::error::SurfaceError;

/// What control points can be made of: numbers, points of the plane or of space, homogeneous points.
pub(crate) trait ControlPoint: Coefficient + Sub<Output = Self> {}

impl<T> ControlPoint for T where T: Coefficient + Sub<Output = T> {}

/// From `a` to `b`, exact at both ends.
pub(crate) fn mix<P: ControlPoint>(a: P, b: P, t: f64) -> P {
    if t <= 0.5 { a + (b - a) * t } else { b + (a - b) * (1.0 - t) }
}

/// Adds the knot `u` of the domain once, unless it stands there `degree` times already.
///
/// # Source
/// @boehm1980.
fn insert_once<P: ControlPoint>(p: usize, t: &mut Vec<f64>, points: &mut Vec<P>, u: f64) {
    let end = t.partition_point(|&k| k <= u);
    let multiplicity = end - t.partition_point(|&k| k < u);
    if multiplicity >= p || end == 0 {
        return;
    }
    let k = end - 1;
    let (from, to) = (k + 1 - p, k - multiplicity);
    let moved: Vec<P> =
        (from..=to).map(|i| mix(points[i - 1], points[i], (u - t[i]) / (t[i + p] - t[i]))).collect();
    points.splice(from..to, moved);
    t.insert(end, u);
}

/// The same row with the knot `u`, strictly inside the domain, `times` times more.
///
/// # Errors
/// `u` outside of the open domain, or there more than `degree` times.
pub(crate) fn insert<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
    u: f64,
    times: usize,
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    check_inside(knots, u)?;
    let (multiplicity, max) = (knots.multiplicity(u).saturating_add(times), knots.degree());
    if multiplicity > max {
        return Err(SurfaceError::KnotMultiplicity { parameter: "knot", value: u, multiplicity, max });
    }
    let (mut t, mut points) = (knots.knots().to_vec(), points.to_vec());
    for _ in 0..times {
        insert_once(knots.degree(), &mut t, &mut points, u);
    }
    Ok((KnotVector::try_new(knots.degree(), t)?, points))
}

/// The part of the row between two parameters of the domain, clamped there.
///
/// # Errors
/// Parameters outside of the domain or not ascending.
pub(crate) fn restrict<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
    [start, end]: [f64; 2],
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    let [min, max] = knots.domain();
    for value in [start, end] {
        if !(value >= min && value <= max) {
            return Err(SurfaceError::OutOfRange { parameter: "parameter", value, min, max });
        }
    }
    if start >= end {
        return Err(SurfaceError::EmptyRange { parameter: "the parameter", min: start, max: end });
    }
    let p = knots.degree();
    let (mut t, mut points) = (knots.knots().to_vec(), points.to_vec());
    for u in [start, end] {
        for _ in 0..p {
            insert_once(p, &mut t, &mut points, u);
        }
    }
    // With p copies of a knot from index f on, point f - 1 lies on the spline.
    let first = t.partition_point(|&k| k <= start) - 1 - p;
    let last = t.partition_point(|&k| k < end) - 1;
    let inner = t.iter().copied().filter(|k| *k > start && *k < end).collect();
    let knots = KnotVector::try_new(p, clamped(p, [start, end], inner))?;
    Ok((knots, points[first..=last].to_vec()))
}

/// The ends of the pieces and their Bézier points, of which neighbours share one: piece i has those from
/// `degree * i` to `degree * (i + 1)`.
///
/// # Errors
/// None for points that belong to the knots.
pub(crate) fn bezier<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
) -> Result<(Vec<f64>, Vec<P>), SurfaceError> {
    let (whole, mut points) = restrict(knots, points, knots.domain())?;
    let (p, breaks) = (whole.degree(), whole.breaks());
    let mut t = whole.knots().to_vec();
    for &u in breaks.iter().take(breaks.len() - 1).skip(1) {
        for _ in 0..p {
            insert_once(p, &mut t, &mut points, u);
        }
    }
    Ok((breaks, points))
}

/// The same row one degree higher.
///
/// A new control point is the mean of the polar form over all ways to leave out one of its knots. The polar form is
/// that of the longest piece on which the point acts: from there, the others are reached with the smallest factors.
///
/// # Errors
/// A degree that is too high already.
///
/// # Source
/// @prautzsch1984; @farin2002 section 8.
pub(crate) fn elevate<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    let (p, [start, end]) = (knots.degree(), knots.domain());
    let distinct = knots.distinct();
    let raised: Vec<f64> = distinct.iter().flat_map(|&(k, n)| std::iter::repeat_n(k, n + 1)).collect();
    // Each value outside of the domain has brought a knot too many.
    let before = distinct.iter().filter(|(k, _)| *k < start).count();
    let after = distinct.iter().filter(|(k, _)| *k > end).count();
    let raised = KnotVector::try_new(p + 1, raised[before..raised.len() - after].to_vec())?;
    let s = raised.knots();
    let point = |j: usize| {
        let span = longest_span(knots, s[j], s[j + p + 2]);
        let without = |omitted: usize| {
            let arguments = (j + 1..=j + p + 1).filter(|i| *i != omitted).map(|i| s[i]);
            polar_form(knots, points, span, arguments)
        };
        let first = without(j + 1);
        (j + 2..=j + p + 1)
            .fold(first, |mean, omitted| mean + (without(omitted) - first) * (1.0 / (p + 1) as f64))
    };
    let points = (0..raised.count()).map(point).collect();
    Ok((raised, points))
}

/// The longest span of the domain within [from, to], or the one next to it.
fn longest_span(knots: &KnotVector, from: f64, to: f64) -> usize {
    let t = knots.knots();
    let nearest = knots.find_span(from);
    let length = |i: usize| t[i + 1] - t[i];
    (nearest..knots.count())
        .take_while(|i| t[*i] < to)
        .fold(nearest, |best, i| if length(i) > length(best) { i } else { best })
}

/// The multi-affine symmetric function that on its diagonal is the polynomial piece over `span`.
fn polar_form<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
    span: usize,
    arguments: impl Iterator<Item = f64>,
) -> P {
    let (t, p) = (knots.knots(), knots.degree());
    let mut work = points[span - p..=span].to_vec();
    for (r, u) in arguments.take(p).enumerate() {
        for j in 0..p - r {
            let (low, high) = (t[span + 1 + j + r - p], t[span + 1 + j]);
            work[j] = mix(work[j], work[j + 1], (u - low) / (high - low));
        }
    }
    work[0]
}

/// The row without one of the knots `u`, strictly inside the domain: nearly the same spline if it is smooth enough
/// there.
///
/// The points of the new row are computed from both sides, each with the equations that it may divide by 1/2 or more;
/// the one equation that is left over is not fulfilled but measures the error.
///
/// # Errors
/// `u` outside of the open domain, or no knot.
///
/// # Source
/// @tiller1992; departure: where the two sides meet.
pub(crate) fn remove<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
    u: f64,
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    check_inside(knots, u)?;
    let (p, multiplicity) = (knots.degree(), knots.multiplicity(u));
    if multiplicity == 0 {
        return Err(SurfaceError::TooFew { parameter: "knots at the parameter", count: 0, min: 1 });
    }
    let mut t = knots.knots().to_vec();
    let last = t.partition_point(|&k| k <= u) - 1;
    t.remove(last);
    let (from, to) = (last - p, last - multiplicity);
    let share = |i: usize| (u - t[i]) / (t[i + p] - t[i]);
    // points[i] = share(i) new[i] + (1 - share(i)) new[i - 1] for from <= i <= to.
    let meet = (from..to).find(|i| share(*i) < 0.5).unwrap_or(to);
    let mut new = points.to_vec();
    new.remove(to);
    for i in from..meet {
        let a = share(i);
        new[i] = new[i - 1] + (points[i] - new[i - 1]) * (1.0 / a);
    }
    for i in (meet + 1..=to).rev() {
        let a = share(i);
        new[i - 1] = new[i] + (points[i] - new[i]) * (1.0 / (1.0 - a));
    }
    Ok((KnotVector::try_new(p, t)?, new))
}

/// The same row run through backwards.
///
/// # Errors
/// See [`KnotVector::reversed`].
pub(crate) fn reverse<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    Ok((knots.reversed()?, points.iter().rev().copied().collect()))
}

fn check_inside(knots: &KnotVector, value: f64) -> Result<(), SurfaceError> {
    let [min, max] = knots.domain();
    if value > min && value < max {
        Ok(())
    } else {
        Err(SurfaceError::OutOfRange { parameter: "knot", value, min, max })
    }
}
