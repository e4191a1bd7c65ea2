//! Groups, and the shapes and instances in them.

use glanz_math::DMat4;

use super::Location;
use super::geometry::GeometryDescription;
use super::light::EmissionDescription;
use super::receiver::ReceiverDescription;
use super::trim::TrimDescription;

/// Shapes and instances with one frame.
#[derive(Clone, Debug, Default)]
pub struct GroupDescription {
    /// Its name; empty for the world.
    pub name: String,
    /// Shapes.
    pub shapes: Vec<ShapeDescription>,
    /// Copies of other groups.
    pub instances: Vec<InstanceDescription>,
}

/// A copy of a group.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Index into [`Description::groups`](super::Description::groups).
    pub group: usize,
    /// From the group's frame to that of the group that holds this instance.
    pub to_parent: DMat4,
    /// Where it was said.
    pub location: Option<Location>,
}

/// A surface with its material.
#[derive(Clone, Debug)]
pub struct ShapeDescription {
    /// The surface in its own frame.
    pub geometry: GeometryDescription,
    /// From the frame of the surface to that of the group.
    pub to_parent: DMat4,
    /// Whether the normal is turned round.
    pub reverse_orientation: bool,
    /// Index into [`Description::materials`](super::Description::materials).
    pub material: usize,
    /// Light it gives off.
    pub emission: Option<EmissionDescription>,
    /// The part of its parameter domain that is kept; `None`: all of it.
    pub trim: Option<TrimDescription>,
    /// What makes it a receiver; only shapes of the world can be.
    pub receiver: Option<ReceiverDescription>,
    /// Where it was said.
    pub location: Option<Location>,
}
