//! Tallies as bytes, for checkpoints.

use glanz_sampling::exact::{SquareSum, WideSum};
use glanz_transport::codec::{Decoder, Encoder};

use crate::far_field::FarFieldGrid;
use crate::receiver::Receivers;
use crate::tally::{FarFieldSums, Tally, TallySums};

impl Tally {
    /// Appends the tally: number of particles, the six sums of the flux balance, then the lists of receivers, cells and directions,
    /// each with its length.
    pub fn encode(&self, encoder: &mut Encoder) {
        encoder.u64(self.particles);
        let books =
            [self.emitted, self.absorbed_by_receivers, self.absorbed_elsewhere, self.escaped, self.given_up];
        books.iter().for_each(|sum| encode_wide(sum, encoder));
        encode_list(&self.receivers, encoder);
        self.other_sides.iter().for_each(|sum| encode_wide(sum, encoder));
        encode_list(&self.cells, encoder);
        encode_list(self.far_field.as_ref().map_or(&[][..], |far_field| &far_field.bins), encoder);
    }

    /// Reads the output of [`Tally::encode`] for the same receivers and directions; `None` if malformed.
    #[must_use]
    pub fn decode(
        decoder: &mut Decoder<'_>,
        receivers: &Receivers,
        far_field: Option<FarFieldGrid>,
    ) -> Option<Self> {
        let particles = decoder.u64()?;
        let mut book = || decode_wide(decoder);
        let (emitted, absorbed_by_receivers, absorbed_elsewhere) = (book()?, book()?, book()?);
        let (escaped, given_up) = (book()?, book()?);
        let count = receivers.as_slice().len();
        let of_receivers = decode_list(decoder, count)?;
        let other_sides = (0..count).map(|_| decode_wide(decoder)).collect::<Option<Vec<_>>>()?;
        let cells = decode_list(decoder, receivers.cell_count())?;
        let bins = decode_list(decoder, far_field.map_or(0, |grid| grid.bins()))?;
        Some(Self {
            particles,
            cells,
            receivers: of_receivers,
            other_sides,
            emitted,
            absorbed_by_receivers,
            absorbed_elsewhere,
            escaped,
            given_up,
            far_field: far_field.map(|grid| FarFieldSums { grid, bins }),
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

fn decode_list(decoder: &mut Decoder<'_>, wanted: usize) -> Option<Vec<TallySums>> {
    if decoder.u64()? != wanted as u64 {
        return None;
    }
    // Every entry has 40 bytes: no more entries are allocated than the bytes can hold.
    if decoder.0.len() / 40 < wanted {
        return None;
    }
    (0..wanted)
        .map(|_| {
            let sum = decode_wide(decoder)?;
            let squares = SquareSum::from_words([decoder.u64()?, decoder.u64()?, decoder.u64()?]);
            Some(TallySums { sum, squares })
        })
        .collect()
}
