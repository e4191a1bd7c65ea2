//! From faces and edges to trimmed surfaces.

use glanz_math::{Bounds3, DMat4, DVec2, DVec3};
use rayon::prelude::*;

use super::border::{border, border_extent, ranges};
use super::edges::{EdgeNormals, polylines};
use super::geometry::{FaceGeometry, metric, placed};
use super::outcome::{FaceRefusal, FaceRepair};
use crate::boundary::{
    BoundaryChain, BoundaryCurve, BoundaryError, BoundaryRepair, ParameterSpace, chain, close,
};
use crate::carrier::{Carrier, CarrierConversion};
use crate::curve::{EdgeCurve, EdgePolyline};
use crate::error::BrepError;
use crate::model::{
    BoundaryLoop, BrepModel, CurveVector, Edge, EntityId, Face, FaceSurface, OrientedEdge, Placement,
};
use crate::parameter_curve::{EdgeParameterCurve, ParameterCurveSource, edge_on_carrier};

/// A face as a trimmed surface in the frame of its part.
#[derive(Clone, Debug)]
pub struct TrimmedFace {
    /// The surface in its own frame.
    pub geometry: FaceGeometry,
    /// From its own frame to that of the part.
    pub to_part: DMat4,
    /// Whether the normal of the face is opposite to that of the surface.
    pub reversed: bool,
    /// The part of the surface that is the face; `None`: all of it.
    pub trim: Option<FaceTrim>,
    /// Largest distance by which the face extends beyond an edge, metres.
    pub width: f64,
    /// Repairs that were necessary.
    pub repairs: Vec<FaceRepair>,
    /// Its normals along the edges of its loops, twice along a seam; empty unless made by [`trimmed_faces_with_edges`].
    pub edge_normals: Vec<EdgeNormals>,
}

/// The boundary of a face in parameters of its surface.
#[derive(Clone, Debug)]
pub struct FaceTrim {
    /// Closed loops, the face on their left; widths of curves are metres, after the scale.
    pub loops: Vec<Vec<BoundaryCurve>>,
    /// Metres per unit of each parameter.
    pub scale: DVec2,
    /// The parameters within which the boundary is complete: the ranges of u and v.
    pub domain: [[f64; 2]; 2],
}

/// The faces of a model, by their indices, with the widths of their edges.
#[derive(Clone, Debug)]
pub struct TrimmedFaces {
    /// The faces.
    pub faces: Vec<Result<TrimmedFace, FaceRefusal>>,
    /// Per edge: the sum of the distances by which the faces beside it stray from it, metres; 0 where no face has it.
    pub widths: Vec<f64>,
    /// Of [`trimmed_faces_with_edges`]: points along the edges, `None` for those without a curve.
    pub edges: Option<Vec<Option<EdgePolyline>>>,
}

/// Part of the size of a face up to which the uncertainty of the file counts.
const COINCIDENT: f64 = 1e-3;

/// Part of the size of a face up to which gaps in its boundary are bridged.
const BRIDGED: f64 = 0.02;

/// Multiple of the distance by which two faces stray from their edge by which they extend beyond it. Surfaces that meet smoothly lie up
/// to that distance above one another: rays at angles of less than the inverse of this pass between them.
const OVERLAP: f64 = 8.0;

/// Part of the size of a face up to which its edges may be off its surface.
const STRAYING: f64 = 0.05;

/// Width of the overlap at edges that lie exactly on both surfaces, relative to the size of the face: the rounding of parameters.
const ROUNDING: f64 = 1e-11;

/// Distance below which points coincide, relative to the size of the face, however small an uncertainty the file states: it gives ten
/// digits or so.
const RESOLUTION: f64 = 1e-9;

/// Accuracy of curves on surfaces, relative to the size of the face: many files state uncertainties that would change areas.
const ACCURACY: f64 = 1e-7;

/// Largest ratio by which the width of a curve grows where parameters are dense, as near a pole.
const MAX_STRETCH: f64 = 1e3;

/// The trimmed faces of a model. They do not depend on the number of threads.
#[must_use]
pub fn trimmed_faces(model: &BrepModel) -> TrimmedFaces {
    trimmed(model, false)
}

/// The same, with points along the edges and the normals of the faces there.
#[must_use]
pub fn trimmed_faces_with_edges(model: &BrepModel) -> TrimmedFaces {
    trimmed(model, true)
}

fn trimmed(model: &BrepModel, with_edges: bool) -> TrimmedFaces {
    let edges: Vec<BoundedEdge> = model.edges.par_iter().map(|edge| BoundedEdge::new(model, edge)).collect();
    let laid: Vec<Result<LaidFace, FaceRefusal>> =
        model.faces.par_iter().map(|face| LaidFace::try_new(model, &edges, face, with_edges)).collect();
    let mut widths = vec![0.0; model.edges.len()];
    for &(edge, deviation) in laid.iter().flatten().flat_map(|face| &face.deviations) {
        widths[edge] += deviation;
    }
    let faces = laid.into_par_iter().map(|face| face?.close(model, &widths)).collect();
    let edges = with_edges.then(|| polylines(model, &edges));
    TrimmedFaces { faces, widths, edges }
}

/// An edge with a box around it.
pub(super) struct BoundedEdge {
    pub(super) curve: Result<EdgeCurve, BrepError>,
    /// Around its control points; around its vertices where there is no curve.
    pub(super) bounds: Bounds3,
}

impl BoundedEdge {
    fn new(model: &BrepModel, edge: &Edge) -> Self {
        let curve = EdgeCurve::try_new(edge, &model.vertices, model.uncertainty);
        let spline = curve.as_ref().ok().and_then(|curve| curve.to_spline().ok());
        let vertices =
            [edge.start, edge.end].into_iter().filter_map(|vertex| model.vertices.get(vertex).copied());
        let bounds = match spline {
            Some(spline) => {
                Bounds3::from_points(spline.control_points().iter().map(|&point| DVec3::project(point)))
            }
            None => Bounds3::from_points(vertices),
        };
        Self { curve, bounds }
    }
}

/// A face whose edges lie on its carrier.
struct LaidFace {
    carrier: Carrier,
    reversed: bool,
    metric: DVec2,
    /// Edges in the order and sense of each loop, the face on their left, in region coordinates.
    loops: Vec<Vec<BoundaryCurve>>,
    /// The edges of the loops and the distances by which the curves stray from them.
    deviations: Vec<(usize, f64)>,
    /// The numbers of the loops in the file.
    bounds: Vec<EntityId>,
    size: f64,
    /// Distance below which points coincide, metres.
    tolerance: f64,
    /// Distance up to which curves on the surface may stray from edges if they can be closer, metres.
    accuracy: f64,
    repairs: Vec<FaceRepair>,
    /// `None` unless they are needed.
    normals: Option<Vec<EdgeNormals>>,
}

impl LaidFace {
    fn try_new(
        model: &BrepModel,
        edges: &[BoundedEdge],
        face: &Face,
        with_normals: bool,
    ) -> Result<Self, FaceRefusal> {
        let entry = model.surfaces.get(face.surface).ok_or(FaceRefusal::Dangling)?;
        let extent = extent(model, edges, face)?;
        let size = (extent.max - extent.min).length();
        let size = if size.is_finite() { size } else { 0.0 };
        // Points further apart than a part of the face are different points, whatever the file says.
        let limit = if size > 0.0 { COINCIDENT * size } else { f64::INFINITY };
        let tolerance = model.uncertainty.min(limit).max(RESOLUTION * size);
        let mut repairs = Vec::new();
        let (surface, same_sense) = match plane_of_polygons(&entry.surface, face, size, tolerance) {
            Some((plane, distance)) => {
                repairs.push(FaceRepair::PolygonPlane { distance });
                (FaceSurface::Plane(plane), true)
            }
            None => (part_with_edges(&entry.surface, model, edges, face), face.same_sense),
        };
        let refused = |error| FaceRefusal::Surface { entity: entry.entity, error };
        let has_border = ends_at_border(&surface, face);
        let extent =
            if has_border { border_extent(&surface, extent, tolerance).map_err(refused)? } else { extent };
        let size = if has_border { (extent.max - extent.min).length() } else { size };
        let conversion = Carrier::try_from_surface(&surface, extent, tolerance).map_err(refused)?;
        let reach = reach(&conversion.carrier, extent);
        let mut laid = Self {
            metric: metric(&conversion.carrier, reach),
            reversed: same_sense == conversion.reversed,
            carrier: conversion.carrier.clone(),
            loops: Vec::with_capacity(face.bounds.len()),
            deviations: Vec::new(),
            bounds: Vec::with_capacity(face.bounds.len()),
            size,
            tolerance,
            accuracy: tolerance.min(ACCURACY * size),
            repairs,
            normals: with_normals.then(Vec::new),
        };
        if conversion.deviation > ROUNDING * size {
            laid.repairs.push(FaceRepair::FittedSurface { deviation: conversion.deviation });
        }
        if has_border {
            let ranges = ranges(&surface, &conversion).map_err(refused)?;
            for curves in border(&laid.carrier, ranges) {
                laid.loops.push(curves.into_iter().map(|curve| curve.scaled(laid.metric)).collect());
                laid.bounds.push(face.entity);
            }
        }
        for bound in &face.bounds {
            let mut curves = match &bound.boundary {
                BoundaryLoop::Edges(oriented) => {
                    laid.edges(model, edges, face.surface, &conversion, oriented)?
                }
                BoundaryLoop::Polygon(corners) => laid.polygon(corners, bound.entity)?,
                BoundaryLoop::Vertex(vertex) => {
                    laid.vertex(*model.vertices.get(*vertex).ok_or(FaceRefusal::Dangling)?, bound.entity);
                    continue;
                }
                BoundaryLoop::Border => continue,
            };
            if laid.reversed {
                curves = curves.into_iter().rev().map(BoundaryCurve::reversed).collect();
            }
            laid.loops.push(curves);
            laid.bounds.push(bound.entity);
        }
        Ok(laid)
    }

    /// The curves of a loop of edges.
    fn edges(
        &mut self,
        model: &BrepModel,
        edges: &[BoundedEdge],
        surface: usize,
        conversion: &CarrierConversion,
        oriented: &[OrientedEdge],
    ) -> Result<Vec<BoundaryCurve>, FaceRefusal> {
        let mut curves = Vec::with_capacity(oriented.len());
        for &OrientedEdge { edge: number, forward } in oriented {
            let (Some(edge), Some(curve)) = (model.edges.get(number), edges.get(number)) else {
                return Err(FaceRefusal::Dangling);
            };
            let refused = |error: BrepError| FaceRefusal::Edge { entity: edge.entity, error };
            let curve = curve.curve.as_ref().map_err(|error| refused(error.clone()))?;
            let given = edge.parameter_curves.iter().find(|given| given.surface == surface);
            let on_carrier =
                edge_on_carrier(conversion, curve, given.map(|given| &given.curve), self.accuracy);
            let parts = on_carrier.map_err(refused)?;
            let deviation = parts.iter().map(|part| part.deviation).fold(0.0, f64::max);
            if deviation.is_nan() || deviation > STRAYING * self.size {
                return Err(FaceRefusal::StrayingEdge { edge: edge.entity, distance: deviation });
            }
            if deviation > self.tolerance {
                self.repairs.push(FaceRepair::StrayingEdge { edge: edge.entity, distance: deviation });
            } else if given.is_some() && parts.iter().any(|part| part.source == ParameterCurveSource::Fitted)
            {
                self.repairs.push(FaceRepair::ParameterCurve(edge.entity));
            }
            self.deviations.push((number, deviation));
            if let Some(normals) = &mut self.normals {
                normals.push(EdgeNormals::new(number, (&self.carrier, self.reversed), curve, &parts));
            }
            let ranges = part_ranges(&self.carrier, curve, &parts);
            let laid = parts.iter().zip(ranges).map(|(part, range)| {
                BoundaryCurve::from_spline(&part.curve, number, range).scaled(self.metric)
            });
            if forward {
                curves.extend(laid);
            } else {
                curves.extend(laid.rev().map(BoundaryCurve::reversed));
            }
        }
        Ok(curves)
    }

    /// Straight sides between points.
    fn polygon(&mut self, corners: &[DVec3], bound: EntityId) -> Result<Vec<BoundaryCurve>, FaceRefusal> {
        let mut near = None;
        let mut strays: f64 = 0.0;
        let mut points: Vec<DVec2> = Vec::with_capacity(corners.len() + 1);
        for &corner in corners.iter().chain(corners.first()) {
            let projection = self.carrier.parameters(corner, near);
            near = Some(projection.uv);
            strays = strays.max(projection.distance);
            points.push(projection.uv * self.metric);
        }
        if strays.is_nan() || strays > STRAYING * self.size {
            return Err(FaceRefusal::StrayingPolygon { bound, distance: strays });
        }
        if strays > self.tolerance {
            self.repairs.push(FaceRepair::StrayingPolygon { bound, distance: strays });
        }
        points.dedup();
        let side = |pair: &[DVec2]| BoundaryCurve { width: strays, ..BoundaryCurve::line(pair[0], pair[1]) };
        Ok(points.windows(2).map(side).collect())
    }

    /// A loop that is a point: a pole, which bounds nothing, or a mistake.
    fn vertex(&mut self, point: DVec3, bound: EntityId) {
        let at_pole = self.carrier.poles().iter().any(|pole| pole.point.distance(point) <= self.tolerance);
        let closed = matches!(self.carrier, Carrier::Sphere { .. } | Carrier::Torus { .. });
        if !at_pole && !closed {
            self.repairs.push(FaceRepair::VertexLoop(bound));
        }
    }

    /// The trimmed face. `widths`: per edge.
    fn close(mut self, model: &BrepModel, widths: &[f64]) -> Result<TrimmedFace, FaceRefusal> {
        let floor = ROUNDING * self.size;
        let mut largest: f64 = 0.0;
        for curve in self.loops.iter_mut().flatten() {
            let strayed = curve.edge.and_then(|edge| widths.get(edge).copied()).unwrap_or(curve.width);
            let overlap = if strayed <= self.tolerance { OVERLAP * strayed } else { strayed };
            let on_surface = overlap + floor;
            curve.width = (on_surface * stretch(&self.carrier, self.metric, curve)).min(BRIDGED * self.size);
            largest = largest.max(curve.width);
        }
        let point = |at: DVec2| self.carrier.point(at / self.metric);
        let space = self.space(&point);
        let limit = (BRIDGED * self.size).max(self.tolerance);
        let loops = std::mem::take(&mut self.loops);
        if loops.is_empty() && !space.is_closed() {
            self.repairs.push(FaceRepair::MissingBoundary);
        }
        let chains: Result<Vec<BoundaryChain>, BoundaryError> =
            loops.into_iter().map(|curves| chain(curves, &space, self.tolerance, limit)).collect();
        let closed = close(chains?, &space, largest)?;
        let mut repairs = self.repairs;
        repairs.extend(closed.repairs.iter().map(|&repair| match repair {
            BoundaryRepair::BridgedGap { gap } => FaceRepair::BridgedGap { gap },
            BoundaryRepair::ReversedEdge { edge } => FaceRepair::ReversedEdge(model.edges[edge].entity),
            BoundaryRepair::ReversedBoundary => FaceRepair::ReversedBoundary,
            BoundaryRepair::ReversedLoop { number } => FaceRepair::ReversedLoop(self.bounds[number]),
        }));
        let widths = closed.loops.iter().flatten().map(|curve| curve.width);
        let width = widths.fold(0.0, f64::max);
        let geometry = placed(&self.carrier, self.metric, closed.window);
        let trim = (!closed.loops.is_empty()).then(|| FaceTrim {
            loops: closed
                .loops
                .iter()
                .map(|l| l.iter().map(|curve| geometry.curve(curve)).collect())
                .collect(),
            scale: geometry.scale,
            domain: geometry.domain(closed.window),
        });
        let face = TrimmedFace {
            geometry: geometry.geometry,
            to_part: geometry.to_part,
            reversed: self.reversed,
            trim,
            width,
            repairs,
            edge_normals: self.normals.unwrap_or_default(),
        };
        face.check()?;
        Ok(face)
    }

    /// The parameters of the carrier in region coordinates.
    fn space<'a>(&self, point: &'a dyn Fn(DVec2) -> DVec3) -> ParameterSpace<'a> {
        let (domain, mut periods, metric) = (self.carrier.domain(), self.carrier.periods(), self.metric);
        let mut poles = [[false; 2]; 2];
        for pole in self.carrier.poles() {
            let [low, high] = domain[pole.axis];
            poles[pole.axis][usize::from((pole.value - low).abs() > (pole.value - high).abs())] = true;
            // The ends of a spindle or horn torus are one point, but not joined by it.
            periods[pole.axis] = None;
        }
        let analytic = !matches!(self.carrier, Carrier::Spline(_));
        ParameterSpace {
            domain: [0, 1].map(|axis| domain[axis].map(|end| end * metric[axis])),
            periods: [0, 1].map(|axis| periods[axis].map(|period| period * metric[axis])),
            movable: [analytic, false],
            poles,
            point,
        }
    }
}

/// Whether a face ends where its surface does: without edges on a surface with a range, or because it says so.
fn ends_at_border(surface: &FaceSurface, face: &Face) -> bool {
    let has_range = matches!(surface, FaceSurface::Rectangular { .. });
    let says_so = face.bounds.iter().any(|bound| matches!(bound.boundary, BoundaryLoop::Border));
    says_so || has_range && face.bounds.is_empty()
}

/// The plane of a face between polygons that are far from the plane in the file, and how far.
fn plane_of_polygons(
    surface: &FaceSurface,
    face: &Face,
    size: f64,
    tolerance: f64,
) -> Option<(Placement, f64)> {
    let FaceSurface::Plane(given) = *surface else { return None };
    let mut corners: Vec<DVec3> = Vec::new();
    for bound in &face.bounds {
        let BoundaryLoop::Polygon(polygon) = &bound.boundary else { return None };
        corners.extend(polygon);
    }
    let distance = |plane: Placement| corners.iter().map(|&p| plane.to_local(p).z.abs()).fold(0.0, f64::max);
    let off = distance(given);
    if off <= STRAYING * size {
        return None;
    }
    let plane = Placement::of_polygons(&face.bounds)?;
    (distance(plane) <= tolerance).then_some((plane, off))
}

/// Of a torus whose tube meets the axis, the part on which the edges lie: files often give the other one.
fn part_with_edges(
    surface: &FaceSurface,
    model: &BrepModel,
    edges: &[BoundedEdge],
    face: &Face,
) -> FaceSurface {
    let FaceSurface::Torus { placement, major_radius, minor_radius, .. } = *surface else {
        return surface.clone();
    };
    if minor_radius < major_radius {
        return surface.clone();
    }
    let oriented = face.bounds.iter().filter_map(|bound| match &bound.boundary {
        BoundaryLoop::Edges(oriented) => Some(oriented),
        _ => None,
    });
    let curves = oriented.flatten().filter_map(|oriented| edges.get(oriented.edge)?.curve.as_ref().ok());
    let points: Vec<DVec3> = curves.flat_map(|curve| [0.0, 0.5, 1.0].map(|at| curve.point(at))).collect();
    // The outer part is where the distance from the axis grows with that from the tube's circle on the near side.
    let outside = |point: &DVec3| {
        let p = *point - placement.origin;
        let (z, rho) = (p.dot(placement.z), (p - placement.z * p.dot(placement.z)).length());
        let outer = (rho - major_radius).hypot(z) - minor_radius;
        let inner = (rho + major_radius).hypot(z) - minor_radius;
        outer.abs() - inner.abs()
    };
    let balance = points.iter().map(outside).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    match balance {
        Some(balance) if balance.abs() > model.uncertainty => {
            FaceSurface::Torus { placement, major_radius, minor_radius, select_outer: balance < 0.0 }
        }
        _ => surface.clone(),
    }
}

/// The fractions of an edge at which its parts start and end.
fn part_ranges(carrier: &Carrier, edge: &EdgeCurve, parts: &[EdgeParameterCurve]) -> Vec<[f64; 2]> {
    let ends = parts.split_last().map_or(&[][..], |(_, others)| others).iter().map(|part| {
        let end = part.curve.control_points().last().copied().map_or(DVec2::NAN, DVec2::project);
        edge.nearest_fraction(carrier.point(end))
    });
    let cuts: Vec<f64> = [0.0].into_iter().chain(ends).chain([1.0]).collect();
    cuts.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// A box around the edges of a face.
fn extent(model: &BrepModel, edges: &[BoundedEdge], face: &Face) -> Result<Bounds3, FaceRefusal> {
    let mut points: Vec<DVec3> = Vec::new();
    for bound in &face.bounds {
        match &bound.boundary {
            BoundaryLoop::Edges(oriented) => {
                for oriented in oriented {
                    let curve = edges.get(oriented.edge).ok_or(FaceRefusal::Dangling)?;
                    points.extend([curve.bounds.min, curve.bounds.max]);
                }
            }
            BoundaryLoop::Polygon(corners) => points.extend(corners),
            BoundaryLoop::Vertex(vertex) => points.extend(model.vertices.get(*vertex)),
            BoundaryLoop::Border => {}
        }
    }
    Ok(Bounds3::from_points(points))
}

/// The largest distance of a box from the axis of a carrier; the radius at the origin of a cone where the box is empty.
fn reach(carrier: &Carrier, extent: Bounds3) -> f64 {
    let Carrier::Cone { placement, radius, .. } = carrier else { return 1.0 };
    let corners = (0..8).map(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { extent.min[axis] } else { extent.max[axis] };
        DVec3::new(pick(0), pick(1), pick(2)) - placement.origin
    });
    let distance = |p: DVec3| (p - placement.z * p.dot(placement.z)).length();
    let largest = corners.map(distance).fold(0.0, f64::max);
    if largest.is_finite() && largest > 0.0 { largest } else { radius.max(f64::MIN_POSITIVE) }
}

/// How much longer a small distance on the surface may be in region coordinates, at the points of a curve.
fn stretch(carrier: &Carrier, metric: DVec2, curve: &BoundaryCurve) -> f64 {
    /// Between samples the ratio is taken to change by less than this.
    const SAFETY: f64 = 1.25;
    let mut least = f64::INFINITY;
    for at in curve.samples() {
        let [du, dv] = carrier.tangents(at / metric);
        let (du, dv) = (du / metric.x, dv / metric.y);
        // The smallest singular value of the two columns.
        let (e, f, g) = (du.length_squared(), du.dot(dv), dv.length_squared());
        let mean = 0.5 * (e + g);
        let square = mean - ((0.5 * (e - g)).powi(2) + f * f).sqrt();
        least = least.min(square.max(0.0).sqrt());
    }
    if least.is_finite() { (SAFETY / least).clamp(1.0, MAX_STRETCH) } else { 1.0 }
}
