//! Freeform surfaces and trimming from their descriptions.

use std::sync::Arc;

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_geometry::spline::NurbsSurface;
use glanz_geometry::trim::{TrimCurve, TrimRegion};
use glanz_geometry::{Surface, SurfaceError};
use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use crate::description::{
    BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription, TrimCurveDescription,
    TrimDescription,
};

fn homogeneous(points: Vec<[f64; 4]>) -> Vec<DVec4> {
    points.into_iter().map(DVec4::from_array).collect()
}

pub(super) fn nurbs(description: NurbsDescription) -> Result<Surface, SurfaceError> {
    let NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain } = description;
    let mut surface = NurbsSurface::try_new([degree_u, degree_v], [knots_u, knots_v], homogeneous(points))?;
    if let Some(domain) = domain {
        surface = surface.restrict(domain)?;
    }
    Ok(surface.to_freeform()?.into())
}

pub(super) fn patches(description: BezierPatchesDescription) -> Result<Surface, SurfaceError> {
    let BezierPatchesDescription { degree_u, degree_v, patches } = description;
    let pieces = patches.into_iter().map(|points| {
        let patch = TensorPatch::try_new(degree_u, degree_v, homogeneous(points))?;
        SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0])
    });
    Ok(Freeform::try_new(pieces.collect::<Result<_, _>>()?)?.into())
}

pub(super) fn triangles(description: BezierTrianglesDescription) -> Result<Surface, SurfaceError> {
    let mut pieces = Vec::new();
    for points in description.patches {
        let triangle = TrianglePatch::try_new(description.degree, homogeneous(points))?;
        for quad in triangle.to_quads() {
            pieces.push(SurfacePatch::over_quad(quad.patch, quad.corners)?);
        }
    }
    Ok(Freeform::try_new(pieces)?.into())
}

/// The region of the parameters that `trim` keeps.
pub(super) fn region(trim: TrimDescription) -> Result<Arc<TrimRegion>, SurfaceError> {
    let curve = |curve: TrimCurveDescription| {
        let points: Vec<DVec3> = curve.points.into_iter().map(DVec3::from_array).collect();
        TrimCurve::try_nurbs(curve.degree, &curve.knots, &points)
    };
    let loops = trim.loops.into_iter().map(|l| l.curves.into_iter().map(curve).collect());
    TrimRegion::try_from_curves(loops.collect::<Result<_, _>>()?).map(Arc::new)
}
