//! Shapes from OBJ and STL files, with the material of the scene.

use glanz_scene::description::GeometryDescription;

use super::Lowering;
use crate::obj::{self, ObjMesh, ObjSurface};
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;
use crate::stl;

impl Lowering {
    /// The surfaces of a file, at least one.
    pub(super) fn mesh_file(&mut self, list: &mut ParameterList) -> ParseResult<Vec<GeometryDescription>> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = format!("{} has no \"string filename\"", list.subject);
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let (path, bytes) = match self.read_file(&name) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("{}: {problem}", list.subject);
                return Err(self.reporter.error(&p.value_place, "missing-file", message));
            }
        };
        let shown = path.display();
        let read = if stl::is_stl(&bytes) { stl_surfaces(&bytes) } else { obj_surfaces(&bytes) };
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

/// Surfaces, and notes on what was left out, with its place.
type SurfacesAndNotes = (Vec<GeometryDescription>, Vec<String>);

fn stl_surfaces(bytes: &[u8]) -> Result<SurfacesAndNotes, String> {
    let mesh = stl::read(bytes).map_err(|error| match error.place {
        Some((line, column)) => format!(":{line}:{column}: {error}"),
        None => format!(": {error}"),
    })?;
    let stl::StlMesh { positions, triangles: indices } = mesh;
    let geometry = GeometryDescription::Triangles { positions, indices, normals: None, uvs: None };
    Ok((vec![geometry], Vec::new()))
}

fn obj_surfaces(bytes: &[u8]) -> Result<SurfacesAndNotes, String> {
    let file = obj::read(bytes).map_err(|error| format!(":{error}"))?;
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
