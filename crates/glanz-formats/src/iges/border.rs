//! The border of a surface as the boundary of a face.

use glanz_brep::model::{Curve, FaceBound, FaceSurface, SplineCurve};
use glanz_geometry::spline::{NurbsCurve, ParameterDirection};
use glanz_math::DVec3;
use glanz_math::glam::DQuat;

use super::boundary::BoundarySegment;
use super::curves::part;
use super::entity::IgesEntity;
use super::lowering::IgesReader;
use super::surfaces::SurfaceLink;
use crate::cad::Refusal;

/// The sides of a rectangle of parameters: those of the lowest and the highest v, along u, and those of the lowest and the highest u, along v.
type BorderSides = [Curve<DVec3>; 4];

impl IgesReader<'_> {
    /// The bounds of a face that is the whole of a surface, which may be closed: none, one or two.
    pub(super) fn border(
        &mut self,
        entity: IgesEntity<'_>,
        link: &SurfaceLink,
    ) -> Result<Vec<FaceBound>, Refusal> {
        let surface = self.model.surfaces.get(link.index).map(|entry| &entry.surface);
        let sides = match (surface, link.ranges) {
            (Some(FaceSurface::Sphere { .. } | FaceSurface::Torus { .. }), _) => return Ok(Vec::new()),
            (Some(surface), Some(ranges)) => sides(surface, ranges),
            _ => None,
        };
        let Some([bottom, top, left, right]) = sides else {
            return Err(entity.refuse("the surface has no border"));
        };
        let tolerance = self.model.uncertainty;
        let (closed_u, closed_v) = (is_same(&left, &right, tolerance), is_same(&bottom, &top, tolerance));
        let segment =
            |curve, reversed| BoundarySegment { curve, reversed, parameter_curve: None, entity: entity.id() };
        let loops = match (closed_u, closed_v) {
            (true, true) => Vec::new(),
            (true, false) => vec![vec![segment(bottom, false)], vec![segment(top, true)]],
            (false, true) => vec![vec![segment(right, false)], vec![segment(left, true)]],
            (false, false) => vec![vec![
                segment(bottom, false),
                segment(right, false),
                segment(top, true),
                segment(left, true),
            ]],
        };
        let mut bounds = Vec::new();
        for segments in loops {
            // A side that is a pole bounds nothing.
            if segments.iter().any(|segment| !segment.is_point(tolerance)) {
                bounds.push(self.bound(entity, link.index, segments, link.reversed, true)?);
            }
        }
        Ok(bounds)
    }
}

/// The sides of a surface of a kind that has parameters in the standard.
fn sides(surface: &FaceSurface, [[u0, u1], [v0, v1]]: [[f64; 2]; 2]) -> Option<BorderSides> {
    match surface {
        FaceSurface::Extrusion { curve, direction } => {
            let moved = |v: f64| curve.mapped(|p| p, *direction * v);
            let ruling =
                |u: f64| part(Curve::Line { origin: curve.point(u), direction: *direction }, [v0, v1]);
            Some([moved(v0)?, moved(v1)?, ruling(u0), ruling(u1)])
        }
        FaceSurface::Revolution { curve, origin, axis } => {
            let turned = |angle: f64| {
                let rotation = DQuat::from_axis_angle(*axis, angle);
                curve.mapped(|v| rotation * v, *origin - rotation * *origin)
            };
            let circle = |v: f64| {
                let point = curve.point(v);
                let center = *origin + *axis * (point - *origin).dot(*axis);
                let a = point - center;
                let ellipse = Curve::Ellipse { center, a, b: axis.cross(a) };
                if a.length() > 0.0 { part(ellipse, [u0, u1]) } else { Curve::Polyline(vec![center; 2]) }
            };
            Some([circle(v0), circle(v1), turned(u0)?, turned(u1)?])
        }
        FaceSurface::Spline(surface) => {
            let side = |fixed, value: f64, range| {
                let curve: NurbsCurve = surface.isocurve(fixed, value).ok()?;
                let points = curve.control_points().to_vec();
                let spline = SplineCurve::<DVec3>::from_knots(curve.knots().clone(), points).ok()?;
                Some(Curve::Spline(spline.restrict(range).ok()?))
            };
            let (u, v) = (ParameterDirection::U, ParameterDirection::V);
            Some([
                side(v, v0, [u0, u1])?,
                side(v, v1, [u0, u1])?,
                side(u, u0, [v0, v1])?,
                side(u, u1, [v0, v1])?,
            ])
        }
        _ => None,
    }
}

/// Whether two curves with the same parameters coincide.
fn is_same(a: &Curve<DVec3>, b: &Curve<DVec3>, tolerance: f64) -> bool {
    let ([a0, a1], [b0, b1]) = (a.domain(), b.domain());
    (0..=16)
        .map(|i| f64::from(i) / 16.0)
        .all(|s| a.point(a0 + (a1 - a0) * s).distance(b.point(b0 + (b1 - b0) * s)) <= tolerance)
}
