//! Checkpoint files: a film with its identity, for resuming and merging.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZCKP` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 8 | length of the head, the lines from the next one to the one before its checksum |
//! | | the picture's identity, see [`PictureIdentity`] |
//! | 4, 8 each | number of sample ranges; first and end of each, ascending |
//! | 4, 12 each | number of plans of which samples are missing; first and end of the samples of each, and its number of parts |
//! | 16 | samples dropped, samples cut |
//! | | with passes: their weight, samples and last weight (8 each); length (8) and state of the training, see [`Guide`](crate::Guide) |
//! | 4 each | with a noise level: number of samples with which each tile ended, 2^32 - 1 if it has not |
//! | 1 | 1 with lines over the picture: their red, green and blue (`f32`), the covered share of each pixel of the crop window in 255ths (1 each), row by row |
//! | 4 | CRC-32 (IEEE) of all preceding bytes |
//! | 8 each | the sums of all pixels, tile after tile, and of the light splatted to them, row by row, see [`Film`] |
//! | 4 | CRC-32 (IEEE) of all preceding bytes but the first checksum: behind its own checksum, the head would not count |
//!
//! Numbers are little-endian; text is a length byte and UTF-8.

mod head;
mod identity;
mod sums;

use std::io::{self, Read, Write};

use glanz_job::{Interrupted, IoFault};

use crate::codec::{EnvelopeError, FileEnvelope};
use crate::film::{Film, FilmError, FilmSumsWriter};
use crate::identity::PictureIdentity;

pub use head::CheckpointHead;
pub(crate) use sums::SumReader;

/// Envelope of checkpoint files.
const ENVELOPE: FileEnvelope =
    FileEnvelope { magic: b"GLANZCKP", version: 7, content: "the checkpoint", kind: "a checkpoint of Glanz" };

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
    /// The film cannot be created, or its temporary file failed.
    #[error("the checkpoint cannot be used: {0}")]
    Film(#[from] FilmError),
    /// The file cannot be read: the kind of the error, and its text.
    #[error("the checkpoint cannot be read: {1}")]
    Read(io::ErrorKind, String),
    /// Reading was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<io::Error> for CheckpointError {
    fn from(error: io::Error) -> Self {
        Self::Read(error.kind(), IoFault::sentence(&error).to_string())
    }
}

/// A file that ends after `found` bytes instead of `expected`.
fn damaged(expected: u64, found: u64) -> CheckpointError {
    EnvelopeError::Length { content: ENVELOPE.content, expected, found }.into()
}

/// Appends the next `count` bytes to `bytes`; false if the file ends before. Takes no more memory than the file has bytes.
fn read_bytes(input: &mut impl Read, count: usize, bytes: &mut Vec<u8>) -> Result<bool, CheckpointError> {
    let read = input.take(count as u64).read_to_end(bytes);
    Ok(read? == count)
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
    /// The bytes of the file.
    ///
    /// # Errors
    /// A film in a file that cannot be read.
    pub fn to_bytes(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Self::write(&self.identity, &self.film, &mut bytes)?;
        Ok(bytes)
    }

    /// Writes the bytes of the file of a film that may be in use, in large blocks. The caller should write a new file and rename it over the old one,
    /// so that one of them is always complete.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(identity: &PictureIdentity, film: &Film, out: &mut dyn Write) -> io::Result<()> {
        let (head, crc) = CheckpointHead::encode(identity, film);
        out.write_all(&head)?;
        sums::write(film, crc32fast::Hasher::new_with_initial(crc), out)
    }

    /// Reads the output of [`Checkpoint::write`]. The film is in a temporary file if it takes more than `memory` bytes, see [`Film::try_new_within`].
    ///
    /// # Errors
    /// [`CheckpointError`] if any bit differs from the written file; [`CheckpointError::Film`] if the film takes more than `memory` and has to be in
    /// memory, there is no memory for it, or its temporary file failed.
    pub fn read_within(mut input: impl Read, memory: u64) -> Result<Self, CheckpointError> {
        let head = CheckpointHead::read(&mut input)?;
        Self::read_sums(head, input, memory)
    }

    /// Reads the rest of a checkpoint, of which `head` was read from `input`, as [`Checkpoint::read_within`] does.
    ///
    /// # Errors
    /// As [`Checkpoint::read_within`].
    pub fn read_sums(head: CheckpointHead, input: impl Read, memory: u64) -> Result<Self, CheckpointError> {
        let format = head.film.format();
        format.check_memory(memory)?;
        let mut words = FilmSumsWriter::try_new(format.words()?, memory)?;
        let mut sums = SumReader::new(&head, input);
        let mut block = Vec::new();
        let mut left = format.words()? as usize;
        while left > 0 {
            let count = left.min(sums::BLOCK);
            sums.read_words(count, &mut block)?;
            words.push(block.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)))?;
            left -= count;
        }
        sums.finish()?;
        let CheckpointHead { identity, film, .. } = head;
        Ok(Self { identity, film: film.with_sums(words)? })
    }

    /// Reads the output of [`Checkpoint::to_bytes`]. Memory is limited to a few times the size of `bytes`, whatever their content.
    ///
    /// # Errors
    /// As [`Checkpoint::read_within`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CheckpointError> {
        Self::read_within(bytes, u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aov::AovSet;
    use crate::codec::{CRC_LENGTH, PREFIX_LENGTH};
    use crate::edges::EdgeLayer;
    use crate::film::FilmFormat;
    use crate::integrator::IntegratorSettings;
    use crate::noise::NoiseLevel;
    use crate::pixel::Rejects;
    use crate::pixel::{PixelSample, PixelSums};
    use crate::pixel_rect::PixelRect;
    use crate::sample_plan::SamplePlan;
    use glanz_job::JobIdentity;
    use glanz_sampling::SamplerKind;
    use glanz_scene::description::{FilterDescription, FilterKind};
    use proptest::prelude::*;

    /// Length of what precedes the head.
    const HEAD: usize = PREFIX_LENGTH + 8;

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
        let mut film = film.with_edges(Some(EdgeLayer { crop, color: [0.1, 0.2, 0.3], coverage })).unwrap();
        film.add_plans(SamplePlan::try_new(4..9, 2));
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
        assert_eq!(Checkpoint::from_bytes(&checkpoint.to_bytes().unwrap()), Ok(checkpoint));
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
        assert_eq!(Checkpoint::from_bytes(&checkpoint.to_bytes().unwrap()), Ok(checkpoint));
        assert!(with([48, 32]).is_none() && with([31, 32]).is_none());
        assert!(film.with_tile_ends(vec![32]).is_none());
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_detected() {
        let bytes = example().to_bytes().unwrap();
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
    fn errors_of_reading_are_sentences() {
        let failed = |kind| CheckpointError::from(io::Error::from(kind)).to_string();
        let text = failed(io::ErrorKind::StorageFull);
        assert!(text.starts_with("the checkpoint cannot be read: the disk is full ("), "{text}");
        assert_eq!(
            CheckpointError::from(io::Error::from(io::ErrorKind::NotFound)),
            CheckpointError::from(io::Error::from(io::ErrorKind::NotFound))
        );
    }

    #[test]
    fn errors_state_their_reason() {
        let bytes = example().to_bytes().unwrap();
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

    /// `bytes` with corrected length and checksums, as from a malicious writer.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        bytes.truncate(bytes.len() - CRC_LENGTH);
        let length = (bytes.len() + CRC_LENGTH) as u64;
        bytes[12..20].copy_from_slice(&length.to_le_bytes());
        let head = u64::from_le_bytes(bytes[PREFIX_LENGTH..HEAD].try_into().unwrap());
        let end = HEAD.saturating_add(head as usize);
        let mut covered = bytes.clone();
        if bytes.len() >= end.saturating_add(CRC_LENGTH) {
            let crc = crc32fast::hash(&bytes[..end]);
            covered.drain(end..end + CRC_LENGTH);
            bytes[end..end + CRC_LENGTH].copy_from_slice(&crc.to_le_bytes());
        }
        bytes.extend(crc32fast::hash(&covered).to_le_bytes());
        bytes
    }

    #[test]
    fn sizes_beyond_the_file_are_refused_before_allocation() {
        // Version text, 16 bytes of hash, then the resolution and the crop.
        let resolution = HEAD + 1 + glanz_job::current_version().len() + 16;
        let Checkpoint { identity, film } = example();
        let with_edges = film.edges().cloned();
        let written = |edges| {
            let film = film.clone().with_edges(edges).unwrap();
            Checkpoint { identity: identity.clone(), film }.to_bytes().unwrap()
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
            let mut bytes = example().to_bytes().unwrap();
            for (at, value) in changes {
                // The prefix stays valid; otherwise nothing behind it would be tested.
                if at >= PREFIX_LENGTH {
                    bytes[at] = value;
                }
            }
            bytes.truncate(length.max(HEAD + CRC_LENGTH));
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
