//! A bound on the memory of pictures.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glanz_light::Pixels;

/// Values of pictures that may be read: for each byte of a scene or model and its files, and in any case, 1 GiB. A picture may be used with several contents,
/// or by several parts of a file. A picture of one channel takes three times as much again in the scene.
const VALUES_PER_BYTE: usize = 256;
const FREE_VALUES: usize = 1 << 28;

/// The problem of a picture beyond the bound, as a sentence.
const TOO_MANY_PICTURES: &str =
    "the pictures have too many pixels for the size of the files; use smaller or fewer pictures";

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

    /// Decodes a picture of so many bytes and takes its values.
    ///
    /// What cannot be decoded, or is too large, takes the share of its bytes, so that a file that names it often does not have it decoded each time: that takes time, and
    /// memory for a while.
    ///
    /// # Errors
    /// The problem as a sentence: that of `decode`, or that too few values are left.
    pub(crate) fn decode(
        &mut self,
        bytes: usize,
        decode: impl FnOnce() -> Result<Pixels, String>,
    ) -> Result<Pixels, String> {
        if self.values == 0 {
            return Err(TOO_MANY_PICTURES.to_owned());
        }
        let decoded = decode().and_then(|pixels| {
            let values = pixels.len().saturating_mul(pixels.channels().len());
            self.values = self.values.checked_sub(values).ok_or(TOO_MANY_PICTURES)?;
            Ok(pixels)
        });
        if decoded.is_err() {
            self.values = self.values.saturating_sub(bytes.saturating_mul(VALUES_PER_BYTE));
        }
        decoded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_counts_once_and_pictures_by_their_values() {
        let mut budget = PictureBudget::of_values(1);
        let mut decode = |file: &str| {
            budget.allow_file(Path::new(file), 3);
            budget.decode(3, || Ok(Pixels::try_from_rgb(16, 16, &[[0.5; 3]; 256]).unwrap())).map(|_| ())
        };
        assert_eq!(decode("a.png"), Ok(()));
        assert!(decode("a.png").unwrap_err().contains("too many pixels"));
        assert_eq!(decode("b.png"), Ok(()));
    }
}
