//! Parts into which a long job is split.

use std::error::Error;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Largest number of parts of a job: lists of missing parts stay small.
pub const MAX_PARTS: u32 = 1 << 20;

/// Part K of N of a job, of samples, particles or texels: written `K/N`, with K from 1 to N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobPart {
    number: u32,
    count: u32,
}

impl JobPart {
    /// Part `number` of `count`; `None` unless `number` is from 1 to `count`, and `count` at most [`MAX_PARTS`].
    #[must_use]
    pub fn try_new(number: u32, count: u32) -> Option<Self> {
        (count <= MAX_PARTS && (1..=count).contains(&number)).then_some(Self { number, count })
    }

    /// Its number, from 1.
    #[must_use]
    pub fn number(self) -> u32 {
        self.number
    }

    /// The number of parts.
    #[must_use]
    pub fn count(self) -> u32 {
        self.count
    }

    /// Its share of `whole`. The shares of all parts follow one another, cover `whole`, and differ in length by one at most; with more
    /// parts than numbers some are empty.
    #[must_use]
    pub fn share(self, whole: Range<u64>) -> Range<u64> {
        let length = u128::from(whole.end.saturating_sub(whole.start));
        let at = |part: u32| whole.start + (length * u128::from(part) / u128::from(self.count)) as u64;
        at(self.number - 1)..at(self.number)
    }
}

impl fmt::Display for JobPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

/// A text that is no part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobPartError;

impl fmt::Display for JobPartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a part is written K/N with K from 1 to N and N up to 1 048 576, such as 3/16")
    }
}

impl Error for JobPartError {}

impl FromStr for JobPart {
    type Err = JobPartError;

    fn from_str(text: &str) -> Result<Self, JobPartError> {
        let (number, count) = text.split_once('/').ok_or(JobPartError)?;
        let parse = |text: &str| text.parse().map_err(|_| JobPartError);
        Self::try_new(parse(number)?, parse(count)?).ok_or(JobPartError)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_one_another_and_cover_the_whole() {
        for whole in [0..0, 5..6, 3..19, 0..1000, 7..u64::MAX] {
            for count in [1, 2, 7, 16, 1024] {
                let shares: Vec<Range<u64>> =
                    (1..=count).map(|k| JobPart::try_new(k, count).unwrap().share(whole.clone())).collect();
                assert_eq!((shares[0].start, shares[count as usize - 1].end), (whole.start, whole.end));
                assert!(shares.windows(2).all(|pair| pair[0].end == pair[1].start));
                let lengths = || shares.iter().map(|share| share.end - share.start);
                assert!(lengths().max().unwrap() - lengths().min().unwrap() <= 1, "{whole:?} {count}");
            }
        }
    }

    #[test]
    fn parts_are_read_and_written_with_numbers_from_one() {
        assert_eq!("3/16".parse::<JobPart>().unwrap().to_string(), "3/16");
        assert_eq!(JobPart::try_new(1, 1).unwrap().share(2..9), 2..9);
        for text in ["", "3", "0/4", "5/4", "-1/4", "1/0", "1/2/3", " 1/2", "1/1048577", "1/4294967296"] {
            assert_eq!(text.parse::<JobPart>(), Err(JobPartError), "{text}");
        }
    }
}
