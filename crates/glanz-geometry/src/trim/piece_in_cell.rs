//! A monotone piece in a cell: points of the piece near the cell's diagonals, and the quarters that it reaches.
//!
//! In coordinates in which the curve rises, the falling diagonal of a cell passes through the middle of the cell and is the
//! diagonal of two of its quarters. One point of the curve near that diagonal proves on which side of the middle the curve
//! passes; one near the falling diagonal of each of the other two quarters does so for the remaining corners. Quarters take over the
//! points, so that each cell needs two new ones.

use glanz_math::DVec2;

use super::piece_table::{CurveSide, PiecePoint, PieceRecord, PieceTable, SideTest};

/// A piece that touches a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct PieceInCell {
    pub(super) index: u32,
    /// Whether the cell's lower right corner is right of the piece; used if the piece's box holds it.
    pub(super) is_corner_right: bool,
    /// Points before and behind the diagonal that the piece crosses.
    ends: [PiecePoint; 2],
    /// A point near the diagonal, between the ends; none as long as a quarter held all of the piece.
    middle: Option<PiecePoint>,
}

/// Relations of a piece to the quarters of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuarteredPiece {
    /// Points near the diagonals of the first quarter along the piece, of the cell, and of the last quarter; none if the piece reaches
    /// only one quarter.
    points: Option<[PiecePoint; 3]>,
    /// The quarter in which the piece, were it to run from corner to corner, would start.
    first: u8,
    /// Bits of the quarters whose lower right corner is right of the piece.
    is_right: u8,
    /// Bits of the quarters that the piece touches.
    touched: u8,
}

/// Three lines of a grid each way: the sides of a cell and its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellGrid {
    pub(super) min: DVec2,
    pub(super) middle: DVec2,
    pub(super) max: DVec2,
}

impl CellGrid {
    /// The lower right corners of the quarters.
    pub(super) fn lower_right_corners(&self) -> [DVec2; 4] {
        let (low, high) = (self.min.y, self.middle.y);
        let (left, right) = (self.middle.x, self.max.x);
        [DVec2::new(left, low), DVec2::new(right, low), DVec2::new(left, high), DVec2::new(right, high)]
    }
}

impl PieceInCell {
    /// The piece number `index` in the cell of `grid`. Within the clearance of the piece corners may count as left of it.
    pub(super) fn new(pieces: &PieceTable, index: u32, grid: &CellGrid) -> Self {
        let piece = &pieces.pieces[index as usize];
        let clearance = pieces.margin(piece) + pieces.slack;
        let corner = DVec2::new(grid.max.x, grid.min.y);
        let side = if piece.holds(corner) {
            pieces.side_with_clearance(piece, corner, clearance)
        } else {
            CurveSide::Left
        };
        let start = PiecePoint { t: 0.0, position: piece.start };
        let end = PiecePoint { t: 1.0, position: piece.end };
        Self { index, is_corner_right: side == CurveSide::Right, ends: [start, end], middle: None }
    }

    /// Crossings of the ray to the right from the cell's lower right corner.
    pub(super) fn crossings_right(&self, pieces: &PieceTable, corner: DVec2) -> i32 {
        pieces.pieces[self.index as usize].crossings_right(corner, right_or_left(self.is_corner_right))
    }

    /// The piece with its relations to the quarters of the cell. Quarters within the margin of the piece are touched; within
    /// the clearance, which is larger, corners may count as left of the piece.
    pub(super) fn quartered(&self, pieces: &PieceTable, grid: &CellGrid) -> QuarteredPiece {
        let piece = &pieces.pieces[self.index as usize];
        let margin = pieces.margin(piece);
        let clearance = margin + pieces.slack;
        let (turn, center) = (piece.turn(), grid.middle);
        let first = u8::from(turn.x < 0.0) | (u8::from(turn.y < 0.0) << 1);
        let (low, high) = (piece.min.cmple(center + margin), piece.max.cmpge(center - margin));
        let reaches = [low.x && low.y, high.x && low.y, low.x && high.y, high.x && high.y];
        // The box of a piece that reaches one quarter only holds no corner of a quarter except the cell's own, and those do not exclude
        // it, since the piece touches the cell.
        if reaches.into_iter().filter(|&reaches| reaches).count() == 1 {
            let is_right = bits([false, self.is_corner_right, false, false]);
            return QuarteredPiece { points: None, first, is_right, touched: bits(reaches) };
        }
        // The grid in coordinates in which the curve rises.
        let (x0, x2) = if turn.x < 0.0 { (grid.max.x, grid.min.x) } else { (grid.min.x, grid.max.x) };
        let (y0, y2) = if turn.y < 0.0 { (grid.max.y, grid.min.y) } else { (grid.min.y, grid.max.y) };
        let (left, bottom) = (DVec2::new(x0, center.y), DVec2::new(center.x, y0));
        let (top, right) = (DVec2::new(center.x, y2), DVec2::new(x2, center.y));
        let ([before, behind], scale) = (self.ends, turn / (grid.max - grid.min));
        let near_center = || pieces.near_diagonal(piece, [before, behind], center, scale);
        let middle = self.middle.unwrap_or_else(near_center);
        let start = pieces.near_diagonal(piece, [before, middle], left, scale);
        let end = pieces.near_diagonal(piece, [middle, behind], top, scale);
        let side = |corner: DVec2, point: PiecePoint| {
            let side = SideTest::new(piece, corner, clearance).side(point.position);
            if side == CurveSide::On { pieces.side_of_corner(piece, corner, clearance) } else { side }
        };
        let (at_left, at_bottom) = (side(left, start), side(bottom, start));
        let at_center = side(center, middle);
        let (at_top, at_right) = (side(top, end), side(right, end));
        let (passes_above, passes_below) = piece.sides();
        let misses = [
            at_left == passes_above || at_bottom == passes_below,
            at_center == passes_above,
            at_center == passes_below,
            at_top == passes_above || at_right == passes_below,
        ];
        let below_center = if turn.y > 0.0 { at_bottom } else { at_top };
        let beside_center = if turn.x > 0.0 { at_right } else { at_left };
        let touches = |quarter: usize| reaches[quarter] && !misses[quarter ^ usize::from(first)];
        let is_right = [
            below_center == CurveSide::Right,
            self.is_corner_right,
            at_center == CurveSide::Right,
            beside_center == CurveSide::Right,
        ];
        QuarteredPiece {
            points: Some([start, middle, end]),
            first,
            is_right: bits(is_right),
            touched: bits([touches(0), touches(1), touches(2), touches(3)]),
        }
    }
}

/// Bit i is the flag number i.
fn bits(flags: [bool; 4]) -> u8 {
    (0..).zip(flags).fold(0, |bits, (i, flag)| bits | (u8::from(flag) << i))
}

impl QuarteredPiece {
    /// Whether the piece touches a quarter.
    pub(super) fn touches(&self, quarter: usize) -> bool {
        (self.touched >> quarter) & 1 != 0
    }

    /// Whether the lower right corner of a quarter is right of the piece; used if the piece's box holds it.
    pub(super) fn is_right(&self, quarter: usize) -> bool {
        (self.is_right >> quarter) & 1 != 0
    }

    /// `piece`, from which this was made, in one quarter.
    pub(super) fn in_quarter(&self, piece: &PieceInCell, quarter: usize) -> PieceInCell {
        let (index, is_corner_right) = (piece.index, self.is_right(quarter));
        let Some([start, middle, end]) = self.points else {
            return PieceInCell { is_corner_right, middle: None, ..*piece };
        };
        let [before, behind] = piece.ends;
        let (ends, near) = match quarter ^ usize::from(self.first) {
            0 => ([before, middle], start),
            3 => ([middle, behind], end),
            _ => ([start, end], middle),
        };
        PieceInCell { index, is_corner_right, ends, middle: Some(near) }
    }

    /// Changes of the winding numbers from the cell's corner to those of its quarters, for this piece.
    ///
    /// The paths to that corner lead right to the edge of the cell, then down.
    #[inline]
    pub(super) fn winding_changes(&self, piece: &PieceRecord, grid: &CellGrid) -> [i32; 4] {
        let corners = grid.lower_right_corners();
        let side = |quarter: usize| right_or_left(self.is_right(quarter));
        let right = |quarter: usize| piece.crossings_right(corners[quarter], side(quarter));
        let above = |quarter: usize| piece.crossings_above(corners[quarter], side(quarter));
        let up = above(3) - above(1);
        [right(0) - right(1), 0, right(2) - right(3) + up, up]
    }
}

/// The side of a point that is right of a piece, or left.
pub(super) fn right_or_left(is_right: bool) -> CurveSide {
    if is_right { CurveSide::Right } else { CurveSide::Left }
}

impl PieceTable {
    /// The side of a corner for which a point near a diagonal does not decide; `On` if it is not sure.
    #[cold]
    fn side_of_corner(&self, piece: &PieceRecord, corner: DVec2, clearance: DVec2) -> CurveSide {
        let test = SideTest::new(piece, corner, clearance);
        match (test.side(piece.start), test.side(piece.end)) {
            (CurveSide::On, CurveSide::On) if piece.near(corner, clearance) => {
                self.side_with_clearance(piece, corner, clearance)
            }
            (CurveSide::On, side) | (side, _) => side,
        }
    }

    /// A point near the falling diagonal through `p`, between two points of the piece: one step of regula falsi. One of the two
    /// if the diagonal does not pass between them.
    ///
    /// `scale`: coordinates times it rise along the piece, and are those of a square cell.
    #[inline]
    fn near_diagonal(
        &self,
        piece: &PieceRecord,
        [from, to]: [PiecePoint; 2],
        p: DVec2,
        scale: DVec2,
    ) -> PiecePoint {
        let (low, high) = ((from.position - p).dot(scale), (to.position - p).dot(scale));
        if low >= 0.0 {
            return from;
        }
        if high <= 0.0 {
            return to;
        }
        let t = (from.t + (to.t - from.t) * (low / (low - high))).min(to.t);
        self.point(piece, t)
    }
}
