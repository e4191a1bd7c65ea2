//! Where arriving light is measured.

use super::Location;

/// Cells along each side of a receiver at most.
pub const MAX_RECEIVER_CELLS: u32 = 4096;

/// What makes a shape of the world a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceiverDescription {
    /// Its name; several may have the same.
    pub name: String,
    /// Numbers of cells along u and v, each from 1 to [`MAX_RECEIVER_CELLS`]; `None`: whoever measures decides.
    pub cells: Option<[u32; 2]>,
    /// Where light must arrive to count.
    pub side: ReceiverSide,
    /// Where it was said.
    pub location: Option<Location>,
}

/// Sides of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReceiverSide {
    /// The one that the normal points to, after `reverse_orientation`.
    #[default]
    Front,
    /// The other.
    Back,
    /// Both, each by itself.
    Both,
}
