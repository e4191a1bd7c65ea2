//! Merging of separately rendered films.

use std::ops::Range;

use glanz_job::{IdentityMismatch, JobIdentity};

use crate::checkpoint::Checkpoint;
use crate::film::{Film, FilmError};
use crate::ranges::SampleRanges;

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

/// The film of all `parts`, identical bit for bit to that of one run over all their samples.
///
/// Parts are taken one by one, so that an iterator that reads files needs memory for two of them.
///
/// # Errors
/// [`MergeError`] if the parts are of different pictures or edges, share samples, depend on the order of samples, or have more than a film can hold.
pub fn merge(parts: impl IntoIterator<Item = Checkpoint>) -> Result<Checkpoint, MergeError> {
    let mut parts = parts.into_iter();
    let mut whole = parts.next().ok_or(MergeError::Empty)?;
    let mut taken: Vec<SampleRanges> = vec![whole.film.samples().clone()];
    let check_order = |part, film: &Film| {
        if film.format().is_ordered() { Err(MergeError::Ordered { part }) } else { Ok(()) }
    };
    for (part, next) in (1..).zip(parts) {
        check_order(0, &whole.film)?;
        check_order(part, &next.film)?;
        next.identity.check(&whole.identity).map_err(|mismatch| MergeError::Picture { part, mismatch })?;
        let shared = taken.iter().enumerate().find_map(|(i, t)| Some((i, t.overlap(next.film.samples())?)));
        if let Some((first, samples)) = shared {
            return Err(MergeError::Overlap { first, second: part, samples });
        }
        whole.film.merge(&next.film).map_err(|error| MergeError::Film { part, error })?;
        // Parts may have different plans if the sampler does not use the plan.
        whole.identity.samples_per_pixel =
            whole.identity.samples_per_pixel.max(next.identity.samples_per_pixel);
        taken.push(next.film.samples().clone());
    }
    Ok(whole)
}
