//! Descriptions of files with their materials.

use std::collections::BTreeMap;

use glanz_light::SpectralDistribution;
use glanz_scene::Severity;
use glanz_scene::description::{
    EmissionDescription, GeometryDescription, ImageDescription, ImageFilter, ImageWrap, MappingDescription,
    MaterialDescription, MaterialKind, ShapeDescription, SpectrumParameter, TextureKind,
};
use glanz_scene::studio::CAD_GREY;

use super::{ObjFile, ObjMaterial, SkippedStatement, read, read_materials};
use crate::model::{ModelReader, PictureContent, SurfaceParameters, exponent, mean, read_picture};

/// A material of the description, with the emission of its surfaces.
type StyledMaterial = (usize, Option<EmissionDescription>);

/// Models of illumination with refraction, and with the reflection of a mirror.
const REFRACTION: [f64; 2] = [6.0, 7.0];
const MIRROR: [f64; 2] = [3.0, 5.0];

/// Refractive index of glass, for files without one.
const GLASS: f64 = 1.5;

/// Adds a file to the description.
pub(crate) fn read_into(bytes: &[u8], reader: &mut ModelReader) {
    let file = match read(bytes) {
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
    let mut missing = BTreeMap::new();
    let mut placed = |geometry: GeometryDescription, name: Option<String>| {
        let known = name.as_ref().and_then(|name| materials.get(name));
        if let (Some(name), None) = (name, known) {
            *missing.entry(name).or_insert(0) += 1;
        }
        let (material, emission) = known.cloned().unwrap_or_default();
        ShapeDescription { material, emission, ..geometry.into() }
    };
    for mesh in file.meshes {
        let super::ObjMesh { material, positions, normals, uvs, triangles: indices } = mesh;
        let geometry = GeometryDescription::Triangles { positions, indices, normals, uvs };
        reader.description.world.shapes.push(placed(geometry, material));
    }
    for super::ObjSurface { material, surface, trim } in file.surfaces {
        let shape = ShapeDescription { trim, ..placed(GeometryDescription::Nurbs(surface), material) };
        reader.description.world.shapes.push(shape);
    }
    // Without a file of materials, names of materials are expected.
    for name in missing.into_keys().filter(|_| !file.libraries.is_empty()) {
        reader.stand_in("obj-material", None, format!("material {name:?} does not exist; grey stands in"));
    }
}

/// State of the lowering of materials.
struct MaterialLowering<'a> {
    reader: &'a mut ModelReader,
    /// Index of each picture that was read; `None`: it cannot be read.
    images: BTreeMap<String, Option<usize>>,
}

impl MaterialLowering<'_> {
    fn libraries(mut self, libraries: &[String]) -> BTreeMap<String, StyledMaterial> {
        let mut materials = BTreeMap::new();
        let mut known: Vec<&str> = Vec::new();
        for library in libraries {
            // Names may contain blanks, and a statement may have several names.
            let whole = self.reader.read_file(library).map(|bytes| vec![(library.as_str(), bytes)]);
            let files = whole.or_else(|problem| {
                let names = library.split(' ').filter(|name| !name.is_empty());
                let parts = names.map(|name| Ok((name, self.reader.read_file(name)?)));
                parts.collect::<Result<Vec<_>, (String, bool)>>().map_err(|_| problem)
            });
            let files = match files {
                Ok(files) => files,
                Err((problem, true)) => {
                    self.reader.error("missing-file", None, problem);
                    continue;
                }
                Err((problem, false)) => {
                    self.reader.stand_in(
                        "missing-file",
                        None,
                        format!("{problem}; grey stands in for its materials"),
                    );
                    continue;
                }
            };
            for (name, bytes) in files {
                if !known.contains(&name) {
                    known.push(name);
                    self.library(name, &bytes, &mut materials);
                }
            }
        }
        materials
    }

    fn library(&mut self, name: &str, bytes: &[u8], materials: &mut BTreeMap<String, StyledMaterial>) {
        match read_materials(bytes) {
            Ok(file) => {
                report(self.reader, name, &file.skipped);
                for material in file.materials {
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
        let kind = self.kind(material, diffuse, &name);
        let emission = self.emission(material, &name);
        let materials = &mut self.reader.description.materials;
        materials.push(MaterialDescription { name: material.name.clone(), ..kind.into() });
        (materials.len() - 1, emission)
    }

    /// The scattering model: glass for models of illumination with refraction, the metallic-roughness model where its parameters are given, else
    /// that of Phong.
    fn kind(&mut self, material: &ObjMaterial, diffuse: SpectrumParameter, name: &str) -> MaterialKind {
        let is_model = |models: [f64; 2]| material.illumination.is_some_and(|model| models.contains(&model));
        let index = material.index.filter(|index| (1.0..=1e3).contains(index));
        if is_model(REFRACTION) {
            let filter = rgb(material.filter.unwrap_or([1.0; 3]));
            return MaterialKind::dielectric(index.unwrap_or(GLASS) as f32, 1.0, filter);
        }
        if material.opacity.is_some_and(|opacity| opacity < 1.0) {
            let message = format!("{name}: transparency is not available; an opaque surface stands in");
            self.reader.stand_in("obj-opacity", None, message);
        }
        if material.metallic.is_some() || material.roughness.is_some() {
            let unit = |x: Option<f64>, default: f64| x.unwrap_or(default).clamp(0.0, 1.0) as f32;
            return self.reader.surface_model(SurfaceParameters {
                base_color: diffuse,
                metallic: unit(material.metallic, 0.0).into(),
                roughness: unit(material.roughness, 0.5),
                ior: index.unwrap_or(GLASS) as f32,
                specular: [1.0; 3],
                transmission: 0.0,
                solid: false,
            });
        }
        let specular = rgb(material.specular.unwrap_or([0.0; 3]));
        // Exporters write the highlight of surfaces without one, too.
        let has_highlight = material.illumination.is_none_or(|model| model >= 2.0) && specular != [0.0; 3];
        match diffuse {
            diffuse if !has_highlight => MaterialKind::diffuse(diffuse),
            SpectrumParameter::Value(SpectralDistribution::Rgb([0.0, 0.0, 0.0])) if is_model(MIRROR) => {
                MaterialKind::mirror(specular)
            }
            diffuse => {
                // `Ns` is the exponent about the half vector, whose angle to the normal is half of that from the mirrored direction.
                let sharp = material.exponent.map_or(exponent(0.5), |exponent| (0.25 * exponent) as f32);
                let sharp = sharp.clamp(0.0, 1e6);
                let (diffuse, specular) = conserving(diffuse, specular);
                MaterialKind::phong(diffuse.clone(), diffuse, specular, sharp)
            }
        }
    }

    /// The diffuse reflectance: the picture times `Kd`.
    fn diffuse(&mut self, material: &ObjMaterial, name: &str) -> SpectrumParameter {
        let map = material.diffuse_map.as_ref();
        let image = map.and_then(|map| Some((map, self.image(&map.file, name)?)));
        let Some((map, image)) = image else {
            return rgb(material.diffuse.unwrap_or(CAD_GREY.map(f64::from))).into();
        };
        let mapping = MappingDescription::Uv { scale: map.scale.into(), offset: map.offset.into() };
        let wrap = if map.clamped { ImageWrap::Clamp } else { ImageWrap::Repeat };
        let filter = ImageFilter::Trilinear;
        let kind = TextureKind::Image { image, mapping, wrap, filter, scale: 1.0, invert: false };
        let picture = SpectrumParameter::Texture(self.reader.add_texture(map.file.clone(), kind));
        match material.diffuse {
            // Exporters write black where the picture counts alone.
            None | Some([1.0, 1.0, 1.0] | [0.0, 0.0, 0.0]) => picture,
            Some(factor) => self.reader.scaled(picture, rgb(factor).into()),
        }
    }

    /// The emitted light: of a picture the mean.
    fn emission(&mut self, material: &ObjMaterial, name: &str) -> Option<EmissionDescription> {
        let default = material.emission_map.as_ref().map(|_| [1.0; 3]);
        let color = material.emission.or(default).filter(|color| *color != [0.0; 3])?;
        let mean = match &material.emission_map {
            Some(map) => {
                let image = self.image(&map.file, name);
                let message = format!("{name}: the mean of the picture of emitted light stands in for it");
                self.reader.stand_in("obj-emission", None, message);
                let image = image.and_then(|image| self.reader.description.images.get(image));
                image.map_or([1.0; 3], |image| mean(&image.pixels))
            }
            None => [1.0; 3],
        };
        let color = rgb(color);
        Some([0, 1, 2].map(|i| color[i] * mean[i]).into())
    }

    /// The index of a picture; `None`, after a report, if it cannot be read.
    fn image(&mut self, map: &str, name: &str) -> Option<usize> {
        if let Some(known) = self.images.get(map) {
            return *known;
        }
        let read = self.reader.read_file(map).map_err(|(problem, _)| problem);
        let index = match read.and_then(|bytes| read_picture(&bytes, PictureContent::Color)) {
            Ok(pixels) => {
                let images = &mut self.reader.description.images;
                images.push(ImageDescription { name: map.to_owned(), pixels: pixels.into() });
                Some(images.len() - 1)
            }
            Err(problem) => {
                let message = format!("{name}: picture {map:?}: {problem}; its colour stands in");
                self.reader.stand_in("obj-picture", None, message);
                None
            }
        };
        self.images.insert(map.to_owned(), index);
        index
    }
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
