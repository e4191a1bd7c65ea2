//! The border of a surface as the boundary of a face.

use std::f64::consts::TAU;

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
fn sides(surface: &FaceSurface, [u, v]: [[f64; 2]; 2]) -> Option<BorderSides> {
    Some([
        isoline(surface, 1, v[0], u)?,
        isoline(surface, 1, v[1], u)?,
        isoline(surface, 0, u[0], v)?,
        isoline(surface, 0, u[1], v)?,
    ])
}

/// The line along which a parameter (0: u, 1: v) has a value, over an ascending range of the other one, which is its own parameter. `None`
/// beyond the surface, and on kinds of surfaces that have no parameters in the standard.
pub(super) fn isoline(
    surface: &FaceSurface,
    fixed: usize,
    value: f64,
    range: [f64; 2],
) -> Option<Curve<DVec3>> {
    match surface {
        FaceSurface::Extrusion { curve, direction } if fixed == 0 => {
            let origin = contains(curve, [value; 2]).then(|| curve.point(value))?;
            Some(part(Curve::Line { origin, direction: *direction }, range))
        }
        FaceSurface::Extrusion { curve, direction } => {
            whole_or_part(curve.mapped(|p| p, *direction * value)?, range)
        }
        FaceSurface::Revolution { curve, origin, axis } if fixed == 0 => {
            let rotation = DQuat::from_axis_angle(*axis, value);
            whole_or_part(curve.mapped(|v| rotation * v, *origin - rotation * *origin)?, range)
        }
        FaceSurface::Revolution { curve, origin, axis } => {
            let point = contains(curve, [value; 2]).then(|| curve.point(value))?;
            let center = *origin + *axis * (point - *origin).dot(*axis);
            let a = point - center;
            if a.length() <= 0.0 {
                return Some(Curve::Polyline(vec![center; 2]));
            }
            // An ellipse has no part longer than itself.
            let is_turn = range[1] - range[0] <= TAU * (1.0 + f64::EPSILON.sqrt());
            is_turn.then(|| part(Curve::Ellipse { center, a, b: axis.cross(a) }, range))
        }
        FaceSurface::Spline(surface) => {
            let fixed = [ParameterDirection::U, ParameterDirection::V].get(fixed).copied()?;
            let curve: NurbsCurve = surface.isocurve(fixed, value).ok()?;
            let points = curve.control_points().to_vec();
            let spline = SplineCurve::<DVec3>::from_knots(curve.knots().clone(), points).ok()?;
            Some(Curve::Spline(spline.restrict(range).ok()?))
        }
        _ => None,
    }
}

/// Whether a curve has these parameters.
fn contains(curve: &Curve<DVec3>, [from, to]: [f64; 2]) -> bool {
    let [start, end] = curve.domain();
    start <= from && to <= end
}

fn whole_or_part(curve: Curve<DVec3>, range: [f64; 2]) -> Option<Curve<DVec3>> {
    if curve.domain() == range {
        return Some(curve);
    }
    contains(&curve, range).then(|| part(curve, range))
}

/// Whether two curves with the same parameters coincide.
fn is_same(a: &Curve<DVec3>, b: &Curve<DVec3>, tolerance: f64) -> bool {
    let ([a0, a1], [b0, b1]) = (a.domain(), b.domain());
    (0..=16)
        .map(|i| f64::from(i) / 16.0)
        .all(|s| a.point(a0 + (a1 - a0) * s).distance(b.point(b0 + (b1 - b0) * s)) <= tolerance)
}
