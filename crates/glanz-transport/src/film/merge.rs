//! Films of one picture, added.

use glanz_sampling::exact::MAX_TERMS;

use super::{Film, FilmError};
use crate::pixel::PixelSums;
use crate::splat::SplatSums;

impl Film {
    /// Adds the samples of another film of the same picture.
    ///
    /// # Errors
    /// [`FilmError::Layout`] if the formats or the edges differ, [`FilmError::Overlap`] if a sample is in both, and
    /// [`FilmError::Samples`] if there would be too many, [`FilmError::Ordered`] for films with passes or a noise level; after an error this film is
    /// unchanged.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if self.format != other.format {
            return Err(FilmError::Layout("size, crop, filter or channels"));
        }
        if self.edges != other.edges {
            return Err(FilmError::Layout("edges over the picture"));
        }
        if self.format.is_ordered() {
            return Err(FilmError::Ordered);
        }
        let total = self.samples.total() + other.samples.total();
        if total > u64::from(MAX_TERMS) {
            return Err(FilmError::Samples(total));
        }
        let mut samples = self.samples.clone();
        for range in other.samples.as_slice() {
            samples.insert(range.clone())?;
        }
        let (layout, splats) = (self.format.layout(), self.format.splat_layout());
        let ((own, splatted), (theirs, their_splats)) = (self.sums_mut(), other.sums());
        join(own, theirs, layout.words(), |mine, theirs| {
            let mut sums = PixelSums::read(&layout, mine);
            sums.merge(&PixelSums::read(&layout, theirs));
            sums.write(&layout, mine);
        });
        join(splatted, their_splats, splats.words(), |mine, theirs| {
            let mut sums = SplatSums::read(mine);
            sums.merge(&SplatSums::read(theirs));
            sums.write(mine);
        });
        self.samples = samples;
        self.rejects.merge(other.rejects);
        Ok(())
    }
}

/// Calls `add` for every `stride` words of two films of one format.
fn join(mine: &mut [u64], theirs: &[u64], stride: usize, add: impl Fn(&mut [u64], &[u64])) {
    mine.chunks_exact_mut(stride)
        .zip(theirs.chunks_exact(stride))
        .for_each(|(mine, theirs)| add(mine, theirs));
}
