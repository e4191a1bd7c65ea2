//! The trimmed region of a parameter domain.

use glanz_math::DVec2;

use super::cell_tree::{CellLookup, CellTree};
use super::curve::{TrimCurve, check_range};
use super::loops::TrimLoop;
use super::monotone::MonotonePiece;
use super::piece_table::PieceTable;
use crate::error::{SurfaceError, not_negative};

/// Largest gap between consecutive curves of a loop, relative to the extent of all loops: coordinates are often written
/// with seven digits.
const LOOP_GAP: f64 = 1e-6;

/// Width of the kept strip along a trimming curve, relative to the extent of all loops: the parameters of one point may
/// differ by this much in two faces that meet in the curve.
const BORDER: f64 = 1e-9;

/// Width of the domain around the loops, relative to their extent.
const DOMAIN_MARGIN: f64 = 0.1;

/// Relation of a rectangle to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// The whole rectangle is kept.
    Inside,
    /// The whole rectangle is cut away.
    Outside,
    /// A curve crosses it, or comes so near that it might.
    Crossed,
}

/// The part of a rectangular parameter domain on the left of closed loops.
///
/// A point is kept if its winding number is greater than zero. The winding number counts how often the loops go round the point
/// counter-clockwise; 1 is added everywhere if the domain itself is the outermost material: if the loop of the largest area
/// runs clockwise, or if there are no loops. Holes, islands and islands in holes follow from this rule. For loops that do not
/// alternate (a counter-clockwise loop directly inside another, a hole in a hole) winding numbers add up: points inside both
/// counter-clockwise loops are kept, and a doubly cut hole needs two islands to be filled. Points on a curve are always kept, so
/// that two faces with a common border leave no gap.
///
/// # Source
/// @markgraf2019 section 4.3; departure: the winding number, which handles both orientations and nesting, instead of
/// "trimmed if the sum is 1".
#[derive(Clone, Debug)]
pub struct TrimRegion {
    pieces: PieceTable,
    cells: CellTree,
    domain: [DVec2; 2],
    /// Winding number far outside.
    outermost: i32,
    /// Distance from a curve within which points are kept, parameter units.
    border: f64,
}

impl TrimRegion {
    /// The region that `loops` keep of the domain from `domain[0]` to `domain[1]`.
    ///
    /// Loops may leave the domain. Without loops, the whole domain is kept.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::EmptyRange`] for the domain, [`SurfaceError::TooMany`] from 2^30 control
    /// points on.
    pub fn try_new(loops: Vec<TrimLoop>, domain: [DVec2; 2]) -> Result<Self, SurfaceError> {
        Self::with_border(loops, domain, 0.0)
    }

    /// The region of [`TrimRegion::try_new`], with the points within `border` of a curve.
    fn with_border(loops: Vec<TrimLoop>, domain: [DVec2; 2], border: f64) -> Result<Self, SurfaceError> {
        let [min, max] = domain;
        check_range("domain", min, max)?;
        let largest = loops.iter().fold(0.0, |largest: f64, trim_loop| {
            // The bound is the area of a rectangle, with another rounding.
            if trim_loop.area_bound() * (1.0 + 1e-9) <= largest.abs() {
                return largest;
            }
            let area = trim_loop.approximate_area();
            if area.abs() > largest.abs() { area } else { largest }
        });
        let outermost = i32::from(loops.is_empty() || largest < 0.0);
        let pieces = PieceTable::try_new(&loops, min.abs().max(max.abs()))?;
        let cells = CellTree::try_new(&pieces, domain, outermost, margin(&pieces, border))?;
        Ok(Self { pieces, cells, domain, outermost, border })
    }

    /// The region that loops of curves keep, with tolerances in proportion to their extent.
    ///
    /// The extent is the longer side of a box around all control points. Consecutive curves may end and start 1e-6 of it
    /// apart, points within 1e-9 of it from a curve are kept, and the domain is the box widened by a tenth of it: what
    /// lies beyond is kept or not as the nearest point of the box is.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without curves, [`SurfaceError::OpenLoop`], [`SurfaceError::CollapsedLoop`],
    /// [`SurfaceError::NotFinite`], and those of [`TrimRegion::try_new`].
    pub fn try_from_curves(loops: Vec<Vec<TrimCurve>>) -> Result<Self, SurfaceError> {
        if loops.iter().all(Vec::is_empty) {
            return Err(SurfaceError::TooFew { parameter: "trimming curves", count: 0, min: 1 });
        }
        let [low, high] = loops
            .iter()
            .flatten()
            .map(|curve| curve.bounds)
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
        let extent = (high - low).max_element();
        let margin = DVec2::splat(DOMAIN_MARGIN * extent);
        let loops = loops.into_iter().map(|curves| TrimLoop::try_new(curves, LOOP_GAP * extent));
        let loops: Vec<TrimLoop> = loops.collect::<Result<_, _>>()?;
        Self::with_border(loops, [low - margin, high + margin], BORDER * extent)
    }

    /// The region extended by all points within `tolerance` (parameter units) of a curve.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::Negative`], [`SurfaceError::TooMany`].
    pub fn with_widened_border(self, tolerance: f64) -> Result<Self, SurfaceError> {
        let border = not_negative("tolerance of the border", tolerance)?;
        let cells =
            CellTree::try_new(&self.pieces, self.domain, self.outermost, margin(&self.pieces, border))?;
        Ok(Self { cells, border, ..self })
    }

    /// Whether the point `uv` is kept; exact except for points within rounding of a curve, which are kept.
    ///
    /// A point outside the domain, where rounding may put a hit, is clamped to it. NaN is not kept.
    #[inline]
    #[must_use]
    pub fn contains(&self, uv: DVec2) -> bool {
        if uv.is_nan() {
            return false;
        }
        let p = uv.max(self.domain[0]).min(self.domain[1]);
        match self.cells.find(p) {
            CellLookup::Uniform(inside) => inside,
            CellLookup::Crossed(leaf) => {
                let list = self.cells.entries(leaf);
                self.pieces.winding(leaf, list, p).is_none_or(|winding| winding > 0)
                    || (self.border > 0.0 && self.is_on_border(list, p))
            }
        }
    }

    #[cold]
    fn is_on_border(&self, list: &[u32], p: DVec2) -> bool {
        let pieces = list.iter().filter_map(|&i| self.pieces.pieces.get(i as usize));
        pieces
            .filter(|piece| piece.near(p, self.pieces.slack + self.border))
            .any(|piece| self.pieces.is_within(piece, p, self.border))
    }

    /// The relation of the rectangle from `min` to `max`, clamped to the domain, to the region.
    ///
    /// `Inside` and `Outside` are certain. A rectangle with NaN, or with `min` greater than `max`, is `Crossed`.
    #[must_use]
    pub fn classify(&self, min: DVec2, max: DVec2) -> Containment {
        if !min.cmple(max).all() {
            return Containment::Crossed;
        }
        let [low, high] = self.domain;
        let (min, max) = (min.clamp(low, high), max.clamp(low, high));
        let margin = margin(&self.pieces, self.border);
        let meets = |i: u32| {
            let piece = self.pieces.pieces.get(i as usize);
            piece.is_some_and(|piece| self.pieces.touches(piece, min, max, margin))
        };
        if self.cells.any_piece(min, max, meets) {
            Containment::Crossed
        } else if self.contains(0.5 * min + 0.5 * max) {
            Containment::Inside
        } else {
            Containment::Outside
        }
    }

    /// Corners of the domain.
    #[must_use]
    pub fn domain(&self) -> [DVec2; 2] {
        self.domain
    }

    /// The winding number far outside.
    #[must_use]
    pub fn outermost(&self) -> i32 {
        self.outermost
    }

    /// The curves of all loops, split into pieces monotone in u and in v; each ends, to the bit, where the next of its loop starts.
    pub fn monotone_pieces(&self) -> impl ExactSizeIterator<Item = MonotonePiece> + '_ {
        self.pieces.pieces.iter().map(|piece| MonotonePiece {
            start: piece.start,
            end: piece.end,
            control_points: self.pieces.control_points(piece),
        })
    }

    /// The distance from a curve within which points are kept, parameter units.
    #[must_use]
    pub fn border(&self) -> f64 {
        self.border
    }

    /// Numbers of pieces and cells.
    #[must_use]
    pub fn statistics(&self) -> TrimStatistics {
        let (cells, crossed_cells, entries) = self.cells.sizes();
        TrimStatistics { pieces: self.pieces.pieces.len(), cells, crossed_cells, entries }
    }
}

/// Numbers of pieces and cells of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrimStatistics {
    /// Monotone pieces of curves.
    pub pieces: usize,
    /// Cells of the hierarchy, on all levels.
    pub cells: usize,
    /// Cells that curves cross or come close to.
    pub crossed_cells: usize,
    /// Pieces in crossed cells, counted once per cell.
    pub entries: usize,
}

/// Distance from a cell within which a piece belongs to it: the corners of a cell, the cell of a point and both sides of a piece
/// are each accurate to the slack.
fn margin(pieces: &PieceTable, border: f64) -> DVec2 {
    4.0 * pieces.slack + border
}
