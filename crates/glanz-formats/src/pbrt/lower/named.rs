//! Spectra that pbrt knows by name.

use glanz_light::SpectralDistribution;

/// Indices of refraction of optical glass at the d line, 587.6 nm (manufacturers' catalogues).
const GLASS: &[(&str, f32)] = &[
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.6700),
    ("glass-FK51A", 1.4866),
    ("glass-LASF9", 1.8503),
    ("glass-F5", 1.6034),
    ("glass-SF5", 1.6727),
    ("glass-SF10", 1.7283),
    ("glass-SF11", 1.7847),
];

/// Index and absorption of metals in the bands of Rec. 709: measured spectra weighted with the bands, as in the
/// published scenes of @bitterli2016.
const METALS: &[(&str, [f32; 3])] = &[
    ("metal-Ag-eta", [0.155_265, 0.116_723, 0.138_381]),
    ("metal-Ag-k", [4.828_343, 3.122_246, 2.147_05]),
    ("metal-Al-eta", [1.657_46, 0.880_369, 0.521_229]),
    ("metal-Al-k", [9.223_869, 6.269_523, 4.837_001]),
    ("metal-Au-eta", [0.143_119, 0.374_957, 1.442_479]),
    ("metal-Au-k", [3.983_16, 2.385_721, 1.603_215]),
    ("metal-Cu-eta", [0.200_438, 0.924_033, 1.102_212]),
    ("metal-Cu-k", [3.912_949, 2.452_848, 2.142_188]),
];

/// Temperature of CIE standard illuminant A, K (@cie015).
const ILLUMINANT_A: f32 = 2856.0;

/// The spectrum of that name.
pub(super) fn named(name: &str) -> Option<SpectralDistribution> {
    if let Some((_, index)) = GLASS.iter().find(|(n, _)| *n == name) {
        return Some(SpectralDistribution::Constant(*index));
    }
    if let Some((_, rgb)) = METALS.iter().find(|(n, _)| *n == name) {
        return Some(SpectralDistribution::Rgb(*rgb));
    }
    match name {
        // A constant means D65 when it is light.
        "stdillum-D65" => Some(SpectralDistribution::Constant(1.0)),
        "stdillum-A" => Some(SpectralDistribution::Blackbody { kelvin: ILLUMINANT_A, scale: 1.0 }),
        _ => None,
    }
}

/// The names.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    let others = ["stdillum-D65", "stdillum-A"];
    GLASS.iter().map(|(n, _)| *n).chain(METALS.iter().map(|(n, _)| *n)).chain(others)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_spectrum() {
        assert_eq!(names().filter(|n| named(n).is_none()).count(), 0);
        assert_eq!(named("glass-BK"), None);
    }
}
