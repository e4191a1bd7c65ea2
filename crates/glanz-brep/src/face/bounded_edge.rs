//! Edges with boxes around them.

use glanz_math::{Bounds3, DVec3};

use super::outcome::FaceRefusal;
use crate::curve::EdgeCurve;
use crate::error::BrepError;
use crate::model::{BoundaryLoop, BrepModel, CurveVector, Edge, Face, OrientedEdge};

/// An edge with a box around it.
pub(super) struct BoundedEdge {
    pub(super) curve: Result<EdgeCurve, BrepError>,
    /// Around its control points; around its vertices where there is no curve.
    pub(super) bounds: Bounds3,
}

impl BoundedEdge {
    pub(super) fn new(model: &BrepModel, edge: &Edge) -> Self {
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

/// A box around the edges of a face.
pub(super) fn extent(model: &BrepModel, edges: &[BoundedEdge], face: &Face) -> Result<Bounds3, FaceRefusal> {
    let mut points: Vec<DVec3> = Vec::new();
    for bound in &face.bounds {
        match &bound.boundary {
            BoundaryLoop::Edges(oriented) => {
                for oriented in oriented {
                    let curve = edges.get(oriented.edge).ok_or(FaceRefusal::Dangling)?;
                    points.extend([curve.bounds.min, curve.bounds.max]);
                }
            }
            BoundaryLoop::Vertex(vertex) => points.extend(model.vertices.get(*vertex)),
            BoundaryLoop::Border => {}
        }
    }
    Ok(Bounds3::from_points(points))
}

/// Points of the edges of a loop in its order and sense, the ends of `parts` equal parts of each; edges without a curve are passed over.
pub(super) fn loop_points(edges: &[BoundedEdge], oriented: &[OrientedEdge], parts: u32) -> Vec<DVec3> {
    let curves = oriented.iter().filter_map(|&OrientedEdge { edge, forward }| {
        edges.get(edge).and_then(|edge| edge.curve.as_ref().ok()).map(|curve| (curve, forward))
    });
    let points = curves.flat_map(|(curve, forward)| {
        let fraction = move |i: u32| f64::from(if forward { i } else { parts - i }) / f64::from(parts);
        (0..=parts).map(move |i| curve.point(fraction(i)))
    });
    points.collect()
}
