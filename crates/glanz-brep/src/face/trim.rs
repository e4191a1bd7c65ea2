//! From faces and edges to trimmed surfaces.

use glanz_math::{DMat4, DVec2};
use rayon::prelude::*;

use super::bounded_edge::BoundedEdge;
use super::edges::{EdgeNormals, polylines};
use super::geometry::FaceGeometry;
use super::laid_face::LaidFace;
use super::outcome::{FaceRefusal, FaceRepair};
use crate::boundary::BoundaryCurve;
use crate::curve::EdgePolyline;
use crate::model::BrepModel;

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
    /// Largest distance by which the face extends beyond an edge, metres, at samples along the edges; between them it may be larger.
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
#[derive(Clone, Debug, Default)]
pub struct TrimmedFaces {
    /// The faces.
    pub faces: Vec<Result<TrimmedFace, FaceRefusal>>,
    /// Per edge: the sum of the distances by which the faces beside it stray from it, metres; 0 where no face has it.
    pub widths: Vec<f64>,
    /// Of [`trimmed_faces_with_edges`]: points along the edges, `None` for those without a curve.
    pub edges: Option<Vec<Option<EdgePolyline>>>,
}

/// The trimmed faces of a model. They do not depend on the number of threads.
#[must_use]
pub fn trimmed_faces(model: &BrepModel) -> TrimmedFaces {
    trimmed_faces_while(model, false, &|| true).unwrap_or_default()
}

/// The same, with points along the edges and the normals of the faces there.
#[must_use]
pub fn trimmed_faces_with_edges(model: &BrepModel) -> TrimmedFaces {
    trimmed_faces_while(model, true, &|| true).unwrap_or_default()
}

/// The same, `with_edges` or without, as long as `proceed` allows it, which is asked for each edge and face; `None` if it did not.
#[must_use]
pub fn trimmed_faces_while(
    model: &BrepModel,
    with_edges: bool,
    proceed: &(dyn Fn() -> bool + Sync),
) -> Option<TrimmedFaces> {
    let bounded = |edge| proceed().then(|| BoundedEdge::new(model, edge));
    let edges: Vec<BoundedEdge> = model.edges.par_iter().map(bounded).collect::<Option<_>>()?;
    let laid = |face| proceed().then(|| LaidFace::try_new(model, &edges, face, with_edges));
    let laid: Vec<Result<LaidFace, FaceRefusal>> = model.faces.par_iter().map(laid).collect::<Option<_>>()?;
    let mut widths = vec![0.0; model.edges.len()];
    for &(edge, deviation) in laid.iter().flatten().flat_map(|face| &face.deviations) {
        widths[edge] += deviation;
    }
    let close = |face: Result<LaidFace, FaceRefusal>| face?.close(model, &edges, &widths);
    let faces = laid.into_par_iter().map(|face| proceed().then(|| close(face))).collect::<Option<_>>()?;
    let edges = if with_edges { Some(polylines(model, &edges, proceed)?) } else { None };
    Some(TrimmedFaces { faces, widths, edges })
}
