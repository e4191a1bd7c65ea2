//! What is known about where light comes from, and how it is learnt.
//!
//! A [`Guide`] answers for a place and a direction: how dense shall directions be there? It is learnt in passes: pass after pass
//! takes twice as many samples of each pixel, guided by what the pass before found. During a pass the guide is fixed and
//! what the paths find is added up as integers ([`Training`]), so that a sample depends on its number alone, and a picture on nothing
//! but scene, settings and seed.
//!
//! - `cells`: space and normals, divided where paths come often;
//! - `directions`: for each cell a density over the sphere, fine where light is;
//! - `mixture`: how often the guide draws and how often the BSDF;
//! - `record`, `lessons`: what a path found, and the sums over all paths;
//! - `training`: the passes.
//!
//! # Source
//! Document 003 chapter 3 (a grid of cells on each surface, a fixed grid of directions, densities learnt in passes);
//! @muller2017 (trees for both, passes of doubled length, halving by records), @muller2019 (passes weighted by their variance, a
//! learnt mixture), @vorba2014. Departures: normals part cells; the mixture is chosen by its second moment on a grid;
//! light that light sampling finds too counts with its weight of multiple importance sampling only; all sums are integers.

use glanz_math::{Bounds3, DVec2, DVec3};

mod cells;
mod directions;
mod file;
mod lessons;
mod mixture;
mod record;
mod training;
mod tree;

pub use file::GuideFileError;
pub use training::Training;
pub use tree::TreeGuide;

pub(crate) use directions::Draw;
pub(crate) use file::{decode_training, encode_training};
pub(crate) use lessons::Lessons;
pub(crate) use mixture::density;
pub(crate) use record::Record;
pub(crate) use training::pass;
pub(crate) use tree::Place;

/// Knows where light comes from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Guide {
    /// Cells and directions that refine themselves.
    Tree(TreeGuide),
}

/// How large a guide is.
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
    /// A guide over `bounds` that knows nothing.
    pub(crate) fn new(bounds: &Bounds3) -> Self {
        Self::Tree(TreeGuide::new(bounds))
    }

    /// What is known at a place whose surface has this unit normal on the viewer's side.
    #[inline]
    pub(crate) fn place(&self, position: DVec3, normal: DVec3) -> Place {
        match self {
            Self::Tree(tree) => tree.place(position, normal),
        }
    }

    /// Draws a direction; `None` where no light is known.
    #[inline]
    pub(crate) fn sample(&self, place: &Place, xi: DVec2) -> Option<Draw> {
        match self {
            Self::Tree(tree) => tree.sample(place, xi),
        }
    }

    /// Density per steradian of `direction`, and where it is learnt.
    #[inline]
    pub(crate) fn pdf(&self, place: &Place, direction: DVec3) -> (f64, u32) {
        match self {
            Self::Tree(tree) => tree.pdf(place, direction),
        }
    }

    /// Empty sums for what is to be learnt on top of this guide.
    pub(crate) fn lessons(&self) -> Lessons {
        match self {
            Self::Tree(tree) => tree.lessons(),
        }
    }

    /// The guide that follows from `lessons` on this one; `samples`: per pixel, in the pass.
    pub(crate) fn taught(&self, lessons: &Lessons) -> Self {
        match self {
            Self::Tree(tree) => Self::Tree(tree.taught(lessons)),
        }
    }

    /// How large it is.
    #[must_use]
    pub fn size(&self) -> GuideSize {
        match self {
            Self::Tree(tree) => tree.size(),
        }
    }
}
