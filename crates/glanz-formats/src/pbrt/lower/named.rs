//! Values of named spectra and suggestions of names, in addition to the table in `glanz_light::named`.

use glanz_light::named::names;
use glanz_light::{SpectralDistribution, Wavelengths};

use crate::nearest::nearest;

/// The yellow line of helium called d, at which catalogues state the index of refraction of glass (@schott2017), nm.
const HELIUM_D_NM: f64 = 587.5618;

/// Largest number of suggested names.
const MAX_SUGGESTIONS: usize = 8;

/// A number from a spectrum, such as the index of refraction of glass: its value at the d line, or the
/// mean of a colour.
pub(super) fn at_d_line(spectrum: &SpectralDistribution) -> f32 {
    match spectrum {
        SpectralDistribution::Constant(x) => *x,
        SpectralDistribution::Sampled(samples) => samples.at(HELIUM_D_NM) as f32,
        other => {
            let wavelengths = Wavelengths::default();
            other.unbounded(&wavelengths).mean(&wavelengths)
        }
    }
}

/// Suggestions for an unknown name: the names that begin with it, or else the nearest.
pub(super) fn suggestion(name: &str) -> Option<String> {
    let lower = name.to_lowercase();
    let longer = names().filter(|n| !name.is_empty() && n.to_lowercase().starts_with(&lower));
    let mut similar: Vec<&str> = longer.take(MAX_SUGGESTIONS).collect();
    if similar.is_empty() {
        similar.extend(nearest(name, names()));
    }
    match similar[..] {
        [] => None,
        [one] => Some(format!("did you mean the built-in {one:?}?")),
        _ => {
            let quoted: Vec<String> = similar.iter().map(|n| format!("{n:?}")).collect();
            Some(format!("did you mean one of the built-in {}?", quoted.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_suggested() {
        assert_eq!(suggestion("glass-BK8").unwrap(), "did you mean the built-in \"glass-BK7\"?");
        let of_gold = "did you mean one of the built-in \"metal-Au-eta\", \"metal-Au-k\"?";
        assert_eq!(suggestion("metal-au").unwrap(), of_gold);
        assert_eq!(suggestion("spds/sky.spd"), None);
        assert_eq!(suggestion(""), None);
    }

    #[test]
    fn index_of_glass_is_that_of_its_catalogue() {
        // n_d of the data sheets (@schott2017).
        for (name, index) in [("glass-BK7", 1.51680), ("glass-SF11", 1.78472), ("glass-BAF10", 1.67003)] {
            let found = f64::from(at_d_line(&glanz_light::named::spectrum(name).unwrap()));
            // Linear between samples 5 nm apart.
            assert!((found - index).abs() < 1e-4, "{name}: {found}");
        }
        assert_eq!(at_d_line(&SpectralDistribution::Constant(1.5)), 1.5);
    }
}
