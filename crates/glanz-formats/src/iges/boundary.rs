//! Boundaries of curves that belong to one face only.

use glanz_brep::model::{BoundaryLoop, Curve, Edge, EntityId, FaceBound, OrientedEdge, ParameterCurve};
use glanz_math::{DVec2, DVec3};

use super::curves::CurveSegment;
use super::entity::IgesEntity;
use super::lowering::IgesReader;
use crate::cad::{ENTITY_COST, Refusal};

/// A segment of a boundary.
pub(super) struct BoundarySegment {
    pub(super) curve: Curve<DVec3>,
    /// Whether the boundary runs through it against its parameter.
    pub(super) reversed: bool,
    /// Its curve in the parameters of the surface in the model.
    pub(super) parameter_curve: Option<Curve<DVec2>>,
    pub(super) entity: EntityId,
}

/// Segments after which a boundary runs back through a seam, at most.
const MAX_SEAM_DISTANCE: usize = 64;

/// Samples of a curve per control point of a spline, for its direction around an area.
const SAMPLES: usize = 4;

impl BoundarySegment {
    /// The segments of a curve in space, with those of a curve in parameters if there are as many.
    pub(super) fn zip(curves: Vec<CurveSegment>, parameter_curves: Vec<Curve<DVec2>>) -> Vec<Self> {
        let has_parameters = curves.len() == parameter_curves.len();
        let mut parameter_curves = parameter_curves.into_iter().filter(|_| has_parameters);
        let segment = |CurveSegment { curve, entity }| Self {
            curve,
            reversed: false,
            parameter_curve: parameter_curves.next(),
            entity,
        };
        curves.into_iter().map(segment).collect()
    }

    /// Points from its start to its end in the order of the boundary.
    fn points(&self) -> [DVec3; 5] {
        let [from, to] = self.curve.domain();
        let mut points = [0.0, 0.25, 0.5, 0.75, 1.0].map(|s| self.curve.point(from + (to - from) * s));
        if self.reversed {
            points.reverse();
        }
        points
    }

    /// Whether all of it is one point.
    pub(super) fn is_point(&self, tolerance: f64) -> bool {
        let [from, to] = self.curve.domain();
        let start = self.curve.point(from);
        let distance = |s: f64| self.curve.point(from + (to - from) * s).distance(start);
        [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0].into_iter().all(|s| distance(s) <= tolerance)
    }
}

/// Whether the second of two segments runs through the first from its end to its start, and is not closed.
fn runs_back(first: &[DVec3; 5], second: &[DVec3; 5], tolerance: f64) -> bool {
    first[0].distance(first[4]) > tolerance
        && first.iter().zip(second.iter().rev()).all(|(a, b)| a.distance(*b) <= tolerance)
}

/// Points along a curve in its order.
fn samples(curve: &Curve<DVec2>) -> Vec<DVec2> {
    let [from, to] = curve.domain();
    let count = match curve {
        Curve::Line { .. } => 1,
        Curve::Spline(spline) => SAMPLES * spline.control_points().len(),
        Curve::Polyline(points) => points.len(),
        Curve::Trimmed { basis, .. } => match basis.as_ref() {
            Curve::Line { .. } => 1,
            Curve::Spline(spline) => SAMPLES * spline.control_points().len(),
            _ => 16 * SAMPLES,
        },
        _ => 16 * SAMPLES,
    };
    (0..=count).map(|i| curve.point(from + (to - from) * (i as f64 / count as f64))).collect()
}

/// Whether a loop in parameters runs counterclockwise; `None` if it is not closed, or encloses nothing.
pub(super) fn is_counterclockwise(curves: &[Curve<DVec2>]) -> Option<bool> {
    let points: Vec<DVec2> = curves.iter().flat_map(samples).collect();
    let (first, last) = (*points.first()?, *points.last()?);
    let area: f64 = points.windows(2).map(|pair| 0.5 * (pair[0] - first).perp_dot(pair[1] - first)).sum();
    let size = points.iter().map(|point| point.distance(first)).fold(0.0, f64::max);
    // A loop around a period ends elsewhere; an area that is rounding has no sense.
    (last.distance(first) <= 1e-3 * size && area.abs() > f64::EPSILON.sqrt() * size * size)
        .then_some(area > 0.0)
}

impl IgesReader<'_> {
    /// A bound of new edges. Segments that are points are left out; a seam, through which the bound runs both ways, is one edge.
    pub(super) fn bound(
        &mut self,
        entity: IgesEntity<'_>,
        surface: usize,
        mut segments: Vec<BoundarySegment>,
        reversed: bool,
        outer: bool,
    ) -> Result<FaceBound, Refusal> {
        let tolerance = self.model.uncertainty;
        segments.retain(|segment| !segment.is_point(tolerance));
        if segments.is_empty() {
            return Err(entity.refuse("the boundary is a point"));
        }
        self.budget.spend(entity.id(), ENTITY_COST * segments.len())?;
        let points: Vec<[DVec3; 5]> = segments.iter().map(BoundarySegment::points).collect();
        let starts: Vec<usize> = points.iter().map(|points| self.vertex_at(points[0])).collect();
        let mut oriented: Vec<OrientedEdge> = Vec::with_capacity(segments.len());
        for (i, (segment, &[start, .., end])) in segments.into_iter().zip(&points).enumerate() {
            let (Some(&first), Some(&next)) = (starts.get(i), starts.get((i + 1) % starts.len())) else {
                continue;
            };
            // One of the last few segments; any distance would take the square of their number.
            let seam = (i.saturating_sub(MAX_SEAM_DISTANCE)..i).find(|&k| {
                let back = points.get(k).zip(points.get(i)).map(|(a, b)| runs_back(a, b, tolerance));
                back == Some(true)
            });
            if let Some(known) = seam.and_then(|k| oriented.get(k)).copied() {
                oriented.push(OrientedEdge { forward: !known.forward, ..known });
                continue;
            }
            let joins = |vertex: usize| {
                self.model.vertices.get(vertex).is_some_and(|vertex| vertex.distance(end) <= tolerance)
            };
            let last = if start.distance(end) <= tolerance {
                first
            } else if joins(next) {
                next
            } else {
                self.vertex_at(end)
            };
            let [start, end] = if segment.reversed { [last, first] } else { [first, last] };
            let parameter_curves =
                segment.parameter_curve.map(|curve| ParameterCurve { surface, curve }).into_iter().collect();
            oriented.push(OrientedEdge { edge: self.model.edges.len(), forward: !segment.reversed });
            self.model.edges.push(Edge {
                start,
                end,
                curve: Some(segment.curve),
                same_sense: true,
                parameter_curves,
                entity: segment.entity,
            });
        }
        if reversed {
            oriented.reverse();
            oriented.iter_mut().for_each(|edge| edge.forward ^= true);
        }
        Ok(FaceBound { boundary: BoundaryLoop::Edges(oriented), outer, entity: entity.id() })
    }

    fn vertex_at(&mut self, point: DVec3) -> usize {
        self.model.vertices.push(point);
        self.model.vertices.len() - 1
    }
}
