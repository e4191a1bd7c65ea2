//! Knot insertion and removal in one row of control points, for curves and surfaces.
//!
//! Every step interpolates by `a + (b - a) t`, so that coordinates and weights that are equal stay so to the last bit.

use std::ops::{Add, Mul, Sub};

use glanz_math::bspline::Knots;

use super::knots::KnotVector;
use crate::error::SurfaceError;

/// A type of control points: numbers, points of the plane or of space, homogeneous points.
pub trait ControlPoint: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T> ControlPoint for T where T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T> {}

/// Linear interpolation from `a` to `b`, exact at both ends.
pub(crate) fn mix<P: ControlPoint>(a: P, b: P, t: f64) -> P {
    if t <= 0.5 { a + (b - a) * t } else { b + (a - b) * (1.0 - t) }
}

/// Inserts the knot `u` of the domain once, unless it appears `degree` times already.
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

/// The row after inserting the knot `u`, strictly inside the domain, `times` times.
///
/// # Errors
/// [`SurfaceError::OutOfRange`] if `u` is outside the open domain, [`SurfaceError::KnotMultiplicity`] if the knot would appear more
/// than `degree` times.
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
    Ok((KnotVector::try_with_jumps(knots.degree(), t)?, points))
}

/// The part of the row between two parameters of the domain, with clamped knots.
///
/// # Errors
/// [`SurfaceError::OutOfRange`] for a parameter outside the domain, [`SurfaceError::EmptyRange`] if they do not ascend.
pub fn restrict<P: ControlPoint>(
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
    // With p copies of a knot, the first at index f, control point f - 1 lies on the spline. With one more, that is the end of the part
    // before, and the next one the start of the part behind.
    let first = t.partition_point(|&k| k <= start) - 1 - p;
    let last = t.partition_point(|&k| k < end) - 1;
    let inner = t.iter().copied().filter(|k| *k > start && *k < end);
    let knots = KnotVector::try_with_jumps(p, Knots::clamped(p, [start, end], inner))?;
    Ok((knots, points[first..=last].to_vec()))
}

/// The ends of the pieces of a continuous spline and their Bézier points, of which neighbours share one: piece i has the points from
/// `degree * i` to `degree * (i + 1)`.
///
/// # Errors
/// Those of [`restrict`], and [`SurfaceError::KnotMultiplicity`] if the spline jumps.
pub fn bezier<P: ControlPoint>(knots: &KnotVector, points: &[P]) -> Result<(Vec<f64>, Vec<P>), SurfaceError> {
    knots.check_continuous()?;
    let BezierRow { breaks, points, .. } = bezier_row(knots, points)?;
    Ok((breaks, points))
}

/// The Bézier pieces of a row.
pub(super) struct BezierRow<P> {
    /// Ends of the pieces, one more than there are pieces.
    pub(super) breaks: Vec<f64>,
    /// Index of the first of the `degree + 1` points of each piece: neighbours share one, unless the spline jumps between them.
    pub(super) starts: Vec<usize>,
    pub(super) points: Vec<P>,
}

/// The Bézier pieces of a spline that may jump.
///
/// # Errors
/// Those of [`restrict`].
pub(super) fn bezier_row<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
) -> Result<BezierRow<P>, SurfaceError> {
    let (whole, mut points) = restrict(knots, points, knots.domain())?;
    let (p, breaks) = (whole.degree(), whole.breaks());
    let mut t = whole.knots().to_vec();
    for &u in breaks.iter().take(breaks.len() - 1).skip(1) {
        for _ in 0..p {
            insert_once(p, &mut t, &mut points, u);
        }
    }
    let start = |&u: &f64| t.partition_point(|&k| k <= u) - 1 - p;
    let starts = breaks.iter().take(breaks.len() - 1).map(start).collect();
    Ok(BezierRow { breaks, starts, points })
}

/// The row with its degree raised by one.
///
/// A new control point is the mean of the polar form over all ways to omit one of its knots. The polar form is that of the
/// longest piece on which the point acts, from which extrapolation to the others needs the smallest factors.
///
/// # Errors
/// [`SurfaceError::OutOfRange`] if the degree is already the highest possible.
///
/// # Source
/// @prautzsch1984; @farin2002 section 8.
pub fn elevate<P: ControlPoint>(
    knots: &KnotVector,
    points: &[P],
) -> Result<(KnotVector, Vec<P>), SurfaceError> {
    let (p, [start, end]) = (knots.degree(), knots.domain());
    let distinct = knots.distinct();
    let raised: Vec<f64> = distinct.iter().flat_map(|&(k, n)| std::iter::repeat_n(k, n + 1)).collect();
    // Each value outside the domain has added one knot too many.
    let before = distinct.iter().filter(|(k, _)| *k < start).count();
    let after = distinct.iter().filter(|(k, _)| *k > end).count();
    let raised = KnotVector::try_with_jumps(p + 1, raised[before..raised.len() - after].to_vec())?;
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

/// The longest knot span of the domain within [from, to], or the nearest one.
fn longest_span(knots: &KnotVector, from: f64, to: f64) -> usize {
    let t = knots.knots();
    let nearest = knots.find_span(from);
    let length = |i: usize| t[i + 1] - t[i];
    (nearest..knots.count())
        .take_while(|i| t[*i] < to)
        .fold(nearest, |best, i| if length(i) > length(best) { i } else { best })
}

/// The polar form of the polynomial piece over `span`: the symmetric multi-affine function that equals it on the diagonal.
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

/// The row after removing one of the knots `u`, strictly inside the domain; the same spline if it is smooth enough there.
///
/// The points of the new row are computed from both ends, with those equations whose divisor is 1/2 or more; the one
/// equation that remains is not solved, its residual is the error.
///
/// # Errors
/// [`SurfaceError::OutOfRange`] if `u` is outside the open domain, [`SurfaceError::TooFew`] if it is not a knot,
/// [`SurfaceError::KnotMultiplicity`] if the spline jumps there.
///
/// # Source
/// @tiller1992; departure: the equation that remains.
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
    if multiplicity > p {
        return Err(SurfaceError::KnotMultiplicity { parameter: "knot", value: u, multiplicity, max: p });
    }
    let mut t = knots.knots().to_vec();
    let last = t.partition_point(|&k| k <= u) - 1;
    t.remove(last);
    let (from, to) = (last - p, last - multiplicity);
    let weight = |i: usize| (u - t[i]) / (t[i + p] - t[i]);
    // points[i] = weight(i) new[i] + (1 - weight(i)) new[i - 1] for from <= i <= to.
    let split = (from..to).find(|i| weight(*i) < 0.5).unwrap_or(to);
    let mut new = points.to_vec();
    new.remove(to);
    for i in from..split {
        let a = weight(i);
        new[i] = new[i - 1] + (points[i] - new[i - 1]) * (1.0 / a);
    }
    for i in (split + 1..=to).rev() {
        let a = weight(i);
        new[i - 1] = new[i] + (points[i] - new[i]) * (1.0 / (1.0 - a));
    }
    Ok((KnotVector::try_with_jumps(p, t)?, new))
}

/// The same spline reversed.
///
/// # Errors
/// See [`KnotVector::reversed`].
pub fn reverse<P: ControlPoint>(
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
