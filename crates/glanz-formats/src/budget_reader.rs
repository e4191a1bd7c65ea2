//! The bytes of a file for a decoder, which ends with its budget.

use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

use glanz_job::ResourceBudget;

/// Largest number of bytes that are given at once: deflate makes at most 4 MB of them.
const STEP: usize = 4096;

/// A reader of bytes in memory that fails when the budget does.
pub(crate) struct BudgetReader<'a> {
    bytes: Cursor<&'a [u8]>,
    budget: &'a ResourceBudget,
}

impl<'a> BudgetReader<'a> {
    pub(crate) fn new(bytes: &'a [u8], budget: &'a ResourceBudget) -> Self {
        Self { bytes: Cursor::new(bytes), budget }
    }
}

impl Read for BudgetReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.budget.check().map_err(io::Error::other)?;
        let length = buffer.len().min(STEP);
        self.bytes.read(buffer.get_mut(..length).unwrap_or_default())
    }
}

impl BufRead for BudgetReader<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.budget.check().map_err(io::Error::other)?;
        let rest = self.bytes.fill_buf()?;
        Ok(rest.get(..rest.len().min(STEP)).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.bytes.consume(amount);
    }
}

impl Seek for BudgetReader<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}
