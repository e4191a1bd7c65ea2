//! `Shape "loopsubdiv"`.

use glanz_geometry::SurfaceError;
use glanz_geometry::subdivision::{SubdividedMesh, loop_subdivision};
use glanz_math::DVec3;
use glanz_scene::description::GeometryDescription;

use super::Lowering;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// Levels without the parameter.
const LEVELS: u32 = 3;

/// Largest number of triangles of all subdivided meshes of a scene.
const MOST_SUBDIVIDED: usize = 1 << 24;

/// Bytes while a mesh is subdivided, for each triangle of the last level.
const BYTES_PER_TRIANGLE: u64 = 100;

impl Lowering {
    /// The limit surface of a control mesh, as triangles with its normals.
    pub(super) fn loop_subdivision(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        // There is one scheme.
        list.ignore(&["scheme"]);
        let (p, positions) = self.positions(list)?;
        let triangles = self.corners::<3>(list, &p, positions.len())?;
        let levels = list.integer_from("nlevels", 0, &mut self.reporter)?;
        let levels = list.integer_from("levels", 0, &mut self.reporter)?.or(levels).unwrap_or(LEVELS);
        let count = triangles.len().saturating_mul(4_usize.saturating_pow(levels));
        if count > MOST_SUBDIVIDED - self.subdivided {
            let message = format!(
                "shape \"loopsubdiv\": the control mesh stands in: the subdivided meshes of the scene have more than \
                 {MOST_SUBDIVIDED} triangles; use fewer levels"
            );
            self.stand_in(&p.value_place, "stand-in-shape", message);
            return Ok(control_mesh(positions, triangles));
        }
        let reserved = self.reporter.budget.reserve(BYTES_PER_TRIANGLE.saturating_mul(count as u64));
        let _memory = reserved.map_err(|end| self.reporter.end(&p.value_place, end))?;
        match loop_subdivision(positions.clone(), triangles.clone(), levels) {
            Ok(SubdividedMesh { positions, normals, triangles: indices }) => {
                self.subdivided += count;
                Ok(GeometryDescription::Triangles { positions, indices, normals: Some(normals), uvs: None })
            }
            Err(error @ (SurfaceError::NotManifold { .. } | SurfaceError::TooMany { .. })) => {
                let message = format!("shape \"loopsubdiv\": the control mesh stands in: {error}");
                self.stand_in(&p.value_place, "stand-in-shape", message);
                Ok(control_mesh(positions, triangles))
            }
            Err(error) => {
                let message = format!("shape \"loopsubdiv\": {error}");
                Err(self.reporter.error(&list.place, "subdivision", message))
            }
        }
    }
}

fn control_mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> GeometryDescription {
    // The normals of the limit point to this side.
    let indices = triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
    GeometryDescription::Triangles { positions, indices, normals: None, uvs: None }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::finder::FileFinder;
    use crate::pbrt::dialect::Dialect;
    use crate::pbrt::parser::Parser;
    use crate::registry::Options;
    use crate::source::Reporter;

    #[test]
    fn subdivided_meshes_of_a_scene_share_a_number_of_triangles() {
        let shape = |levels| {
            format!("Shape \"loopsubdiv\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer levels\" {levels}\n")
        };
        let text = format!("WorldBegin\n{}{}{}", shape(2), shape(2), shape(1));
        let bytes: Arc<[u8]> = text.into_bytes().into();
        let finder =
            FileFinder::of_scene("scene", None, &bytes, &Options::default(), &Default::default()).unwrap();
        let mut lowering = Lowering::new(Reporter::default(), Dialect::V4, finder);
        // Room for 16 and 4 triangles.
        lowering.subdivided = MOST_SUBDIVIDED - 20;
        let mut parser = Parser::new(lowering);
        parser.run("scene", None, bytes);
        let counts = parser.lowering.description.world.shapes.iter().map(|shape| match &shape.geometry {
            GeometryDescription::Triangles { indices, .. } => indices.len(),
            other => panic!("{other:?}"),
        });
        assert_eq!(counts.collect::<Vec<_>>(), [16, 1, 4]);
        let messages = parser.lowering.reporter.diagnostics.to_string();
        assert!(messages.contains("scene:3:31") && messages.contains("use fewer levels"), "{messages}");
    }
}
