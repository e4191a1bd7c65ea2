//! What all readers of geometry share.

use glanz_brep::model::{CurveVector, EntityId};
use glanz_job::ResourceBudget;
use glanz_math::{DVec2, DVec3};

use super::part21::{Entity, Refusal, TapeItems};
pub(super) use crate::cad::ENTITY_COST;
use crate::cad::{CopyBudget, NoteList};

/// Entities of geometry inside one another, at most.
pub(super) const MAX_DEPTH: usize = 16;

/// A reader of points, curves and surfaces.
pub(super) struct GeometryReader {
    /// What was mended.
    pub(super) repairs: NoteList,
    budget: CopyBudget,
}

impl GeometryReader {
    /// A reader of a file of `size` bytes.
    pub(super) fn new(size: usize, budget: &ResourceBudget) -> Self {
        Self { repairs: NoteList::default(), budget: CopyBudget::new(size, budget) }
    }

    /// Takes `count` points, or other things of about that size, off the budget.
    ///
    /// # Errors
    /// Those of [`CopyBudget::spend`].
    pub(super) fn spend(&mut self, entity: EntityId, count: usize) -> Result<(), Refusal> {
        self.budget.spend(entity, count)
    }

    /// Takes `cost` for each item of a list off the budget, and returns their number.
    ///
    /// # Errors
    /// The budget is used up; then the items are not counted.
    pub(super) fn spend_items(
        &mut self,
        entity: EntityId,
        items: TapeItems<'_>,
        cost: usize,
    ) -> Result<usize, Refusal> {
        self.spend(entity, 1)?;
        let count = items.count_items();
        self.spend(entity, cost * count)?;
        Ok(count)
    }
}

/// One level of entities less, or a refusal.
pub(super) fn deeper(entity: Entity<'_>, depth: usize) -> Result<usize, Refusal> {
    depth
        .checked_sub(1)
        .ok_or_else(|| entity.refuse(format!("geometry is nested deeper than {MAX_DEPTH} levels")))
}

/// Units of the coordinates of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveUnits {
    /// Metres in space; metres or radians in the parameters of a surface.
    pub(super) coordinates: DVec3,
    /// Radians.
    pub(super) angle: f64,
}

/// A point that can be made of the coordinates of a file.
pub(super) trait FileVector: CurveVector {
    /// The point with these coordinates; a point of the plane takes two of them.
    fn from_file(coordinates: DVec3) -> Self;
}

impl FileVector for DVec2 {
    fn from_file(coordinates: DVec3) -> Self {
        coordinates.truncate()
    }
}

impl FileVector for DVec3 {
    fn from_file(coordinates: DVec3) -> Self {
        coordinates
    }
}
