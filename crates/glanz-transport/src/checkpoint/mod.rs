//! Checkpoint files: a film with its identity, for resuming and merging.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZCKP` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | | the picture's identity, see [`PictureIdentity`] |
//! | 4, 8 each | number of sample ranges; first and end of each, ascending |
//! | 16 | samples dropped, samples cut |
//! | | with passes: their weight, samples and last weight (8 each); length (8) and state of the training, see [`Guide`](crate::Guide) |
//! | 4 each | with a noise level: number of samples with which each tile ended, 2^32 - 1 if it has not |
//! | 1 | 1 with lines over the picture: their red, green and blue (`f32`), the covered share of each pixel of the crop window in 255ths (1 each), row by row |
//! | 8 each | the sums of all pixels, tile after tile, and of the light splatted to them, row by row, see [`Film`] |
//! | 4 | CRC-32 (IEEE) of all preceding bytes |
//!
//! Numbers are little-endian; text is a length byte and UTF-8.

use glanz_sampling::SamplerKind;
use glanz_scene::description::{FilterDescription, FilterKind};

use crate::aov::AovSet;
use crate::codec::{Decoder, Encoder, EnvelopeError, FileEnvelope};
use crate::edges::EdgeLayer;
use crate::film::{Film, FilmError, FilmFormat};
use crate::guide::{decode_training, encode_training};
use crate::identity::PictureIdentity;
use crate::integrator::IntegratorSettings;
use crate::noise::NoiseLevel;
use crate::passes::Passes;
use crate::pixel::Rejects;
use crate::pixel_rect::{PixelRect, TILE_SIDE};
use crate::ranges::SampleRanges;

/// Envelope of checkpoint files.
const ENVELOPE: FileEnvelope =
    FileEnvelope { magic: b"GLANZCKP", version: 6, content: "the checkpoint", kind: "a checkpoint of Glanz" };

/// Errors of reading a checkpoint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// Another kind or version of file, or a damaged one.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// An intact file with content that this program does not write.
    #[error("the checkpoint is invalid: {0}")]
    Content(&'static str),
    /// The film cannot be created.
    #[error("the checkpoint cannot be used: {0}")]
    Film(#[from] FilmError),
}

/// A film with the identity of its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Identity of the picture.
    pub identity: PictureIdentity,
    /// The film with the samples so far.
    pub film: Film,
}

impl Checkpoint {
    /// The bytes of the file. The caller should write a new file and rename it over the old one, so that one of them is always complete.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        Self::encode(&self.identity, &self.film)
    }

    /// As [`Checkpoint::to_bytes`], for a film that is still in use.
    #[must_use]
    pub fn encode(identity: &PictureIdentity, film: &Film) -> Vec<u8> {
        ENVELOPE.seal(|e| {
            encode_identity(e, identity);
            e.u32(film.samples().as_slice().len() as u32);
            for range in film.samples().as_slice() {
                e.u32(range.start);
                e.u32(range.end);
            }
            e.u64(film.rejects().dropped);
            e.u64(film.rejects().cut);
            if film.format().passes {
                encode_passes(e, film.passes());
            }
            film.tile_ends().iter().for_each(|&end| e.u32(end));
            encode_edges(e, film.edges());
            e.0.reserve(film.words().len() * 8 + 4);
            for &word in film.words() {
                e.u64(word);
            }
        })
    }

    /// Reads the output of [`Checkpoint::to_bytes`]. Memory is limited to a few times the size of `bytes`, whatever their content.
    ///
    /// # Errors
    /// [`CheckpointError`] if any bit differs from the written file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CheckpointError> {
        let mut d = Decoder(ENVELOPE.open(bytes)?);
        let identity = decode_identity(&mut d)?;
        let samples = decode_ranges(&mut d).ok_or(CheckpointError::Content("its sample ranges"))?;
        let rejects = match (d.u64(), d.u64()) {
            (Some(dropped), Some(cut)) => Rejects { dropped, cut },
            _ => return Err(CheckpointError::Content("its counters")),
        };
        let passes = match identity.film.passes {
            true => decode_passes(&mut d, &samples).ok_or(CheckpointError::Content("its training state"))?,
            false => Passes::default(),
        };
        let ends = decode_tile_ends(&mut d, &identity.film).ok_or(CheckpointError::Content("its tiles"))?;
        let edges = decode_edges(&mut d, &identity.film).ok_or(CheckpointError::Content("its edges"))?;
        // Sizes are compared before anything is allocated for them.
        if identity.film.words()?.checked_mul(8) != Some(d.0.len() as u64) {
            return Err(CheckpointError::Content("its size"));
        }
        let (words, _) = d.0.as_chunks::<8>();
        let words = words.iter().map(|w| u64::from_le_bytes(*w)).collect();
        let film = Film::try_from_words(identity.film, words, samples, rejects)?;
        let film = film.with_tile_ends(ends).ok_or(CheckpointError::Content("its tiles"))?;
        Ok(Self { identity, film: film.with_passes(passes).with_edges(edges)? })
    }
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

fn encode_identity(e: &mut Encoder, identity: &PictureIdentity) {
    e.text(&identity.version);
    e.u128(identity.scene);
    let film = &identity.film;
    for value in film.resolution.into_iter().chain(film.crop.min).chain(film.crop.size) {
        e.u32(value);
    }
    e.u8(film.aovs.to_bits());
    e.u8(u8::from(film.signed));
    e.u8(u8::from(film.passes));
    e.u8(u8::from(film.splats));
    e.u32(film.noise.map_or(0, NoiseLevel::millionths));
    encode_filter(e, &identity.filter);
    e.text(&identity.integrator.full_name());
    e.u32(identity.integrator.max_depth);
    e.u8(u8::from(identity.integrator.light_sampling) | u8::from(identity.integrator.spectral) << 1);
    e.u32(identity.integrator.branching);
    e.text(identity.sampler.name());
    e.u64(identity.seed);
    e.u32(identity.samples_per_pixel);
    // A hash of 0 stands for none; one in 2^128 guides has this hash.
    e.u128(identity.guide.unwrap_or_default());
}

fn decode_identity(d: &mut Decoder<'_>) -> Result<PictureIdentity, CheckpointError> {
    let cut = || CheckpointError::Content("its header");
    let version = d.text().ok_or_else(cut)?.to_owned();
    let scene = d.u128().ok_or_else(cut)?;
    let film = decode_format(d).ok_or_else(cut)?;
    let filter = decode_filter(d).ok_or(CheckpointError::Content("its filter"))?;
    let name = d.text().ok_or_else(cut)?;
    let max_depth = d.u32().ok_or_else(cut)?;
    let flags = d.u8().filter(|flags| flags & !3 == 0).ok_or_else(cut)?;
    let branching = d.u32().ok_or_else(cut)?;
    let integrator =
        IntegratorSettings::by_name(name, max_depth, [1, 2].map(|bit| flags & bit != 0), branching)
            .ok_or(CheckpointError::Content("an integrator this program does not have"))?;
    let sampler = d.text().and_then(SamplerKind::from_name);
    let sampler = sampler.ok_or(CheckpointError::Content("a sampler this program does not have"))?;
    let seed = d.u64().ok_or_else(cut)?;
    let samples_per_pixel = d.u32().ok_or_else(cut)?;
    let guide = Some(d.u128().ok_or_else(cut)?).filter(|&hash| hash != 0);
    Ok(PictureIdentity { scene, film, filter, integrator, sampler, seed, samples_per_pixel, guide, version })
}

fn decode_format(d: &mut Decoder<'_>) -> Option<FilmFormat> {
    Some(FilmFormat {
        resolution: [d.u32()?, d.u32()?],
        crop: PixelRect { min: [d.u32()?, d.u32()?], size: [d.u32()?, d.u32()?] },
        aovs: AovSet::from_bits(d.u8()?),
        signed: d.u8()? != 0,
        passes: d.u8()? != 0,
        splats: d.u8()? != 0,
        noise: match d.u32()? {
            0 => None,
            millionths => Some(NoiseLevel::try_new(f64::from(millionths) / 1e6)?),
        },
    })
}

fn encode_filter(e: &mut Encoder, filter: &FilterDescription) {
    let (tag, parameters) = match filter.kind {
        FilterKind::Box => (0, [0.0; 2]),
        FilterKind::Triangle => (1, [0.0; 2]),
        FilterKind::Gaussian { sigma } => (2, [sigma, 0.0]),
        FilterKind::Mitchell { b, c } => (3, [b, c]),
        FilterKind::Cylinder => (4, [0.0; 2]),
        FilterKind::Pyramid => (5, [0.0; 2]),
        FilterKind::Cone => (6, [0.0; 2]),
        FilterKind::Sinc { tau } => (7, [tau, 0.0]),
    };
    e.u8(tag);
    parameters.into_iter().chain(filter.radius).for_each(|v| e.f64(v));
}

fn decode_filter(d: &mut Decoder<'_>) -> Option<FilterDescription> {
    let tag = d.u8()?;
    let (p, q) = (d.f64()?, d.f64()?);
    let kind = match tag {
        0 => FilterKind::Box,
        1 => FilterKind::Triangle,
        2 => FilterKind::Gaussian { sigma: p },
        3 => FilterKind::Mitchell { b: p, c: q },
        4 => FilterKind::Cylinder,
        5 => FilterKind::Pyramid,
        6 => FilterKind::Cone,
        7 => FilterKind::Sinc { tau: p },
        _ => return None,
    };
    Some(FilterDescription { kind, radius: [d.f64()?, d.f64()?] })
}

fn decode_ranges(d: &mut Decoder<'_>) -> Option<SampleRanges> {
    let count = d.u32()? as usize;
    let (ranges, _) = d.take(count.checked_mul(8)?)?.as_chunks::<8>();
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n: u32, &b| n << 8 | u32::from(b));
    SampleRanges::from_ascending(ranges.iter().map(|r| number(&r[..4])..number(&r[4..])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{CRC_LENGTH, PREFIX_LENGTH, resealed};
    use crate::pixel::{PixelSample, PixelSums};
    use glanz_job::JobIdentity;
    use proptest::prelude::*;

    pub(crate) fn example() -> Checkpoint {
        let crop = PixelRect { min: [2, 1], size: [20, 3] };
        let format = FilmFormat {
            resolution: [30, 8],
            crop,
            aovs: AovSet::ALL,
            signed: true,
            passes: false,
            splats: true,
            noise: None,
        };
        let mut film = Film::try_new(format).unwrap();
        let layout = format.layout();
        let mut rejects = Rejects::default();
        for (tile, words) in film.parts_mut().tiles {
            for ([x, y], words) in tile.pixels().zip(words.chunks_exact_mut(layout.words())) {
                let mut sums = PixelSums::read(&layout, words);
                let rgb = [x as f32, y as f32 * 0.3, f32::NAN];
                sums.add(
                    &layout,
                    &PixelSample { index: 4, rgb, negative: false, first_hit: None },
                    &mut rejects,
                );
                sums.write(&layout, words);
            }
        }
        film.finish_pass(4..5, rejects).unwrap();
        film.finish_pass(7..9, Rejects::default()).unwrap();
        let coverage = (0..60).map(|pixel| pixel * 4).collect();
        let film = film.with_edges(Some(EdgeLayer { crop, color: [0.1, 0.2, 0.3], coverage })).unwrap();
        let identity = PictureIdentity {
            scene: 0x0123_4567_89ab_cdef_0011_2233_4455_6677,
            film: format,
            filter: FilterDescription { kind: FilterKind::Mitchell { b: 0.1, c: 0.4 }, radius: [2.0, 1.5] },
            integrator: IntegratorSettings::by_name("path", 7, [true, true], 1).unwrap(),
            sampler: SamplerKind::Stratified,
            seed: 5,
            samples_per_pixel: 64,
            guide: None,
            version: glanz_job::current_version(),
        };
        Checkpoint { identity, film }
    }

    #[test]
    fn written_checkpoints_are_read_back() {
        let checkpoint = example();
        assert_eq!(checkpoint.film.rejects().dropped, 60);
        assert_eq!(Checkpoint::from_bytes(&checkpoint.to_bytes()), Ok(checkpoint));
    }

    #[test]
    fn ends_of_tiles_are_read_back_and_foreign_ones_refused() {
        let Checkpoint { identity, film } = example();
        let format = FilmFormat { splats: false, noise: NoiseLevel::try_new(0.05), ..*film.format() };
        let identity = PictureIdentity { film: format, ..identity };
        let mut film = Film::try_new(format).unwrap();
        film.finish_pass(0..40, Rejects::default()).unwrap();
        let with = |ends: [u32; 2]| film.clone().with_tile_ends(ends.to_vec());
        let checkpoint = Checkpoint { identity, film: with([32, u32::MAX]).unwrap() };
        assert_eq!(Checkpoint::from_bytes(&checkpoint.to_bytes()), Ok(checkpoint));
        assert!(with([48, 32]).is_none() && with([31, 32]).is_none());
        assert!(film.with_tile_ends(vec![32]).is_none());
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_detected() {
        let bytes = example().to_bytes();
        for length in (0..300).chain(bytes.len() - 300..bytes.len()) {
            assert!(Checkpoint::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        let mut longer = bytes.clone();
        longer.push(0);
        assert!(matches!(
            Checkpoint::from_bytes(&longer),
            Err(CheckpointError::Envelope(EnvelopeError::Length { .. }))
        ));
        for bit in (0..300 * 8).chain((300 * 8..bytes.len() * 8).step_by(977)) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Checkpoint::from_bytes(&damaged).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn errors_state_their_reason() {
        let bytes = example().to_bytes();
        let foreign = CheckpointError::Envelope(EnvelopeError::Foreign("a checkpoint of Glanz"));
        assert_eq!(Checkpoint::from_bytes(b"PNG..."), Err(foreign.clone()));
        assert_eq!(Checkpoint::from_bytes(b""), Err(foreign));
        let mut newer = bytes.clone();
        newer[8] += 1;
        let (content, known) = ("the checkpoint", ENVELOPE.version);
        assert_eq!(
            Checkpoint::from_bytes(&newer),
            Err(EnvelopeError::Version { content, found: known + 1, known }.into())
        );
        let found = bytes.len() as u64;
        assert_eq!(
            Checkpoint::from_bytes(&bytes[..100]),
            Err(EnvelopeError::Length { content, expected: found, found: 100 }.into())
        );
    }

    /// `bytes` with corrected length and checksum, as from a malicious writer.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        bytes.truncate(bytes.len() - CRC_LENGTH);
        resealed(bytes)
    }

    #[test]
    fn sizes_beyond_the_file_are_refused_before_allocation() {
        // Version text, 16 bytes of hash, then the resolution and the crop.
        let resolution = PREFIX_LENGTH + 1 + glanz_job::current_version().len() + 16;
        let Checkpoint { identity, film } = example();
        let with_edges = film.edges().cloned();
        let written = |edges| {
            let film = film.clone().with_edges(edges).unwrap();
            Checkpoint { identity: identity.clone(), film }.to_bytes()
        };
        for (edges, reason) in [(None, "its size"), (with_edges, "its edges")] {
            let mut huge = written(edges);
            for offset in [0, 4, 16, 20] {
                huge[resolution + offset..resolution + offset + 4].copy_from_slice(&40_000_u32.to_le_bytes());
            }
            huge[resolution + 8..resolution + 16].fill(0);
            assert_eq!(Checkpoint::from_bytes(&sealed(huge)), Err(CheckpointError::Content(reason)));
        }
        let mut outside = written(None);
        outside[resolution..resolution + 4].copy_from_slice(&1_u32.to_le_bytes());
        assert!(matches!(Checkpoint::from_bytes(&sealed(outside)), Err(CheckpointError::Film(_))));
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_do_not_panic(
            changes in prop::collection::vec((0_usize..250, any::<u8>()), 1..8), length in 24_usize..20_000,
        ) {
            let mut bytes = example().to_bytes();
            for (at, value) in changes {
                // The prefix stays valid; otherwise nothing behind it would be tested.
                if at >= PREFIX_LENGTH {
                    bytes[at] = value;
                }
            }
            bytes.truncate(length.max(PREFIX_LENGTH + CRC_LENGTH));
            let _ = Checkpoint::from_bytes(&sealed(bytes));
        }
    }

    #[test]
    fn first_difference_is_named() {
        let wanted = example().identity;
        assert_eq!(wanted.check(&wanted), Ok(()));
        let named = |change: &dyn Fn(&mut PictureIdentity)| {
            let mut other = wanted.clone();
            change(&mut other);
            other.check(&wanted).unwrap_err().to_string()
        };
        assert_eq!(named(&|i| i.seed = 3), "it is of another picture: the seed is 3, not 5");
        assert!(named(&|i| i.scene = 1).contains("the scene"));
        assert!(named(&|i| i.film.resolution = [31, 8]).contains("the picture size is 31 x 8, not 30 x 8"));
        assert!(named(&|i| i.film.aovs = AovSet::NONE).contains("extra channels is none"));
        assert!(named(&|i| i.film.crop.min = [0, 0]).contains("crop"));
        assert!(named(&|i| i.filter.radius = [1.0, 1.0]).contains("filter"));
        assert!(named(&|i| i.integrator.max_depth = 8).contains("the integrator"));
        assert!(named(&|i| i.sampler = SamplerKind::Sobol).contains("the sampler is sobol, not stratified"));
        assert!(named(&|i| i.samples_per_pixel = 65).contains("65, not 64"));
        assert!(
            named(&|i| i.guide = Some(7))
                .contains("the guide is 00000000000000000000000000000007, not learnt")
        );
        assert!(named(&|i| i.version = "0.0.1".to_owned()).contains("version is 0.0.1"));
        // Sobol points do not depend on the planned number.
        let sobol = PictureIdentity { sampler: SamplerKind::Sobol, ..wanted };
        assert_eq!(PictureIdentity { samples_per_pixel: 1, ..sobol.clone() }.check(&sobol), Ok(()));
    }
}
