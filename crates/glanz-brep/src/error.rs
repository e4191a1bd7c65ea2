//! The error of this crate.

use glanz_geometry::SurfaceError;

/// A curve, an edge or a surface that cannot be converted. Every variant holds the values that are at fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BrepError {
    /// A spline that a conversion makes is invalid.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A part of a curve is unbounded, or empty.
    #[error("the part of the {curve} from parameter {start} to {end} is not a bounded curve")]
    Range {
        /// Kind of the curve.
        curve: &'static str,
        /// Parameter of its start.
        start: f64,
        /// Parameter of its end.
        end: f64,
    },
    /// A curve has too few points or segments.
    #[error("the {curve} has {count} {elements}; at least {min} are needed")]
    TooFew {
        /// Kind of the curve.
        curve: &'static str,
        /// What it is made of.
        elements: &'static str,
        /// Their number.
        count: usize,
        /// The number needed.
        min: usize,
    },
    /// An edge has no length.
    #[error("the edge from ({}, {}, {}) has no length", point[0], point[1], point[2])]
    ShortEdge {
        /// Its start, metres.
        point: [f64; 3],
    },
    /// An edge ends at the vertex where it starts, but its curve is open.
    #[error(
        "the edge is closed, but its curve is open: its ends are {gap:.2e} m apart; the tolerance is {tolerance:.2e} m"
    )]
    OpenCurve {
        /// Distance of the ends of the curve, metres.
        gap: f64,
        /// Distance allowed, metres.
        tolerance: f64,
    },
    /// The box of a face is empty or infinite.
    #[error("the surface is unbounded, and so is the extent of its face")]
    UnboundedExtent,
    /// A face without edges on a surface that is trimmed by a range of parameters.
    #[error("the range of a trimmed surface without edges is not applied")]
    UnappliedRange,
    /// The range of a trimmed surface without edges goes on behind an apex or a pole, by so many metres.
    #[error("the range of the surface goes {0:.1e} m beyond its apex or pole; it must end there")]
    RangeBeyondPole(f64),
    /// A surface is a curve, a point or nothing.
    #[error("the surface has no area: {reason} ({value})")]
    DegenerateSurface {
        /// The reason.
        reason: &'static str,
        /// The measured quantity.
        value: f64,
    },
    /// No spline within the limits is close enough.
    #[error(
        "the {shape} is fitted with a deviation of {deviation:.2e} m; the tolerance is {tolerance:.2e} m"
    )]
    Unfitted {
        /// What was fitted.
        shape: &'static str,
        /// Deviation reached, metres.
        deviation: f64,
        /// Deviation allowed, metres.
        tolerance: f64,
    },
}
