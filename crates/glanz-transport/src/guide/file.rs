//! A guide in a file, to render with it elsewhere.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZGDE` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 | kind of guide: 0, cells and directions that refine themselves |
//! | 24, 24 | corner and sides of the bounds |
//! | 4; 5 each | nodes of the cells: axis, first half; or 3, number of the cell |
//! | 5 each | cells: root of the tree of directions, share |
//! | 4; 32 each | nodes of the directions: light of the quarters, their own quarters |
//! | 4 | CRC-32 (IEEE) of all before |
//!
//! Numbers are little-endian.

use glanz_math::DVec3;

use super::cells::{Cells, Node};
use super::directions::{DirectionTrees, Quarters};
use super::mixture::{SHARES, Share};
use super::tree::{Cell, TreeGuide};
use super::{Guide, Training};
use crate::codec::{Decoder, Encoder, EnvelopeError, open, seal};

const MAGIC: &[u8; 8] = b"GLANZGDE";
const VERSION: u32 = 1;

/// What stands for an axis where there is a cell.
const CELL: u8 = 3;

/// Why bytes are not a guide.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GuideFileError {
    /// Something else.
    #[error("this is not a guide of Glanz")]
    Foreign,
    /// Written by a program of another time.
    #[error("the guide has format {0}, this program reads format {VERSION}")]
    Version(u32),
    /// Cut or changed on the way.
    #[error("the guide is damaged: {0}")]
    Damaged(String),
    /// Unchanged, but nothing that this program would write.
    #[error("the guide makes no sense: {0}")]
    Content(&'static str),
}

impl From<EnvelopeError> for GuideFileError {
    fn from(error: EnvelopeError) -> Self {
        match error {
            EnvelopeError::Foreign => Self::Foreign,
            EnvelopeError::Version(version) => Self::Version(version),
            other => Self::Damaged(other.to_string()),
        }
    }
}

impl Guide {
    /// The bytes of the file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        seal(MAGIC, VERSION, |e| encode_guide(e, self))
    }

    /// Reads what [`Guide::to_bytes`] wrote. Takes no more memory than a few times `bytes`, whatever they are.
    ///
    /// # Errors
    /// [`GuideFileError`] if any bit is not as it was written.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, GuideFileError> {
        let mut d = Decoder(open(MAGIC, VERSION, bytes)?);
        let guide = decode_guide(&mut d).ok_or(GuideFileError::Content("its trees"))?;
        if d.0.is_empty() { Ok(guide) } else { Err(GuideFileError::Content("its size")) }
    }
}

fn encode_guide(e: &mut Encoder, guide: &Guide) {
    let Guide::Tree(TreeGuide { cells, known, trees }) = guide;
    e.u8(0);
    for value in cells.min.to_array().into_iter().chain(cells.size.to_array()) {
        e.f64(value);
    }
    e.u32(cells.nodes.len() as u32);
    for node in &cells.nodes {
        let (tag, number) = match *node {
            Node::Halved { axis, low } => (axis, low),
            Node::Cell(cell) => (CELL, cell),
        };
        e.u8(tag);
        e.u32(number);
    }
    for cell in known {
        e.u32(cell.root);
        e.u8(cell.share.0);
    }
    e.u32(trees.0.len() as u32);
    for quarters in &trees.0 {
        quarters.light.iter().for_each(|light| e.u32(light.to_bits()));
        quarters.child.iter().for_each(|&child| e.u32(child));
    }
}

fn decode_guide(d: &mut Decoder<'_>) -> Option<Guide> {
    if d.u8()? != 0 {
        return None;
    }
    let min = DVec3::new(d.f64()?, d.f64()?, d.f64()?);
    let size = DVec3::new(d.f64()?, d.f64()?, d.f64()?);
    let mut nodes = Vec::new();
    for _ in 0..d.u32()? {
        let (tag, number) = (d.u8()?, d.u32()?);
        nodes.push(if tag == CELL { Node::Cell(number) } else { Node::Halved { axis: tag, low: number } });
    }
    let cells = Cells::from_parts(min, size, nodes)?;
    let mut known = Vec::new();
    for _ in 0..cells.count() {
        known.push(Cell { root: d.u32()?, share: Share(d.u8()?) });
    }
    let mut trees = Vec::new();
    for _ in 0..d.u32()? {
        let light = [d.u32()?, d.u32()?, d.u32()?, d.u32()?].map(f32::from_bits);
        trees.push(Quarters { light, child: [d.u32()?, d.u32()?, d.u32()?, d.u32()?] });
    }
    let trees = DirectionTrees(trees);
    let sound = |cell: &Cell| {
        (cell.root as usize) < trees.0.len()
            && usize::from(cell.share.0) < SHARES
            && (cell.share.0 == 0 || trees.is_lit(cell.root))
    };
    (trees.is_valid() && known.iter().all(sound)).then_some(Guide::Tree(TreeGuide { cells, known, trees }))
}

/// Appends the state of a training.
pub(crate) fn encode_training(e: &mut Encoder, training: &Training) {
    encode_guide(e, &training.guide);
    e.f64(training.typical.unwrap_or_default());
    training.lessons.to_words().into_iter().for_each(|word| e.u64(word));
}

/// What [`encode_training`] wrote; `None` if it did not.
pub(crate) fn decode_training(d: &mut Decoder<'_>) -> Option<Training> {
    let guide = decode_guide(d)?;
    let typical = d.f64()?;
    let typical = match typical {
        0.0 => None,
        _ if typical > 0.0 && typical.is_finite() => Some(typical),
        _ => return None,
    };
    let Guide::Tree(tree) = &guide;
    let words = tree.lesson_words();
    let (words, _) = d.take(words.checked_mul(8)?)?.as_chunks::<8>();
    let mut lessons = guide.lessons();
    lessons.set_words(words.iter().map(|word| u64::from_le_bytes(*word)));
    Some(Training { guide, lessons, typical })
}

#[cfg(test)]
mod tests {
    use glanz_light::{Spectrum, Wavelengths};
    use glanz_math::{Bounds3, DVec2};
    use proptest::prelude::*;

    use super::*;
    use crate::codec::{CRC_LENGTH, PREFIX_LENGTH};
    use crate::guide::Record;

    /// A guide that has learnt twice of light around one direction, and begun to learn again.
    fn example() -> Training {
        let mut training = Training::new(&Bounds3::new(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)));
        training.finish_pass(1.0);
        for _ in 0..3 {
            if training.records() > 0 {
                training.finish_pass(1.0);
            }
            for i in 0..5000_u32 {
                let xi = DVec2::new(f64::from(i).sqrt().fract(), f64::from(i) * 0.618 % 1.0);
                let position = DVec3::new(2.0 * xi.x, xi.y, 0.5);
                let place = training.guide().place(position, DVec3::Z);
                let direction = DVec3::new(0.3 * xi.y, 0.1 * xi.x, 1.0).normalize();
                let (guide_pdf, leaf) = training.guide().pdf(&place, direction);
                let beyond = Spectrum::splat(0.5);
                let record = Record {
                    cell: place.cell,
                    leaf,
                    cosine: direction.z,
                    guide_pdf,
                    bsdf_pdf: 0.3,
                    pdf: 0.3,
                    light: Spectrum::BLACK,
                    throughput: Spectrum::ONE,
                    beyond,
                };
                training.learn(&[record], Spectrum::splat(1.0), &Wavelengths::default());
            }
        }
        training
    }

    #[test]
    fn what_was_written_is_read() {
        let training = example();
        let guide = training.guide();
        assert!(guide.size().active > 1 && guide.size().cells > 7, "{:?}", guide.size());
        assert_eq!(Guide::from_bytes(&guide.to_bytes()).as_ref(), Ok(guide));
        let mut e = Encoder::default();
        encode_training(&mut e, &training);
        assert_eq!(decode_training(&mut Decoder(&e.0)), Some(training));
        assert_eq!(decode_training(&mut Decoder(&e.0[..e.0.len() - 1])), None);
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_found() {
        let bytes = example().guide().to_bytes();
        for length in (0..200).chain(bytes.len() - 200..bytes.len()) {
            assert!(Guide::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        for bit in (0..200 * 8).chain((200 * 8..bytes.len() * 8).step_by(977)) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Guide::from_bytes(&damaged).is_err(), "bit {bit}");
        }
        assert_eq!(Guide::from_bytes(b"GLANZCKP"), Err(GuideFileError::Foreign));
        let mut newer = bytes;
        newer[8] = 9;
        assert_eq!(Guide::from_bytes(&newer), Err(GuideFileError::Version(9)));
    }

    static EXAMPLE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();

    proptest! {
        #[test]
        fn no_bytes_make_it_panic_or_hang(
            changes in prop::collection::vec((PREFIX_LENGTH..1500, any::<u8>()), 1..8), cut in 0_usize..100,
        ) {
            let mut bytes = EXAMPLE.get_or_init(|| example().guide().to_bytes()).clone();
            for (at, value) in changes {
                bytes[at] = value;
            }
            bytes.truncate(bytes.len() - CRC_LENGTH - cut);
            let length = (bytes.len() + CRC_LENGTH) as u64;
            bytes[12..20].copy_from_slice(&length.to_le_bytes());
            let crc = crc32fast::hash(&bytes);
            bytes.extend_from_slice(&crc.to_le_bytes());
            if let Ok(guide) = Guide::from_bytes(&bytes) {
                // Whatever is taken can be used.
                let place = guide.place(DVec3::new(0.3, 0.4, 0.5), DVec3::Z);
                let _ = guide.sample(&place, DVec2::new(0.2, 0.7));
                let _ = guide.pdf(&place, DVec3::X);
                let _ = guide.taught(&guide.lessons());
            }
        }
    }
}
