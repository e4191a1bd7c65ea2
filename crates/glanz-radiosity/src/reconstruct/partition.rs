//! Interpolation of many samples by a partition of unity.

use glanz_math::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Interpolant, Interpolation, ReconstructError, Sample};

/// Largest number of samples of a part, without those that it shares with its neighbours.
const MAX_SAMPLES: usize = 256;

/// Overlap of a part with its neighbours, relative to its size.
const OVERLAP: f64 = 0.25;

/// Weighted mean of the interpolants of overlapping parts: the systems of equations have the size of a part, and samples are still
/// interpolated, because all parts that contain one agree on its value.
struct Partition {
    parts: Vec<InterpolatedPart>,
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

/// As [`Interpolation::of_samples_within`], for any number of samples: the time grows linearly with their number.
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
    divide(points, [DVec2::ZERO, size], &mut rectangles);
    let part = |&[low, high]: &[DVec2; 2]| {
        let reach = OVERLAP * (high - low);
        let (min, max) = (low - reach, high + reach);
        let is_inside = |s: &&Sample| s.point.cmpge(min).all() && s.point.cmple(max).all();
        let samples: Vec<Sample> = samples.iter().filter(is_inside).copied().collect();
        Ok(InterpolatedPart { min, max, interpolant: method.of_samples_within(&samples, size)? })
    };
    let parts = rectangles.par_iter().map(part).collect::<Result<_, ReconstructError>>()?;
    Ok(Box::new(Partition { parts }))
}

/// Divides a rectangle across its longer side at the median of the points until each part has at most [`MAX_SAMPLES`] of them.
fn divide(mut points: Vec<DVec2>, [low, high]: [DVec2; 2], rectangles: &mut Vec<[DVec2; 2]>) {
    if points.len() <= MAX_SAMPLES {
        return rectangles.push([low, high]);
    }
    let axis = usize::from(high.y - low.y > high.x - low.x);
    points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    let mut middle = points.get(points.len() / 2).map_or(low[axis], |point| point[axis]);
    // Where most samples are on one side of the rectangle, it is halved instead.
    if middle <= low[axis] || middle >= high[axis] {
        middle = 0.5 * (low[axis] + high[axis]);
    }
    if middle <= low[axis] || middle >= high[axis] {
        return rectangles.push([low, high]);
    }
    let above = points.split_off(points.partition_point(|point| point[axis] < middle));
    let (mut end, mut begin) = (high, low);
    (end[axis], begin[axis]) = (middle, middle);
    divide(points, [low, end], rectangles);
    divide(above, [begin, high], rectangles);
}

impl Interpolant for Partition {
    fn value(&self, point: DVec2) -> DVec3 {
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for part in &self.parts {
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
