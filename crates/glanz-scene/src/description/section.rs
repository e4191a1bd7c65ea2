//! Sections through groups.

use glanz_math::DVec3;

/// A plane that cuts a group open: the part of its shapes and instances beyond the plane is left out, and the solids that they enclose get a flat
/// face where they are cut.
///
/// A point is inside of a solid if a ray from it meets the shapes of one group an odd number of times, so that they must be closed together. Solids of different
/// groups may overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionDescription {
    /// Index into [`Description::groups`](super::Description::groups).
    pub group: usize,
    /// Normal towards the part that is left out, in the frame of the group; any length but 0.
    pub normal: DVec3,
    /// `normal . p` of the points p of the plane.
    pub offset: f64,
    /// Index into [`Description::materials`](super::Description::materials): the material of the faces.
    pub material: usize,
}
