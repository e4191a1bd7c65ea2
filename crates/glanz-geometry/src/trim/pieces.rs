//! All monotone pieces of a region, in flat arrays, and on which side of one a point lies.

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::curve::MAX_DEGREE;
use super::loops::TrimLoop;
use crate::bezier::bernstein::{binomials, halve};
use crate::error::SurfaceError;

/// Where a point lies, seen along a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    /// Within rounding of the curve.
    On,
}

/// A rational Bézier curve that is monotone in u and in v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) start: DVec2,
    pub(super) end: DVec2,
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    /// Its first entry in the terms.
    first: u32,
    degree: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Pieces {
    pub(super) pieces: Vec<Piece>,
    /// Control points times their binomials.
    terms: Vec<DVec3>,
    /// How far a computed point may be from the curve and the curve from being monotone: along u, along v.
    pub(super) slack: DVec2,
}

impl Pieces {
    /// `reach`: the largest coordinates, in magnitude, at which the pieces will be asked.
    pub(super) fn try_new(loops: &[TrimLoop], reach: DVec2) -> Result<Self, SurfaceError> {
        let (mut pieces, mut terms) = (Vec::new(), Vec::new());
        let (mut reach, mut highest) = (reach, 1);
        for part in loops.iter().flat_map(|l| &l.parts) {
            let degree = part.points.len().saturating_sub(1).min(MAX_DEGREE) as u32;
            let Ok(first) = u32::try_from(terms.len()) else {
                let max = u32::MAX as usize;
                return Err(SurfaceError::TooMany { parameter: "control points", count: terms.len(), max });
            };
            let (start, end) = (part.start, part.end);
            pieces.push(Piece { start, end, min: start.min(end), max: start.max(end), first, degree });
            terms.extend(part.points.iter().zip(binomials(degree as usize)).map(|(&p, b)| p * b));
            reach = reach.max(start.abs()).max(end.abs());
            highest = highest.max(degree);
        }
        // A value has 4 n + 4 roundings, the cuts that made the piece 3 n each; moved ends and the search for turns
        // (2 n + 4 for each of 48 halvings, of the speed times the width of what stays unknown) are below the rest.
        Ok(Self { pieces, terms, slack: reach * gamma(64 * (highest + 4)) })
    }

    fn terms(&self, piece: &Piece) -> &[DVec3] {
        let first = piece.first as usize;
        self.terms.get(first..first + piece.degree as usize + 1).unwrap_or(&[])
    }

    /// Homogeneous control points.
    pub(super) fn control_points(&self, piece: &Piece) -> Vec<DVec3> {
        self.terms(piece).iter().zip(binomials(piece.degree as usize)).map(|(&term, b)| term / b).collect()
    }

    /// The point at `t`: Horner's rule with powers of `t` and `1 - t`, all terms of one sign.
    ///
    /// # Source
    /// @farin2002 chapter 5.
    #[inline]
    fn point(terms: &[DVec3], t: f64) -> DVec2 {
        let s = 1.0 - t;
        let (mut sum, mut power) = (DVec3::ZERO, 1.0);
        for &term in terms {
            sum = sum * s + term * power;
            power *= t;
        }
        sum.truncate() / sum.z
    }

    /// The side of `piece` on which `p` lies, in or near its box.
    ///
    /// Turned so that it climbs, a monotone curve with a point to the upper left of `p` passes `p` there: one such
    /// point decides. It is sought where the curve crosses the falling diagonal through `p`, by regula falsi in a
    /// bracket. `Left` and `Right` are only said of points more than the slack away in a coordinate.
    ///
    /// # Source
    /// @press2007 section 9.2; departure: halving at every third step.
    pub(super) fn side(&self, piece: &Piece, p: DVec2) -> Side {
        let turn = DVec2::new(
            if piece.end.x < piece.start.x { -1.0 } else { 1.0 },
            if piece.end.y < piece.start.y { -1.0 } else { 1.0 },
        );
        let (upper_left, lower_right) =
            if turn.x * turn.y > 0.0 { (Side::Right, Side::Left) } else { (Side::Left, Side::Right) };
        // In units of the slack.
        let (terms, scale) = (self.terms(piece), turn / self.slack);
        let climb = |q: DVec2| (q - p) * scale;
        let (mut low, mut high) =
            ((0.0, climb(piece.start).element_sum()), (1.0, climb(piece.end).element_sum()));
        for step in 0..192 {
            let mut t: f64 = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1));
            let inside = t > low.0 && t < high.0;
            if step % 3 == 2 || !inside {
                t = 0.5 * low.0 + 0.5 * high.0;
                if t <= low.0 || t >= high.0 {
                    break;
                }
            }
            let d = climb(Self::point(terms, t));
            if d.x < -1.0 && d.y > 1.0 {
                return upper_left;
            }
            if d.x > 1.0 && d.y < -1.0 {
                return lower_right;
            }
            let beyond = d.x > 1.0 || d.y > 1.0;
            if !beyond && d.x >= -1.0 && d.y >= -1.0 {
                return Side::On;
            }
            if beyond {
                high = (t, d.element_sum());
            } else {
                low = (t, d.element_sum());
            }
        }
        Side::On
    }

    /// Whether `piece` may touch the rectangle; `margin` (at least twice the slack) is added on all sides.
    pub(super) fn touches(&self, piece: &Piece, min: DVec2, max: DVec2, margin: DVec2) -> bool {
        let (min, max) = (min - margin, max + margin);
        if piece.max.x < min.x || piece.min.x > max.x || piece.max.y < min.y || piece.min.y > max.y {
            return false;
        }
        // The corners furthest to the two sides of a curve that climbs, or falls.
        let climbs = (piece.end.x < piece.start.x) == (piece.end.y < piece.start.y);
        let (above, below) =
            if climbs { (DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)) } else { (max, min) };
        // Left of a curve that runs to the right is above it.
        let (side_above, side_below) =
            if piece.end.x < piece.start.x { (Side::Right, Side::Left) } else { (Side::Left, Side::Right) };
        // Level or upright pieces are their boxes.
        if piece.min.x == piece.max.x || piece.min.y == piece.max.y {
            return true;
        }
        let misses = |corner: DVec2, other: Side| piece.holds(corner) && self.side(piece, corner) == other;
        !misses(above, side_below) && !misses(below, side_above)
    }

    /// Whether the curve comes as near to `p` as `tolerance` (by the distance in the plane).
    ///
    /// Parts lie around their chord no further than their control points do; those for which that does not tell are
    /// halved, until they are straight to rounding.
    pub(super) fn is_within(&self, piece: &Piece, p: DVec2, tolerance: f64) -> bool {
        let terms = self.terms(piece);
        let mut points = [DVec3::ZERO; MAX_DEGREE + 1];
        let Some(points) = points.get_mut(..terms.len()) else { return false };
        for ((point, term), binomial) in points.iter_mut().zip(terms).zip(binomials(piece.degree as usize)) {
            *point = *term / binomial;
        }
        part_is_within(points, p, tolerance, self.slack.max_element(), 60)
    }
}

fn part_is_within(points: &[DVec3], p: DVec2, tolerance: f64, slack: f64, splits: u32) -> bool {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return false };
    let (start, end) = (first.truncate() / first.z - p, last.truncate() / last.z - p);
    let distance = segment_distance(start, end, DVec2::ZERO);
    let sag =
        points.iter().fold(0.0_f64, |sag, q| sag.max(segment_distance(start, end, q.truncate() / q.z - p)));
    if distance + sag <= tolerance {
        return true;
    }
    if distance - sag > tolerance {
        return false;
    }
    if sag <= slack || splits == 0 {
        return true;
    }
    let (mut left, mut right) = ([DVec3::ZERO; MAX_DEGREE + 1], [DVec3::ZERO; MAX_DEGREE + 1]);
    let count = points.len();
    left[..count].copy_from_slice(points);
    halve(&mut left[..count], &mut right[..count]);
    part_is_within(&left[..count], p, tolerance, slack, splits - 1)
        || part_is_within(&right[..count], p, tolerance, slack, splits - 1)
}

/// Distance of `q` from the straight line between two points.
fn segment_distance(start: DVec2, end: DVec2, q: DVec2) -> f64 {
    let along = end - start;
    let length2 = along.length_squared();
    let share = if length2 > 0.0 { ((q - start).dot(along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (start + along * share).distance(q)
}

impl Piece {
    /// Largest extent, each coordinate in units of `size`.
    pub(super) fn extent(&self, size: DVec2) -> f64 {
        ((self.max - self.min) / size).max_element()
    }

    /// Whether `p` lies in the box, its lower and left sides included: both of the piece's crossings depend on the side.
    pub(super) fn holds(&self, p: DVec2) -> bool {
        p.x >= self.min.x && p.x < self.max.x && p.y >= self.min.y && p.y < self.max.y
    }

    /// Whether `p` is in the box or within `margin` of it, per coordinate.
    pub(super) fn near(&self, p: DVec2, margin: DVec2) -> bool {
        p.x >= self.min.x - margin.x
            && p.x <= self.max.x + margin.x
            && p.y >= self.min.y - margin.y
            && p.y <= self.max.y + margin.y
    }

    /// Crossings of the ray from `p` to the right: 1 if the piece rises there, -1 if it falls.
    ///
    /// A point level with an end counts as a little higher and further right, so that every loop is crossed
    /// consistently. `side`: that of `p` if the piece holds it.
    pub(super) fn crossings_right(&self, p: DVec2, side: Side) -> i32 {
        if p.y < self.min.y || p.y >= self.max.y || p.x >= self.max.x {
            return 0;
        }
        let rises = self.start.y < self.end.y;
        let met = p.x < self.min.x || (side == Side::Right) != rises;
        i32::from(met) * if rises { 1 } else { -1 }
    }

    /// Crossings of the upward ray from `p`: 1 if the piece runs to the left there, -1 if it runs to the right.
    ///
    /// Level points and `side` as for [`Piece::crossings_right`].
    pub(super) fn crossings_above(&self, p: DVec2, side: Side) -> i32 {
        if p.x < self.min.x || p.x >= self.max.x || p.y >= self.max.y {
            return 0;
        }
        let leftwards = self.end.x < self.start.x;
        let met = p.y < self.min.y || (side == Side::Right) != leftwards;
        i32::from(met) * if leftwards { 1 } else { -1 }
    }
}
