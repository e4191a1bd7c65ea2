//! Guide files, for renders with a fixed guide.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZGDE` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 | kind of guide: 0, cells and directions that refine themselves; 1, a grid |
//! | 8 | brightness of the picture |
//! | 24, 24 | corner and sides of the bounds |
//! | 4; 5 each | nodes of the cells: axis, first half; or 3, number of the cell |
//! | 85 each | cells: root of the tree of directions, mixture weight, probabilities of the light groups, effective samples, flux |
//! | 4; 64 each | squares of the directions: shares of the parts, their own squares |
//! | | or, of a grid: |
//! | 1; n | length of the settings; settings |
//! | 4 | passes learnt from |
//! | 4; 1, 33 or 49 each | shapes: 0, no chart; 1, smallest and largest parameters; 2, corners of a box |
//! | 1 or 1 + 4 each each | cells: 0, nothing; 1, coefficients of the density |
//! | 4 | CRC-32 (IEEE) of all preceding bytes |
//!
//! Numbers are little-endian.

use glanz_math::DVec3;

use super::cells::{GuideCells, GuideNode};
use super::directions::{DirectionTrees, QuadtreeNode};
use super::grid::{decode_grid, decode_sums, encode_grid, encode_sums};
use super::light_groups::LightGroups;
use super::mixture::{MixtureWeight, SHARES};
use super::training::PassSums;
use super::tree::{GuideCell, TreeGuide};
use super::{Guide, Training};
use crate::codec::{Decoder, Encoder, EnvelopeError, FileEnvelope};

/// Envelope of guide files.
const ENVELOPE: FileEnvelope =
    FileEnvelope { magic: b"GLANZGDE", version: 2, content: "the guide", kind: "a guide of Glanz" };

/// Kinds of guides.
const TREE: u8 = 0;
const GRID: u8 = 1;

/// Code of a cell in place of an axis.
const CELL: u8 = 3;

/// Errors of reading a guide.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GuideFileError {
    /// Another kind or version of file, or a damaged one.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// An intact file with content that this program does not write.
    #[error("the guide is invalid: {0}")]
    Content(&'static str),
}

impl Guide {
    /// The bytes of the file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        ENVELOPE.seal(|e| encode_guide(e, self))
    }

    /// Reads the output of [`Guide::to_bytes`]. Memory is limited to a few times the size of `bytes`, whatever their content.
    ///
    /// # Errors
    /// [`GuideFileError`] if any bit differs from the written file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, GuideFileError> {
        let mut d = Decoder(ENVELOPE.open(bytes)?);
        let guide = decode_guide(&mut d).ok_or(GuideFileError::Content("its trees or densities"))?;
        if d.0.is_empty() { Ok(guide) } else { Err(GuideFileError::Content("its size")) }
    }
}

fn encode_guide(e: &mut Encoder, guide: &Guide) {
    match guide {
        Guide::Tree(tree) => {
            e.u8(TREE);
            encode_tree(e, tree);
        }
        Guide::Grid(grid) => {
            e.u8(GRID);
            encode_grid(e, grid);
        }
    }
}

fn decode_guide(d: &mut Decoder<'_>) -> Option<Guide> {
    match d.u8()? {
        TREE => decode_tree(d).map(Guide::Tree),
        GRID => decode_grid(d).map(Guide::Grid),
        _ => None,
    }
}

fn encode_tree(e: &mut Encoder, tree: &TreeGuide) {
    let TreeGuide { cells, known, trees, brightness } = tree;
    for value in [*brightness].into_iter().chain(cells.min.to_array()).chain(cells.size.to_array()) {
        e.f64(value);
    }
    e.u32(cells.nodes.len() as u32);
    for node in &cells.nodes {
        let (tag, number) = match *node {
            GuideNode::Halved { axis, low } => (axis, low),
            GuideNode::GuideCell(cell) => (CELL, cell),
        };
        e.u8(tag);
        e.u32(number);
    }
    for cell in known {
        e.u32(cell.root);
        e.u8(cell.share.0);
        cell.light_groups.shares.iter().for_each(|share| e.u32(share.to_bits()));
        e.f64(cell.effective);
        e.f64(cell.flux);
    }
    e.u32(trees.0.len() as u32);
    for square in &trees.0 {
        square.share.iter().chain(&square.child).for_each(|&number| e.u16(number));
    }
}

fn decode_tree(d: &mut Decoder<'_>) -> Option<TreeGuide> {
    let brightness = d.f64().filter(|&b| b >= 0.0 && b.is_finite())?;
    let min = DVec3::new(d.f64()?, d.f64()?, d.f64()?);
    let size = DVec3::new(d.f64()?, d.f64()?, d.f64()?);
    let mut nodes = Vec::new();
    for _ in 0..d.u32()? {
        let (tag, number) = (d.u8()?, d.u32()?);
        nodes.push(if tag == CELL {
            GuideNode::GuideCell(number)
        } else {
            GuideNode::Halved { axis: tag, low: number }
        });
    }
    let cells = GuideCells::from_parts(min, size, nodes)?;
    let mut known = Vec::new();
    for _ in 0..cells.count() {
        let (root, share) = (d.u32()?, MixtureWeight(d.u8()?));
        let mut light_groups = LightGroups::UNKNOWN;
        for slot in &mut light_groups.shares {
            *slot = f32::from_bits(d.u32()?);
        }
        known.push(GuideCell { root, share, light_groups, effective: d.f64()?, flux: d.f64()? });
    }
    let mut trees = Vec::new();
    for _ in 0..d.u32()? {
        let mut square = QuadtreeNode::default();
        for slot in square.share.iter_mut().chain(&mut square.child) {
            *slot = d.u16()?;
        }
        trees.push(square);
    }
    let trees = DirectionTrees(trees);
    let sound = |cell: &GuideCell| {
        (cell.root as usize) < trees.0.len()
            && usize::from(cell.share.0) < SHARES
            && (cell.share.0 == 0 || trees.is_lit(cell.root))
            && cell.light_groups.is_valid()
            && cell.effective >= 0.0
            && cell.effective.is_finite()
            && cell.flux >= 0.0
            && cell.flux.is_finite()
    };
    (trees.is_valid(known.iter().map(|cell| cell.root)) && known.iter().all(sound)).then_some(TreeGuide {
        cells,
        known,
        trees,
        brightness,
    })
}

/// Appends the state of a training.
pub(crate) fn encode_training(e: &mut Encoder, training: &Training) {
    encode_guide(e, &training.guide);
    e.f64(training.typical.unwrap_or_default());
    match &training.sums {
        PassSums::Tree(sums) => sums.to_words().into_iter().for_each(|word| e.u64(word)),
        PassSums::Grid(sums) => encode_sums(e, sums),
    }
}

/// Reads the output of [`encode_training`]; `None` if malformed.
pub(crate) fn decode_training(d: &mut Decoder<'_>) -> Option<Training> {
    let guide = decode_guide(d)?;
    let typical = d.f64()?;
    let typical = match typical {
        0.0 => None,
        _ if typical > 0.0 && typical.is_finite() => Some(typical),
        _ => return None,
    };
    let sums = match &guide {
        Guide::Tree(tree) => {
            let words = tree.sum_words();
            let (words, _) = d.take(words.checked_mul(8)?)?.as_chunks::<8>();
            let mut sums = tree.sums();
            sums.set_words(words.iter().map(|word| u64::from_le_bytes(*word)));
            PassSums::Tree(sums)
        }
        Guide::Grid(grid) => PassSums::Grid(decode_sums(d, grid)?),
    };
    Some(Training { guide, sums, typical })
}

#[cfg(test)]
mod tests {
    use glanz_light::{Spectrum, Wavelengths};
    use glanz_math::{Bounds3, DVec2};
    use proptest::prelude::*;

    use super::*;
    use crate::codec::{CRC_LENGTH, PREFIX_LENGTH, resealed};
    use crate::guide::{DirectionRecord, PathRecords};

    /// A guide trained in two passes with light around one direction, in its third pass.
    fn example() -> Training {
        let bounds = Bounds3::new(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
        let mut training = Training::new(Guide::Tree(TreeGuide::new(&bounds)));
        training.finish_pass(1.0);
        for _ in 0..3 {
            if training.records() > 0 {
                training.finish_pass(1.0);
            }
            for i in 0..5000_u32 {
                let xi = DVec2::new(f64::from(i).sqrt().fract(), f64::from(i) * 0.618 % 1.0);
                let position = DVec3::new(2.0 * xi.x, xi.y, 0.5);
                let Guide::Tree(tree) = training.guide() else { panic!("it is a tree") };
                let place = tree.place(position, DVec3::Z);
                let direction = DVec3::new(0.3 * xi.y, 0.1 * xi.x, 1.0).normalize();
                let (guide_pdf, leaf) = tree.pdf(&place, direction);
                let beyond = Spectrum::splat(0.5);
                let record = DirectionRecord {
                    cell: place.cell,
                    leaf,
                    cosine: direction.z,
                    guide_pdf,
                    bsdf_pdf: 0.3,
                    pdf: 0.3,
                    light: Spectrum::BLACK,
                    throughput: Spectrum::ONE,
                    beyond,
                    is_dispersed: false,
                    next: None,
                };
                let mut records = PathRecords::default();
                records.push(record);
                training.learn(&records, Spectrum::splat(1.0), &Wavelengths::default());
            }
        }
        training
    }

    #[test]
    fn written_guides_are_read_back() {
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
    fn every_truncation_and_every_flipped_bit_is_detected() {
        let bytes = example().guide().to_bytes();
        for length in (0..200).chain(bytes.len() - 200..bytes.len()) {
            assert!(Guide::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        for bit in (0..200 * 8).chain((200 * 8..bytes.len() * 8).step_by(977)) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Guide::from_bytes(&damaged).is_err(), "bit {bit}");
        }
        let foreign = EnvelopeError::Foreign("a guide of Glanz");
        assert_eq!(Guide::from_bytes(b"GLANZCKP"), Err(foreign.into()));
        let mut newer = bytes;
        newer[8] = 9;
        let version = EnvelopeError::Version { content: "the guide", found: 9, known: 2 };
        assert_eq!(Guide::from_bytes(&newer), Err(version.into()));
    }

    static EXAMPLE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();

    proptest! {
        #[test]
        fn arbitrary_bytes_neither_panic_nor_hang(
            changes in prop::collection::vec((PREFIX_LENGTH..1500, any::<u8>()), 1..8), cut in 0_usize..100,
        ) {
            let mut bytes = EXAMPLE.get_or_init(|| example().guide().to_bytes()).clone();
            for (at, value) in changes {
                bytes[at] = value;
            }
            bytes.truncate(bytes.len() - CRC_LENGTH - cut);
            if let Ok(Guide::Tree(tree)) = Guide::from_bytes(&resealed(bytes)) {
                // Accepted guides can be used.
                let place = tree.place(DVec3::new(0.3, 0.4, 0.5), DVec3::Z);
                let _ = tree.sample(&place, DVec2::new(0.2, 0.7));
                let _ = tree.pdf(&place, DVec3::X);
                let _ = tree.fitted(&tree.sums(), 1.0, 1.0);
            }
        }
    }
}
