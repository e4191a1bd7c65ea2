//! Faces whose edges lie on their carriers, and their boundaries.

use glanz_math::{DVec2, DVec3};

use super::border::{border, border_extent, ranges};
use super::bounded_edge::{BoundedEdge, extent};
use super::edges::EdgeNormals;
use super::geometry::{metric, placed, reach};
use super::offset_part::offset_part;
use super::outcome::{FaceRefusal, FaceRepair};
use super::stretch::{StretchedCurve, WidenedCurve};
use super::surface::{STRAYING, ends_at_border, plane_of_polygons};
use super::surface_part::part_with_edges;
use super::trim::{FaceTrim, TrimmedFace};
use crate::boundary::{BoundaryChain, BoundaryCurve, BoundaryRepair, ParameterSpace, chain, close};
use crate::carrier::{Carrier, CarrierConversion};
use crate::curve::EdgeCurve;
use crate::error::BrepError;
use crate::model::{BoundaryLoop, BrepModel, CurveVector, EntityId, Face, FaceSurface, OrientedEdge};
use crate::parameter_curve::{EdgeParameterCurve, ParameterCurveSource, edge_on_carrier, largest};

/// Part of the size of a face up to which the uncertainty of the file counts.
const COINCIDENT: f64 = 1e-3;

/// Part of the size of a face up to which gaps in its boundary are bridged.
const BRIDGED: f64 = 0.02;

/// Multiple of the distance by which two faces stray from their edge by which they extend beyond it. Surfaces that meet smoothly lie up
/// to that distance above one another: rays at angles of less than the inverse of this pass between them.
const OVERLAP: f64 = 8.0;

/// The same where faces stray by little: a wide overlap costs nothing up to [`UNSEEN`].
const NARROW_OVERLAP: f64 = 1000.0;

/// Width of an overlap, relative to the size of the face, that no picture shows; with more, edges would get tubes.
const UNSEEN: f64 = 5e-7;

/// Width of the overlap at edges that lie exactly on both surfaces, relative to the size of the face: the rounding of parameters.
const ROUNDING: f64 = 1e-11;

/// Distance below which points coincide, relative to the size of the face, however small an uncertainty the file states: it gives ten
/// digits or so.
const RESOLUTION: f64 = 1e-9;

/// Accuracy of curves on surfaces, relative to the size of the face: many files state uncertainties that would change areas.
const ACCURACY: f64 = 1e-7;

/// A face whose edges lie on its carrier.
pub(super) struct LaidFace {
    carrier: Carrier,
    reversed: bool,
    metric: DVec2,
    /// Edges in the order and sense of each loop, the face on their left, in region coordinates.
    loops: Vec<Vec<BoundaryCurve>>,
    /// The edges of the loops and the distances by which the curves stray from them.
    pub(super) deviations: Vec<(usize, f64)>,
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
    /// The edges of a face on the carrier of its surface.
    pub(super) fn try_new(
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
        let (surface, same_sense) = match plane_of_polygons(&entry.surface, model, face, size, tolerance) {
            Some((plane, repair)) => {
                repairs.push(repair);
                (FaceSurface::Plane(plane), true)
            }
            None => (part_with_edges(&entry.surface, model, edges, face, &mut repairs), face.same_sense),
        };
        let refused = |error| FaceRefusal::Surface { entity: entry.entity, error };
        let has_border = ends_at_border(&surface, face);
        let extent =
            if has_border { border_extent(&surface, extent, tolerance).map_err(refused)? } else { extent };
        let size = if has_border { (extent.max - extent.min).length() } else { size };
        let conversion = Carrier::try_from_surface(&surface, extent, tolerance).or_else(|error| {
            let part = offset_part(&surface, edges, face, tolerance).ok_or(error)?;
            Carrier::try_from_surface(&part, extent, tolerance)
        });
        let conversion = conversion.map_err(refused)?;
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
            let ranges = ranges(&surface, &conversion, tolerance).map_err(refused)?;
            for curves in border(&laid.carrier, ranges, tolerance) {
                laid.loops.push(curves.into_iter().map(|curve| curve.scaled(laid.metric)).collect());
                laid.bounds.push(face.entity);
            }
        }
        for bound in &face.bounds {
            let mut curves = match &bound.boundary {
                BoundaryLoop::Edges(oriented) => {
                    laid.edges(model, edges, face.surface, &conversion, oriented)?
                }
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
        // Without a map of the parameters, curves of the file are not compared with the edges: nothing is repaired.
        let keeps_parameters = conversion.parameters.is_some();
        let is_fitted = |part: &EdgeParameterCurve| part.source == ParameterCurveSource::Fitted;
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
            let deviation = largest(parts.iter().map(|part| part.deviation));
            if deviation.is_nan() || deviation > STRAYING * self.size {
                return Err(FaceRefusal::StrayingEdge { edge: edge.entity, distance: deviation });
            }
            if deviation > self.tolerance {
                self.repairs.push(FaceRepair::StrayingEdge { edge: edge.entity, distance: deviation });
            } else if given.is_some() && keeps_parameters && parts.iter().any(is_fitted) {
                self.repairs.push(FaceRepair::ParameterCurve(edge.entity));
            }
            self.deviations.push((number, deviation));
            let ranges = part_ranges(&self.carrier, curve, &parts);
            if let Some(normals) = &mut self.normals {
                let parts = (parts.as_slice(), ranges.as_slice());
                normals.push(EdgeNormals::new(number, (&self.carrier, self.reversed), curve, parts));
            }
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

    /// A loop that is a point: a pole, which bounds nothing, or a mistake.
    fn vertex(&mut self, point: DVec3, bound: EntityId) {
        let at_pole = self.carrier.poles().iter().any(|pole| pole.point.distance(point) <= self.tolerance);
        let closed = matches!(self.carrier, Carrier::Sphere { .. } | Carrier::Torus { .. });
        if !at_pole && !closed {
            self.repairs.push(FaceRepair::VertexLoop(bound));
        }
    }

    /// The trimmed face. `widths`: per edge.
    pub(super) fn close(
        mut self,
        model: &BrepModel,
        edges: &[BoundedEdge],
        widths: &[f64],
    ) -> Result<TrimmedFace, FaceRefusal> {
        let (size, tolerance) = (self.size, self.tolerance);
        for curve in self.loops.iter_mut().flatten() {
            let strayed = curve.edge.and_then(|edge| widths.get(edge).copied()).unwrap_or(curve.width);
            curve.width = overlap(strayed, tolerance, size) + ROUNDING * size;
        }
        let point = |at: DVec2| self.carrier.point(at / self.metric);
        let space = self.space(&point);
        let limit = (BRIDGED * self.size).max(self.tolerance);
        let loops = std::mem::take(&mut self.loops);
        if loops.is_empty() && !space.is_closed() {
            self.repairs.push(FaceRepair::MissingBoundary);
        }
        let mut chains: Vec<BoundaryChain> = Vec::with_capacity(loops.len());
        let (mut width, mut margin): (f64, f64) = (0.0, 0.0);
        for curves in loops {
            let mut chain = chain(curves, &space, tolerance, limit)?;
            let widened: Vec<WidenedCurve> =
                chain.curves.iter().flat_map(|curve| self.widened(edges, curve)).collect();
            for part in &widened {
                (width, margin) = (width.max(part.distance), margin.max(part.curve.width));
            }
            chain.curves = widened.into_iter().map(|widened| widened.curve).collect();
            chains.push(chain);
        }
        let closed = close(chains, &space, margin)?;
        let mut repairs = std::mem::take(&mut self.repairs);
        repairs.extend(closed.repairs.iter().map(|&repair| match repair {
            BoundaryRepair::BridgedGap { gap } => FaceRepair::BridgedGap { gap },
            BoundaryRepair::ReversedEdge { edge } => FaceRepair::ReversedEdge(model.edges[edge].entity),
            BoundaryRepair::ReversedBoundary => FaceRepair::ReversedBoundary,
            BoundaryRepair::ReversedLoop { number } => FaceRepair::ReversedLoop(self.bounds[number]),
        }));
        let geometry = placed(&self.carrier, self.metric, closed.window);
        let trim = (!closed.loops.is_empty()).then(|| FaceTrim {
            loops: closed
                .loops
                .iter()
                .map(|curves| curves.iter().map(|curve| geometry.curve(curve)).collect())
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

    /// A curve of a boundary with widths in region coordinates.
    fn widened(&self, edges: &[BoundedEdge], curve: &BoundaryCurve) -> Vec<WidenedCurve> {
        let fraction = |at: DVec2| {
            let edge = edges.get(curve.edge?)?.curve.as_ref().ok()?;
            Some(edge.nearest_fraction(self.carrier.point(at / self.metric)))
        };
        let stretched = StretchedCurve::new(&self.carrier, self.metric, curve);
        stretched.widened(BRIDGED * self.size, UNSEEN * self.size, fraction)
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

/// How far a face of this size extends on its surface beyond an edge from which the faces beside it stray by `strayed`, metres: the farther, the more
/// they stray, but beyond the tolerance no farther than needed.
fn overlap(strayed: f64, tolerance: f64, size: f64) -> f64 {
    let narrow = (NARROW_OVERLAP * strayed).min(UNSEEN * size);
    strayed.max(OVERLAP * strayed.min(tolerance)).max(narrow)
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
