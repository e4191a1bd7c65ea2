//! Interpolation of many samples by a partition of unity.

use glanz_math::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Interpolant, Interpolation, ReconstructError, Sample};
use crate::rectangle_grid::RectangleGrid;

/// Largest number of samples of a part, without those that it shares with its neighbours.
const MAX_SAMPLES: usize = 256;

/// Overlap of a part with its neighbours, relative to its size.
const OVERLAP: f64 = 0.25;

/// Largest number of samples of a part with those that it shares; where its neighbours have more, it overlaps them less.
const MAX_SHARED_SAMPLES: usize = 4 * MAX_SAMPLES;

/// Largest number of times that the overlap is halved.
const MAX_HALVINGS: u32 = 16;

/// Mean number of samples in a cell of the grid in which they are looked up.
const SAMPLES_PER_CELL: f64 = 4.0;

/// Largest number of cells along each axis of the grid in which parts are looked up.
const MAX_COLUMNS: usize = 64;

/// Weighted mean of the interpolants of overlapping parts: the systems of equations have the size of a part, and samples are still
/// interpolated, because all parts that contain one agree on its value.
struct Partition {
    parts: Vec<InterpolatedPart>,
    /// Bounds of the parts.
    grid: RectangleGrid,
}

struct InterpolatedPart {
    min: DVec2,
    max: DVec2,
    interpolant: Box<dyn Interpolant>,
}

impl InterpolatedPart {
    /// Weight at a point: positive inside, decreasing smoothly to 0 at the border.
    fn weight(&self, point: DVec2) -> f64 {
        let inside = (point - self.min).min(self.max - point) / (self.max - self.min);
        inside.max(DVec2::ZERO).to_array().map(|x| x * x).iter().product()
    }
}

/// As [`Interpolation::of_samples_within`], for any number of samples: the time to prepare n samples grows as n log n,
/// and that of a value not with n unless they are crowded.
///
/// # Errors
/// Those of [`Interpolation::of_samples_within`].
pub(crate) fn of_many_samples(
    method: Interpolation,
    samples: &[Sample],
    size: DVec2,
) -> Result<Box<dyn Interpolant>, ReconstructError> {
    let is_global = matches!(method, Interpolation::Shepard { .. } | Interpolation::Multiquadrics { .. });
    if !is_global || samples.len() <= MAX_SAMPLES {
        return method.of_samples_within(samples, size);
    }
    let mut rectangles = Vec::new();
    let points: Vec<DVec2> = samples.iter().map(|sample| sample.point).collect();
    let columns = (points.len() as f64 / SAMPLES_PER_CELL).sqrt().ceil() as usize;
    let grid = RectangleGrid::new(size, columns, &points.iter().map(|&point| [point; 2]).collect::<Vec<_>>());
    divide(points, [DVec2::ZERO, size], &mut rectangles);
    let part = |rectangle: &[DVec2; 2]| {
        let ([min, max], samples) = with_overlap(rectangle, samples, &grid);
        Ok(InterpolatedPart { min, max, interpolant: method.of_samples_within(&samples, size)? })
    };
    let parts: Vec<InterpolatedPart> =
        rectangles.par_iter().map(part).collect::<Result<_, ReconstructError>>()?;
    let bounds: Vec<[DVec2; 2]> = parts.iter().map(|part| [part.min, part.max]).collect();
    let grid = RectangleGrid::with_linear_memory(size, MAX_COLUMNS, &bounds);
    Ok(Box::new(Partition { parts, grid }))
}

/// A rectangle with its overlap, and the samples in it. `grid`: that of the points of all samples.
fn with_overlap(
    [low, high]: &[DVec2; 2],
    samples: &[Sample],
    grid: &RectangleGrid,
) -> ([DVec2; 2], Vec<Sample>) {
    let with = |halvings: u32| {
        let reach = OVERLAP * 0.5_f64.powi(halvings as i32) * (high - low);
        let [min, max] = [low - reach, high + reach];
        let is_inside = |&number: &u32| {
            let sample = samples.get(number as usize);
            sample.is_some_and(|s| s.point.cmpge(min).all() && s.point.cmple(max).all())
        };
        ([min, max], grid.overlapping(&[min, max]).filter(is_inside).collect::<Vec<u32>>())
    };
    let (bounds, mut inside) = (0..MAX_HALVINGS)
        .map(with)
        .find(|(_, inside)| inside.len() <= MAX_SHARED_SAMPLES)
        .unwrap_or_else(|| with(MAX_HALVINGS));
    inside.sort_unstable();
    let inside = inside.into_iter().filter_map(|number| samples.get(number as usize).copied());
    (bounds, inside.collect())
}

/// Divides a rectangle at the median of the points, across its longer side if possible, until each part has at most [`MAX_SAMPLES`] of
/// them; each part has at least one.
fn divide(mut points: Vec<DVec2>, [low, high]: [DVec2; 2], rectangles: &mut Vec<[DVec2; 2]>) {
    if points.len() <= MAX_SAMPLES {
        return rectangles.push([low, high]);
    }
    let longer = usize::from(high.y - low.y > high.x - low.x);
    let cut = [longer, 1 - longer].into_iter().find_map(|axis| Some((axis, cut(&mut points, axis, high)?)));
    let Some((axis, middle)) = cut else { return rectangles.push([low, high]) };
    let above = points.split_off(points.partition_point(|point| point[axis] < middle));
    let (mut end, mut begin) = (high, low);
    (end[axis], begin[axis]) = (middle, middle);
    divide(points, [low, end], rectangles);
    divide(above, [begin, high], rectangles);
}

/// Sorts points along an axis; returns the coordinate next to their median that has points on both sides of it, below `high`. `None` if all
/// are equal.
fn cut(points: &mut [DVec2], axis: usize, high: DVec2) -> Option<f64> {
    points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    let median = points.get(points.len() / 2)?[axis];
    let below = points.partition_point(|point| point[axis] < median);
    if below > 0 && median < high[axis] {
        return Some(median);
    }
    // Half of the points or more are on one line, at a side of the rectangle or of the points: the cut is beside it.
    let i = if below > 0 { below } else { points.partition_point(|point| point[axis] <= median) };
    let (before, after) = (points.get(i.checked_sub(1)?)?[axis], points.get(i)?[axis]);
    let middle = before.midpoint(after);
    (before < middle && middle < after).then_some(middle)
}

impl Interpolant for Partition {
    fn value(&self, point: DVec2) -> DVec3 {
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for part in self.grid.near(point).iter().filter_map(|&number| self.parts.get(number as usize)) {
            let weight = part.weight(point);
            if weight > 0.0 {
                sum += weight * part.interpolant.value(point);
                weights += weight;
            }
        }
        sum / weights
    }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::sequence::owen::{ScrambledSobol, unit};

    use super::*;

    /// Rectangles of parts, and the samples that belong to each.
    fn parts(samples: &[Sample], size: DVec2) -> Vec<([DVec2; 2], Vec<Sample>)> {
        let points: Vec<DVec2> = samples.iter().map(|sample| sample.point).collect();
        let grid = RectangleGrid::new(size, 9, &points.iter().map(|&point| [point; 2]).collect::<Vec<_>>());
        let mut rectangles = Vec::new();
        divide(points, [DVec2::ZERO, size], &mut rectangles);
        rectangles.iter().map(|rectangle| with_overlap(rectangle, samples, &grid)).collect()
    }

    #[test]
    fn parts_next_to_crowded_ones_have_few_samples() {
        // Most samples are near the left side, and many on it.
        let sobol = ScrambledSobol::new(7);
        let sample = |i: u32| {
            let [x, y] = sobol.pair(i, 0).map(unit);
            let x = match i % 8 {
                0 => x,
                1..=3 => 0.0,
                _ => 0.02 * x,
            };
            Sample { point: DVec2::new(x, y), value: DVec3::ONE }
        };
        let samples: Vec<Sample> = (0..20_000).map(sample).collect();
        let parts = parts(&samples, DVec2::ONE);
        let most = parts.iter().map(|(_, samples)| samples.len()).max();
        assert!(most <= Some(MAX_SHARED_SAMPLES), "{most:?}");
        assert!(parts.iter().all(|(_, samples)| !samples.is_empty()));
        // A value is the mean of a few parts.
        let bounds: Vec<[DVec2; 2]> = parts.iter().map(|(bounds, _)| *bounds).collect();
        let grid = RectangleGrid::with_linear_memory(DVec2::ONE, MAX_COLUMNS, &bounds);
        let near = samples.iter().map(|sample| grid.near(sample.point).len()).sum::<usize>() / samples.len();
        assert!(near < 24 && parts.len() > 100, "{near} of {}", parts.len());
    }

    #[test]
    fn parts_agree_with_the_whole_and_interpolate_the_samples() {
        let sobol = ScrambledSobol::new(5);
        let size = DVec2::new(1.0, 0.4);
        let value = |p: DVec2| DVec3::new((3.0 * p.x).sin(), p.x * p.y, 1.0 + p.y * p.y);
        let sample = |i: u32| {
            let point = size * DVec2::from_array(sobol.pair(i, 0).map(unit));
            Sample { point, value: value(point) }
        };
        let samples: Vec<Sample> = (0..1500).map(sample).collect();
        for method in
            [Interpolation::Multiquadrics { exponent: 0.5 }, Interpolation::Shepard { exponent: 4.0 }]
        {
            let whole = method.of_samples_within(&samples, size).unwrap();
            let parts = of_many_samples(method, &samples, size).unwrap();
            let off = |p: DVec2| (parts.value(p) - whole.value(p)).abs().max_element();
            let held = samples.iter().map(|s| (parts.value(s.point) - s.value).abs().max_element());
            assert!(held.fold(0.0, f64::max) < 1e-6);
            let between = (1500..3000).map(|i| off(sample(i).point)).fold(0.0, f64::max);
            assert!(between < 0.01, "{method:?} {between}");
            // Corners and sides belong to parts as well.
            assert!(
                [DVec2::ZERO, size, DVec2::new(size.x, 0.2)].into_iter().all(|p| parts.value(p).is_finite())
            );
        }
    }
}
