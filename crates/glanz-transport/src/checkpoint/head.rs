//! The head of a checkpoint: everything but the sums.

use std::io::Read;

use super::identity::{decode_identity, encode_identity};
use super::{CheckpointError, ENVELOPE, damaged, read_bytes};
use crate::codec::{CRC_LENGTH, Decoder, Encoder, EnvelopeError, PREFIX_LENGTH};
use crate::edges::EdgeLayer;
use crate::film::{Film, FilmFormat};
use crate::guide::{decode_training, encode_training};
use crate::identity::PictureIdentity;
use crate::passes::Passes;
use crate::pixel::Rejects;
use crate::pixel_rect::TILE_SIDE;
use crate::ranges::SampleRanges;
use crate::sample_plan::SamplePlan;

/// Length of the field before the head.
const LENGTH_FIELD: usize = 8;

/// The head of a checkpoint, which is small beside the sums that follow it.
#[derive(Clone, Debug)]
pub struct CheckpointHead {
    /// Identity of the picture.
    pub identity: PictureIdentity,
    /// The film without its sums.
    pub(crate) film: Film,
    /// Length up to the sums.
    pub(super) before_sums: u64,
    pub(super) length: u64,
    /// Its checksum, from which that of the whole file continues.
    pub(super) crc: u32,
}

impl CheckpointHead {
    /// Reads the beginning of a checkpoint, up to the sums.
    ///
    /// # Errors
    /// [`CheckpointError`] if any bit of it differs from the written file.
    pub fn read(mut input: impl Read) -> Result<Self, CheckpointError> {
        let mut bytes = Vec::new();
        let complete = read_bytes(&mut input, PREFIX_LENGTH + LENGTH_FIELD, &mut bytes)?;
        let length = ENVELOPE.length(&bytes)?;
        let cut = |found: usize| damaged(length, found as u64);
        let stored =
            bytes.last_chunk::<LENGTH_FIELD>().filter(|_| complete).ok_or_else(|| cut(bytes.len()))?;
        let head = u64::from_le_bytes(*stored);
        let start = bytes.len();
        let rest = usize::try_from(head.min(length)).unwrap_or(usize::MAX);
        if !read_bytes(&mut input, rest.saturating_add(CRC_LENGTH), &mut bytes)? {
            return Err(cut(bytes.len()));
        }
        let before_sums = bytes.len() as u64;
        let Some((sealed, stored)) = bytes.split_last_chunk::<CRC_LENGTH>() else { return Err(cut(start)) };
        let (expected, found) = (u32::from_le_bytes(*stored), crc32fast::hash(sealed));
        if expected != found {
            return Err(EnvelopeError::Checksum { content: ENVELOPE.content, expected, found }.into());
        }
        let mut d = Decoder(sealed.get(start..).unwrap_or_default());
        let (identity, film) = decode(&mut d)?;
        // Sizes are compared before anything is allocated for the sums.
        let sums = identity.film.words()?.checked_mul(8);
        let expected = sums.and_then(|sums| sums.checked_add(before_sums + CRC_LENGTH as u64));
        if expected != Some(length) || !d.0.is_empty() {
            return Err(CheckpointError::Content("its size"));
        }
        Ok(Self { identity, film, before_sums, length, crc: found })
    }

    /// Length of the whole file, bytes.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Checks that a file of `found` bytes is the whole file.
    ///
    /// # Errors
    /// [`CheckpointError::Envelope`] for another length.
    pub fn check_length(&self, found: u64) -> Result<(), CheckpointError> {
        if found == self.length { Ok(()) } else { Err(damaged(self.length, found)) }
    }

    /// Position of the first sum in the file, bytes.
    #[must_use]
    pub fn before_sums(&self) -> u64 {
        self.before_sums
    }

    /// The bytes of a file up to its sums, and the checksum of all of them before it.
    pub(super) fn encode(identity: &PictureIdentity, film: &Film) -> (Vec<u8>, u32) {
        let mut head = Encoder::default();
        encode_identity(&mut head, identity);
        encode_state(&mut head, film);
        let before_sums = PREFIX_LENGTH + LENGTH_FIELD + head.0.len() + CRC_LENGTH;
        let mut e = ENVELOPE.prefix((before_sums + film.word_count() * 8 + CRC_LENGTH) as u64);
        e.u64(head.0.len() as u64);
        e.0.extend(head.0);
        let crc = crc32fast::hash(&e.0);
        e.u32(crc);
        (e.0, crc)
    }
}

fn encode_state(e: &mut Encoder, film: &Film) {
    e.u32(film.samples().as_slice().len() as u32);
    for range in film.samples().as_slice() {
        e.u32(range.start);
        e.u32(range.end);
    }
    e.u32(film.plans().as_slice().len() as u32);
    for plan in film.plans().as_slice() {
        e.u32(plan.samples().start);
        e.u32(plan.samples().end);
        e.u32(plan.parts());
    }
    e.u64(film.rejects().dropped);
    e.u64(film.rejects().cut);
    if film.format().passes {
        encode_passes(e, film.passes());
    }
    film.tile_ends().iter().for_each(|&end| e.u32(end));
    encode_edges(e, film.edges());
}

/// Identity and film, without its sums.
fn decode(d: &mut Decoder<'_>) -> Result<(PictureIdentity, Film), CheckpointError> {
    let identity = decode_identity(d)?;
    let samples = decode_ranges(d).ok_or(CheckpointError::Content("its sample ranges"))?;
    let plans = decode_plans(d).ok_or(CheckpointError::Content("its plans of parts"))?;
    let (Some(dropped), Some(cut)) = (d.u64(), d.u64()) else {
        return Err(CheckpointError::Content("its counters"));
    };
    let passes = match identity.film.passes {
        true => decode_passes(d, &samples).ok_or(CheckpointError::Content("its training state"))?,
        false => Passes::default(),
    };
    let ends = decode_tile_ends(d, &identity.film).ok_or(CheckpointError::Content("its tiles"))?;
    let edges = decode_edges(d, &identity.film).ok_or(CheckpointError::Content("its edges"))?;
    let mut film = Film::try_from_state(identity.film, samples, Rejects { dropped, cut })?;
    film.add_plans(plans);
    let film = film.with_tile_ends(ends).ok_or(CheckpointError::Content("its tiles"))?;
    Ok((identity, film.with_passes(passes).with_edges(edges)?))
}

fn decode_plans(d: &mut Decoder<'_>) -> Option<Vec<SamplePlan>> {
    let count = d.u32()?;
    (0..count).map(|_| SamplePlan::try_new(d.u32()?..d.u32()?, d.u32()?)).collect()
}

fn decode_tile_ends(d: &mut Decoder<'_>, format: &FilmFormat) -> Option<Vec<u32>> {
    if format.noise.is_none() {
        return Some(Vec::new());
    }
    // The size of the film is checked after this: a header cannot make it allocate more than the file has.
    let count = format.crop.size.map(|side| u64::from(side.div_ceil(TILE_SIDE)));
    let bytes = d.take(usize::try_from(count[0].checked_mul(count[1])?.checked_mul(4)?).ok()?)?;
    Some(bytes.as_chunks::<4>().0.iter().map(|end| u32::from_le_bytes(*end)).collect())
}

fn encode_passes(e: &mut Encoder, passes: &Passes) {
    e.f64(passes.weight);
    e.u64(passes.samples);
    e.f64(passes.last);
    let mut training = Encoder::default();
    if let Some(state) = &passes.training {
        encode_training(&mut training, state);
    }
    e.u64(training.0.len() as u64);
    e.0.extend(training.0);
}

fn decode_passes(d: &mut Decoder<'_>, taken: &SampleRanges) -> Option<Passes> {
    let (weight, samples, last) = (d.f64()?, d.u64()?, d.f64()?);
    let fine = |value: f64| value >= 0.0 && value.is_finite();
    if !fine(weight) || !fine(last) || samples > taken.total() {
        return None;
    }
    let length = usize::try_from(d.u64()?).ok()?;
    let mut state = Decoder(d.take(length)?);
    let training = match length {
        0 => None,
        _ => Some(Box::new(decode_training(&mut state)?)),
    };
    state.0.is_empty().then_some(Passes { weight, samples, last, training })
}

fn encode_edges(e: &mut Encoder, edges: Option<&EdgeLayer>) {
    e.u8(u8::from(edges.is_some()));
    if let Some(EdgeLayer { color, coverage, .. }) = edges {
        color.iter().for_each(|band| e.u32(band.to_bits()));
        e.0.extend(coverage);
    }
}

fn decode_edges(d: &mut Decoder<'_>, format: &FilmFormat) -> Option<Option<EdgeLayer>> {
    if d.u8()? == 0 {
        return Some(None);
    }
    let color = [d.u32()?, d.u32()?, d.u32()?].map(f32::from_bits);
    let coverage = d.take(usize::try_from(format.crop.len()).ok()?)?.to_vec();
    color.iter().all(|band| band.is_finite()).then_some(Some(EdgeLayer {
        crop: format.crop,
        color,
        coverage,
    }))
}

fn decode_ranges(d: &mut Decoder<'_>) -> Option<SampleRanges> {
    let count = d.u32()? as usize;
    let (ranges, _) = d.take(count.checked_mul(8)?)?.as_chunks::<8>();
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n: u32, &b| n << 8 | u32::from(b));
    SampleRanges::from_ascending(ranges.iter().map(|r| number(&r[..4])..number(&r[4..])).collect())
}
