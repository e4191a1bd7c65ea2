//! Reasons against entities.

use glanz_brep::model::EntityId;

/// An entity that cannot be used, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Refusal {
    /// Its number.
    pub(crate) entity: EntityId,
    /// The reason.
    pub(crate) reason: String,
}

impl Refusal {
    pub(crate) fn new(entity: EntityId, reason: impl Into<String>) -> Self {
        Self { entity, reason: reason.into() }
    }
}
