//! Angles of a far field, chosen by a sample of the light that is to be counted.
//!
//! Gamma and C start with steps of 5 and 15 degrees, which are halved where the intensity bends: where it differs in neighbouring intervals, or
//! in their halves, such that a straight line between the middles of two misses the one between them. This is tested for all light together, and for each eighth of it by
//! the other angle, so that structure is found that the mean over the other angle hides. An interval so small that it would have little light even at the peak is not
//! halved, so that bins have enough particles, nor is one whose bend may be noise. Steps of neighbouring intervals differ by a factor of two at most.

use std::collections::BTreeSet;

use glanz_math::DVec3;

use super::grid::{FarFieldGrid, angles};

/// Halvings of a step: the smallest are 5 / 1024 and 15 / 1024 degrees.
const HALVINGS: u32 = 10;

/// Units of angles: smallest steps per largest step.
const UNITS: u32 = 1 << HALVINGS;

/// Largest second difference of the mean intensities of three intervals, relative to the largest intensity, at which the middle one stays whole. Values
/// differ from the true intensity by about a twelfth of it.
const BEND: f64 = 0.05;

/// Standard errors by which a second difference must exceed 0.
const SIGNIFICANT: f64 = 2.5;

/// Smallest share of all light that an interval that is halved would have, if it were as bright as the brightest one, and the same for an
/// eighth of the light.
const LEAST: f64 = 1.0 / 32.0;
const LEAST_OF_BAND: f64 = 1.0 / 128.0;
const BANDS: usize = 8;

/// Factor on this share at the poles, where one bin has the light of all planes.
const AT_POLE: f64 = 1.0 / 8.0;

/// Smallest number of particles whose variance is trusted.
const LEAST_PARTICLES: usize = 32;

/// Largest numbers of angles, which readers of EULUMDAT files accept, and of bins.
const EULUMDAT_GAMMAS: usize = 361;
const EULUMDAT_PLANES: usize = 720;
const MOST_BINS: usize = 1 << 16;

/// Light of a particle that left the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EscapedLight {
    /// C and gamma, units.
    units: [f64; 2],
    lumens: f64,
}

impl EscapedLight {
    pub(crate) fn new(direction: DVec3, lumens: f64) -> Self {
        let angles = angles(direction);
        let axes = [&C, &GAMMA];
        // The end of an axis belongs to its last interval.
        let units = [0, 1].map(|i| {
            let end = f64::from(axes[i].steps * UNITS);
            (angles[i] / axes[i].degrees * f64::from(UNITS)).min(end.next_down())
        });
        Self { units, lumens }
    }
}

/// One of the two angles.
struct AngleAxis {
    /// Number of largest steps, and their size, degrees.
    steps: u32,
    degrees: f64,
    /// Whether the last interval is a neighbour of the first; otherwise it is its own neighbour, as at the poles.
    is_circle: bool,
    /// Solid angle between two angles, radians, up to a factor.
    extent: fn(f64, f64) -> f64,
}

const C: AngleAxis = AngleAxis { steps: 24, degrees: 15.0, is_circle: true, extent: |a, b| b - a };

const GAMMA: AngleAxis = AngleAxis {
    steps: 36,
    degrees: 5.0,
    is_circle: false,
    // cos a - cos b, without cancellation.
    extent: |a, b| 2.0 * (0.5 * (a + b)).sin() * (0.5 * (b - a)).sin(),
};

impl FarFieldGrid {
    /// The grid for light of which this is a sample.
    pub(crate) fn adapted(light: &[EscapedLight]) -> Self {
        let fits = |grid: &Self| {
            grid.gammas().len() <= EULUMDAT_GAMMAS
                && grid.planes().len() <= EULUMDAT_PLANES
                && grid.bins() <= MOST_BINS
        };
        let adapted = |halvings: u32| {
            let mut planes = C.angles(light, 0, halvings);
            // 360 degrees are 0 degrees.
            planes.pop();
            Self::of(planes, GAMMA.angles(light, 1, halvings))
        };
        (1..=HALVINGS).rev().map(adapted).find(fits).unwrap_or_else(|| adapted(0))
    }
}

impl AngleAxis {
    /// Angles for light by its angle number `own`, degrees, with largest steps that are halved so many times at most.
    fn angles(&self, light: &[EscapedLight], own: usize, halvings: u32) -> Vec<f64> {
        let mut lines: BTreeSet<u32> = (0..=self.steps).map(|step| step * UNITS).collect();
        let all: f64 = light.iter().map(|one| one.lumens).sum();
        let mut sorted = light.to_vec();
        let by =
            |axis: usize| move |a: &EscapedLight, b: &EscapedLight| a.units[axis].total_cmp(&b.units[axis]);
        sorted.sort_by(by(own));
        self.halve(&LightSums::of(&sorted, own), LEAST * all, halvings, &mut lines);
        sorted.sort_by(by(1 - own));
        for band in sorted.chunks_mut(light.len().div_ceil(BANDS).max(1)) {
            band.sort_by(by(own));
            self.halve(&LightSums::of(band, own), LEAST_OF_BAND * all, halvings, &mut lines);
        }
        let unit = self.degrees / f64::from(UNITS);
        self.graded(lines).into_iter().map(|line| f64::from(line) * unit).collect()
    }

    /// Adds the middles of all intervals that are halved, for light of which an interval with less than `least` lumens stays whole.
    fn halve(&self, light: &LightSums, least: f64, halvings: u32, lines: &mut BTreeSet<u32>) {
        let (mut peak, mut width) = (0.0_f64, UNITS);
        let mut starts: Vec<u32> = (0..self.steps).map(|step| step * UNITS).collect();
        while width > UNITS >> halvings && !starts.is_empty() {
            let mean = |start: u32| (start, self.mean(light, start, width));
            let means: Vec<(u32, IntervalMean)> = starts.iter().copied().map(mean).collect();
            let bright = means.iter().filter(|(_, mean)| mean.lumens >= least);
            peak = bright.map(|(_, mean)| mean.intensity).fold(peak, f64::max);
            starts.clear();
            let is_large = |(start, mean): &(u32, IntervalMean)| {
                let is_pole = self.neighbours(*start, width).contains(start);
                let least = least * if is_pole { AT_POLE } else { 1.0 };
                mean.lumens * peak >= least * mean.intensity && mean.particles >= LEAST_PARTICLES
            };
            for (start, _) in means.into_iter().filter(is_large) {
                let (half, middle) = (width / 2, start + width / 2);
                // A step in the middle of the interval bends its halves only.
                let parts = [(start, width), (start, half), (middle, half)];
                if parts.into_iter().any(|(start, width)| self.bends(light, start, width, BEND * peak)) {
                    lines.insert(middle);
                    starts.extend([start, middle]);
                }
            }
            width /= 2;
        }
    }

    /// Whether the second difference of the intensities of an interval and its neighbours, at a pole the first, exceeds `least` and its noise.
    fn bends(&self, light: &LightSums, start: u32, width: u32, least: f64) -> bool {
        let (own, mut second, mut variance) = (self.mean(light, start, width), 0.0, 0.0);
        // An interval at a pole is its own neighbour, without a difference.
        let others = self.neighbours(start, width).into_iter().filter(|&other| other != start);
        let count = others.clone().count() as f64;
        for other in others.map(|other| self.mean(light, other, width)) {
            second += other.intensity - own.intensity;
            variance += other.variance;
        }
        variance += count * count * own.variance;
        second.abs() > least && second.abs() > SIGNIFICANT * variance.sqrt()
    }

    /// Starts of the intervals before and after one.
    fn neighbours(&self, start: u32, width: u32) -> [u32; 2] {
        let end = self.steps * UNITS;
        let (before, after) = (start.checked_sub(width), Some(start + width).filter(|&next| next < end));
        if self.is_circle {
            [before.unwrap_or(end - width), after.unwrap_or(0)]
        } else {
            [before.unwrap_or(start), after.unwrap_or(start)]
        }
    }

    fn mean(&self, light: &LightSums, start: u32, width: u32) -> IntervalMean {
        let unit = (self.degrees / f64::from(UNITS)).to_radians();
        let [from, to] = [start, start + width].map(f64::from);
        let extent = (self.extent)(from * unit, to * unit);
        let [from, to] = [light.below(from), light.below(to)];
        let [lumens, squares] = [0, 1].map(|i| light.sums[to][i] - light.sums[from][i]);
        let (intensity, variance) = (lumens / extent, squares / (extent * extent));
        IntervalMean { particles: to - from, lumens, intensity, variance }
    }

    /// All lines, with more of them where neighbouring intervals differ by more than a factor of two.
    fn graded(&self, lines: BTreeSet<u32>) -> Vec<u32> {
        let mut lines: Vec<u32> = lines.into_iter().collect();
        loop {
            let widths: Vec<u32> = lines.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let last = widths.len() - 1;
            let neighbours = |i: usize| match i {
                0 if self.is_circle => [last, 1],
                0 => [1, 1],
                i if i == last && self.is_circle => [last - 1, 0],
                i if i == last => [last - 1, last - 1],
                i => [i - 1, i + 1],
            };
            let is_wide = |i: &usize| neighbours(*i).iter().any(|&other| widths[*i] > 2 * widths[other]);
            let middles: Vec<u32> =
                (0..widths.len()).filter(is_wide).map(|i| lines[i] + widths[i] / 2).collect();
            if middles.is_empty() {
                return lines;
            }
            lines.extend(middles);
            lines.sort_unstable();
        }
    }
}

/// Mean intensity in an interval, up to a factor, with its variance.
struct IntervalMean {
    particles: usize,
    lumens: f64,
    intensity: f64,
    variance: f64,
}

/// Particles by one of their angles.
struct LightSums {
    /// Ascending.
    units: Vec<f64>,
    /// Sums of the lumens and of their squares of the particles before each one, and of all.
    sums: Vec<[f64; 2]>,
}

impl LightSums {
    /// `light`: ascending by its angle number `own`.
    fn of(light: &[EscapedLight], own: usize) -> Self {
        let mut total = [0.0; 2];
        let mut sums = vec![total];
        sums.extend(light.iter().map(|&EscapedLight { lumens, .. }| {
            total = [total[0] + lumens, total[1] + lumens * lumens];
            total
        }));
        Self { units: light.iter().map(|one| one.units[own]).collect(), sums }
    }

    /// Number of particles below an angle.
    fn below(&self, units: f64) -> usize {
        self.units.partition_point(|&at| at < units)
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::intensity::AngularSystem;

    use super::*;

    const PARTICLES: u32 = 1 << 17;

    /// Light spread evenly over the part of a square around an axis, in its tangent plane, of half width 1, that `shape` accepts, scaled by `size`.
    fn light(axis: DVec3, size: f64, shape: impl Fn(f64, f64) -> bool) -> Vec<EscapedLight> {
        let (side, other) = axis.any_orthonormal_pair();
        // A two-dimensional sequence by the plastic number.
        let square = (0..PARTICLES).map(|i| {
            [0.754_877_666_246_693, 0.569_840_290_998_053]
                .map(|step| 2.0 * (f64::from(i) * step).fract() - 1.0)
        });
        let inside = square.filter(|&[x, y]| shape(x, y));
        inside
            .map(|[x, y]| EscapedLight::new((axis + (side * x + other * y) * size).normalize(), 1.0))
            .collect()
    }

    fn ratios(angles: &[f64], end: f64) -> f64 {
        let closed: Vec<f64> =
            angles.iter().copied().chain((angles.last() != Some(&end)).then_some(end)).collect();
        let steps: Vec<f64> = closed.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.windows(2).map(|pair| (pair[1] / pair[0]).max(pair[0] / pair[1])).fold(0.0, f64::max)
    }

    /// The angles between two, ends included.
    fn between(angles: &[f64], from: f64, to: f64) -> usize {
        angles.iter().filter(|angle| (from..=to).contains(*angle)).count()
    }

    #[test]
    fn grids_are_small_and_their_steps_change_gradually() {
        let disk = |x: f64, y: f64| x * x + y * y < 1.0;
        let tilted = DVec3::new(0.6, 0.2, -0.7).normalize();
        let lights = [
            light(DVec3::NEG_Z, 0.1, disk),
            light(DVec3::Z, 0.001, disk),
            light(tilted, 0.02, disk),
            // A single direction, and 32 beams all over the sphere.
            light(tilted, 0.0, disk),
            (0..32)
                .flat_map(|i| {
                    let (sin, cos) = f64::from(i * i).sin_cos();
                    let z = f64::from(i) / 16.0 - 0.97;
                    light(DVec3::new(cos, sin, z).normalize(), 0.003, |x, y| disk(x, y) && x > 0.0)
                })
                .collect(),
        ];
        for light in lights {
            let grid = FarFieldGrid::adapted(&light);
            assert!(
                grid.bins() <= MOST_BINS
                    && grid.gammas().len() <= EULUMDAT_GAMMAS
                    && grid.planes().len() <= EULUMDAT_PLANES
            );
            assert!(ratios(grid.gammas(), 180.0) <= 2.0 && ratios(grid.planes(), 360.0) <= 2.0);
            let across_zero =
                [&grid.planes()[grid.planes().len() - 2..], &[360.0, 360.0 + grid.planes()[1]]].concat();
            assert!(ratios(&across_zero, across_zero[3]) <= 2.0 && grid.gammas().len() >= 50, "{grid:?}");
        }
        assert_eq!(FarFieldGrid::adapted(&[]), FarFieldGrid::try_new(24, 36).unwrap());
        // Exactly at the poles.
        for pole in [DVec3::NEG_Z, DVec3::Z] {
            let grid = FarFieldGrid::adapted(&vec![EscapedLight::new(pole, 1.0); 1000]);
            let least = grid.gammas().windows(2).map(|pair| pair[1] - pair[0]).fold(180.0, f64::min);
            assert!(least < 0.01, "{pole}: {least}");
        }
    }

    #[test]
    fn square_beams_have_more_planes_and_round_ones_more_gammas() {
        // 0.1 in the tangent plane are 5.7 degrees; the corners of the square are at 8.1.
        let round = FarFieldGrid::adapted(&light(DVec3::NEG_Z, 0.1, |x, y| x * x + y * y < 1.0));
        assert_eq!(round.planes().len(), 24);
        assert!((10..40).contains(&between(round.gammas(), 0.0, 7.0)), "{:?}", round.gammas());
        assert!(between(round.gammas(), 20.0, 180.0) < 36, "{:?}", round.gammas());
        let square = FarFieldGrid::adapted(&light(DVec3::NEG_Z, 0.1, |_, _| true));
        assert!(square.planes().len() >= 48, "{:?}", square.planes());
    }

    #[test]
    fn tilted_beams_have_fine_angles_around_their_axis_only() {
        let axis = AngularSystem::C.direction(200.0, 60.0);
        let grid = FarFieldGrid::adapted(&light(axis, 0.02, |x, y| x * x + y * y < 1.0));
        // 0.02 are 1.15 degrees of gamma and 1.32 of C.
        assert!(between(grid.gammas(), 58.85, 61.15) >= 12, "{:?}", grid.gammas());
        assert!(between(grid.planes(), 198.68, 201.32) >= 12, "{:?}", grid.planes());
        assert!(between(grid.gammas(), 0.0, 50.0) <= 11 && between(grid.planes(), 0.0, 180.0) <= 13);
    }
}
