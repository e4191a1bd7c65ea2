//! A bound on the memory of pictures.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glanz_light::Pixels;

/// Values of pictures that may be read: for each byte of a scene or model and its files, and in any case, 1 GiB. A picture may be used with several contents,
/// or by several parts of a file.
const VALUES_PER_BYTE: usize = 256;
const FREE_VALUES: usize = 1 << 28;

/// Number of values of pictures that a scene or a model may still read.
#[derive(Debug)]
pub(crate) struct PictureBudget {
    values: usize,
    /// Paths of files that count, with links resolved.
    counted: BTreeSet<PathBuf>,
}

impl Default for PictureBudget {
    fn default() -> Self {
        Self { values: FREE_VALUES, counted: BTreeSet::new() }
    }
}

impl PictureBudget {
    /// A budget of so many values.
    #[cfg(test)]
    pub(crate) fn of_values(values: usize) -> Self {
        Self { values, counted: BTreeSet::new() }
    }

    /// Allows pictures for so many bytes.
    pub(crate) fn allow(&mut self, bytes: usize) {
        self.values = self.values.saturating_add(bytes.saturating_mul(VALUES_PER_BYTE));
    }

    /// Allows pictures for a file of so many bytes, the first time only.
    pub(crate) fn allow_file(&mut self, path: &Path, bytes: usize) {
        if self.counted.insert(std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())) {
            self.allow(bytes);
        }
    }

    /// Takes the values of a picture.
    ///
    /// # Errors
    /// The problem as a sentence, if too few are left.
    pub(crate) fn take(&mut self, pixels: &Pixels) -> Result<(), String> {
        let values = pixels.len().saturating_mul(pixels.channels().len());
        let left = self.values.checked_sub(values);
        self.values = left.ok_or(
            "the pictures have too many pixels for the size of the files; use smaller or fewer pictures",
        )?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_counts_once_and_pictures_by_their_values() {
        let mut budget = PictureBudget::of_values(0);
        let pixels = Pixels::try_from_rgb(16, 16, &[[0.5; 3]; 256]).unwrap();
        budget.allow_file(Path::new("a.png"), 3);
        budget.allow_file(Path::new("a.png"), 3);
        assert_eq!(budget.take(&pixels), Ok(()));
        assert!(budget.take(&pixels).unwrap_err().contains("too many pixels"));
        budget.allow_file(Path::new("b.png"), 3);
        assert_eq!(budget.take(&pixels), Ok(()));
    }
}
