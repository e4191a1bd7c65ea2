//! Mutants of one target, one after the other.

use std::collections::HashSet;
use std::time::Duration;

use crate::corpus;
use crate::measurement::Measurement;
use crate::mutation::{RandomStream, mutant};
use crate::targets::Target;

/// Largest number of files that are mutated.
const POOL: usize = 1000;

/// Largest file that is added to the seeds, bytes, if no seed is half as large: small files take less time.
const LARGEST: usize = 1 << 14;

/// Mutants of the right files of a target, of its corpus, and of mutants whose outcome was new.
///
/// That takes the place of coverage: a file that gets to another message has come further. It needs no special compiler, and the same seed gives the same files.
#[derive(Debug)]
pub struct Campaign {
    target: &'static Target,
    pool: Vec<Vec<u8>>,
    /// Largest file that is added to the pool, bytes.
    largest: usize,
    /// Number of files at the beginning of the pool that were there at first.
    seeds: usize,
    classes: HashSet<u64>,
    random: RandomStream,
    /// Figures so far.
    pub figures: CampaignFigures,
}

/// What a campaign found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CampaignFigures {
    /// Number of mutants.
    pub cases: u64,
    /// Number of mutants that were read.
    pub read: u64,
    /// Number of different outcomes.
    pub classes: u64,
    /// Longest time.
    pub slowest: Duration,
    /// Largest peak of memory, bytes.
    pub peak: usize,
    /// Largest peak per byte of the file, above one MiB, bytes.
    pub peak_factor: f64,
}

impl CampaignFigures {
    /// Adds the figures of another campaign.
    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.read += other.read;
        // They have most of their outcomes in common.
        self.classes = self.classes.max(other.classes);
        self.slowest = self.slowest.max(other.slowest);
        self.peak = self.peak.max(other.peak);
        self.peak_factor = self.peak_factor.max(other.peak_factor);
    }
}

impl Campaign {
    /// The campaign of a seed.
    #[must_use]
    pub fn new(target: &'static Target, seed: u64) -> Self {
        let mut pool = (target.seeds)();
        let largest = LARGEST.max(2 * pool.iter().map(Vec::len).max().unwrap_or_default());
        let entries = corpus::entries(target.name).into_iter();
        let files = entries.filter_map(|entry| std::fs::read(entry.file).ok());
        pool.extend(files.filter(|bytes| bytes.len() <= largest));
        let seeds = pool.len();
        let (classes, figures) = Default::default();
        Self { target, pool, largest, seeds, classes, random: RandomStream::new(seed), figures }
    }

    /// The next mutant.
    pub fn next_mutant(&mut self) -> Vec<u8> {
        // Half of them from the first files, which are whole.
        let count = if self.random.below(2) == 0 { self.seeds } else { self.pool.len() };
        let pool = self.pool.get(..count).unwrap_or_default();
        mutant(pool, self.target.syntax, &mut self.random)
    }

    /// Adds what reading a mutant gave. Returns whether its outcome is new.
    pub fn add(&mut self, bytes: &[u8], measurement: &Measurement) -> bool {
        let Measurement { outcome, time, peak, .. } = measurement;
        let figures = &mut self.figures;
        figures.cases += 1;
        figures.slowest = figures.slowest.max(*time);
        figures.peak = figures.peak.max(*peak);
        let factor = peak.saturating_sub(1 << 20) as f64 / bytes.len().max(1) as f64;
        figures.peak_factor = figures.peak_factor.max(factor);
        let Some(outcome) = outcome else { return false };
        figures.read += u64::from(outcome.is_read());
        let is_new = self.classes.insert(outcome.class());
        figures.classes += u64::from(is_new);
        if is_new && self.pool.len() < POOL && bytes.len() <= self.largest {
            self.pool.push(bytes.to_vec());
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::targets::{ReadOutcome, target};

    #[test]
    fn mutants_with_new_outcomes_are_mutated_further() {
        let mut campaign = Campaign::new(target("mtl").expect("a target"), 5);
        let seeds = campaign.pool.len();
        let measurement = |text: &str| Measurement {
            outcome: Some(ReadOutcome::Refused(text.to_owned())),
            time: Duration::ZERO,
            peak: 0,
            fault: None,
        };
        assert!(campaign.add(b"one", &measurement("line 1: no number")));
        assert!(!campaign.add(b"two", &measurement("line 2: no number")));
        assert!(campaign.add(b"three", &measurement("line 2: no name")));
        assert_eq!(campaign.pool.len(), seeds + 2);
        assert_eq!((campaign.figures.cases, campaign.figures.read, campaign.figures.classes), (3, 0, 2));
    }
}
