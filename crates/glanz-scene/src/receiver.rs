//! Shapes on which incident light is measured.

use crate::description::{Location, MAX_RECEIVER_CELLS, ReceiverDescription, ReceiverSide, ZoneKind};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::Scene;

/// A shape that the scene declares as a receiver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedReceiver {
    name: String,
    shape: u32,
    cells: Option<[u32; 2]>,
    side: ReceiverSide,
    zone: Option<ZoneKind>,
    location: Option<Location>,
}

impl NamedReceiver {
    /// `shape`: its number in the order of the scene file. `is_opaque`: whether it stops all rays; others would measure what they stop, not what arrives.
    pub(crate) fn try_new(
        description: ReceiverDescription,
        shape: u32,
        is_opaque: bool,
    ) -> Result<Self, SceneError> {
        let ReceiverDescription { name, cells, side, zone, location } = description;
        let error = |kind| SceneError { location, kind };
        if name.is_empty() {
            let (what, value, range) = ("receiver: name", "empty".to_owned(), "a text");
            return Err(error(SceneErrorKind::Range { what, value, range }));
        }
        if !is_opaque {
            let (what, value) = ("receiver: opacity", "not 1".to_owned());
            let range = "1, for light that passes is not measured; remove the opacity, or use the material \"interface\"";
            return Err(error(SceneErrorKind::Range { what, value, range }));
        }
        if let Some([u, v]) = cells
            && !(u.min(v) >= 1 && u.max(v) <= MAX_RECEIVER_CELLS)
        {
            let value = format!("{u} x {v}");
            let (what, range) = ("receiver: number of cells", "1 to 4096 along each side");
            return Err(error(SceneErrorKind::Range { what, value, range }));
        }
        Ok(Self { name, shape, cells, side, zone, location })
    }

    /// Its name, not empty; several receivers may have the same.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of the shape: [`Interaction::id`](crate::Interaction::id) of its hits and
    /// [`PlacedSurface::shape`](crate::PlacedSurface::shape) of its faces.
    #[must_use]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// Numbers of cells along u and v, 1 to [`MAX_RECEIVER_CELLS`] each, if the scene sets them.
    #[must_use]
    pub fn cells(&self) -> Option<[u32; 2]> {
        self.cells
    }

    /// The side on which light counts.
    #[must_use]
    pub fn side(&self) -> ReceiverSide {
        self.side
    }

    /// The part of a planned room that it is, if it is one.
    #[must_use]
    pub fn zone(&self) -> Option<ZoneKind> {
        self.zone
    }

    /// Its place in the input.
    #[must_use]
    pub fn location(&self) -> Option<Location> {
        self.location
    }
}

impl Scene {
    /// The receivers that the scene declares, by ascending number of the shape.
    ///
    /// Shapes that were left out, such as meshes without area, are not in it. A shape of an interface material stays in the scene if it is a
    /// receiver.
    #[must_use]
    pub fn receivers(&self) -> &[NamedReceiver] {
        &self.receivers
    }
}
