//! Closed chains of curves.

use super::curve::{TrimCurve, evaluate_in, project};
use super::monotone::{MonotonePiece, monotone_pieces};
use crate::error::{SurfaceError, not_negative};

/// A closed chain of curves that keeps the points on its left: counter-clockwise it keeps its inside, clockwise it is the
/// border of a hole.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoop {
    /// Each piece ends, to the bit, where the next starts.
    pub(super) pieces: Vec<MonotonePiece>,
}

impl TrimLoop {
    /// The loop of these curves in this order; the last one ends at the start of the first.
    ///
    /// `tolerance`: largest distance from the end of a curve to the start of the next one, parameter units, or the sum of the widths of
    /// both curves if that is larger. Both are moved to the point halfway between them; a curve that has a width is widened by as much.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without curves, [`SurfaceError::OpenLoop`] if two ends do not meet,
    /// [`SurfaceError::CollapsedLoop`] if the loop is a point, [`SurfaceError::NotFinite`] or [`SurfaceError::Negative`] for the
    /// tolerance.
    pub fn try_new(curves: Vec<TrimCurve>, tolerance: f64) -> Result<Self, SurfaceError> {
        Self::with_default_width(curves, tolerance, 0.0)
    }

    /// The loop of [`TrimLoop::try_new`]. `width`: that of curves without one of their own.
    pub(super) fn with_default_width(
        mut curves: Vec<TrimCurve>,
        tolerance: f64,
        width: f64,
    ) -> Result<Self, SurfaceError> {
        let tolerance = not_negative("tolerance of a loop", tolerance)?;
        let count = curves.len();
        if count == 0 {
            return Err(SurfaceError::TooFew { parameter: "curves of a loop", count, min: 1 });
        }
        let mut meeting_points = Vec::with_capacity(count);
        for (i, curve) in curves.iter().enumerate() {
            let next = (i + 1) % count;
            let (end, start) = (curve.end(), curves[next].start());
            let gap = end.distance(start);
            let widths = curve.width.unwrap_or(0.0) + curves[next].width.unwrap_or(0.0);
            let tolerance = tolerance.max(widths);
            if gap > tolerance {
                return Err(SurfaceError::OpenLoop { curve: i, next, end, start, gap, tolerance });
            }
            meeting_points.push(if end == start { end } else { 0.5 * end + 0.5 * start });
        }
        let mut pieces: Vec<MonotonePiece> = Vec::new();
        for (i, curve) in curves.iter_mut().enumerate() {
            let mut start = meeting_points[(i + count - 1) % count];
            let moved = start.distance(curve.start()).max(meeting_points[i].distance(curve.end()));
            let width = curve.width.map_or(width, |width| width + moved);
            curve.move_ends(start, meeting_points[i]);
            for points in curve.pieces.iter().flat_map(|piece| monotone_pieces(piece)) {
                let end = points.last().map_or(start, |&p| project(p));
                pieces.push(MonotonePiece { start, end, control_points: points, width });
                start = end;
            }
            if let Some(last) = pieces.last_mut() {
                last.end = meeting_points[i];
            }
        }
        pieces.retain(|piece| piece.start != piece.end);
        if pieces.is_empty() {
            return Err(SurfaceError::CollapsedLoop { point: meeting_points[0] });
        }
        Ok(Self { pieces })
    }

    /// The loop of one closed curve, whose ends coincide within `tolerance`.
    ///
    /// # Errors
    /// As [`TrimLoop::try_new`].
    pub fn try_closed(curve: TrimCurve, tolerance: f64) -> Result<Self, SurfaceError> {
        Self::try_new(vec![curve], tolerance)
    }

    /// The enclosed area to about one percent, positive if the loop runs counter-clockwise; parameter units squared.
    #[must_use]
    pub fn approximate_area(&self) -> f64 {
        const SAMPLES: u32 = 16;
        let Some(origin) = self.pieces.first().map(|piece| piece.start) else { return 0.0 };
        let (mut twice, mut row) = (0.0, Vec::new());
        for piece in &self.pieces {
            let mut before = piece.start - origin;
            for i in 1..=SAMPLES {
                let point = if i == SAMPLES {
                    piece.end
                } else {
                    row.clone_from(&piece.control_points);
                    evaluate_in(&mut row, f64::from(i) / f64::from(SAMPLES))
                };
                twice += before.perp_dot(point - origin);
                before = point - origin;
            }
        }
        0.5 * twice
    }

    /// A bound on the magnitude of the enclosed area, parameter units squared.
    ///
    /// The area is the integral of u - m over v for any m: with the middle of the range of u, at most half the width times the total
    /// variation of v.
    pub(super) fn area_bound(&self) -> f64 {
        let [low, high] =
            self.pieces.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], piece| {
                [low.min(piece.start.x), high.max(piece.start.x)]
            });
        0.5 * (high - low) * self.pieces.iter().map(|piece| (piece.end.y - piece.start.y).abs()).sum::<f64>()
    }

    /// Number of pieces monotone in u and in v.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        self.pieces.len()
    }
}
