//! Luminous intensity of a whole optic in the far field.

use std::f64::consts::{PI, TAU};

use glanz_math::DVec3;

/// Directions about an axis in C-planes and gamma angles, both in equal steps.
///
/// The frame is that of a luminaire: gamma is measured from -z, C about z from +x to +y. A value represents the directions nearest to
/// (C, gamma); at gamma 0 and 180 degrees all planes share one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FarFieldGrid {
    planes: u32,
    /// Steps between gamma 0 and 180 degrees.
    steps: u32,
}

/// Intensities on a [`FarFieldGrid`].
#[derive(Clone, Debug, PartialEq)]
pub struct FarField {
    /// The directions.
    pub grid: FarFieldGrid,
    /// Luminous intensities by bin, cd.
    pub candela: Vec<f64>,
    /// Their standard errors, cd.
    pub errors: Vec<f64>,
}

impl FarFieldGrid {
    /// `None` unless there are 1 to 3600 planes and 1 to 1800 steps of gamma.
    #[must_use]
    pub fn try_new(planes: u32, gamma_steps: u32) -> Option<Self> {
        let ok = (1..=3600).contains(&planes) && (1..=1800).contains(&gamma_steps);
        ok.then_some(Self { planes, steps: gamma_steps })
    }

    /// Number of bins: all planes at every gamma but the two poles, which have one each.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.planes as usize * (self.steps as usize - 1) + 2
    }

    /// Number of planes, and of steps between gamma 0 and 180 degrees.
    pub(crate) fn counts(&self) -> [u32; 2] {
        [self.planes, self.steps]
    }

    /// C angles, degrees.
    #[must_use]
    pub fn planes(&self) -> Vec<f64> {
        (0..self.planes).map(|i| 360.0 * f64::from(i) / f64::from(self.planes)).collect()
    }

    /// Gamma angles, degrees.
    #[must_use]
    pub fn gammas(&self) -> Vec<f64> {
        (0..=self.steps).map(|j| 180.0 * f64::from(j) / f64::from(self.steps)).collect()
    }

    /// The bin of a plane and a gamma angle by their numbers.
    #[must_use]
    pub fn bin_of(&self, plane: usize, gamma: usize) -> usize {
        match gamma {
            0 => 0,
            gamma if gamma >= self.steps as usize => self.bins() - 1,
            gamma => 1 + (gamma - 1) * self.planes as usize + plane % self.planes as usize,
        }
    }

    /// The bin of a direction of length 1.
    #[must_use]
    pub fn bin(&self, direction: DVec3) -> usize {
        let gamma = direction.truncate().length().atan2(-direction.z) / PI;
        let azimuth = direction.y.atan2(direction.x) / TAU;
        let step = (gamma * f64::from(self.steps)).round() as usize;
        let plane = (azimuth.rem_euclid(1.0) * f64::from(self.planes)).round() as usize;
        self.bin_of(plane, step)
    }

    /// Solid angle of a bin, sr.
    #[must_use]
    pub fn solid_angle(&self, bin: usize) -> f64 {
        let half = 0.5 * PI / f64::from(self.steps);
        if bin == 0 || bin + 1 == self.bins() {
            // 1 - cos, without cancellation.
            return TAU * 2.0 * (0.5 * half).sin().powi(2);
        }
        let step = (bin - 1) / self.planes as usize + 1;
        let middle = 2.0 * half * step as f64;
        TAU / f64::from(self.planes) * 2.0 * middle.sin() * half.sin()
    }
}

impl FarField {
    /// Intensity at the direction of a plane and a gamma angle by their numbers, cd.
    #[must_use]
    pub fn at(&self, plane: usize, gamma: usize) -> f64 {
        self.candela.get(self.grid.bin_of(plane, gamma)).copied().unwrap_or_default()
    }

    /// Emitted flux, lm.
    #[must_use]
    pub fn flux(&self) -> f64 {
        self.candela.iter().enumerate().map(|(bin, candela)| candela * self.grid.solid_angle(bin)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_fill_the_sphere() {
        for (planes, steps) in [(1, 1), (1, 18), (24, 36), (7, 5)] {
            let grid = FarFieldGrid::try_new(planes, steps).unwrap();
            let all: f64 = (0..grid.bins()).map(|bin| grid.solid_angle(bin)).sum();
            assert!((all - 4.0 * PI).abs() < 1e-12, "{planes} {steps}: {all}");
        }
        assert_eq!(FarFieldGrid::try_new(0, 4), None);
        assert_eq!(FarFieldGrid::try_new(4, 1801), None);
    }

    #[test]
    fn directions_fall_into_the_bins_of_their_angles() {
        let grid = FarFieldGrid::try_new(4, 4).unwrap();
        let bin = |x: f64, y: f64, z: f64| grid.bin(DVec3::new(x, y, z).normalize());
        assert_eq!(bin(0.0, 0.0, -1.0), 0);
        assert_eq!(bin(0.1, 0.1, 1.0), grid.bins() - 1);
        // Gamma 90: C 0 is +x, C 90 is +y; just before 360 degrees it is C 0 again.
        assert_eq!(bin(1.0, 0.0, 0.0), grid.bin_of(0, 2));
        assert_eq!(bin(0.0, 1.0, 0.0), grid.bin_of(1, 2));
        assert_eq!(bin(1.0, -0.1, 0.0), grid.bin_of(0, 2));
        assert_eq!(bin(-1.0, 0.0, -1.0), grid.bin_of(2, 1));
    }
}
