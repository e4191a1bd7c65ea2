//! Materials of models.

use std::str::FromStr;

use glanz_light::{SpectralDistribution, named};

use super::color::{SrgbColor, SrgbColorError};
use crate::description::MaterialKind;

/// A material that replaces those of a model.
///
/// As text: its name in lower case; plastic with its colour, such as `plastic:#c01818` or `plastic:white`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StudioMaterial {
    /// Polished iron.
    Steel,
    /// Polished aluminium.
    Aluminium,
    /// Polished gold.
    Gold,
    /// Polished silver.
    Silver,
    /// Polished copper.
    Copper,
    /// Polished brass.
    Brass,
    /// Clear glass.
    Glass,
    /// Plastic of this colour.
    Plastic(SrgbColor),
}

/// A text that is not a material.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StudioMaterialError {
    /// An unknown name.
    #[error("{0:?} is not a material; use {names} or plastic:#rrggbb", names = NAMES.map(|(name, _)| name).join(", "))]
    Name(String),
    /// Plastic without a valid colour.
    #[error("plastic: {0}")]
    Color(#[from] SrgbColorError),
}

/// The materials without parameters by their names.
const NAMES: [(&str, StudioMaterial); 7] = [
    ("steel", StudioMaterial::Steel),
    ("aluminium", StudioMaterial::Aluminium),
    ("gold", StudioMaterial::Gold),
    ("silver", StudioMaterial::Silver),
    ("copper", StudioMaterial::Copper),
    ("brass", StudioMaterial::Brass),
    ("glass", StudioMaterial::Glass),
];

impl FromStr for StudioMaterial {
    type Err = StudioMaterialError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(color) = text.strip_prefix("plastic:") {
            return Ok(Self::Plastic(color.parse()?));
        }
        let known = NAMES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
        known.map(|(_, material)| material).ok_or_else(|| StudioMaterialError::Name(text.to_owned()))
    }
}

/// Index of refraction of window glass and of most plastics.
const GLASS_INDEX: f32 = 1.5;

impl StudioMaterial {
    /// The scattering model with its parameters.
    #[must_use]
    pub fn kind(self) -> MaterialKind {
        match self {
            Self::Steel => iron(),
            Self::Aluminium => metal("metal-Al-eta", "metal-Al-k"),
            Self::Gold => metal("metal-Au-eta", "metal-Au-k"),
            Self::Silver => metal("metal-Ag-eta", "metal-Ag-k"),
            Self::Copper => metal("metal-Cu-eta", "metal-Cu-k"),
            Self::Brass => metal("metal-CuZn-eta", "metal-CuZn-k"),
            Self::Glass => MaterialKind::dielectric(GLASS_INDEX, 1.0, 1.0),
            Self::Plastic(color) => cad_material(color.to_linear(), 0.0),
        }
    }
}

fn metal(eta: &str, k: &str) -> MaterialKind {
    let spectrum = |name: &str| named::spectrum(name).unwrap_or_default();
    MaterialKind::conductor(spectrum(eta), spectrum(k))
}

/// Iron at 650, 550 and 450 nm, as red, green and blue (@johnson1974).
fn iron() -> MaterialKind {
    let eta = SpectralDistribution::Rgb([2.911, 2.950, 2.585]);
    MaterialKind::conductor(eta, SpectralDistribution::Rgb([3.089, 2.932, 2.767]))
}

/// Colour of parts of a model without one, linear Rec. 709.
pub const CAD_GREY: [f32; 3] = [0.5; 3];

/// Share of light that plastic reflects at its surface: at normal incidence on an index of 1.5.
const GLOSS: f32 = 0.04;

/// Exponent of the highlight of plastic: about 8 degrees wide.
const GLOSS_EXPONENT: f32 = 120.0;

/// The material of a part with a colour, as CAD files give it.
///
/// `color`: linear Rec. 709, each in [0, 1]; `transparency`: 0 is opaque, 1 is clear. Opaque parts are plastic with a slight gloss. Transparent
/// ones are thin panes that do not refract, since what lies behind them is to be seen in its place; a part has two of them on a ray, which together
/// let the colour and the share `transparency` of the rest pass.
#[must_use]
pub fn cad_material(color: [f32; 3], transparency: f32) -> MaterialKind {
    let unit = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let (color, transparency) = (color.map(unit), unit(transparency));
    if transparency > 0.0 {
        let passes = color.map(|c| (c + (1.0 - c) * transparency).sqrt());
        return MaterialKind::thin_dielectric(GLASS_INDEX, 1.0, passes);
    }
    MaterialKind::phong(color, color.map(|c| c * (1.0 - GLOSS)), GLOSS, GLOSS_EXPONENT)
}

#[cfg(test)]
mod tests {
    use glanz_light::Wavelengths;
    use glanz_math::DVec3;
    use glanz_shading::texture::{TexturePoint, Textures};

    use super::*;
    use crate::SceneBuilder;

    /// Linear Rec. 709 that a surface of this material reflects and transmits in all, seen along its normal.
    fn albedo(kind: MaterialKind) -> [f32; 3] {
        let (scene, warnings) = SceneBuilder::new()
            .shape(crate::description::ShapeDescription::sphere(1.0), kind)
            .resolve()
            .unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let at = TexturePoint::new(glanz_math::DVec2::ZERO, DVec3::ZERO);
        let wavelengths = Wavelengths::default();
        let bsdf = scene.materials()[0].bsdf(&Textures::new(), &at, &wavelengths).unwrap();
        bsdf.albedo(DVec3::Z).to_rgb(&wavelengths)
    }

    #[test]
    fn every_name_is_a_material() {
        for (name, material) in NAMES {
            assert_eq!(name.parse(), Ok(material));
            assert!(albedo(material.kind()).iter().all(|x| (0.2..=1.0).contains(x)), "{name}");
        }
        assert_eq!("plastic:#ff0000".parse(), Ok(StudioMaterial::Plastic(SrgbColor([255, 0, 0]))));
        for text in ["", "wood", "plastic", "plastic:", "plastic:#ff", "gold:#ffffff"] {
            assert!(text.parse::<StudioMaterial>().is_err(), "{text}");
        }
    }

    #[test]
    fn iron_reflects_half_of_the_light() {
        // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) at 550 nm.
        let expected = (1.95f32.powi(2) + 2.932f32.powi(2)) / (3.95f32.powi(2) + 2.932f32.powi(2));
        let [r, g, b] = albedo(StudioMaterial::Steel.kind());
        assert!((g - expected).abs() < 1e-3, "{g} {expected}");
        assert!((r - b).abs() < 0.06, "iron is grey: {r} {b}");
    }

    #[test]
    fn plastic_has_its_colour_and_creates_no_energy() {
        let [r, g, b] = albedo(cad_material([1.0, 0.5, 0.0], 0.0));
        assert!(r <= 1.0 && (0.48..=0.54).contains(&g) && b <= GLOSS + 1e-6, "{r} {g} {b}");
        assert_eq!(
            albedo(cad_material([f32::NAN, 2.0, -1.0], f32::NAN))[2],
            albedo(cad_material([0.0, 1.0, 0.0], 0.0))[2]
        );
    }

    #[test]
    fn a_clear_part_takes_no_light_and_a_tinted_one_its_colour() {
        assert!(albedo(cad_material([0.0, 0.0, 0.0], 1.0)).iter().all(|x| (x - 1.0).abs() < 1e-5));
        let [r, g, b] = albedo(cad_material([1.0, 0.0, 0.0], 0.25));
        // Each of the two panes passes the square root of 0.25, but for what it reflects.
        assert!((r - 1.0).abs() < 1e-5 && (g - b).abs() < 1e-6 && (0.45..0.6).contains(&g), "{r} {g} {b}");
    }
}
