//! Exact rational forms of curves.

use std::f64::consts::TAU;

use crate::error::BrepError;
use crate::model::{Curve, CurveVector, SplineCurve};

impl<P: CurveVector> Curve<P> {
    /// The part of the curve from parameter `range[0]` to `range[1]`, with clamped knots.
    ///
    /// The part runs against the parameter if the range descends, and its parameters are then the negatives. On a curve with a bounded
    /// domain the part may pass the end of the domain, as on a closed curve, and be a turn long. Its shape is exact; parameters
    /// between the knots agree with those of the curve on lines, parabolas, splines and polylines only. Where segments of a composite
    /// curve do not meet, the start of the next is moved.
    ///
    /// # Errors
    /// [`BrepError::Range`] for an empty or infinite range, [`BrepError::TooFew`] points or segments, [`BrepError::Surface`] where
    /// numbers overflow or knots coincide by rounding.
    ///
    /// # Source
    /// @piegl1997 chapter 7.
    pub fn to_spline(&self, range: [f64; 2]) -> Result<SplineCurve<P>, BrepError> {
        let [from, to] = range;
        if let Self::Trimmed { basis, same_sense, .. } = self {
            return if *same_sense { basis.to_spline(range) } else { basis.to_spline([-from, -to]) };
        }
        if from > to {
            return Ok(self.ascending([to, from])?.reversed()?);
        }
        self.ascending(range)
    }

    fn ascending(&self, [from, to]: [f64; 2]) -> Result<SplineCurve<P>, BrepError> {
        let fault = BrepError::Range { curve: self.kind(), start: from, end: to };
        if !(from < to && (to - from).is_finite()) {
            return Err(fault);
        }
        Ok(match self {
            Self::Line { .. } => SplineCurve::line(self.point(from), self.point(to), [from, to])?,
            Self::Ellipse { center, a, b } => {
                // Rounding may have made a turn longer.
                let to = to.min(from + TAU);
                SplineCurve::elliptic_arc([*center, *a, *b], [from, to])?
            }
            Self::Parabola { apex, a, b } => {
                let corner = *apex + *a * (from * to) + *b * (from + to);
                let points = [self.point(from), corner, self.point(to)].map(|p| p.with_weight(1.0));
                SplineCurve::try_new(2, vec![from, from, from, to, to, to], points.to_vec())?
            }
            Self::Hyperbola { center, a, b } => SplineCurve::hyperbolic_arc([*center, *a, *b], [from, to])?,
            Self::Spline(spline) => turn_of(spline, [from, to])?,
            Self::Polyline(points) => turn_of(&polyline(points)?, [from, to])?,
            Self::Composite(segments) => composite(segments, [from, to])?,
            Self::Trimmed { .. } => return Err(fault),
        })
    }
}

/// A part of a spline that may pass the end of its domain.
fn turn_of<P: CurveVector>(
    spline: &SplineCurve<P>,
    [from, to]: [f64; 2],
) -> Result<SplineCurve<P>, BrepError> {
    let [start, end] = spline.domain();
    let turn = end - start;
    // Whole turns before the start of the part.
    let turns = ((from - start) / turn).floor();
    let offset = if from >= start && from < end { 0.0 } else { turns * turn };
    let part = spline.restrict_over_seam([from - offset, to - offset])?;
    Ok(if offset == 0.0 { part } else { part.shifted(offset)? })
}

fn polyline<P: CurveVector>(points: &[P]) -> Result<SplineCurve<P>, BrepError> {
    let count = points.len();
    if count < 2 {
        return Err(BrepError::TooFew { curve: "polyline", elements: "points", count, min: 2 });
    }
    let last = (count - 1) as f64;
    let knots = std::iter::once(0.0).chain((0..count).map(|i| i as f64)).chain(std::iter::once(last));
    Ok(SplineCurve::try_new(1, knots.collect(), points.iter().map(|p| p.with_weight(1.0)).collect())?)
}

/// A part of a composite curve that may pass the end of its domain, each segment cut by its own parameter.
fn composite<P: CurveVector>(
    segments: &[(Curve<P>, bool)],
    [from, to]: [f64; 2],
) -> Result<SplineCurve<P>, BrepError> {
    let total: f64 = segments.iter().map(|(segment, _)| segment.extent()).sum();
    // A multiple of the rounding of the sums.
    let negligible = 8.0 * f64::EPSILON * total.max(to.abs()).max(from.abs());
    let turns = if from >= 0.0 && from < total { 0.0 } else { (from / total).floor() };
    let (mut parts, mut start) = (Vec::new(), turns * total);
    for (segment, sense) in segments.iter().chain(segments) {
        let [a, b] = segment.domain();
        let length = b - a;
        let (low, high) = (from.max(start) - start, to.min(start + length) - start);
        if high - low > negligible {
            let high = if high >= length - negligible { length } else { high };
            let end = |t: f64| if t == length { b } else { a + t };
            let range = if *sense {
                [end(low), end(high)]
            } else {
                [b - low, if high == length { a } else { b - high }]
            };
            parts.push(segment.to_spline(range)?);
        }
        start += length;
    }
    let Some(first) = parts.first() else {
        let count = segments.len();
        return Err(BrepError::TooFew { curve: "composite curve", elements: "segments", count, min: 1 });
    };
    let offset = from - first.domain()[0];
    Ok(SplineCurve::joined(&parts)?.shifted(offset)?)
}
