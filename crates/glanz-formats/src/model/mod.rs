//! Files of surfaces alone as descriptions: without camera and light, which [`glanz_scene::studio`] adds.

use std::path::Path;
use std::sync::Arc;

use glanz_job::ResourceBudget;
use glanz_scene::description::GeometryDescription;
use glanz_scene::{Diagnostics, Severity};

use crate::cad::{CadModel, CadWarning};
use crate::file_list::SceneFileList;
use crate::finder::spend_groups;
use crate::registry::{Loaded, ModelFormat, Options};
use crate::{gltf, newell, obj, ply, rib, stl};

mod light_copies;
mod material;
mod picture;
mod reader;

pub(crate) use light_copies::{MAX_LIGHT_COPIES, face_count, light_count};
pub(crate) use material::grey;
pub(crate) use picture::{PictureContent, repetition};
pub(crate) use reader::ModelReader;

/// Reads a model from the bytes of its file. `name`: its name in messages; `path`: its path, if it is a file.
pub(crate) fn load(
    format: ModelFormat,
    name: &str,
    path: Option<&Path>,
    bytes: &Arc<[u8]>,
    options: &Options,
    budget: &ResourceBudget,
) -> Result<Loaded, Diagnostics> {
    let mut reader = ModelReader::new(name, path, bytes, options, budget)?;
    reader.read(format, bytes, options);
    reader.finish(format.up(), options)
}

/// Lists the files that a model needs.
pub(crate) fn list_files(
    format: ModelFormat,
    name: &str,
    path: &Path,
    bytes: &Arc<[u8]>,
    options: &Options,
    budget: &ResourceBudget,
) -> Result<SceneFileList, Diagnostics> {
    let mut reader = ModelReader::new(name, Some(path), bytes, options, budget)?;
    reader.finder.lists = true;
    if matches!(format, ModelFormat::Obj | ModelFormat::Gltf) {
        reader.read(format, bytes, options);
    }
    Ok(reader.finder.into_list(reader.diagnostics))
}

impl ModelReader {
    fn read(&mut self, format: ModelFormat, bytes: &[u8], options: &Options) {
        self.read_format(format, bytes, options);
        // The reader of glTF spends as it reads.
        let added = std::slice::from_ref(&self.description.world);
        let spent = match format {
            ModelFormat::Gltf => Ok(()),
            _ => spend_groups(&self.finder.budget, added)
                .and_then(|()| spend_groups(&self.finder.budget, &self.description.groups)),
        };
        if let Err(end) = spent {
            self.error("limit", None, end.to_string());
        }
    }

    fn read_format(&mut self, format: ModelFormat, bytes: &[u8], options: &Options) {
        match format {
            ModelFormat::Ply => self.ply(bytes),
            ModelFormat::Rib => self.rib(bytes),
            ModelFormat::Newell => self.newell(bytes),
            ModelFormat::Step => self.cad("step", bytes, options.edges),
            ModelFormat::Obj => obj::read_into(bytes, self),
            ModelFormat::Gltf => gltf::read(bytes, self),
            ModelFormat::Stl => self.stl(bytes),
            ModelFormat::Iges => self.cad("iges", bytes, options.edges),
        }
    }

    fn ply(&mut self, bytes: &[u8]) {
        match ply::read_with(bytes, &self.finder.budget) {
            Ok(ply::PlyMesh { positions, normals, uvs, triangles: indices, skipped_faces }) => {
                if indices.is_empty() {
                    return self.error("ply", None, "the mesh has no triangles".to_owned());
                }
                if skipped_faces > 0 {
                    let message =
                        format!("{skipped_faces} faces have fewer than three corners and are left out");
                    self.report(Severity::Warning, "ply-faces", None, message);
                }
                self.add(GeometryDescription::Triangles { positions, indices, normals, uvs });
            }
            Err(error) => match error.position {
                ply::PlyPosition::Text { line, column } => {
                    self.error("ply", Some((line, column)), error.kind.to_string());
                }
                ply::PlyPosition::Byte(_) => self.error("ply", None, error.to_string()),
            },
        }
    }

    fn stl(&mut self, bytes: &[u8]) {
        match stl::read_with(bytes, &self.finder.budget) {
            Ok(mesh) if mesh.triangles.is_empty() => {
                self.error("stl", None, "the file has no facets".to_owned());
            }
            Ok(stl::StlMesh { positions, triangles: indices }) => {
                self.add(GeometryDescription::Triangles { positions, indices, normals: None, uvs: None });
            }
            Err(error) => self.error("stl", error.place, error.to_string()),
        }
    }

    fn rib(&mut self, bytes: &[u8]) {
        let file = match rib::read_with(bytes, &self.finder.budget) {
            Ok(file) => file,
            Err(error) => {
                return self.error("rib", Some((error.line, error.column)), error.kind.to_string());
            }
        };
        if file.patches.is_empty() && file.splines.is_empty() {
            return self.error("rib", None, "the file has no Patch, PatchMesh or NuPatch".to_owned());
        }
        for rib::SkippedRequest { name, line, column } in file.skipped {
            let message = format!("request {name:?} is not read and skipped");
            self.report(Severity::Warning, "rib-request", Some((line, column)), message);
        }
        file.patches
            .into_iter()
            .map(GeometryDescription::BezierPatches)
            .for_each(|patches| self.add(patches));
        file.splines.into_iter().map(GeometryDescription::Nurbs).for_each(|spline| self.add(spline));
    }

    fn cad(&mut self, kind: &'static str, bytes: &[u8], with_edges: bool) {
        let report = match CadModel::read_with(bytes, with_edges, &self.finder.budget) {
            Ok(model) => model.into_world(&mut self.description),
            Err(error) => return self.error(kind, None, error.to_string()),
        };
        for CadWarning { kind, position, message } in report.warnings() {
            self.report(Severity::Warning, kind, position, message);
        }
        if report.shapes.is_empty() {
            return self.error(kind, None, "the file shows no surface that can be read".to_owned());
        }
        self.cad = Some(report);
    }

    fn newell(&mut self, bytes: &[u8]) {
        match newell::read_with(bytes, &self.finder.budget) {
            Ok(mesh) if mesh.patches.is_empty() => {
                self.error("newell", None, "the file has no patches".to_owned());
            }
            Ok(mesh) => {
                let patches = newell::bicubic_patches(&mesh.positions, &mesh.patches);
                self.add(GeometryDescription::BezierPatches(patches));
            }
            Err(error) => self.error("newell", Some((error.line, error.column)), error.kind.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;
    use glanz_scene::studio::{StudioSettings, UpAxis};

    use super::*;
    use crate::registry::load_str;

    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n";

    fn loaded(text: &str) -> Loaded {
        load_str("m", text, &Options::default()).unwrap()
    }

    fn message(text: &str) -> String {
        load_str("m", text, &Options::default()).unwrap_err().to_string()
    }

    #[test]
    fn models_have_shapes_a_material_and_a_studio() {
        let patch = "Patch \"bilinear\" \"P\" [0 0 0  1 0 0  0 2 0  1 2 0]";
        let list = format!("1\n{}\n16\n{}1 2 0\n", "1,".repeat(15) + "16", "0 0 0\n".repeat(15));
        for (text, up) in [(PLY, UpAxis::Y), (patch, UpAxis::Z), (&list, UpAxis::Z)] {
            let model = loaded(text);
            assert_eq!(model.description.bounds().max, DVec3::new(1.0, 2.0, 0.0), "{text}");
            assert_eq!((model.description.materials.len(), model.description.files.len()), (1, 1));
            assert!(model.description.lights.is_empty() && model.diagnostics.iter().next().is_none());
            assert_eq!(model.studio.unwrap(), StudioSettings { up: Some(up), ..StudioSettings::default() });
        }
        let studio = StudioSettings { up: Some(UpAxis::Z), ..StudioSettings::default() };
        let options = Options { studio: studio.clone(), ..Options::default() };
        assert_eq!(load_str("m", PLY, &options).unwrap().studio, Some(studio), "the options go first");
    }

    #[test]
    fn errors_name_the_place_in_the_file() {
        let cut = PLY.replace("0 2 0\n", "0 x 0\n");
        assert!(
            message(&cut).starts_with("error: m:12:3: \"x\" is not a number\n  12 | 0 x 0"),
            "{}",
            message(&cut)
        );
        let text = "Patch \"bilinear\" \"P\" [0 0]";
        assert!(message(text).starts_with("error: m:1:"), "{}", message(text));
        assert!(message("1 2 x").starts_with("error: m:1:1: "), "{}", message("1 2 x"));
        assert_eq!(
            message("Basis \"bezier\" 3 \"bezier\" 3"),
            "error: m: the file has no Patch, PatchMesh or NuPatch\n"
        );
        let empty = PLY.replace("element face 1", "element face 0").replace("3 0 1 2\n", "");
        assert_eq!(message(&empty), "error: m: the mesh has no triangles\n");
        assert_eq!(message("0 0"), "error: m: the file has no patches\n");
    }

    #[test]
    fn what_is_left_out_is_reported() {
        let text = "Patch \"bilinear\" \"P\" [0 0 0  1 0 0  0 2 0  1 2 0]\nColor [1 0 0]";
        let warnings: Vec<String> = loaded(text).diagnostics.iter().map(|d| d.sentence()).collect();
        assert!(warnings.len() == 1 && warnings[0].contains("Color"), "{warnings:?}");
    }
}
