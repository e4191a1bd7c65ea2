//! Directions by which escaped light is counted.

use std::f64::consts::TAU;

use glanz_light::intensity::{AngularSystem, zonal_integral};
use glanz_math::DVec3;

/// Largest numbers of planes and of gamma angles.
const MOST_PLANES: usize = 3600;
const MOST_GAMMAS: usize = 1801;

/// A step of angles, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleStep(f64);

/// A step out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("step is {0} degrees; it must be from 0.1 to 90 degrees")]
pub struct AngleStepError(pub f64);

impl AngleStep {
    /// A step of `degrees`.
    ///
    /// # Errors
    /// [`AngleStepError`] if it is not from 0.1 to 90.
    pub fn try_new(degrees: f64) -> Result<Self, AngleStepError> {
        if (0.1..=90.0).contains(&degrees) { Ok(Self(degrees)) } else { Err(AngleStepError(degrees)) }
    }

    /// The step in degrees.
    #[must_use]
    pub fn degrees(self) -> f64 {
        self.0
    }

    /// Smallest number of equal steps in `whole` degrees that are at most this one.
    fn count(self, whole: u32) -> u32 {
        // A step that divides the whole but for its decimal fraction counts as dividing it.
        let rounding = 4.0 * f64::EPSILON * f64::from(whole);
        (f64::from(whole) / self.0 * (1.0 - rounding)).ceil() as u32
    }
}

/// Directions about an axis in C-planes and gamma angles.
///
/// The frame is that of a luminaire: gamma is measured from -z, C about z from +x to +y. A bin belongs to a pair of angles and its hat
/// function, see [`super`]; at gamma 0 and 180 degrees all planes share one.
#[derive(Clone, Debug, PartialEq)]
pub struct FarFieldGrid {
    /// Degrees.
    planes: Vec<f64>,
    gammas: Vec<f64>,
    /// Integrals of the hat functions: of the planes over C, radians, and of the gamma angles over the cosine.
    widths: Vec<f64>,
    zones: Vec<f64>,
}

impl FarFieldGrid {
    /// Equal steps. `None` unless there are 1 to 3600 planes and 1 to 1800 steps of gamma.
    #[must_use]
    pub fn try_new(planes: u32, gamma_steps: u32) -> Option<Self> {
        if planes as usize > MOST_PLANES || gamma_steps as usize >= MOST_GAMMAS {
            return None;
        }
        let part = |whole: f64, number: u32, count: u32| whole * f64::from(number) / f64::from(count);
        let gammas = (0..=gamma_steps).map(|j| part(180.0, j, gamma_steps)).collect();
        Self::from_angles((0..planes).map(|i| part(360.0, i, planes)).collect(), gammas)
    }

    /// Equal steps that are at most these.
    #[must_use]
    pub fn with_steps(gamma: AngleStep, plane: AngleStep) -> Option<Self> {
        Self::try_new(plane.count(360), gamma.count(180))
    }

    /// The directions of these angles, degrees. `None` unless there are 1 to 3600 planes, ascending from 0 and below 360, and 2 to 1801 gamma
    /// angles, ascending from 0 to 180.
    #[must_use]
    pub fn from_angles(planes: Vec<f64>, gammas: Vec<f64>) -> Option<Self> {
        let ascend = |angles: &[f64]| angles.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = |angles: &[f64]| Some([*angles.first()?, *angles.last()?]);
        let [first, last] = ends(&planes)?;
        let fits = ascend(&planes) && ascend(&gammas) && first == 0.0 && last < 360.0;
        if !fits || ends(&gammas)? != [0.0, 180.0] || planes.len() > MOST_PLANES || gammas.len() > MOST_GAMMAS
        {
            return None;
        }
        Some(Self::of(planes, gammas))
    }

    /// As [`FarFieldGrid::from_angles`], of angles that fit.
    pub(super) fn of(planes: Vec<f64>, gammas: Vec<f64>) -> Self {
        let next = planes.iter().skip(1).copied().chain([360.0]);
        let steps: Vec<f64> = planes.iter().zip(next).map(|(from, to)| (to - from).to_radians()).collect();
        let widths = (0..steps.len()).map(|i| 0.5 * (steps[i] + steps[(i + steps.len() - 1) % steps.len()]));
        let widths: Vec<f64> = widths.collect();
        let mut zones = vec![0.0; gammas.len()];
        for (j, pair) in gammas.windows(2).enumerate() {
            let [a, b] = [pair[0].to_radians(), pair[1].to_radians()];
            zones[j] += zonal_integral(a, b, 1.0, 0.0);
            zones[j + 1] += zonal_integral(a, b, 0.0, 1.0);
        }
        Self { planes, gammas, widths, zones }
    }

    /// Number of bins: all planes at every gamma but the two poles, which have one each.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.planes.len() * (self.gammas.len() - 2) + 2
    }

    /// C angles, degrees.
    #[must_use]
    pub fn planes(&self) -> &[f64] {
        &self.planes
    }

    /// Gamma angles, degrees.
    #[must_use]
    pub fn gammas(&self) -> &[f64] {
        &self.gammas
    }

    /// The bin of a plane and a gamma angle by their numbers.
    #[must_use]
    pub fn bin_of(&self, plane: usize, gamma: usize) -> usize {
        match gamma {
            0 => 0,
            gamma if gamma + 1 >= self.gammas.len() => self.bins() - 1,
            gamma => 1 + (gamma - 1) * self.planes.len() + plane % self.planes.len(),
        }
    }

    /// The bins around a direction of length 1, with the values of their hat functions there, which add up to 1; bins with the value 0
    /// have no meaning.
    #[must_use]
    pub fn weights(&self, direction: DVec3) -> [(usize, f64); 4] {
        let [azimuth, polar] = angles(direction);
        let (i, u) = interval(&self.planes, 360.0, azimuth);
        let (j, v) = interval(&self.gammas, 180.0, polar);
        let mut weights = [(0, 0.0); 4];
        for (pair, (gamma, weight)) in weights.chunks_exact_mut(2).zip([(j, 1.0 - v), (j + 1, v)]) {
            // At a pole both planes have the same bin, which counts once.
            let is_pole = gamma == 0 || gamma + 1 >= self.gammas.len();
            let shares = if is_pole { [1.0, 0.0] } else { [1.0 - u, u] };
            for (k, (slot, share)) in pair.iter_mut().zip(shares).enumerate() {
                *slot = (self.bin_of(i + k, gamma), weight * share);
            }
        }
        weights
    }

    /// Integral of the hat function of a bin over all directions, sr.
    #[must_use]
    pub fn solid_angle(&self, bin: usize) -> f64 {
        let count = self.planes.len();
        let zone = |gamma: usize| self.zones.get(gamma).copied().unwrap_or(0.0);
        match bin {
            0 => TAU * zone(0),
            bin if bin + 1 >= self.bins() => TAU * zone(self.gammas.len() - 1),
            bin => zone(1 + (bin - 1) / count) * self.widths.get((bin - 1) % count).copied().unwrap_or(0.0),
        }
    }
}

/// C from 0 to 360 and gamma of a direction, degrees.
pub(super) fn angles(direction: DVec3) -> [f64; 2] {
    let [azimuth, polar] = AngularSystem::C.angles(direction);
    [azimuth.rem_euclid(360.0), polar]
}

/// The interval of ascending angles, the last of which ends at `end`, that holds `angle`, and its position there from 0 to 1.
fn interval(angles: &[f64], end: f64, angle: f64) -> (usize, f64) {
    let i = angles.partition_point(|&a| a <= angle).clamp(1, angles.len()) - 1;
    // An angle at the end of the list that is itself the end belongs to the interval before.
    let i = if angles.get(i).is_some_and(|&a| a >= end) { i.saturating_sub(1) } else { i };
    let from = angles.get(i).copied().unwrap_or(0.0);
    let to = angles.get(i + 1).copied().unwrap_or(end);
    (i, ((angle - from) / (to - from)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn uneven() -> FarFieldGrid {
        FarFieldGrid::from_angles(vec![0.0, 20.0, 30.0, 200.0], vec![0.0, 0.25, 1.0, 40.0, 90.0, 180.0])
            .unwrap()
    }

    /// Directions spread over the sphere, by the golden angle.
    fn directions(count: u32) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        })
    }

    #[test]
    fn hats_fill_the_sphere_and_have_their_solid_angles() {
        let grids = [(1, 1), (1, 18), (24, 36), (7, 5)].map(|(c, g)| FarFieldGrid::try_new(c, g).unwrap());
        for grid in grids.into_iter().chain([uneven()]) {
            let all: f64 = (0..grid.bins()).map(|bin| grid.solid_angle(bin)).sum();
            assert!((all - 4.0 * PI).abs() < 1e-12, "{all}");
            // The integral of every hat, by the mean over many directions.
            let count = 400_000;
            let mut sums = vec![0.0; grid.bins()];
            for direction in directions(count) {
                let weights = grid.weights(direction);
                let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
                assert!((total - 1.0).abs() < 1e-12 && weights.iter().all(|(_, weight)| *weight >= 0.0));
                weights.iter().for_each(|(bin, weight)| sums[*bin] += weight);
            }
            for (bin, sum) in sums.iter().enumerate() {
                let found = sum * 4.0 * PI / f64::from(count);
                let expected = grid.solid_angle(bin);
                assert!((found - expected).abs() < 1e-4 + 0.01 * expected, "{bin}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn directions_at_the_angles_of_a_bin_are_counted_in_it() {
        let grid = uneven();
        for (i, c) in grid.planes().iter().enumerate() {
            for (j, gamma) in grid.gammas().iter().enumerate() {
                let weights = grid.weights(AngularSystem::C.direction(*c, *gamma));
                let own: f64 =
                    weights.iter().filter(|(bin, _)| *bin == grid.bin_of(i, j)).map(|(_, w)| w).sum();
                assert!((own - 1.0).abs() < 1e-10, "C {c} gamma {gamma}: {weights:?}");
            }
        }
        // Between the last plane and the first, 280 degrees: half of the light in each.
        let weights = grid.weights(AngularSystem::C.direction(280.0, 90.0));
        for plane in [0, 3] {
            let own: f64 =
                weights.iter().filter(|(bin, _)| *bin == grid.bin_of(plane, 4)).map(|(_, w)| w).sum();
            assert!((own - 0.5).abs() < 1e-10, "{weights:?}");
        }
    }

    #[test]
    fn impossible_angles_are_refused() {
        assert_eq!(FarFieldGrid::try_new(0, 4), None);
        assert_eq!(FarFieldGrid::try_new(4, 0), None);
        assert_eq!(FarFieldGrid::try_new(4, 1801), None);
        for (planes, gammas) in [
            (vec![1.0], vec![0.0, 180.0]),
            (vec![0.0, 360.0], vec![0.0, 180.0]),
            (vec![0.0, 0.0], vec![0.0, 180.0]),
            (vec![0.0], vec![0.0, 90.0]),
            (vec![0.0], vec![0.0, f64::NAN, 180.0]),
            (vec![0.0], vec![]),
        ] {
            assert_eq!(FarFieldGrid::from_angles(planes, gammas), None);
        }
        for degrees in [0.0, -1.0, 0.09, 91.0, f64::NAN, f64::INFINITY] {
            assert!(AngleStep::try_new(degrees).is_err());
        }
    }

    #[test]
    fn steps_are_at_most_as_wide_as_asked_for() {
        let counts = |gamma: f64, plane: f64| {
            let [gamma, plane] = [gamma, plane].map(|degrees| AngleStep::try_new(degrees).unwrap());
            let grid = FarFieldGrid::with_steps(gamma, plane).unwrap();
            (grid.gammas().len() - 1, grid.planes().len())
        };
        assert_eq!(counts(5.0, 15.0), (36, 24));
        assert_eq!(counts(0.1, 0.1), (1800, 3600));
        assert_eq!(counts(0.7, 50.0), (258, 8));
        assert_eq!(counts(90.0, 90.0), (2, 4));
    }
}
