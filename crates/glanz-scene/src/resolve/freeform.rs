//! Freeform surfaces and trimming from their descriptions.

use std::sync::Arc;

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, Piece};
use glanz_geometry::spline::NurbsSurface;
use glanz_geometry::trim::{TrimCurve, TrimError, TrimLoop, TrimRegion};
use glanz_geometry::{Surface, SurfaceError};
use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use crate::description::{
    BezierPatchesDescription, BezierTrianglesDescription, NurbsDescription, TrimDescription,
};

/// Gap between the ends of two curves of a loop that is closed without a word, relative to the loops' extent: what is
/// left of numbers that were written with seven digits.
const TRIM_GAP: f64 = 1e-6;

/// What is kept beyond a trimming curve, relative to the loops' extent: so much may the parameters of one point differ in the two
/// faces that meet in the curve.
const TRIM_BORDER: f64 = 1e-9;

fn homogeneous(points: Vec<[f64; 4]>) -> Vec<DVec4> {
    points.into_iter().map(DVec4::from_array).collect()
}

pub(super) fn nurbs(description: NurbsDescription) -> Result<Surface, SurfaceError> {
    let NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain } = description;
    let mut surface = NurbsSurface::try_new(degree_u, degree_v, knots_u, knots_v, homogeneous(points))?;
    if let Some(domain) = domain {
        surface = surface.restrict(domain)?;
    }
    let pieces = surface.bezier_patches()?.into_iter().map(|p| Piece::over_rectangle(p.patch, p.u, p.v));
    Ok(Freeform::try_new(pieces.collect::<Result<_, _>>()?)?.into())
}

pub(super) fn patches(description: BezierPatchesDescription) -> Result<Surface, SurfaceError> {
    let BezierPatchesDescription { degree_u, degree_v, patches } = description;
    let pieces = patches.into_iter().map(|points| {
        let patch = TensorPatch::try_new(degree_u, degree_v, homogeneous(points))?;
        Piece::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0])
    });
    Ok(Freeform::try_new(pieces.collect::<Result<_, _>>()?)?.into())
}

pub(super) fn triangles(description: BezierTrianglesDescription) -> Result<Surface, SurfaceError> {
    let mut pieces = Vec::new();
    for points in description.patches {
        let triangle = TrianglePatch::try_new(description.degree, homogeneous(points))?;
        for quad in triangle.to_quads() {
            pieces.push(Piece::over_quad(quad.patch, quad.corners)?);
        }
    }
    Ok(Freeform::try_new(pieces)?.into())
}

/// The part of the parameters that `trim` keeps.
pub(super) fn region(trim: TrimDescription) -> Result<Arc<TrimRegion>, TrimError> {
    // The curves lie in the hull of their points. Beyond a margin around it nothing changes, so that the parameters of
    // any surface, infinite ones too, are judged as those at the margin.
    let points = || trim.loops.iter().flat_map(|l| &l.curves).flat_map(|c| &c.points);
    let places = || points().map(|&[u, v, w]| DVec2::new(u, v) / w);
    let (low, high) = places().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let extent = (high - low).max_element();
    let margin = DVec2::splat(0.1 * extent);
    let mut loops = Vec::new();
    for of_curves in trim.loops {
        let curves = of_curves.curves.into_iter().map(|curve| {
            let points: Vec<DVec3> = curve.points.into_iter().map(DVec3::from_array).collect();
            TrimCurve::try_nurbs(curve.degree, &curve.knots, &points)
        });
        loops.push(TrimLoop::try_new(curves.collect::<Result<_, _>>()?, TRIM_GAP * extent)?);
    }
    let region = TrimRegion::try_new(loops, [low - margin, high + margin])?;
    Ok(Arc::new(region.with_widened_border(TRIM_BORDER * extent)?))
}
