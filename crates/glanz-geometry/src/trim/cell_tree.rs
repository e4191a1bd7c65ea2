//! The quadtree over the domain: cells that curves cross, and cells inside or outside as a whole.

use std::collections::VecDeque;

use glanz_math::DVec2;

use super::piece_table::{CurveSide, PieceRecord, PieceTable};
use crate::error::SurfaceError;

/// Largest depth of the tree.
const MAX_LEVEL: u32 = 20;

/// A cell with more pieces is quartered, within the budget.
const FEW_PIECES: usize = 3;

/// A cell wider than this fraction of its largest piece is quartered, so that crossed cells form a narrow strip.
const STRIP: f64 = 1.0 / 8.0;

/// Number of entries in all cells, per piece, at which quartering stops.
const ENTRIES_PER_PIECE: usize = 96;

/// A reference to a cell: a tag, and the index of its four quarters or of its leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct CellLink(u32);

const TAG_BITS: u32 = 30;
const TAG_NODE: u32 = 0;
const TAG_LEAF: u32 = 1;
const TAG_OUTSIDE: u32 = 2;
const TAG_INSIDE: u32 = 3;
const MAX_INDEX: usize = (1 << TAG_BITS) - 1;

/// The result of looking up the cell of a point.
pub(super) enum CellLookup<'a> {
    /// The whole cell is inside, or outside.
    Uniform(bool),
    /// Curves cross the cell or come near.
    Crossed(&'a CrossedCell),
}

/// A cell that curves cross or come near.
#[derive(Clone, Copy, Debug)]
pub(super) struct CrossedCell {
    first: u32,
    count: u32,
    /// Winding number of the cell's lower right corner, less the crossings of its pieces above that corner.
    base: i32,
    /// Right side of the cell.
    edge: f64,
}

/// A square of a grid with 2^level cells each way.
#[derive(Clone, Copy, Debug)]
struct GridSquare {
    x: u32,
    y: u32,
    level: u32,
}

/// A quadtree over the domain of a region.
#[derive(Clone, Debug)]
pub(super) struct CellTree {
    root: CellLink,
    nodes: Vec<[CellLink; 4]>,
    leaves: Vec<CrossedCell>,
    entries: Vec<u32>,
    min: DVec2,
    max: DVec2,
    /// Size of the smallest cell, and its inverse.
    unit: DVec2,
    per_unit: DVec2,
}

/// A cell that waits for being classified or quartered.
struct PendingCell {
    /// Node and quarter that will refer to it.
    parent: Option<(usize, usize)>,
    square: GridSquare,
    pieces: Vec<u32>,
    /// Winding number of its lower right corner.
    winding: i32,
}

impl CellTree {
    /// The tree over the domain. `outermost`: winding number far outside. Pieces within `margin` of a cell belong to it.
    pub(super) fn try_new(
        pieces: &PieceTable,
        [min, max]: [DVec2; 2],
        outermost: i32,
        margin: DVec2,
    ) -> Result<Self, SurfaceError> {
        let steps = f64::from(1_u32 << MAX_LEVEL);
        let unit = (max - min) / steps;
        let mut tree = Self {
            root: CellLink(0),
            nodes: Vec::new(),
            leaves: Vec::new(),
            entries: Vec::new(),
            min,
            max,
            unit,
            per_unit: unit.recip(),
        };
        let count = pieces.pieces.len();
        let all = (0..count as u32).filter(|&i| pieces.touches(&pieces.pieces[i as usize], min, max, margin));
        let corner = DVec2::new(max.x, min.y);
        let winding = outermost
            + pieces
                .pieces
                .iter()
                .map(|piece| piece.crossings_right(corner, side_in_box(pieces, piece, corner)))
                .sum::<i32>();
        let root = PendingCell {
            parent: None,
            square: GridSquare { x: 0, y: 0, level: 0 },
            pieces: all.collect(),
            winding,
        };
        let budget = 1024 + ENTRIES_PER_PIECE * count;
        let mut live = root.pieces.len();
        let mut queue = VecDeque::from([root]);
        while let Some(cell) = queue.pop_front() {
            let link = if cell.pieces.is_empty() {
                CellLink((if cell.winding > 0 { TAG_INSIDE } else { TAG_OUTSIDE }) << TAG_BITS)
            } else if live < budget && tree.is_coarse(pieces, &cell) {
                let quarters = tree.quarters(pieces, &cell, margin);
                live = live - cell.pieces.len() + quarters.iter().map(|q| q.pieces.len()).sum::<usize>();
                queue.extend(quarters);
                tree.nodes.push([CellLink(0); 4]);
                CellLink((TAG_NODE << TAG_BITS) | (tree.nodes.len() - 1) as u32)
            } else {
                tree.leaf(pieces, &cell)
            };
            for (parameter, count) in
                [("cells", tree.nodes.len().max(tree.leaves.len())), ("entries of cells", tree.entries.len())]
            {
                if count >= MAX_INDEX {
                    return Err(SurfaceError::TooMany { parameter, count, max: MAX_INDEX });
                }
            }
            match cell.parent {
                Some((node, quarter)) => tree.nodes[node][quarter] = link,
                None => tree.root = link,
            }
        }
        Ok(tree)
    }

    fn is_coarse(&self, pieces: &PieceTable, cell: &PendingCell) -> bool {
        if cell.square.level >= MAX_LEVEL {
            return false;
        }
        let size = self.max - self.min;
        let largest = cell.pieces.iter().fold(0.0_f64, |a, &i| a.max(pieces.pieces[i as usize].extent(size)));
        let width = 1.0 / f64::from(1_u32 << cell.square.level);
        cell.pieces.len() > FEW_PIECES || width > largest * STRIP
    }

    fn quarters(&self, pieces: &PieceTable, cell: &PendingCell, margin: DVec2) -> [PendingCell; 4] {
        let GridSquare { x, y, level } = cell.square;
        let node = self.nodes.len();
        let (_, max) = self.bounds(cell.square);
        let base = cell.winding - pieces.above(&cell.pieces, self.corner(cell.square));
        std::array::from_fn(|quarter| {
            let square = GridSquare {
                x: 2 * x + (quarter as u32 & 1),
                y: 2 * y + (quarter as u32 >> 1),
                level: level + 1,
            };
            let (low, high) = self.bounds(square);
            let touching = |i: &u32| pieces.touches(&pieces.pieces[*i as usize], low, high, margin);
            PendingCell {
                parent: Some((node, quarter)),
                square,
                pieces: cell.pieces.iter().copied().filter(touching).collect(),
                winding: base + pieces.winding_change_from_left(&cell.pieces, self.corner(square), max.x),
            }
        })
    }

    fn leaf(&mut self, pieces: &PieceTable, cell: &PendingCell) -> CellLink {
        let corner = self.corner(cell.square);
        self.leaves.push(CrossedCell {
            first: self.entries.len() as u32,
            count: cell.pieces.len() as u32,
            base: cell.winding - pieces.above(&cell.pieces, corner),
            edge: corner.x,
        });
        self.entries.extend(&cell.pieces);
        CellLink((TAG_LEAF << TAG_BITS) | (self.leaves.len() - 1) as u32)
    }

    /// Corners of a cell; neighbours agree on theirs to the bit.
    fn bounds(&self, square: GridSquare) -> (DVec2, DVec2) {
        let shift = MAX_LEVEL - square.level;
        let at =
            |x: u32, y: u32| self.min + DVec2::new(f64::from(x << shift), f64::from(y << shift)) * self.unit;
        (at(square.x, square.y), at(square.x + 1, square.y + 1))
    }

    fn corner(&self, square: GridSquare) -> DVec2 {
        let (low, high) = self.bounds(square);
        DVec2::new(high.x, low.y)
    }

    /// The smallest possible cell that contains a point of the domain, up to rounding.
    #[inline]
    fn grid(&self, p: DVec2) -> (u32, u32) {
        let last = (1_u32 << MAX_LEVEL) - 1;
        let at = (p - self.min) * self.per_unit;
        ((at.x as u32).min(last), (at.y as u32).min(last))
    }

    /// The cell of `p`, a point of the domain.
    #[inline]
    pub(super) fn find(&self, p: DVec2) -> CellLookup<'_> {
        let (x, y) = self.grid(p);
        let (mut link, mut shift) = (self.root.0, MAX_LEVEL);
        while link >> TAG_BITS == TAG_NODE {
            let Some(node) = self.nodes.get(link as usize) else { break };
            shift = shift.saturating_sub(1);
            let quarter = ((x >> shift) & 1) | (((y >> shift) & 1) << 1);
            link = node[quarter as usize & 3].0;
        }
        match (link >> TAG_BITS, self.leaves.get(link as usize & MAX_INDEX)) {
            (TAG_LEAF, Some(leaf)) => CellLookup::Crossed(leaf),
            (tag, _) => CellLookup::Uniform(tag == TAG_INSIDE),
        }
    }

    /// The pieces of a leaf.
    #[inline]
    pub(super) fn entries(&self, leaf: &CrossedCell) -> &[u32] {
        let first = leaf.first as usize;
        self.entries.get(first..first + leaf.count as usize).unwrap_or(&[])
    }

    /// Whether `meets` is true for a piece in a cell that overlaps the rectangle.
    pub(super) fn any_piece(&self, min: DVec2, max: DVec2, meets: impl Fn(u32) -> bool) -> bool {
        let ((x0, y0), (x1, y1)) = (self.grid(min), self.grid(max));
        let mut stack = vec![(self.root.0, GridSquare { x: 0, y: 0, level: 0 })];
        while let Some((link, GridSquare { x, y, level })) = stack.pop() {
            let shift = MAX_LEVEL - level;
            if x > x1 >> shift || x < x0 >> shift || y > y1 >> shift || y < y0 >> shift {
                continue;
            }
            let index = link as usize & MAX_INDEX;
            match link >> TAG_BITS {
                TAG_NODE => {
                    let node = self.nodes.get(index).into_iter().flatten();
                    stack.extend(node.enumerate().map(|(quarter, link)| {
                        let (right, up) = (quarter as u32 & 1, quarter as u32 >> 1);
                        (link.0, GridSquare { x: 2 * x + right, y: 2 * y + up, level: level + 1 })
                    }));
                }
                TAG_LEAF => {
                    let entries = self.leaves.get(index).map_or(&[][..], |leaf| self.entries(leaf));
                    if entries.iter().any(|&i| meets(i)) {
                        return true;
                    }
                }
                _ => {}
            }
        }
        false
    }

    /// Numbers of all cells, of crossed cells, and of their entries.
    pub(super) fn sizes(&self) -> (usize, usize, usize) {
        (1 + 4 * self.nodes.len(), self.leaves.len(), self.entries.len())
    }
}

/// The side of a piece on which `p` lies; unspecified if its box does not hold `p`.
fn side_in_box(pieces: &PieceTable, piece: &PieceRecord, p: DVec2) -> CurveSide {
    if piece.holds(p) { pieces.side(piece, p) } else { CurveSide::Left }
}

impl PieceTable {
    /// The winding number of `p` less the leaf's base; `None` if `p` lies on a curve.
    ///
    /// The path leads right to the edge of the cell, then down to its corner. It never leaves the cell, so that other pieces
    /// contribute nothing. Points on a curve may count as being on either side, as long as each point always counts as being
    /// on the same one.
    #[inline]
    fn winding_change(&self, list: &[u32], p: DVec2, edge: f64) -> Option<i32> {
        let mut winding = 0;
        for &i in list {
            let Some(piece) = self.pieces.get(i as usize) else { continue };
            let mut side = CurveSide::Left;
            if piece.near(p, self.slack) {
                side = self.side(piece, p);
                if side == CurveSide::On {
                    return None;
                }
            }
            winding += piece.crossings_right(p, side) + self.crossings_at_edge(piece, DVec2::new(edge, p.y));
        }
        Some(winding)
    }

    fn crossings_at_edge(&self, piece: &PieceRecord, elbow: DVec2) -> i32 {
        let side = side_in_box(self, piece, elbow);
        piece.crossings_above(elbow, side) - piece.crossings_right(elbow, side)
    }

    /// [`PieceTable::winding_change`], with points on a curve counted as left of it.
    fn winding_change_from_left(&self, list: &[u32], p: DVec2, edge: f64) -> i32 {
        let pieces = list.iter().filter_map(|&i| self.pieces.get(i as usize));
        pieces
            .map(|piece| {
                piece.crossings_right(p, side_in_box(self, piece, p))
                    + self.crossings_at_edge(piece, DVec2::new(edge, p.y))
            })
            .sum()
    }

    /// Crossings above `p` of the pieces in the list.
    fn above(&self, list: &[u32], p: DVec2) -> i32 {
        let pieces = list.iter().filter_map(|&i| self.pieces.get(i as usize));
        pieces.map(|piece| piece.crossings_above(p, side_in_box(self, piece, p))).sum()
    }

    /// The winding number of `p` in a crossed cell with these entries; `None` if it lies on a curve.
    #[inline]
    pub(super) fn winding(&self, leaf: &CrossedCell, list: &[u32], p: DVec2) -> Option<i32> {
        self.winding_change(list, p, leaf.edge).map(|change| leaf.base + change)
    }
}
