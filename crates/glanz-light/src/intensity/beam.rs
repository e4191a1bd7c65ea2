//! Direction and width of beams.

use glanz_math::DVec3;

use super::distribution::IntensityDistribution;

/// Shares of the peak that end a beam and its field.
const BEAM: f64 = 0.5;
const FIELD: f64 = 0.1;

/// Steps of the search for the edge of a beam: the first, degrees, and the later ones relative to the angle reached.
const FIRST_STEP: f64 = 1e-4;
const GROWTH: f64 = 1.0 / 64.0;

/// Bisections of the step in which a beam ends: to the rounding of angles.
const BISECTIONS: u32 = 50;

/// The brightest part of a distribution. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Largest intensity, cd.
    pub peak: f64,
    /// Azimuth and polar angle of the largest intensity; of several equal ones, of that with the smallest polar angle.
    pub peak_angles: [f64; 2],
    /// Azimuth and polar angle of the middle: the mean direction of all light of at least half of the peak, or `peak_angles` if the mean
    /// direction is darker than that, as in a ring. At a pole the azimuth is 0.
    pub middle: [f64; 2],
    /// Full angles within which the intensity is at least half of the peak: in the plane of the middle's azimuth and the opposite one, and in
    /// the great circle across it through the middle.
    pub beam_angles: [f64; 2],
    /// The same for a tenth of the peak.
    pub field_angles: [f64; 2],
}

impl IntensityDistribution {
    /// The brightest part; `None` if all is dark.
    #[must_use]
    pub fn beam(&self) -> Option<Beam> {
        let (peak, peak_angles) = self.peak_at();
        if peak <= 0.0 {
            return None;
        }
        let mean = self.middle(BEAM * peak).filter(|&[a, p]| self.at(a, p) >= BEAM * peak);
        let middle = mean.unwrap_or(peak_angles);
        let start = self.direction(middle[0], middle[1]);
        let along = self.direction(middle[0], middle[1] + 90.0);
        let angles =
            |share: f64| [along, start.cross(along)].map(|side| self.full_angle(start, side, share * peak));
        Some(Beam { peak, peak_angles, middle, beam_angles: angles(BEAM), field_angles: angles(FIELD) })
    }

    /// Angle, degrees, around the unit vector `start` in the great circle towards the unit vector `side`, which is perpendicular to it,
    /// within which the intensity is at least `candela`: 0 if it is less at `start`, 360 if it is so in the whole circle.
    #[must_use]
    pub fn full_angle(&self, start: DVec3, side: DVec3, candela: f64) -> f64 {
        let reach = |sign: f64| {
            let is_bright = |angle: f64| {
                let (sin, cos) = (sign * angle).to_radians().sin_cos();
                self.intensity(start * cos + side * sin) >= candela
            };
            let (mut inside, mut outside) = (0.0, FIRST_STEP);
            while is_bright(outside) {
                if outside >= 180.0 {
                    return 180.0;
                }
                inside = outside;
                outside = f64::min(outside + FIRST_STEP.max(GROWTH * outside), 180.0);
            }
            for _ in 0..BISECTIONS {
                let angle = 0.5 * (inside + outside);
                if is_bright(angle) {
                    inside = angle;
                } else {
                    outside = angle;
                }
            }
            inside
        };
        if self.intensity(start) < candela { 0.0 } else { reach(1.0) + reach(-1.0) }
    }

    /// The largest intensity, candela, and its angles, degrees.
    fn peak_at(&self) -> (f64, [f64; 2]) {
        let mut best = (0.0, [0.0; 2]);
        for (j, &polar) in self.polars().iter().enumerate() {
            for (i, &azimuth) in self.azimuths().iter().enumerate() {
                let value = self.plane(i).get(j).copied().unwrap_or(0.0);
                if value > best.0 {
                    best = (value, [azimuth, polar]);
                }
            }
        }
        best
    }

    /// Angles, degrees, of the mean direction of the light of all cells that reach `candela`; `None` if the mean is the zero vector.
    fn middle(&self, candela: f64) -> Option<[f64; 2]> {
        let (azimuths, polars) = (self.azimuths(), self.polars());
        let last = azimuths.len() - 1;
        let axis = self.direction(0.0, 0.0);
        let mut mean = DVec3::ZERO;
        let fluxes = self.cell_fluxes();
        let mut fluxes = fluxes.iter();
        for i in 0..last.max(1) {
            let second = (i + 1).min(last);
            // A single plane applies to the full circle.
            let to = if last == 0 { azimuths[i] + 360.0 } else { azimuths[second] };
            let half = 0.5 * (to - azimuths[i]).to_radians();
            let across = self.direction(0.5 * (azimuths[i] + to), 90.0) * (half.sin() / half);
            for j in 0..polars.len() - 1 {
                let flux = fluxes.next().copied().unwrap_or(0.0);
                let corners = [self.plane(i), self.plane(second)].map(|plane| plane.get(j..j + 2));
                if corners.into_iter().flatten().flatten().any(|value| *value >= candela) {
                    let (sin, cos) = (0.5 * (polars[j] + polars[j + 1])).to_radians().sin_cos();
                    mean += (axis * cos + across * sin) * flux;
                }
            }
        }
        let mean = mean.try_normalize()?;
        let [azimuth, polar] = self.system().angles(mean);
        // Nearer to a pole than noise tells apart.
        let nearby = |pair: Option<&[f64]>| pair.map_or(0.0, |pair| 0.25 * (pair[1] - pair[0]));
        if polar < nearby(polars.windows(2).next()) {
            return Some([0.0, 0.0]);
        }
        if 180.0 - polar < nearby(polars.windows(2).next_back()) {
            return Some([0.0, 180.0]);
        }
        Some([azimuth, polar])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AngularSystem, Symmetry};
    use super::*;

    fn lamp(azimuths: &[f64], polars: Vec<f64>, candela: impl Fn(f64, f64) -> f64) -> IntensityDistribution {
        let rows = azimuths.iter().flat_map(|&c| polars.iter().map(move |&gamma| (c, gamma)));
        let candela = rows.map(|(c, gamma)| candela(c, gamma)).collect();
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, azimuths, polars, candela).unwrap()
    }

    fn close(found: [f64; 2], expected: [f64; 2], tolerance: f64) {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
        assert!(near, "{found:?}, not {expected:?}");
    }

    #[test]
    fn angles_of_a_cone_are_those_of_its_interpolation() {
        // 100 cd within gamma 1, linear to 0 at gamma 3: half of it at 2, a tenth at 2.8.
        let narrow =
            lamp(&[0.0], vec![0.0, 1.0, 3.0, 180.0], |_, gamma| if gamma <= 1.0 { 100.0 } else { 0.0 });
        let beam = narrow.beam().unwrap();
        assert_eq!((beam.peak, beam.peak_angles, beam.middle), (100.0, [0.0; 2], [0.0; 2]));
        close(beam.beam_angles, [4.0; 2], 1e-9);
        close(beam.field_angles, [5.6; 2], 1e-9);
        let all = lamp(&[0.0, 90.0, 180.0, 270.0], vec![0.0, 180.0], |_, _| 7.0).beam().unwrap();
        assert_eq!((all.beam_angles, all.field_angles), ([360.0; 2], [360.0; 2]));
        assert_eq!(lamp(&[0.0], vec![0.0, 90.0], |_, _| 0.0).beam(), None);
    }

    #[test]
    fn middle_of_a_tilted_beam_is_its_axis() {
        // A tent over C 20 to 40 and gamma 30 to 50: half of it 5 degrees from the middle in gamma; across it the great circle with
        // tan(angle) = sin 40 tan(difference of C), but for the change of gamma along it.
        let peak = |c: f64, gamma: f64| if c == 30.0 && gamma == 40.0 { 50.0 } else { 0.0 };
        let tilted = lamp(&[0.0, 20.0, 30.0, 40.0, 180.0], vec![0.0, 30.0, 40.0, 50.0, 180.0], peak);
        let beam = tilted.beam().unwrap();
        assert_eq!((beam.peak, beam.peak_angles), (50.0, [30.0, 40.0]));
        close(beam.middle, [30.0, 40.0], 0.5);
        let along = tilted.full_angle(tilted.direction(30.0, 40.0), tilted.direction(30.0, 130.0), 25.0);
        assert!((along - 10.0).abs() < 1e-9, "{along}");
        assert!((beam.beam_angles[1] - 10.0 * 40.0_f64.to_radians().sin()).abs() < 0.3, "{beam:?}");
    }

    #[test]
    fn middle_of_a_ring_is_its_brightest_direction() {
        let ring = |c: f64, gamma: f64| match gamma {
            60.0 => 100.0 + if c == 90.0 { 1.0 } else { 0.0 },
            _ => 10.0,
        };
        let beam = lamp(&[0.0, 90.0, 180.0, 270.0], vec![0.0, 50.0, 60.0, 70.0, 180.0], ring).beam().unwrap();
        assert_eq!((beam.peak, beam.middle), (101.0, [90.0, 60.0]));
        // 50.5 is (101 - 50.5) / 91 of ten degrees from the ring, on both sides.
        assert!((beam.beam_angles[0] - 20.0 * 50.5 / 91.0).abs() < 1e-9, "{beam:?}");
    }
}
