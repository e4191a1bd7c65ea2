//! Cells of a surface's parameters with one value each.

use glanz_math::{DVec2, DVec3};

use super::{Border, Interpolant, InterpolatedTexture, Lattice, ReconstructError, Sample};
use crate::rectangle_grid::RectangleGrid;

/// Largest difference between the sum of the areas of cells and that of the square.
const AREA_TOLERANCE: f64 = 1e-9;

/// A rectangle of parameters with a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterCell {
    /// Smallest u and v.
    pub min: DVec2,
    /// Largest u and v.
    pub max: DVec2,
    /// Its value: red, green and blue.
    pub value: DVec3,
}

impl ParameterCell {
    /// Its middle.
    #[must_use]
    pub fn middle(&self) -> DVec2 {
        0.5 * (self.min + self.max)
    }

    /// Whether it contains a point; its upper sides belong to it only on the border of the square.
    fn contains(&self, point: DVec2) -> bool {
        (0..2).all(|i| point[i] >= self.min[i] && (point[i] < self.max[i] || self.max[i] == 1.0))
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.min.cmplt(other.max).all() && other.min.cmplt(self.max).all()
    }

    fn area(&self) -> f64 {
        let size = self.max - self.min;
        size.x * size.y
    }
}

/// Cells that cover the unit square without overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterCells {
    cells: Vec<ParameterCell>,
    grid: RectangleGrid,
}

impl ParameterCells {
    /// Checks and indexes cells.
    ///
    /// # Errors
    /// [`ReconstructError::Cells`] if they do not cover the unit square exactly once, [`ReconstructError::Sample`] for a value that is not
    /// finite.
    pub fn try_new(cells: Vec<ParameterCell>) -> Result<Self, ReconstructError> {
        for (i, cell) in cells.iter().enumerate() {
            let inside = cell.min.cmpge(DVec2::ZERO).all() && cell.max.cmple(DVec2::ONE).all();
            if !(inside && cell.min.cmplt(cell.max).all()) {
                return Err(ReconstructError::Cells(i));
            }
            if !cell.value.is_finite() {
                return Err(ReconstructError::Sample(i));
            }
        }
        let side = (cells.len() as f64).sqrt().ceil().max(1.0) as usize;
        let bounds: Vec<[DVec2; 2]> = cells.iter().map(|cell| [cell.min, cell.max]).collect();
        let grid = RectangleGrid::with_linear_memory(DVec2::ONE, side, &bounds);
        for list in grid.lists() {
            for (at, &i) in list.iter().enumerate() {
                let cell = &cells[i as usize];
                if list[..at].iter().any(|&j| cell.overlaps(&cells[j as usize])) {
                    return Err(ReconstructError::Cells(i as usize));
                }
            }
        }
        let missing = 1.0 - cells.iter().map(ParameterCell::area).sum::<f64>();
        if missing.abs() > AREA_TOLERANCE {
            return Err(ReconstructError::Cells(cells.len()));
        }
        Ok(Self { cells, grid })
    }

    /// A grid of `size[0]` x `size[1]` equal cells with values by rows of constant v, from v = 0.
    ///
    /// # Errors
    /// Those of [`ParameterCells::try_new`]; [`ReconstructError::Cells`] for another number of values.
    pub fn grid(size: [usize; 2], values: &[DVec3]) -> Result<Self, ReconstructError> {
        if size[0].checked_mul(size[1]) != Some(values.len()) {
            return Err(ReconstructError::Cells(values.len()));
        }
        let corner = |x: usize, y: usize| DVec2::new(x as f64 / size[0] as f64, y as f64 / size[1] as f64);
        let cells = values.iter().enumerate().map(|(i, &value)| {
            let (x, y) = (i % size[0], i / size[0]);
            ParameterCell { min: corner(x, y), max: corner(x + 1, y + 1), value }
        });
        Self::try_new(cells.collect())
    }

    /// All cells.
    #[must_use]
    pub fn as_slice(&self) -> &[ParameterCell] {
        &self.cells
    }

    /// A sample in the middle of each cell, and those at the border as selected.
    #[must_use]
    pub fn samples(&self, border: Border) -> Vec<Sample> {
        let mut samples: Vec<Sample> =
            self.cells.iter().map(|cell| Sample { point: cell.middle(), value: cell.value }).collect();
        if border == Border::Sampled {
            for cell in &self.cells {
                let middle = cell.middle().to_array();
                let sides = [0, 1].map(|axis| {
                    let (low, high) = (cell.min[axis] == 0.0, cell.max[axis] == 1.0);
                    [(low, 0.0), (high, 1.0)].into_iter().filter(|(at, _)| *at).map(|(_, x)| x)
                });
                let [across, along] = sides;
                let mut add = |u: f64, v: f64| {
                    samples.push(Sample { point: DVec2::new(u, v), value: cell.value });
                };
                along.clone().for_each(|v| add(middle[0], v));
                for u in across {
                    add(u, middle[1]);
                    along.clone().for_each(|v| add(u, v));
                }
            }
        }
        samples
    }

    /// The samples as a grid; `None` if the cells form no grid.
    #[must_use]
    pub fn lattice(&self, border: Border) -> Option<Lattice> {
        let lines = |axis: usize| {
            let mut line: Vec<f64> = self.cells.iter().map(|cell| cell.middle()[axis]).collect();
            line.sort_by(f64::total_cmp);
            line.dedup();
            line
        };
        let (u, v) = (lines(0), lines(1));
        if u.len().checked_mul(v.len()) != Some(self.cells.len()) {
            return None;
        }
        let mut order: Vec<&ParameterCell> = self.cells.iter().collect();
        order.sort_by(|a, b| {
            let (a, b) = (a.middle(), b.middle());
            a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
        });
        let plain = Lattice::new(u, v, order.iter().map(|cell| cell.value).collect())?;
        match border {
            Border::Open => Some(plain),
            Border::Sampled => plain.with_border(),
        }
    }

    /// The cell that contains a point of the unit square; on a common side that of larger u or v.
    #[must_use]
    pub fn cell_at(&self, point: DVec2) -> Option<&ParameterCell> {
        let near = self.grid.near(point).iter();
        near.filter_map(|&i| self.cells.get(i as usize)).find(|cell| cell.contains(point))
    }
}

/// Piecewise constant.
impl Interpolant for ParameterCells {
    fn value(&self, point: DVec2) -> DVec3 {
        self.cell_at(point).map_or(DVec3::ZERO, |cell| cell.value)
    }

    fn texture(&self, size: [usize; 2]) -> InterpolatedTexture {
        let mut texels = vec![DVec3::ZERO; size[0] * size[1]];
        for cell in &self.cells {
            // Texels whose middle is in the cell.
            let range = |axis: usize| {
                let first = |x: f64| ((x * size[axis] as f64 - 0.5).ceil().max(0.0) as usize).min(size[axis]);
                let end = if cell.max[axis] == 1.0 { size[axis] } else { first(cell.max[axis]) };
                first(cell.min[axis])..end
            };
            for y in range(1) {
                for x in range(0) {
                    texels[y * size[0] + x] = cell.value;
                }
            }
        }
        InterpolatedTexture::from_texels(size, texels)
            .unwrap_or_else(|| InterpolatedTexture::from_function(size, |p| self.value(p)))
    }
}
