//! Tallies as bytes, for checkpoints.

use glanz_sampling::exact::{SquareSum, WideSum};
use glanz_transport::ParticleRanges;
use glanz_transport::codec::{Decoder, Encoder};

use crate::far_field::FarFieldGrid;
use crate::tally::{FarFieldSums, Tally, TallySums};

impl Tally {
    /// Appends the tally: the ranges of its particles, the six sums of the flux balance, the lists of receivers and cells, then the numbers of
    /// planes and of steps of gamma of the far field, or 0 and 0, with the list of its directions. Each list begins with its length.
    pub fn encode(&self, encoder: &mut Encoder) {
        let ranges = self.particles.as_slice();
        encoder.u64(ranges.len() as u64);
        ranges.iter().flat_map(|range| [range.start, range.end]).for_each(|number| encoder.u64(number));
        let books =
            [self.emitted, self.absorbed_by_receivers, self.absorbed_elsewhere, self.escaped, self.given_up];
        books.iter().for_each(|sum| encode_wide(sum, encoder));
        encode_list(&self.receivers, encoder);
        self.other_sides.iter().for_each(|sum| encode_wide(sum, encoder));
        encode_list(&self.cells, encoder);
        let counts = self.far_field.as_ref().map_or([0, 0], |sums| sums.grid.counts());
        counts.into_iter().for_each(|count| encoder.u32(count));
        encode_list(self.far_field.as_ref().map_or(&[][..], |far_field| &far_field.bins), encoder);
    }

    /// Reads the output of [`Tally::encode`]; `None` if malformed. Uses at most a few times the memory of the bytes.
    #[must_use]
    pub fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let count = decoder.u64()?;
        let range = |_| Some(decoder.u64()?..decoder.u64()?);
        let particles = ParticleRanges::from_ascending((0..count).map(range).collect::<Option<_>>()?)?;
        let mut book = || decode_wide(decoder);
        let (emitted, absorbed_by_receivers, absorbed_elsewhere) = (book()?, book()?, book()?);
        let (escaped, given_up) = (book()?, book()?);
        let receivers = decode_list(decoder)?;
        let other_sides = receivers.iter().map(|_| decode_wide(decoder)).collect::<Option<_>>()?;
        let cells = decode_list(decoder)?;
        let (planes, steps) = (decoder.u32()?, decoder.u32()?);
        let bins = decode_list(decoder)?;
        let far_field = match FarFieldGrid::try_new(planes, steps) {
            Some(grid) if grid.bins() == bins.len() => Some(FarFieldSums { grid, bins }),
            None if [planes, steps] == [0, 0] && bins.is_empty() => None,
            _ => return None,
        };
        Some(Self {
            particles,
            cells,
            receivers,
            other_sides,
            emitted,
            absorbed_by_receivers,
            absorbed_elsewhere,
            escaped,
            given_up,
            far_field,
        })
    }
}

fn encode_wide(sum: &WideSum, encoder: &mut Encoder) {
    sum.to_words().into_iter().for_each(|word| encoder.u64(word));
}

fn decode_wide(decoder: &mut Decoder<'_>) -> Option<WideSum> {
    Some(WideSum::from_words([decoder.u64()?, decoder.u64()?]))
}

fn encode_list(list: &[TallySums], encoder: &mut Encoder) {
    encoder.u64(list.len() as u64);
    for TallySums { sum, squares } in list {
        encode_wide(sum, encoder);
        squares.to_words().into_iter().for_each(|word| encoder.u64(word));
    }
}

fn decode_list(decoder: &mut Decoder<'_>) -> Option<Vec<TallySums>> {
    let count = usize::try_from(decoder.u64()?).ok()?;
    // Every entry has 40 bytes: no more entries are allocated than the bytes can hold.
    if decoder.0.len() / 40 < count {
        return None;
    }
    (0..count)
        .map(|_| {
            let sum = decode_wide(decoder)?;
            let squares = SquareSum::from_words([decoder.u64()?, decoder.u64()?, decoder.u64()?]);
            Some(TallySums { sum, squares })
        })
        .collect()
}
