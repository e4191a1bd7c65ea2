//! Closed chains of curves.

use glanz_math::{DVec2, DVec3};

use super::curve::{TrimCurve, evaluate, project};
use super::monotone::monotone_parts;
use crate::error::{SurfaceError, not_negative};

/// A closed chain of curves; what lies to its left is kept.
///
/// Counter-clockwise it keeps its inside, clockwise it is the border of a hole.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoop {
    pub(super) parts: Vec<MonotonePart>,
}

/// A rational Bézier curve that is monotone in u and in v. One part of a loop ends, to the bit, where the next starts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MonotonePart {
    pub(super) points: Vec<DVec3>,
    pub(super) start: DVec2,
    pub(super) end: DVec2,
}

impl TrimLoop {
    /// The loop of these curves in this order, the last one leading back to the first.
    ///
    /// `tolerance` (parameter units): how far the end of a curve may be from the start of the next one. Both are moved
    /// to the point halfway between them.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without curves, [`SurfaceError::OpenLoop`] with the ends that do not meet,
    /// [`SurfaceError::CollapsedLoop`] if the loop is a point, [`SurfaceError::NotFinite`] or [`SurfaceError::Negative`] for the
    /// tolerance.
    pub fn try_new(mut curves: Vec<TrimCurve>, tolerance: f64) -> Result<Self, SurfaceError> {
        let tolerance = not_negative("tolerance of a loop", tolerance)?;
        let count = curves.len();
        if count == 0 {
            return Err(SurfaceError::TooFew { parameter: "curves of a loop", count, min: 1 });
        }
        let mut joints = Vec::with_capacity(count);
        for (i, curve) in curves.iter().enumerate() {
            let next = (i + 1) % count;
            let (end, start) = (curve.end(), curves[next].start());
            let gap = end.distance(start);
            if gap > tolerance {
                return Err(SurfaceError::OpenLoop { curve: i, next, end, start, gap, tolerance });
            }
            joints.push(if end == start { end } else { 0.5 * end + 0.5 * start });
        }
        let mut parts: Vec<MonotonePart> = Vec::new();
        for (i, curve) in curves.iter_mut().enumerate() {
            let mut start = joints[(i + count - 1) % count];
            curve.move_ends(start, joints[i]);
            for points in curve.pieces.iter().flat_map(|piece| monotone_parts(piece)) {
                let end = points.last().map_or(start, |&p| project(p));
                parts.push(MonotonePart { points, start, end });
                start = end;
            }
            if let Some(last) = parts.last_mut() {
                last.end = joints[i];
            }
        }
        parts.retain(|part| part.start != part.end);
        if parts.is_empty() {
            return Err(SurfaceError::CollapsedLoop { point: joints[0] });
        }
        Ok(Self { parts })
    }

    /// The loop of one closed curve, its ends being the same point within `tolerance`.
    ///
    /// # Errors
    /// As [`TrimLoop::try_new`].
    pub fn try_closed(curve: TrimCurve, tolerance: f64) -> Result<Self, SurfaceError> {
        Self::try_new(vec![curve], tolerance)
    }

    /// The area it encloses, positive if it runs counter-clockwise, to about a percent; parameter units squared.
    #[must_use]
    pub fn approximate_area(&self) -> f64 {
        const SAMPLES: u32 = 16;
        let Some(origin) = self.parts.first().map(|part| part.start) else { return 0.0 };
        let mut twice = 0.0;
        for part in &self.parts {
            let mut before = part.start - origin;
            for i in 1..=SAMPLES {
                let point = if i == SAMPLES {
                    part.end
                } else {
                    evaluate(&part.points, f64::from(i) / f64::from(SAMPLES))
                };
                twice += before.perp_dot(point - origin);
                before = point - origin;
            }
        }
        0.5 * twice
    }

    /// Number of pieces monotone in u and in v.
    #[must_use]
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }
}
