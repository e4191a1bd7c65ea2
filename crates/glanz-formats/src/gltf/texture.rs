//! Textures: pictures, samplers and the transformation of coordinates.

use glanz_math::DVec2;
use glanz_scene::description::{
    FloatParameter, ImageDescription, ImageFilter, ImageWrap, MappingDescription, SpectrumParameter,
    TextureKind,
};
use glanz_shading::texture::MipMap;

use super::GltfReader;
use super::buffers::read_address;
use super::error::GltfError;
use super::json::JsonObject;
use crate::file_list::FileKind;
use crate::model::PictureContent;
use crate::source::shortened;

/// Numbers of the format: filters and repetitions.
const NEAREST: usize = 9728;
const LINEAR: usize = 9729;
const MIRRORED_REPEAT: usize = 33648;
const REPEAT: usize = 10497;
const CLAMP_TO_EDGE: usize = 33071;

/// Affine map of texture coordinates: `linear (u, v) + offset`, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvTransform {
    rows: [DVec2; 2],
    offset: DVec2,
}

/// The coordinates of a texture on meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvSource {
    /// Number of the set of coordinates.
    pub(super) set: usize,
    pub(super) transform: UvTransform,
}

/// A use of a texture by a material.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextureUse {
    index: usize,
    pub(super) uv: UvSource,
}

/// The number of a picture, and what is taken from it.
pub(super) type PictureKey = (usize, PictureContent);

impl UvTransform {
    pub(super) const IDENTITY: Self = Self { rows: [DVec2::X, DVec2::Y], offset: DVec2::ZERO };

    pub(super) fn apply(&self, uv: DVec2) -> DVec2 {
        DVec2::new(self.rows[0].dot(uv), self.rows[1].dot(uv)) + self.offset
    }

    /// `KHR_texture_transform`: scaled, then turned, then moved. Its example of a quarter turn tells the direction.
    fn of(object: &JsonObject<'_>) -> Result<Self, GltfError> {
        let [su, sv] = object.numbers("scale")?.unwrap_or([1.0; 2]);
        let offset = object.numbers("offset")?.unwrap_or([0.0; 2]);
        let (sin, cos) = object.number("rotation")?.unwrap_or(0.0).sin_cos();
        Ok(Self {
            rows: [DVec2::new(su * cos, sv * sin), DVec2::new(-su * sin, sv * cos)],
            offset: offset.into(),
        })
    }

    /// Factors and offsets of the mapping that has the effect of this transformation on coordinates of a mesh to which `base` was applied,
    /// and whose v was turned upwards; `None` if they do not suffice.
    fn mapping_after(&self, base: &Self) -> Option<MappingDescription> {
        // Those that show a single pixel have no inverse.
        if self == base {
            return Some(MappingDescription::Uv { scale: DVec2::ONE, offset: DVec2::ZERO });
        }
        // M = L B^-1, and its offset, with v pointing down.
        let [[a, b], [c, d]] = base.rows.map(|row| row.to_array());
        let determinant = a * d - b * c;
        let inverse = [DVec2::new(d, -b) / determinant, DVec2::new(-c, a) / determinant];
        let columns = [DVec2::new(inverse[0].x, inverse[1].x), DVec2::new(inverse[0].y, inverse[1].y)];
        let linear = self.rows.map(|row| columns.map(|column| row.dot(column)));
        let [[uu, uv], [vu, vv]] = linear;
        let moved = self.offset
            - DVec2::new(uu * base.offset.x + uv * base.offset.y, vu * base.offset.x + vv * base.offset.y);
        let size = uu.abs().max(vv.abs());
        // A few rounding errors of sine and cosine.
        let is_diagonal = uv.abs().max(vu.abs()) <= 1e-12 * size;
        let upward = MappingDescription::Uv {
            scale: DVec2::new(uu, vv),
            // v = 1 - w of the mesh: 1 - (vv (1 - w) + o) = vv w + (1 - vv - o).
            offset: DVec2::new(moved.x, 1.0 - vv - moved.y),
        };
        (is_diagonal && linear.iter().flatten().all(|x| x.is_finite()) && moved.is_finite()).then_some(upward)
    }
}

impl TextureUse {
    /// The use of a texture that a member of an object describes.
    pub(super) fn of(object: &JsonObject<'_>, name: &str) -> Result<Option<Self>, GltfError> {
        object.object(name, |info| {
            let Some(info) = info else { return Ok(None) };
            let (index, mut set) = (info.required_count("index")?, info.count("texCoord")?.unwrap_or(0));
            let transform = info.extension("KHR_texture_transform", |found| {
                let Some(transform) = found else { return Ok(UvTransform::IDENTITY) };
                set = transform.count("texCoord")?.unwrap_or(set);
                UvTransform::of(&transform)
            })?;
            Ok(Some(Self { index, uv: UvSource { set, transform } }))
        })
    }
}

impl GltfReader<'_, '_> {
    /// A texture of colours: the picture times a factor. `base`: the coordinates of the meshes.
    pub(super) fn color_texture(
        &mut self,
        texture: Option<TextureUse>,
        factor: [f64; 3],
        base: &UvSource,
        from: &JsonObject<'_>,
    ) -> Result<SpectrumParameter, GltfError> {
        let factor = factor.map(|x| x as f32);
        let constant = SpectrumParameter::from(factor);
        let Some(texture) = texture else { return Ok(constant) };
        let Some(picture) = self.image_texture(&texture, PictureContent::Color, base, from)? else {
            return Ok(constant);
        };
        let picture = SpectrumParameter::Texture(picture);
        Ok(if factor == [1.0; 3] { picture } else { self.reader.scaled(picture, constant) })
    }

    /// A texture of numbers: a channel of the picture times a factor.
    pub(super) fn number_texture(
        &mut self,
        texture: Option<TextureUse>,
        channel: u8,
        factor: f64,
        base: &UvSource,
        from: &JsonObject<'_>,
    ) -> Result<FloatParameter, GltfError> {
        let constant = FloatParameter::Value(factor as f32);
        let Some(texture) = texture.filter(|_| factor != 0.0) else { return Ok(constant) };
        let content = PictureContent::Channel(channel);
        // Pictures without alpha are common.
        let image = self.picture_of(&texture, content, from)?;
        if image.is_none_or(|image| self.constant(image) == Some(1.0)) {
            return Ok(constant);
        }
        let Some(picture) = self.image_texture(&texture, content, base, from)? else { return Ok(constant) };
        Ok(self.reader.scaled_number(FloatParameter::Texture(picture), factor as f32))
    }

    /// The value that all pixels and channels of a picture have, without alpha.
    pub(super) fn constant(&self, image: usize) -> Option<f32> {
        self.reader.description.images.get(image)?.picture.uniform()
    }

    fn image_texture(
        &mut self,
        texture: &TextureUse,
        content: PictureContent,
        base: &UvSource,
        from: &JsonObject<'_>,
    ) -> Result<Option<usize>, GltfError> {
        let Some(image) = self.picture_of(texture, content, from)? else { return Ok(None) };
        let mapping = (texture.uv.set == base.set)
            .then(|| texture.uv.transform.mapping_after(&base.transform))
            .flatten();
        let mapping = mapping.unwrap_or_else(|| {
            let message = format!(
                "{}: textures of one material have different coordinates; those of the first stand in",
                from.path()
            );
            self.reader.stand_in("gltf-coordinates", None, message);
            MappingDescription::Uv { scale: DVec2::ONE, offset: DVec2::ZERO }
        });
        let (wrap, filter) = self.sampler_of(texture, from)?;
        let kind = TextureKind::Image { image, mapping, wrap, filter, scale: 1.0, invert: false };
        let name = self.reader.description.images.get(image).map(|image| shortened(&image.name));
        Ok(Some(self.reader.add_texture(name.unwrap_or_default(), kind)))
    }

    /// Repetition and filter of a texture.
    pub(super) fn sampler_of(
        &mut self,
        texture: &TextureUse,
        from: &JsonObject<'_>,
    ) -> Result<(ImageWrap, ImageFilter), GltfError> {
        let document = self.document;
        document.element("textures", texture.index, from.path(), |texture| {
            let Some(sampler) = texture.count("sampler")? else {
                return Ok((ImageWrap::Repeat, ImageFilter::ANISOTROPIC));
            };
            document.element("samplers", sampler, &texture.path().name("sampler"), |sampler| {
                let [s, t] = ["wrapS", "wrapT"].map(|name| sampler.count(name));
                let (s, t) = (s?.unwrap_or(REPEAT), t?.unwrap_or(REPEAT));
                let wrap = match s {
                    REPEAT | MIRRORED_REPEAT => ImageWrap::Repeat,
                    CLAMP_TO_EDGE => ImageWrap::Clamp,
                    other => return Err(sampler.error("wrapS", format!("{other} is unknown"))),
                };
                if s != t || s == MIRRORED_REPEAT {
                    let message = format!(
                        "{}: mirrored repetition, and different repetition along u and v, are not available; {} stands in",
                        sampler.path(),
                        if wrap == ImageWrap::Clamp { "the border" } else { "plain repetition" }
                    );
                    self.reader.stand_in("gltf-sampler", None, message);
                }
                let filter = match (sampler.count("magFilter")?, sampler.count("minFilter")?) {
                    (Some(NEAREST), _) => ImageFilter::Point,
                    (_, Some(NEAREST | LINEAR)) => ImageFilter::Bilinear,
                    (_, None) => ImageFilter::ANISOTROPIC,
                    _ => ImageFilter::Trilinear,
                };
                Ok((wrap, filter))
            })
        })
    }

    /// The number of the picture of a texture; `None`, after a report, if it has none that can be read.
    fn image_of(&mut self, texture: &TextureUse, from: &JsonObject<'_>) -> Result<Option<usize>, GltfError> {
        let document = self.document;
        document.element("textures", texture.index, from.path(), |texture| {
            let source = texture.count("source")?;
            if source.is_none() {
                let names = texture
                    .object_or_empty("extensions", |e| Ok(e.names().collect::<Vec<_>>().join(", ")))?;
                let message = format!(
                    "{}: pictures of {} are not read; the factor of the texture stands in",
                    texture.path(),
                    if names.is_empty() { "no source" } else { &names }
                );
                self.reader.stand_in("gltf-picture", None, message);
            }
            Ok(source)
        })
    }

    /// The picture of a texture in the description; `None`, after a report, if it cannot be read.
    pub(super) fn picture_of(
        &mut self,
        texture: &TextureUse,
        content: PictureContent,
        from: &JsonObject<'_>,
    ) -> Result<Option<usize>, GltfError> {
        let Some(image) = self.image_of(texture, from)? else { return Ok(None) };
        let document = self.document;
        let key = (image, content);
        document.element("images", image, from.path(), |image| {
            if let Some(known) = self.pictures.get(&key) {
                return Ok(*known);
            }
            let index = match self.picture(content, &image)? {
                Ok(picture) => {
                    let images = &mut self.reader.description.images;
                    images.push(ImageDescription { name: image.own_name(), picture });
                    Some(images.len() - 1)
                }
                Err(problem) => {
                    self.report_picture(&image, &problem);
                    None
                }
            };
            self.pictures.insert(key, index);
            Ok(index)
        })
    }

    fn report_picture(&mut self, image: &JsonObject<'_>, problem: &str) {
        let message = format!("{}: {problem}; the factor of the texture stands in", image.path());
        self.reader.stand_in("gltf-picture", None, message);
    }

    /// The content of a picture, or a problem for which there is a substitute.
    fn picture(
        &mut self,
        content: PictureContent,
        image: &JsonObject<'_>,
    ) -> Result<Result<MipMap, String>, GltfError> {
        match (image.text("uri")?, image.count("bufferView")?) {
            (Some(uri), _) => {
                let bytes = read_address(uri, self.reader, FileKind::Picture);
                Ok(bytes.and_then(|bytes| self.reader.picture(&bytes, content)))
            }
            (None, Some(view)) => {
                let view = self.buffers.view(self.document, view, &image.path().name("bufferView"))?;
                Ok(self.reader.picture(view.bytes, content))
            }
            (None, None) => Err(image.fault("the picture has neither an address nor a buffer view")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(text: &str) -> UvTransform {
        let value = serde_json::from_str(text).unwrap();
        UvTransform::of(&JsonObject::try_new(&value, &super::super::json::JsonPath::ROOT).unwrap()).unwrap()
    }

    fn assert_near(a: DVec2, b: [f64; 2]) {
        assert!((a - DVec2::from(b)).length() < 1e-12, "{a} is not {b:?}");
    }

    #[test]
    fn the_quarter_turn_of_the_specification_shows_the_lower_left_quarter() {
        // v points down: the lower left quarter is [0, 1/2] x [1/2, 1].
        let turned =
            transform(r#"{ "offset": [0, 1], "rotation": 1.5707963267948966, "scale": [0.5, 0.5] }"#);
        assert_near(turned.apply(DVec2::ZERO), [0.0, 1.0]);
        assert_near(turned.apply(DVec2::X), [0.0, 0.5]);
        assert_near(turned.apply(DVec2::ONE), [0.5, 0.5]);
    }

    #[test]
    fn a_mapping_has_the_effect_of_a_transformation_after_another() {
        let turn = transform(r#"{ "rotation": 0.5, "scale": [2, 3], "offset": [0.1, 0.2] }"#);
        let more = transform(r#"{ "rotation": 0.5, "scale": [2, 3], "offset": [-0.3, 0.7] }"#);
        let larger = UvTransform { rows: [turn.rows[0] * 4.0, turn.rows[1] * 5.0], ..more };
        for (own, base) in
            [(more, turn), (larger, turn), (transform(r#"{ "scale": [2, 3] }"#), UvTransform::IDENTITY)]
        {
            let Some(MappingDescription::Uv { scale, offset }) = own.mapping_after(&base) else { panic!() };
            for uv in [DVec2::ZERO, DVec2::new(0.3, 0.9), DVec2::new(-2.0, 5.0)] {
                let upward = |uv: DVec2| DVec2::new(uv.x, 1.0 - uv.y);
                let mapped = scale * upward(base.apply(uv)) + offset;
                assert_near(mapped, upward(own.apply(uv)).to_array());
            }
        }
        assert!(turn.mapping_after(&UvTransform::IDENTITY).is_none(), "a turn is no factor");
        assert!(turn.mapping_after(&transform(r#"{ "scale": [0, 1] }"#)).is_none());
    }
}
