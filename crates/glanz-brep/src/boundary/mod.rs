//! Closed boundaries of faces in the parameters of their carriers.
//!
//! A loop of edges closes in space, not always in the parameters: it may run around a period, end in a pole, or cross a seam. [`chain`]
//! joins the curves of a loop in the universal cover of the parameters, where angles go on over the seam. [`close`] makes of all loops
//! of a face closed curves with the face on their left within a window of the parameters, as [`TrimRegion`] wants them:
//!
//! - A loop that does not go around is closed. It appears in every copy, moved by periods, that reaches into the window.
//! - A loop that goes around in u is continued over the width of the window and closed far above it. Run towards +u, it has the face
//!   above it and adds one to the winding number there; run towards -u, it has the face below and takes one away. If the lowest loop
//!   takes away, or there is none below, the face begins at the lower side of the domain, which must then be a pole.
//! - Where two curves meet in a pole, the side of the domain that is the pole joins them.
//!
//! Going around in v is the same, turned by a right angle.
//!
//! [`TrimRegion`]: glanz_geometry::trim::TrimRegion

mod chain;
mod close;
mod curve;
mod space;
#[cfg(test)]
mod tests;

pub use chain::{BoundaryChain, chain};
pub use close::{ClosedBoundary, close};
pub use curve::BoundaryCurve;
pub use space::ParameterSpace;

use thiserror::Error;

/// A repair of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BoundaryRepair {
    /// Consecutive edges do not meet; a straight segment joins them.
    BridgedGap {
        /// Length of the gap, metres.
        gap: f64,
    },
    /// An edge runs against its loop.
    ReversedEdge {
        /// Its index.
        edge: usize,
    },
    /// The loops have the face on their right.
    ReversedBoundary,
    /// A hole runs as an outer loop, or an outer loop as a hole.
    ReversedLoop {
        /// Its position among the loops of the face.
        number: usize,
    },
}

/// Why a face has no boundary.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BoundaryError {
    /// A loop has no edges.
    #[error("a loop has no edges")]
    Empty,
    /// A loop does not close.
    #[error("consecutive edges are {gap:.2e} m apart; at most {limit:.2e} m can be bridged")]
    OpenLoop {
        /// Distance, metres.
        gap: f64,
        /// Largest distance that is bridged, metres.
        limit: f64,
    },
    /// The face would extend to infinity.
    #[error("the loops leave the face unbounded")]
    Unbounded,
    /// A loop goes around both periods at once.
    #[error(
        "a loop goes {0} times around in u and {1} times in v; only one of both can be other than zero, and by one"
    )]
    Winding(i32, i32),
    /// Loops around a period that do not bound one face.
    #[error("{0} loops go around one way and {1} the other; they must alternate")]
    Unpaired(usize, usize),
    /// Loops run over so many periods that their copies would not fit into memory.
    #[error("the boundary goes around its surface too often")]
    TooLarge,
    /// A coordinate is not a number.
    #[error("a curve of the boundary is not finite")]
    NotFinite,
}
