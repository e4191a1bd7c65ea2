//! Samples that are rendered in numbered parts.

use std::ops::Range;

use glanz_job::JobPart;

use crate::ranges::SampleRanges;

/// Samples of a picture that are divided into parts, each rendered by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SamplePlan {
    samples: Range<u32>,
    parts: u32,
}

impl SamplePlan {
    /// The plan of `parts` parts of `samples`; `None` without parts, or for more parts than samples.
    #[must_use]
    pub fn try_new(samples: Range<u32>, parts: u32) -> Option<Self> {
        (JobPart::try_new(1, parts).is_some() && parts as usize <= samples.len())
            .then_some(Self { samples, parts })
    }

    /// All samples.
    #[must_use]
    pub fn samples(&self) -> Range<u32> {
        self.samples.clone()
    }

    /// The number of parts.
    #[must_use]
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// The samples of `part`, which is one of as many.
    #[must_use]
    pub fn share(&self, part: JobPart) -> Range<u32> {
        let share = part.share(self.samples.start.into()..self.samples.end.into());
        // Both lie within the range.
        share.start as u32..share.end as u32
    }

    /// What `taken` lacks of each part, without the parts of which it lacks nothing.
    #[must_use]
    pub fn missing(&self, taken: &SampleRanges) -> Vec<MissingSamples> {
        if taken.covers(&self.samples) {
            return Vec::new();
        }
        let parts = (1..=self.parts).filter_map(|number| JobPart::try_new(number, self.parts));
        let missing = parts.filter_map(|part| {
            let share = self.share(part);
            let missing = SampleRanges::from_ascending(taken.missing(share.clone()))?;
            let is_whole = missing.total() == share.len() as u64;
            (!missing.is_empty()).then_some(MissingSamples { part, samples: missing, is_whole })
        });
        missing.collect()
    }
}

/// A set of plans, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct SamplePlans(Vec<SamplePlan>);

impl SamplePlans {
    pub(crate) fn as_slice(&self) -> &[SamplePlan] {
        &self.0
    }

    pub(crate) fn add(&mut self, plans: impl IntoIterator<Item = SamplePlan>) {
        self.0.extend(plans);
        self.0.sort_by_key(|SamplePlan { samples, parts }| (samples.start, samples.end, *parts));
        self.0.dedup();
    }

    /// Removes the plans of which `taken` has all samples.
    pub(crate) fn drop_finished(&mut self, taken: &SampleRanges) {
        self.0.retain(|plan| !taken.covers(&plan.samples));
    }

    /// What `taken` lacks, every sample once.
    pub(crate) fn missing(&self, taken: &SampleRanges) -> Vec<MissingSamples> {
        let mut missing = Vec::new();
        let mut named = taken.clone();
        for plan in &self.0 {
            let parts = plan.missing(&named);
            // What is missing is new.
            parts.iter().for_each(|part| named.insert_all(&part.samples).unwrap_or(()));
            missing.extend(parts);
        }
        missing
    }
}

/// Samples of a part that were planned but not taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingSamples {
    /// The part.
    pub part: JobPart,
    /// The samples.
    pub samples: SampleRanges,
    /// Whether these are all samples of the part.
    pub is_whole: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(ranges: &[Range<u32>]) -> SampleRanges {
        SampleRanges::from_ascending(ranges.to_vec()).unwrap()
    }

    #[test]
    fn missing_samples_are_named_by_their_parts() {
        // 256 samples in 8 parts: 32 each, from 10 on.
        let plan = SamplePlan::try_new(10..266, 8).unwrap();
        let missing = plan.missing(&taken(&[0..80, 106..298]));
        let part = |number| JobPart::try_new(number, 8).unwrap();
        let third = MissingSamples { part: part(3), samples: SampleRanges::from(80..106), is_whole: false };
        assert_eq!(missing, [third]);
        let missing = plan.missing(&taken(&[10..74, 106..200, 202..266]));
        let third = MissingSamples { part: part(3), samples: SampleRanges::from(74..106), is_whole: true };
        let sixth = MissingSamples { part: part(6), samples: SampleRanges::from(200..202), is_whole: false };
        assert_eq!(missing, [third, sixth]);
        assert_eq!(plan.missing(&SampleRanges::from(10..266)), []);
        assert_eq!(plan.missing(&SampleRanges::default()).len(), 8);
    }

    #[test]
    fn plans_take_no_time_of_their_number_times_that_of_the_ranges() {
        // Of the numbers 0 to 2 000 000, every second one; the plans overlap nearly all of them.
        let count = 1_000_000;
        let taken = taken(&(0..count).map(|i| 2 * i..2 * i + 1).collect::<Vec<_>>());
        let mut plans = SamplePlans::default();
        plans.add((0..count).rev().filter_map(|i| SamplePlan::try_new(i..2 * count, 1)));
        plans.add(SamplePlan::try_new(4..5, 1));
        assert_eq!(plans.as_slice().len(), count as usize + 1);
        plans.drop_finished(&taken);
        assert_eq!(plans.as_slice().len(), count as usize);
    }

    #[test]
    fn plans_have_a_sample_for_every_part() {
        assert!(SamplePlan::try_new(3..7, 4).is_some() && SamplePlan::try_new(3..4, 1).is_some());
        for (samples, parts) in [(3..7, 5), (3..7, 0), (3..3, 1)] {
            assert_eq!(SamplePlan::try_new(samples, parts), None);
        }
    }
}
