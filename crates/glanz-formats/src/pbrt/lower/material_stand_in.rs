//! Substitutes for unsupported materials.

use glanz_scene::description::MaterialKind;

use super::Lowering;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, Values, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// Lowers an unsupported material to its substitute.
    pub(super) fn replaced_material(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let (made, instead) = match kind {
            "mix" => (self.first_of_mix(list)?, "the first of its materials".to_owned()),
            other => (self.diffuse_of(other, list, space)?, "\"diffuse\"".to_owned()),
        };
        let known = KNOWN_MATERIALS.contains(&kind);
        let what = if known { "is not available yet" } else { "is unknown" };
        let message = format!("material {:?} {what}; {instead} stands in", shortened(kind));
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

    /// The kind of the first material of a mixture.
    fn first_of_mix(&mut self, list: &mut ParameterList) -> ParseResult<MaterialKind> {
        list.ignore(&["amount", "namedmaterial2"]);
        let first = list.take("namedmaterial1").or_else(|| list.take("materials"));
        let name = first.as_ref().and_then(|p| match &p.values {
            Values::Texts(names) => names.first(),
            _ => None,
        });
        let Some((name, p)) = name.zip(first.as_ref()) else {
            let message = "material \"mix\" does not say of which materials";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let index = match name.as_str() {
            "interface" if self.dialect == Dialect::V4 => return Ok(MaterialKind::Interface),
            name => self.materials.get(name).filter(|m| m.awaited.is_none()).map(|m| m.index),
        };
        match index.and_then(|i| self.description.materials.get(i)) {
            Some(material) => Ok(material.kind.clone()),
            None => {
                let message = format!("material \"mix\": there is no material {:?}", shortened(name));
                Err(self.reporter.error(&p.value_place, "missing-material", message))
            }
        }
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
    "mix",
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
