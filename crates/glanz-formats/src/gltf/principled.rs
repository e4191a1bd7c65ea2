//! The metallic-roughness model and its extensions as the principled material.

use glanz_scene::description::{DescriptionForm, FloatParameter, SpectrumParameter};
use glanz_shading::model::{PrincipledMaterial, Roughness, RoughnessScale};

use super::GltfReader;
use super::error::GltfError;
use super::json::JsonObject;
use super::texture::{TextureUse, UvSource};
use crate::model::grey;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const SPECULAR: &str = "KHR_materials_specular";
const TRANSMISSION: &str = "KHR_materials_transmission";

/// Members of extensions that are textures.
pub(super) const TEXTURES: [(&str, &[&str]); 4] = [
    (TRANSMISSION, &["transmissionTexture"]),
    (SPECULAR, &["specularTexture", "specularColorTexture"]),
    (CLEARCOAT, &["clearcoatTexture", "clearcoatRoughnessTexture"]),
    (SHEEN, &["sheenColorTexture", "sheenRoughnessTexture"]),
];

/// Largest refractive index.
const MAX_INDEX: f64 = 1e3;

impl GltfReader<'_, '_> {
    /// The material (@khr_gltf section 3.9, appendix B). `base`: the coordinates of the meshes.
    pub(super) fn principled(
        &mut self,
        material: &JsonObject<'_>,
        base: &UvSource,
    ) -> Result<PrincipledMaterial<DescriptionForm>, GltfError> {
        let (base_color, metallic, roughness) = material.object_or_empty("pbrMetallicRoughness", |pbr| {
            let rough = TextureUse::of(&pbr, "metallicRoughnessTexture")?;
            let [r, g, b, _] = pbr.color("baseColorFactor")?.unwrap_or([1.0; 4]);
            let color = TextureUse::of(&pbr, "baseColorTexture")?;
            let color = self.color_texture(color, [r, g, b], base, &pbr)?;
            let metallic = self.number_texture(rough, 2, pbr.fraction("metallicFactor", 1.0)?, base, &pbr)?;
            let roughness = pbr.fraction("roughnessFactor", 1.0)?;
            Ok((color, metallic, self.number_texture(rough, 1, roughness, base, &pbr)?))
        })?;
        let mut number = |extension: &str, factor: (&'static str, f64), texture: (&str, u8)| {
            self.extension_number((material, extension), factor, texture, base)
        };
        let transmission = number(TRANSMISSION, ("transmissionFactor", 0.0), ("transmissionTexture", 0))?;
        let strength = number(SPECULAR, ("specularFactor", 1.0), ("specularTexture", 3))?;
        let coat = number(CLEARCOAT, ("clearcoatFactor", 0.0), ("clearcoatTexture", 0))?;
        let coat_roughness =
            number(CLEARCOAT, ("clearcoatRoughnessFactor", 0.0), ("clearcoatRoughnessTexture", 1))?;
        let sheen_roughness = number(SHEEN, ("sheenRoughnessFactor", 0.0), ("sheenRoughnessTexture", 3))?;
        let sheen = self.extension_color(
            (material, SHEEN),
            "sheenColorFactor",
            "sheenColorTexture",
            ([0.0; 3], base),
            |c| c,
        )?;
        let thin = material.extension("KHR_materials_volume", |found| {
            let thickness = found.map(|volume| volume.positive("thicknessFactor", 0.0)).transpose()?;
            Ok(thickness.unwrap_or(0.0) == 0.0)
        })?;
        let (eta, specular) = self.specular(material, strength, transmission == 0.0.into(), base)?;
        Ok(PrincipledMaterial {
            metallic,
            eta,
            specular,
            transmission,
            thin,
            coat,
            coat_roughness: Roughness::isotropic(coat_roughness, RoughnessScale::Square),
            sheen,
            sheen_roughness,
            ..PrincipledMaterial::new(base_color, roughness)
        })
    }

    /// The refractive index and the factor on what the interface reflects. The index makes up for colours above 1 where no light passes.
    fn specular(
        &mut self,
        material: &JsonObject<'_>,
        strength: FloatParameter,
        is_opaque: bool,
        base: &UvSource,
    ) -> Result<(FloatParameter, SpectrumParameter), GltfError> {
        let ior = material.extension("KHR_materials_ior", |found| {
            Ok(found.map(|object| object.positive("ior", 1.5)).transpose()?.unwrap_or(1.5))
        })?;
        // 0 stands for infinity: everything is reflected.
        let mut ior = if ior < 1.0 { MAX_INDEX } else { ior.min(MAX_INDEX) };
        let amplitude = (ior - 1.0) / (ior + 1.0);
        let color = self.extension_color(
            (material, SPECULAR),
            "specularColorFactor",
            "specularColorTexture",
            ([1.0; 3], base),
            |color| {
                // The colour is limited before the factor applies.
                let color = color.map(|c| c.min((1.0 / amplitude).powi(2)));
                let most = color.iter().copied().fold(1.0, f64::max);
                if is_opaque && most > 1.0 {
                    let amplitude = amplitude * most.sqrt();
                    ior = if amplitude < 1.0 {
                        ((1.0 + amplitude) / (1.0 - amplitude)).min(MAX_INDEX)
                    } else {
                        MAX_INDEX
                    };
                    return color.map(|c| c / most);
                }
                color
            },
        )?;
        let specular = match strength {
            FloatParameter::Value(1.0) => color,
            strength => self.scaled_color(color, strength),
        };
        Ok(((ior as f32).into(), specular))
    }

    /// A number of an extension: a factor times a channel of a texture.
    fn extension_number(
        &mut self,
        (material, extension): (&JsonObject<'_>, &str),
        (factor, default): (&'static str, f64),
        (texture, channel): (&str, u8),
        base: &UvSource,
    ) -> Result<FloatParameter, GltfError> {
        material.extension(extension, |found| {
            let Some(object) = found else { return Ok((default as f32).into()) };
            let factor = object.positive(factor, default)?.min(1.0);
            let texture = TextureUse::of(&object, texture)?;
            self.number_texture(texture, channel, factor, base, &object)
        })
    }

    /// A colour of an extension: a changed factor times a texture.
    fn extension_color(
        &mut self,
        (material, extension): (&JsonObject<'_>, &str),
        factor: &'static str,
        texture: &str,
        (default, base): ([f64; 3], &UvSource),
        change: impl FnOnce([f64; 3]) -> [f64; 3],
    ) -> Result<SpectrumParameter, GltfError> {
        material.extension(extension, |found| {
            let Some(object) = found else { return Ok(default.map(|x| x as f32).into()) };
            let factor = object.color(factor)?.unwrap_or(default);
            // A texture has no effect on black.
            let texture = TextureUse::of(&object, texture)?.filter(|_| factor != [0.0; 3]);
            self.color_texture(texture, change(factor), base, &object)
        })
    }

    /// A colour times a number.
    fn scaled_color(&mut self, color: SpectrumParameter, number: FloatParameter) -> SpectrumParameter {
        match (color, number) {
            (
                SpectrumParameter::Value(glanz_light::SpectralDistribution::Rgb(color)),
                FloatParameter::Value(number),
            ) => color.map(|c| c * number).into(),
            (color, number) => self.reader.scaled(color, grey(number)),
        }
    }
}
