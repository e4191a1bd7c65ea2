//! Building of the quadtree, level by level.

use glanz_math::DVec2;

use super::cell_tree::{CellLink, CellTree, GridSquare, MAX_INDEX, MAX_LEVEL};
use super::piece_in_cell::{CellGrid, PieceInCell, QuarteredPiece, right_or_left};
use super::piece_table::{PieceRecord, PieceTable};
use crate::bvh::parallel_map;
use crate::error::SurfaceError;

/// A cell with more pieces is quartered, within the budget.
const FEW_PIECES: usize = 3;

/// A cell wider than this fraction of its largest piece is quartered, so that crossed cells form a narrow strip.
const STRIP: f64 = 1.0 / 8.0;

/// Number of entries in all cells, per piece, at which quartering stops.
const ENTRIES_PER_PIECE: usize = 96;

/// Least number of pieces of a level whose cells are divided among tasks; smaller in tests, whose slow comparisons take few pieces.
const PIECES_TO_SHARE: usize = if cfg!(test) { 256 } else { 4096 };

/// Least number of cells of such a level.
const CELLS_TO_SHARE: usize = 64;

/// Most groups of cells into which a level is divided; larger groups are divided again.
const MOST_GROUPS: usize = 64;

/// Number of pieces in the cells of a task: its cells, quartered as far as they are, fit into the cache of a core.
const PIECES_PER_TASK: usize = 128;

// No task gets all of a level that is divided.
const _: () = assert!(PIECES_PER_TASK < PIECES_TO_SHARE && CELLS_TO_SHARE > 1);

/// A cell with pieces, which waits for being quartered or becoming a leaf.
#[derive(Clone, Copy)]
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
    /// Those of the first cell, of the second, and so on.
    pieces: Vec<PieceInCell>,
}

impl CellLevel {
    fn pieces_of(&self, cell: &PendingCell) -> &[PieceInCell] {
        self.pieces.get(cell.first..cell.first + cell.count).unwrap_or(&[])
    }

    /// Groups of consecutive cells: single ones, or several of up to `most` pieces together.
    fn groups(&self, most: usize) -> Vec<&[PendingCell]> {
        let (mut groups, mut start, mut pieces) = (Vec::new(), 0, 0);
        for (end, cell) in self.cells.iter().enumerate() {
            if end > start && pieces + cell.count > most {
                groups.push(&self.cells[start..end]);
                (start, pieces) = (end, 0);
            }
            pieces += cell.count;
        }
        groups.push(&self.cells[start..]);
        groups
    }

    /// The level of `cells`, some consecutive ones of this level, below a [`CellTree::stem`].
    fn part(&self, cells: &[PendingCell]) -> Self {
        let first = cells.first().map_or(0, |cell| cell.first);
        let of_part = |(i, cell): (usize, &PendingCell)| PendingCell {
            parent: Some((i / 4, i % 4)),
            first: cell.first - first,
            ..*cell
        };
        Self {
            cells: cells.iter().enumerate().map(of_part).collect(),
            pieces: cells.iter().flat_map(|cell| self.pieces_of(cell)).copied().collect(),
        }
    }
}

/// Input of all tasks that build a tree.
struct CellRules<'a> {
    pieces: &'a PieceTable,
    /// Those of each piece.
    levels: Vec<PieceLevels>,
}

/// The levels of cells at which a piece needs no smaller ones.
#[derive(Clone, Copy, Default)]
struct PieceLevels {
    /// Cells are no wider than the strip, or than the width of the piece.
    strip: u32,
    /// Cells are no wider than the width of the piece: quarters would have the same pieces.
    finest: u32,
}

impl PieceLevels {
    fn new(piece: &PieceRecord, min: DVec2, max: DVec2) -> Self {
        let level_of = |size: f64| {
            let is_wider = |level: &u32| 1.0 / f64::from(1_u32 << level) > size;
            (0..MAX_LEVEL).take_while(is_wider).count() as u32
        };
        let finest = level_of((piece.width / (max - min)).min_element());
        Self { strip: level_of(piece.extent(min, max) * STRIP).min(finest), finest }
    }
}

/// The levels that the pieces of a cell need together.
#[derive(Clone, Copy)]
struct CellLevels {
    /// That of the widest strip.
    coarsest: u32,
    /// That of the narrowest piece.
    finest: u32,
}

impl CellLevels {
    const NONE: Self = Self { coarsest: MAX_LEVEL, finest: 0 };

    fn add(&mut self, piece: PieceLevels) {
        self.coarsest = self.coarsest.min(piece.strip);
        self.finest = self.finest.max(piece.finest);
    }

    /// Whether a cell of `level` with `count` pieces is to be quartered.
    fn are_beyond(self, level: u32, count: usize) -> bool {
        level < MAX_LEVEL && (count > FEW_PIECES && level < self.finest || level < self.coarsest)
    }
}

/// A tree being built, or the part of one below some of its cells.
struct CellTreeBuilder<'a> {
    rules: &'a CellRules<'a>,
    tree: CellTree,
    /// Number of entries at which quartering stops.
    budget: usize,
    /// Number of entries of all cells, quartered as far as they are.
    live: usize,
    /// The pieces of the cell that is quartered.
    quartered: Vec<QuarteredPiece>,
}

impl CellTree {
    /// The tree over the domain. `outermost`: winding number far outside.
    pub(super) fn try_new(
        pieces: &PieceTable,
        [min, max]: [DVec2; 2],
        outermost: i32,
    ) -> Result<Self, SurfaceError> {
        let levels = pieces.pieces.iter().map(|piece| PieceLevels::new(piece, min, max)).collect();
        let rules = CellRules { pieces, levels };
        let budget = 1024 + ENTRIES_PER_PIECE * pieces.pieces.len();
        let mut builder = CellTreeBuilder::new(&rules, Self::new(min, max), budget);
        let root = builder.root(outermost);
        builder.build(root)?;
        builder.tree.shrink_to_fit();
        Ok(builder.tree)
    }
}

impl<'a> CellTreeBuilder<'a> {
    fn new(rules: &'a CellRules<'a>, tree: CellTree, budget: usize) -> Self {
        Self { rules, tree, budget, live: 0, quartered: Vec::new() }
    }

    /// Adds the cells of `level` and all that they are quartered into.
    fn build(&mut self, mut level: CellLevel) -> Result<(), SurfaceError> {
        self.live = level.pieces.len();
        let mut next = CellLevel::default();
        while !level.cells.is_empty() {
            if level.cells.len() >= CELLS_TO_SHARE && level.pieces.len() >= PIECES_TO_SHARE {
                return self.build_in_tasks(&level);
            }
            for cell in &level.cells {
                let pieces = level.pieces_of(cell);
                if self.live < self.budget {
                    self.live -= pieces.len();
                    self.live += self.quarter(cell, pieces, &mut next);
                } else {
                    self.push_leaf(cell, pieces.iter().map(|piece| (piece.index, piece.is_corner_right)));
                }
                check_size(self.tree.sizes())?;
            }
            std::mem::swap(&mut level, &mut next);
            next.cells.clear();
            next.pieces.clear();
        }
        Ok(())
    }

    /// [`CellTreeBuilder::build`] with tasks for groups of cells: in parallel, and each in memory that fits into a cache. Neither groups
    /// nor their shares of the budget depend on the number of threads.
    fn build_in_tasks(&mut self, level: &CellLevel) -> Result<(), SurfaceError> {
        let all = level.pieces.len();
        let left = self.budget.saturating_sub(self.live - all);
        let groups: Vec<&[PendingCell]> = level.groups(PIECES_PER_TASK.max(all / MOST_GROUPS));
        let parts = parallel_map(&groups, 1, |cells| {
            let part = level.part(cells);
            let share = left as u128 * part.pieces.len() as u128 / all as u128;
            let mut builder = Self::new(self.rules, self.tree.stem(cells.len()), share as usize);
            builder.build(part).map(|()| builder.tree)
        });
        let parts = parts.into_iter().collect::<Result<Vec<CellTree>, _>>()?;
        let add = |a: (usize, usize, usize), b: (usize, usize, usize)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
        check_size(parts.iter().map(CellTree::sizes).fold(self.tree.sizes(), add))?;
        for (cells, part) in groups.iter().zip(parts) {
            self.tree.graft(cells.iter().map(|cell| cell.parent), &part);
        }
        Ok(())
    }

    /// The level of the whole domain; without cells if the domain has no pieces.
    fn root(&mut self, outermost: i32) -> CellLevel {
        let (pieces, square) = (self.rules.pieces, GridSquare { x: 0, y: 0, level: 0 });
        let grid = self.grid(square);
        let (mut winding, mut level, mut levels) = (outermost, CellLevel::default(), CellLevels::NONE);
        let corner = DVec2::new(grid.max.x, grid.min.y);
        for (index, piece) in (0_u32..).zip(&pieces.pieces) {
            let inside = PieceInCell::new(pieces, index, &grid);
            winding += inside.crossings_right(pieces, corner);
            if pieces.touches(piece, grid.min, grid.max) {
                level.pieces.push(inside);
                levels.add(self.rules.levels(index));
            }
        }
        let count = level.pieces.len();
        let cell = PendingCell { parent: None, square, first: 0, count, winding };
        if count == 0 {
            self.tree.set(None, CellLink::uniform(winding));
        } else if levels.are_beyond(0, count) {
            level.cells.push(cell);
        } else {
            self.push_leaf(&cell, level.pieces.iter().map(|piece| (piece.index, piece.is_corner_right)));
        }
        level
    }

    /// Three lines of the grid each way: those of a cell and its middle.
    fn grid(&self, square: GridSquare) -> CellGrid {
        let (min, middle) = self.tree.bounds(square.quarter(0));
        let (_, max) = self.tree.bounds(square.quarter(3));
        CellGrid { min, middle, max }
    }

    /// Adds a leaf with these pieces; of each the number, and whether the cell's lower right corner is right of it.
    fn push_leaf(&mut self, cell: &PendingCell, pieces: impl Iterator<Item = (u32, bool)> + Clone) {
        let (min, max) = self.tree.bounds(cell.square);
        let corner = DVec2::new(max.x, min.y);
        let above = |(index, is_right)| {
            self.rules.pieces.pieces[index as usize].crossings_above(corner, right_or_left(is_right))
        };
        let base = cell.winding - pieces.clone().map(above).sum::<i32>();
        self.tree.push_leaf(cell.parent, base, corner.x, pieces.map(|(index, _)| index));
    }

    /// Adds a node for `cell`, and those of its quarters that are leaves; quarters to be quartered wait in `next`. Returns the
    /// number of pieces in all quarters.
    fn quarter(&mut self, cell: &PendingCell, pieces: &[PieceInCell], next: &mut CellLevel) -> usize {
        let (rules, grid) = (self.rules, self.grid(cell.square));
        let mut quartered = std::mem::take(&mut self.quartered);
        let (mut windings, mut counts, mut levels) = ([cell.winding; 4], [0; 4], [CellLevels::NONE; 4]);
        for piece in pieces {
            let record = &rules.pieces.pieces[piece.index as usize];
            let parts = piece.quartered(rules.pieces, &grid);
            let (changes, of_piece) = (parts.winding_changes(record, &grid), rules.levels(piece.index));
            for quarter in 0..4 {
                windings[quarter] += changes[quarter];
                if parts.touches(quarter) {
                    counts[quarter] += 1;
                    levels[quarter].add(of_piece);
                }
            }
            quartered.push(parts);
        }
        let node = self.tree.push_node(cell.parent, windings.map(CellLink::uniform));
        for quarter in 0..4 {
            let (count, winding) = (counts[quarter], windings[quarter]);
            if count == 0 {
                continue;
            }
            let (square, parent) = (cell.square.quarter(quarter as u32), Some((node, quarter)));
            let cell = PendingCell { parent, square, first: next.pieces.len(), count, winding };
            let both = pieces.iter().zip(&quartered);
            let touching = both.filter(|(_, parts)| parts.touches(quarter));
            if levels[quarter].are_beyond(square.level, count) {
                next.pieces.reserve(count);
                touching.for_each(|(piece, parts)| next.pieces.push(parts.in_quarter(piece, quarter)));
                next.cells.push(cell);
            } else {
                self.push_leaf(&cell, touching.map(|(piece, parts)| (piece.index, parts.is_right(quarter))));
            }
        }
        quartered.clear();
        self.quartered = quartered;
        counts.iter().sum()
    }
}

impl CellRules<'_> {
    fn levels(&self, piece: u32) -> PieceLevels {
        self.levels.get(piece as usize).copied().unwrap_or_default()
    }
}

/// Numbers of cells, of leaves and of their entries must be indices.
fn check_size((cells, leaves, entries): (usize, usize, usize)) -> Result<(), SurfaceError> {
    for (parameter, count) in [("cells", (cells / 4).max(leaves)), ("entries of cells", entries)] {
        if count >= MAX_INDEX {
            return Err(SurfaceError::TooMany { parameter, count, max: MAX_INDEX });
        }
    }
    Ok(())
}
