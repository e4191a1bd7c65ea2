//! Path guiding: densities of incident light and their training.
//!
//! A [`Guide`] is a density of directions at every point. It is learnt in passes: every pass
//! takes twice as many samples of each pixel as the one before, guided by its results. During a pass the guide is fixed, and
//! the light of the paths is summed as integers ([`Training`]), so that a sample depends on its number alone, and a picture on
//! scene, settings and seed alone.
//!
//! - `cells`: space and normals, divided where there are many paths;
//! - `directions`: for each cell a density over the sphere, finer in directions of light;
//! - `light_groups`: for each cell, probabilities of selecting lights;
//! - `mixture`: probabilities of sampling guide and BSDF;
//! - `survival`: Russian roulette by the expected contribution of a path;
//! - `record`, `training_sums`: the light of a path, and the sums over all paths;
//! - `training`: the passes;
//! - `grid`: the guide of document 003, a fixed grid of cells and densities in a selected basis, for its experiments.
//!
//! # Source
//! Document 003 chapter 3 (a grid of cells on each surface, a fixed grid of directions, densities learnt in passes);
//! @muller2017 (trees for both, passes of doubled length, halving by records), @muller2019 (passes weighted by their variance, a
//! learnt mixture), @rath2020 (densities proportional to the root of squared light), @dahm2017 (expected instead of sampled light from the next
//! vertex), @vorba2014. Departures: cells are also divided by normals; the mixture is selected by its second moment on a grid;
//! light that light sampling can also find counts with its weight of multiple importance sampling only; all sums are integers.

use glanz_scene::Scene;
use glanz_scene::description::GuideSettings;

mod cells;
mod directions;
mod file;
mod grid;
mod light_groups;
mod mixture;
mod record;
pub(crate) mod survival;
mod training;
mod training_sums;
mod tree;

pub use file::GuideFileError;
pub use grid::{GridError, GridGuide};
pub use training::Training;
pub use tree::TreeGuide;

pub(crate) use file::{decode_training, encode_training};
pub(crate) use grid::{GridRecord, GridSample, GridVertex};
pub(crate) use mixture::density;
pub(crate) use record::{DirectionRecord, LightGroupRecord, PathRecords};
pub(crate) use tree::GuidedVertex;

/// Densities of incident light.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Guide {
    /// Cells and directions that refine themselves.
    Tree(TreeGuide),
    /// A fixed grid of cells on each surface, as in document 003.
    Grid(GridGuide),
}

/// Size of a guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuideSize {
    /// Number of cells.
    pub cells: usize,
    /// Number of cells in which the guide samples directions.
    pub active: usize,
    /// Number of leaves of the directions of all cells.
    pub leaves: usize,
    /// Memory of the guide and of the sums for the next one, bytes.
    pub bytes: usize,
}

impl Guide {
    /// An untrained guide for `scene`.
    ///
    /// # Errors
    /// [`GridError`] if a grid cannot be built.
    pub fn new(scene: &Scene, settings: &GuideSettings) -> Result<Self, GridError> {
        Ok(match settings {
            GuideSettings::Tree => Self::Tree(TreeGuide::new(&scene.bounds())),
            GuideSettings::Grid(settings) => Self::Grid(GridGuide::new(scene, settings)?),
        })
    }

    /// Its settings.
    #[must_use]
    pub fn settings(&self) -> GuideSettings {
        match self {
            Self::Tree(_) => GuideSettings::Tree,
            Self::Grid(grid) => GuideSettings::Grid(grid.settings()),
        }
    }

    /// Its size.
    #[must_use]
    pub fn size(&self) -> GuideSize {
        match self {
            Self::Tree(tree) => tree.size(),
            Self::Grid(grid) => grid.size(),
        }
    }
}
