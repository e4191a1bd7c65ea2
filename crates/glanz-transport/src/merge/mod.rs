//! Merging of separately rendered films.

mod join;

use std::ops::Range;

use glanz_job::{IdentityMismatch, JobIdentity};
use glanz_sampling::exact::MAX_TERMS;

use crate::checkpoint::{Checkpoint, CheckpointHead};
use crate::edges::EdgeLayer;
use crate::film::{Film, FilmError};
use crate::identity::PictureIdentity;
use crate::ranges::SampleRanges;
use crate::sample_plan::{MissingSamples, SamplePlans};

pub use join::FilmJoin;

/// Errors of merging checkpoints. Parts are numbered from 0 in the order given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// There are no parts.
    #[error("there are no parts; at least one is needed")]
    Empty,
    /// A part of another picture than the first.
    #[error("parts 0 and {part} are of different pictures: {} is {} in part 0 and {} in part {part}", .mismatch.what, .mismatch.wanted, .mismatch.found)]
    Picture {
        /// Its number.
        part: usize,
        /// The difference.
        mismatch: IdentityMismatch,
    },
    /// A part whose samples depend on earlier ones.
    #[error("the samples of part {part} depend on earlier ones, so that it cannot be joined with others")]
    Ordered {
        /// Its number.
        part: usize,
    },
    /// Two parts with common samples.
    #[error("parts {first} and {second} both have samples {} to {}", .samples.start, .samples.end - 1)]
    Overlap {
        /// Number of the earlier part.
        first: usize,
        /// Number of the later part.
        second: usize,
        /// The first common samples.
        samples: Range<u32>,
    },
    /// A part whose film cannot be added to those before it.
    #[error("part {part} cannot be joined with part 0: {error}")]
    Film {
        /// Its number.
        part: usize,
        /// The reason.
        error: FilmError,
    },
}

/// Checks of parts that are to be joined, by all but their sums. Parts have numbers, by which errors name them.
#[derive(Clone, Debug, Default)]
pub struct MergeChecks {
    first: Option<FirstPart>,
    /// The samples of each part, with its number.
    parts: Vec<(usize, SampleRanges)>,
    /// The samples of all parts.
    taken: SampleRanges,
    plans: SamplePlans,
}

/// The part that all others are compared with.
#[derive(Clone, Debug)]
struct FirstPart {
    number: usize,
    identity: PictureIdentity,
    edges: Option<EdgeLayer>,
}

impl MergeChecks {
    /// Checks that the part belongs to those before it. Its edges are dropped: they are those of the first.
    ///
    /// # Errors
    /// [`MergeError`] if it is of another picture or edges, shares samples with another, or depends on the order of samples.
    pub fn admit(&mut self, part: usize, head: &mut CheckpointHead) -> Result<(), MergeError> {
        self.check(part, &head.identity, &head.film)?;
        head.film.drop_edges();
        Ok(())
    }

    fn check(&mut self, part: usize, identity: &PictureIdentity, film: &Film) -> Result<(), MergeError> {
        let taken = film.samples();
        let first = match &mut self.first {
            Some(first) => {
                first.check(part, identity, film)?;
                first
            }
            None => {
                let (identity, edges) = (identity.clone(), film.edges().cloned());
                self.first.insert(FirstPart { number: part, identity, edges })
            }
        };
        let shared = self.parts.iter().find_map(|(i, samples)| Some((*i, samples.overlap(taken)?)));
        if let Some((first, samples)) = shared {
            return Err(MergeError::Overlap { first, second: part, samples });
        }
        let total = self.taken.total() + taken.total();
        if total > u64::from(MAX_TERMS) {
            return Err(MergeError::Film { part, error: FilmError::Samples(total) });
        }
        self.taken.insert_all(taken).map_err(|error| MergeError::Film { part, error: error.into() })?;
        self.parts.push((part, taken.clone()));
        self.plans.add(film.plans().as_slice().iter().cloned());
        // Parts may have different plans if the sampler does not use the plan.
        let planned = &mut first.identity.samples_per_pixel;
        *planned = identity.samples_per_pixel.max(*planned);
        Ok(())
    }

    /// What is missing of the samples that are rendered in parts.
    #[must_use]
    pub fn missing_samples(&self) -> Vec<MissingSamples> {
        self.plans.missing(&self.taken)
    }
}

impl FirstPart {
    /// Checks that another part is of the same picture, and that neither depends on the order of samples.
    fn check(&self, part: usize, identity: &PictureIdentity, film: &Film) -> Result<(), MergeError> {
        for (part, format) in [(self.number, &self.identity.film), (part, film.format())] {
            if format.is_ordered() {
                return Err(MergeError::Ordered { part });
            }
        }
        identity.check(&self.identity).map_err(|mismatch| MergeError::Picture { part, mismatch })?;
        let same = film.check_layout(&self.identity.film, self.edges.as_ref());
        same.map_err(|error| MergeError::Film { part, error })
    }
}

/// The film of all `parts`, identical bit for bit to that of one run over all their samples.
///
/// # Errors
/// [`MergeError`] if the parts are of different pictures or edges, share samples, depend on the order of samples, or have more than a film can hold.
pub fn merge(parts: impl IntoIterator<Item = Checkpoint>) -> Result<Checkpoint, MergeError> {
    let mut checks = MergeChecks::default();
    let mut whole: Option<Film> = None;
    for (part, Checkpoint { identity, film }) in parts.into_iter().enumerate() {
        checks.check(part, &identity, &film)?;
        match &mut whole {
            Some(whole) => whole.merge(&film).map_err(|error| MergeError::Film { part, error })?,
            None => whole = Some(film),
        }
    }
    match (checks.first, whole) {
        (Some(FirstPart { identity, .. }), Some(film)) => Ok(Checkpoint { identity, film }),
        _ => Err(MergeError::Empty),
    }
}
