//! The stack of a traversal.

use std::mem::MaybeUninit;

/// A stack of fixed capacity that is not cleared when it is created: clearing would cost a tenth of a short ray.
pub(crate) struct Stack<const CAPACITY: usize> {
    entries: [MaybeUninit<u64>; CAPACITY],
    // Invariant: the first `len` entries are initialised, and `len <= CAPACITY`.
    len: usize,
}

impl<const CAPACITY: usize> Stack<CAPACITY> {
    /// An empty stack.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; CAPACITY], len: 0 }
    }

    /// Pushes `entry`. If there is no room, it is lost: `CAPACITY` needs a proof.
    #[inline(always)]
    pub(crate) fn push(&mut self, entry: u64) {
        if let Some(slot) = self.entries.get_mut(self.len) {
            slot.write(entry);
            self.len += 1;
        }
    }

    /// Removes and returns the top entry.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<u64> {
        self.len = self.len.checked_sub(1)?;
        let slot = self.entries.get(self.len)?;
        // SAFETY: the entry lay below `len`, so it was written by `push`.
        Some(unsafe { slot.assume_init() })
    }

    /// Sorts the `count` topmost entries descending, so that the smallest is popped first.
    #[inline(always)]
    pub(crate) fn sort_top(&mut self, count: usize) {
        let start = self.len.saturating_sub(count);
        let Some(slots) = self.entries.get_mut(start..self.len) else { return };
        // SAFETY: the entries below `len` were written by `push`, and `MaybeUninit<u64>` has the layout of `u64`.
        let top = unsafe { &mut *(std::ptr::from_mut(slots) as *mut [u64]) };
        for i in 1..top.len() {
            let entry = top[i];
            let mut j = i;
            while j > 0 && top[j - 1] < entry {
                top[j] = top[j - 1];
                j -= 1;
            }
            top[j] = entry;
        }
    }
}
