//! The guide that grows: cells, each with a tree of directions and a share.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::GuideSize;
use super::cells::GuideCells;
use super::directions::{DirectionSample, DirectionTrees, QuadtreeLeaf, QuadtreeNode};
use super::light_groups::LightGroups;
use super::mixture::MixtureWeight;
use super::training_sums::{CellTrainingSums, LIGHT_QUANTA, TrainingSums};

/// Records above which a cell is halved: this times the square root of all records of a pass, so that cells become finer and know
/// more at the same time, in pictures of any size (@muller2017: with the square root of the samples of a pixel).
const CELLS_BY_RECORDS: f64 = 4.0;

/// The least that this may be.
const FEWEST_RECORDS: f64 = 1000.0;

/// Effective samples of light that a cell has to have to be halved; as many records may hold less, where light is rare.
const FEWEST_TO_HALVE: f64 = 16.0;

/// Effective samples of light that a tree of directions needs; with fewer the old one stays.
const FEWEST_TO_LEARN: f64 = 16.0;

/// Weight of a sample of earlier passes relative to a new one.
const REMEMBERED: f64 = 1.0;

/// Lamps sampled in a cell that tell something; with fewer it keeps what it knows of them.
const FEWEST_LAMPS: u64 = 64;

/// Cells at most. A tree of directions has some ten squares of 64 bytes, and 128 more each to learn.
const MAX_CELLS: u32 = 1 << 15;

/// Result of the update of a cell.
#[derive(Clone, Debug, Default)]
struct CellUpdate {
    records: u64,
    /// Equal samples that would tell as much of the light.
    effective: f64,
    /// Its tree; `None` as long as it knows nothing.
    tree: Option<Vec<QuadtreeNode>>,
    share: MixtureWeight,
    lamps: LightGroups,
    flux: f64,
}

/// Guide data of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuideCell {
    /// Root of its tree of directions.
    pub(crate) root: u32,
    /// Mixture weight of the tree; 0 as long as it holds no light.
    pub(crate) share: MixtureWeight,
    pub(crate) lamps: LightGroups,
    /// Equal samples that would tell as much of the light as is known.
    pub(crate) effective: f64,
    /// Luminance times cosine over all directions, as far as paths bring it; 0 as long as it is not known.
    pub(crate) flux: f64,
}

/// A guide of cells and directions that refine themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeGuide {
    pub(crate) cells: GuideCells,
    pub(crate) known: Vec<GuideCell>,
    pub(crate) trees: DirectionTrees,
    /// Mean luminance of the picture; 0 as long as it is not known.
    pub(crate) brightness: f64,
}

/// The knowledge that a vertex has at its disposal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedVertex {
    pub(crate) cell: u32,
    root: u32,
    /// Probability that the guide draws.
    pub(crate) probability: f64,
    /// Luminance times cosine over all directions, as far as paths bring it; 0 as long as it is not known.
    pub(crate) flux: f64,
}

impl TreeGuide {
    /// A guide over `bounds` that knows nothing.
    pub(crate) fn new(bounds: &Bounds3) -> Self {
        let (cells, mut trees) = (GuideCells::new(bounds), DirectionTrees::default());
        let known = (0..cells.count())
            .map(|_| GuideCell {
                root: trees.push_blank(),
                share: MixtureWeight(0),
                lamps: LightGroups::UNKNOWN,
                effective: 0.0,
                flux: 0.0,
            })
            .collect();
        Self { cells, known, trees, brightness: 0.0 }
    }

    /// Guide data at a position with that unit normal.
    #[inline]
    pub(crate) fn place(&self, position: DVec3, normal: DVec3) -> GuidedVertex {
        let cell = self.cells.find(position, normal);
        match self.known.get(cell as usize) {
            Some(known) => GuidedVertex {
                cell,
                root: known.root,
                probability: known.share.probability(),
                flux: known.flux,
            },
            None => GuidedVertex { cell, root: 0, probability: 0.0, flux: 0.0 },
        }
    }

    /// Probabilities of the light groups there.
    #[inline]
    pub(crate) fn lamps(&self, place: &GuidedVertex) -> &LightGroups {
        self.known.get(place.cell as usize).map_or(&LightGroups::UNKNOWN, |known| &known.lamps)
    }

    /// Draws a direction.
    #[inline]
    pub(crate) fn sample(&self, place: &GuidedVertex, xi: DVec2) -> Option<DirectionSample> {
        self.trees.sample(place.root, xi)
    }

    /// Density per steradian of `direction`, and its leaf.
    #[inline]
    pub(crate) fn pdf(&self, place: &GuidedVertex, direction: DVec3) -> (f64, u32) {
        self.trees.pdf(place.root, direction)
    }

    /// Empty sums for what is to be learnt on top of this guide.
    pub(crate) fn lessons(&self) -> TrainingSums {
        TrainingSums::new(self.known.len(), 16 * self.trees.0.len())
    }

    /// The guide that follows from `lessons` on this one. `typical`: the luminance that is their unit; `brightness`: mean of the
    /// picture.
    pub(crate) fn taught(&self, lessons: &TrainingSums, typical: f64, brightness: f64) -> Self {
        let taught: Vec<CellUpdate> =
            (0..self.cells.count()).map(|cell| self.taught_cell(cell, lessons, typical)).collect();
        let limit = (CELLS_BY_RECORDS * (lessons.records() as f64).sqrt()).max(FEWEST_RECORDS);
        let mut room = MAX_CELLS.saturating_sub(self.cells.count());
        let halvings: Vec<u32> = taught
            .iter()
            .map(|taught| {
                let ratio = (taught.records as f64 / limit).min(taught.effective / FEWEST_TO_HALVE);
                let wanted = ratio.log2().ceil().max(0.0) as u32;
                // 2^n cells instead of one.
                let halvings = wanted.min((room + 1).ilog2());
                room -= (1 << halvings) - 1;
                halvings
            })
            .collect();
        let (mut known, mut trees) = (Vec::new(), DirectionTrees::default());
        let cells =
            self.cells.halved(&|cell| halvings.get(cell as usize).copied().unwrap_or(0), &mut |old| {
                let halvings = halvings.get(old as usize).copied().unwrap_or(0);
                if let Some(CellUpdate { tree, share, lamps, effective, flux, .. }) = taught.get(old as usize)
                {
                    let root = match tree {
                        Some(tree) => trees.push(tree),
                        None => trees.push_blank(),
                    };
                    let share = if trees.is_lit(root) { *share } else { MixtureWeight(0) };
                    // Each half knows what the whole knew, but half as well.
                    let effective = effective * 0.5_f64.powi(halvings as i32);
                    known.push(GuideCell { root, share, lamps: *lamps, effective, flux: *flux });
                }
            });
        Self { cells, known, trees, brightness }
    }

    fn taught_cell(&self, cell: u32, lessons: &TrainingSums, typical: f64) -> CellUpdate {
        let Some(old) = self.known.get(cell as usize) else { return CellUpdate::default() };
        let CellTrainingSums { records, light, squared_light, moments, lamps, lamp_moments } =
            lessons.cell(cell);
        let lamps = if lamps >= FEWEST_LAMPS { LightGroups::learnt(lamps, &lamp_moments) } else { old.lamps };
        let new = if squared_light > 0.0 { light * light / squared_light } else { 0.0 };
        let kept = REMEMBERED * old.effective;
        let effective = new + kept;
        // Sums of the pass, and those before in the same unit.
        let all = self.trees.total(old.root, &|leaf| lessons.weight(leaf));
        let weight = |leaf: QuadtreeLeaf| lessons.weight(leaf) + leaf.share * all * kept / new;
        let enough = new >= FEWEST_TO_LEARN;
        match enough.then(|| self.trees.refined(old.root, effective, &weight)).flatten() {
            Some(tree) => {
                // The moments of a tree without light are meaningless: equal weights, and the next pass decides.
                let lit = self.trees.is_lit(old.root);
                let share = if lit { old.share.better(new, &moments) } else { MixtureWeight::HALF };
                let flux = typical * light / (LIGHT_QUANTA * records as f64);
                CellUpdate { records, effective, tree: Some(tree), share, lamps, flux }
            }
            // The old tree as it is.
            None => {
                let tree = self.trees.is_lit(old.root).then(|| self.trees.tree(old.root));
                CellUpdate {
                    records,
                    effective: old.effective,
                    tree,
                    share: old.share,
                    lamps,
                    flux: old.flux,
                }
            }
        }
    }

    /// Its size.
    pub(crate) fn size(&self) -> GuideSize {
        let divided = self.trees.0.iter().flat_map(|square| square.child).filter(|&child| child != 0).count();
        let bytes = size_of_val(self.cells.nodes.as_slice())
            + size_of_val(self.known.as_slice())
            + size_of_val(self.trees.0.as_slice())
            + 8 * self.lesson_words();
        GuideSize {
            cells: self.known.len(),
            active: self.known.iter().filter(|cell| cell.share != MixtureWeight(0)).count(),
            leaves: 16 * self.trees.0.len() - divided,
            bytes,
        }
    }

    /// Number of words of [`TreeGuide::lessons`].
    pub(crate) fn lesson_words(&self) -> usize {
        TrainingSums::words_for(self.known.len(), 16 * self.trees.0.len())
    }
}
