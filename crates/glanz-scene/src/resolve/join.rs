//! Joins small meshes.
//!
//! Exporters write a mesh per wall or per patch, thousands of two triangles each. Tested one by one, each costs a call and a
//! box; joined, they share one hierarchy and are tested four at a time.

use std::sync::Arc;

use glanz_geometry::Surface;
use glanz_geometry::mesh::Mesh;

use crate::object::{JoinedShape, SceneObject};

/// Meshes of more triangles have a hierarchy worth keeping, and copying them would cost memory.
const LARGEST: usize = 256;

/// Joins the small meshes among `objects`, which keep their numbers, materials and orientation by face.
///
/// Lights are not joined: points are sampled on one shape at a time. Neither are shapes with an opacity of their own, nor those that light passes.
pub(super) fn join_small_meshes(objects: Vec<SceneObject>) -> Vec<SceneObject> {
    // Lists by vertex exist for all or for none: four kinds of meshes.
    let mut kinds: [Vec<(Arc<Mesh>, SceneObject)>; 4] = Default::default();
    let mut rest = Vec::with_capacity(objects.len());
    for object in objects {
        match object.surface() {
            Surface::Mesh(mesh) if joinable(mesh, &object) => {
                let kind = usize::from(mesh.normals().is_some()) + 2 * usize::from(mesh.uvs().is_some());
                kinds[kind].push((Arc::clone(mesh), object));
            }
            _ => rest.push(object),
        }
    }
    for meshes in kinds {
        match join(&meshes) {
            Some(joined) => rest.push(joined),
            None => rest.extend(meshes.into_iter().map(|(_, object)| object)),
        }
    }
    rest
}

fn joinable(mesh: &Mesh, object: &SceneObject) -> bool {
    mesh.indices().len() <= LARGEST
        && object.to_parent().is_none()
        && object.light.is_none()
        && object.solid.is_none()
        && object.alpha.is_none()
        && !object.passable
        && object.shape_count() == 1
}

/// One object of all meshes; `None` if there are fewer than two, or more vertices than can be numbered.
fn join(meshes: &[(Arc<Mesh>, SceneObject)]) -> Option<SceneObject> {
    let [(first, object), _, ..] = meshes else { return None };
    let (mut positions, mut indices, mut shapes) = (Vec::new(), Vec::new(), Vec::with_capacity(meshes.len()));
    let mut normals = first.normals().map(|_| Vec::new());
    let mut uvs = first.uvs().map(|_| Vec::new());
    for (mesh, object) in meshes {
        let base = u32::try_from(positions.len()).ok()?;
        shapes.push(JoinedShape {
            first_face: u32::try_from(indices.len()).ok()?,
            attributes: object.attributes(0),
        });
        base.checked_add(u32::try_from(mesh.vertex_count()).ok()?)?;
        positions.extend(mesh.positions());
        indices.extend(mesh.indices().iter().map(|triangle| triangle.map(|vertex| base + vertex)));
        if let Some(normals) = &mut normals {
            normals.extend(mesh.normals()?);
        }
        if let Some(uvs) = &mut uvs {
            uvs.extend(mesh.uvs()?);
        }
    }
    let mesh = Mesh::try_new(positions, indices, normals, uvs).ok()?;
    Some(SceneObject::joined(Surface::Mesh(Arc::new(mesh)), shapes, object.attributes(0)))
}
