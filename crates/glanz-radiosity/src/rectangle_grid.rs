//! Lookup of rectangles of a plane by point.

use glanz_math::DVec2;

/// Largest mean number of cells that a rectangle overlaps if the grid has few cells for their number.
const MAX_OVERLAPS: usize = 16;

/// A grid of cells over a rectangle of the plane, with the numbers of the indexed rectangles that overlap each cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RectangleGrid {
    /// Upper right corner of the grid; its lower left corner is the origin.
    size: DVec2,
    /// Cells along each axis.
    columns: usize,
    /// Index in `numbers` of the first entry of each cell, and the number of all.
    first: Vec<u32>,
    /// Numbers of rectangles, cell by cell, ascending within each.
    numbers: Vec<u32>,
}

impl RectangleGrid {
    /// Indexes rectangles, given by their lower left and upper right corners, in `columns` x `columns` cells.
    ///
    /// Rectangles beyond the grid belong to its outermost cells.
    pub(crate) fn new(size: DVec2, columns: usize, rectangles: &[[DVec2; 2]]) -> Self {
        let mut grid = Self { size, columns, first: vec![0; columns * columns + 1], numbers: Vec::new() };
        for rectangle in rectangles {
            grid.cells(rectangle).for_each(|cell| grid.first[cell + 1] += 1);
        }
        let mut count = 0;
        for first in &mut grid.first {
            count += *first;
            *first = count;
        }
        let mut next = grid.first.clone();
        let mut numbers = vec![0; count as usize];
        for (number, rectangle) in (0..).zip(rectangles) {
            for cell in grid.cells(rectangle) {
                numbers[next[cell] as usize] = number;
                next[cell] += 1;
            }
        }
        Self { numbers, ..grid }
    }

    /// As [`RectangleGrid::new`], with `columns` halved until rectangles overlap few cells: long slanted ones, whose bounds overlap most
    /// cells, would otherwise take memory in proportion to the square of their number.
    pub(crate) fn with_linear_memory(size: DVec2, mut columns: usize, rectangles: &[[DVec2; 2]]) -> Self {
        loop {
            let grid = Self { size, columns, ..Self::default() };
            let overlaps = |rectangle: &[DVec2; 2]| {
                let [x, y] = grid.ranges(rectangle);
                x.count() * y.count()
            };
            let entries: usize = rectangles.iter().map(overlaps).sum();
            if columns == 1 || entries <= MAX_OVERLAPS * rectangles.len() + columns * columns {
                return Self::new(size, columns, rectangles);
            }
            columns /= 2;
        }
    }

    /// Numbers of the rectangles that overlap the cell of a point, or the cell nearest to a point beyond the grid, ascending.
    pub(crate) fn near(&self, point: DVec2) -> &[u32] {
        let [x, y] = self.cell(point);
        self.of_cell(y * self.columns + x)
    }

    /// Numbers of the rectangles that overlap a cell that `rectangle` overlaps, repeated for each such cell.
    pub(crate) fn overlapping(&self, rectangle: &[DVec2; 2]) -> impl Iterator<Item = u32> {
        self.cells(rectangle).flat_map(|cell| self.of_cell(cell)).copied()
    }

    /// The lists of all cells.
    pub(crate) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.columns * self.columns).map(|cell| self.of_cell(cell))
    }

    fn of_cell(&self, cell: usize) -> &[u32] {
        match self.first.get(cell..cell + 2) {
            Some(&[from, to]) => self.numbers.get(from as usize..to as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Column and row of a point.
    fn cell(&self, point: DVec2) -> [usize; 2] {
        // The cast maps negative numbers and those that are not numbers to 0.
        let share = point / self.size * self.columns as f64;
        share.to_array().map(|x| (x as usize).min(self.columns.saturating_sub(1)))
    }

    /// Columns and rows that a rectangle overlaps.
    fn ranges(&self, [low, high]: &[DVec2; 2]) -> [std::ops::RangeInclusive<usize>; 2] {
        let ([a, b], [c, d]) = (self.cell(*low), self.cell(*high));
        [a..=c, b..=d]
    }

    fn cells(&self, rectangle: &[DVec2; 2]) -> impl Iterator<Item = usize> + use<> {
        let ([x, y], columns) = (self.ranges(rectangle), self.columns);
        y.flat_map(move |y| x.clone().map(move |x| y * columns + x))
    }
}

/// Triangles between one corner of the unit square and its opposite sides, for tests: the bounds of most overlap many cells.
#[cfg(test)]
pub(crate) fn slender_triangles(count: u32) -> Vec<[DVec2; 3]> {
    let on_sides = |i: u32| {
        let share = f64::from(i) / f64::from(count) * 2.0;
        if share < 1.0 { DVec2::new(1.0, share) } else { DVec2::new(2.0 - share, 1.0) }
    };
    (0..count).map(|i| [DVec2::ZERO, on_sides(i), on_sides(i + 1)]).collect()
}
