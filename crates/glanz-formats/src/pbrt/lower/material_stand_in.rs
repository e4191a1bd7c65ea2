//! Substitutes for unsupported materials.

use glanz_scene::description::MaterialKind;

use super::Lowering;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// Lowers an unsupported material to its substitute.
    pub(super) fn replaced_material(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let made = self.diffuse_of(kind, list, space)?;
        let known = KNOWN_MATERIALS.contains(&kind);
        let what = if known { "is not available yet" } else { "is unknown" };
        let message = format!("material {:?} {what}; \"diffuse\" stands in", shortened(kind));
        self.stand_in(&list.place, "stand-in-material", message);
        Ok(made)
    }

    /// The reflectance of a material with a diffuse substitute, under any of its names.
    fn diffuse_of(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let name = if kind == "subsurface" { "reflectance" } else { "Kd" };
        let reflectance = self.spectrum_or(list, name, 0.5, space)?;
        if KNOWN_MATERIALS.contains(&kind) {
            list.ignore(OTHER_PARAMETERS);
        }
        Ok(MaterialKind::diffuse(reflectance))
    }
}

/// Parameters without effect on the diffuse substitute.
const OTHER_PARAMETERS: &[&str] = &[
    "Kr",
    "Kt",
    "Ks",
    "mfp",
    "eta",
    "uroughness",
    "vroughness",
    "roughness",
    "remaproughness",
    "sigma_a",
    "sigma_s",
    "g",
    "bsdffile",
    "filename",
    "scale",
    "name",
    "eumelanin",
    "pheomelanin",
    "color",
    "beta_m",
    "beta_n",
    "alpha",
    "Kd",
    "reflectance",
];

/// Names of pbrt's other materials.
const KNOWN_MATERIALS: &[&str] = &[
    "subsurface",
    "kdsubsurface",
    "hair",
    "fourier",
    "measured",
    "bluepaint",
    "brushedmetal",
    "clay",
    "felt",
    "primer",
    "skin",
];
