//! Edges beside faces: points along them, and the normals of the faces there.

use glanz_math::{Bounds3, DVec3};
use rayon::prelude::*;

use super::bounded_edge::BoundedEdge;
use crate::carrier::Carrier;
use crate::curve::{EdgeCurve, EdgePolyline};
use crate::model::BrepModel;
use crate::parameter_curve::EdgeParameterCurve;

/// Shares of the range of an edge at which normals are compared: away from its ends, where surfaces often degenerate.
const FRACTIONS: [f64; 5] = [0.08, 0.29, 0.5, 0.71, 0.92];

/// Deviation of polylines, relative to the model: a tenth of a pixel in a picture of 2000 pixels.
const MODEL_DEVIATION: f64 = 5e-5;

/// Deviation of polylines, relative to the edge: circles have about 50 segments at least.
const EDGE_DEVIATION: f64 = 1e-3;

/// The normals of a face along one of its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeNormals {
    /// Index of the edge.
    pub edge: usize,
    /// Unit normals of the face at points of the edge; zero where the face has none.
    normals: [DVec3; FRACTIONS.len()],
}

impl EdgeNormals {
    /// The normals of a face on `carrier`, opposite to its own if `reversed`. `curves`: the edge in parameters of the carrier; `ranges`: the
    /// fractions of the edge at which each of them starts and ends.
    pub(super) fn new(
        edge: usize,
        (carrier, reversed): (&Carrier, bool),
        curve: &EdgeCurve,
        (curves, ranges): (&[EdgeParameterCurve], &[[f64; 2]]),
    ) -> Self {
        let side = if reversed { -1.0 } else { 1.0 };
        let normal = |fraction: f64| {
            let point = curve.point(fraction);
            let projections = curves.iter().zip(ranges).map(|(part, [from, to])| {
                let [start, end] = part.curve.domain();
                let share = if to > from { ((fraction - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
                carrier.parameters(point, Some(part.curve.point(start + share * (end - start))))
            });
            let nearest = projections.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
            carrier.normal(nearest.uv).map(|normal| side * normal)
        };
        Self { edge, normals: FRACTIONS.map(|fraction| normal(fraction).unwrap_or(DVec3::ZERO)) }
    }

    /// The normals of the face that looks to the other side.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { edge: self.edge, normals: self.normals.map(|normal| -normal) }
    }

    /// The largest angle between these normals and those of another face along the same edge, radians.
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        let pairs = self.normals.iter().zip(&other.normals);
        pairs.map(|(a, b)| a.cross(*b).length().atan2(a.dot(*b))).fold(0.0, f64::max)
    }
}

/// Points along the edges of a model, `None` for those without a curve, as long as `proceed` allows it, which is asked for each edge; `None` if
/// it did not.
pub(super) fn polylines(
    model: &BrepModel,
    edges: &[BoundedEdge],
    proceed: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Option<EdgePolyline>>> {
    let size = Bounds3::from_points(model.vertices.iter().copied()).diagonal().length();
    let polyline = |edge: &BoundedEdge| {
        let own = EDGE_DEVIATION * edge.bounds.diagonal().length();
        let curve = edge.curve.as_ref().ok()?;
        // A single closed edge has one vertex, and its model no size.
        let tolerance = if size > 0.0 { own.min(MODEL_DEVIATION * size) } else { own };
        curve.polyline(tolerance).ok().filter(|polyline| polyline.points.iter().all(|p| p.is_finite()))
    };
    edges.par_iter().map(|edge| proceed().then(|| polyline(edge))).collect()
}
