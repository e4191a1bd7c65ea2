//! Groups, and the shapes and instances in them.

use glanz_math::DMat4;

use super::Location;
use super::edge::EdgeDescription;
use super::shape::ShapeDescription;

/// Shapes and instances with one frame.
#[derive(Clone, Debug, Default)]
pub struct GroupDescription {
    /// Its name; empty for the world.
    pub name: String,
    /// Shapes.
    pub shapes: Vec<ShapeDescription>,
    /// Copies of other groups.
    pub instances: Vec<InstanceDescription>,
    /// Edges of the shapes, where the reader was asked for them.
    pub edges: Vec<EdgeDescription>,
}

/// A copy of a group.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Its name, such as that of an occurrence in an assembly; may be empty.
    pub name: String,
    /// Index into [`Description::groups`](super::Description::groups).
    pub group: usize,
    /// Transformation from the group's frame to that of the group that contains this instance.
    pub to_parent: DMat4,
    /// Its place in the input.
    pub location: Option<Location>,
}
