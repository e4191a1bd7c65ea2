//! Materials: the metallic-roughness model and its extensions, and what stands in for them.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{EmissionDescription, MaterialDescription, MaterialKind};

use super::GltfReader;
use super::error::GltfError;
use super::json::JsonObject;
use super::texture::{TextureUse, UvSource, UvTransform};
use crate::model::{PictureContent, SurfaceParameters};

/// A material of the file in the description.
#[derive(Clone, Debug)]
pub(super) struct GltfMaterial {
    /// Its index.
    pub(super) index: usize,
    /// Emission of its surfaces.
    pub(super) emission: Option<EmissionDescription>,
    /// Coordinates of its textures; `None`: it has no textures.
    pub(super) uv: Option<UvSource>,
}

/// Extensions that are read.
const READ: [&str; 6] = [
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_ior",
    "KHR_materials_specular",
];

/// Members of extensions without an effect on pictures here, which are reported.
const LEFT_OUT_MEMBERS: [(&str, &str); 4] = [
    ("KHR_materials_transmission", "transmissionTexture"),
    ("KHR_materials_volume", "attenuationDistance"),
    ("KHR_materials_specular", "specularTexture"),
    ("KHR_materials_specular", "specularColorTexture"),
];

/// Names of other extensions, which are reported.
const LEFT_OUT: [(&str, &str); 6] = [
    ("KHR_materials_clearcoat", "clearcoat"),
    ("KHR_materials_sheen", "sheen"),
    ("KHR_materials_iridescence", "iridescence"),
    ("KHR_materials_anisotropy", "anisotropy"),
    ("KHR_materials_dispersion", "dispersion"),
    ("KHR_materials_diffuse_transmission", "diffuse transmission"),
];

impl GltfReader<'_, '_> {
    /// The material with this number, or the default one. `from`: the primitive that names it.
    pub(super) fn material(
        &mut self,
        number: Option<usize>,
        from: &JsonObject<'_>,
    ) -> Result<GltfMaterial, GltfError> {
        if let Some(known) = self.materials.get(&number) {
            return Ok(known.clone());
        }
        let document = self.document;
        let material = match number {
            Some(number) => {
                let path = from.path().name("material");
                document.element("materials", number, &path, |material| self.new_material(&material))?
            }
            None => from.object_or_empty("", |empty| self.new_material(&empty))?,
        };
        self.materials.insert(number, material.clone());
        Ok(material)
    }

    fn new_material(&mut self, material: &JsonObject<'_>) -> Result<GltfMaterial, GltfError> {
        self.report_alpha(material)?;
        self.report_normals(material)?;
        let (kind, emission, uv) =
            match material.extension("KHR_materials_unlit", |found| Ok(found.is_some()))? {
                true => self.unlit(material)?,
                false => {
                    let (parameters, uv) = self.parameters(material)?;
                    (self.reader.surface_model(parameters), self.emission(material)?, uv)
                }
            };
        let materials = &mut self.reader.description.materials;
        materials.push(MaterialDescription { name: material.own_name(), ..kind.into() });
        Ok(GltfMaterial { index: materials.len() - 1, emission, uv })
    }

    fn parameters(
        &mut self,
        material: &JsonObject<'_>,
    ) -> Result<(SurfaceParameters, Option<UvSource>), GltfError> {
        let of = |extension: &str, name: &'static str, default: f64| {
            material.extension(extension, |found| {
                found.map_or(Ok(default), |object| object.positive(name, default))
            })
        };
        let transmission = of("KHR_materials_transmission", "transmissionFactor", 0.0)?;
        let solid = of("KHR_materials_volume", "thicknessFactor", 0.0)? > 0.0;
        // 0 stands for infinity: everything is reflected.
        let ior = of("KHR_materials_ior", "ior", 1.5)?;
        let strength = of("KHR_materials_specular", "specularFactor", 1.0)?;
        let tint = material.extension("KHR_materials_specular", |found| {
            Ok(found
                .map(|object| object.color("specularColorFactor"))
                .transpose()?
                .flatten()
                .unwrap_or([1.0; 3]))
        })?;
        self.report_extensions(material)?;
        material.object_or_empty("pbrMetallicRoughness", |pbr| {
            let base = self.texture_use(&pbr, "baseColorTexture")?;
            let rough = self.texture_use(&pbr, "metallicRoughnessTexture")?;
            let uv = base.or(rough).map(|texture| texture.uv);
            let source = uv.unwrap_or(UvSource { set: 0, transform: UvTransform::IDENTITY });
            let [r, g, b, _] = pbr.color("baseColorFactor")?.unwrap_or([1.0; 4]);
            let base_color = self.color_texture(base, [r, g, b], &source, &pbr)?;
            let metallic = pbr.fraction("metallicFactor", 1.0)?;
            let transmission = match transmission > 0.0 {
                true => {
                    // No light passes through metal.
                    let [mean, ..] = self.mean_color(rough, PictureContent::Channel(2), &pbr)?;
                    (transmission * (1.0 - metallic * mean)) as f32
                }
                false => 0.0,
            };
            let metallic = self.number_texture(rough, 2, metallic, &source, &pbr)?;
            let [mean, ..] = self.mean_color(rough, PictureContent::Channel(1), &pbr)?;
            let roughness = (pbr.fraction("roughnessFactor", 1.0)? * mean) as f32;
            let ior = if ior < 1.0 { 1e3 } else { ior.min(1e3) };
            // The colour is limited before the factor applies.
            let limit = ((ior + 1.0) / (ior - 1.0)).powi(2);
            let specular = tint.map(|factor| (strength * factor.min(limit)) as f32);
            let ior = ior as f32;
            let parameters =
                SurfaceParameters { base_color, metallic, roughness, ior, specular, transmission, solid };
            Ok((parameters, uv))
        })
    }

    /// A surface that shows its base colour whatever the light: it emits that colour, or, with a texture, scatters it.
    #[allow(clippy::type_complexity)]
    fn unlit(
        &mut self,
        material: &JsonObject<'_>,
    ) -> Result<(MaterialKind, Option<EmissionDescription>, Option<UvSource>), GltfError> {
        material.object_or_empty("pbrMetallicRoughness", |pbr| {
            let [r, g, b, _] = pbr.color("baseColorFactor")?.unwrap_or([1.0; 4]);
            let Some(texture) = self.texture_use(&pbr, "baseColorTexture")? else {
                let emission = emission([r, g, b], 1.0, true);
                return Ok((MaterialKind::diffuse(0.0), emission, None));
            };
            let color = self.color_texture(Some(texture), [r, g, b], &texture.uv, &pbr)?;
            let message = format!("{}: an unlit texture is shown as a diffuse one", material.path());
            self.reader.stand_in("gltf-unlit", None, message);
            Ok((MaterialKind::diffuse(color), None, Some(texture.uv)))
        })
    }

    /// The emitted light: of a texture the mean.
    fn emission(&mut self, material: &JsonObject<'_>) -> Result<Option<EmissionDescription>, GltfError> {
        let factor = material.color("emissiveFactor")?.unwrap_or([0.0; 3]);
        if factor == [0.0; 3] {
            return Ok(None);
        }
        let strength = material.extension("KHR_materials_emissive_strength", |found| {
            found.map_or(Ok(1.0), |object| object.positive("emissiveStrength", 1.0))
        })?;
        let texture: Option<TextureUse> = self.texture_use(material, "emissiveTexture")?;
        if texture.is_some() {
            let message = format!("{}: the mean of the emissive texture stands in for it", material.path());
            self.reader.stand_in("gltf-emission", None, message);
        }
        let mean = self.mean_color(texture, PictureContent::Color, material)?;
        let color = [0, 1, 2].map(|i| factor[i] * mean[i] * strength);
        Ok(emission(color, self.radiance_unit, material.boolean("doubleSided")?))
    }

    fn report_extensions(&mut self, material: &JsonObject<'_>) -> Result<(), GltfError> {
        let mut left_out = |what: &str| {
            let message = format!("{}: {what} is not available and left out", material.path());
            self.reader.stand_in("gltf-material", None, message);
        };
        material.object_or_empty("extensions", |extensions| {
            for name in extensions.names().filter(|name| !READ.contains(name)) {
                left_out(
                    LEFT_OUT.iter().find(|(extension, _)| *extension == name).map_or(name, |(_, what)| what),
                );
            }
            for (extension, member) in LEFT_OUT_MEMBERS {
                if extensions.object(extension, |found| Ok(found.is_some_and(|found| found.has(member))))? {
                    left_out(&format!("{member} of {extension}"));
                }
            }
            Ok(())
        })
    }

    /// Reports transparency by alpha, which is not represented.
    fn report_alpha(&mut self, material: &JsonObject<'_>) -> Result<(), GltfError> {
        let mode = material.text("alphaMode")?.unwrap_or("OPAQUE");
        if mode != "OPAQUE" {
            let message = format!(
                "{}: alpha mode {mode} is not available; an opaque surface stands in",
                material.path()
            );
            self.reader.stand_in("gltf-alpha", None, message);
        }
        Ok(())
    }

    /// Reports normal maps, which are not represented.
    fn report_normals(&mut self, material: &JsonObject<'_>) -> Result<(), GltfError> {
        if material.has("normalTexture") {
            let message =
                format!("{}: the normal map is not available; the smooth surface stands in", material.path());
            self.reader.stand_in("gltf-normals", None, message);
        }
        Ok(())
    }
}

/// The emission of a colour in this unit, W/(m^2 sr); `None` for black.
fn emission(color: [f64; 3], unit: f32, two_sided: bool) -> Option<EmissionDescription> {
    let radiance = SpectralDistribution::from(color.map(|x| x as f32));
    let emission = EmissionDescription { scale: unit, two_sided, ..radiance.into() };
    (color != [0.0; 3]).then_some(emission)
}
