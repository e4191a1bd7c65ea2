//! Shapes from OBJ and STL files, with the material of the scene, and from glTF files, with their own.

use std::path::Path;

use glanz_job::ResourceBudget;
use glanz_scene::Severity;
use glanz_scene::description::{GeometryDescription, GroupDescription};

use super::{EntityState, Lowering};
use crate::file_list::FileKind;
use crate::gltf;
use crate::model::{ModelReader, light_count};
use crate::obj::{self, ObjMesh, ObjSurface};
use crate::pbrt::parameters::ParameterList;
use crate::source::{MISSING_FILE, ParseResult, Span};
use crate::stl;

impl Lowering {
    /// The surfaces of a file, at least one.
    pub(super) fn mesh_file(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
    ) -> ParseResult<Vec<GeometryDescription>> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = format!("{} has no \"string filename\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let (path, bytes) = match self.read_file(&name, FileKind::Mesh) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("{}: {problem}", list.subject);
                return Err(self.reporter.error(&p.value_place, MISSING_FILE, message));
            }
        };
        let shown = path.display();
        // Binary files with more or fewer bytes than their facets need are recognised by nothing else than the name of the shape.
        let is_stl = stl::is_stl(&bytes) || kind == "stl" && !obj::is_obj(&bytes);
        let read = match is_stl {
            true => stl_surfaces(&bytes, &self.finder.budget),
            false => obj_surfaces(&bytes, &self.finder.budget),
        };
        let (surfaces, notes) = read.map_err(|problem| {
            let message = format!("{}: {shown}{problem}", list.subject);
            self.reporter.error(&p.value_place, "mesh-file", message)
        })?;
        for note in notes {
            self.stand_in(&p.value_place, "mesh-file", format!("{}: {shown}{note}", list.subject));
        }
        if surfaces.is_empty() {
            let message = format!("{}: {shown} has no surfaces that can be read", list.subject);
            return Err(self.reporter.error(&p.value_place, "mesh-file", message));
        }
        Ok(surfaces)
    }
}

/// A glTF file, read once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GltfFile {
    group: usize,
    /// Whether there are media in it.
    has_media: bool,
}

impl Lowering {
    /// Adds an instance of the default scene of a glTF file. Its camera and lights have no effect.
    pub(super) fn gltf_shape(&mut self, mut list: ParameterList, context: &EntityState) -> ParseResult<()> {
        let place = list.place;
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = format!("{} has no \"string filename\"", list.subject);
            return Err(self.reporter.error(&place, "parameter-missing", message));
        };
        let opacity = "the opacity of their materials stands in";
        self.without_surface_parameters(&mut list, context, "glTF", opacity)?;
        let subject = std::mem::take(&mut list.subject);
        list.finish(&mut self.reporter);
        let known = self.locate(&name).ok().and_then(|path| self.gltf_files.get(&path).copied());
        let GltfFile { group, has_media } = match known {
            Some(file) => file,
            None => {
                let found = self
                    .find(&name, FileKind::Model)
                    .map_err(|fault| format!("file {name:?} {}", fault.what()));
                let read = found.and_then(|path| {
                    let bytes = self.finder.read(&path, FileKind::Model);
                    Ok((bytes.map_err(|error| format!("file {name:?} cannot be read: {error}"))?, path))
                });
                let (bytes, path) = read.map_err(|problem| {
                    let message = format!("{subject}: {problem}");
                    self.reporter.error(&p.value_place, MISSING_FILE, message)
                })?;
                let file = self.gltf_group(&path, &bytes, &subject, &p.value_place)?;
                self.gltf_files.insert(path, file);
                file
            }
        };
        if has_media && context.media.outside.is_some() && context.media.inside == context.media.outside {
            let message = format!("{subject}: glass that absorbs has empty space around, not the medium");
            self.stand_in(&p.value_place, "stand-in-medium", message);
        }
        self.add_instance(group, &place, context)
    }

    /// Adds a group of the default scene of a file.
    fn gltf_group(
        &mut self,
        path: &Path,
        bytes: &[u8],
        subject: &str,
        place: &Span,
    ) -> ParseResult<GltfFile> {
        let (mut description, finder) =
            (std::mem::take(&mut self.description), std::mem::take(&mut self.finder));
        let world = std::mem::take(&mut description.world);
        let (camera, film, lights) =
            (description.camera.clone(), description.film.clone(), description.lights.len());
        let (first, media) = (description.groups.len(), description.media.len());
        let mut reader = ModelReader::within(description, finder, Some(path));
        gltf::read(bytes, &mut reader);
        let ModelReader { mut description, finder, diagnostics, .. } = reader;
        let shapes = std::mem::replace(&mut description.world, world);
        description.lights.truncate(lights);
        (self.description, self.finder) = (glanz_scene::Description { camera, film, ..description }, finder);
        let shown = self.finder.shown(path).display().to_string();
        for diagnostic in diagnostics.iter() {
            let message = format!("{subject}: {shown}: {}", diagnostic.message);
            match diagnostic.severity {
                Severity::Error => return Err(self.reporter.error(place, diagnostic.kind, message)),
                Severity::Warning => self.stand_in(place, diagnostic.kind, message),
            }
        }
        self.description.groups.push(GroupDescription { name: shown, ..shapes });
        let groups = self.description.groups.iter().enumerate().skip(first);
        for (index, group) in groups {
            let emitting = light_count(&group.shapes);
            let inner = group.instances.iter().filter_map(|i| self.lights_in_groups.get(&i.group));
            let lights = inner.fold(emitting, |sum, lights| sum.saturating_add(*lights));
            self.lights_in_groups.insert(index, lights);
        }
        let has_media = self.description.media.len() > media;
        Ok(GltfFile { group: self.description.groups.len() - 1, has_media })
    }
}

/// Surfaces, and notes on what was left out, with its place.
type SurfacesAndNotes = (Vec<GeometryDescription>, Vec<String>);

fn stl_surfaces(bytes: &[u8], budget: &ResourceBudget) -> Result<SurfacesAndNotes, String> {
    let mesh = stl::read_with(bytes, budget).map_err(|error| match error.place {
        Some((line, column)) => format!(":{line}:{column}: {error}"),
        None => format!(": {error}"),
    })?;
    let stl::StlMesh { positions, triangles: indices } = mesh;
    let geometry = GeometryDescription::Triangles { positions, indices, normals: None, uvs: None };
    Ok((vec![geometry], Vec::new()))
}

fn obj_surfaces(bytes: &[u8], budget: &ResourceBudget) -> Result<SurfacesAndNotes, String> {
    let file = obj::read_with(bytes, budget).map_err(|error| format!(":{error}"))?;
    let skipped = file.skipped.iter();
    let mut notes: Vec<String> = skipped.map(|s| format!(":{}:{}: {}", s.line, s.column, s.what)).collect();
    let meshes = file.meshes.into_iter().map(|mesh| {
        let ObjMesh { positions, normals, uvs, triangles: indices, .. } = mesh;
        GeometryDescription::Triangles { positions, indices, normals, uvs }
    });
    let mut surfaces: Vec<GeometryDescription> = meshes.collect();
    for ObjSurface { surface, trim, .. } in file.surfaces {
        if trim.is_some() {
            notes.push(": a trimmed surface is left out; open the file itself to see it".to_owned());
        } else {
            surfaces.push(GeometryDescription::Nurbs(surface));
        }
    }
    Ok((surfaces, notes))
}
