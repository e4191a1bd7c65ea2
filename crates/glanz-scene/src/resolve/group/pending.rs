//! Shapes of a group before and after their surfaces are built.

use std::sync::Arc;

use crate::alpha::AlphaTest;
use crate::description::{EmissionDescription, Location, ShapeDescription};
use crate::error::SceneError;
use crate::medium::MediumInterface;
use crate::object::SceneObject;
use crate::receiver::NamedReceiver;
use crate::resolve::{WarningList, shape};

/// A shape without its geometry.
pub(super) struct ShapeEntry {
    pub(super) id: u32,
    /// Whether light passes its surfaces.
    pub(super) passable: bool,
    pub(super) has_detail: bool,
    pub(super) alpha: Option<Arc<AlphaTest>>,
    pub(super) location: Option<Location>,
    pub(super) emission: Option<EmissionDescription>,
    pub(super) solid: Option<u32>,
    pub(super) receiver: Option<NamedReceiver>,
    pub(super) media: MediumInterface,
}

/// A shape whose surfaces are still to be built.
pub(super) struct PendingShape {
    pub(super) entry: ShapeEntry,
    /// Without what the entry holds.
    pub(super) shape: ShapeDescription,
}

/// A shape with its surfaces.
pub(super) struct BuiltShape {
    pub(super) entry: ShapeEntry,
    pub(super) objects: Result<Vec<SceneObject>, SceneError>,
    pub(super) warnings: WarningList,
}

impl ShapeEntry {
    /// Whether no ray hits the shape.
    pub(super) fn is_absent(&self) -> bool {
        self.alpha.as_ref().is_some_and(|alpha| alpha.is_absent())
    }

    /// Whether a medium ends at it.
    pub(super) fn bounds_medium(&self) -> bool {
        self.media.is_boundary() && !self.is_absent()
    }
}

impl PendingShape {
    pub(super) fn build(self) -> BuiltShape {
        let Self { entry, shape } = self;
        let mut warnings = WarningList::default();
        let objects = shape::objects(shape, entry.id, entry.media, &mut warnings);
        let prepared = |object: SceneObject| {
            let mut object = match entry.solid {
                Some(solid) => object.bounding(solid),
                None => object,
            };
            object.passable = entry.passable;
            object.set_detail(entry.has_detail);
            object.alpha.clone_from(&entry.alpha);
            object
        };
        let objects = objects.map(|objects| objects.into_iter().map(prepared).collect());
        BuiltShape { entry, objects, warnings }
    }
}
