//! Lengths of training passes.

use std::fmt;
use std::num::NonZeroU16;
use std::str::FromStr;

/// Samples per pixel of the training passes of a guide, such as 1-2-4. After the last pass the guide no longer changes.
///
/// # Source
/// Document 003 section 3.5 (distributions of samples).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PassLengths([Option<NonZeroU16>; Self::MOST]);

impl PassLengths {
    /// Largest number of passes.
    pub const MOST: usize = 8;
    /// Largest number of samples per pixel of a pass.
    pub const LONGEST: u32 = 4096;

    /// Passes of these lengths: 1 to [`PassLengths::MOST`] of them, each 1 to [`PassLengths::LONGEST`]; `None` for others.
    #[must_use]
    pub fn new(lengths: &[u32]) -> Option<Self> {
        let mut list = [None; Self::MOST];
        for (i, &length) in lengths.iter().enumerate() {
            let fine = u16::try_from(length).ok().filter(|_| length <= Self::LONGEST);
            *list.get_mut(i)? = Some(NonZeroU16::new(fine?)?);
        }
        list[0].map(|_| Self(list))
    }

    /// The lengths in their order.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.0.iter().flatten().map(|length| u32::from(length.get()))
    }

    /// Number of passes.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.iter().count() as u32
    }
}

/// A text that is not a list of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "samples per pixel of 1 to {most} passes, each 1 to {longest}, with - between them, such as 1-2-4",
    most = PassLengths::MOST,
    longest = PassLengths::LONGEST
)]
pub struct PassLengthsError;

impl FromStr for PassLengths {
    type Err = PassLengthsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let lengths: Option<Vec<u32>> =
            text.split('-').take(Self::MOST + 1).map(|length| length.parse().ok()).collect();
        lengths.and_then(|lengths| Self::new(&lengths)).ok_or(PassLengthsError)
    }
}

impl fmt::Display for PassLengths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, length) in self.iter().enumerate() {
            let between = if i == 0 { "" } else { "-" };
            write!(f, "{between}{length}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_back() {
        for text in ["1", "1-2-4", "4096-1-1-1-1-1-1-7"] {
            assert_eq!(text.parse::<PassLengths>().unwrap().to_string(), text);
        }
        let lengths = PassLengths::new(&[3, 6, 12]).unwrap();
        assert_eq!((lengths.to_string(), lengths.count()), ("3-6-12".to_owned(), 3));
        for text in ["", "-", "1-", "0", "1-0-2", "4097", "1--2", "1-2-4-8-16-32-64-128-256", "one"] {
            assert_eq!(text.parse::<PassLengths>(), Err(PassLengthsError), "{text}");
        }
    }
}
