//! Densities on a grid.

use std::sync::Arc;

use glanz_math::{DVec3, Ray, Transform};

use super::segments::MediumSegments;

/// Largest number of densities of a medium: a gigabyte.
pub const MAX_DENSITIES: usize = 1 << 28;

/// Cells along each axis for which bounds on the density are kept.
const BOUNDS: usize = 16;

/// Densities at the middles of cells, linear along each axis between them and 0 outside.
///
/// # Source
/// @pharr2023 section 11.4.4 (`GridMedium`) and appendix B (`SampledGrid`).
#[derive(Clone, Debug)]
pub(crate) struct DensityGrid {
    resolution: [usize; 3],
    values: Arc<[f32]>,
    /// From world space to the frame in which the box is [0, 1]^3.
    to_box: Transform,
    /// The largest density in each of 16^3 cells of the box, x fastest.
    bounds: Vec<f32>,
}

impl DensityGrid {
    /// `values`: as many as the product of the `resolution`, x fastest, finite and at least 0.
    pub(crate) fn from_checked(resolution: [usize; 3], values: Arc<[f32]>, to_box: Transform) -> Self {
        let mut grid = Self { resolution, values, to_box, bounds: Vec::new() };
        grid.bounds = (0..BOUNDS.pow(3)).map(|cell| grid.bound_of(cell)).collect();
        grid
    }

    /// The largest density in a cell of the bounds.
    fn bound_of(&self, cell: usize) -> f32 {
        let place = [cell % BOUNDS, cell / BOUNDS % BOUNDS, cell / (BOUNDS * BOUNDS)];
        // All values between which densities of the cell are interpolated, and one more on each side for roundings.
        let range = |axis: usize| {
            let (n, i) = (self.resolution[axis], place[axis]);
            let first = (i * n / BOUNDS).saturating_sub(1);
            first..=((i + 1) * n / BOUNDS + 1).min(n - 1)
        };
        let rows = range(2).flat_map(|z| range(1).map(move |y| (z, y)));
        let values = rows.flat_map(|(z, y)| range(0).map(move |x| self.value([x, y, z])));
        values.fold(0.0, f32::max)
    }

    fn value(&self, [x, y, z]: [usize; 3]) -> f32 {
        let [nx, ny, _] = self.resolution;
        self.values[(z * ny + y) * nx + x]
    }

    /// The density at a point of world space.
    pub(super) fn density(&self, at: DVec3) -> f64 {
        let [nx, ny, nz] = self.resolution.map(|n| n as f64);
        let place = self.to_box.point(at) * DVec3::new(nx, ny, nz) - 0.5;
        let corner = place.floor();
        let across = (place - corner).to_array();
        let corner = corner.to_array();
        let mut density = 0.0;
        for number in 0..8 {
            let (mut weight, mut cell, mut is_inside) = (1.0, [0; 3], true);
            for axis in 0..3 {
                let upper = number >> axis & 1;
                let index = corner[axis] + f64::from(upper);
                weight *= if upper == 1 { across[axis] } else { 1.0 - across[axis] };
                is_inside &= index >= 0.0 && index < self.resolution[axis] as f64;
                cell[axis] = index as usize;
            }
            if is_inside {
                density += weight * f64::from(self.value(cell));
            }
        }
        density
    }

    /// The parts of a ray in the cells of the bounds that are not empty.
    pub(super) fn segments(&self, ray: &Ray, t_max: f64) -> MediumSegments<'_> {
        MediumSegments::through_cells(&self.to_box.ray(ray), t_max, BOUNDS, &self.bounds)
    }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::hash::{combine, unit_f64};

    use super::*;

    fn grid(resolution: [usize; 3]) -> DensityGrid {
        let count: usize = resolution.iter().product();
        // A third of them is 0.
        let values =
            (0..count).map(|i| (1.5 * unit_f64(combine(7, i as u64)) - 0.5).max(0.0) as f32).collect();
        let to_box = Transform::translate(DVec3::new(1.0, 2.0, 3.0));
        DensityGrid::from_checked(resolution, values, to_box.inverse())
    }

    #[test]
    fn densities_are_those_of_cells_at_their_middles_and_linear_in_between() {
        let (resolution, corner) = ([3, 4, 5], DVec3::new(1.0, 2.0, 3.0));
        let grid = grid(resolution);
        let middle = |cell: [usize; 3]| {
            corner + DVec3::from(std::array::from_fn(|k| (cell[k] as f64 + 0.5) / resolution[k] as f64))
        };
        let value = |cell| f64::from(grid.value(cell));
        let close = |at: DVec3, expected: f64| assert!((grid.density(at) - expected).abs() < 1e-14, "{at}");
        let (a, b) = ([1, 2, 3], [2, 3, 2]);
        close(middle(a), value(a));
        close(middle(b), value(b));
        close(
            0.25 * middle([0, 1, 4]) + 0.75 * middle([1, 1, 4]),
            0.25 * value([0, 1, 4]) + 0.75 * value([1, 1, 4]),
        );
        // At the border half of the last value is left, half a cell beyond it nothing.
        let last = [2, 2, 3];
        close(DVec3 { x: 2.0, ..middle(last) }, 0.5 * value(last));
        close(DVec3 { x: 2.0 + 0.5 / 3.0, ..middle(last) }, 0.0);
    }

    #[test]
    fn segments_bound_all_densities_along_a_ray() {
        for resolution in [[1, 1, 1], [3, 5, 40], [16, 7, 33]] {
            let grid = grid(resolution);
            for i in 0..200 {
                let number = |k| unit_f64(combine(k, i));
                let point = |k| DVec3::new(number(k), number(k + 1), number(k + 2));
                let origin = DVec3::new(1.0, 2.0, 3.0) + 2.0 * point(1) - 0.5;
                let ray = Ray::new(origin, point(4) - 0.5);
                let segments: Vec<_> = grid.segments(&ray, 5.0).collect();
                for k in 0..500 {
                    let t = f64::from(k) * 0.01;
                    let density = grid.density(ray.at(t));
                    let is_inside = (ray.at(t) - DVec3::new(1.5, 2.5, 3.5)).abs().max_element() < 0.5;
                    let bound =
                        segments.iter().find(|s| s.start <= t && t <= s.end).map_or(0.0, |s| s.density);
                    assert!(!is_inside || density <= f64::from(bound), "{resolution:?} ray {i} at {t}");
                }
            }
        }
    }
}
