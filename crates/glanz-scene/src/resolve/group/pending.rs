//! Shapes of a group before and after their surfaces are built.

use std::sync::Arc;

use glanz_geometry::Surface;
use glanz_job::ResourceBudget;

use crate::alpha::AlphaTest;
use crate::description::{EmissionDescription, Location, ShapeDescription};
use crate::error::SceneError;
use crate::medium::MediumInterface;
use crate::object::SceneObject;
use crate::receiver::NamedReceiver;
use crate::resolve::{WarningList, shape, spend};

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

/// Bytes of an object with its surface and its part of the hierarchy over all objects.
fn object_bytes(object: &SceneObject) -> u64 {
    let surface = match object.surface() {
        Surface::Mesh(mesh) => mesh.bytes(),
        Surface::Freeform(surface) => surface.bytes(),
        _ => 0,
    };
    (size_of_val(object) + HIERARCHY_PER_OBJECT + surface) as u64
}

/// Bytes per object of a hierarchy over objects.
const HIERARCHY_PER_OBJECT: usize = 96;

impl PendingShape {
    /// Builds the shape and takes its objects off the budget.
    pub(super) fn build_within(self, budget: &ResourceBudget) -> Result<BuiltShape, SceneError> {
        let location = self.entry.location;
        budget.check().map_err(|end| SceneError { location, kind: end.into() })?;
        // What does not fit is not built; afterwards, what was built counts instead.
        let reserved = budget.reserve(shape::least_bytes(&self.shape.geometry));
        let reserved = reserved.map_err(|end| SceneError { location, kind: end.into() })?;
        let built = self.build();
        drop(reserved);
        let objects = built.objects.as_deref().unwrap_or_default();
        let bytes: u64 = objects.iter().map(object_bytes).sum();
        spend(budget, objects.len() as u64, bytes, location)?;
        Ok(built)
    }

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
