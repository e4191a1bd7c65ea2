//! Numbers over the cells of a rectangle.

/// Numbers over the cells of a rectangle. Adjacent cells can be joined if there are too many of them to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct CellField {
    /// Borders between the columns and the rows, counted in the original cells, from 0.
    edges: [Vec<u32>; 2],
    /// Lengths in metres.
    size: [f64; 2],
    /// Row by row: the number and the area of its cell, 0 if the cell shows nothing.
    values: Vec<(f64, f64)>,
}

impl CellField {
    /// A field of `cells` columns and rows over a rectangle of `size` metres.
    ///
    /// `areas` and `numbers`, row by row, are the areas of the cells and the numbers to show. Cells without area show
    /// nothing, nor do numbers that are not finite; lists that are too short leave rows out.
    #[must_use]
    pub fn new(cells: [u32; 2], size: [f64; 2], areas: &[f64], numbers: &[f64]) -> Self {
        let pairs: Vec<(f64, f64)> = numbers.iter().copied().zip(areas.iter().copied()).collect();
        let columns = cells[0].min(u32::try_from(pairs.len()).unwrap_or(u32::MAX));
        let rows = (pairs.len() as u64).checked_div(u64::from(columns)).unwrap_or(0);
        let rows = cells[1].min(u32::try_from(rows).unwrap_or(u32::MAX));
        let shown = |&(number, area): &(f64, f64)| {
            let is_shown = f64::is_finite(number) && area > 0.0 && f64::is_finite(area);
            if is_shown { (number, area) } else { (0.0, 0.0) }
        };
        let values = pairs.iter().take(columns as usize * rows as usize).map(shown).collect();
        let size = size.map(|s| if s.is_finite() && s > 0.0 { s } else { 1.0 });
        Self { edges: [(0..=columns).collect(), (0..=rows).collect()], size, values }
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.edges[0].len() - 1
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.edges[1].len() - 1
    }

    /// Lengths in metres; lengths that were not positive and finite are 1.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Borders between columns or rows, in original cells.
    pub(crate) fn edges(&self, axis: usize) -> &[u32] {
        &self.edges[axis]
    }

    /// The number of a cell; `None` if it shows nothing.
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> Option<f64> {
        let (number, area) = self.values.get(row * self.columns() + column)?;
        (*area > 0.0).then_some(*number)
    }

    /// The numbers that are shown, each with the area of its cell.
    pub fn shown(&self) -> impl Iterator<Item = (f64, f64)> {
        self.values.iter().copied().filter(|(_, area)| *area > 0.0)
    }

    /// The field with two by two cells joined: means over their areas.
    pub(crate) fn halved(&self) -> Self {
        let borders = |count: usize| (0..count).step_by(2).chain([count]).collect();
        self.joined([borders(self.columns()), borders(self.rows())])
    }

    /// The field with cells joined to at most `most` columns and rows: means over their areas. All have equally many cells if at least half as many columns, or
    /// rows, as allowed can have; otherwise they differ by one.
    #[must_use]
    pub(crate) fn blocks(&self, most: [usize; 2]) -> Self {
        let borders = |count: usize, most: usize| {
            if count == 0 {
                return vec![0];
            }
            let most = most.clamp(1, count);
            let even = (most.div_ceil(2)..=most).rev().find(|blocks| count.is_multiple_of(*blocks));
            let blocks = even.unwrap_or(most);
            (0..=blocks).map(|number| number * count / blocks).collect()
        };
        self.joined([borders(self.columns(), most[0]), borders(self.rows(), most[1])])
    }

    /// The field with the cells between some of its borders joined; `borders`: their numbers, ascending, from the first to the last.
    fn joined(&self, borders: [Vec<usize>; 2]) -> Self {
        let edges = [0, 1].map(|axis: usize| {
            borders[axis].iter().filter_map(|border| self.edges[axis].get(*border).copied()).collect()
        });
        let mean = |columns: &[usize], rows: &[usize]| {
            let (mut sum, mut all) = (0.0, 0.0);
            let [&[left, right], &[bottom, top]] = [columns, rows] else { return (0.0, 0.0) };
            for (x, y) in (bottom..top).flat_map(|y| (left..right).map(move |x| (x, y))) {
                let (value, area) = self.values.get(y * self.columns() + x).copied().unwrap_or_default();
                (sum, all) = (sum + value * area, all + area);
            }
            if all > 0.0 { (sum / all, all) } else { (0.0, 0.0) }
        };
        let [across, up] = &borders;
        let values = up.windows(2).flat_map(|rows| across.windows(2).map(move |columns| mean(columns, rows)));
        Self { values: values.collect(), edges, size: self.size }
    }

    /// The field with each cell divided into equal ones until its longer direction has at least `least`, with values that are linear between the centres of the cells, in both
    /// directions; beyond the outermost centres, and beside cells that show nothing, they are those of the nearest cell.
    #[must_use]
    pub fn refined(&self, least: usize) -> Self {
        let longer = self.columns().max(self.rows());
        let factor = least.div_ceil(longer.max(1)).max(1);
        if factor == 1 {
            return self.clone();
        }
        // The two cells whose centres are around the centre of a part, and the share of the second.
        let around = |part: usize, count: usize| {
            let at = (part as f64 + 0.5) / factor as f64 - 0.5;
            let low = at.floor().clamp(0.0, count.saturating_sub(1) as f64);
            let next = (low as usize + 1).min(count.saturating_sub(1));
            (low as usize, next, (at - low).clamp(0.0, 1.0))
        };
        let parts = (factor * factor) as f64;
        let value = |column: usize, row: usize| {
            let own = self.values.get(row / factor * self.columns() + column / factor);
            let Some(&(number, area)) = own.filter(|(_, area)| *area > 0.0) else { return (0.0, 0.0) };
            let (x0, x1, u) = around(column, self.columns());
            let (y0, y1, v) = around(row, self.rows());
            let at = |x: usize, y: usize| self.at(x, y).unwrap_or(number);
            let along = |y: usize| at(x0, y) * (1.0 - u) + at(x1, y) * u;
            (along(y0) * (1.0 - v) + along(y1) * v, area / parts)
        };
        let (columns, rows) = (self.columns() * factor, self.rows() * factor);
        let values = (0..rows).flat_map(|row| (0..columns).map(move |column| value(column, row))).collect();
        let edges = [0, 1].map(|axis: usize| {
            let divided = self.edges[axis].windows(2).flat_map(|pair| {
                let (from, to) = (pair[0] as usize * factor, pair[1] as usize * factor);
                let count = factor;
                (0..count).map(move |part| (from + part * (to - from) / count) as u32)
            });
            let last = self.edges[axis].last().map(|edge| edge * factor as u32);
            divided.chain(last).collect()
        });
        Self { edges, size: self.size, values }
    }

    /// Centres of the columns or rows in [0, 1], between the borders of the rectangle, 0 and 1.
    pub(crate) fn centres(&self, axis: usize) -> Vec<f64> {
        let edges = &self.edges[axis];
        let all = f64::from(edges.last().copied().unwrap_or(0).max(1));
        let centres = edges.windows(2).map(|pair| (f64::from(pair[0]) + f64::from(pair[1])) / (2.0 * all));
        std::iter::once(0.0).chain(centres).chain([1.0]).collect()
    }

    /// The numbers at all pairs of [`CellField::centres`]; on the borders those of the nearest cells.
    pub(crate) fn to_borders(&self) -> Vec<Option<f64>> {
        let near = |index: usize, count: usize| index.saturating_sub(1).min(count.saturating_sub(1));
        let (columns, rows) = (self.columns(), self.rows());
        (0..rows + 2)
            .flat_map(|y| (0..columns + 2).map(move |x| self.at(near(x, columns), near(y, rows))))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn joined_cells_are_means_over_the_area() {
        // 1 2 9 and above it 3 4 - ; the last column stands alone.
        let field = CellField::new([3, 2], [3.0, 1.0], &[1., 1., 2., 1., 3., 0.], &[1., 2., 9., 3., 4., 7.]);
        assert_eq!((field.at(2, 0), field.at(2, 1)), (Some(9.0), None));
        let half = field.halved();
        // (1 + 2 + 3 + 3 * 4) / 6.
        assert_eq!((half.columns(), half.rows(), half.at(0, 0), half.at(1, 0)), (2, 1, Some(3.0), Some(9.0)));
        assert_eq!(half.edges(0), [0, 2, 3]);
        assert_eq!(half.centres(0), [0.0, 1.0 / 3.0, 5.0 / 6.0, 1.0]);
        let row = [Some(3.0), Some(3.0), Some(9.0), Some(9.0)];
        assert_eq!(half.to_borders(), [row, row, row].concat());
    }

    #[test]
    fn blocks_leave_at_most_so_many_columns_and_rows() {
        let numbers: Vec<f64> = (0..48).map(f64::from).collect();
        let field = CellField::new([8, 6], [8.0, 6.0], &[1.0; 48], &numbers);
        let blocks = field.blocks([5, 6]);
        // Four columns of two cells; every row stays.
        assert_eq!((blocks.edges(0), blocks.rows()), (&[0, 2, 4, 6, 8][..], 6));
        assert_eq!((blocks.at(0, 0), blocks.at(3, 5)), (Some(0.5), Some(46.5)));
        // Seven columns cannot be equal in two or three.
        assert_eq!(
            CellField::new([7, 1], [7.0, 1.0], &[1.0; 7], &[1.0; 7]).blocks([3, 1]).edges(0),
            [0, 2, 4, 7]
        );
        assert_eq!((field.blocks([9, 9]), field.blocks([0, 0]).at(0, 0)), (field.clone(), Some(23.5)));
    }

    #[test]
    fn refined_fields_are_linear_between_centres() {
        let field = CellField::new([2, 2], [4.0, 2.0], &[2.0; 4], &[0.0, 8.0, 4.0, 12.0]);
        let fine = field.refined(8);
        assert_eq!((fine.columns(), fine.rows(), fine.edges(0)), (8, 8, &[0, 1, 2, 3, 4, 5, 6, 7, 8][..]));
        // f = 4 x / 1 m + 4 y / 1 m from the first centre at (1, 0.5) m: parts of 0.5 m x 0.25 m, of which the third's centre is at (1.25, 0.625) m.
        let expected = |x: f64, y: f64| 4.0 * (x - 1.0).clamp(0.0, 2.0) + 4.0 * (y - 0.5).clamp(0.0, 1.0);
        for (row, column) in (0..8).flat_map(|row| (0..8).map(move |column| (row, column))) {
            let (x, y) = (0.5 * column as f64 + 0.25, 0.25 * row as f64 + 0.125);
            assert!((fine.at(column, row).unwrap() - expected(x, y)).abs() < 1e-12, "{column} {row}");
        }
        let area: f64 = fine.shown().map(|(_, area)| area).sum();
        assert!((area - 8.0).abs() < 1e-12);
        // Beside a hole the values stay those of the cell.
        let holed = CellField::new([2, 1], [2.0, 1.0], &[1.0, 0.0], &[3.0, 9.0]).refined(4);
        assert_eq!([0, 1, 2, 3].map(|column| holed.at(column, 0)), [Some(3.0), Some(3.0), None, None]);
        assert_eq!(CellField::new([0, 0], [1.0; 2], &[], &[]).refined(8).columns(), 0);
    }

    #[test]
    fn lists_that_are_too_short_leave_rows_out() {
        let cut = CellField::new([2, u32::MAX], [3.0, 1.0], &[1.0; 3], &[1.0, f64::NAN, 3.0]);
        assert_eq!((cut.columns(), cut.rows(), cut.at(0, 0), cut.at(1, 0)), (2, 1, Some(1.0), None));
        let none = CellField::new([0, 5], [3.0, 1.0], &[], &[]);
        assert_eq!((none.columns(), none.rows(), none.halved().rows(), none.at(0, 0)), (0, 0, 0, None));
    }
}
