//! Sets of numbers: the samples of every pixel, the particles of a calculation.

use std::ops::Range;

/// Two sets of samples that are not disjoint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("samples {} to {} occur twice", .0.start, .0.end - 1)]
pub struct OverlapError(pub Range<u32>);

/// A set of numbers as ascending ranges that neither touch nor overlap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberRanges<T>(Vec<Range<T>>);

/// A set of sample numbers.
pub type SampleRanges = NumberRanges<u32>;

/// A set of particle numbers.
pub type ParticleRanges = NumberRanges<u64>;

impl<T> Default for NumberRanges<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl SampleRanges {
    /// Adds `range`.
    ///
    /// # Errors
    /// [`OverlapError`] with the first samples that are in the set already; the set is then unchanged.
    pub fn insert(&mut self, range: Range<u32>) -> Result<(), OverlapError> {
        self.try_insert(range).map_err(OverlapError)
    }

    /// Adds the samples of another set.
    ///
    /// # Errors
    /// [`OverlapError`] with the first samples that are in both; the set is then unchanged.
    pub fn insert_all(&mut self, other: &Self) -> Result<(), OverlapError> {
        match self.overlap(other) {
            Some(common) => Err(OverlapError(common)),
            None => other.0.iter().try_for_each(|range| self.insert(range.clone())),
        }
    }
}

impl<T: Copy + Ord + Into<u64>> NumberRanges<T> {
    /// The set of `ranges`, if they have the form of [`NumberRanges::as_slice`]: not empty, ascending, with gaps.
    #[must_use]
    pub fn from_ascending(ranges: Vec<Range<T>>) -> Option<Self> {
        let fine = ranges.iter().all(|r| r.start < r.end) && ranges.windows(2).all(|w| w[0].end < w[1].start);
        fine.then_some(Self(ranges))
    }

    /// Adds `range`.
    ///
    /// # Errors
    /// The first numbers that are in the set already; the set is then unchanged.
    pub fn try_insert(&mut self, range: Range<T>) -> Result<(), Range<T>> {
        if range.is_empty() {
            return Ok(());
        }
        if let Some(old) = self.0.iter().find(|old| old.start < range.end && range.start < old.end) {
            return Err(old.start.max(range.start)..old.end.min(range.end));
        }
        let at = self.0.partition_point(|old| old.start < range.start);
        self.0.insert(at, range);
        self.0.dedup_by(|next, kept| {
            let touching = kept.end == next.start;
            if touching {
                kept.end = next.end;
            }
            touching
        });
        Ok(())
    }

    /// The first numbers in both sets.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> Option<Range<T>> {
        self.0.iter().find_map(|a| {
            let b = other.0.iter().find(|b| b.start < a.end && a.start < b.end)?;
            Some(a.start.max(b.start)..a.end.min(b.end))
        })
    }

    /// The ranges, ascending.
    #[must_use]
    pub fn as_slice(&self) -> &[Range<T>] {
        &self.0
    }

    /// How many numbers are in the set.
    #[must_use]
    pub fn total(&self) -> u64 {
        let length = |range: &Range<T>| -> u64 { range.end.into() - range.start.into() };
        self.0.iter().map(length).sum()
    }

    /// Whether the set is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether the set has all of `wanted`.
    #[must_use]
    pub fn covers(&self, wanted: &Range<T>) -> bool {
        let at = self.0.partition_point(|range| range.end < wanted.end);
        wanted.is_empty() || self.0.get(at).is_some_and(|range| range.start <= wanted.start)
    }

    /// The parts of `wanted` that are not in the set, ascending.
    #[must_use]
    pub fn missing(&self, wanted: Range<T>) -> Vec<Range<T>> {
        let mut gaps = Vec::new();
        let mut from = wanted.start;
        let first = self.0.partition_point(|range| range.end <= wanted.start);
        for done in self.0.iter().skip(first).take_while(|range| range.start < wanted.end) {
            let gap = from..done.start.min(wanted.end);
            if !gap.is_empty() {
                gaps.push(gap);
            }
            from = from.max(done.end);
        }
        if from < wanted.end {
            gaps.push(from..wanted.end);
        }
        gaps
    }
}

impl From<Range<u32>> for SampleRanges {
    fn from(range: Range<u32>) -> Self {
        Self(if range.is_empty() { Vec::new() } else { vec![range] })
    }
}

impl<T: std::fmt::Display> std::fmt::Display for NumberRanges<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return f.write_str("none");
        }
        for (i, range) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{}..{}", range.start, range.end)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn touching_ranges_become_one() {
        let mut set = SampleRanges::default();
        set.insert(10..20).unwrap();
        set.insert(0..4).unwrap();
        assert_eq!(set.as_slice(), [0..4, 10..20]);
        set.insert(4..10).unwrap();
        assert_eq!(set.as_slice(), std::slice::from_ref(&(0..20)));
        assert_eq!(set.to_string(), "0..20");
    }

    #[test]
    fn overlap_is_refused_with_its_numbers() {
        let mut set = SampleRanges::default();
        set.insert(8..16).unwrap();
        assert_eq!(set.insert(4..12), Err(OverlapError(8..12)));
        assert_eq!(OverlapError(8..12).to_string(), "samples 8 to 11 occur twice");
        assert_eq!(set.as_slice(), std::slice::from_ref(&(8..16)));
    }

    proptest! {
        #[test]
        fn set_behaves_like_a_set_of_numbers(
            parts in prop::collection::vec((0_u32..60, 0_u32..9), 0..12), wanted in (0_u32..60, 0_u32..40),
        ) {
            let mut set = SampleRanges::default();
            let mut model = [false; 100];
            for (start, length) in parts {
                let range = start..start + length;
                let clash = range.clone().any(|i| model[i as usize]);
                prop_assert_eq!(set.insert(range.clone()).is_err(), clash);
                if !clash {
                    range.for_each(|i| model[i as usize] = true);
                }
            }
            prop_assert_eq!(set.total(), model.iter().filter(|&&m| m).count() as u64);
            prop_assert!(set.as_slice().windows(2).all(|w| w[0].end < w[1].start));
            let wanted = wanted.0..wanted.0 + wanted.1;
            let missing: Vec<u32> = set.missing(wanted.clone()).into_iter().flatten().collect();
            prop_assert_eq!(set.covers(&wanted), missing.is_empty());
            let expected: Vec<u32> = wanted.filter(|&i| !model[i as usize]).collect();
            prop_assert_eq!(missing, expected);
        }
    }
}
