//! Freeform surfaces and trimming from their descriptions.

use std::sync::Arc;

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_geometry::spline::NurbsSurface;
use glanz_geometry::trim::{RegionSettings, TrimCurve, TrimRegion};
use glanz_geometry::{Surface, SurfaceError};
use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use crate::description::{
    BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription, TrimCurveDescription,
    TrimDescription,
};

fn homogeneous(points: Vec<[f64; 4]>) -> Vec<DVec4> {
    points.into_iter().map(DVec4::from_array).collect()
}

/// The part of a surface that a region keeps, or all of it.
fn freeform(patches: Vec<SurfacePatch>, region: Option<&Arc<TrimRegion>>) -> Result<Surface, SurfaceError> {
    let surface = match region {
        Some(region) => Freeform::try_trimmed(patches, Arc::clone(region)),
        None => Freeform::try_new(patches),
    };
    Ok(surface?.into())
}

pub(super) fn nurbs(
    description: NurbsDescription,
    region: Option<&Arc<TrimRegion>>,
) -> Result<Surface, SurfaceError> {
    let NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain } = description;
    let mut surface = NurbsSurface::try_new([degree_u, degree_v], [knots_u, knots_v], homogeneous(points))?;
    if let Some(domain) = domain {
        surface = surface.restrict(domain)?;
    }
    freeform(surface.surface_patches()?, region)
}

pub(super) fn patches(
    description: BezierPatchesDescription,
    region: Option<&Arc<TrimRegion>>,
) -> Result<Surface, SurfaceError> {
    let BezierPatchesDescription { degree_u, degree_v, patches } = description;
    let pieces = patches.into_iter().map(|points| {
        let patch = TensorPatch::try_new(degree_u, degree_v, homogeneous(points))?;
        SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0])
    });
    freeform(pieces.collect::<Result<_, _>>()?, region)
}

pub(super) fn triangles(
    description: BezierTrianglesDescription,
    region: Option<&Arc<TrimRegion>>,
) -> Result<Surface, SurfaceError> {
    let mut pieces = Vec::new();
    for points in description.patches {
        let triangle = TrianglePatch::try_new(description.degree, homogeneous(points))?;
        for quad in triangle.to_quads() {
            pieces.push(SurfacePatch::over_quad(quad.patch, quad.corners)?);
        }
    }
    freeform(pieces, region)
}

/// The region of the parameters that `trim` keeps.
pub(crate) fn region(trim: TrimDescription) -> Result<Arc<TrimRegion>, SurfaceError> {
    let curve = |curve: TrimCurveDescription| {
        let points: Vec<DVec3> = curve.points.into_iter().map(DVec3::from_array).collect();
        let made = TrimCurve::try_nurbs(curve.degree, &curve.knots, &points)?;
        curve.width.map_or(Ok(made.clone()), |width| made.with_width(width))
    };
    let loops = trim.loops.into_iter().map(|l| l.curves.into_iter().map(curve).collect());
    let domain = trim.domain.map(|corners| corners.map(DVec2::from_array));
    let settings = RegionSettings { scale: trim.scale.into(), domain };
    TrimRegion::try_with_settings(loops.collect::<Result<_, _>>()?, settings).map(Arc::new)
}
