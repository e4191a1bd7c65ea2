//! Edges in which shapes meet or end.

use glanz_math::DVec3;

/// An edge of the shapes of a group. Rays do not meet it; pictures of CAD models and measurements use it.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeDescription {
    /// Points along it in the frame of the group, metres; at least two. The last is the first one if it is closed.
    pub points: Vec<DVec3>,
    /// Bound on the distance of the straight segments between its points from the edge and from the shapes, metres.
    pub deviation: f64,
    /// Kind of the curve.
    pub kind: EdgeKind,
    /// Arc length, metres.
    pub length: f64,
    /// Indices of the shapes of the group that meet in it, as a rule two; twice the same where a shape meets itself, one where it ends.
    pub shapes: Vec<usize>,
    /// How the shapes meet.
    pub transition: EdgeTransition,
    /// Largest angle between the normals of the shapes along it, radians, from 0 to pi; 0 at a border.
    pub angle: f64,
}

/// Kind of the curve of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum EdgeKind {
    /// A straight line.
    Line,
    /// A circle or a part of it.
    Circle {
        /// Centre, metres.
        center: DVec3,
        /// Unit normal of its plane.
        axis: DVec3,
        /// Radius, metres.
        radius: f64,
    },
    /// An ellipse or a part of it.
    Ellipse {
        /// Centre, metres.
        center: DVec3,
        /// Unit normal of its plane.
        axis: DVec3,
        /// The larger and the smaller radius, metres.
        radii: [f64; 2],
    },
    /// Any other curve.
    Spline,
}

/// How shapes meet in an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EdgeTransition {
    /// One shape ends.
    Border,
    /// The normals of two shapes differ, or more than two shapes meet.
    Sharp,
    /// Two shapes continue each other tangentially.
    Smooth,
    /// A shape continues itself, as a cylinder after a turn.
    Seam,
}

impl EdgeTransition {
    /// Whether it shows in the form of the model: a border or a sharp edge.
    #[must_use]
    pub fn is_feature(self) -> bool {
        matches!(self, Self::Border | Self::Sharp)
    }
}

impl EdgeDescription {
    /// Whether it ends where it starts.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }
}
