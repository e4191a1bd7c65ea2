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
        self.joined([2; 2])
    }

    /// The field with as many equal numbers of cells joined, along each direction, as it takes to leave at most `most` columns and rows: means over their areas.
    #[must_use]
    pub fn blocks(&self, most: [usize; 2]) -> Self {
        let [columns, rows] = most.map(|count| count.max(1));
        self.joined([self.columns().div_ceil(columns).max(1), self.rows().div_ceil(rows).max(1)])
    }

    /// The field with these numbers of columns and rows joined; at the ends fewer. At least 1 each.
    fn joined(&self, counts: [usize; 2]) -> Self {
        let join = |edges: &[u32], count: usize| {
            let mut joined: Vec<u32> = edges.iter().copied().step_by(count).collect();
            if joined.last() != edges.last() {
                joined.extend(edges.last());
            }
            joined
        };
        let edges = [join(&self.edges[0], counts[0]), join(&self.edges[1], counts[1])];
        let (columns, rows) = (edges[0].len() - 1, edges[1].len() - 1);
        let mean = |column: usize, row: usize| {
            let within = |number: usize, axis: usize, end: usize| {
                number * counts[axis]..((number + 1) * counts[axis]).min(end)
            };
            let (mut sum, mut all) = (0.0, 0.0);
            for y in within(row, 1, self.rows()) {
                for x in within(column, 0, self.columns()) {
                    let (value, area) = self.values.get(y * self.columns() + x).copied().unwrap_or_default();
                    (sum, all) = (sum + value * area, all + area);
                }
            }
            if all > 0.0 { (sum / all, all) } else { (0.0, 0.0) }
        };
        let values = (0..rows).flat_map(|row| (0..columns).map(move |column| mean(column, row))).collect();
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
        let numbers: Vec<f64> = (0..35).map(f64::from).collect();
        let field = CellField::new([7, 5], [7.0, 5.0], &[1.0; 35], &numbers);
        let blocks = field.blocks([3, 5]);
        // Three columns at a time, the last one alone; every row stays.
        assert_eq!((blocks.columns(), blocks.rows()), (3, 5));
        assert_eq!((blocks.at(0, 0), blocks.at(1, 2), blocks.at(2, 4)), (Some(1.0), Some(18.0), Some(34.0)));
        assert_eq!(blocks.edges(0), [0, 3, 6, 7]);
        assert_eq!((field.blocks([9, 9]), field.blocks([0, 0]).at(0, 0)), (field.clone(), Some(17.0)));
    }

    #[test]
    fn lists_that_are_too_short_leave_rows_out() {
        let cut = CellField::new([2, u32::MAX], [3.0, 1.0], &[1.0; 3], &[1.0, f64::NAN, 3.0]);
        assert_eq!((cut.columns(), cut.rows(), cut.at(0, 0), cut.at(1, 0)), (2, 1, Some(1.0), None));
        let none = CellField::new([0, 5], [3.0, 1.0], &[], &[]);
        assert_eq!((none.columns(), none.rows(), none.halved().rows(), none.at(0, 0)), (0, 0, 0, None));
    }
}
