//! Luminous intensity over directions.

use std::f64::consts::TAU;

use glanz_math::DVec3;

/// Errors of making a distribution of intensities.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntensityError {
    /// No azimuths or no polar angles.
    #[error("there is no {0}; at least one is needed")]
    Empty(&'static str),
    /// An angle out of range or order.
    #[error("{what} {second} follows {first}; the angles must be {allowed} and ascend")]
    Angles {
        /// Which angles.
        what: &'static str,
        /// One angle in degrees.
        first: f64,
        /// The next, or the same if it alone is at fault.
        second: f64,
        /// The condition on each angle.
        allowed: &'static str,
    },
    /// The number of intensities is not that of the directions.
    #[error(
        "there are {found} intensities for {azimuths} azimuths and {polars} polar angles; each pair needs one"
    )]
    Count {
        /// Intensities.
        found: usize,
        /// Azimuths.
        azimuths: usize,
        /// Polar angles.
        polars: usize,
    },
    /// An intensity is negative, infinite or NaN.
    #[error("intensity {index} is {value} cd; it must be finite and not negative")]
    Intensity {
        /// Index, row by row.
        index: usize,
        /// Candela.
        value: f64,
    },
}

/// Coordinate system of the goniophotometer; see the table in [`super`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngularSystem {
    /// Planes share a vertical axis, angles count from the horizontal; headlamps and signals.
    A,
    /// Planes share a horizontal axis; floodlights.
    B,
    /// Planes share a vertical axis, angles count from straight down; nearly everything else.
    C,
}

impl AngularSystem {
    /// Unit direction in the luminaire's frame of an azimuth and a polar angle, degrees; for type C these are C and gamma, for the others see
    /// [`IntensityDistribution`].
    #[must_use]
    pub fn direction(self, azimuth: f64, polar: f64) -> DVec3 {
        let (pole, zero, ninety) = self.axes();
        let ((sin, cos), (sin_a, cos_a)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        pole * cos + (zero * cos_a + ninety * sin_a) * sin
    }

    /// The inverse of [`AngularSystem::direction`] for a direction of any length: the azimuth is from -180 to 180, and 0 at the poles.
    #[must_use]
    pub fn angles(self, direction: DVec3) -> [f64; 2] {
        let (pole, zero, ninety) = self.axes();
        let (x, y) = (direction.dot(zero), direction.dot(ninety));
        [y.atan2(x), x.hypot(y).atan2(direction.dot(pole))].map(f64::to_degrees)
    }

    /// The axis and the directions of azimuth 0 and 90 at polar angle 90.
    fn axes(self) -> (DVec3, DVec3, DVec3) {
        match self {
            // Horizontal angles count counterclockwise seen from above for type C, clockwise for A and B.
            Self::C => (DVec3::NEG_Z, DVec3::X, DVec3::Y),
            Self::A => (DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
            Self::B => (DVec3::Y, DVec3::NEG_Z, DVec3::X),
        }
    }
}

/// Symmetry by which the measured planes give the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// No symmetry: every plane is measured.
    None,
    /// All planes are equal.
    Axial,
    /// Mirror symmetry about the plane y = 0 (C0-C180).
    AcrossY,
    /// Mirror symmetry about the plane x = 0 (C90-C270).
    AcrossX,
    /// Mirror symmetry about both planes.
    Quadrants,
}

/// Luminous intensities in candela on a grid of directions around an axis.
///
/// A direction has an azimuth about the axis and a polar angle from it, both in degrees. For type C these are C and
/// gamma, about -z; for type A horizontal angle and vertical angle + 90, about -z; for type B vertical angle and
/// horizontal angle + 90, about +y. The planes that follow by symmetry are included. Between the angles the intensity is bilinear, outside
/// them zero.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityDistribution {
    system: AngularSystem,
    symmetry: Symmetry,
    /// Strictly ascending; the last is the first + 360 if the planes cover the full circle; a single one applies to all azimuths.
    azimuths: Vec<f64>,
    /// For each azimuth its row in `candela`.
    rows: Vec<usize>,
    /// Strictly ascending, within [0, 180].
    polars: Vec<f64>,
    /// Row by row.
    candela: Vec<f64>,
}

/// Rounding error, in degrees, of an angle up to 360 degrees computed from a direction; angles beyond the grid by no more
/// count as its last.
const ROUNDING: f64 = 8.0 * 360.0 * f64::EPSILON;

impl IntensityDistribution {
    /// A distribution from the measured planes.
    ///
    /// `azimuths`: degrees, one for each row of `candela`, ascending for types A and B; for types A and C `symmetry` adds the others.
    /// `polars`: degrees, ascending, within [0, 180]. `candela`: row by row, one value for each pair of angles.
    ///
    /// # Errors
    /// [`IntensityError`] if the angles or intensities violate these conditions.
    pub fn try_new(
        system: AngularSystem,
        symmetry: Symmetry,
        azimuths: &[f64],
        polars: Vec<f64>,
        candela: Vec<f64>,
    ) -> Result<Self, IntensityError> {
        check(system, azimuths, &polars, &candela)?;
        let (azimuths, rows) = unfolded(system, symmetry, azimuths);
        Ok(Self { system, symmetry, azimuths, rows, polars, candela })
    }

    /// Coordinate system of the goniophotometer.
    #[must_use]
    pub fn system(&self) -> AngularSystem {
        self.system
    }

    /// Symmetry of the measurement.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Azimuths of the planes in degrees, ascending, those by symmetry included. If they cover the full circle, the last is
    /// the first + 360. A single one applies to all azimuths.
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
        let Some((j, v)) = interval(&self.polars, polar) else { return 0.0 };
        let in_plane = |plane: usize| {
            let plane = self.plane(plane);
            let value = |k: usize| plane.get(k).copied().unwrap_or(0.0);
            // A grid point has exactly its own value.
            if v == 0.0 { value(j) } else { value(j) * (1.0 - v) + value(j + 1) * v }
        };
        if self.azimuths.len() == 1 {
            return in_plane(0);
        }
        let Some((i, u)) = interval(&self.azimuths, self.wrapped(azimuth)) else { return 0.0 };
        if u == 0.0 { in_plane(i) } else { in_plane(i) * (1.0 - u) + in_plane(i + 1) * u }
    }

    /// Candela in a direction of any length in the luminaire's frame; 0 for the zero vector and NaN.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> f64 {
        let [azimuth, polar] = self.system.angles(direction);
        if !(polar.is_finite() && direction.length_squared() > 0.0) {
            return 0.0;
        }
        self.at(azimuth, polar)
    }

    /// Unit direction at angles in degrees.
    #[must_use]
    pub fn direction(&self, azimuth: f64, polar: f64) -> DVec3 {
        self.system.direction(azimuth, polar)
    }

    /// Lumens: the integral of the interpolated intensity over all directions, exact up to rounding.
    #[must_use]
    pub fn flux(&self) -> f64 {
        let of_plane = |i: usize| -> f64 {
            let pairs = self.polars.windows(2).zip(self.plane(i).windows(2));
            pairs.map(|(t, v)| zonal_integral(t[0].to_radians(), t[1].to_radians(), v[0], v[1])).sum()
        };
        if self.azimuths.len() == 1 {
            return TAU * of_plane(0);
        }
        // Linear in azimuth: the trapezoidal rule is exact.
        let steps = self.azimuths.windows(2).enumerate();
        steps.map(|(i, a)| (a[1] - a[0]).to_radians() * 0.5 * (of_plane(i) + of_plane(i + 1))).sum()
    }

    /// The distribution with all intensities times `factor`; `None` if one would be negative or not finite.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        let mut scaled = self.clone();
        for value in &mut scaled.candela {
            *value *= factor;
        }
        let valid = |value: &f64| value.is_finite() && *value >= 0.0;
        scaled.candela.iter().all(valid).then_some(scaled)
    }

    /// The azimuth plus the multiple of 360 that puts it within the planes, if one does.
    fn wrapped(&self, azimuth: f64) -> f64 {
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
        // Azimuths of type C are sorted later, with those by symmetry.
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

/// Index of the interval of ascending `angles` that holds `angle`, and its position in [0, 1) there; `None` outside them.
fn interval(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
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

/// Integral of v sin t over the zone of polar angles t in [a, b], radians, with v linear from `at_a` to `at_b`; exact up to rounding, also in
/// narrow zones.
#[must_use]
pub fn zonal_integral(a: f64, b: f64, at_a: f64, at_b: f64) -> f64 {
    let half = 0.5 * (b - a);
    let middle = 0.5 * (a + b);
    // cos a - cos b and (sin b - sin a) / (b - a), without cancellation for angles close together.
    let whole = 2.0 * middle.sin() * half.sin();
    let mean_cos = middle.cos() * if half == 0.0 { 1.0 } else { half.sin() / half };
    let of_b = mean_cos - b.cos();
    at_a * (whole - of_b) + at_b * of_b
}

/// The measured azimuths and those by symmetry, ascending, with the row of each.
fn unfolded(system: AngularSystem, symmetry: Symmetry, measured: &[f64]) -> (Vec<f64>, Vec<usize>) {
    if system != AngularSystem::C {
        // Azimuths of types A and B lie in [-90, 90]; only those of type A are mirrored by symmetry.
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
    fn flux_of_constant_intensity_is_its_solid_angle_in_every_system() {
        for (system, azimuths, expected) in [
            (AngularSystem::C, degrees(0.0, 360.0, 7), 4.0 * PI),
            (AngularSystem::C, vec![0.0, 17.0, 359.0], 4.0 * PI),
            (AngularSystem::A, degrees(-90.0, 90.0, 6), 2.0 * PI),
            (AngularSystem::B, degrees(-90.0, 90.0, 5), 2.0 * PI),
        ] {
            let polars = degrees(0.0, 180.0, 9);
            let count = azimuths.len() * polars.len();
            let d =
                IntensityDistribution::try_new(system, Symmetry::None, &azimuths, polars, vec![2.0; count])
                    .unwrap();
            close(d.flux(), 2.0 * expected, 1e-14);
        }
    }

    #[test]
    fn flux_of_an_intensity_linear_in_gamma_equals_the_closed_form() {
        // 1 - 2 t / pi over [0, pi / 2]: 2 pi (1 - 2 / pi), for any number of angles.
        for steps in [1, 2, 90] {
            let polars = degrees(0.0, 90.0, steps);
            let values = polars.iter().map(|t| 1.0 - t / 90.0).collect();
            let d = IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, values)
                .unwrap();
            close(d.flux(), 2.0 * PI * (1.0 - 2.0 / PI), 1e-13);
        }
    }

    #[test]
    fn flux_of_a_lambertian_emitter_is_pi_within_the_error_of_the_interpolant() {
        for steps in [18, 90] {
            let polars = degrees(0.0, 90.0, steps);
            let values = polars.iter().map(|t| t.to_radians().cos()).collect();
            let d = IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, values)
                .unwrap();
            // A chord lies below cos by at most h^2 / 8 cos; over the hemisphere that is pi h^2 / 8.
            let step = (90.0 / steps as f64).to_radians();
            assert!(d.flux() < PI && PI - d.flux() < 1.01 * PI * step * step / 8.0, "{}", d.flux());
        }
    }

    #[test]
    fn axes_of_the_three_systems_agree_with_the_table() {
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-15, "{a} {b}");
        let of = |system| {
            IntensityDistribution::try_new(system, Symmetry::None, &[0.0, 1.0], vec![0.0], vec![0.0; 2])
                .unwrap()
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
    fn grid_points_have_their_values_in_every_turn() {
        let (azimuths, polars) = (degrees(0.0, 315.0, 7), degrees(0.0, 180.0, 4));
        let values: Vec<f64> = (0..azimuths.len() * polars.len()).map(|i| 1.0 + i as f64).collect();
        let d = IntensityDistribution::try_new(
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
    fn invalid_angles_and_intensities_are_reported_with_their_values() {
        let of = |system, azimuths: &[f64], polars: &[f64], candela: &[f64]| {
            IntensityDistribution::try_new(
                system,
                Symmetry::None,
                azimuths,
                polars.to_vec(),
                candela.to_vec(),
            )
            .unwrap_err()
            .to_string()
        };
        let (a, c) = (AngularSystem::A, AngularSystem::C);
        for (found, expected) in [
            (of(c, &[], &[0.0], &[]), "there is no azimuth"),
            (of(c, &[0.0], &[], &[]), "there is no polar angle"),
            (of(c, &[f64::NAN], &[0.0], &[1.0]), "azimuth NaN"),
            (of(a, &[5.0, 5.0], &[0.0], &[1.0; 2]), "azimuth 5 follows 5"),
            (of(c, &[0.0], &[0.0, 181.0], &[1.0; 2]), "polar angle 181"),
            (of(c, &[0.0], &[2.0, 1.0], &[1.0; 2]), "polar angle 1 follows 2"),
            (of(c, &[0.0], &[0.0, 1.0], &[1.0; 3]), "there are 3 intensities for 1 azimuths and 2 polar"),
            (of(c, &[0.0], &[0.0, 1.0], &[1.0, -1.0]), "intensity 1 is -1 cd"),
            (of(c, &[0.0], &[0.0], &[f64::INFINITY]), "intensity 0 is inf cd"),
        ] {
            assert!(found.starts_with(expected), "{found}");
        }
    }

    #[test]
    fn intensity_is_kept_at_the_last_angle_and_zero_beyond() {
        let d = IntensityDistribution::try_new(
            AngularSystem::C,
            Symmetry::Axial,
            &[0.0],
            vec![0.0, 90.0],
            vec![5.0; 2],
        )
        .unwrap();
        for azimuth in 0..360 {
            assert_eq!(d.intensity(d.direction(f64::from(azimuth), 90.0)), 5.0);
            assert_eq!(d.intensity(d.direction(f64::from(azimuth), 90.001)), 0.0);
        }
    }
}
