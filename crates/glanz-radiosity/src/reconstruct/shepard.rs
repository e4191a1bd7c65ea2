//! Interpolation by inverse distance weighting.

use glanz_math::{DVec2, DVec3};

use super::{Interpolant, Sample};

/// Mean of all samples with the weights distance^-exponent.
///
/// # Source
/// @shepard1968; @pietrek2001 section 4.5.1.
pub(super) struct Shepard {
    samples: Vec<Sample>,
    /// Half the exponent, since weights are computed from squared distances.
    half: f64,
}

impl Shepard {
    /// `exponent`: above 0.
    pub(super) fn new(samples: &[Sample], exponent: f64) -> Self {
        Self { samples: samples.to_vec(), half: 0.5 * exponent }
    }

    fn weighted(&self, point: DVec2, weight: impl Fn(f64) -> f64) -> DVec3 {
        // Relative to the nearest sample, so that no power overflows.
        let square = |s: &Sample| s.point.distance_squared(point);
        let nearest = self.samples.iter().map(square).fold(f64::INFINITY, f64::min);
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for sample in &self.samples {
            let square = square(sample);
            let w = if square == nearest { 1.0 } else { weight(nearest / square) };
            sum += w * sample.value;
            weights += w;
        }
        sum / weights
    }
}

impl Interpolant for Shepard {
    fn value(&self, point: DVec2) -> DVec3 {
        // Multiplication is twenty times faster than `powf`.
        match self.half {
            1.0 => self.weighted(point, |x| x),
            2.0 => self.weighted(point, |x| x * x),
            3.0 => self.weighted(point, |x| x * x * x),
            4.0 => self.weighted(point, |x| (x * x) * (x * x)),
            0.5 => self.weighted(point, f64::sqrt),
            half => self.weighted(point, |x| x.powf(half)),
        }
    }
}
