//! All monotone pieces of a region in flat arrays, with the tests of points against them.

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::border::scale_across;
use super::curve::MAX_DEGREE;
use super::loops::TrimLoop;
use crate::bezier::bernstein::{binomials, halve};
use crate::error::SurfaceError;

/// The side of a directed curve on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CurveSide {
    Left,
    Right,
    /// Within rounding of the curve.
    On,
}

/// The ends and the bounding box of a monotone piece, and the position of its control points.
#[derive(Clone, Copy, Debug)]
pub(super) struct PieceRecord {
    pub(super) start: DVec2,
    pub(super) end: DVec2,
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    /// Distance within which points are kept.
    pub(super) width: f64,
    /// Index of its first entry in the terms.
    first: u32,
    degree: u32,
}

/// A point of a piece, up to the slack.
#[derive(Clone, Copy, Debug)]
pub(super) struct PiecePoint {
    pub(super) t: f64,
    pub(super) position: DVec2,
}

/// The test on which side of a monotone piece a point lies, by another point of the piece.
///
/// In coordinates in which the curve rises, a point of it to the upper left of the tested one proves that the whole curve passes
/// on that side, and one to the lower right likewise.
pub(super) struct SideTest {
    p: DVec2,
    clearance: DVec2,
    turn: DVec2,
}

impl SideTest {
    /// The test of `p` against `piece`. `clearance` (at least the slack): the distance, per coordinate, that a point needs
    /// to decide.
    #[inline]
    pub(super) fn new(piece: &PieceRecord, p: DVec2, clearance: DVec2) -> Self {
        Self { p, clearance, turn: piece.turn() }
    }

    /// The side of the piece on which the tested point lies if `q` is on the piece; `On` if `q` does not decide.
    #[inline]
    pub(super) fn side(&self, q: DVec2) -> CurveSide {
        let d = (q - self.p) * self.turn;
        let is_upper_left = d.x < -self.clearance.x && d.y > self.clearance.y;
        let is_lower_right = d.x > self.clearance.x && d.y < -self.clearance.y;
        if !is_upper_left && !is_lower_right {
            CurveSide::On
        } else if is_upper_left == (self.turn.x == self.turn.y) {
            CurveSide::Right
        } else {
            CurveSide::Left
        }
    }
}

/// All monotone pieces of a region.
#[derive(Clone, Debug)]
pub(super) struct PieceTable {
    pub(super) pieces: Vec<PieceRecord>,
    /// Control points times their binomial coefficients.
    terms: Vec<DVec3>,
    /// Bound, in u and in v, on the distance of a computed point from its curve, and on the deviation of a curve from being
    /// monotone.
    pub(super) slack: DVec2,
}

impl PieceTable {
    /// The pieces of `loops`. `reach`: the largest magnitudes of the coordinates of tested points.
    pub(super) fn try_new(loops: &[TrimLoop], reach: DVec2) -> Result<Self, SurfaceError> {
        let (mut pieces, mut terms) = (Vec::new(), Vec::new());
        let (mut reach, mut highest) = (reach, 1);
        for piece in loops.iter().flat_map(|l| &l.pieces) {
            let degree = piece.control_points.len().saturating_sub(1).min(MAX_DEGREE) as u32;
            let Ok(first) = u32::try_from(terms.len()) else {
                let max = u32::MAX as usize;
                return Err(SurfaceError::TooMany { parameter: "control points", count: terms.len(), max });
            };
            let (start, end) = (piece.start, piece.end);
            let (min, max, width) = (start.min(end), start.max(end), piece.width);
            pieces.push(PieceRecord { start, end, min, max, width, first, degree });
            terms.extend(piece.control_points.iter().zip(binomials(degree as usize)).map(|(&p, b)| p * b));
            reach = reach.max(start.abs()).max(end.abs());
            highest = highest.max(degree);
        }
        pieces.shrink_to_fit();
        terms.shrink_to_fit();
        // A value has 4 n + 4 roundings, each split of the piece 3 n. The margin covers moved ends and the search for turning
        // points (2 n + 4 roundings for each of 48 halvings, relative to the speed times the width of the last interval).
        Ok(Self { pieces, terms, slack: reach * gamma(64 * (highest + 4)) })
    }

    /// The largest width of a piece.
    pub(super) fn max_width(&self) -> f64 {
        self.pieces.iter().fold(0.0, |width, piece| width.max(piece.width))
    }

    /// Distance from a cell within which a piece belongs to it: the corners of a cell, the cell of a point and both sides of a piece
    /// are each accurate to the slack.
    pub(super) fn margin(&self, piece: &PieceRecord) -> DVec2 {
        4.0 * self.slack + piece.width
    }

    fn terms(&self, piece: &PieceRecord) -> &[DVec3] {
        let first = piece.first as usize;
        self.terms.get(first..first + piece.degree as usize + 1).unwrap_or(&[])
    }

    /// Homogeneous control points of a piece.
    pub(super) fn control_points(&self, piece: &PieceRecord) -> Vec<DVec3> {
        self.terms(piece).iter().zip(binomials(piece.degree as usize)).map(|(&term, b)| term / b).collect()
    }

    /// The point of `piece` at `t`: Horner's rule with powers of `t` and `1 - t`, all terms of one sign.
    ///
    /// # Source
    /// @farin2002 chapter 5.
    #[inline]
    pub(super) fn point(&self, piece: &PieceRecord, t: f64) -> PiecePoint {
        let s = 1.0 - t;
        let (mut sum, mut power) = (DVec3::ZERO, 1.0);
        for &term in self.terms(piece) {
            sum = sum * s + term * power;
            power *= t;
        }
        PiecePoint { t, position: sum.truncate() / sum.z }
    }

    /// The side of `piece` on which `p` lies, for points in or near its box. Points closer than the slack in both coordinates
    /// are `On`.
    pub(super) fn side(&self, piece: &PieceRecord, p: DVec2) -> CurveSide {
        self.side_with_clearance(piece, p, self.slack)
    }

    /// The side of `piece` on which `p` lies, for points in or near its box. Points closer than `clearance` (at least the
    /// slack) in both coordinates are `On`.
    ///
    /// The point that decides ([`SideTest`]) is searched where the curve crosses the falling diagonal through `p`, by regula
    /// falsi in a bracket.
    ///
    /// # Source
    /// @press2007 section 9.2; departure: halving at every third step.
    pub(super) fn side_with_clearance(&self, piece: &PieceRecord, p: DVec2, clearance: DVec2) -> CurveSide {
        let (test, scale) = (SideTest::new(piece, p, clearance), piece.turn() / clearance);
        let relative = |q: DVec2| (q - p) * scale;
        let (mut low, mut high) =
            ((0.0, relative(piece.start).element_sum()), (1.0, relative(piece.end).element_sum()));
        for step in 0..192 {
            let mut t: f64 = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1));
            let inside = t > low.0 && t < high.0;
            if step % 3 == 2 || !inside {
                t = 0.5 * low.0 + 0.5 * high.0;
                if t <= low.0 || t >= high.0 {
                    break;
                }
            }
            let q = self.point(piece, t).position;
            let side = test.side(q);
            if side != CurveSide::On {
                return side;
            }
            let d = relative(q);
            let beyond = d.x > 1.0 || d.y > 1.0;
            if !beyond && d.x >= -1.0 && d.y >= -1.0 {
                return CurveSide::On;
            }
            if beyond {
                high = (t, d.element_sum());
            } else {
                low = (t, d.element_sum());
            }
        }
        CurveSide::On
    }

    /// Whether points within the margin of `piece` may lie in the rectangle.
    pub(super) fn touches(&self, piece: &PieceRecord, min: DVec2, max: DVec2) -> bool {
        let margin = self.margin(piece);
        let (min, max) = (min - margin, max + margin);
        if piece.max.x < min.x || piece.min.x > max.x || piece.max.y < min.y || piece.min.y > max.y {
            return false;
        }
        // The corners of the rectangle farthest above and below a rising, or a falling, curve.
        let rises = (piece.end.x < piece.start.x) == (piece.end.y < piece.start.y);
        let (above, below) =
            if rises { (DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)) } else { (max, min) };
        // The left side of a curve that runs to the right is above it.
        let (side_above, side_below) = if piece.end.x < piece.start.x {
            (CurveSide::Right, CurveSide::Left)
        } else {
            (CurveSide::Left, CurveSide::Right)
        };
        // Horizontal and vertical pieces equal their boxes.
        if piece.min.x == piece.max.x || piece.min.y == piece.max.y {
            return true;
        }
        let misses =
            |corner: DVec2, other: CurveSide| piece.holds(corner) && self.side(piece, corner) == other;
        !misses(above, side_below) && !misses(below, side_above)
    }

    /// The direction of the curve where it comes within its width of `p` (Euclidean distance); `None` if it does not.
    ///
    /// A part is at most as far from its chord as its control points are; parts for which this bound does not decide are halved
    /// until they are straight up to rounding.
    fn direction_within_width(&self, piece: &PieceRecord, p: DVec2) -> Option<DVec2> {
        let terms = self.terms(piece);
        let mut points = [DVec3::ZERO; MAX_DEGREE + 1];
        let points = points.get_mut(..terms.len())?;
        for ((point, term), binomial) in points.iter_mut().zip(terms).zip(binomials(piece.degree as usize)) {
            *point = *term / binomial;
        }
        part_within(points, p, piece.width, self.slack.max_element(), 60)
    }

    /// The largest width in space, metres, of those pieces of a list within whose width `p` lies, 0 without any. `derivatives`: of the surface by
    /// the coordinates of the pieces, metres.
    pub(super) fn border_width(&self, list: &[u32], p: DVec2, derivatives: [DVec3; 2]) -> f64 {
        let pieces = list.iter().filter_map(|&i| self.pieces.get(i as usize));
        let near = pieces.filter(|piece| piece.near(p, self.slack + piece.width));
        let widths = near.filter_map(|piece| {
            let along = self.direction_within_width(piece, p)?;
            Some(piece.width * scale_across(derivatives, along))
        });
        widths.fold(0.0, f64::max)
    }

    /// The side of `piece` on which `p` lies, and whether it is within the width, for points about as near as that.
    #[cold]
    pub(super) fn side_near(&self, piece: &PieceRecord, p: DVec2) -> (CurveSide, bool) {
        let side = if piece.near(p, self.slack) { self.side(piece, p) } else { CurveSide::Left };
        (side, self.direction_within_width(piece, p).is_some())
    }
}

/// The chord of a part of a curve that comes within the tolerance of `p`.
fn part_within(points: &[DVec3], p: DVec2, tolerance: f64, slack: f64, splits: u32) -> Option<DVec2> {
    let (&first, &last) = (points.first()?, points.last()?);
    let (start, end) = (first.truncate() / first.z - p, last.truncate() / last.z - p);
    let distance = segment_distance(start, end, DVec2::ZERO);
    let sag =
        points.iter().fold(0.0_f64, |sag, q| sag.max(segment_distance(start, end, q.truncate() / q.z - p)));
    if distance - sag > tolerance {
        return None;
    }
    if distance + sag <= tolerance || sag <= slack || splits == 0 {
        return Some(end - start);
    }
    let (mut left, mut right) = ([DVec3::ZERO; MAX_DEGREE + 1], [DVec3::ZERO; MAX_DEGREE + 1]);
    let count = points.len();
    left[..count].copy_from_slice(points);
    halve(&mut left[..count], &mut right[..count]);
    part_within(&left[..count], p, tolerance, slack, splits - 1)
        .or_else(|| part_within(&right[..count], p, tolerance, slack, splits - 1))
}

/// Distance of `q` from the straight line between two points.
fn segment_distance(start: DVec2, end: DVec2, q: DVec2) -> f64 {
    let chord = end - start;
    let length2 = chord.length_squared();
    let fraction = if length2 > 0.0 { ((q - start).dot(chord) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (start + chord * fraction).distance(q)
}

impl PieceRecord {
    /// Signs that turn the curve so that it rises to the right.
    #[inline]
    pub(super) fn turn(&self) -> DVec2 {
        DVec2::new(
            if self.end.x < self.start.x { -1.0 } else { 1.0 },
            if self.end.y < self.start.y { -1.0 } else { 1.0 },
        )
    }

    /// The sides of the piece on which points lie that it passes on their upper left and on their lower right, once turned.
    #[inline]
    pub(super) fn sides(&self) -> (CurveSide, CurveSide) {
        let turn = self.turn();
        if turn.x == turn.y {
            (CurveSide::Right, CurveSide::Left)
        } else {
            (CurveSide::Left, CurveSide::Right)
        }
    }

    /// Largest extent within the rectangle from `min` to `max`, each coordinate in units of its sides.
    pub(super) fn extent(&self, min: DVec2, max: DVec2) -> f64 {
        ((self.max.min(max) - self.min.max(min)) / (max - min)).max_element()
    }

    /// Whether `p` lies in the box, lower and left sides included. There, crossings depend on the side of the curve.
    pub(super) fn holds(&self, p: DVec2) -> bool {
        p.x >= self.min.x && p.x < self.max.x && p.y >= self.min.y && p.y < self.max.y
    }

    /// Whether `p` is within `margin` of the box, per coordinate.
    pub(super) fn near(&self, p: DVec2, margin: DVec2) -> bool {
        p.x >= self.min.x - margin.x
            && p.x <= self.max.x + margin.x
            && p.y >= self.min.y - margin.y
            && p.y <= self.max.y + margin.y
    }

    /// Crossings of the ray from `p` to the right: 1 if the piece rises there, -1 if it falls.
    ///
    /// A point at the height of an end counts as slightly higher and further right, so that every loop is crossed
    /// consistently. `side`: the side of `p`, used if the box holds `p`.
    pub(super) fn crossings_right(&self, p: DVec2, side: CurveSide) -> i32 {
        if p.y < self.min.y || p.y >= self.max.y || p.x >= self.max.x {
            return 0;
        }
        let rises = self.start.y < self.end.y;
        let crosses = p.x < self.min.x || (side == CurveSide::Right) != rises;
        i32::from(crosses) * if rises { 1 } else { -1 }
    }

    /// Crossings of the upward ray from `p`: 1 if the piece runs to the left there, -1 if it runs to the right.
    ///
    /// Ends and `side` are treated as in [`PieceRecord::crossings_right`].
    pub(super) fn crossings_above(&self, p: DVec2, side: CurveSide) -> i32 {
        if p.x < self.min.x || p.x >= self.max.x || p.y >= self.max.y {
            return 0;
        }
        let leftwards = self.end.x < self.start.x;
        let crosses = p.y < self.min.y || (side == CurveSide::Right) != leftwards;
        i32::from(crosses) * if leftwards { 1 } else { -1 }
    }
}
