//! Building of the quadtree, level by level.

use glanz_math::DVec2;

use super::cell_tree::{CellLink, CellTree, GridSquare, MAX_INDEX, MAX_LEVEL};
use super::piece_in_cell::{CellGrid, PieceInCell, QuarteredPiece};
use super::piece_table::PieceTable;
use crate::error::SurfaceError;

/// A cell with more pieces is quartered, within the budget.
const FEW_PIECES: usize = 3;

/// A cell wider than this fraction of its largest piece is quartered, so that crossed cells form a narrow strip.
const STRIP: f64 = 1.0 / 8.0;

/// Number of entries in all cells, per piece, at which quartering stops.
const ENTRIES_PER_PIECE: usize = 96;

/// A cell with pieces, which waits for being quartered or becoming a leaf.
struct PendingCell {
    /// Node and quarter that will refer to it.
    parent: Option<(usize, usize)>,
    square: GridSquare,
    /// Range of its pieces in those of the level.
    first: usize,
    count: usize,
    /// Winding number of its lower right corner.
    winding: i32,
}

/// The cells of one level that have pieces.
#[derive(Default)]
struct CellLevel {
    cells: Vec<PendingCell>,
    pieces: Vec<PieceInCell>,
}

/// A tree being built.
pub(super) struct CellTreeBuilder<'a> {
    pieces: &'a PieceTable,
    tree: CellTree,
    /// Pieces within this distance of a cell belong to it.
    margin: DVec2,
    /// Largest distance from a piece at which a corner may count as left of it.
    clearance: DVec2,
    /// The level, for each piece, of which cells are no wider than the strip.
    strip_levels: Vec<u32>,
    /// The pieces of the cell that is quartered.
    quartered: Vec<QuarteredPiece>,
}

impl<'a> CellTreeBuilder<'a> {
    /// The builder of an empty tree over the domain. Pieces within `margin` of a cell belong to it.
    pub(super) fn new(pieces: &'a PieceTable, [min, max]: [DVec2; 2], margin: DVec2) -> Self {
        let strip_level = |extent: f64| {
            let is_wider = |level: &u32| 1.0 / f64::from(1_u32 << level) > extent * STRIP;
            (0..MAX_LEVEL).take_while(is_wider).count() as u32
        };
        let strip_levels = pieces.pieces.iter().map(|piece| strip_level(piece.extent(max - min))).collect();
        Self {
            pieces,
            tree: CellTree::new(min, max),
            margin,
            clearance: margin + pieces.slack,
            strip_levels,
            quartered: Vec::new(),
        }
    }

    /// The tree. `outermost`: winding number far outside.
    pub(super) fn build(mut self, outermost: i32) -> Result<CellTree, SurfaceError> {
        let budget = 1024 + ENTRIES_PER_PIECE * self.pieces.pieces.len();
        let mut level = self.root(outermost);
        let mut live = level.pieces.len();
        let mut next = CellLevel::default();
        while !level.cells.is_empty() {
            for cell in &level.cells {
                let pieces = level.pieces.get(cell.first..cell.first + cell.count).unwrap_or(&[]);
                if live < budget && self.is_coarse(cell.square, pieces.iter().map(|piece| piece.index)) {
                    live = live - pieces.len() + self.quarter(cell, pieces, &mut next);
                } else {
                    let corner = self.corner(cell.square);
                    let above = |piece: &PieceInCell| piece.crossings_above(self.pieces, corner);
                    let base = cell.winding - pieces.iter().map(above).sum::<i32>();
                    self.tree.push_leaf(cell.parent, base, corner.x, pieces.iter().map(|piece| piece.index));
                }
                self.check_size()?;
            }
            std::mem::swap(&mut level, &mut next);
            next.cells.clear();
            next.pieces.clear();
        }
        Ok(self.tree)
    }

    /// The level of the whole domain; without cells if the domain has no pieces.
    fn root(&mut self, outermost: i32) -> CellLevel {
        let (pieces, square) = (self.pieces, GridSquare { x: 0, y: 0, level: 0 });
        let grid = self.grid(square);
        let (mut winding, mut level) = (outermost, CellLevel::default());
        let corner = DVec2::new(grid.max.x, grid.min.y);
        for (index, piece) in (0_u32..).zip(&pieces.pieces) {
            let inside = PieceInCell::new(pieces, index, &grid, self.clearance);
            winding += inside.crossings_right(pieces, corner);
            if pieces.touches(piece, grid.min, grid.max, self.margin) {
                level.pieces.push(inside);
            }
        }
        let count = level.pieces.len();
        if count == 0 {
            self.tree.set(None, CellLink::uniform(winding));
        } else {
            level.cells.push(PendingCell { parent: None, square, first: 0, count, winding });
        }
        level
    }

    fn grid(&self, square: GridSquare) -> CellGrid {
        let (min, max) = self.tree.bounds(square);
        let (_, middle) = self.tree.bounds(square.quarter(0));
        CellGrid { min, middle, max }
    }

    /// The lower right corner of a cell.
    fn corner(&self, square: GridSquare) -> DVec2 {
        let (min, max) = self.tree.bounds(square);
        DVec2::new(max.x, min.y)
    }

    /// Whether a cell with these pieces is to be quartered.
    fn is_coarse(&self, square: GridSquare, mut pieces: impl Iterator<Item = u32> + Clone) -> bool {
        let is_wide =
            |index: u32| self.strip_levels.get(index as usize).is_some_and(|&level| square.level < level);
        square.level < MAX_LEVEL && (pieces.clone().count() > FEW_PIECES || pieces.all(is_wide))
    }

    /// Adds a node for `cell`, and those of its quarters that are leaves; quarters to be quartered wait in `next`. Returns the
    /// number of pieces in all quarters.
    fn quarter(&mut self, cell: &PendingCell, pieces: &[PieceInCell], next: &mut CellLevel) -> usize {
        let (table, grid) = (self.pieces, self.grid(cell.square));
        let mut quartered = std::mem::take(&mut self.quartered);
        let mut windings = [cell.winding; 4];
        for piece in pieces {
            let piece = piece.quartered(table, &grid, self.margin, self.clearance);
            for (winding, change) in windings.iter_mut().zip(piece.winding_changes(table, &grid)) {
                *winding += change;
            }
            quartered.push(piece);
        }
        let node = self.tree.push_node(cell.parent, windings.map(CellLink::uniform));
        let corners = grid.lower_right_corners();
        let mut entries = 0;
        for (quarter, winding) in windings.into_iter().enumerate() {
            let touching = quartered.iter().filter(|piece| piece.touched[quarter]);
            let count = touching.clone().count();
            entries += count;
            let (square, parent) = (cell.square.quarter(quarter as u32), Some((node, quarter)));
            let indices = touching.clone().map(|piece| piece.index);
            if count == 0 {
                continue;
            }
            if self.is_coarse(square, indices.clone()) {
                let first = next.pieces.len();
                next.pieces.extend(touching.map(|piece| piece.in_quarter(quarter)));
                next.cells.push(PendingCell { parent, square, first, count, winding });
            } else {
                let corner = corners[quarter];
                let above: i32 = touching.map(|piece| piece.crossings_above(table, quarter, corner)).sum();
                self.tree.push_leaf(parent, winding - above, corner.x, indices);
            }
        }
        quartered.clear();
        self.quartered = quartered;
        entries
    }

    fn check_size(&self) -> Result<(), SurfaceError> {
        let (cells, leaves, entries) = self.tree.sizes();
        for (parameter, count) in [("cells", (cells / 4).max(leaves)), ("entries of cells", entries)] {
            if count >= MAX_INDEX {
                return Err(SurfaceError::TooMany { parameter, count, max: MAX_INDEX });
            }
        }
        Ok(())
    }
}
