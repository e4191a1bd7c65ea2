//! Edges of bodies in the description of a scene.

use std::collections::BTreeMap;

use glanz_brep::curve::EdgePolyline;
use glanz_brep::face::{EdgeNormals, TrimmedFace};
use glanz_brep::model::{BrepModel, Curve};
use glanz_math::DVec3;
use glanz_scene::description::{EdgeDescription, EdgeKind, EdgeTransition};

/// Largest angle between the normals of faces that continue each other tangentially, radians: blends that are approximated by splines
/// are off by a part of a degree.
const TANGENT: f64 = 1.0 / 57.295_779_513_082_32;

/// Largest difference of the axes of a circle, relative to them: the digits that files give.
const ROUND: f64 = 1e-9;

/// The faces of a body that meet in its edges.
#[derive(Debug, Default)]
pub(super) struct BodyEdges {
    /// By edge: shapes and the normals of their faces.
    curves: BTreeMap<usize, Vec<(usize, EdgeNormals)>>,
}

impl BodyEdges {
    /// Adds a face of the body. `shape`: its index in the group; `reversed`: whether the body reverses its normal.
    pub(super) fn add(&mut self, shape: usize, face: &TrimmedFace, reversed: bool) {
        for normals in &face.edge_normals {
            let normals = if reversed { normals.reversed() } else { normals.clone() };
            self.curves.entry(normals.edge).or_default().push((shape, normals));
        }
    }

    /// Adds the edges of the body. `polylines`, `widths`: of the edges of the model.
    pub(super) fn describe(
        self,
        model: &BrepModel,
        (polylines, widths): (&[Option<EdgePolyline>], &[f64]),
        edges: &mut Vec<EdgeDescription>,
    ) {
        for (number, uses) in self.curves {
            let (Some(edge), Some(Some(polyline))) = (model.edges.get(number), polylines.get(number)) else {
                continue;
            };
            let shapes: Vec<usize> = uses.iter().map(|&(shape, _)| shape).collect();
            let angle = match uses.as_slice() {
                [(_, first), others @ ..] => {
                    others.iter().map(|(_, other)| first.angle_to(other)).fold(0.0, f64::max)
                }
                [] => 0.0,
            };
            edges.push(EdgeDescription {
                points: polyline.points.clone(),
                deviation: polyline.deviation + widths.get(number).copied().unwrap_or_default(),
                kind: edge.curve.as_ref().map_or(EdgeKind::Line, kind),
                length: polyline.length,
                transition: transition(&shapes, angle),
                shapes,
                angle,
            });
        }
    }
}

fn transition(shapes: &[usize], angle: f64) -> EdgeTransition {
    match *shapes {
        [] | [_] => EdgeTransition::Border,
        [a, b] if angle <= TANGENT => {
            if a == b {
                EdgeTransition::Seam
            } else {
                EdgeTransition::Smooth
            }
        }
        _ => EdgeTransition::Sharp,
    }
}

/// The kind of a curve; of parts of curves, that of the whole one.
fn kind(curve: &Curve<DVec3>) -> EdgeKind {
    match *curve {
        Curve::Line { .. } => EdgeKind::Line,
        Curve::Polyline(ref points) if points.len() == 2 => EdgeKind::Line,
        Curve::Trimmed { ref basis, .. } => kind(basis),
        Curve::Ellipse { center, a, b } => {
            let [long, short] = if a.length() >= b.length() { [a, b] } else { [b, a] };
            let (larger, smaller) = (long.length(), short.length());
            let axis = a.cross(b).normalize_or_zero();
            if larger - smaller <= ROUND * larger {
                EdgeKind::Circle { center, axis, radius: larger }
            } else {
                EdgeKind::Ellipse { center, axis, radii: [larger, smaller] }
            }
        }
        _ => EdgeKind::Spline,
    }
}
