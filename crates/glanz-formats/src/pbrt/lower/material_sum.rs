//! Materials of version 3 that are sums of scattering models, as mixtures.
//!
//! Each model is selected with a probability, by which its colours are divided.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{
    FloatParameter, MaterialDescription, MaterialKind, SpectrumParameter, TextureDescription, TextureKind,
};
use glanz_shading::model::{DielectricMaterial, DiffuseTransmissionMaterial, PrincipledMaterial, Roughness};

use super::Lowering;
use super::spectrum::{grey, largest};
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// A part of a material that lets light pass.
struct Opening {
    /// Probability of the opening.
    amount: FloatParameter,
    /// Colour of the light that passes, and factor on the colours of the rest.
    colors: [SpectralDistribution; 2],
}

impl Lowering {
    /// The sum of Lambert's law, a highlight, a mirror and glass, of which `opacity` lets a part of the light pass.
    pub(super) fn uber(&mut self, list: &mut ParameterList, space: ColorSpace) -> ParseResult<MaterialKind> {
        let index = self.float_or(list, "index", 1.5)?;
        let eta = self.optional_float(list, "eta")?.unwrap_or(index);
        let plastic = PrincipledMaterial { eta, ..self.plastic(list, space)? };
        let glass = DielectricMaterial {
            eta,
            reflectance: self.spectrum_or(list, "Kr", 0.0, space)?,
            transmittance: self.spectrum_or(list, "Kt", 0.0, space)?,
            thin: false,
            dispersion: None,
            roughness: Roughness::smooth(),
            multiple_scattering: true,
        };
        let sizes = [
            brightness(&plastic.base_color).max(brightness(&plastic.specular)),
            brightness(&glass.reflectance).max(brightness(&glass.transmittance)),
        ];
        let textured = [[&plastic.base_color, &plastic.specular], [&glass.reflectance, &glass.transmittance]]
            .map(any_texture);
        let opening = self.open_part(list, space, (sizes[0] + sizes[1]).min(1.0))?;
        let parts = [MaterialKind::Principled(plastic), MaterialKind::Dielectric(glass)];
        let opaque = self.sum(parts, sizes, textured, list);
        let Some(Opening { amount, colors: [passing, rest] }) = opening else { return Ok(opaque) };
        let pane = MaterialKind::Dielectric(DielectricMaterial {
            eta: FloatParameter::Value(1.0),
            reflectance: SpectrumParameter::Value(grey(0.0)),
            transmittance: SpectrumParameter::Value(passing),
            thin: true,
            dispersion: None,
            roughness: Roughness::smooth(),
            multiple_scattering: true,
        });
        let opaque = self.tinted(opaque, &rest, list);
        let materials = [opaque, pane].map(|part| self.add_part(part, list));
        Ok(MaterialKind::mix(materials, amount))
    }

    /// The part that `opacity` leaves open; `None` if it is 1. `size`: the largest colour of the rest.
    fn open_part(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
        size: f32,
    ) -> ParseResult<Option<Opening>> {
        let place = list.value_place("opacity");
        let opacity = match self.spectrum_or(list, "opacity", 1.0, space)? {
            SpectrumParameter::Value(opacity) => opacity,
            SpectrumParameter::Texture(texture) => {
                let amount = FloatParameter::Texture(texture);
                let kind = TextureKind::Mix { a: 1.0.into(), b: 0.0.into(), amount };
                let amount = FloatParameter::Texture(self.add_texture(kind, list));
                return Ok(Some(Opening { amount, colors: [grey(1.0), grey(1.0)] }));
            }
        };
        let rgb = match &opacity {
            SpectralDistribution::Rgb(rgb) => rgb.map(|x| x.clamp(0.0, 1.0)),
            other => [largest(other).unwrap_or(1.0).clamp(0.0, 1.0); 3],
        };
        if rgb == [rgb[0]; 3] {
            let amount = FloatParameter::Value(1.0 - rgb[0]);
            return Ok((rgb[0] < 1.0).then_some(Opening { amount, colors: [grey(1.0), grey(1.0)] }));
        }
        // Each part gets the share that its largest component needs: divided colours above 1 are clamped.
        let open = rgb.map(|x| 1.0 - x);
        let [passing, rest] =
            [(open, 1.0), (rgb, size)].map(|(part, size)| size * part.into_iter().fold(0.0, f32::max));
        let total = passing + rest;
        if total > 1.0 {
            let message = format!(
                "{}: no mixture has this coloured opacity; one that lets less light pass stands in",
                list.subject
            );
            self.stand_in(&place, "stand-in-material", message);
        }
        let amount = passing / total;
        let over = |part: [f32; 3], share: f32| match share > 0.0 {
            true => SpectralDistribution::Rgb(part.map(|x| x / share)),
            false => grey(1.0),
        };
        let colors = [over(open, amount), over(rgb, 1.0 - amount)];
        Ok(Some(Opening { amount: FloatParameter::Value(amount), colors }))
    }

    /// A sheet: the sum of Lambert's law and of rough glass of index 1.5, each on both sides.
    pub(super) fn translucent(
        &mut self,
        list: &mut ParameterList,
        space: ColorSpace,
    ) -> ParseResult<MaterialKind> {
        let base = self.spectrum_or(list, "Kd", 0.25, space)?;
        let specular = self.spectrum_or(list, "Ks", 0.25, space)?;
        let roughness = self.facet_roughness(list, 0.1)?;
        let [reflect, transmit] =
            [self.spectrum_or(list, "reflect", 0.5, space)?, self.spectrum_or(list, "transmit", 0.5, space)?];
        let mut part = |color: &SpectrumParameter, share: &SpectrumParameter| match (share, color) {
            (SpectrumParameter::Value(share), color) => self.product(color.clone(), share.clone(), list),
            (texture, SpectrumParameter::Value(color)) => self.product(texture.clone(), color.clone(), list),
            (share, color) => self.texture_product(color.clone(), share.clone(), list),
        };
        let sheet = DiffuseTransmissionMaterial {
            reflectance: part(&base, &reflect),
            transmittance: part(&base, &transmit),
        };
        let glass = DielectricMaterial {
            eta: FloatParameter::Value(1.5),
            reflectance: part(&specular, &reflect),
            transmittance: part(&specular, &transmit),
            thin: false,
            dispersion: None,
            roughness,
            multiple_scattering: self.multiple_scattering(list)?,
        };
        let sizes = [
            brightness(&sheet.reflectance) + brightness(&sheet.transmittance),
            brightness(&glass.reflectance).max(brightness(&glass.transmittance)),
        ];
        let textured =
            [[&sheet.reflectance, &sheet.transmittance], [&glass.reflectance, &glass.transmittance]]
                .map(any_texture);
        let parts = [MaterialKind::DiffuseTransmission(sheet), MaterialKind::Dielectric(glass)];
        Ok(self.sum(parts, sizes, textured, list))
    }

    /// The sum of two materials that scatter these fractions of light at most. Where both together scatter more than
    /// all light, constant colours are divided by the sum of the fractions, and those of a part with textures are
    /// clamped at shading.
    fn sum(
        &mut self,
        parts: [MaterialKind; 2],
        sizes: [f32; 2],
        textured: [bool; 2],
        list: &ParameterList,
    ) -> MaterialKind {
        let [first, second] = parts;
        if sizes[1] <= 0.0 {
            return first;
        }
        if sizes[0] <= 0.0 {
            return second;
        }
        let total = sizes[0] + sizes[1];
        // Of a texture only the bound is known: where it is dark, nothing has to be scaled down.
        let factor = |part: usize| grey(if textured[part] { total } else { total.min(1.0) } / sizes[part]);
        let [a, b] = [0, 1].map(factor);
        let materials = [self.tinted(first, &a, list), self.tinted(second, &b, list)];
        let materials = materials.map(|part| self.add_part(part, list));
        MaterialKind::mix(materials, sizes[1] / total)
    }

    /// A material with its colours times a factor.
    fn tinted(
        &mut self,
        kind: MaterialKind,
        factor: &SpectralDistribution,
        list: &ParameterList,
    ) -> MaterialKind {
        let mut times = |color: SpectrumParameter| self.product(color, factor.clone(), list);
        match kind {
            MaterialKind::Principled(material) => MaterialKind::Principled(PrincipledMaterial {
                base_color: times(material.base_color.clone()),
                specular: times(material.specular.clone()),
                ..material
            }),
            MaterialKind::Dielectric(material) => MaterialKind::Dielectric(DielectricMaterial {
                reflectance: times(material.reflectance.clone()),
                transmittance: times(material.transmittance.clone()),
                ..material
            }),
            MaterialKind::DiffuseTransmission(material) => {
                MaterialKind::diffuse_transmission(times(material.reflectance), times(material.transmittance))
            }
            MaterialKind::Mix(mix) => {
                for part in mix.materials {
                    let kind = self.description.materials.get(part).map(|part| part.kind.clone());
                    let tinted = kind.map(|kind| self.tinted(kind, factor, list));
                    if let (Some(tinted), Some(part)) = (tinted, self.description.materials.get_mut(part)) {
                        part.kind = tinted;
                    }
                }
                MaterialKind::Mix(mix)
            }
            other => other,
        }
    }

    /// Adds a material without a name, a part of another, and returns its index.
    fn add_part(&mut self, kind: MaterialKind, list: &ParameterList) -> usize {
        // A failure is reported, and ends reading at the next directive.
        let _ = self.spend_entry::<MaterialDescription>("", &list.place);
        let materials = &mut self.description.materials;
        materials.push(MaterialDescription { location: Some(list.place.location), ..kind.into() });
        materials.len() - 1
    }

    /// An input times a spectrum, by a texture if necessary.
    pub(super) fn product(
        &mut self,
        input: SpectrumParameter,
        factor: SpectralDistribution,
        list: &ParameterList,
    ) -> SpectrumParameter {
        use SpectralDistribution::{Constant, Rgb};
        match (&input, &factor) {
            (_, Constant(1.0)) => input,
            (SpectrumParameter::Value(Constant(a)), Constant(b)) => SpectrumParameter::Value(Constant(a * b)),
            (SpectrumParameter::Value(Rgb(a)), Constant(b))
            | (SpectrumParameter::Value(Constant(b)), Rgb(a)) => {
                SpectrumParameter::Value(Rgb(a.map(|a| a * b)))
            }
            (SpectrumParameter::Value(Rgb(a)), Rgb(b)) => {
                SpectrumParameter::Value(Rgb(std::array::from_fn(|i| a[i] * b[i])))
            }
            _ => self.texture_product(input, SpectrumParameter::Value(factor), list),
        }
    }

    fn texture_product(
        &mut self,
        a: SpectrumParameter,
        b: SpectrumParameter,
        list: &ParameterList,
    ) -> SpectrumParameter {
        SpectrumParameter::Texture(self.add_texture(TextureKind::Scale(a, b), list))
    }

    /// Adds a texture without a name and returns its index.
    pub(super) fn add_texture(&mut self, kind: TextureKind, list: &ParameterList) -> usize {
        // A failure is reported, and ends reading at the next directive.
        let _ = self.spend_entry::<TextureDescription>("", &list.place);
        let textures = &mut self.description.textures;
        textures.push(TextureDescription { name: String::new(), kind, location: Some(list.place.location) });
        textures.len() - 1
    }
}

fn any_texture(colors: [&SpectrumParameter; 2]) -> bool {
    colors.into_iter().any(|color| matches!(color, SpectrumParameter::Texture(_)))
}

/// The largest fraction of light that a colour scatters; of a texture 1.
fn brightness(color: &SpectrumParameter) -> f32 {
    match color {
        SpectrumParameter::Value(value) => largest(value).unwrap_or(1.0).clamp(0.0, 1.0),
        SpectrumParameter::Texture(_) => 1.0,
    }
}
