//! The quadtree over the domain: cells that curves cross, and cells inside or outside as a whole.

use glanz_math::DVec2;

use super::piece_table::{CurveSide, PieceRecord, PieceTable};
use super::region::RegionLocation;

/// Largest depth of the tree.
pub(super) const MAX_LEVEL: u32 = 20;

/// A reference to a cell: a tag, and the index of its four quarters or of its leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellLink(u32);

const TAG_BITS: u32 = 30;
const TAG_NODE: u32 = 0;
const TAG_LEAF: u32 = 1;
const TAG_OUTSIDE: u32 = 2;
const TAG_INSIDE: u32 = 3;
pub(super) const MAX_INDEX: usize = (1 << TAG_BITS) - 1;

impl CellLink {
    /// The link to a cell without curves, all of which has the winding number `winding`.
    pub(super) fn uniform(winding: i32) -> Self {
        Self((if winding > 0 { TAG_INSIDE } else { TAG_OUTSIDE }) << TAG_BITS)
    }
}

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
pub(super) struct GridSquare {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) level: u32,
}

impl GridSquare {
    /// The quarter with this number: bit 0 right, bit 1 upper.
    pub(super) fn quarter(self, quarter: u32) -> Self {
        Self { x: 2 * self.x + (quarter & 1), y: 2 * self.y + (quarter >> 1), level: self.level + 1 }
    }
}

/// A quadtree over the domain of a region.
#[derive(Clone, Debug)]
pub(super) struct CellTree {
    root: CellLink,
    nodes: Vec<[CellLink; 4]>,
    leaves: Vec<CrossedCell>,
    entries: Vec<u32>,
    min: DVec2,
    /// Size of the smallest cell, and its inverse.
    unit: DVec2,
    per_unit: DVec2,
}

impl CellTree {
    /// A tree without cells over the domain from `min` to `max`.
    pub(super) fn new(min: DVec2, max: DVec2) -> Self {
        let unit = (max - min) / f64::from(1_u32 << MAX_LEVEL);
        Self {
            root: CellLink::uniform(0),
            nodes: Vec::new(),
            leaves: Vec::new(),
            entries: Vec::new(),
            min,
            unit,
            per_unit: unit.recip(),
        }
    }

    /// Releases memory that is held for more cells.
    pub(super) fn shrink_to_fit(&mut self) {
        self.nodes.shrink_to_fit();
        self.leaves.shrink_to_fit();
        self.entries.shrink_to_fit();
    }

    /// A tree over the same domain whose first nodes have `count` quarters for the links to cells of this one.
    pub(super) fn stem(&self, count: usize) -> Self {
        let nodes = vec![[CellLink::uniform(0); 4]; count.div_ceil(4)];
        Self { nodes, leaves: Vec::new(), entries: Vec::new(), ..*self }
    }

    /// Adds the cells of `part`, a tree made by [`CellTree::stem`], as the quarters `parents` of nodes.
    pub(super) fn graft(
        &mut self,
        parents: impl ExactSizeIterator<Item = Option<(usize, usize)>>,
        part: &Self,
    ) {
        let (stem, nodes) = part.nodes.split_at(parents.len().div_ceil(4));
        let (node, leaf) = (self.nodes.len(), self.leaves.len());
        let moved = |link: CellLink| match link.0 >> TAG_BITS {
            TAG_NODE => CellLink(link.0 + node as u32 - stem.len() as u32),
            TAG_LEAF => CellLink(link.0 + leaf as u32),
            _ => link,
        };
        for (parent, &link) in parents.zip(stem.as_flattened()) {
            self.set(parent, moved(link));
        }
        self.nodes.extend(nodes.iter().map(|quarters| quarters.map(moved)));
        let entry = self.entries.len() as u32;
        let moved = |&leaf: &CrossedCell| CrossedCell { first: leaf.first + entry, ..leaf };
        self.leaves.extend(part.leaves.iter().map(moved));
        self.entries.extend_from_slice(&part.entries);
    }

    /// Sets the link of a quarter of a node, or the root's if there is no parent.
    pub(super) fn set(&mut self, parent: Option<(usize, usize)>, link: CellLink) {
        match parent {
            Some((node, quarter)) => self.nodes[node][quarter] = link,
            None => self.root = link,
        }
    }

    /// Adds a node; returns its number.
    pub(super) fn push_node(&mut self, parent: Option<(usize, usize)>, quarters: [CellLink; 4]) -> usize {
        let node = self.nodes.len();
        self.nodes.push(quarters);
        self.set(parent, CellLink((TAG_NODE << TAG_BITS) | node as u32));
        node
    }

    /// Adds a crossed cell with these pieces.
    pub(super) fn push_leaf(
        &mut self,
        parent: Option<(usize, usize)>,
        base: i32,
        edge: f64,
        pieces: impl Iterator<Item = u32>,
    ) {
        let (leaf, first) = (self.leaves.len() as u32, self.entries.len() as u32);
        pieces.for_each(|piece| self.entries.push(piece));
        let count = self.entries.len() as u32 - first;
        self.leaves.push(CrossedCell { first, count, base, edge });
        self.set(parent, CellLink((TAG_LEAF << TAG_BITS) | leaf));
    }

    /// Corners of a cell; neighbours agree on theirs to the bit.
    pub(super) fn bounds(&self, square: GridSquare) -> (DVec2, DVec2) {
        let shift = MAX_LEVEL - square.level;
        let at =
            |x: u32, y: u32| self.min + DVec2::new(f64::from(x << shift), f64::from(y << shift)) * self.unit;
        (at(square.x, square.y), at(square.x + 1, square.y + 1))
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
                    let square = GridSquare { x, y, level };
                    stack.extend(node.zip(0..).map(|(link, quarter)| (link.0, square.quarter(quarter))));
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
    /// The location of `p`, a point of the crossed cell `leaf` with these entries.
    ///
    /// The path leads right to the edge of the cell, then down to its corner. It never leaves the cell, so that other pieces
    /// contribute nothing. Points on a curve may count as being on either side, as long as each point always counts as being
    /// on the same one.
    #[inline]
    pub(super) fn locate(&self, leaf: &CrossedCell, list: &[u32], p: DVec2) -> RegionLocation {
        let (mut winding, mut in_border) = (leaf.base, false);
        for &i in list {
            let Some(piece) = self.pieces.get(i as usize) else { continue };
            let mut side = CurveSide::Left;
            let clearance = self.slack + piece.width;
            if piece.near(p, clearance) {
                side = self.side_with_clearance(piece, p, clearance);
                if side == CurveSide::On {
                    let is_near;
                    (side, is_near) = self.side_near(piece, p);
                    if side == CurveSide::On {
                        return RegionLocation::InnerBorder;
                    }
                    in_border |= is_near;
                }
            }
            let elbow = DVec2::new(leaf.edge, p.y);
            winding += piece.crossings_right(p, side) + self.crossings_at_edge(piece, elbow);
        }
        match (winding > 0, in_border) {
            (true, false) => RegionLocation::Inside,
            (true, true) => RegionLocation::InnerBorder,
            (false, true) => RegionLocation::OuterBorder,
            (false, false) => RegionLocation::Outside,
        }
    }

    fn crossings_at_edge(&self, piece: &PieceRecord, elbow: DVec2) -> i32 {
        let side = side_in_box(self, piece, elbow);
        piece.crossings_above(elbow, side) - piece.crossings_right(elbow, side)
    }
}
