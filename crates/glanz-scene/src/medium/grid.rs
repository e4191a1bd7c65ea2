//! Densities on a grid.

use std::cmp::Reverse;
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
    /// Memory of the bounds.
    pub(crate) const BOUND_BYTES: usize = BOUNDS.pow(3) * size_of::<f32>();

    /// `values`: as many as the product of the `resolution`, x fastest, finite and at least 0.
    pub(crate) fn from_checked(resolution: [usize; 3], values: Arc<[f32]>, to_box: Transform) -> Self {
        // The longest axis first: the others then have few densities left.
        let mut axes = [0, 1, 2];
        axes.sort_unstable_by_key(|&axis| Reverse(resolution[axis]));
        let mut sides = resolution;
        let first = largest_along(axes[0], &values, &mut sides);
        let bounds = axes[1..].iter().fold(first, |largest, &axis| largest_along(axis, &largest, &mut sides));
        Self { resolution, values, to_box, bounds }
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

/// The largest of `values` (x fastest) in the cells of the bounds along one axis, of which `sides` has the new number afterwards.
fn largest_along(axis: usize, values: &[f32], sides: &mut [usize; 3]) -> Vec<f32> {
    let (n, stride) = (sides[axis], sides[..axis].iter().product::<usize>());
    sides[axis] = BOUNDS;
    let mut largest = vec![0.0_f32; sides.iter().product()];
    for (block, cells) in values.chunks_exact(n * stride).zip(largest.chunks_exact_mut(BOUNDS * stride)) {
        for (i, cell) in cells.chunks_exact_mut(stride).enumerate() {
            // All values between which densities of the cell are interpolated; where a rounding selects one more, its weight is a rounding.
            let (first, last) = ((i * n / BOUNDS).saturating_sub(1), ((i + 1) * n / BOUNDS + 1).min(n - 1));
            for row in block[first * stride..(last + 1) * stride].chunks_exact(stride) {
                cell.iter_mut().zip(row).for_each(|(largest, value)| *largest = largest.max(*value));
            }
        }
    }
    largest
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
    fn bounds_are_the_largest_densities_near_their_cells() {
        for resolution in [[1, 1, 1], [3, 5, 40], [16, 7, 33], [50, 1, 2]] {
            let grid = grid(resolution);
            let cells: Vec<[usize; 3]> = (0..16 * 16 * 16).map(|i| [i % 16, i / 16 % 16, i / 256]).collect();
            for (cell, bound) in cells.iter().zip(&grid.bounds) {
                // Distance of the middle of a value from the cell, in values.
                let distance = |axis: usize, i: usize| {
                    let (n, c) = (resolution[axis] as f64, cell[axis] as f64);
                    let (low, high) = (c * n / 16.0, (c + 1.0) * n / 16.0);
                    let middle = i as f64 + 0.5;
                    (low - middle).max(middle - high)
                };
                let largest_within = |reach: f64| {
                    let [nx, ny, nz] = resolution;
                    let near = |axis, i| distance(axis, i) < reach;
                    let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z)));
                    let rows = rows.filter(|&(y, z)| near(1, y) && near(2, z));
                    let values = rows.flat_map(|(y, z)| (0..nx).map(move |x| [x, y, z]));
                    values.filter(|&[x, ..]| near(0, x)).map(|at| grid.value(at)).fold(0.0, f32::max)
                };
                // Interpolation reaches less than one value far.
                assert!(largest_within(1.0 - 1e-9) <= *bound, "{resolution:?} {cell:?}");
                assert!(*bound <= largest_within(2.0), "{resolution:?} {cell:?}");
            }
        }
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
