//! All receivers of a scene.

use glanz_scene::description::ReceiverSide;
use glanz_scene::{HitLocation, Scene};

use super::shape_occurrence::shapes;
use super::{Receiver, ReceiverError, ReceiverRequest};

/// The receivers of a scene, with lookup by hit.
#[derive(Clone, Debug, Default)]
pub struct Receivers {
    list: Vec<Receiver>,
    /// Number of the first cell of each receiver, then the number of all cells.
    first_cells: Vec<usize>,
    /// For each surface of the scene, the receivers on it.
    by_surface: Vec<Vec<u32>>,
}

/// The cell of a receiver that a ray met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceiverHit {
    /// Number of the receiver.
    pub receiver: usize,
    /// Number of the cell among those of all receivers.
    pub cell: usize,
    /// Whether the hit is on the counted side.
    pub counts: bool,
}

impl Receivers {
    /// Creates the requested grids on the shapes of `scene`.
    ///
    /// A box or a polyhedron becomes one receiver per facet, with numbered names; the names of several shapes of one name are numbered, too.
    /// What is inside of other things, such as furniture that stands on a floor, is no part of the cells.
    ///
    /// # Errors
    /// [`ReceiverError`] for the first shape that cannot be divided.
    pub fn try_new(scene: &Scene, requests: &[ReceiverRequest]) -> Result<Self, ReceiverError> {
        let placed = scene.placed_surfaces();
        let mut receivers = Self { by_surface: vec![Vec::new(); placed.len()], ..Self::default() };
        for (number, request) in requests.iter().enumerate() {
            let found = shapes(&placed, request.shape);
            if found.is_empty() {
                return Err(ReceiverError::NoArea(request.name.clone()));
            }
            let alike = |others: &[ReceiverRequest]| others.iter().filter(|r| r.name == request.name).count();
            let number = (alike(requests) > 1).then(|| alike(&requests[..number]) + 1);
            for (facet, shape) in (1..).zip(&found) {
                let facet = (found.len() > 1).then_some(facet);
                for &back in sides(request.side) {
                    let name = full_name(request, number, facet, back);
                    let mut receiver = Receiver::try_new(request, name, shape, back)?;
                    receiver.exclude_covered(scene, &placed);
                    receivers.push(receiver);
                }
            }
        }
        Ok(receivers)
    }

    fn push(&mut self, receiver: Receiver) {
        let first = self.cell_count();
        if self.first_cells.is_empty() {
            self.first_cells.push(0);
        }
        self.first_cells.push(first + receiver.len());
        if let Some(list) = self.by_surface.get_mut(receiver.surface as usize) {
            list.push(self.list.len() as u32);
        }
        self.list.push(receiver);
    }

    /// The receivers.
    #[must_use]
    pub fn as_slice(&self) -> &[Receiver] {
        &self.list
    }

    /// Number of cells of all.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.first_cells.last().copied().unwrap_or_default()
    }

    /// Numbers of the cells of a receiver among all.
    #[must_use]
    pub fn cells_of(&self, receiver: usize) -> std::ops::Range<usize> {
        let at = |i: usize| self.first_cells.get(i).copied().unwrap_or_default();
        at(receiver)..at(receiver + 1)
    }

    /// The cell that a ray met; `None` where no light is counted.
    #[inline]
    #[must_use]
    pub fn met(&self, at: &HitLocation) -> Option<ReceiverHit> {
        let place = &at.place;
        let here = self.by_surface.get(place.surface as usize)?;
        let mut met = None;
        for &number in here {
            let receiver = &self.list[number as usize];
            if receiver.shape != at.shape || receiver.face.is_some_and(|face| face != place.face) {
                continue;
            }
            let counts = receiver.back == place.back;
            let cell = self.cells_of(number as usize).start + receiver.locate(at)?;
            met = Some(ReceiverHit { receiver: number as usize, cell, counts });
            if counts {
                break;
            }
        }
        met
    }
}

fn sides(side: ReceiverSide) -> &'static [bool] {
    match side {
        ReceiverSide::Front => &[false],
        ReceiverSide::Back => &[true],
        ReceiverSide::Both => &[false, true],
    }
}

/// The name of a receiver, numbered if others have the same name.
fn full_name(request: &ReceiverRequest, number: Option<usize>, facet: Option<usize>, back: bool) -> String {
    let mut name = request.name.clone();
    if let Some(number) = number {
        name += &format!(" {number}");
    }
    if let Some(facet) = facet {
        name += &format!(" facet {facet}");
    }
    if request.side == ReceiverSide::Both {
        name += if back { " back" } else { " front" };
    }
    name
}
