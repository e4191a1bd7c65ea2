//! Repairs of faces, and reasons why they are left out.

use glanz_geometry::SurfaceError;
use thiserror::Error;

use crate::boundary::BoundaryError;
use crate::error::BrepError;
use crate::model::EntityId;

/// A repair of a face.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FaceRepair {
    /// Consecutive edges do not meet.
    #[error("a gap of {gap:.1e} m in its boundary is bridged")]
    BridgedGap {
        /// Length of the gap, metres.
        gap: f64,
    },
    /// An edge runs against its loop.
    #[error("edge {0}, which runs against its loop, is reversed")]
    ReversedEdge(EntityId),
    /// The boundary has the face on its right.
    #[error("its boundary has the outside on its left; it is reversed")]
    ReversedBoundary,
    /// An outer loop runs as a hole, or a hole as an outer loop.
    #[error("loop {0} has the outside on its left; it is reversed")]
    ReversedLoop(EntityId),
    /// The curve that the file gives in the parameters of the surface does not hold; another was made from the edge.
    #[error("the parameter curve of edge {0} is not on the edge; another was made")]
    ParameterCurve(EntityId),
    /// The edge does not lie on the surface.
    #[error("edge {edge} is {distance:.1e} m off the surface")]
    StrayingEdge {
        /// The edge.
        edge: EntityId,
        /// Its largest distance, metres.
        distance: f64,
    },
    /// The polygons of the face lie in another plane.
    #[error("its polygons are {distance:.1e} m off its plane; their own is taken")]
    PolygonPlane {
        /// Their largest distance from the plane in the file, metres.
        distance: f64,
    },
    /// The polygons of the face run clockwise about its normal.
    #[error("its polygons run clockwise about its normal; its plane is turned")]
    TurnedPlane,
    /// A loop is a single point that is not a pole.
    #[error("loop {0} is a point; it is ignored")]
    VertexLoop(EntityId),
    /// The boundary of a surface that has borders is missing.
    #[error("it has no boundary; the whole surface is taken")]
    MissingBoundary,
    /// The profile of a surface of revolution crosses or passes the axis too often to be divided there.
    #[error("its profile crosses or passes the axis too often to be divided there; all of it is taken")]
    WholeProfile,
    /// A surface that cannot be taken over exactly is approximated.
    #[error("its surface is approximated to {deviation:.1e} m")]
    FittedSurface {
        /// Largest distance from the surface in the file, metres.
        deviation: f64,
    },
}

/// Why a face is left out.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FaceRefusal {
    /// Its surface cannot be converted.
    #[error("surface {entity}: {error}")]
    Surface {
        /// The surface.
        entity: EntityId,
        /// Reason.
        error: BrepError,
    },
    /// An edge cannot be laid onto its surface.
    #[error("edge {entity}: {error}")]
    Edge {
        /// The edge.
        entity: EntityId,
        /// Reason.
        error: BrepError,
    },
    /// An edge is far from its surface.
    #[error("edge {edge} is {distance:.1e} m off its surface")]
    StrayingEdge {
        /// The edge.
        edge: EntityId,
        /// Its largest distance, metres.
        distance: f64,
    },
    /// Its boundary does not close.
    #[error("{0}")]
    Boundary(#[from] BoundaryError),
    /// What was made of it cannot be part of a scene.
    #[error("its geometry is invalid: {0}")]
    Geometry(#[from] SurfaceError),
    /// An index of the model is invalid.
    #[error("it refers to a part that the model lacks")]
    Dangling,
}
