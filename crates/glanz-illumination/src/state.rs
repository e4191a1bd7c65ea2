//! Tallies as bytes, for checkpoints.

use glanz_sampling::exact::WideSum;
use glanz_transport::ParticleRanges;
use glanz_transport::codec::{Decoder, Encoder};

use crate::far_field::FarFieldGrid;
use crate::replicates::REPLICATES;
use crate::tally::{FluxSums, Tally};

impl Tally {
    /// Appends the tally: the ranges of its particles; the numbers of planes and of gamma angles of the far field, or 0 and 0, with these angles in degrees; then for
    /// each replicate the five sums of the flux balance, and the lists of the other sides of receivers, the cells and the directions. Each list begins with its length.
    pub fn encode(&self, encoder: &mut Encoder) {
        let ranges = self.particles.as_slice();
        encoder.u64(ranges.len() as u64);
        ranges.iter().flat_map(|range| [range.start, range.end]).for_each(|number| encoder.u64(number));
        let grid = self.far_field.as_ref();
        let angles = grid.map_or([&[][..]; 2], |grid| [grid.planes(), grid.gammas()]);
        angles.into_iter().for_each(|list| encoder.u32(list.len() as u32));
        angles.into_iter().flatten().for_each(|angle| encoder.u64(angle.to_bits()));
        for sums in &self.replicates {
            let FluxSums { emitted, absorbed_by_receivers, absorbed_elsewhere, escaped, given_up, .. } = sums;
            for sum in [emitted, absorbed_by_receivers, absorbed_elsewhere, escaped, given_up] {
                encode_sum(sum, encoder);
            }
            for list in [&sums.other_sides, &sums.cells, &sums.bins] {
                encoder.u64(list.len() as u64);
                list.iter().for_each(|sum| encode_sum(sum, encoder));
            }
        }
    }

    /// Reads the output of [`Tally::encode`]; `None` if malformed. Uses at most a few times the memory of the bytes.
    #[must_use]
    pub fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let count = decoder.u64()?;
        let range = |_| Some(decoder.u64()?..decoder.u64()?);
        let particles = ParticleRanges::from_ascending((0..count).map(range).collect::<Option<_>>()?)?;
        let counts = [decoder.u32()?, decoder.u32()?];
        let mut angles =
            |count| (0..count).map(|_| Some(f64::from_bits(decoder.u64()?))).collect::<Option<Vec<f64>>>();
        let (planes, gammas) = (angles(counts[0])?, angles(counts[1])?);
        let far_field = FarFieldGrid::from_angles(planes, gammas);
        if far_field.is_none() && counts != [0, 0] {
            return None;
        }
        let replicates: Vec<FluxSums> =
            (0..REPLICATES).map(|_| decode_sums(decoder)).collect::<Option<_>>()?;
        let shape = |sums: &FluxSums| [sums.other_sides.len(), sums.cells.len(), sums.bins.len()];
        let bins = far_field.as_ref().map_or(0, FarFieldGrid::bins);
        let first = shape(replicates.first()?);
        let fits = first[2] == bins && replicates.iter().all(|sums| shape(sums) == first);
        fits.then_some(Self { particles, far_field, replicates })
    }
}

fn encode_sum(sum: &WideSum, encoder: &mut Encoder) {
    sum.to_words().into_iter().for_each(|word| encoder.u64(word));
}

fn decode_sum(decoder: &mut Decoder<'_>) -> Option<WideSum> {
    Some(WideSum::from_words([decoder.u64()?, decoder.u64()?]))
}

fn decode_sums(decoder: &mut Decoder<'_>) -> Option<FluxSums> {
    Some(FluxSums {
        emitted: decode_sum(decoder)?,
        absorbed_by_receivers: decode_sum(decoder)?,
        absorbed_elsewhere: decode_sum(decoder)?,
        escaped: decode_sum(decoder)?,
        given_up: decode_sum(decoder)?,
        other_sides: decode_list(decoder)?,
        cells: decode_list(decoder)?,
        bins: decode_list(decoder)?,
    })
}

fn decode_list(decoder: &mut Decoder<'_>) -> Option<Vec<WideSum>> {
    let count = usize::try_from(decoder.u64()?).ok()?;
    // Every sum has 16 bytes: no more are allocated than the bytes can hold.
    if decoder.0.len() / 16 < count {
        return None;
    }
    (0..count).map(|_| decode_sum(decoder)).collect()
}
