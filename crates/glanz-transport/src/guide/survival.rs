//! Russian roulette by the expected contribution of a path.
//!
//! A path shall end where what it can still bring is small beside what it is expected to bring as a whole, not where its throughput is small: the
//! guide knows how much light comes from where (@vorba2016). What is brought counts beside the mean of the path's own expectation and that
//! of the whole picture: an error of a dark pixel weighs as much as the same of a bright one, but is seen more.

/// Factor by which paths live longer than in proportion to their contribution: the path so far has a cost, too.
const EAGERNESS: f64 = 3.0;

/// Least probability to go on: what is known may be wrong, and the light of survivors is divided by it.
const LEAST: f64 = 0.2;

/// Share of the light that is believed to come from where the BSDF looks, whatever the guide says.
const DOUBT: f64 = 0.3;

/// Expected contribution of a path, from its first vertex and the mean of the picture.
pub(crate) fn expected(own: f64, brightness: f64) -> f64 {
    0.5 * (own + brightness)
}

/// Density per steradian of the light, as far as it is believed.
pub(crate) fn believed(guide: f64, bsdf: f64) -> f64 {
    (1.0 - DOUBT) * guide + DOUBT * bsdf
}

/// The probability to go on if that is expected to bring `rest` and the path as a whole `path`; `None` if that says nothing.
pub(crate) fn probability(rest: f64, path: f64) -> Option<f64> {
    let ratio = EAGERNESS * rest / path;
    ratio.is_finite().then(|| ratio.clamp(LEAST, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_go_on_as_long_as_they_bring_a_third_of_what_is_expected() {
        assert_eq!(probability(0.5, 1.0), Some(1.0));
        assert_eq!(probability(0.1, 1.0), Some(EAGERNESS * 0.1));
        // Never less than a fifth, and no opinion where nothing is expected at all.
        assert_eq!(probability(0.0, 1.0), Some(0.2));
        assert_eq!(probability(0.0, 0.0), None);
        assert_eq!(probability(f64::INFINITY, 1.0), None);
    }
}
