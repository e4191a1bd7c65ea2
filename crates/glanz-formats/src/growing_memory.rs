//! Memory of lists that grow while a file is read.

use glanz_job::{BudgetError, MemoryReservation, ResourceBudget};

/// Bytes that are reserved at once, at least.
const STEP: u64 = 1 << 16;

/// Memory of a budget that is reserved as it is needed, until this is dropped.
#[derive(Debug, Default)]
pub(crate) struct GrowingReservation {
    budget: ResourceBudget,
    parts: Vec<MemoryReservation>,
    /// Bytes of all parts.
    reserved: u64,
}

impl GrowingReservation {
    pub(crate) fn new(budget: &ResourceBudget) -> Self {
        Self { budget: budget.clone(), parts: Vec::new(), reserved: 0 }
    }

    /// Reserves at least `bytes` in all.
    ///
    /// # Errors
    /// The budget is used up.
    pub(crate) fn reach(&mut self, bytes: u64) -> Result<(), BudgetError> {
        if bytes <= self.reserved {
            return Ok(());
        }
        let more = (bytes - self.reserved).max(STEP).max(self.reserved / 4);
        self.parts.push(self.budget.reserve(more)?);
        self.reserved += more;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, Resource, ResourceLimits};

    use super::*;

    #[test]
    fn memory_is_reserved_in_steps_and_given_back() {
        let limits = ResourceLimits { memory: 3 * STEP, ..ResourceLimits::default() };
        let budget = ResourceBudget::new(limits, CancelFlag::default());
        let mut memory = GrowingReservation::new(&budget);
        memory.reach(1).unwrap();
        memory.reach(STEP).unwrap();
        assert_eq!(budget.used(Resource::Memory), STEP);
        memory.reach(3 * STEP).unwrap();
        assert_eq!(budget.used(Resource::Memory), 3 * STEP);
        assert!(memory.reach(3 * STEP + 1).is_err());
        drop(memory);
        assert_eq!(budget.used(Resource::Memory), 0);
    }
}
