//! Observers of a planned room.

use glanz_math::DVec3;

use super::Location;

/// A point of a planned room at which light is rated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverDescription {
    /// The point in the world, metres.
    pub position: DVec3,
    /// The line of sight of an observer whose glare is rated, of any length, not vertical; `None`: a point of cylindrical illuminance.
    pub view: Option<DVec3>,
    /// Its place in the input.
    pub location: Option<Location>,
}
