//! `Texture`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    ImageDescription, ImageFilter, ImageWrap, MappingDescription, SpectrumParameter, TextureDescription,
    TextureKind,
};

use super::spectrum::grey;
use super::{EntityState, FileError, Lowering};
use crate::file_list::FileKind;
use crate::image::{self, Encoding};
use crate::nearest::nearest;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::source::ParseResult;

/// The textures by name, separately for numbers and for spectra.
#[derive(Clone, Debug, Default)]
pub(crate) struct TextureNames {
    floats: BTreeMap<String, usize>,
    spectra: BTreeMap<String, usize>,
}

impl TextureNames {
    /// The texture of this name, if necessary of the other type.
    pub(super) fn find(&self, name: &str, spectrum: bool) -> Option<usize> {
        let (first, second) =
            if spectrum { (&self.spectra, &self.floats) } else { (&self.floats, &self.spectra) };
        first.get(name).or_else(|| second.get(name)).copied()
    }

    /// The most similar name.
    pub(super) fn nearest(&self, name: &str) -> Option<&str> {
        nearest(name, self.spectra.keys().chain(self.floats.keys()).map(String::as_str))
    }
}

/// Key of a picture, which is read once per file and encoding.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ImageKey {
    path: PathBuf,
    encoding: (u8, u32),
}

/// Largest ratio of the axes of a footprint that is filtered, as in graphics hardware: it bounds the time of a look-up.
const MOST_ANISOTROPY: f64 = 16.0;

/// Substitute for a picture that cannot be read.
const MISSING_PICTURE: f32 = 0.5;

impl Lowering {
    /// Adds a texture: a `Texture` directive's name, `float` or `spectrum`, and type.
    pub(crate) fn texture(
        &mut self,
        name: &str,
        value_type: &str,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<()> {
        let spectrum = match value_type {
            "spectrum" | "color" => true,
            "float" => false,
            other => {
                let message = format!("texture {:?} has the type {:?}", shortened(name), shortened(other));
                let help = Some("textures are of type float or spectrum".to_owned());
                return Err(self.reporter.error_with_help(&list.place, "texture-type", message, help));
            }
        };
        let made = match kind {
            "constant" => {
                TextureKind::Constant(self.spectrum_or(&mut list, "value", 1.0, context.color_space)?)
            }
            "scale" => self.scale_texture(&mut list, context)?,
            "mix" => TextureKind::Mix {
                a: self.spectrum_or(&mut list, "tex1", 0.0, context.color_space)?,
                b: self.spectrum_or(&mut list, "tex2", 1.0, context.color_space)?,
                amount: self.float_or(&mut list, "amount", 0.5)?,
            },
            "checkerboard" => self.checkerboard(&mut list, context)?,
            "imagemap" => self.image_map(&mut list, context)?,
            other => self.procedural_texture(other, &mut list, context)?,
        };
        let location = Some(list.place.location);
        self.spend_entry::<TextureDescription>(name, &list.place)?;
        list.finish(&mut self.reporter);
        let index = self.description.textures.len();
        self.description.textures.push(TextureDescription { name: name.to_owned(), kind: made, location });
        let names = if spectrum { &mut self.textures.spectra } else { &mut self.textures.floats };
        names.insert(name.to_owned(), index);
        Ok(())
    }

    /// `tex1 * tex2` (version 3) or `tex * scale` (version 4).
    fn scale_texture(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<TextureKind> {
        let names = if list.has("tex") || (self.dialect == Dialect::V4 && !list.has("tex1")) {
            ["tex", "scale"]
        } else {
            ["tex1", "tex2"]
        };
        Ok(TextureKind::Scale(
            self.spectrum_or(list, names[0], 1.0, context.color_space)?,
            self.spectrum_or(list, names[1], 1.0, context.color_space)?,
        ))
    }

    fn checkerboard(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<TextureKind> {
        let place = list.value_place("dimension");
        let mapping = match list.integer("dimension", &mut self.reporter)?.unwrap_or(2) {
            2 => self.mapping(list, context)?,
            3 => MappingDescription::Solid { to_texture: self.texture_space(list, context)? },
            n => {
                let message = format!("texture \"checkerboard\": \"dimension\" is {n}; it must be 2 or 3");
                return Err(self.reporter.error(&place, "parameter-range", message));
            }
        };
        list.ignore(&["aamode"]);
        Ok(TextureKind::Checkerboard {
            even: self.spectrum_or(list, "tex1", 1.0, context.color_space)?,
            odd: self.spectrum_or(list, "tex2", 0.0, context.color_space)?,
            mapping,
        })
    }

    /// From world to texture space; an error if the texture's space is flat.
    pub(super) fn texture_space(
        &mut self,
        list: &ParameterList,
        context: &EntityState,
    ) -> ParseResult<DMat4> {
        let inverse = context.ctm.inverse();
        if inverse.is_finite() {
            return Ok(inverse);
        }
        let message = format!("{}: the transformation cannot be inverted", list.subject);
        Err(self.reporter.error(&list.place, "transformation", message))
    }

    /// Texture mapping.
    pub(super) fn mapping(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<MappingDescription> {
        let place = list.value_place("mapping");
        let kind = list.text("mapping", &mut self.reporter)?;
        let r = &mut self.reporter;
        Ok(match kind.as_deref().unwrap_or("uv") {
            "uv" => MappingDescription::Uv {
                scale: DVec2::new(list.float_or("uscale", 1.0, r)?, list.float_or("vscale", 1.0, r)?),
                offset: DVec2::new(list.float_or("udelta", 0.0, r)?, list.float_or("vdelta", 0.0, r)?),
            },
            "planar" => MappingDescription::Planar {
                v1: list.vec3("v1", r)?.unwrap_or(DVec3::X),
                v2: list.vec3("v2", r)?.unwrap_or(DVec3::Y),
                offset: DVec2::new(list.float_or("udelta", 0.0, r)?, list.float_or("vdelta", 0.0, r)?),
                to_texture: self.texture_space(list, context)?,
            },
            "spherical" => MappingDescription::Spherical { to_texture: self.texture_space(list, context)? },
            "cylindrical" => {
                MappingDescription::Cylindrical { to_texture: self.texture_space(list, context)? }
            }
            other => {
                let message = format!("{}: mapping {:?} is unknown", list.subject, shortened(other));
                let help = Some("mappings are uv, planar, spherical and cylindrical".to_owned());
                return Err(r.error_with_help(&place, "parameter-range", message, help));
            }
        })
    }

    fn image_map(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<TextureKind> {
        let mapping = self.mapping(list, context)?;
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = "texture \"imagemap\" has no \"string filename\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let encoding = self.encoding(list)?;
        let wrap = self.wrap(list)?;
        let filter = self.image_filter(list)?;
        let scale = list.float_or("scale", 1.0, &mut self.reporter)? as f32;
        let invert = list.boolean("invert", &mut self.reporter)?.unwrap_or(false);
        list.ignore(&["noiseaware"]);
        let instead = format!("grey of {MISSING_PICTURE} stands in");
        Ok(match self.image(&p, &name, encoding, &list.subject, &instead)? {
            Some(image) => TextureKind::Image { image, mapping, wrap, filter, scale, invert },
            None => TextureKind::Constant(SpectrumParameter::Value(grey(MISSING_PICTURE))),
        })
    }

    /// Encoding of the picture's integers: `gamma` in version 3, `encoding` in version 4.
    fn encoding(&mut self, list: &mut ParameterList) -> ParseResult<Encoding> {
        if let Some(gamma) = list.boolean("gamma", &mut self.reporter)? {
            return Ok(if gamma { Encoding::Srgb } else { Encoding::Linear });
        }
        let place = list.value_place("encoding");
        let Some(text) = list.text("encoding", &mut self.reporter)? else { return Ok(Encoding::Srgb) };
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let gamma = match words[..] {
            ["sRGB"] => return Ok(Encoding::Srgb),
            ["linear"] => return Ok(Encoding::Linear),
            ["gamma", value] => value.parse::<f32>().ok().filter(|g| g.is_finite() && *g > 0.0),
            _ => None,
        };
        gamma.map(Encoding::Gamma).ok_or_else(|| {
            let message = format!("texture \"imagemap\": encoding {:?} is unknown", shortened(&text));
            let help = Some("encodings are sRGB, linear and gamma with a number".to_owned());
            self.reporter.error_with_help(&place, "parameter-range", message, help)
        })
    }

    fn wrap(&mut self, list: &mut ParameterList) -> ParseResult<ImageWrap> {
        let place = list.value_place("wrap");
        let text = list.text("wrap", &mut self.reporter)?;
        Ok(match text.as_deref().unwrap_or("repeat") {
            "repeat" => ImageWrap::Repeat,
            "black" => ImageWrap::Black,
            "clamp" => ImageWrap::Clamp,
            "octahedralsphere" => ImageWrap::OctahedralSphere,
            other => {
                let message = format!(
                    "texture \"imagemap\": wrap mode {:?} is unknown; \"repeat\" stands in",
                    shortened(other)
                );
                self.stand_in(&place, "stand-in-texture", message);
                ImageWrap::Repeat
            }
        })
    }

    /// Version 3 filters anisotropically by default.
    fn image_filter(&mut self, list: &mut ParameterList) -> ParseResult<ImageFilter> {
        let most = list.float_or("maxanisotropy", 8.0, &mut self.reporter)?;
        let anisotropic = ImageFilter::Anisotropic { most: most.round().clamp(1.0, MOST_ANISOTROPY) as u8 };
        let isotropic = list.boolean("trilinear", &mut self.reporter)?.unwrap_or(false);
        let place = list.value_place("filter");
        let text = list.text("filter", &mut self.reporter)?;
        Ok(match text.as_deref() {
            None if isotropic => ImageFilter::Trilinear,
            None if self.dialect == Dialect::V3 => anisotropic,
            None | Some("bilinear") => ImageFilter::Bilinear,
            Some("point" | "nearest") => ImageFilter::Point,
            Some("trilinear") => ImageFilter::Trilinear,
            Some("ewa" | "EWA") => anisotropic,
            Some(other) => {
                let message = format!(
                    "texture \"imagemap\": filter {:?} is unknown; \"bilinear\" stands in",
                    shortened(other)
                );
                self.stand_in(&place, "stand-in-texture", message);
                ImageFilter::Bilinear
            }
        })
    }

    /// The index of a picture; `None`, after a report, if it cannot be read. `subject`: what needs it; `instead`: what stands in.
    pub(super) fn image(
        &mut self,
        p: &Parameter,
        name: &str,
        encoding: Encoding,
        subject: &str,
        instead: &str,
    ) -> ParseResult<Option<usize>> {
        match self.picture(name, encoding) {
            Ok(index) => Ok(Some(index)),
            Err(problem) => {
                let message = format!("{subject}: {problem}; {instead}");
                self.without_file(&p.value_place, &problem, message)?;
                Ok(None)
            }
        }
    }

    /// The index of a picture with colours, read at its first use.
    pub(super) fn picture(&mut self, name: &str, encoding: Encoding) -> Result<usize, FileError> {
        let tag = match encoding {
            Encoding::Srgb => (0, 0),
            Encoding::Linear => (1, 0),
            Encoding::Gamma(g) => (2, g.to_bits()),
        };
        let key = self.locate(name).ok().map(|path| ImageKey { path, encoding: tag });
        if let Some(known) = key.as_ref().and_then(|key| self.images.get(key)) {
            return Ok(*known);
        }
        // Whatever the encoding: it would have to be decoded again to be refused.
        if let Some(problem) = key.as_ref().and_then(|key| self.refused_pictures.get(&key.path)) {
            return Err(format!("picture {name:?}: {problem}").into());
        }
        let (path, bytes) = self.read_file(name, FileKind::Picture)?;
        let read = image::read_reserved(&bytes, Some(&path), encoding, &self.finder.budget);
        let picture = read.map_err(|error| error.to_string());
        let picture = picture.and_then(|(read, _memory)| self.finder.picture(&read.pixels));
        let picture = picture.map_err(|problem| {
            self.refused_pictures.extend(key.as_ref().map(|key| (key.path.clone(), problem.clone())));
            format!("picture {name:?}: {problem}")
        })?;
        let images = &mut self.description.images;
        images.push(ImageDescription { name: name.to_owned(), picture });
        let index = images.len() - 1;
        if let Some(key) = key {
            self.images.insert(key, index);
        }
        Ok(index)
    }
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, ResourceBudget, ResourceLimits};
    use glanz_light::{Pixels, Tone};

    use super::*;
    use crate::finder::FileFinder;
    use crate::image::Format;
    use crate::source::Reporter;

    #[test]
    fn pictures_are_taken_off_the_budget_each_time_they_are_decoded() {
        let pixels = Pixels::try_from_rgb(100, 100, &vec![[1.0; 3]; 10_000]).unwrap();
        let bytes = image::write(&pixels, Format::Png, &Tone::default(), &Default::default()).unwrap();
        let path = std::env::temp_dir().join(format!("glanz-formats-{}-budget.png", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        let name = path.file_name().unwrap().display().to_string();
        let read = |pixels: u64| {
            let limits = ResourceLimits { pixels, ..ResourceLimits::default() };
            let budget = ResourceBudget::new(limits, CancelFlag::default());
            let mut finder = FileFinder::new(path.parent());
            finder.budget = budget;
            let mut lowering = Lowering::new(Reporter::default(), Dialect::V4, finder);
            [Encoding::Srgb, Encoding::Linear]
                .map(|encoding| lowering.picture(&name, encoding).map_err(|e| e.message))
        };
        let results = [9_999, 10_000, 20_000].map(read);
        std::fs::remove_file(&path).unwrap();
        let refused = |limit| Err(format!("picture {name:?}: PNG: the limit of {limit} pixels is exceeded"));
        assert_eq!(results[0], [refused("9 999"), refused("9 999")]);
        assert_eq!(results[1], [Ok(0), refused("10 000")]);
        assert_eq!(results[2], [Ok(0), Ok(1)]);
    }

    #[test]
    fn a_broken_picture_has_one_message() {
        let path = std::env::temp_dir().join(format!("glanz-formats-{}-broken.png", std::process::id()));
        std::fs::write(&path, b"no").unwrap();
        let name = path.file_name().unwrap().display().to_string();
        let mut lowering = Lowering::new(Reporter::default(), Dialect::V4, FileFinder::new(path.parent()));
        let results = [Encoding::Srgb, Encoding::Linear, Encoding::Gamma(2.0)]
            .map(|encoding| lowering.picture(&name, encoding).map_err(|e| e.message));
        std::fs::remove_file(&path).unwrap();
        let problem = results[0].clone().unwrap_err();
        assert!(results.iter().all(|result| result.as_ref() == Err(&problem)), "{results:?}");
    }
}
