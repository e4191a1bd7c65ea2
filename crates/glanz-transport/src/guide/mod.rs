//! Path guiding: densities of incident light and their training.
//!
//! A [`Guide`] answers for a place and a direction: how dense shall directions be there? It is learnt in passes: pass after pass
//! takes twice as many samples of each pixel, guided by what the pass before found. During a pass the guide is fixed and
//! what the paths find is added up as integers ([`Training`]), so that a sample depends on its number alone, and a picture on nothing
//! but scene, settings and seed.
//!
//! - `cells`: space and normals, divided where paths come often;
//! - `directions`: for each cell a density over the sphere, fine where light is;
//! - `lamps`: for each cell, which lamps matter;
//! - `mixture`: how often the guide draws and how often the BSDF;
//! - `survival`: whether a path is worth going on with;
//! - `record`, `lessons`: what a path found, and the sums over all paths;
//! - `training`: the passes;
//! - `grid`: document 003's own guide instead, a fixed grid of cells and densities in a chosen basis, for its experiments.
//!
//! # Source
//! Document 003 chapter 3 (a grid of cells on each surface, a fixed grid of directions, densities learnt in passes);
//! @muller2017 (trees for both, passes of doubled length, halving by records), @muller2019 (passes weighted by their variance, a
//! learnt mixture), @rath2020 (densities in proportion to the root of squared light), @dahm2017 (light from the next vertex as it is
//! expected there), @vorba2014. Departures: normals part cells; the mixture is chosen by its second moment on a grid;
//! light that light sampling finds too counts with its weight of multiple importance sampling only; all sums are integers.

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

/// Knows where light comes from.
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
    /// Parts of space that learn apart.
    pub cells: usize,
    /// Those in which the guide draws directions at all.
    pub active: usize,
    /// Leaves of the directions of all cells.
    pub leaves: usize,
    /// Memory of the guide and of the sums for the next one, bytes.
    pub bytes: usize,
}

impl Guide {
    /// A guide for `scene` that knows nothing.
    ///
    /// # Errors
    /// [`GridError`] if a grid cannot be made.
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
