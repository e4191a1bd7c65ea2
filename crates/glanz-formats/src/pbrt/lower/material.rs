//! `Material`, `MakeNamedMaterial`, `NamedMaterial`.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{
    FloatInput, MaterialDescription, MaterialKind, SpectrumInput, TextureDescription, TextureKind,
};

use super::Lowering;
use super::named::named;
use super::spectrum::grey;
use crate::diagnostic::nearest;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, Values, shortened};
use crate::source::{Place, Step};

/// A material with a name. It may be used before it is made: then its place in the list is kept free.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedMaterial {
    pub(crate) index: usize,
    /// Where it was first used, while it has not been made.
    pub(crate) awaited: Option<Place>,
}

/// Reflectance of the surface of plastic (index 1.5) seen from straight above.
const PLASTIC_SURFACE: f32 = 0.04;

impl Lowering {
    /// Adds a material and gives its index.
    pub(crate) fn material(&mut self, kind: &str, list: ParameterList, space: ColorSpace) -> Step<usize> {
        let location = Some(list.place.location);
        let kind = self.material_kind(kind, list, space)?;
        let materials = &mut self.description.materials;
        materials.push(MaterialDescription { name: String::new(), kind, location });
        Ok(materials.len() - 1)
    }

    /// Makes a material with a name; its type is the parameter `type`.
    pub(crate) fn named_material(
        &mut self,
        name: &str,
        mut list: ParameterList,
        space: ColorSpace,
    ) -> Step<()> {
        let location = Some(list.place.location);
        let Some(kind) = list.text("type", &mut self.reporter)? else {
            let message = format!("material {:?} has no \"string type\"", shortened(name));
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        list.subject = format!("material {kind:?}");
        let kind = self.material_kind(&kind, list, space)?;
        let material = MaterialDescription { name: name.to_owned(), kind, location };
        let materials = &mut self.description.materials;
        let index = match self.materials.get(name) {
            Some(NamedMaterial { index, awaited: Some(_) }) if *index < materials.len() => {
                materials[*index] = material;
                *index
            }
            _ => {
                materials.push(material);
                materials.len() - 1
            }
        };
        self.materials.insert(name.to_owned(), NamedMaterial { index, awaited: None });
        Ok(())
    }

    /// The index of the material of that name, which may come later.
    pub(crate) fn use_material(&mut self, name: &str, place: &Place) -> usize {
        if let Some(material) = self.materials.get(name) {
            return material.index;
        }
        let index = self.add_default(name, place);
        self.materials.insert(name.to_owned(), NamedMaterial { index, awaited: Some(*place) });
        index
    }

    fn add_default(&mut self, name: &str, place: &Place) -> usize {
        let kind = MaterialKind::Diffuse { reflectance: SpectrumInput::Value(grey(0.5)) };
        let location = Some(place.location);
        self.description.materials.push(MaterialDescription { name: name.to_owned(), kind, location });
        self.description.materials.len() - 1
    }

    /// The material of shapes that were given none.
    pub(crate) fn default_material(&mut self, place: &Place) -> usize {
        match self.default_material {
            Some(index) => index,
            None => {
                let index = self.add_default("", place);
                self.default_material = Some(index);
                index
            }
        }
    }

    /// Complains of materials that were used and never made.
    pub(crate) fn check_materials(&mut self) {
        let missing: Vec<(String, Place)> = self
            .materials
            .iter()
            .filter_map(|(name, m)| m.awaited.map(|place| (name.clone(), place)))
            .collect();
        for (name, place) in missing {
            let made = self.materials.iter().filter(|(_, m)| m.awaited.is_none()).map(|(n, _)| n.as_str());
            let help = nearest(&name, made).map(|n| format!("did you mean {n:?}?"));
            let message = format!("there is no material {:?}", shortened(&name));
            self.reporter.error_with_help(&place, "missing-material", message, help);
        }
    }

    fn material_kind(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        space: ColorSpace,
    ) -> Step<MaterialKind> {
        let l = &mut list;
        self.surface_detail(l)?;
        let made = match kind {
            "diffuse" | "matte" => self.diffuse(kind, l, space)?,
            "mirror" => {
                let reflectance = self.spectrum_or(l, "Kr", 0.9, space)?;
                let reflectance = self.optional_spectrum(l, "reflectance", space)?.unwrap_or(reflectance);
                MaterialKind::Mirror { reflectance }
            }
            "conductor" | "metal" => self.conductor(kind, l, ["eta", "k", "reflectance"], space)?,
            "dielectric" | "glass" => self.dielectric(kind, l, space)?,
            "phong" => MaterialKind::Phong {
                ambient: self.spectrum_or(l, "Ka", 0.0, space)?,
                diffuse: self.spectrum_or(l, "Kd", 0.5, space)?,
                specular: self.spectrum_or(l, "Ks", 0.5, space)?,
                exponent: self.float_or(l, "exponent", 10.0)?,
            },
            "" | "none" | "interface" => MaterialKind::Interface,
            other => self.replaced_material(other, l, space)?,
        };
        list.finish(&mut self.reporter);
        Ok(made)
    }

    /// Bumps and the like, which every material may have.
    fn surface_detail(&mut self, list: &mut ParameterList) -> Step<()> {
        for name in ["bumpmap", "displacement", "normalmap"] {
            let place = list.value_place(name);
            if list.take(name).is_some() {
                let message =
                    format!("{}: {name:?} is not available yet; the smooth surface stands in", list.subject);
                self.stand_in(&place, "stand-in-bumps", message);
            }
        }
        Ok(())
    }

    fn diffuse(&mut self, kind: &str, list: &mut ParameterList, space: ColorSpace) -> Step<MaterialKind> {
        let name = if kind == "matte" { "Kd" } else { "reflectance" };
        let reflectance = self.spectrum_or(list, name, 0.5, space)?;
        let place = list.value_place("sigma");
        let sigma = self.float_or(list, "sigma", 0.0)?;
        if !matches!(sigma, FloatInput::Value(0.0)) {
            let message =
                format!("material {kind:?}: \"sigma\" is not available yet; Lambert's law stands in");
            self.stand_in(&place, "stand-in-material", message);
        }
        Ok(MaterialKind::Diffuse { reflectance })
    }

    /// A metal from its index and absorption (copper's by default) or, in version 4, from its reflectance at normal
    /// incidence r: index 1 and absorption `2 sqrt(r / (1 - r))` have it.
    fn conductor(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        [eta, k, reflectance]: [&'static str; 3],
        space: ColorSpace,
    ) -> Step<MaterialKind> {
        let rough = if kind == "metal" { 0.01 } else { 0.0 };
        self.smooth(kind, list, rough)?;
        if let Some(input) = self.optional_spectrum(list, reflectance, space)? {
            return Ok(match input {
                SpectrumInput::Value(
                    r @ (SpectralDistribution::Rgb(_) | SpectralDistribution::Constant(_)),
                ) => {
                    let rgb = match r {
                        SpectralDistribution::Rgb(rgb) => rgb,
                        SpectralDistribution::Constant(x) => [x; 3],
                        _ => [0.0; 3],
                    };
                    let k = rgb.map(|r| {
                        let r = r.clamp(0.0, 0.9999);
                        2.0 * (r / (1.0 - r)).sqrt()
                    });
                    MaterialKind::Conductor {
                        eta: SpectrumInput::Value(grey(1.0)),
                        k: SpectrumInput::Value(SpectralDistribution::Rgb(k)),
                    }
                }
                input => MaterialKind::Mirror { reflectance: input },
            });
        }
        let eta = self.optional_spectrum(list, eta, space)?;
        let k = self.optional_spectrum(list, k, space)?;
        let copper = |name: &str| SpectrumInput::Value(named(name).unwrap_or_default());
        Ok(MaterialKind::Conductor {
            eta: eta.unwrap_or_else(|| copper("metal-Cu-eta")),
            k: k.unwrap_or_else(|| copper("metal-Cu-k")),
        })
    }

    fn dielectric(&mut self, kind: &str, list: &mut ParameterList, space: ColorSpace) -> Step<MaterialKind> {
        self.smooth(kind, list, 0.0)?;
        let index = self.optional_float(list, "index")?;
        let eta = self.optional_float(list, "eta")?.or(index).unwrap_or(FloatInput::Value(1.5));
        Ok(MaterialKind::Dielectric {
            eta,
            reflectance: self.spectrum_or(list, "Kr", 1.0, space)?,
            transmittance: self.spectrum_or(list, "Kt", 1.0, space)?,
        })
    }

    /// Takes out the roughness and says that a smooth surface stands in if it is not 0.
    fn smooth(&mut self, kind: &str, list: &mut ParameterList, default: f32) -> Step<()> {
        let place = ["roughness", "uroughness", "vroughness"]
            .into_iter()
            .find(|name| list.has(name))
            .map_or(list.place, |name| list.value_place(name));
        let given = self.roughness(list, default)?;
        let value = match given {
            FloatInput::Value(0.0) => return Ok(()),
            FloatInput::Value(x) => format!("roughness {x}"),
            FloatInput::Texture(_) => "textured roughness".to_owned(),
        };
        let message = format!("material {kind:?}: {value} is not available yet; a smooth surface stands in");
        self.stand_in(&place, "stand-in-material", message);
        Ok(())
    }

    /// The roughness, the mean of both directions if they differ.
    fn roughness(&mut self, list: &mut ParameterList, default: f32) -> Step<FloatInput> {
        list.ignore(&["remaproughness"]);
        let both = self.float_or(list, "roughness", default)?;
        let u = self.optional_float(list, "uroughness")?;
        let v = self.optional_float(list, "vroughness")?;
        Ok(match (u, v) {
            (None, None) => both,
            (Some(FloatInput::Value(u)), Some(FloatInput::Value(v))) => FloatInput::Value(0.5 * (u + v)),
            (Some(one), _) | (None, Some(one)) => one,
        })
    }

    /// The exponent of a Phong lobe about as wide as pbrt's of that roughness.
    ///
    /// A microfacet distribution of width alpha is about as wide as `cos^m` of the half-angle with
    /// `m = 2 / alpha^2 - 2` (@walter2007). The angle from the mirrored direction is twice the half-angle, so that its
    /// exponent is `m / 4`. pbrt maps roughness to alpha by a polynomial unless told not to.
    fn exponent(&mut self, list: &mut ParameterList, default: f32) -> Step<f32> {
        let remap = list.boolean("remaproughness", &mut self.reporter)?.unwrap_or(true);
        let roughness = match self.roughness(list, default)? {
            FloatInput::Value(x) => x,
            FloatInput::Texture(_) => default,
        };
        let alpha = if remap { roughness_to_alpha(roughness) } else { roughness.max(1e-3) };
        Ok((0.25 * (2.0 / (alpha * alpha) - 2.0)).clamp(0.0, MAX_EXPONENT))
    }

    /// Materials that something else stands in for.
    fn replaced_material(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> Step<MaterialKind> {
        let (made, instead) = match kind {
            "plastic" => {
                let exponent = self.exponent(list, 0.1)?;
                let diffuse = self.spectrum_or(list, "Kd", 0.25, space)?;
                let specular = self.spectrum_or(list, "Ks", 0.25, space)?;
                let specular = self.scaled(specular, PLASTIC_SURFACE, list);
                (phong(diffuse, specular, exponent), format!("\"phong\" with exponent {exponent:.4}"))
            }
            "substrate" => {
                let exponent = self.exponent(list, 0.1)?;
                let diffuse = self.spectrum_or(list, "Kd", 0.5, space)?;
                let specular = self.spectrum_or(list, "Ks", 0.5, space)?;
                // What the coat reflects does not reach the base (Ashikhmin and Shirley's factor 1 - Ks).
                let diffuse = match &specular {
                    SpectrumInput::Value(SpectralDistribution::Constant(s)) => {
                        self.scaled(diffuse, 1.0 - s.clamp(0.0, 1.0), list)
                    }
                    SpectrumInput::Value(SpectralDistribution::Rgb(rgb)) => {
                        let rest = rgb.map(|s| 1.0 - s.clamp(0.0, 1.0));
                        self.product(diffuse, SpectralDistribution::Rgb(rest), list)
                    }
                    _ => diffuse,
                };
                list.ignore(&["d"]);
                (phong(diffuse, specular, exponent), format!("\"phong\" with exponent {exponent:.4}"))
            }
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
                (MaterialKind::Diffuse { reflectance }, "opaque \"diffuse\" of its \"Kd\"".to_owned())
            }
            "translucent" => {
                list.ignore(&["Ks", "roughness", "transmit", "remaproughness"]);
                let base = self.spectrum_or(list, "Kd", 0.25, space)?;
                let reflectance = match self.spectrum_or(list, "reflect", 0.5, space)? {
                    SpectrumInput::Value(share) => self.product(base, share, list),
                    SpectrumInput::Texture(_) => self.scaled(base, 0.5, list),
                };
                (MaterialKind::Diffuse { reflectance }, "\"diffuse\" of what it reflects".to_owned())
            }
            "shinymetal" => {
                list.ignore(&["Ks", "roughness"]);
                let reflectance = self.spectrum_or(list, "Kr", 1.0, space)?;
                (MaterialKind::Mirror { reflectance }, "\"mirror\"".to_owned())
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
            "thindielectric" => {
                list.ignore(&["eta"]);
                (MaterialKind::Interface, "no surface at all".to_owned())
            }
            "mix" => (self.first_of_mix(list)?, "the first of its materials".to_owned()),
            other => (self.diffuse_of(other, list, space)?, String::new()),
        };
        let instead = match (&made, instead.is_empty()) {
            (_, false) => instead,
            _ => "\"diffuse\"".to_owned(),
        };
        let known = KNOWN_MATERIALS.contains(&kind);
        let what = if known { "is not available yet" } else { "is unknown" };
        let message = format!("material {:?} {what}; {instead} stands in", shortened(kind));
        self.stand_in(&list.place, "stand-in-material", message);
        Ok(made)
    }

    /// The reflectance of a material that is shown as a diffuse one, whatever it calls it.
    fn diffuse_of(&mut self, kind: &str, list: &mut ParameterList, space: ColorSpace) -> Step<MaterialKind> {
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
        Ok(MaterialKind::Diffuse { reflectance })
    }

    /// The kind of the first material of a mixture.
    fn first_of_mix(&mut self, list: &mut ParameterList) -> Step<MaterialKind> {
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
    fn scaled(&mut self, input: SpectrumInput, factor: f32, list: &ParameterList) -> SpectrumInput {
        self.product(input, grey(factor), list)
    }

    /// An input times a spectrum, through a texture where need be.
    fn product(
        &mut self,
        input: SpectrumInput,
        factor: SpectralDistribution,
        list: &ParameterList,
    ) -> SpectrumInput {
        use SpectralDistribution::{Constant, Rgb};
        match (&input, &factor) {
            (SpectrumInput::Value(Constant(a)), Constant(b)) => SpectrumInput::Value(Constant(a * b)),
            (SpectrumInput::Value(Rgb(a)), Constant(b)) => SpectrumInput::Value(Rgb(a.map(|a| a * b))),
            (SpectrumInput::Value(Constant(a)), Rgb(b)) => SpectrumInput::Value(Rgb(b.map(|b| a * b))),
            (SpectrumInput::Value(Rgb(a)), Rgb(b)) => {
                SpectrumInput::Value(Rgb(std::array::from_fn(|i| a[i] * b[i])))
            }
            _ => {
                self.description.textures.push(TextureDescription {
                    name: String::new(),
                    kind: TextureKind::Scale(input, SpectrumInput::Value(factor)),
                    location: Some(list.place.location),
                });
                SpectrumInput::Texture(self.description.textures.len() - 1)
            }
        }
    }
}

fn phong(diffuse: SpectrumInput, specular: SpectrumInput, exponent: f32) -> MaterialKind {
    MaterialKind::Phong {
        ambient: SpectrumInput::Value(grey(0.0)),
        diffuse,
        specular,
        exponent: FloatInput::Value(exponent),
    }
}

/// Sharper lobes than this cannot be told from a mirror in `f32`.
const MAX_EXPONENT: f32 = 1e6;

/// pbrt's map from roughness in [0, 1] to the width of a microfacet distribution (@pbrt3 section 8.4.3).
fn roughness_to_alpha(roughness: f32) -> f32 {
    let x = roughness.max(1e-3).ln();
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}

/// Parameters of version 4's coated materials that make no difference to their stand-ins.
const COAT: &[&str] = &["thickness", "g", "albedo", "maxdepth", "nsamples", "twosided", "remaproughness"];

/// Materials of pbrt that are not an unknown word.
const KNOWN_MATERIALS: &[&str] = &[
    "plastic",
    "substrate",
    "uber",
    "translucent",
    "shinymetal",
    "coatedconductor",
    "coateddiffuse",
    "thindielectric",
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
