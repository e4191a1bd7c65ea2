//! `Shape "loopsubdiv"`.

use glanz_geometry::SurfaceError;
use glanz_geometry::subdivision::{SubdividedMesh, loop_subdivision};
use glanz_scene::description::GeometryDescription;

use super::Lowering;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// Levels without the parameter.
const LEVELS: u32 = 3;

impl Lowering {
    /// The limit surface of a control mesh, as triangles with its normals.
    pub(super) fn loop_subdivision(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        // There is one scheme.
        list.ignore(&["scheme"]);
        let (p, positions) = self.positions(list)?;
        let triangles = self.corners::<3>(list, &p, positions.len())?;
        let levels = list.integer_from("nlevels", 0, &mut self.reporter)?;
        let levels = list.integer_from("levels", 0, &mut self.reporter)?.or(levels).unwrap_or(LEVELS);
        match loop_subdivision(positions.clone(), triangles.clone(), levels) {
            Ok(SubdividedMesh { positions, normals, triangles: indices }) => {
                Ok(GeometryDescription::Triangles { positions, indices, normals: Some(normals), uvs: None })
            }
            Err(error @ (SurfaceError::NotManifold { .. } | SurfaceError::TooMany { .. })) => {
                let message = format!("shape \"loopsubdiv\": the control mesh stands in: {error}");
                self.stand_in(&p.value_place, "stand-in-shape", message);
                // The normals of the limit point to this side.
                let indices = triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
                Ok(GeometryDescription::Triangles { positions, indices, normals: None, uvs: None })
            }
            Err(error) => {
                let message = format!("shape \"loopsubdiv\": {error}");
                Err(self.reporter.error(&list.place, "subdivision", message))
            }
        }
    }
}
