//! Version 3's principled material.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{DescriptionForm, FloatParameter, MaterialKind, SpectrumParameter};
use glanz_shading::model::{PrincipledMaterial, Roughness, RoughnessScale};

use super::Lowering;
use super::spectrum::grey;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

impl Lowering {
    /// Version 3's principled material, with the parts that ours has.
    pub(super) fn disney(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let thin = list.boolean("thin", &mut self.reporter)?.unwrap_or(false);
        self.report_left_out(list, thin, space)?;
        let anisotropic = self.constant(list, "anisotropic", 0.0)?;
        let place = list.value_place("roughness");
        let roughness = self.float_or(list, "roughness", 0.5)?;
        if anisotropic != 0.0 && matches!(roughness, FloatParameter::Texture(_)) {
            let message = "material \"disney\": \"anisotropic\" with a textured roughness is not available yet; the same roughness in all directions stands in";
            self.stand_in(&place, "stand-in-material", message);
        }
        let clearcoat = self.constant(list, "clearcoat", 0.0)?;
        let gloss = self.constant(list, "clearcoatgloss", 1.0)?;
        let sheen = self.constant(list, "sheen", 0.0)?;
        let metallic = self.float_or(list, "metallic", 0.0)?;
        let transmission = self.float_or(list, "spectrans", 0.0)?;
        let color = self.spectrum_or(list, "color", 0.5, space)?;
        // Each face of pbrt's glass transmits the root. The colour is also that of the diffuse surface and of metal.
        let is_glass = transmission == FloatParameter::Value(1.0) && metallic == FloatParameter::Value(0.0);
        Ok(MaterialKind::Principled(PrincipledMaterial {
            metallic,
            roughness: stretched(roughness, anisotropic),
            eta: self.float_or(list, "eta", 1.5)?,
            transmission,
            thin,
            // @burley2012: the coat has a quarter of the reflectance of its interface.
            coat: FloatParameter::Value((0.25 * clearcoat).clamp(0.0, 1.0)),
            coat_roughness: Roughness::isotropic(
                FloatParameter::Value((1.0 - gloss) * 0.1 + gloss * 0.001),
                RoughnessScale::Alpha,
            ),
            sheen: SpectrumParameter::Value(grey(sheen.clamp(0.0, 1.0))),
            multiple_scattering: self.multiple_scattering(list)?,
            ..PrincipledMaterial::new(if is_glass { root(color) } else { color }, 0.0)
        }))
    }

    /// Reports parameters without effect here that have one in pbrt.
    fn report_left_out(
        &mut self,
        list: &mut ParameterList,
        thin: bool,
        space: ColorSpace,
    ) -> ParseResult<()> {
        // Name, default, and the value that changes nothing here.
        let mut left_out =
            vec![("speculartint", 0.0, 0.0), ("scatterdistance", 0.0, 0.0), ("sheentint", 0.5, 0.5)];
        if thin {
            left_out.extend([("difftrans", 1.0, 0.0), ("flatness", 0.0, 0.0)]);
        } else {
            list.ignore(&["difftrans", "flatness"]);
        }
        for (name, default, neutral) in left_out {
            let place = list.value_place(name);
            if self.spectrum_or(list, name, default, space)? != SpectrumParameter::Value(grey(neutral)) {
                let message = format!("material \"disney\": {name:?} is not available yet; 0 stands in");
                self.stand_in(&place, "stand-in-material", message);
            }
        }
        Ok(())
    }

    /// A number; its default stands in for a texture.
    fn constant(&mut self, list: &mut ParameterList, name: &'static str, default: f32) -> ParseResult<f32> {
        let place = list.value_place(name);
        match self.float_or(list, name, default)? {
            FloatParameter::Value(value) => Ok(value),
            FloatParameter::Texture(_) => {
                let message = format!(
                    "material \"disney\": a textured {name:?} is not available yet; {default} stands in"
                );
                self.stand_in(&place, "stand-in-material", message);
                Ok(default)
            }
        }
    }
}

/// The square root of a spectrum without texture.
fn root(color: SpectrumParameter) -> SpectrumParameter {
    use SpectralDistribution::{Constant, Rgb, Sampled};
    let root = |x: f32| x.max(0.0).sqrt();
    match color {
        SpectrumParameter::Value(Constant(x)) => SpectrumParameter::Value(Constant(root(x))),
        SpectrumParameter::Value(Rgb(rgb)) => SpectrumParameter::Value(Rgb(rgb.map(root))),
        SpectrumParameter::Value(Sampled(samples)) => {
            let roots: Vec<_> = samples.points().iter().map(|&(nm, x)| (nm, root(x))).collect();
            SpectrumParameter::Value(SpectralDistribution::try_sampled(roots).unwrap_or(Sampled(samples)))
        }
        other => other,
    }
}

/// The roughness of facets that are longer along u by an anisotropy in [0, 1], in the scale [`RoughnessScale::Square`] (@burley2012).
fn stretched(roughness: FloatParameter, anisotropic: f32) -> Roughness<DescriptionForm> {
    let stretch = (1.0 - 0.9 * anisotropic.clamp(0.0, 1.0)).sqrt().sqrt();
    match roughness {
        FloatParameter::Value(r) => Roughness {
            u: FloatParameter::Value(r / stretch),
            v: FloatParameter::Value(r * stretch),
            scale: RoughnessScale::Square,
        },
        texture => Roughness::isotropic(texture, RoughnessScale::Square),
    }
}
