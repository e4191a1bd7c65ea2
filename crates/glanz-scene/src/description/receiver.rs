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
    /// The part of a planned room that it is, if it is one.
    pub zone: Option<ZoneKind>,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// A part of a planned room, with requirements of its own (EN 12464-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// The task area.
    Task,
    /// The band around the task area.
    Surrounding,
    /// The area beyond that band.
    Background,
    /// A wall.
    Wall,
    /// The ceiling.
    Ceiling,
}

impl ZoneKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Task, Self::Surrounding, Self::Background, Self::Wall, Self::Ceiling];

    /// Name in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Task => "task",
            Self::Surrounding => "surrounding",
            Self::Background => "background",
            Self::Wall => "wall",
            Self::Ceiling => "ceiling",
        }
    }
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
