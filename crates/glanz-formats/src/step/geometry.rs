//! What all readers of geometry share.

use glanz_brep::model::{CurveVector, EntityId};
use glanz_math::{DVec2, DVec3};

use super::part21::{Entity, Refusal, TapeItems};
use super::report::NoteList;

/// Entities of geometry inside one another, at most.
pub(super) const MAX_DEPTH: usize = 16;

/// A reader of points, curves and surfaces.
///
/// A file may use one curve many times, in each of which it is copied. A budget of copies keeps memory in proportion to the file: no
/// file reaches it whose curves are used once or twice.
pub(super) struct GeometryReader {
    /// What was mended.
    pub(super) repairs: NoteList,
    budget: usize,
}

impl GeometryReader {
    /// A reader of a file of `size` bytes.
    pub(super) fn new(size: usize) -> Self {
        Self { repairs: NoteList::default(), budget: size.saturating_mul(2).saturating_add(1000) }
    }

    /// Takes `count` points, or other things of about that size, off the budget. Each is at least one reference in the file, such as
    /// `#1,`.
    ///
    /// # Errors
    /// The budget is used up.
    pub(super) fn spend(&mut self, entity: EntityId, count: usize) -> Result<(), Refusal> {
        let left = self.budget.checked_sub(count);
        // What fails uses it up, so that no list is counted again and again.
        self.budget = left.unwrap_or_default();
        left.map(drop).ok_or_else(|| Refusal::new(entity, "the file repeats its geometry too often"))
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

/// The size of an edge, a face or a surface, in points; in the file each has more bytes.
pub(super) const ENTITY_COST: usize = 8;

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
