//! Luminous intensity over directions.

use std::f64::consts::TAU;

use glanz_math::DVec3;

/// Why numbers are no distribution of intensities.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntensityError {
    /// There are no angles of one kind.
    #[error("there are no {0}s")]
    Empty(&'static str),
    /// An angle out of its range or order.
    #[error("{what} {second} follows {first}; they must ascend, {allowed}")]
    Angles {
        /// Which angles.
        what: &'static str,
        /// One angle in degrees.
        first: f64,
        /// The next, or the same if it alone is at fault.
        second: f64,
        /// Where they may lie.
        allowed: &'static str,
    },
    /// Another number of intensities than directions.
    #[error("there are {found} intensities for {azimuths} azimuths and {polars} polar angles")]
    Count {
        /// Intensities.
        found: usize,
        /// Azimuths.
        azimuths: usize,
        /// Polar angles.
        polars: usize,
    },
    /// An intensity that is negative or no finite number.
    #[error("intensity number {index} is {value} cd, it must be finite and not negative")]
    Intensity {
        /// Its index.
        index: usize,
        /// Candela.
        value: f64,
    },
}

/// How the goniophotometer turned; see the table in [`super`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngularSystem {
    /// Planes share a vertical axis, angles count from the horizontal; headlamps and signals.
    A,
    /// Planes share a horizontal axis; floodlights.
    B,
    /// Planes share a vertical axis, angles count from straight down; nearly everything else.
    C,
}

/// What the file left out because it follows from the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Nothing.
    None,
    /// All planes are alike.
    Axial,
    /// Alike on both sides of the plane y = 0 (C0-C180).
    AcrossY,
    /// Alike on both sides of the plane x = 0 (C90-C270).
    AcrossX,
    /// Alike on both sides of both planes.
    Quadrants,
}

/// Luminous intensities in candela on a grid of directions around an axis.
///
/// A direction has an azimuth about the axis and a polar angle from it, both in degrees. For type C these are C and
/// gamma, about -z; for type A horizontal angle and vertical angle + 90, about -z; for type B vertical angle and
/// horizontal angle + 90, about +y. Symmetry is unfolded. Between the angles the intensity is bilinear, outside them
/// zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    system: AngularSystem,
    symmetry: Symmetry,
    /// Strictly ascending; the last is the first + 360 if the planes go round; a single one stands for all.
    azimuths: Vec<f64>,
    /// For each azimuth its row in `candela`.
    rows: Vec<usize>,
    /// Strictly ascending, within [0, 180].
    polars: Vec<f64>,
    /// Row by row.
    candela: Vec<f64>,
}

/// An angle computed from a direction is off by a few roundings of a number up to 360 degrees; this many degrees
/// beyond the last angle of the grid still count as on it.
const ROUNDING: f64 = 8.0 * 360.0 * f64::EPSILON;

impl Distribution {
    /// `azimuths`: of the rows of `candela`, in degrees, as measured; for types A and C `symmetry` adds the others. Those of types A and B
    /// ascend. `polars`: degrees, ascending, within [0, 180]. `candela`: row by row, one value for each pair of angles.
    ///
    /// # Errors
    /// [`IntensityError`] for numbers that are not so.
    pub fn try_new(
        system: AngularSystem,
        symmetry: Symmetry,
        azimuths: &[f64],
        polars: Vec<f64>,
        candela: Vec<f64>,
    ) -> Result<Self, IntensityError> {
        check(system, azimuths, &polars, &candela)?;
        let (azimuths, rows) = unfold(system, symmetry, azimuths);
        Ok(Self { system, symmetry, azimuths, rows, polars, candela })
    }

    /// How the goniophotometer turned.
    #[must_use]
    pub fn system(&self) -> AngularSystem {
        self.system
    }

    /// What the file left out.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Azimuths of the planes in degrees, ascending, symmetry unfolded; with the first one again, 360 degrees on,
    /// where they go all round. A single one stands for all.
    #[must_use]
    pub fn azimuths(&self) -> &[f64] {
        &self.azimuths
    }

    /// Polar angles in degrees, ascending.
    #[must_use]
    pub fn polars(&self) -> &[f64] {
        &self.polars
    }

    /// Intensities in candela of the plane of an azimuth, one per polar angle; empty beyond the last plane.
    #[must_use]
    pub fn plane(&self, azimuth: usize) -> &[f64] {
        let n = self.polars.len();
        let row = self.rows.get(azimuth).and_then(|&r| self.candela.get(r * n..(r + 1) * n));
        row.unwrap_or_default()
    }

    /// The largest intensity in candela.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.candela.iter().copied().fold(0.0, f64::max)
    }

    /// Candela at angles in degrees.
    #[must_use]
    pub fn at(&self, azimuth: f64, polar: f64) -> f64 {
        let Some((j, v)) = cell(&self.polars, polar) else { return 0.0 };
        let in_plane = |plane: usize| {
            let plane = self.plane(plane);
            let value = |k: usize| plane.get(k).copied().unwrap_or(0.0);
            // Written so that a grid point gives its own value, whatever stands beside it.
            if v == 0.0 { value(j) } else { value(j) * (1.0 - v) + value(j + 1) * v }
        };
        if self.azimuths.len() == 1 {
            return in_plane(0);
        }
        let Some((i, u)) = cell(&self.azimuths, self.turned(azimuth)) else { return 0.0 };
        if u == 0.0 { in_plane(i) } else { in_plane(i) * (1.0 - u) + in_plane(i + 1) * u }
    }

    /// Candela in a direction of any length in the luminaire's frame; 0 for no direction.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> f64 {
        let (pole, zero, ninety) = self.axes();
        let (x, y) = (direction.dot(zero), direction.dot(ninety));
        let polar = x.hypot(y).atan2(direction.dot(pole)).to_degrees();
        if !(polar.is_finite() && direction.length_squared() > 0.0) {
            return 0.0;
        }
        self.at(y.atan2(x).to_degrees(), polar)
    }

    /// The direction of length 1 of angles in degrees.
    #[must_use]
    pub fn direction(&self, azimuth: f64, polar: f64) -> DVec3 {
        let (pole, zero, ninety) = self.axes();
        let ((sin, cos), (sin_a, cos_a)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        pole * cos + (zero * cos_a + ninety * sin_a) * sin
    }

    /// Lumens: the integral of the interpolated intensity over all directions, exact but for roundings.
    #[must_use]
    pub fn flux(&self) -> f64 {
        let of_plane = |i: usize| -> f64 {
            let pairs = self.polars.windows(2).zip(self.plane(i).windows(2));
            pairs.map(|(t, v)| band(t[0].to_radians(), t[1].to_radians(), v[0], v[1])).sum()
        };
        if self.azimuths.len() == 1 {
            return TAU * of_plane(0);
        }
        // Linear in azimuth: the trapezoidal rule is exact.
        let steps = self.azimuths.windows(2).enumerate();
        steps.map(|(i, a)| (a[1] - a[0]).to_radians() * 0.5 * (of_plane(i) + of_plane(i + 1))).sum()
    }

    /// The same with all intensities times `factor`; `None` if one would be negative or no finite number.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        let mut scaled = self.clone();
        for value in &mut scaled.candela {
            *value *= factor;
        }
        let holds = |value: &f64| value.is_finite() && *value >= 0.0;
        scaled.candela.iter().all(holds).then_some(scaled)
    }

    /// The axis and the directions of azimuth 0 and 90 at polar angle 90.
    fn axes(&self) -> (DVec3, DVec3, DVec3) {
        match self.system {
            // Horizontal angles count counterclockwise seen from above for type C, clockwise for A and B.
            AngularSystem::C => (DVec3::NEG_Z, DVec3::X, DVec3::Y),
            AngularSystem::A => (DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
            AngularSystem::B => (DVec3::Y, DVec3::NEG_Z, DVec3::X),
        }
    }

    /// The azimuth with full turns added or taken away so that it lies among the planes if it can.
    fn turned(&self, azimuth: f64) -> f64 {
        let first = self.azimuths.first().copied().unwrap_or(0.0);
        if (first - ROUNDING..first + 360.0).contains(&azimuth) {
            return azimuth;
        }
        first + (azimuth - first).rem_euclid(360.0)
    }
}

fn check(
    system: AngularSystem,
    azimuths: &[f64],
    polars: &[f64],
    candela: &[f64],
) -> Result<(), IntensityError> {
    for (what, angles, allowed, low, high, sorted) in [
        // Symmetry puts those of type C in order.
        ("azimuth", azimuths, "finite", -f64::MAX, f64::MAX, system != AngularSystem::C),
        ("polar angle", polars, "within [0, 180]", 0.0, 180.0, true),
    ] {
        if angles.is_empty() {
            return Err(IntensityError::Empty(what));
        }
        if let Some(&angle) = angles.iter().find(|angle| !(low..=high).contains(*angle)) {
            return Err(IntensityError::Angles { what, first: angle, second: angle, allowed });
        }
        if let Some(pair) = angles.windows(2).find(|pair| sorted && pair[0] >= pair[1]) {
            return Err(IntensityError::Angles { what, first: pair[0], second: pair[1], allowed });
        }
    }
    if candela.len() != azimuths.len() * polars.len() {
        let (azimuths, polars) = (azimuths.len(), polars.len());
        return Err(IntensityError::Count { found: candela.len(), azimuths, polars });
    }
    match candela.iter().zip(0..).find(|(value, _)| !(value.is_finite() && **value >= 0.0)) {
        Some((&value, index)) => Err(IntensityError::Intensity { index, value }),
        None => Ok(()),
    }
}

/// The index and position in [0, 1) of an angle among ascending ones; `None` outside them.
fn cell(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    let (first, last) = (*angles.first()?, *angles.last()?);
    if !(first - ROUNDING..=last + ROUNDING).contains(&angle) {
        return None;
    }
    let angle = angle.clamp(first, last);
    let i = angles.partition_point(|&a| a <= angle).checked_sub(1)?;
    match angles.get(i..i + 2) {
        Some(pair) => Some((i, (angle - pair[0]) / (pair[1] - pair[0]))),
        None => Some((i, 0.0)),
    }
}

/// The integral of v sin t over [a, b], in radians, where v goes linearly from `at_a` to `at_b`.
pub(super) fn band(a: f64, b: f64, at_a: f64, at_b: f64) -> f64 {
    let half = 0.5 * (b - a);
    let middle = 0.5 * (a + b);
    // cos a - cos b and (sin b - sin a) / (b - a), without cancellation between near angles.
    let whole = 2.0 * middle.sin() * half.sin();
    let mean_cos = middle.cos() * if half == 0.0 { 1.0 } else { half.sin() / half };
    let of_b = mean_cos - b.cos();
    at_a * (whole - of_b) + at_b * of_b
}

/// All azimuths that symmetry gives, and the row of each.
fn unfold(system: AngularSystem, symmetry: Symmetry, measured: &[f64]) -> (Vec<f64>, Vec<usize>) {
    if system != AngularSystem::C {
        // Types A and B reach from -90 to 90; only A has its mirrored angle as azimuth.
        let mut planes: Vec<(f64, usize)> = measured.iter().copied().zip(0..).collect();
        if system == AngularSystem::A && symmetry == Symmetry::AcrossY {
            let mirrored = planes.iter().filter(|(a, _)| *a > 0.0).map(|&(a, row)| (-a, row));
            planes = mirrored.rev().chain(planes.iter().copied()).collect();
        }
        return planes.into_iter().unzip();
    }
    if symmetry == Symmetry::Axial {
        return (vec![0.0], vec![0]);
    }
    let mirrors: &[fn(f64) -> f64] = match symmetry {
        Symmetry::None | Symmetry::Axial => &[|a| a],
        Symmetry::AcrossY => &[|a| a, |a| -a],
        Symmetry::AcrossX => &[|a| a, |a| 180.0 - a],
        Symmetry::Quadrants => &[|a| a, |a| -a, |a| 180.0 - a, |a| 180.0 + a],
    };
    let mirrored =
        mirrors.iter().flat_map(|mirror| measured.iter().zip(0..).map(|(&a, row)| (mirror(a), row)));
    // Adding 0 turns -0 to 0.
    let mut planes: Vec<(f64, usize)> = mirrored.map(|(a, row)| (a.rem_euclid(360.0) + 0.0, row)).collect();
    planes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    planes.dedup_by(|a, b| a.0 - b.0 <= ROUNDING);
    if let Some(&(first, row)) = planes.first() {
        if planes.last().is_some_and(|&(last, _)| planes.len() > 1 && first + 360.0 - last <= ROUNDING) {
            planes.pop();
        }
        planes.push((first + 360.0, row));
    }
    planes.into_iter().unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn degrees(from: f64, to: f64, steps: usize) -> Vec<f64> {
        (0..=steps).map(|i| from + (to - from) * i as f64 / steps as f64).collect()
    }

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{a} against {b}");
    }

    #[test]
    fn equal_intensity_everywhere_gives_four_pi_in_every_system() {
        for (system, azimuths, expected) in [
            (AngularSystem::C, degrees(0.0, 360.0, 7), 4.0 * PI),
            (AngularSystem::C, vec![0.0, 17.0, 359.0], 4.0 * PI),
            (AngularSystem::A, degrees(-90.0, 90.0, 6), 2.0 * PI),
            (AngularSystem::B, degrees(-90.0, 90.0, 5), 2.0 * PI),
        ] {
            let polars = degrees(0.0, 180.0, 9);
            let count = azimuths.len() * polars.len();
            let d =
                Distribution::try_new(system, Symmetry::None, &azimuths, polars, vec![2.0; count]).unwrap();
            close(d.flux(), 2.0 * expected, 1e-14);
        }
    }

    #[test]
    fn flux_of_an_intensity_linear_in_gamma_is_its_closed_form() {
        // 1 - 2 t / pi over [0, pi / 2]: 2 pi (1 - 2 / pi), with two angles as with many.
        for steps in [1, 2, 90] {
            let polars = degrees(0.0, 90.0, steps);
            let values = polars.iter().map(|t| 1.0 - t / 90.0).collect();
            let d = Distribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, values).unwrap();
            close(d.flux(), 2.0 * PI * (1.0 - 2.0 / PI), 1e-13);
        }
    }

    #[test]
    fn flux_of_a_lambertian_emitter_is_pi_within_the_error_of_the_interpolant() {
        for steps in [18, 90] {
            let polars = degrees(0.0, 90.0, steps);
            let values = polars.iter().map(|t| t.to_radians().cos()).collect();
            let d = Distribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, values).unwrap();
            // A chord lies below cos by at most h^2 / 8 cos; over the hemisphere that is pi h^2 / 8.
            let step = (90.0 / steps as f64).to_radians();
            assert!(d.flux() < PI && PI - d.flux() < 1.01 * PI * step * step / 8.0, "{}", d.flux());
        }
    }

    #[test]
    fn axes_of_the_three_systems_are_those_of_the_table() {
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-15, "{a} {b}");
        let of = |system| {
            Distribution::try_new(system, Symmetry::None, &[0.0, 1.0], vec![0.0], vec![0.0; 2]).unwrap()
        };
        let c = of(AngularSystem::C);
        near(c.direction(0.0, 0.0), DVec3::NEG_Z);
        near(c.direction(0.0, 90.0), DVec3::X);
        near(c.direction(90.0, 90.0), DVec3::Y);
        // Horizontal 0, vertical 0, -90 and 90; horizontal 90 is clockwise seen from above.
        let a = of(AngularSystem::A);
        near(a.direction(0.0, 90.0), DVec3::X);
        near(a.direction(0.0, 0.0), DVec3::NEG_Z);
        near(a.direction(90.0, 90.0), DVec3::NEG_Y);
        let b = of(AngularSystem::B);
        near(b.direction(0.0, 90.0), DVec3::NEG_Z);
        near(b.direction(90.0, 90.0), DVec3::X);
        near(b.direction(90.0, 180.0), DVec3::NEG_Y);
    }

    #[test]
    fn directions_find_their_own_grid_point_and_planes_repeat_after_a_turn() {
        let (azimuths, polars) = (degrees(0.0, 315.0, 7), degrees(0.0, 180.0, 4));
        let values: Vec<f64> = (0..azimuths.len() * polars.len()).map(|i| 1.0 + i as f64).collect();
        let d = Distribution::try_new(
            AngularSystem::C,
            Symmetry::None,
            &azimuths,
            polars.clone(),
            values.clone(),
        )
        .unwrap();
        for (i, &azimuth) in azimuths.iter().enumerate() {
            for (j, &polar) in polars.iter().enumerate() {
                let expected = values[i * polars.len() + j];
                assert_eq!(d.at(azimuth, polar), expected);
                assert_eq!(d.at(azimuth - 360.0, polar), expected);
                assert_eq!(d.at(azimuth + 720.0, polar), expected);
                if j > 0 && j < 4 {
                    close(d.intensity(3.0 * d.direction(azimuth, polar)), expected, 1e-12);
                }
            }
        }
        // Between the last plane and the first.
        assert_eq!(d.at(337.5, 90.0), 0.5 * (values[2] + values[37]));
        assert_eq!(d.intensity(DVec3::ZERO), 0.0);
        assert_eq!(d.intensity(DVec3::splat(f64::NAN)), 0.0);
    }

    #[test]
    fn numbers_that_are_no_distribution_are_refused_with_their_values() {
        let of = |system, azimuths: &[f64], polars: &[f64], candela: &[f64]| {
            Distribution::try_new(system, Symmetry::None, azimuths, polars.to_vec(), candela.to_vec())
                .unwrap_err()
                .to_string()
        };
        let (a, c) = (AngularSystem::A, AngularSystem::C);
        for (found, expected) in [
            (of(c, &[], &[0.0], &[]), "there are no azimuth"),
            (of(c, &[0.0], &[], &[]), "there are no polar angle"),
            (of(c, &[f64::NAN], &[0.0], &[1.0]), "azimuth NaN"),
            (of(a, &[5.0, 5.0], &[0.0], &[1.0; 2]), "azimuth 5 follows 5"),
            (of(c, &[0.0], &[0.0, 181.0], &[1.0; 2]), "polar angle 181"),
            (of(c, &[0.0], &[2.0, 1.0], &[1.0; 2]), "polar angle 1 follows 2"),
            (of(c, &[0.0], &[0.0, 1.0], &[1.0; 3]), "there are 3 intensities for 1 azimuths and 2 polar"),
            (of(c, &[0.0], &[0.0, 1.0], &[1.0, -1.0]), "intensity number 1 is -1 cd"),
            (of(c, &[0.0], &[0.0], &[f64::INFINITY]), "intensity number 0 is inf cd"),
        ] {
            assert!(found.starts_with(expected), "{found}");
        }
    }

    #[test]
    fn the_last_angle_belongs_to_the_grid_and_beyond_it_is_dark() {
        let d =
            Distribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], vec![0.0, 90.0], vec![5.0; 2])
                .unwrap();
        for azimuth in 0..360 {
            assert_eq!(d.intensity(d.direction(f64::from(azimuth), 90.0)), 5.0);
            assert_eq!(d.intensity(d.direction(f64::from(azimuth), 90.001)), 0.0);
        }
    }
}
