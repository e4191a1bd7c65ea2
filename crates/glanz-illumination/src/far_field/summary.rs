//! Figures of a far field.

use glanz_light::intensity::Beam;

use super::FarField;

/// Steps between angles that a beam must span for its peak and width to be those of the light.
const STEPS_OF_BEAM: f64 = 4.0;

/// Relative standard error above which values are noisy.
const NOISY: f64 = 0.1;

/// Loss of a kink in the middle between two angles, which is the largest, relative to the larger fall to a neighbour: 13/24 s h of 23/24 s h. For one at an
/// angle, both are 1/3 and 2/3 s h.
const KINK: f64 = 13.0 / 23.0;

/// Share of the peak from which errors of values count.
const BRIGHT: f64 = 0.1;

/// Figures of the light that left a scene, from the intensities that files hold. Angles are in degrees, directions are C and gamma.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FarFieldSummary {
    /// Flux, lm.
    #[serde(rename = "flux_lm")]
    pub flux: f64,
    /// Largest intensity, cd. It is the largest of many values with errors, so that it tends to be too large by one or two of them.
    #[serde(rename = "peak_cd")]
    pub peak: f64,
    /// Its standard error, cd.
    #[serde(rename = "peak_error_cd")]
    pub peak_error: f64,
    /// Amount, cd, by which the true peak may be larger, because it is narrower than the steps between angles: an estimate by the neighbouring
    /// values, large enough for a kink at the peak.
    #[serde(rename = "peak_shortfall_cd")]
    pub peak_shortfall: f64,
    /// Its direction.
    #[serde(rename = "peak_direction_degrees")]
    pub peak_direction: [f64; 2],
    /// The middle of the beam: see [`Beam::middle`].
    #[serde(rename = "middle_degrees")]
    pub middle: [f64; 2],
    /// Full angles within which the intensity is at least half of the peak: in the plane of the middle, and across it.
    #[serde(rename = "beam_angles_degrees")]
    pub beam_angles: [f64; 2],
    /// The same for a tenth of the peak.
    #[serde(rename = "field_angles_degrees")]
    pub field_angles: [f64; 2],
    /// Largest relative standard error of the values of at least a tenth of the peak.
    pub largest_relative_error: f64,
    /// Number of C-planes.
    pub planes: usize,
    /// Number of gamma angles.
    pub gammas: usize,
    /// Steps between neighbouring values at the middle: in gamma, and across it.
    #[serde(rename = "steps_degrees")]
    pub steps: [f64; 2],
}

impl FarFieldSummary {
    /// Beam angle and step, if the beam is so narrow, in one of the two directions, that interpolation between so few angles does not show it.
    /// Steps of C are not tested for a beam at a pole, which they show only if it is round.
    #[must_use]
    pub fn coarse(&self) -> Option<[f64; 2]> {
        let pairs = self.beam_angles.into_iter().zip(self.steps).map(|(angle, step)| [angle, step]);
        let ratio = |[angle, step]: [f64; 2]| angle / step;
        let narrow = pairs.filter(|&[angle, step]| angle < STEPS_OF_BEAM * step);
        narrow.min_by(|a, b| ratio(*a).total_cmp(&ratio(*b)))
    }

    /// Whether values of at least a tenth of the peak have errors of more than 10 per cent.
    #[must_use]
    pub fn is_noisy(&self) -> bool {
        self.largest_relative_error > NOISY
    }
}

impl FarField {
    /// The figures; `None` if no light left the scene, or if an intensity is not finite.
    #[must_use]
    pub fn summary(&self) -> Option<FarFieldSummary> {
        let Beam { peak, peak_angles, middle, beam_angles, field_angles } =
            self.distribution().ok()?.beam()?;
        let values = || self.candela.iter().zip(&self.errors);
        let bright = values().filter(|(candela, _)| **candela >= BRIGHT * peak);
        let bin = self.candela.iter().position(|candela| *candela == peak)?;
        let (planes, gammas) = (self.grid.planes(), self.grid.gammas());
        let closed: Vec<f64> = planes.iter().copied().chain([360.0]).collect();
        let by_c = |[azimuth, polar]: [f64; 2]| [azimuth.rem_euclid(360.0), polar];
        let (peak_direction, middle) = (by_c(peak_angles), by_c(middle));
        let across = step_at(&closed, middle[0]) * middle[1].to_radians().sin();
        Some(FarFieldSummary {
            flux: self.flux(),
            peak,
            peak_error: self.errors.get(bin).copied().unwrap_or_default(),
            peak_shortfall: self.shortfall(bin),
            peak_direction,
            middle,
            beam_angles,
            field_angles,
            largest_relative_error: bright.map(|(candela, error)| error / candela).fold(0.0, f64::max),
            planes: planes.len(),
            gammas: gammas.len(),
            steps: [step_at(gammas, middle[1]), across],
        })
    }
}

impl FarField {
    /// Estimate of what the hat of a bin takes from a peak, cd.
    ///
    /// The mean of I - s |x| under a hat of half width h whose angle is t h from the kink is I - (1/3 + t^2 - t^3 / 3) s h, up to the middle between two angles, t = 1/2;
    /// see [`KINK`]. On a cone about the axis it is I - s h / 2, and the neighbours are s h / 2 lower. Smooth peaks lose a third of that or less.
    fn shortfall(&self, bin: usize) -> f64 {
        let (count, last) = (self.grid.planes().len(), self.grid.gammas().len() - 1);
        let peak = self.candela.get(bin).copied().unwrap_or_default();
        let fall = |(i, j): (usize, usize)| (peak - self.at(i, j)).max(0.0);
        let ring = |gamma: usize| (0..count).map(|i| fall((i, gamma))).sum::<f64>() / count as f64;
        match bin {
            0 => ring(1),
            bin if bin + 1 == self.grid.bins() => ring(last - 1),
            bin => {
                let (i, j) = ((bin - 1) % count, 1 + (bin - 1) / count);
                let larger = |a, b| fall(a).max(fall(b));
                KINK * (larger((i, j - 1), (i, j + 1)) + larger((i + 1, j), (i + count - 1, j)))
            }
        }
    }
}

/// The largest step of ascending angles that reaches `angle`.
fn step_at(angles: &[f64], angle: f64) -> f64 {
    let at = angles.windows(2).filter(|pair| (pair[0]..=pair[1]).contains(&angle));
    at.map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
}
