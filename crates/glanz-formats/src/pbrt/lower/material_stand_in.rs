//! Substitutes for unsupported materials.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{
    FloatParameter, MaterialKind, SpectrumParameter, TextureDescription, TextureKind,
};

use super::Lowering;
use super::spectrum::grey;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, Values, shortened};
use crate::source::ParseResult;

/// Reflectance of the surface of plastic (index 1.5) seen from straight above.
const PLASTIC_SURFACE: f32 = 0.04;

/// A material and its description in messages.
type MaterialStandIn = (MaterialKind, String);

impl Lowering {
    /// The exponent of a Phong lobe about as wide as pbrt's of that roughness.
    ///
    /// A microfacet distribution of width alpha is about as wide as `cos^m` of the half-angle with
    /// `m = 2 / alpha^2 - 2` (@walter2007). The angle from the mirrored direction is twice the half-angle, so that its
    /// exponent is `m / 4`. pbrt maps roughness to alpha by a polynomial unless this is switched off.
    fn exponent(&mut self, list: &mut ParameterList, default: f32) -> ParseResult<f32> {
        let remap = list.boolean("remaproughness", &mut self.reporter)?.unwrap_or(true);
        let roughness = match self.roughness(list, default)? {
            FloatParameter::Value(x) => x,
            FloatParameter::Texture(_) => default,
        };
        let alpha = if remap { roughness_to_alpha(roughness) } else { roughness.max(1e-3) };
        Ok((0.25 * (2.0 / (alpha * alpha) - 2.0)).clamp(0.0, MAX_EXPONENT))
    }

    /// Lowers an unsupported material to its substitute.
    pub(super) fn replaced_material(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let (made, instead) = match kind {
            "plastic" => self.plastic(list, space)?,
            "substrate" => self.substrate(list, space)?,
            "uber" => {
                list.ignore(&[
                    "Ks",
                    "Kr",
                    "Kt",
                    "roughness",
                    "uroughness",
                    "vroughness",
                    "eta",
                    "index",
                    "opacity",
                    "remaproughness",
                ]);
                let reflectance = self.spectrum_or(list, "Kd", 0.25, space)?;
                (MaterialKind::diffuse(reflectance), "opaque \"diffuse\" of its \"Kd\"".to_owned())
            }
            "translucent" => self.translucent(list, space)?,
            "shinymetal" => {
                list.ignore(&["Ks", "roughness"]);
                let reflectance = self.spectrum_or(list, "Kr", 1.0, space)?;
                (MaterialKind::mirror(reflectance), "\"mirror\"".to_owned())
            }
            "coatedconductor" => {
                list.ignore(COAT);
                list.ignore(&[
                    "interface.roughness",
                    "interface.uroughness",
                    "interface.vroughness",
                    "interface.eta",
                ]);
                list.ignore(&["conductor.roughness", "conductor.uroughness", "conductor.vroughness"]);
                let names = ["conductor.eta", "conductor.k", "reflectance"];
                let made = self.conductor("coatedconductor", list, names, space)?;
                (made, "the bare \"conductor\"".to_owned())
            }
            "mix" => (self.first_of_mix(list)?, "the first of its materials".to_owned()),
            other => (self.diffuse_of(other, list, space)?, "\"diffuse\"".to_owned()),
        };
        let known = KNOWN_MATERIALS.contains(&kind);
        let what = if known { "is not available yet" } else { "is unknown" };
        let message = format!("material {:?} {what}; {instead} stands in", shortened(kind));
        self.stand_in(&list.place, "stand-in-material", message);
        Ok(made)
    }

    /// A diffuse base and the reflection of a surface of index 1.5.
    fn plastic(&mut self, list: &mut ParameterList, space: ColorSpace) -> ParseResult<MaterialStandIn> {
        let exponent = self.exponent(list, 0.1)?;
        let diffuse = self.spectrum_or(list, "Kd", 0.25, space)?;
        let specular = self.spectrum_or(list, "Ks", 0.25, space)?;
        let specular = self.scaled(specular, PLASTIC_SURFACE, list);
        Ok(phong(diffuse, specular, exponent))
    }

    /// A diffuse base under a coat. Light reflected by the coat does not reach the base (Ashikhmin and Shirley's factor
    /// 1 - Ks).
    fn substrate(&mut self, list: &mut ParameterList, space: ColorSpace) -> ParseResult<MaterialStandIn> {
        let exponent = self.exponent(list, 0.1)?;
        let diffuse = self.spectrum_or(list, "Kd", 0.5, space)?;
        let specular = self.spectrum_or(list, "Ks", 0.5, space)?;
        let diffuse = match &specular {
            SpectrumParameter::Value(SpectralDistribution::Constant(s)) => {
                self.scaled(diffuse, 1.0 - s.clamp(0.0, 1.0), list)
            }
            SpectrumParameter::Value(SpectralDistribution::Rgb(rgb)) => {
                let rest = rgb.map(|s| 1.0 - s.clamp(0.0, 1.0));
                self.product(diffuse, SpectralDistribution::Rgb(rest), list)
            }
            _ => diffuse,
        };
        list.ignore(&["d"]);
        Ok(phong(diffuse, specular, exponent))
    }

    /// The reflected part.
    fn translucent(&mut self, list: &mut ParameterList, space: ColorSpace) -> ParseResult<MaterialStandIn> {
        list.ignore(&["Ks", "roughness", "transmit", "remaproughness"]);
        let base = self.spectrum_or(list, "Kd", 0.25, space)?;
        let reflectance = match self.spectrum_or(list, "reflect", 0.5, space)? {
            SpectrumParameter::Value(share) => self.product(base, share, list),
            SpectrumParameter::Texture(_) => self.scaled(base, 0.5, list),
        };
        Ok((MaterialKind::diffuse(reflectance), "\"diffuse\" of what it reflects".to_owned()))
    }

    /// The reflectance of a material with a diffuse substitute, under any of its names.
    fn diffuse_of(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let (name, default) = match kind {
            "diffusetransmission" => ("reflectance", 0.25),
            "coateddiffuse" | "subsurface" => ("reflectance", 0.5),
            "disney" => ("color", 0.5),
            _ => ("Kd", 0.5),
        };
        let reflectance = self.spectrum_or(list, name, default, space)?;
        let known = KNOWN_MATERIALS.contains(&kind);
        if known {
            list.ignore(COAT);
            list.ignore(&[
                "Kr",
                "Kt",
                "Ks",
                "mfp",
                "eta",
                "uroughness",
                "vroughness",
                "roughness",
                "sigma_a",
                "sigma_s",
            ]);
            list.ignore(&[
                "bsdffile",
                "filename",
                "transmittance",
                "scale",
                "name",
                "metallic",
                "speculartint",
            ]);
            list.ignore(&[
                "anisotropic",
                "sheen",
                "sheentint",
                "clearcoat",
                "clearcoatgloss",
                "spectrans",
                "flatness",
            ]);
            list.ignore(&[
                "difftrans",
                "scatterdistance",
                "thin",
                "eumelanin",
                "pheomelanin",
                "color",
                "beta_m",
            ]);
            list.ignore(&["beta_n", "alpha", "Kd", "reflectance"]);
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

    /// An input times a number.
    fn scaled(&mut self, input: SpectrumParameter, factor: f32, list: &ParameterList) -> SpectrumParameter {
        self.product(input, grey(factor), list)
    }

    /// An input times a spectrum, by a texture if necessary.
    fn product(
        &mut self,
        input: SpectrumParameter,
        factor: SpectralDistribution,
        list: &ParameterList,
    ) -> SpectrumParameter {
        use SpectralDistribution::{Constant, Rgb};
        match (&input, &factor) {
            (SpectrumParameter::Value(Constant(a)), Constant(b)) => SpectrumParameter::Value(Constant(a * b)),
            (SpectrumParameter::Value(Rgb(a)), Constant(b)) => {
                SpectrumParameter::Value(Rgb(a.map(|a| a * b)))
            }
            (SpectrumParameter::Value(Constant(a)), Rgb(b)) => {
                SpectrumParameter::Value(Rgb(b.map(|b| a * b)))
            }
            (SpectrumParameter::Value(Rgb(a)), Rgb(b)) => {
                SpectrumParameter::Value(Rgb(std::array::from_fn(|i| a[i] * b[i])))
            }
            _ => {
                self.description.textures.push(TextureDescription {
                    name: String::new(),
                    kind: TextureKind::Scale(input, SpectrumParameter::Value(factor)),
                    location: Some(list.place.location),
                });
                SpectrumParameter::Texture(self.description.textures.len() - 1)
            }
        }
    }
}

/// A Phong material. The ambient reflectance is that of the diffuse base.
fn phong(diffuse: SpectrumParameter, specular: SpectrumParameter, exponent: f32) -> MaterialStandIn {
    (
        MaterialKind::phong(diffuse.clone(), diffuse, specular, exponent),
        format!("\"phong\" with exponent {exponent:.4}"),
    )
}

/// Largest exponent: in `f32`, sharper lobes cannot be distinguished from a mirror.
const MAX_EXPONENT: f32 = 1e6;

/// pbrt's map from roughness in [0, 1] to the width of a microfacet distribution (@pbrt3 section 8.4.3).
fn roughness_to_alpha(roughness: f32) -> f32 {
    let x = roughness.max(1e-3).ln();
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}

/// Parameters of version 4's coated materials without effect on their substitutes.
const COAT: &[&str] = &["thickness", "g", "albedo", "maxdepth", "nsamples", "twosided", "remaproughness"];

/// Names of pbrt's other materials.
const KNOWN_MATERIALS: &[&str] = &[
    "plastic",
    "substrate",
    "uber",
    "translucent",
    "shinymetal",
    "coatedconductor",
    "coateddiffuse",
    "mix",
    "diffusetransmission",
    "subsurface",
    "kdsubsurface",
    "hair",
    "fourier",
    "measured",
    "disney",
    "bluepaint",
    "brushedmetal",
    "clay",
    "felt",
    "primer",
    "skin",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roughness_of_one_is_the_constant_of_the_polynomial() {
        assert!((roughness_to_alpha(1.0) - 1.62142).abs() < 1e-6);
        // ln 0.1 = -2.302585: 1.62142 - 1.888017 + 0.919340 - 0.209003 + 0.018010 = 0.461750
        assert!((roughness_to_alpha(0.1) - 0.46175).abs() < 1e-5);
    }
}
