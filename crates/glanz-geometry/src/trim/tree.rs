//! The hierarchy over the domain: which cells a curve crosses, and what the others are.

use std::collections::VecDeque;

use glanz_math::DVec2;

use super::pieces::{Piece, Pieces, Side};
use crate::error::SurfaceError;

/// Halvings of the domain's sides at most.
const MAX_LEVEL: u32 = 20;

/// A cell with more pieces than these is quartered, as long as the budget lasts.
const FEW_PIECES: usize = 3;

/// A cell wider than this share of its largest piece is quartered: what is crossed is then a narrow strip.
const STRIP: f64 = 1.0 / 8.0;

/// Entries of all cells together, per piece, at which quartering stops.
const ENTRIES_PER_PIECE: usize = 96;

/// A cell: the index of four quarters or of a leaf, with a tag, or its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Link(u32);

const TAG_BITS: u32 = 30;
const TAG_NODE: u32 = 0;
const TAG_LEAF: u32 = 1;
const TAG_OUTSIDE: u32 = 2;
const TAG_INSIDE: u32 = 3;
const MAX_INDEX: usize = (1 << TAG_BITS) - 1;

/// What a point's cell says about it.
pub(super) enum Found<'a> {
    Uniform(bool),
    Crossed(&'a Leaf),
}

/// A cell that curves cross or come near.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    first: u32,
    count: u32,
    /// Winding number of the cell's lower right corner, less what its pieces contribute above that.
    base: i32,
    /// Right side of the cell.
    edge: f64,
}

/// A square of a grid with 2^level cells each way.
#[derive(Clone, Copy, Debug)]
struct Square {
    x: u32,
    y: u32,
    level: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Tree {
    root: Link,
    nodes: Vec<[Link; 4]>,
    leaves: Vec<Leaf>,
    entries: Vec<u32>,
    min: DVec2,
    max: DVec2,
    /// Size of the smallest cell, and its inverse.
    unit: DVec2,
    per_unit: DVec2,
}

/// A cell to be decided on.
struct Pending {
    /// Node and quarter that will refer to it.
    parent: Option<(usize, usize)>,
    square: Square,
    pieces: Vec<u32>,
    /// Winding number of its lower right corner.
    winding: i32,
}

impl Tree {
    /// `outermost`: winding number far outside. Pieces within `margin` of a cell belong to it.
    pub(super) fn try_new(
        pieces: &Pieces,
        [min, max]: [DVec2; 2],
        outermost: i32,
        margin: DVec2,
    ) -> Result<Self, SurfaceError> {
        let steps = f64::from(1_u32 << MAX_LEVEL);
        let unit = (max - min) / steps;
        let mut tree = Self {
            root: Link(0),
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
                .map(|piece| piece.crossings_right(corner, asked(pieces, piece, corner)))
                .sum::<i32>();
        let root =
            Pending { parent: None, square: Square { x: 0, y: 0, level: 0 }, pieces: all.collect(), winding };
        let budget = 1024 + ENTRIES_PER_PIECE * count;
        let mut live = root.pieces.len();
        let mut queue = VecDeque::from([root]);
        while let Some(cell) = queue.pop_front() {
            let link = if cell.pieces.is_empty() {
                Link((if cell.winding > 0 { TAG_INSIDE } else { TAG_OUTSIDE }) << TAG_BITS)
            } else if live < budget && tree.is_coarse(pieces, &cell) {
                let quarters = tree.quarters(pieces, &cell, margin);
                live = live - cell.pieces.len() + quarters.iter().map(|q| q.pieces.len()).sum::<usize>();
                queue.extend(quarters);
                tree.nodes.push([Link(0); 4]);
                Link((TAG_NODE << TAG_BITS) | (tree.nodes.len() - 1) as u32)
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

    fn is_coarse(&self, pieces: &Pieces, cell: &Pending) -> bool {
        if cell.square.level >= MAX_LEVEL {
            return false;
        }
        let size = self.max - self.min;
        let largest = cell.pieces.iter().fold(0.0_f64, |a, &i| a.max(pieces.pieces[i as usize].extent(size)));
        let width = 1.0 / f64::from(1_u32 << cell.square.level);
        cell.pieces.len() > FEW_PIECES || width > largest * STRIP
    }

    fn quarters(&self, pieces: &Pieces, cell: &Pending, margin: DVec2) -> [Pending; 4] {
        let Square { x, y, level } = cell.square;
        let node = self.nodes.len();
        let (_, max) = self.bounds(cell.square);
        let base = cell.winding - pieces.above(&cell.pieces, self.corner(cell.square));
        std::array::from_fn(|quarter| {
            let square = Square {
                x: 2 * x + (quarter as u32 & 1),
                y: 2 * y + (quarter as u32 >> 1),
                level: level + 1,
            };
            let (low, high) = self.bounds(square);
            let touching = |i: &u32| pieces.touches(&pieces.pieces[*i as usize], low, high, margin);
            Pending {
                parent: Some((node, quarter)),
                square,
                pieces: cell.pieces.iter().copied().filter(touching).collect(),
                winding: base + pieces.change(&cell.pieces, self.corner(square), max.x),
            }
        })
    }

    fn leaf(&mut self, pieces: &Pieces, cell: &Pending) -> Link {
        let corner = self.corner(cell.square);
        self.leaves.push(Leaf {
            first: self.entries.len() as u32,
            count: cell.pieces.len() as u32,
            base: cell.winding - pieces.above(&cell.pieces, corner),
            edge: corner.x,
        });
        self.entries.extend(&cell.pieces);
        Link((TAG_LEAF << TAG_BITS) | (self.leaves.len() - 1) as u32)
    }

    /// Corners of a cell; neighbours agree on theirs to the bit.
    fn bounds(&self, square: Square) -> (DVec2, DVec2) {
        let shift = MAX_LEVEL - square.level;
        let at =
            |x: u32, y: u32| self.min + DVec2::new(f64::from(x << shift), f64::from(y << shift)) * self.unit;
        (at(square.x, square.y), at(square.x + 1, square.y + 1))
    }

    fn corner(&self, square: Square) -> DVec2 {
        let (low, high) = self.bounds(square);
        DVec2::new(high.x, low.y)
    }

    /// The smallest cell that a point of the domain lies in, or, for rounding, next to.
    #[inline]
    fn grid(&self, p: DVec2) -> (u32, u32) {
        let last = (1_u32 << MAX_LEVEL) - 1;
        let at = (p - self.min) * self.per_unit;
        ((at.x as u32).min(last), (at.y as u32).min(last))
    }

    /// What the cell of `p`, a point of the domain, says.
    #[inline]
    pub(super) fn find(&self, p: DVec2) -> Found<'_> {
        let (x, y) = self.grid(p);
        let (mut link, mut shift) = (self.root.0, MAX_LEVEL);
        while link >> TAG_BITS == TAG_NODE {
            let Some(node) = self.nodes.get(link as usize) else { break };
            shift = shift.saturating_sub(1);
            let quarter = ((x >> shift) & 1) | (((y >> shift) & 1) << 1);
            link = node[quarter as usize & 3].0;
        }
        match (link >> TAG_BITS, self.leaves.get(link as usize & MAX_INDEX)) {
            (TAG_LEAF, Some(leaf)) => Found::Crossed(leaf),
            (tag, _) => Found::Uniform(tag == TAG_INSIDE),
        }
    }

    /// The pieces of a leaf.
    #[inline]
    pub(super) fn entries(&self, leaf: &Leaf) -> &[u32] {
        let first = leaf.first as usize;
        self.entries.get(first..first + leaf.count as usize).unwrap_or(&[])
    }

    /// Whether `meets` holds for a piece of a cell that overlaps the rectangle.
    pub(super) fn any_piece(&self, min: DVec2, max: DVec2, meets: impl Fn(u32) -> bool) -> bool {
        let ((x0, y0), (x1, y1)) = (self.grid(min), self.grid(max));
        let mut stack = vec![(self.root.0, Square { x: 0, y: 0, level: 0 })];
        while let Some((link, Square { x, y, level })) = stack.pop() {
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
                        (link.0, Square { x: 2 * x + right, y: 2 * y + up, level: level + 1 })
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

    /// Cells in all, crossed cells, and their entries.
    pub(super) fn sizes(&self) -> (usize, usize, usize) {
        (1 + 4 * self.nodes.len(), self.leaves.len(), self.entries.len())
    }
}

/// The side of a piece for a point that it holds; anything for others.
fn asked(pieces: &Pieces, piece: &Piece, p: DVec2) -> Side {
    if piece.holds(p) { pieces.side(piece, p) } else { Side::Left }
}

impl Pieces {
    /// The winding number of `p` less the leaf's base; `None` if `p` lies on a curve.
    ///
    /// The way leads right to the edge of the cell, then down to its corner. It never leaves the cell, so that other
    /// pieces contribute nothing, and points on a curve may be put on either side of it as long as the same point is
    /// always put on the same one.
    #[inline]
    fn off_curves(&self, list: &[u32], p: DVec2, edge: f64) -> Option<i32> {
        let mut winding = 0;
        for &i in list {
            let Some(piece) = self.pieces.get(i as usize) else { continue };
            let mut side = Side::Left;
            if piece.near(p, self.slack) {
                side = self.side(piece, p);
                if side == Side::On {
                    return None;
                }
            }
            winding += piece.crossings_right(p, side) + self.past_edge(piece, DVec2::new(edge, p.y));
        }
        Some(winding)
    }

    fn past_edge(&self, piece: &Piece, elbow: DVec2) -> i32 {
        let side = asked(self, piece, elbow);
        piece.crossings_above(elbow, side) - piece.crossings_right(elbow, side)
    }

    /// [`Pieces::off_curves`] with points on a curve put to its left.
    fn change(&self, list: &[u32], p: DVec2, edge: f64) -> i32 {
        let pieces = list.iter().filter_map(|&i| self.pieces.get(i as usize));
        pieces
            .map(|piece| {
                piece.crossings_right(p, asked(self, piece, p)) + self.past_edge(piece, DVec2::new(edge, p.y))
            })
            .sum()
    }

    /// Crossings above `p` of the pieces in the list.
    fn above(&self, list: &[u32], p: DVec2) -> i32 {
        let pieces = list.iter().filter_map(|&i| self.pieces.get(i as usize));
        pieces.map(|piece| piece.crossings_above(p, asked(self, piece, p))).sum()
    }

    /// The winding number of `p` in a crossed cell with these entries; `None` if it lies on a curve.
    #[inline]
    pub(super) fn winding(&self, leaf: &Leaf, list: &[u32], p: DVec2) -> Option<i32> {
        self.off_curves(list, p, leaf.edge).map(|change| leaf.base + change)
    }
}
