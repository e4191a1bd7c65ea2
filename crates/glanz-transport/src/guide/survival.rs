//! Russian roulette by the expected contribution of a path.
//!
//! A path should end where its remaining contribution is small relative to the expected contribution of the whole path, not where its
//! throughput is small; the guide estimates the incident light (@vorba2016). The reference is the mean of the path's own expectation and
//! that of the whole picture: an absolute error counts the same in dark and in bright pixels, but is more visible in dark ones.

use glanz_light::{Spectrum, Wavelengths};

/// Factor on the survival probability above the ratio of contributions, because the path so far has a cost, too.
const EAGERNESS: f64 = 3.0;

/// Smallest probability of survival: the estimate may be wrong, and the light of survivors is divided by the probability.
const LEAST: f64 = 0.2;

/// Fraction of the light that is assumed to be distributed as the BSDF, regardless of the guide.
const DOUBT: f64 = 0.3;

/// Luminance of a throughput times white light. At sampled wavelengths the mean: a path of blue light has hardly any luminance, but all of the blue.
pub(crate) fn brightness(throughput: Spectrum, wavelengths: &Wavelengths) -> f64 {
    f64::from(match wavelengths {
        Wavelengths::Rgb => throughput.luminance(wavelengths),
        _ => throughput.mean(wavelengths),
    })
}

/// Expected contribution of a path, from its first vertex and the mean of the picture.
pub(crate) fn expected(own: f64, brightness: f64) -> f64 {
    0.5 * (own + brightness)
}

/// Assumed density of the light per steradian: a mixture of the densities of guide and BSDF.
pub(crate) fn believed(guide: f64, bsdf: f64) -> f64 {
    (1.0 - DOUBT) * guide + DOUBT * bsdf
}

/// Probability of survival for an expected remaining contribution `rest` and an expected contribution `path` of the whole path; `None` if
/// the ratio is undefined.
pub(crate) fn probability(rest: f64, path: f64) -> Option<f64> {
    let ratio = EAGERNESS * rest / path;
    ratio.is_finite().then(|| ratio.clamp(LEAST, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_while_they_bring_a_third_of_the_expected_light() {
        assert_eq!(probability(0.5, 1.0), Some(1.0));
        assert_eq!(probability(0.1, 1.0), Some(EAGERNESS * 0.1));
        // Never less than a fifth, and undefined if no light is expected.
        assert_eq!(probability(0.0, 1.0), Some(0.2));
        assert_eq!(probability(0.0, 0.0), None);
        assert_eq!(probability(f64::INFINITY, 1.0), None);
    }
}
