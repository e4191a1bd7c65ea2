//! Descriptions of files with their materials.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use glanz_light::SpectralDistribution;
use glanz_math::DVec2;
use glanz_scene::Severity;
use glanz_scene::description::{
    AlphaDescription, EmissionDescription, FloatParameter, GeometryDescription, ImageDescription,
    ImageFilter, ImageWrap, MappingDescription, MaterialDescription, MaterialKind, ShapeDescription,
    SpectrumParameter, TextureKind,
};
use glanz_scene::studio::CAD_GREY;
use glanz_shading::model::PrincipledMaterial;

use super::{ObjFile, ObjMaterial, ObjPicture, SkippedStatement, read_materials_with, read_with};
use crate::file_list::FileKind;
use crate::model::{ModelReader, PictureContent, repetition};
use crate::source::MISSING_FILE;

/// A material of the description, with the emission and the opacity of its surfaces.
type StyledMaterial = (usize, Option<EmissionDescription>, Option<AlphaDescription>);

/// Models of illumination with refraction, and with the reflection of a mirror.
const REFRACTION: [f64; 2] = [6.0, 7.0];
const MIRROR: [f64; 2] = [3.0, 5.0];

/// Refractive index of glass, for files without one.
const GLASS: f64 = 1.5;

/// Exponent of a highlight, for files without one: of the width of facets of roughness 1/2.
const EXPONENT: f64 = 30.0;

/// Adds a file to the description.
pub(crate) fn read_into(bytes: &[u8], reader: &mut ModelReader) {
    let file = match read_with(bytes, &reader.finder.budget) {
        Ok(file) => file,
        Err(error) => return reader.error("obj", Some((error.line, error.column)), error.kind.to_string()),
    };
    if file.meshes.is_empty() && file.surfaces.is_empty() {
        return reader.error(
            "obj",
            None,
            "the file has no faces and no surfaces that can be read".to_owned(),
        );
    }
    report(reader, "", &file.skipped);
    let materials = MaterialLowering { reader, images: BTreeMap::new() }.libraries(&file.libraries);
    add(file, &materials, reader);
}

fn report(reader: &mut ModelReader, library: &str, skipped: &[SkippedStatement]) {
    for SkippedStatement { what, line, column } in skipped {
        match library {
            "" => reader.report(Severity::Warning, "obj-statement", Some((*line, *column)), what.clone()),
            library => {
                let message = format!("{library}:{line}:{column}: {what}");
                reader.report(Severity::Warning, "mtl-statement", None, message);
            }
        }
    }
}

/// Adds the surfaces.
fn add(file: ObjFile, materials: &BTreeMap<String, StyledMaterial>, reader: &mut ModelReader) {
    let styles: Vec<_> = file.materials.iter().map(|name| (name, materials.get(name))).collect();
    let mut missing = BTreeSet::new();
    let mut placed = |geometry: GeometryDescription, material: Option<usize>| {
        let style = material.and_then(|number| styles.get(number));
        missing.extend(style.filter(|(_, known)| known.is_none()).map(|(name, _)| *name));
        let known = style.and_then(|(_, known)| *known);
        let (material, emission, alpha) = known.cloned().unwrap_or_default();
        ShapeDescription { material, emission, alpha, ..geometry.into() }
    };
    for mesh in file.meshes {
        let super::ObjMesh { material, positions, normals, mut uvs, triangles: indices } = mesh;
        if let (Some(uvs), Some((name, Some((_, Some(emission), _))))) =
            (&mut uvs, material.and_then(|number| styles.get(number)))
            && emission.image.is_some()
        {
            place_in_picture(uvs, name, reader);
        }
        let geometry = GeometryDescription::Triangles { positions, indices, normals, uvs };
        reader.description.world.shapes.push(placed(geometry, material));
    }
    for super::ObjSurface { material, surface, trim } in file.surfaces {
        let shape = ShapeDescription { trim, ..placed(GeometryDescription::Nurbs(surface), material) };
        reader.description.world.shapes.push(shape);
    }
    // Without a file of materials, names of materials are expected.
    for name in missing.into_iter().filter(|_| !file.libraries.is_empty()) {
        reader.stand_in("obj-material", None, format!("material {name:?} does not exist; grey stands in"));
    }
}

/// Moves the coordinates of a picture of emitted light, which does not repeat, by whole pictures, or reports that this does not suffice.
fn place_in_picture(uvs: &mut [DVec2], material: &str, reader: &mut ModelReader) {
    match repetition(uvs) {
        // The other pictures repeat.
        Some(whole) => uvs.iter_mut().for_each(|uv| *uv -= whole),
        None => {
            let message = format!(
                "material {material:?}: the picture of emitted light does not repeat; its border continues"
            );
            reader.stand_in("obj-emission", None, message);
        }
    }
}

/// State of the lowering of materials.
struct MaterialLowering<'a> {
    reader: &'a mut ModelReader,
    /// Index of each picture that was read; `None`: it cannot be read.
    images: BTreeMap<(String, PictureContent), Option<usize>>,
}

impl MaterialLowering<'_> {
    fn libraries(mut self, libraries: &[String]) -> BTreeMap<String, StyledMaterial> {
        let mut materials = BTreeMap::new();
        let mut known = BTreeSet::new();
        for library in libraries {
            match self.files(library) {
                Ok(files) => {
                    for (name, path) in files {
                        if known.insert(path) {
                            self.library(name, &mut materials);
                        }
                    }
                }
                Err(problem) => {
                    self.reader.name_file(library, FileKind::Materials);
                    self.report_missing(problem);
                }
            }
        }
        materials
    }

    /// The names in a statement, with the files. Names may contain blanks, and a statement may have several names.
    fn files<'l>(&self, library: &'l str) -> Result<Vec<(&'l str, PathBuf)>, (String, bool)> {
        let file = |name| self.reader.real_path(name).map(|path| (name, path));
        file(library).map(|one| vec![one]).or_else(|problem| {
            let names = library.split(' ').filter(|name| !name.is_empty());
            names.map(file).collect::<Result<_, _>>().map_err(|_| problem)
        })
    }

    fn report_missing(&mut self, (problem, is_outside): (String, bool)) {
        if is_outside {
            self.reader.error(MISSING_FILE, None, problem);
        } else {
            let message = format!("{problem}; grey stands in for its materials");
            self.reader.stand_in(MISSING_FILE, None, message);
        }
    }

    fn library(&mut self, name: &str, materials: &mut BTreeMap<String, StyledMaterial>) {
        let bytes = match self.reader.read_file(name, FileKind::Materials) {
            Ok(bytes) => bytes,
            Err(problem) => return self.report_missing(problem),
        };
        match read_materials_with(&bytes, &self.reader.finder.budget) {
            Ok(file) => {
                report(self.reader, name, &file.skipped);
                for material in file.materials {
                    if self.reader.finder.budget.check().is_err() {
                        return;
                    }
                    let lowered = self.material(&material, name);
                    materials.insert(material.name, lowered);
                }
            }
            Err(error) => self.reader.error("mtl", None, format!("{name}:{error}")),
        }
    }

    fn material(&mut self, material: &ObjMaterial, library: &str) -> StyledMaterial {
        let name = format!("{library}: material {:?}", material.name);
        let diffuse = self.diffuse(material, &name);
        let kind = self.kind(material, diffuse);
        let emission = self.emission(material, &name);
        let alpha = if is_refracting(material) { None } else { self.alpha(material, &name) };
        self.reader.spend_entry::<MaterialDescription>(&material.name);
        let materials = &mut self.reader.description.materials;
        materials.push(MaterialDescription { name: material.name.clone(), ..kind.into() });
        (materials.len() - 1, emission, alpha)
    }

    /// The scattering model: glass for models of illumination with refraction, the metallic-roughness model where its parameters are given, else
    /// that of Phong.
    fn kind(&self, material: &ObjMaterial, diffuse: SpectrumParameter) -> MaterialKind {
        let index = material.index.filter(|index| (1.0..=1e3).contains(index));
        if is_refracting(material) {
            let filter = rgb(material.filter.unwrap_or([1.0; 3]));
            return MaterialKind::dielectric(index.unwrap_or(GLASS) as f32, 1.0, filter);
        }
        if material.metallic.is_some() || material.roughness.is_some() {
            let unit = |x: Option<f64>, default: f64| x.unwrap_or(default).clamp(0.0, 1.0) as f32;
            return MaterialKind::Principled(PrincipledMaterial {
                metallic: unit(material.metallic, 0.0).into(),
                eta: (index.unwrap_or(GLASS) as f32).into(),
                ..PrincipledMaterial::new(diffuse, unit(material.roughness, 0.5))
            });
        }
        let specular = rgb(material.specular.unwrap_or([0.0; 3]));
        // Exporters write the highlight of surfaces without one, too.
        let has_highlight = material.illumination.is_none_or(|model| model >= 2.0) && specular != [0.0; 3];
        match diffuse {
            diffuse if !has_highlight => MaterialKind::diffuse(diffuse),
            SpectrumParameter::Value(SpectralDistribution::Rgb([0.0, 0.0, 0.0]))
                if is_model(material, MIRROR) =>
            {
                MaterialKind::mirror(specular)
            }
            diffuse => {
                // `Ns` is the exponent about the half vector, whose angle to the normal is half of that from the mirrored direction.
                let sharp = (0.25 * material.exponent.unwrap_or(EXPONENT)).clamp(0.0, 1e6) as f32;
                let (diffuse, specular) = conserving(diffuse, specular);
                MaterialKind::phong(diffuse.clone(), diffuse, specular, sharp)
            }
        }
    }

    /// The diffuse reflectance: the picture times `Kd`.
    fn diffuse(&mut self, material: &ObjMaterial, name: &str) -> SpectrumParameter {
        let picture = material
            .diffuse_map
            .as_ref()
            .and_then(|map| self.image_texture(map, PictureContent::Color, name));
        let Some(picture) = picture else {
            return rgb(material.diffuse.unwrap_or(CAD_GREY.map(f64::from))).into();
        };
        let picture = SpectrumParameter::Texture(picture);
        match material.diffuse {
            // Exporters write black where the picture counts alone.
            None | Some([1.0, 1.0, 1.0] | [0.0, 0.0, 0.0]) => picture,
            Some(factor) => self.reader.scaled(picture, rgb(factor).into()),
        }
    }

    /// The opacity: the picture times `d`.
    fn alpha(&mut self, material: &ObjMaterial, name: &str) -> Option<AlphaDescription> {
        // Some programs write `Tr` with the meaning of `d`, beside it.
        let factor = material.opacity.or(material.transparency.map(|x| 1.0 - x)).unwrap_or(1.0);
        let factor = factor.clamp(0.0, 1.0) as f32;
        let map = material.opacity_map.as_ref();
        let opacity = match map.and_then(|map| self.image_texture(map, PictureContent::Opacity, name)) {
            Some(picture) => self.reader.scaled_number(FloatParameter::Texture(picture), factor),
            None => factor.into(),
        };
        (opacity != 1.0.into()).then(|| opacity.into())
    }

    /// The emitted light.
    fn emission(&mut self, material: &ObjMaterial, name: &str) -> Option<EmissionDescription> {
        let default = material.emission_map.as_ref().map(|_| [1.0; 3]);
        let color = material.emission.or(default).filter(|color| *color != [0.0; 3])?;
        let image = material.emission_map.as_ref().and_then(|map| {
            if *map != (ObjPicture { file: map.file.clone(), ..ObjPicture::default() }) {
                let message =
                    format!("{name}: options of the picture of emitted light are not available and left out");
                self.reader.stand_in("obj-emission", None, message);
            }
            self.image(&map.file, PictureContent::Color, name)
        });
        Some(EmissionDescription { image, ..rgb(color).into() })
    }

    /// A texture that shows a picture by the coordinates of the surface.
    fn image_texture(&mut self, map: &ObjPicture, content: PictureContent, name: &str) -> Option<usize> {
        let image = self.image(&map.file, content, name)?;
        let mapping = MappingDescription::Uv { scale: map.scale.into(), offset: map.offset.into() };
        let wrap = if map.clamped { ImageWrap::Clamp } else { ImageWrap::Repeat };
        let filter = ImageFilter::ANISOTROPIC;
        let kind = TextureKind::Image { image, mapping, wrap, filter, scale: 1.0, invert: false };
        Some(self.reader.add_texture(map.file.clone(), kind))
    }

    /// The index of a picture; `None`, after a report, if it cannot be read.
    fn image(&mut self, map: &str, content: PictureContent, name: &str) -> Option<usize> {
        let key = (map.to_owned(), content);
        if let Some(known) = self.images.get(&key) {
            return *known;
        }
        let read = self.reader.read_file(map, FileKind::Picture).map_err(|(problem, _)| problem);
        let index = match read.and_then(|bytes| self.reader.picture(&bytes, content)) {
            Ok(picture) => {
                let images = &mut self.reader.description.images;
                images.push(ImageDescription { name: map.to_owned(), picture });
                Some(images.len() - 1)
            }
            Err(problem) => {
                let message = format!("{name}: picture {map:?}: {problem}; its colour stands in");
                self.reader.stand_in("obj-picture", None, message);
                None
            }
        };
        self.images.insert(key, index);
        index
    }
}

fn is_model(material: &ObjMaterial, models: [f64; 2]) -> bool {
    material.illumination.is_some_and(|model| models.contains(&model))
}

/// Whether it is glass.
fn is_refracting(material: &ObjMaterial) -> bool {
    is_model(material, REFRACTION)
}

fn rgb(color: [f64; 3]) -> [f32; 3] {
    color.map(|x| x as f32)
}

/// Both scaled such that their sum is at most 1, where both are constant.
fn conserving(diffuse: SpectrumParameter, specular: [f32; 3]) -> (SpectrumParameter, [f32; 3]) {
    let SpectrumParameter::Value(SpectralDistribution::Rgb(color)) = diffuse else {
        return (diffuse, specular);
    };
    let most = [0, 1, 2].map(|i| color[i] + specular[i]).into_iter().fold(1.0, f32::max);
    (color.map(|x| x / most).into(), specular.map(|x| x / most))
}
