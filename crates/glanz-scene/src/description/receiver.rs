//! Receivers of light.

use super::Location;

/// Largest number of cells along each side of a receiver.
pub const MAX_RECEIVER_CELLS: u32 = 4096;

/// Settings that make a shape of the world a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceiverDescription {
    /// Its name; several may have the same.
    pub name: String,
    /// Numbers of cells along u and v, each from 1 to [`MAX_RECEIVER_CELLS`]; `None`: left to the measurement.
    pub cells: Option<[u32; 2]>,
    /// The side on which light counts.
    pub side: ReceiverSide,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// Sides of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReceiverSide {
    /// The side that the normal points to, after `reverse_orientation`.
    #[default]
    Front,
    /// The other side.
    Back,
    /// Both, measured separately.
    Both,
}
