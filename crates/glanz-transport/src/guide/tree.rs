//! The adaptive guide: cells, each with a tree of directions and a mixture weight.

use glanz_math::{Bounds3, DVec2, DVec3};

use super::GuideSize;
use super::cells::GuideCells;
use super::directions::{DirectionSample, DirectionTrees, QuadtreeLeaf, QuadtreeNode};
use super::light_groups::LightGroups;
use super::mixture::MixtureWeight;
use super::training_sums::{CellTrainingSums, LIGHT_QUANTA, TrainingSums};

/// Number of records above which a cell is halved: this times the square root of all records of a pass, so that cells become smaller and
/// more accurate at the same time, in pictures of any size (@muller2017: the square root of the samples of a pixel).
const CELLS_BY_RECORDS: f64 = 4.0;

/// Smallest number of records above which a cell is halved.
const FEWEST_RECORDS: f64 = 1000.0;

/// Smallest effective number of samples for halving a cell; where light is rare, it is less than the number of records.
const FEWEST_TO_HALVE: f64 = 16.0;

/// Smallest effective number of samples for a new tree of directions; with fewer the old tree is kept.
const FEWEST_TO_LEARN: f64 = 16.0;

/// Weight of a sample of earlier passes relative to a new one.
const REMEMBERED: f64 = 1.0;

/// Smallest number of light samples in a cell for new probabilities of the light groups; with fewer the old ones are kept.
const FEWEST_LIGHT_SAMPLES: u64 = 64;

/// Largest number of cells. A tree of directions has some ten squares of 64 bytes, and 128 bytes more each for training.
const MAX_CELLS: u32 = 1 << 15;

/// Result of the update of a cell.
#[derive(Clone, Debug, Default)]
struct CellUpdate {
    records: u64,
    /// Effective number of samples.
    effective: f64,
    /// Its tree; `None` for an untrained cell.
    tree: Option<Vec<QuadtreeNode>>,
    share: MixtureWeight,
    light_groups: LightGroups,
    flux: f64,
}

/// Guide data of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuideCell {
    /// Root of its tree of directions.
    pub(crate) root: u32,
    /// Mixture weight of the tree; 0 while it has no light.
    pub(crate) share: MixtureWeight,
    pub(crate) light_groups: LightGroups,
    /// Effective number of samples of the tree.
    pub(crate) effective: f64,
    /// Luminance times cosine over all directions, as far as paths bring it; 0 as long as it is not known.
    pub(crate) flux: f64,
}

/// A guide of adaptive cells and directions.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeGuide {
    pub(crate) cells: GuideCells,
    pub(crate) known: Vec<GuideCell>,
    pub(crate) trees: DirectionTrees,
    /// Mean luminance of the picture; 0 while it is unknown.
    pub(crate) brightness: f64,
}

/// Guide data of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedVertex {
    pub(crate) cell: u32,
    root: u32,
    /// Probability of sampling the guide.
    pub(crate) probability: f64,
    /// Luminance times cosine over all directions, as far as paths bring it; 0 as long as it is not known.
    pub(crate) flux: f64,
}

impl TreeGuide {
    /// An untrained guide over `bounds`.
    pub(crate) fn new(bounds: &Bounds3) -> Self {
        let (cells, mut trees) = (GuideCells::new(bounds), DirectionTrees::default());
        let known = (0..cells.count())
            .map(|_| GuideCell {
                root: trees.push_blank(),
                share: MixtureWeight(0),
                light_groups: LightGroups::UNKNOWN,
                effective: 0.0,
                flux: 0.0,
            })
            .collect();
        Self { cells, known, trees, brightness: 0.0 }
    }

    /// Guide data at a position with this unit normal.
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

    /// Probabilities of the light groups at a vertex.
    #[inline]
    pub(crate) fn light_groups(&self, place: &GuidedVertex) -> &LightGroups {
        self.known.get(place.cell as usize).map_or(&LightGroups::UNKNOWN, |known| &known.light_groups)
    }

    /// Samples a direction.
    #[inline]
    pub(crate) fn sample(&self, place: &GuidedVertex, xi: DVec2) -> Option<DirectionSample> {
        self.trees.sample(place.root, xi)
    }

    /// Density per steradian of `direction`, and its leaf.
    #[inline]
    pub(crate) fn pdf(&self, place: &GuidedVertex, direction: DVec3) -> (f64, u32) {
        self.trees.pdf(place.root, direction)
    }

    /// Empty sums for a pass with this guide.
    pub(crate) fn sums(&self) -> TrainingSums {
        TrainingSums::new(self.known.len(), 16 * self.trees.0.len())
    }

    /// The guide fitted to `sums` of this guide. `typical`: the luminance on which their unit is based; `brightness`: mean of the
    /// picture.
    pub(crate) fn fitted(&self, sums: &TrainingSums, typical: f64, brightness: f64) -> Self {
        let updates: Vec<CellUpdate> =
            (0..self.cells.count()).map(|cell| self.fitted_cell(cell, sums, typical)).collect();
        let limit = (CELLS_BY_RECORDS * (sums.records() as f64).sqrt()).max(FEWEST_RECORDS);
        let mut room = MAX_CELLS.saturating_sub(self.cells.count());
        let halvings: Vec<u32> = updates
            .iter()
            .map(|update| {
                let ratio = (update.records as f64 / limit).min(update.effective / FEWEST_TO_HALVE);
                let wanted = ratio.log2().ceil().max(0.0) as u32;
                // n halvings make 2^n cells of one.
                let halvings = wanted.min((room + 1).ilog2());
                room -= (1 << halvings) - 1;
                halvings
            })
            .collect();
        let (mut known, mut trees) = (Vec::new(), DirectionTrees::default());
        let cells =
            self.cells.halved(&|cell| halvings.get(cell as usize).copied().unwrap_or(0), &mut |old| {
                let halvings = halvings.get(old as usize).copied().unwrap_or(0);
                if let Some(CellUpdate { tree, share, light_groups, effective, flux, .. }) =
                    updates.get(old as usize)
                {
                    let root = match tree {
                        Some(tree) => trees.push(tree),
                        None => trees.push_blank(),
                    };
                    let share = if trees.is_lit(root) { *share } else { MixtureWeight(0) };
                    // Each half has the density of the whole, with half of its samples.
                    let effective = effective * 0.5_f64.powi(halvings as i32);
                    known.push(GuideCell {
                        root,
                        share,
                        light_groups: *light_groups,
                        effective,
                        flux: *flux,
                    });
                }
            });
        Self { cells, known, trees, brightness }
    }

    fn fitted_cell(&self, cell: u32, sums: &TrainingSums, typical: f64) -> CellUpdate {
        let Some(old) = self.known.get(cell as usize) else { return CellUpdate::default() };
        let CellTrainingSums { records, light, squared_light, moments, light_samples, light_moments } =
            sums.cell(cell);
        let light_groups = if light_samples >= FEWEST_LIGHT_SAMPLES {
            LightGroups::learnt(light_samples, &light_moments)
        } else {
            old.light_groups
        };
        let new = if squared_light > 0.0 { light * light / squared_light } else { 0.0 };
        let kept = REMEMBERED * old.effective;
        let effective = new + kept;
        // Sums of this pass, and those of earlier passes in the same unit.
        let all = self.trees.total(old.root, &|leaf| sums.weight(leaf));
        let weight = |leaf: QuadtreeLeaf| sums.weight(leaf) + leaf.share * all * kept / new;
        let enough = new >= FEWEST_TO_LEARN;
        match enough.then(|| self.trees.refined(old.root, effective, &weight)).flatten() {
            Some(tree) => {
                // The moments of a tree without light are meaningless: equal weights until the next pass.
                let lit = self.trees.is_lit(old.root);
                let share = if lit { old.share.better(new, &moments) } else { MixtureWeight::HALF };
                let flux = typical * light / (LIGHT_QUANTA * records as f64);
                CellUpdate { records, effective, tree: Some(tree), share, light_groups, flux }
            }
            // The old tree is kept.
            None => {
                let tree = self.trees.is_lit(old.root).then(|| self.trees.tree(old.root));
                CellUpdate {
                    records,
                    effective: old.effective,
                    tree,
                    share: old.share,
                    light_groups,
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
            + 8 * self.sum_words();
        GuideSize {
            cells: self.known.len(),
            active: self.known.iter().filter(|cell| cell.share != MixtureWeight(0)).count(),
            leaves: 16 * self.trees.0.len() - divided,
            bytes,
        }
    }

    /// Number of words of [`TreeGuide::sums`].
    pub(crate) fn sum_words(&self) -> usize {
        TrainingSums::words_for(self.known.len(), 16 * self.trees.0.len())
    }
}
