//! Materials with a glossy surface over another, and sheets that transmit light.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{DescriptionForm, FloatParameter, MaterialKind, SpectrumParameter};
use glanz_shading::model::{
    CoatedDiffuseMaterial, ConductorMaterial, MetalColor, PrincipledMaterial, RoughnessScale,
};

use super::Lowering;
use super::roughness::RoughnessNames;
use super::spectrum::{grey, largest, scaled};
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// Parameters for the random walk by which pbrt samples a coat, which here has a closed form.
const RANDOM_WALK: &[&str] = &["thickness", "g", "maxdepth", "nsamples", "twosided"];

impl Lowering {
    /// Version 4's diffuse base under a coat.
    pub(super) fn coated_diffuse(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        self.clear_coat(list, space)?;
        Ok(MaterialKind::CoatedDiffuse(CoatedDiffuseMaterial {
            reflectance: self.spectrum_or(list, "reflectance", 0.5, space)?,
            eta: self.float_or(list, "eta", 1.5)?,
            roughness: self.roughness(list, RoughnessNames::PLAIN, 0.0)?,
            multiple_scattering: self.multiple_scattering(list)?,
        }))
    }

    /// Version 4's metal under a coat, which does not refract the light of the metal here.
    pub(super) fn coated_conductor(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        self.clear_coat(list, space)?;
        let color = self.metal_color(list, ["conductor.eta", "conductor.k", "reflectance"], space)?;
        let coat_eta = self.float_or(list, "interface.eta", 1.5)?;
        let remap = self.roughness_scale(list)?;
        Ok(MaterialKind::Principled(PrincipledMaterial {
            metallic: FloatParameter::Value(1.0),
            metal: Some(under_coat(color, coat_eta)),
            roughness: self.scaled_roughness(list, RoughnessNames::CONDUCTOR, 0.0, remap)?,
            coat: FloatParameter::Value(1.0),
            coat_roughness: self.scaled_roughness(list, RoughnessNames::INTERFACE, 0.0, remap)?,
            coat_eta,
            multiple_scattering: self.multiple_scattering(list)?,
            ..PrincipledMaterial::new(grey(1.0), 0.0)
        }))
    }

    /// Reads the parameters of the medium in a coat, and reports one that is not clear.
    fn clear_coat(&mut self, list: &mut ParameterList, space: ColorSpace) -> ParseResult<()> {
        list.ignore(RANDOM_WALK);
        let place = list.value_place("albedo");
        if self.spectrum_or(list, "albedo", 0.0, space)? != SpectrumParameter::Value(grey(0.0)) {
            let message =
                format!("{}: \"albedo\" is not available yet; a clear coat stands in", list.subject);
            self.stand_in(&place, "stand-in-material", message);
        }
        Ok(())
    }

    pub(super) fn diffuse_transmission(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let scale = list.float("scale", &mut self.reporter)?.unwrap_or(1.0) as f32;
        let reflectance = self.spectrum_or(list, "reflectance", 0.25, space)?;
        let transmittance = self.spectrum_or(list, "transmittance", 0.25, space)?;
        let [reflectance, transmittance] =
            [reflectance, transmittance].map(|input| self.product(input, grey(scale), list));
        Ok(MaterialKind::diffuse_transmission(reflectance, transmittance))
    }

    /// Version 3's sum of Lambert's law and the highlight of a surface of index 1.5.
    pub(super) fn plastic(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<PrincipledMaterial<DescriptionForm>> {
        Ok(PrincipledMaterial {
            roughness: self.facet_roughness(list, 0.1)?,
            specular: self.spectrum_or(list, "Ks", 0.25, space)?,
            multiple_scattering: self.multiple_scattering(list)?,
            ..PrincipledMaterial::new(self.spectrum_or(list, "Kd", 0.25, space)?, 0.0)
        })
    }

    /// Version 3's diffuse base under a highlight whose reflectance at normal incidence is `Ks`.
    pub(super) fn substrate(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        list.ignore(&["d"]);
        let place = list.value_place("Ks");
        let found = match self.spectrum_or(list, "Ks", 0.5, space)? {
            SpectrumParameter::Value(specular) => index_and_tint(&specular),
            SpectrumParameter::Texture(_) => None,
        };
        if found.is_none() {
            let message = "material \"substrate\": a textured \"Ks\" is not available yet; 0.5 stands in";
            self.stand_in(&place, "stand-in-material", message);
        }
        let (eta, tint) = found.unwrap_or_else(|| (reflecting_index(0.5), grey(1.0)));
        Ok(MaterialKind::Principled(PrincipledMaterial {
            roughness: self.facet_roughness(list, 0.1)?,
            eta: FloatParameter::Value(eta),
            specular: SpectrumParameter::Value(tint),
            multiple_scattering: self.multiple_scattering(list)?,
            ..PrincipledMaterial::new(self.spectrum_or(list, "Kd", 0.5, space)?, 0.0)
        }))
    }

    /// Version 2's metal of a highlight and a mirror, as one rough metal.
    pub(super) fn shiny_metal(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        list.ignore(&["Ks"]);
        let message =
            "material \"shinymetal\" is not available yet; a metal with the reflectance \"Kr\" stands in";
        self.stand_in(&list.place, "stand-in-material", message);
        Ok(MaterialKind::Conductor(ConductorMaterial {
            color: MetalColor::Reflectance(self.spectrum_or(list, "Kr", 1.0, space)?),
            roughness: self.facet_roughness(list, 0.1)?,
            multiple_scattering: self.multiple_scattering(list)?,
            finish: None,
        }))
    }

    /// The principled material, an extension.
    pub(super) fn principled(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let remap = list.boolean("remaproughness", &mut self.reporter)?.unwrap_or(true);
        let scale = if remap { RoughnessScale::Square } else { RoughnessScale::Alpha };
        let names = ["metal.eta", "metal.k", "reflectance"];
        let metal = if names.into_iter().any(|name| list.has(name)) {
            Some(self.metal_color(list, names, space)?)
        } else {
            None
        };
        Ok(MaterialKind::Principled(PrincipledMaterial {
            base_color: self.spectrum_or(list, "basecolor", 0.8, space)?,
            metallic: self.float_or(list, "metallic", 0.0)?,
            metal,
            roughness: self.scaled_roughness(list, RoughnessNames::PLAIN, 0.5, scale)?,
            eta: self.float_or(list, "eta", 1.5)?,
            specular: self.spectrum_or(list, "specular", 1.0, space)?,
            transmission: self.float_or(list, "transmission", 0.0)?,
            thin: list.boolean("thin", &mut self.reporter)?.unwrap_or(false),
            coat: self.float_or(list, "coat", 0.0)?,
            coat_roughness: self.scaled_roughness(list, RoughnessNames::COAT, 0.0, scale)?,
            coat_eta: self.float_or(list, "coat.eta", 1.5)?,
            sheen: self.spectrum_or(list, "sheen", 0.0, space)?,
            sheen_roughness: self.float_or(list, "sheen.roughness", 0.3)?,
            multiple_scattering: self.multiple_scattering(list)?,
        }))
    }
}

/// A metal whose surroundings have the index of a coat, in place of 1. Textures and a reflectance stay as they are.
fn under_coat(color: MetalColor<DescriptionForm>, coat_eta: FloatParameter) -> MetalColor<DescriptionForm> {
    if let MetalColor::Index { eta: SpectrumParameter::Value(eta), k: SpectrumParameter::Value(k) } = &color
        && let FloatParameter::Value(index) = coat_eta
        && index > 0.0
        && let (Some(eta), Some(k)) = (scaled(eta, 1.0 / index), scaled(k, 1.0 / index))
    {
        return MetalColor::Index { eta: SpectrumParameter::Value(eta), k: SpectrumParameter::Value(k) };
    }
    color
}

/// The refractive index whose surface reflects the largest value of a spectrum at normal incidence, and the spectrum over this value; `None` for
/// one without such a value.
fn index_and_tint(reflectance: &SpectralDistribution) -> Option<(f32, SpectralDistribution)> {
    let largest = largest(reflectance)?;
    // Without reflection every tint is right.
    let tint = if largest > 0.0 { scaled(reflectance, 1.0 / largest)? } else { grey(1.0) };
    Some((reflecting_index(largest), tint))
}

/// The refractive index whose surface has this reflectance at normal incidence.
fn reflecting_index(reflectance: f32) -> f32 {
    let root = reflectance.clamp(0.0, 0.98).sqrt();
    (1.0 + root) / (1.0 - root)
}
