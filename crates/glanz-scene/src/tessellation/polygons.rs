//! Shapes that consist of flat polygons.

use glanz_geometry::Surface;
use glanz_math::{DVec3, Transform};

use super::{GroupMesh, MeshVertex, TessellationFaultKind};
use crate::description::{GeometryDescription, ShapeDescription};
use crate::resolve::shape_surface;

/// Flat polygons with their points and, perhaps, normals by point.
pub(super) struct PolygonList {
    positions: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    triangles: Vec<[u32; 3]>,
}

/// The triangles of a shape that consists of flat polygons; `None` if it does not.
pub(super) fn polygons(shape: &ShapeDescription) -> Option<Result<PolygonList, TessellationFaultKind>> {
    let invalid = TessellationFaultKind::Invalid;
    if shape.trim.is_some() {
        return None;
    }
    let list = match &shape.geometry {
        GeometryDescription::Triangles { positions, indices, normals, .. } => {
            let fits = normals.as_ref().is_none_or(|normals| normals.len() == positions.len())
                && indices.iter().flatten().all(|&i| (i as usize) < positions.len());
            if !fits {
                return Some(Err(invalid("a triangle has a vertex that does not exist".to_owned())));
            }
            PolygonList { positions: positions.clone(), normals: normals.clone(), triangles: indices.clone() }
        }
        GeometryDescription::Polyhedron { .. } => match shape_surface(shape.geometry.clone(), None) {
            Ok(Surface::Polyhedron(polyhedron)) => {
                let fans = polyhedron.facets().iter().flat_map(|facet| {
                    let corners: Vec<u32> = facet.corners().iter().map(|&i| i as u32).collect();
                    let first = corners.first().copied().unwrap_or(0);
                    let others = corners.windows(2).skip(1).map(move |pair| [first, pair[0], pair[1]]);
                    others.collect::<Vec<_>>()
                });
                PolygonList {
                    triangles: fans.collect(),
                    positions: polyhedron.vertices().to_vec(),
                    normals: None,
                }
            }
            Ok(_) => return None,
            Err(error) => return Some(Err(invalid(error.to_string()))),
        },
        _ => return None,
    };
    Some(match Transform::try_from_matrix(shape.to_parent) {
        Ok(to_parent) => Ok(placed(list, &to_parent, shape.reverse_orientation)),
        Err(error) => Err(invalid(error.to_string())),
    })
}

/// The polygons in the frame of the group, counterclockwise on their front.
fn placed(list: PolygonList, to_parent: &Transform, reversed: bool) -> PolygonList {
    let mirrored = to_parent.forward().matrix3.determinant() < 0.0;
    let sign = if reversed { -1.0 } else { 1.0 };
    let positions: Vec<DVec3> = list.positions.into_iter().map(|p| to_parent.point(p)).collect();
    let normals: Option<Vec<DVec3>> = list.normals.map(|normals| {
        normals.into_iter().map(|normal| sign * to_parent.normal(normal).normalize_or_zero()).collect()
    });
    let at = |i: u32| positions.get(i as usize).copied().unwrap_or(DVec3::NAN);
    let triangles = list.triangles.into_iter().map(|[a, b, c]| {
        let flat = (at(b) - at(a)).cross(at(c) - at(a));
        let turned = match &normals {
            // Vertex normals, where given, determine the front.
            Some(normals) => {
                let sum: DVec3 = [a, b, c].iter().filter_map(|&i| normals.get(i as usize)).copied().sum();
                flat.dot(sum) < 0.0
            }
            None => mirrored != reversed,
        };
        if turned { [a, c, b] } else { [a, b, c] }
    });
    let triangles = triangles.collect();
    PolygonList { positions, normals, triangles }
}

/// Adds polygons as the mesh of a shape.
pub(super) fn add_polygons(mesh: &mut GroupMesh, number: usize, list: PolygonList) {
    let Some(shape) = mesh.shapes.get_mut(number) else { return };
    let base = mesh.positions.len() as u32;
    let at = |i: u32| list.positions.get(i as usize).copied().unwrap_or(DVec3::NAN);
    if let Some(normals) = &list.normals {
        shape.vertices = normals
            .iter()
            .enumerate()
            .map(|(i, &normal)| MeshVertex { position: base + i as u32, normal })
            .collect();
        shape.triangles = list.triangles;
    } else {
        for corners in list.triangles {
            let [a, b, c] = corners.map(at);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let first = shape.vertices.len() as u32;
            shape.vertices.extend(corners.map(|i| MeshVertex { position: base + i, normal }));
            shape.triangles.push([first, first + 1, first + 2]);
        }
    }
    mesh.positions.extend(list.positions);
}
