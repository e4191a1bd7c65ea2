//! Distributions of light on a plane at several resolutions.

use glanz_math::DVec2;

/// The distribution that is wanted on a receiver.
#[derive(Clone, Copy, Debug)]
pub(super) enum WantedLight<'a> {
    /// Even on the receiver and beyond each border by this fraction of its sides.
    Even { margin: f64 },
    /// In proportion to values of cells, row by row.
    Values { cells: [u32; 2], values: &'a [f64] },
    /// All in the middle.
    Peak,
}

/// Grids over compressed coordinates from -[`LandingGrid::HALF`] to it, with cells that double in size.
///
/// A point belongs to cells by the quadratic B-spline of their size, so that the share of each cell is a smooth function of the point. The differences at large cells draw light
/// over distances that the small ones do not bridge.
#[derive(Clone, Debug)]
pub(super) struct LandingGrid {
    levels: Vec<GridLevel>,
    /// Number of the finest levels that do not count.
    skipped: usize,
}

#[derive(Clone, Debug)]
struct GridLevel {
    /// Number of the first cell.
    first: usize,
    counts: [usize; 2],
    size: DVec2,
    /// Wanted shares of the cells; their sum is 1.
    wanted: Vec<f64>,
    /// Sum of their squares.
    norm: f64,
}

/// Most cells along a receiver to begin with. Finer cells from the beginning lead to caustics, which are local minima.
const FIRST_CELLS: f64 = 12.0;

/// Points along each side of a cell for the shares that are wanted.
const POINTS: u32 = 8;

impl LandingGrid {
    /// Largest compressed coordinate: 20 times half the side of the receiver.
    pub(super) const HALF: f64 = 4.0;

    /// Grids for `wanted`, of which the finest has `cells` on the receiver.
    pub(super) fn new(cells: [u32; 2], wanted: &WantedLight<'_>) -> Self {
        let mut levels: Vec<GridLevel> = Vec::new();
        let mut size = DVec2::new(2.0 / f64::from(cells[0].max(1)), 2.0 / f64::from(cells[1].max(1)));
        loop {
            let counts = (2.0 * Self::HALF / size).ceil().to_array().map(|n| n as usize);
            let first = levels.last().map_or(0, |level| level.first + level.wanted.len());
            levels.push(GridLevel {
                first,
                counts,
                size,
                wanted: vec![0.0; counts[0] * counts[1]],
                norm: 0.0,
            });
            if size.min_element() >= 2.0 {
                break;
            }
            size = (2.0 * size).min(DVec2::splat(2.0));
        }
        let mut grid = Self { levels, skipped: 0 };
        let mut shares = vec![0.0; grid.len()];
        let mut total = 0.0;
        for (at, weight) in wanted.points(cells) {
            total += weight;
            grid.cells_near(at, |index, share, _| {
                if let Some(cell) = shares.get_mut(index) {
                    *cell += weight * share;
                }
            });
        }
        for level in &mut grid.levels {
            for (wanted, share) in level.wanted.iter_mut().zip(shares.iter().skip(level.first)) {
                *wanted = share / total;
            }
            level.norm = level.wanted.iter().map(|share| share * share).sum();
        }
        grid
    }

    /// Number of levels whose cells are finer than those to begin with.
    pub(super) fn refinements(&self) -> usize {
        let is_fine = |level: &&GridLevel| 2.0 / level.size.min_element() > FIRST_CELLS;
        self.levels.iter().filter(is_fine).count()
    }

    /// Leaves the `count` finest levels out of the difference, but the coarsest.
    pub(super) fn skip(&mut self, count: usize) {
        self.skipped = count.min(self.levels.len().saturating_sub(1));
    }

    /// Number of cells of all levels.
    pub(super) fn len(&self) -> usize {
        self.levels.last().map_or(0, |level| level.first + level.wanted.len())
    }

    /// Calls `visit` for each cell near a point with the share of the point that belongs to it and the derivative of the share.
    pub(super) fn cells_near(&self, at: DVec2, mut visit: impl FnMut(usize, f64, DVec2)) {
        for level in &self.levels {
            let place = (at + Self::HALF) / level.size;
            let base = place.floor();
            let [x, y] = (place - base - 0.5).to_array().map(spline);
            let [nx, ny] = level.counts;
            for (row, (sy, dy)) in [base.y - 1.0, base.y, base.y + 1.0].into_iter().zip(y) {
                for (column, (sx, dx)) in [base.x - 1.0, base.x, base.x + 1.0].into_iter().zip(x) {
                    if column < 0.0 || row < 0.0 || column >= nx as f64 || row >= ny as f64 {
                        continue;
                    }
                    let index = level.first + row as usize * nx + column as usize;
                    visit(index, sx * sy, DVec2::new(dx * sy, sx * dy) / level.size);
                }
            }
        }
    }

    /// The mean over all levels of the squared differences of `cells`, as shares of `flux`, from the wanted ones, in units of the squares of those; then the one of the finest
    /// level. Sets the derivatives by the cells and by the flux.
    pub(super) fn difference(
        &self,
        cells: &[f64],
        flux: f64,
        by_cells: &mut [f64],
        by_flux: &mut f64,
    ) -> (f64, f64) {
        let (mut sum, mut finest) = (0.0, 0.0);
        let mean = 1.0 / (self.levels.len() - self.skipped) as f64;
        for (number, level) in self.levels.iter().enumerate() {
            let counts = if number < self.skipped { 0.0 } else { mean };
            let mut squares = 0.0;
            let cells = cells.iter().skip(level.first).zip(&level.wanted);
            for ((cell, wanted), slope) in cells.zip(by_cells.iter_mut().skip(level.first)) {
                let difference = cell / flux - wanted;
                squares += difference * difference;
                *slope = 2.0 * counts * difference / (level.norm * flux);
                *by_flux -= *slope * cell / flux;
            }
            sum += counts * squares / level.norm;
            if number == 0 {
                finest = squares / level.norm;
            }
        }
        (sum, finest)
    }
}

impl WantedLight<'_> {
    /// Points in compressed coordinates, which have the distribution, with their weights.
    fn points(&self, cells: [u32; 2]) -> Vec<(DVec2, f64)> {
        match *self {
            Self::Peak => vec![(DVec2::ZERO, 1.0)],
            Self::Even { margin } => {
                let half = 1.0 + 2.0 * margin;
                let [nx, ny] = cells.map(|n| (POINTS * n) as f64 * half).map(|n| n.ceil() as u32);
                let even = |_: u32, _: u32| 1.0;
                points([nx, ny], half, even)
            }
            Self::Values { cells: [nx, ny], values } => {
                let value = |i: u32, j: u32| {
                    let cell = (j / POINTS) as usize * nx as usize + (i / POINTS) as usize;
                    values.get(cell).copied().unwrap_or_default()
                };
                points([POINTS * nx, POINTS * ny], 1.0, value)
            }
        }
    }
}

/// A grid of points up to `half` in both directions, with their weights.
fn points([nx, ny]: [u32; 2], half: f64, weight: impl Fn(u32, u32) -> f64) -> Vec<(DVec2, f64)> {
    let place = |i: u32, n: u32| {
        let x = half * ((2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0);
        super::merit::compressed(x).0
    };
    let row = |j: u32| {
        let (weight, place) = (&weight, &place);
        (0..nx).map(move |i| (DVec2::new(place(i, nx), place(j, ny)), weight(i, j)))
    };
    (0..ny).flat_map(row).collect()
}

/// The quadratic B-spline about the cells before, at and after a point, which is `x` from the middle of its cell, in cells; values and derivatives.
fn spline(x: f64) -> [(f64, f64); 3] {
    let (before, after) = (0.5 - x, 0.5 + x);
    [(0.5 * before * before, -before), (0.75 - x * x, -2.0 * x), (0.5 * after * after, after)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_point_add_up_to_it_at_every_level() {
        let grid = LandingGrid::new([8, 6], &WantedLight::Peak);
        // Cells of 1/4 x 1/3, 1/2 x 2/3, 1 x 4/3, 2 x 2.
        let counts: Vec<[usize; 2]> = grid.levels.iter().map(|level| level.counts).collect();
        assert_eq!(counts, [[32, 24], [16, 12], [8, 6], [4, 4]]);
        let (mut shares, mut slopes) = (0.0, DVec2::ZERO);
        grid.cells_near(DVec2::new(0.37, -1.21), |_, share, slope| {
            shares += share;
            slopes += slope;
        });
        assert!((shares - 4.0).abs() < 1e-14 && slopes.length() < 1e-13, "{shares} {slopes}");
    }

    #[test]
    fn fine_cells_do_not_count_at_the_beginning() {
        let mut grid = LandingGrid::new([40, 28], &WantedLight::Even { margin: 0.0 });
        // 40, 20, then 10 cells.
        assert_eq!(grid.refinements(), 2);
        assert_eq!(LandingGrid::new([12, 1], &WantedLight::Peak).refinements(), 0);
        let spot = LandingGrid::new([40, 28], &WantedLight::Peak);
        let cells: Vec<f64> = spot.levels.iter().flat_map(|level| level.wanted.clone()).collect();
        let mut difference = |skipped: usize| {
            grid.skip(skipped);
            let (mut slopes, mut by_flux) = (vec![0.0; cells.len()], 0.0);
            let (sum, finest) = grid.difference(&cells, 1.0, &mut slopes, &mut by_flux);
            (sum, finest, slopes.iter().position(|slope| *slope != 0.0))
        };
        let (all, finest, first) = difference(0);
        let (coarse, same, second) = difference(2);
        assert!(finest == same && coarse < all && first.unwrap() < second.unwrap());
        assert!(second.unwrap() >= grid.levels[2].first);
    }

    #[test]
    fn wanted_values_are_those_of_their_cells() {
        let values = [1.0, 3.0, 0.0, 4.0];
        let grid = LandingGrid::new([16, 16], &WantedLight::Values { cells: [2, 2], values: &values });
        let finest = &grid.levels[0];
        let at = |x: f64, y: f64| {
            let [i, j] = [x, y].map(|x| ((x + 4.0) * 8.0) as usize);
            finest.wanted[j * finest.counts[0] + i]
        };
        // 64 cells for each of the values, whose sum is 8.
        for (x, y, value) in
            [(-0.5, -0.5, 1.0), (0.5, -0.5, 3.0), (-0.5, 0.5, 0.0), (0.5, 0.5, 4.0), (1.5, 0.0, 0.0)]
        {
            assert!((at(x, y) - value / 512.0).abs() < 1e-12, "{x} {y} {}", at(x, y));
        }
    }
}
