//! Directions sampled in proportion to intensity.

use glanz_math::DVec2;

use super::distribution::{IntensityDistribution, zonal_integral};

/// Largest number of steps of Newton's method within a bracket.
const STEPS: u32 = 60;

impl IntensityDistribution {
    /// Lumens of each cell between neighbouring angles, by azimuth, then by polar angle.
    ///
    /// If a single plane applies to all azimuths, a cell covers the full circle. Empty if there is a single polar angle.
    #[must_use]
    pub fn cell_fluxes(&self) -> Vec<f64> {
        let steps = self.azimuth_steps();
        let mut fluxes = Vec::with_capacity(steps * self.polar_steps());
        for step in 0..steps {
            for cell in step * self.polar_steps()..(step + 1) * self.polar_steps() {
                let Some(cell) = self.cell(cell) else { continue };
                let [first, second] = cell.fluxes_per_radian();
                fluxes.push(cell.width().to_radians() * 0.5 * (first + second));
            }
        }
        fluxes
    }

    /// Azimuth and polar angle in degrees of a direction in a cell of [`IntensityDistribution::cell_fluxes`], from two uniform
    /// numbers in [0, 1); its density per solid angle is proportional to the intensity. `None` if the cell is dark or does not
    /// exist.
    #[must_use]
    pub fn sample_cell(&self, cell: usize, xi: DVec2) -> Option<[f64; 2]> {
        let cell = self.cell(cell)?;
        let [first, second] = cell.fluxes_per_radian();
        if first + second <= 0.0 {
            return None;
        }
        // The flux per radian of azimuth is linear in the azimuth.
        let u = sample_linear(xi.x, first, second);
        let mix = |[a, b]: [f64; 2]| a * (1.0 - u) + b * u;
        let [low, high] = [mix([cell.low[0], cell.low[1]]), mix([cell.high[0], cell.high[1]])];
        let polar = polar_at_fraction(xi.y, cell.polars.map(f64::to_radians), low, high);
        Some([cell.azimuths[0] + u * cell.width(), polar.to_degrees().clamp(cell.polars[0], cell.polars[1])])
    }

    fn azimuth_steps(&self) -> usize {
        (self.azimuths().len() - 1).max(1)
    }

    fn polar_steps(&self) -> usize {
        self.polars().len() - 1
    }

    fn cell(&self, cell: usize) -> Option<IntensityCell> {
        let steps = self.polar_steps();
        let (i, j) = (cell.checked_div(steps)?, cell.checked_rem(steps)?);
        let alone = self.azimuths().len() == 1;
        let second = if alone { i } else { i + 1 };
        let first_azimuth = *self.azimuths().get(i)?;
        let last_azimuth = if alone { first_azimuth + 360.0 } else { *self.azimuths().get(second)? };
        let value = |plane: usize, j: usize| self.plane(plane).get(j).copied();
        Some(IntensityCell {
            azimuths: [first_azimuth, last_azimuth],
            polars: [*self.polars().get(j)?, *self.polars().get(j + 1)?],
            low: [value(i, j)?, value(second, j)?],
            high: [value(i, j + 1)?, value(second, j + 1)?],
        })
    }
}

/// Directions between two azimuths and two polar angles, degrees, and the intensities at its corners.
struct IntensityCell {
    azimuths: [f64; 2],
    polars: [f64; 2],
    /// Candela at the smaller polar angle, by azimuth.
    low: [f64; 2],
    /// Candela at the larger polar angle, by azimuth.
    high: [f64; 2],
}

impl IntensityCell {
    fn width(&self) -> f64 {
        self.azimuths[1] - self.azimuths[0]
    }

    /// Lumens per radian of azimuth at both azimuths.
    fn fluxes_per_radian(&self) -> [f64; 2] {
        let [a, b] = self.polars.map(f64::to_radians);
        [0, 1].map(|i| zonal_integral(a, b, self.low[i], self.high[i]))
    }
}

/// Inverse at `xi` of the distribution function on [0, 1] whose density is linear from `a` to `b`, both not negative.
fn sample_linear(xi: f64, a: f64, b: f64) -> f64 {
    // The root of a x + (b - a) x^2 / 2 = xi (a + b) / 2, without cancellation.
    let root = (a * a * (1.0 - xi) + b * b * xi).sqrt();
    if a + root <= 0.0 {
        return 0.0;
    }
    (xi * (a + b) / (a + root)).clamp(0.0, 1.0)
}

/// The angle in [a, b], radians, up to which the integral of v sin t is the fraction `xi` of the whole, with v linear from
/// `at_a` to `at_b`.
fn polar_at_fraction(xi: f64, [a, b]: [f64; 2], at_a: f64, at_b: f64) -> f64 {
    let value = |t: f64| at_a + (at_b - at_a) * ((t - a) / (b - a));
    let target = xi * zonal_integral(a, b, at_a, at_b);
    let (mut low, mut high) = (a, b);
    // First guess: the exact result for constant intensity near the axis, where the sine is the angle.
    let mut t = (a * a + xi * (b * b - a * a)).sqrt().clamp(a, b);
    for _ in 0..STEPS {
        let over = zonal_integral(a, t, at_a, value(t)) - target;
        if over > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - over / (value(t) * t.sin());
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= f64::EPSILON * b {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::intensity::{AngularSystem, Symmetry};

    fn uneven() -> IntensityDistribution {
        let (azimuths, polars) = ([0.0, 70.0, 200.0], vec![0.0, 20.0, 90.0, 180.0]);
        let candela = vec![3.0, 1.0, 0.0, 0.0, 3.0, 8.0, 2.0, 0.0, 3.0, 0.0, 0.0, 1.0];
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, &azimuths, polars, candela).unwrap()
    }

    #[test]
    fn fluxes_of_the_cells_sum_to_the_flux() {
        let axial = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::Axial,
            &[0.0],
            vec![0.0, 60.0, 90.0],
            vec![1.0, 1.0, 1.0],
        );
        // A cap of 60 degrees has the solid angle 2 pi (1 - 1/2), so has the rest of the hemisphere.
        for flux in axial.unwrap().cell_fluxes() {
            assert!((flux - PI).abs() < 1e-14);
        }
        let d = uneven();
        let fluxes = d.cell_fluxes();
        assert_eq!(fluxes.len(), 9);
        assert!((fluxes.iter().sum::<f64>() / d.flux() - 1.0).abs() < 1e-14);
    }

    /// Compares the fraction of samples in halves of each cell with the fraction of its flux by the midpoint rule.
    #[test]
    fn samples_are_distributed_as_the_intensity_within_a_cell() {
        let d = uneven();
        for (cell, flux) in (0..).zip(d.cell_fluxes()) {
            let (i, j) = (cell / 3, cell % 3);
            let [a0, a1] = [d.azimuths()[i], d.azimuths()[i + 1]];
            let [p0, p1] = [d.polars()[j], d.polars()[j + 1]];
            let n = 200;
            let middles = |low: f64, high: f64| {
                (0..n).map(move |k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(n))
            };
            // The halves below the middle azimuth and below the middle polar angle.
            let mut expected = [0.0; 2];
            for azimuth in middles(a0, a1) {
                for polar in middles(p0, p1) {
                    let steps = f64::from(n * n);
                    let area = (a1 - a0).to_radians() * (p1 - p0).to_radians() / steps;
                    let light = d.at(azimuth, polar) * polar.to_radians().sin() * area / flux;
                    expected[0] += if 2.0 * azimuth < a0 + a1 { light } else { 0.0 };
                    expected[1] += if 2.0 * polar < p0 + p1 { light } else { 0.0 };
                }
            }
            let mut found = [0.0; 2];
            let count = 64;
            for x in 0..count {
                for y in 0..count {
                    let xi = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / f64::from(count);
                    let Some([azimuth, polar]) = d.sample_cell(cell, xi) else { continue };
                    let one = 1.0 / f64::from(count * count);
                    found[0] += if 2.0 * azimuth < a0 + a1 { one } else { 0.0 };
                    found[1] += if 2.0 * polar < p0 + p1 { one } else { 0.0 };
                    assert!((a0..=a1).contains(&azimuth) && (p0..=p1).contains(&polar));
                }
            }
            if flux > 0.0 {
                // A row or column of samples may fall on either side.
                assert!(
                    (found[0] - expected[0]).abs() < 1.0 / f64::from(count),
                    "{cell}: {found:?} {expected:?}"
                );
                assert!(
                    (found[1] - expected[1]).abs() < 1.0 / f64::from(count),
                    "{cell}: {found:?} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn samples_at_the_dark_border_of_a_cell_lie_in_it() {
        let candela = vec![0.0, 0.0, 1.0, 0.0];
        let d = IntensityDistribution::try_new(
            AngularSystem::A,
            Symmetry::None,
            &[0.0, 9.0],
            vec![0.0, 9.0],
            candela,
        )
        .unwrap();
        for xi in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            let [azimuth, polar] = d.sample_cell(0, xi).unwrap();
            assert!(
                (0.0..=9.0).contains(&azimuth) && (0.0..=9.0).contains(&polar),
                "{xi}: {azimuth} {polar}"
            );
        }
    }

    #[test]
    fn dark_and_missing_cells_give_no_sample() {
        let dark = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::Axial,
            &[0.0],
            vec![0.0, 90.0],
            vec![0.0; 2],
        );
        let dark = dark.unwrap();
        assert_eq!(dark.sample_cell(0, DVec2::splat(0.5)), None);
        assert_eq!(uneven().sample_cell(9, DVec2::splat(0.5)), None);
        let ray =
            IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], vec![0.0], vec![1.0])
                .unwrap();
        assert!(ray.cell_fluxes().is_empty() && ray.sample_cell(0, DVec2::splat(0.5)).is_none());
    }
}
