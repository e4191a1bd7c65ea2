//! Materials: scattering, emission, opacity and normals, and what is left out.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{
    AlphaDescription, EmissionDescription, ImageWrap, MaterialDescription, MaterialKind, MediumDescription,
    SurfaceDetailDescription,
};

use super::GltfReader;
use super::error::GltfError;
use super::json::JsonObject;
use super::principled::TEXTURES;
use super::texture::{TextureUse, UvSource, UvTransform};
use crate::model::PictureContent;

/// A material of the file in the description.
#[derive(Clone, Debug)]
pub(super) struct GltfMaterial {
    /// Its index.
    pub(super) index: usize,
    /// Emission of its surfaces.
    pub(super) emission: Option<EmissionDescription>,
    /// Opacity of its surfaces.
    pub(super) alpha: Option<AlphaDescription>,
    /// Whether the picture of its emission repeats, which the description cannot represent.
    pub(super) is_repeated: bool,
    /// Whether coordinates may be moved by whole pictures, as all textures repeat alike.
    pub(super) is_periodic: bool,
    /// Index of the medium inside its surfaces, if it absorbs light.
    pub(super) medium: Option<usize>,
    /// Coordinates of its textures; `None`: it has no textures.
    pub(super) uv: Option<UvSource>,
}

/// Extensions that are read.
const READ: [&str; 8] = [
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_ior",
    "KHR_materials_specular",
];

/// Members of extensions without an effect on pictures here, which are reported.
const LEFT_OUT_MEMBERS: [(&str, &str); 1] = [("KHR_materials_clearcoat", "clearcoatNormalTexture")];

/// Names of other extensions, which are reported.
const LEFT_OUT: [(&str, &str); 4] = [
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
        let is_unlit = material.extension("KHR_materials_unlit", |found| Ok(found.is_some()))?;
        let uses = texture_uses(material, is_unlit)?;
        let uv = uses.first().map(|texture| texture.uv);
        let base = uv.unwrap_or(UvSource { set: 0, transform: UvTransform::IDENTITY });
        let alpha = self.alpha(material, &base)?;
        let (kind, emission, surface_detail) = if is_unlit {
            (MaterialKind::diffuse(0.0), self.unlit(material)?, None)
        } else {
            self.report_extensions(material)?;
            let kind = MaterialKind::Principled(self.principled(material, &base)?);
            (kind, self.emission(material)?, self.normals(material, &base)?)
        };
        let (emission, emitting) = emission.unzip();
        let emitting = emitting.flatten();
        let is_repeated = emitting == Some(ImageWrap::Repeat);
        let mut is_periodic = is_repeated;
        for texture in &uses {
            is_periodic = is_periodic
                && texture.uv == base
                && self.sampler_of(texture, material)?.0 == ImageWrap::Repeat;
        }
        let medium = self.volume(material, &kind)?;
        let name = material.own_name();
        self.reader.spend_entry::<MaterialDescription>(&name);
        let materials = &mut self.reader.description.materials;
        materials.push(MaterialDescription { name, surface_detail, ..kind.into() });
        let index = materials.len() - 1;
        Ok(GltfMaterial { index, emission, alpha, is_repeated, is_periodic, medium, uv })
    }

    /// The medium inside surfaces that light passes, if it absorbs: after its distance, white light has its colour (@khr_gltf,
    /// KHR_materials_volume).
    fn volume(&mut self, material: &JsonObject<'_>, kind: &MaterialKind) -> Result<Option<usize>, GltfError> {
        let MaterialKind::Principled(principled) = kind else { return Ok(None) };
        if principled.thin || principled.transmission == 0.0.into() {
            return Ok(None);
        }
        material.extension("KHR_materials_volume", |found| {
            let Some(volume) = found else { return Ok(None) };
            let distance = volume.positive("attenuationDistance", f64::INFINITY)?;
            let color = volume.color::<3>("attenuationColor")?.unwrap_or([1.0; 3]);
            // A colour of 0 would need infinite absorption.
            let absorption =
                color.map(|c| -(c.clamp(f64::from(f32::MIN_POSITIVE), 1.0).ln() / distance) as f32);
            if absorption == [0.0; 3] {
                return Ok(None);
            }
            if !absorption.iter().all(|x| x.is_finite()) {
                return Err(volume.error(
                    "attenuationDistance",
                    format!(
                        "{distance} is too short for its colour; use a longer distance or a lighter colour"
                    ),
                ));
            }
            let name = material.own_name();
            self.reader.spend_entry::<MediumDescription>(&name);
            let media = &mut self.reader.description.media;
            media.push(MediumDescription { name, ..MediumDescription::new(absorption, 0.0) });
            Ok(Some(media.len() - 1))
        })
    }

    /// A surface that shows its base colour whatever the light: it emits that colour.
    fn unlit(&mut self, material: &JsonObject<'_>) -> Result<Option<Emitted>, GltfError> {
        material.object_or_empty("pbrMetallicRoughness", |pbr| {
            let [r, g, b, _] = pbr.color("baseColorFactor")?.unwrap_or([1.0; 4]);
            let texture = TextureUse::of(&pbr, "baseColorTexture")?;
            self.emitted([r, g, b], 1.0, texture, true, &pbr)
        })
    }

    /// The emitted light.
    fn emission(&mut self, material: &JsonObject<'_>) -> Result<Option<Emitted>, GltfError> {
        let factor = emissive_factor(material)?;
        let strength = material.extension("KHR_materials_emissive_strength", |found| {
            found.map_or(Ok(1.0), |object| object.positive("emissiveStrength", 1.0))
        })?;
        let texture = TextureUse::of(material, "emissiveTexture")?;
        let color = factor.map(|factor| factor * strength);
        self.emitted(color, self.radiance_unit, texture, material.boolean("doubleSided")?, material)
    }

    /// The emission of a colour in this unit, W/(m^2 sr), times a texture, with the repetition of its picture; `None` for black.
    fn emitted(
        &mut self,
        color: [f64; 3],
        unit: f32,
        texture: Option<TextureUse>,
        two_sided: bool,
        from: &JsonObject<'_>,
    ) -> Result<Option<Emitted>, GltfError> {
        if color == [0.0; 3] {
            return Ok(None);
        }
        let (mut image, mut wrap) = (None, None);
        if let Some(texture) = texture {
            image = self.picture_of(&texture, PictureContent::Color, from)?;
            wrap = Some(self.sampler_of(&texture, from)?.0).filter(|_| image.is_some());
        }
        if image.is_some_and(|image| self.constant(image) == Some(0.0)) {
            return Ok(None);
        }
        let radiance = SpectralDistribution::from(color.map(|x| x as f32));
        Ok(Some((EmissionDescription { scale: unit, two_sided, image, ..radiance.into() }, wrap)))
    }

    /// The opacity by the alpha of the base colour.
    fn alpha(
        &mut self,
        material: &JsonObject<'_>,
        base: &UvSource,
    ) -> Result<Option<AlphaDescription>, GltfError> {
        let mode = material.text("alphaMode")?.unwrap_or("OPAQUE");
        let cutoff = match mode {
            "OPAQUE" => return Ok(None),
            "MASK" => Some(material.positive("alphaCutoff", 0.5)?),
            "BLEND" => None,
            other => return Err(material.error("alphaMode", format!("the mode {other:?} is unknown"))),
        };
        let opacity = material.object_or_empty("pbrMetallicRoughness", |pbr| {
            let [.., factor] = pbr.color("baseColorFactor")?.unwrap_or([1.0; 4]);
            let texture = TextureUse::of(&pbr, "baseColorTexture")?;
            self.number_texture(texture, 3, factor.min(1.0), base, &pbr)
        })?;
        let opacity = match cutoff {
            Some(0.0) => return Ok(None),
            Some(cutoff) => self.reader.cut_off(opacity, cutoff as f32),
            None => opacity,
        };
        Ok((opacity != 1.0.into()).then(|| opacity.into()))
    }

    /// The map of normals.
    fn normals(
        &mut self,
        material: &JsonObject<'_>,
        base: &UvSource,
    ) -> Result<Option<SurfaceDetailDescription>, GltfError> {
        let Some(texture) = TextureUse::of(material, "normalTexture")? else { return Ok(None) };
        if texture.uv != *base {
            let message = format!(
                "{}: the normal map has other coordinates than the emissive texture; the smooth surface stands in",
                material.path()
            );
            self.reader.stand_in("gltf-normals", None, message);
            return Ok(None);
        }
        let scale =
            material.object("normalTexture", |info| info.map_or(Ok(None), |info| info.number("scale")))?;
        let scale = (scale.unwrap_or(1.0) as f32).to_bits();
        let picture = self.picture_of(&texture, PictureContent::Normals { scale }, material)?;
        Ok(picture.map(SurfaceDetailDescription::NormalMap))
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
}

/// Emission with the repetition of its picture.
type Emitted = (EmissionDescription, Option<ImageWrap>);

fn emissive_factor(material: &JsonObject<'_>) -> Result<[f64; 3], GltfError> {
    Ok(material.color("emissiveFactor")?.unwrap_or([0.0; 3]))
}

/// The uses of textures: first those that have the coordinates of meshes as they are.
fn texture_uses(material: &JsonObject<'_>, is_unlit: bool) -> Result<Vec<TextureUse>, GltfError> {
    let mut uses = Vec::new();
    let mut add = |object: &JsonObject<'_>, name: &str| {
        uses.extend(TextureUse::of(object, name)?);
        Ok(())
    };
    if is_unlit {
        material.object_or_empty("pbrMetallicRoughness", |pbr| add(&pbr, "baseColorTexture"))?;
        return Ok(uses);
    }
    if emissive_factor(material)? != [0.0; 3] {
        add(material, "emissiveTexture")?;
    }
    add(material, "normalTexture")?;
    material.object_or_empty("pbrMetallicRoughness", |pbr| {
        add(&pbr, "baseColorTexture")?;
        add(&pbr, "metallicRoughnessTexture")
    })?;
    for (extension, names) in TEXTURES {
        material.extension(extension, |found| {
            found.map_or(Ok(()), |object| names.iter().try_for_each(|name| add(&object, name)))
        })?;
    }
    Ok(uses)
}
