//! Films of one picture, added.

use std::ops::Range;

use glanz_sampling::exact::MAX_TERMS;
use rayon::prelude::*;

use super::{Film, FilmError, FilmFormat};
use crate::edges::EdgeLayer;
use crate::ranges::OverlapError;
use crate::word_merge::add_words;

/// Number of pixels that a thread adds at a time.
const PIXELS: usize = 1024;

/// Number of words that are added at a time: 64 MiB.
const BLOCK: usize = 1 << 23;

impl Film {
    /// Adds the samples of another film of the same picture.
    ///
    /// # Errors
    /// [`FilmError::Layout`] if the formats or the edges differ, [`FilmError::Overlap`] if a sample is in both, and
    /// [`FilmError::Samples`] if there would be too many, [`FilmError::Ordered`] for films with passes or a noise level; after these errors this film is
    /// unchanged. After [`FilmError::File`], of films in files, it is of no use.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        self.check_layout(&other.format, other.edges())?;
        if self.format.is_ordered() {
            return Err(FilmError::Ordered);
        }
        self.check_samples(other)?;
        let together = self.sums.limit().map_or(BLOCK, |limit| limit.clamp(1, BLOCK));
        for block in self.blocks(together) {
            let first = block.start;
            self.add_sums(first, &other.sums.get(block)?, |word| *word)?;
        }
        self.take_samples(other)
    }

    /// Checks that samples of another film can be added.
    fn check_samples(&self, other: &Self) -> Result<(), FilmError> {
        let total = self.samples.total() + other.samples.total();
        if total > u64::from(MAX_TERMS) {
            return Err(FilmError::Samples(total));
        }
        let shared = self.samples.overlap(&other.samples);
        shared.map_or(Ok(()), |samples| Err(FilmError::Overlap(OverlapError(samples))))
    }

    /// Checks that the film has this format and these edges.
    pub(crate) fn check_layout(
        &self,
        format: &FilmFormat,
        edges: Option<&EdgeLayer>,
    ) -> Result<(), FilmError> {
        if self.format != *format {
            return Err(FilmError::Layout("size, crop, filter or channels"));
        }
        if self.edges.as_ref() != edges {
            return Err(FilmError::Layout("edges over the picture"));
        }
        Ok(())
    }

    /// Takes the numbers, plans and counters of the samples of another film, and the state of its passes if this one has no samples; its sums must be
    /// added, too.
    pub(crate) fn take_samples(&mut self, other: &Self) -> Result<(), FilmError> {
        self.check_samples(other)?;
        if self.samples.is_empty() {
            (self.passes, self.tile_ends) = (other.passes.clone(), other.tile_ends.clone());
        }
        self.samples.insert_all(&other.samples)?;
        self.rejects.merge(other.rejects);
        self.add_plans(other.plans.as_slice().iter().cloned());
        Ok(())
    }

    /// Ranges of about `words` words each, of whole pixels, in order: first of the pixels' own samples, then of splats.
    pub(crate) fn blocks(&self, words: usize) -> Vec<Range<usize>> {
        let (own, all) = (self.own_words(), self.sums.len());
        let strides = [self.format.layout().words(), self.format.splat_layout().words()];
        let regions = [0..own, own..all].into_iter().zip(strides);
        let blocks = regions.flat_map(|(region, stride)| {
            let step = (words / stride).max(1) * stride;
            region.clone().step_by(step).map(move |from| from..(from + step).min(region.end))
        });
        blocks.collect()
    }

    /// Adds the sums of whole pixels of another film, its words from `first` on: all of own samples, or all of splats. `word`: the value of a word.
    pub(crate) fn add_sums<W: Sync>(
        &mut self,
        first: usize,
        theirs: &[W],
        word: impl Fn(&W) -> u64 + Sync,
    ) -> Result<(), FilmError> {
        let merges = match first < self.own_words() {
            true => self.format.layout().merges(),
            false => self.format.splat_layout().merges(),
        };
        let stride: usize = merges.iter().map(|merge| merge.words()).sum();
        self.sums.update(first..first + theirs.len(), |mine| {
            let chunks = mine.par_chunks_mut(stride * PIXELS).zip(theirs.par_chunks(stride * PIXELS));
            chunks.for_each(|(mine, theirs)| {
                for (mine, theirs) in mine.chunks_exact_mut(stride).zip(theirs.chunks_exact(stride)) {
                    add_words(&merges, mine, theirs, &word);
                }
            });
        })
    }
}
