//! Surfaces from their descriptions.

use std::sync::Arc;

use glanz_geometry::algebraic::{AlgebraicSurface, PolynomialTerm};
use glanz_geometry::bilinear::BilinearPatch;
use glanz_geometry::cuboid::Cuboid;
use glanz_geometry::curve::FacingCurve;
use glanz_geometry::freeform::Freeform;
use glanz_geometry::mesh::Mesh;
use glanz_geometry::polyhedron::{HalfSpace, Polyhedron};
use glanz_geometry::quadric::{
    Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid,
};
use glanz_geometry::torus::Torus;
use glanz_geometry::trim::TrimRegion;
use glanz_geometry::{Surface, SurfaceError};
use glanz_math::{Bounds3, DVec3, Transform};

use super::{WarningList, freeform, transform};
use crate::description::{GeometryDescription, Location, ShapeDescription};
use crate::error::{SceneError, SceneErrorKind};
use crate::medium::MediumInterface;
use crate::object::{SceneObject, ShapeAttributes};

/// The objects of one shape: one, except for a list of patches.
pub(super) fn objects(
    shape: ShapeDescription,
    id: u32,
    media: MediumInterface,
    warnings: &mut WarningList,
) -> Result<Vec<SceneObject>, SceneError> {
    let location = shape.location;
    let to_parent = transform(shape.to_parent, "shape", location)?;
    let attributes = ShapeAttributes {
        id,
        material: shape.material as u32,
        media,
        reversed: shape.reverse_orientation,
        has_detail: false,
    };
    let at = |error: SurfaceError| SceneError { location, kind: SceneErrorKind::Surface(error) };
    let trim_error = |error| SceneError { location, kind: SceneErrorKind::Trim(error) };
    let region = shape.trim.map(freeform::region).transpose().map_err(trim_error)?;
    let trimmed = |surface: Surface| match &region {
        // Freeform surfaces are built without the rest.
        Some(region) if surface.trim_region().is_none() => surface.trimmed(Arc::clone(region)),
        _ => surface,
    };
    let placed = |surface: Surface| vec![SceneObject::new(trimmed(surface), to_parent, attributes)];
    let in_parent = |surface: Surface, flipped: bool| {
        SceneObject::new(
            trimmed(surface),
            Transform::IDENTITY,
            ShapeAttributes { reversed: attributes.reversed != flipped, ..attributes },
        )
    };
    Ok(match shape.geometry {
        // Meshes and patches are transformed to the frame of the group, so that rays need not be.
        GeometryDescription::Triangles { positions, indices, normals, uvs } => {
            // Vertex normals, where given, determine the front side of the triangles.
            let flipped = normals.is_none() && mirrors(&to_parent);
            let positions = positions.into_iter().map(|p| to_parent.point(p)).collect();
            let normals = normals.map(|n| n.into_iter().map(|n| to_parent.normal(n)).collect());
            match Mesh::try_new(positions, indices, normals, uvs) {
                Ok(mesh) => {
                    note_degenerate(mesh.degenerate(), location, warnings);
                    vec![in_parent(Surface::Mesh(Arc::new(mesh)), flipped)]
                }
                // Exporters write such meshes, for instance at the poles of a teapot: they are not an error.
                Err(SurfaceError::Degenerate { .. }) => {
                    warnings.warn(location, "no triangle of this mesh has an area; the mesh is left out");
                    Vec::new()
                }
                Err(error) => return Err(at(error)),
            }
        }
        GeometryDescription::Bilinear { positions, indices } => {
            bilinear_patches(&positions, &indices, &to_parent)
                .map(|patch| patch.map(|p| in_parent(p.into(), mirrors(&to_parent))))
                .collect::<Result<_, _>>()
                .map_err(at)?
        }
        other => {
            let quads =
                if matches!(other, GeometryDescription::BezierTriangles(_)) { QUADS_PER_TRIANGLE } else { 1 };
            let surface = surface(other, region.as_ref()).map_err(at)?;
            if let Surface::Freeform(freeform) = &surface {
                note_patches_without_area(freeform, quads, location, warnings);
            }
            placed(surface)
        }
    })
}

/// Least number of bytes that the objects of a shape will have, as far as it is known before they are built.
pub(super) fn least_bytes(geometry: &GeometryDescription) -> u64 {
    let bytes = match geometry {
        GeometryDescription::Triangles { positions, indices, .. } => {
            positions.len() * LEAST_PER_VERTEX + indices.len() * LEAST_PER_TRIANGLE
        }
        GeometryDescription::Bilinear { indices, .. } => indices.len() * size_of::<SceneObject>(),
        _ => 0,
    };
    bytes as u64
}

/// Bytes of the coordinates of a vertex of a mesh: three single numbers.
const LEAST_PER_VERTEX: usize = 12;

/// Bytes of a triangle of a mesh: the numbers of its vertices, and their coordinates once more.
const LEAST_PER_TRIANGLE: usize = 48;

fn mirrors(to_parent: &Transform) -> bool {
    to_parent.forward().matrix3.determinant() < 0.0
}

fn note_degenerate(dropped: usize, location: Option<Location>, warnings: &mut WarningList) {
    if dropped > 0 {
        let (noun, omitted) =
            if dropped == 1 { ("triangle has", "it is") } else { ("triangles have", "they are") };
        warnings.warn(location, format!("{dropped} {noun} no area; {omitted} left out"));
    }
}

/// Number of quadrilateral patches of a triangular one.
const QUADS_PER_TRIANGLE: usize = 3;

/// `quads`: the number of patches of the surface that are one of the description.
fn note_patches_without_area(
    freeform: &Freeform,
    quads: usize,
    location: Option<Location>,
    warnings: &mut WarningList,
) {
    let mut numbers: Vec<usize> =
        freeform.patches_without_area().iter().map(|&face| face as usize / quads).collect();
    numbers.dedup();
    if !numbers.is_empty() {
        let (count, all) = (numbers.len(), freeform.patch_count() / quads);
        let verb = if count == 1 { "has" } else { "have" };
        let message = format!("{count} of {all} patches {verb} parts without area, which no ray meets");
        warnings.warn(location, message);
    }
}

fn bilinear_patches<'a>(
    positions: &'a [DVec3],
    indices: &'a [[u32; 4]],
    to_parent: &'a Transform,
) -> impl Iterator<Item = Result<BilinearPatch, SurfaceError>> + 'a {
    indices.iter().enumerate().map(move |(patch, corners)| {
        let mut points = [DVec3::ZERO; 4];
        for (point, &index) in points.iter_mut().zip(corners) {
            let position = positions.get(index as usize).ok_or(SurfaceError::BadIndex {
                parameter: "corner of patch",
                position: patch,
                index: u64::from(index),
                count: positions.len(),
            })?;
            *point = to_parent.point(*position);
        }
        let [p00, p10, p01, p11] = points;
        BilinearPatch::try_new(p00, p10, p01, p11)
    })
}

/// The surface in its own frame. `region`: the part that is kept, if it is a freeform surface; others are trimmed afterwards.
pub(crate) fn surface(
    geometry: GeometryDescription,
    region: Option<&Arc<TrimRegion>>,
) -> Result<Surface, SurfaceError> {
    Ok(match geometry {
        GeometryDescription::Sphere { radius, z, phi_max } => Sphere::try_new(radius, z, phi_max)?.into(),
        GeometryDescription::Cylinder { radius, z, phi_max } => Cylinder::try_new(radius, z, phi_max)?.into(),
        GeometryDescription::Cone { radius, height, phi_max } => {
            Cone::try_new(radius, height, phi_max)?.into()
        }
        GeometryDescription::Paraboloid { radius, z, phi_max } => {
            Paraboloid::try_new(radius, z, phi_max)?.into()
        }
        GeometryDescription::Hyperboloid { p1, p2, phi_max } => Hyperboloid::try_new(p1, p2, phi_max)?.into(),
        GeometryDescription::TwoSheetedHyperboloid { a, c, z, phi_max } => {
            TwoSheetedHyperboloid::try_new(a, c, z, phi_max)?.into()
        }
        GeometryDescription::Disk { height, radius, inner_radius, phi_max } => {
            Disk::try_new(height, radius, inner_radius, phi_max)?.into()
        }
        GeometryDescription::Plane { x, y } => Plane::try_new(x, y)?.into(),
        GeometryDescription::Algebraic { terms, clip: [a, b] } => {
            let terms: Vec<PolynomialTerm> = terms
                .into_iter()
                .map(|(exponents, coefficient)| PolynomialTerm {
                    exponents: exponents.map(u32::from),
                    coefficient,
                })
                .collect();
            AlgebraicSurface::try_new(&terms, Bounds3::new(a, b))?.into()
        }
        GeometryDescription::Torus { major_radius, minor_radius, phi_max } => {
            Torus::try_new(major_radius, minor_radius, phi_max)?.into()
        }
        GeometryDescription::Polyhedron { half_spaces } => {
            let half_spaces: Vec<HalfSpace> =
                half_spaces.into_iter().map(|(normal, distance)| HalfSpace { normal, distance }).collect();
            Polyhedron::try_new(&half_spaces)?.into()
        }
        GeometryDescription::Cuboid { min, max } => Cuboid::try_new(min, max)?.into(),
        GeometryDescription::Triangles { positions, indices, normals, uvs } => {
            Surface::Mesh(Arc::new(Mesh::try_new(positions, indices, normals, uvs)?))
        }
        GeometryDescription::Bilinear { positions, indices } => {
            let identity = Transform::IDENTITY;
            let first = bilinear_patches(&positions, &indices, &identity).next();
            first.unwrap_or(Err(SurfaceError::TooFew { parameter: "patches", count: 0, min: 1 }))?.into()
        }
        GeometryDescription::Nurbs(description) => freeform::nurbs(description, region)?,
        GeometryDescription::BezierPatches(description) => freeform::patches(description, region)?,
        GeometryDescription::BezierTriangles(description) => freeform::triangles(description, region)?,
        GeometryDescription::Curve { points, widths, shading } => {
            FacingCurve::try_new(&points, widths, shading)?.into()
        }
    })
}
