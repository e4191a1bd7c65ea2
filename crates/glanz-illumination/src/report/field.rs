//! A number for every cell of a receiver, to draw.

use crate::LuxMap;

/// Numbers over the cells of a rectangle. Cells join where there are too many of them to draw.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    /// Borders between the columns and the rows, counted in cells of the map, from 0.
    edges: [Vec<u32>; 2],
    /// Lengths in metres.
    size: [f64; 2],
    /// Row by row: the number and the area of the cell it is for, 0 where there is nothing to show.
    values: Vec<(f64, f64)>,
}

impl Field {
    /// The illuminances of a map.
    pub(crate) fn of(map: &LuxMap) -> Self {
        Self::of_values(map, &map.lux)
    }

    /// Other numbers for the cells of a map. Cells without area show nothing, nor do numbers that are not finite;
    /// lists that are too short leave rows out.
    pub(crate) fn of_values(map: &LuxMap, numbers: &[f64]) -> Self {
        let pairs: Vec<(f64, f64)> = numbers.iter().copied().zip(map.areas.iter().copied()).collect();
        let columns = map.cells[0].min(u32::try_from(pairs.len()).unwrap_or(u32::MAX));
        let rows = (pairs.len() as u64).checked_div(u64::from(columns)).unwrap_or(0);
        let rows = map.cells[1].min(u32::try_from(rows).unwrap_or(u32::MAX));
        let shown = |&(number, area): &(f64, f64)| {
            let is_there = f64::is_finite(number) && area > 0.0 && f64::is_finite(area);
            if is_there { (number, area) } else { (0.0, 0.0) }
        };
        let values = pairs.iter().take(columns as usize * rows as usize).map(shown).collect();
        let size = map.size.map(|s| if s.is_finite() && s > 0.0 { s } else { 1.0 });
        Self { edges: [(0..=columns).collect(), (0..=rows).collect()], size, values }
    }

    pub(crate) fn columns(&self) -> usize {
        self.edges[0].len() - 1
    }

    pub(crate) fn rows(&self) -> usize {
        self.edges[1].len() - 1
    }

    /// Lengths in metres.
    pub(crate) fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Borders between columns or rows, in cells of the map.
    pub(crate) fn edges(&self, axis: usize) -> &[u32] {
        &self.edges[axis]
    }

    /// The number of a cell; `None` where there is nothing to show.
    pub(crate) fn at(&self, column: usize, row: usize) -> Option<f64> {
        let (number, area) = self.values.get(row * self.columns() + column)?;
        (*area > 0.0).then_some(*number)
    }

    /// All numbers that are shown, with the areas of their cells.
    pub(crate) fn shown(&self) -> impl Iterator<Item = (f64, f64)> {
        self.values.iter().copied().filter(|(_, area)| *area > 0.0)
    }

    /// The same with every two columns and rows as one: means over areas.
    pub(crate) fn halved(&self) -> Self {
        let join = |edges: &[u32]| {
            let mut joined: Vec<u32> = edges.iter().copied().step_by(2).collect();
            if edges.len().is_multiple_of(2) {
                joined.extend(edges.last());
            }
            joined
        };
        let edges = [join(&self.edges[0]), join(&self.edges[1])];
        let (columns, rows) = (edges[0].len() - 1, edges[1].len() - 1);
        let mean = |column: usize, row: usize| {
            let cells = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| [2 * column + dx, 2 * row + dy]);
            let inside = cells.into_iter().filter(|[x, y]| *x < self.columns() && *y < self.rows());
            let numbers = inside.filter_map(|[x, y]| self.values.get(y * self.columns() + x));
            let (sum, area) = numbers.fold((0.0, 0.0), |(sum, all), (v, area)| (sum + v * area, all + area));
            if area > 0.0 { (sum / area, area) } else { (0.0, 0.0) }
        };
        let values = (0..rows).flat_map(|row| (0..columns).map(move |column| mean(column, row))).collect();
        Self { edges, size: self.size, values }
    }

    /// Positions of the middles of the columns or rows in [0, 1], and the borders of the rectangle before and after.
    pub(crate) fn middles(&self, axis: usize) -> Vec<f64> {
        let edges = &self.edges[axis];
        let all = f64::from(edges.last().copied().unwrap_or(0).max(1));
        let middles = edges.windows(2).map(|pair| (f64::from(pair[0]) + f64::from(pair[1])) / (2.0 * all));
        std::iter::once(0.0).chain(middles).chain([1.0]).collect()
    }

    /// The numbers at the crossings of all [`Field::middles`]: on the borders those of the nearest cells.
    pub(crate) fn to_borders(&self) -> Vec<Option<f64>> {
        let near = |place: usize, count: usize| place.saturating_sub(1).min(count.saturating_sub(1));
        let (columns, rows) = (self.columns(), self.rows());
        (0..rows + 2)
            .flat_map(|y| (0..columns + 2).map(move |x| self.at(near(x, columns), near(y, rows))))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::DVec3;

    fn map(cells: [u32; 2], lux: Vec<f64>, areas: Vec<f64>) -> LuxMap {
        let positions = vec![DVec3::ZERO; lux.len()];
        LuxMap { name: "m".into(), cells, size: [3.0, 1.0], positions, areas, errors: lux.clone(), lux }
    }

    #[test]
    fn joined_cells_are_means_over_the_area() {
        // 1 2 9 and above it 3 4 - ; the last column stands alone.
        let field = Field::of(&map([3, 2], vec![1., 2., 9., 3., 4., 7.], vec![1., 1., 2., 1., 3., 0.]));
        assert_eq!((field.at(2, 0), field.at(2, 1)), (Some(9.0), None));
        let half = field.halved();
        // (1 + 2 + 3 + 3 * 4) / 6.
        assert_eq!((half.columns(), half.rows(), half.at(0, 0), half.at(1, 0)), (2, 1, Some(3.0), Some(9.0)));
        assert_eq!(half.edges(0), [0, 2, 3]);
        assert_eq!(half.middles(0), [0.0, 1.0 / 3.0, 5.0 / 6.0, 1.0]);
        let row = [Some(3.0), Some(3.0), Some(9.0), Some(9.0)];
        assert_eq!(half.to_borders(), [row, row, row].concat());
    }

    #[test]
    fn lists_that_are_too_short_leave_rows_out() {
        let cut = Field::of(&map([2, u32::MAX], vec![1.0, f64::NAN, 3.0], vec![1.0; 3]));
        assert_eq!((cut.columns(), cut.rows(), cut.at(0, 0), cut.at(1, 0)), (2, 1, Some(1.0), None));
        let none = Field::of(&map([0, 5], Vec::new(), Vec::new()));
        assert_eq!((none.columns(), none.rows(), none.halved().rows(), none.at(0, 0)), (0, 0, 0, None));
    }
}
