//! A limit for the copies of geometry.

use glanz_brep::model::EntityId;
use glanz_job::{Resource, ResourceBudget};

use super::refusal::Refusal;

/// Points that may still be made of a file.
///
/// A file may use one curve many times, in each of which it is copied. A budget of copies keeps memory in proportion to the file: no
/// file reaches it whose curves are used once or twice.
#[derive(Debug)]
pub(crate) struct CopyBudget {
    left: usize,
    /// What reading may use, whatever the size of the file.
    resources: ResourceBudget,
}

/// Bytes of a point, with the lists that have it.
const POINT: u64 = 48;

/// The size of an edge, a face or a surface, in points; in the file each has more bytes.
pub(crate) const ENTITY_COST: usize = 8;

impl CopyBudget {
    /// The budget of a file of `size` bytes.
    pub(crate) fn new(size: usize, resources: &ResourceBudget) -> Self {
        Self { left: size.saturating_mul(2).saturating_add(1000), resources: resources.clone() }
    }

    /// Takes `count` points, or other things of about that size, off the budget. Each is at least one reference in the file, such as
    /// `#1,`.
    ///
    /// # Errors
    /// This budget or that of reading is used up.
    pub(crate) fn spend(&mut self, entity: EntityId, count: usize) -> Result<(), Refusal> {
        let left = self.left.checked_sub(count);
        // What fails uses it up, so that no list is counted again and again.
        self.left = left.unwrap_or_default();
        left.ok_or_else(|| Refusal::new(entity, "the file repeats its geometry too often"))?;
        let bytes = POINT.saturating_mul(count as u64);
        let spent = self.resources.check_now().and_then(|()| self.resources.spend(Resource::Memory, bytes));
        spent.map_err(|end| Refusal::new(entity, end.to_string()))
    }
}
