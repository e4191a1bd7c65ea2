//! The leaves of a surface as rays need them, in the order of the hierarchy.

use glanz_math::glam::DVec4;

use super::bicubic::Bicubic;
use super::leaf::{Draft, Frame};
use super::search::{self, Net, OnRoot, Probe, Scratch};
use crate::bvh::simd::Simd;

/// Largest ratio of the weights of a leaf that is stored by powers: their rounding is that of the largest weight, and
/// counts by the smallest. Bernstein coefficients, of which every point is a mean, do not mind.
const EVEN_WEIGHTS: f64 = 4.0;

/// The leaves, all of one kind, so that the search branches once per ray.
#[derive(Debug)]
pub(super) enum Leaves {
    /// Degrees up to (3, 3), all weights equal within each patch.
    Polynomial(Vec<Bicubic<3>>),
    /// Degrees up to (3, 3), weights that vary little within a leaf.
    Rational(Vec<Bicubic<4>>),
    /// Any degrees and weights.
    General(General),
}

/// Leaves that can be asked by their position.
pub(super) trait LeafList {
    /// Reports every root of the leaf, in no order.
    fn roots<S: Simd>(
        &self,
        simd: S,
        ordinal: usize,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    );
    /// Asks the memory for a leaf that will be visited soon.
    fn prefetch<S: Simd>(&self, simd: S, ordinal: usize);
}

/// Leaves of any degrees.
#[derive(Debug, Default)]
pub(super) struct General {
    leaves: Vec<GeneralLeaf>,
    /// Their homogeneous coefficients.
    points: Vec<DVec4>,
}

#[derive(Debug)]
struct GeneralLeaf {
    frame: Frame,
    degrees: (u8, u8),
    /// Start of its coefficients.
    start: u32,
}

impl Leaves {
    /// Those of `drafts`, in their order.
    pub(super) fn new<'a>(drafts: impl Iterator<Item = &'a Draft> + Clone) -> Self {
        let fast =
            drafts.clone().all(|d| d.degrees.0 <= 3 && d.degrees.1 <= 3 && d.weight_ratio() <= EVEN_WEIGHTS);
        if !fast {
            let mut general = General::default();
            drafts.for_each(|draft| general.push(draft));
            Self::General(general)
        } else if drafts.clone().all(|d| d.is_polynomial()) {
            Self::Polynomial(drafts.map(|d| Bicubic::new(&d.net, d.degrees, &d.frame)).collect())
        } else {
            Self::Rational(drafts.map(|d| Bicubic::new(&d.net, d.degrees, &d.frame)).collect())
        }
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Polynomial(leaves) => size_of_val(&**leaves),
            Self::Rational(leaves) => size_of_val(&**leaves),
            Self::General(general) => size_of_val(&*general.leaves) + size_of_val(&*general.points),
        }
    }
}

impl<const LISTS: usize> LeafList for Vec<Bicubic<LISTS>> {
    #[inline(always)]
    fn roots<S: Simd>(
        &self,
        simd: S,
        ordinal: usize,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    ) {
        if let Some(leaf) = self.get(ordinal) {
            leaf.roots(simd, probe, scratch, report);
        }
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, ordinal: usize) {
        if let Some(leaf) = self.get(ordinal) {
            leaf.prefetch(simd);
        }
    }
}

impl LeafList for General {
    #[inline(always)]
    fn roots<S: Simd>(
        &self,
        simd: S,
        ordinal: usize,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    ) {
        if let Some(leaf) = self.leaves.get(ordinal) {
            search::roots(simd, &leaf.frame, || self.net(leaf), probe, scratch, report);
        }
    }

    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, ordinal: usize) {
        if let Some(leaf) = self.leaves.get(ordinal) {
            simd.prefetch(leaf);
        }
    }
}

impl General {
    fn push(&mut self, draft: &Draft) {
        let (p, q) = draft.degrees;
        let start = self.points.len() as u32;
        self.points.extend_from_slice(&draft.net);
        self.leaves.push(GeneralLeaf { frame: draft.frame, degrees: (p as u8, q as u8), start });
    }

    #[inline(always)]
    fn net(&self, leaf: &GeneralLeaf) -> Net<'_> {
        let degrees = (usize::from(leaf.degrees.0), usize::from(leaf.degrees.1));
        let start = leaf.start as usize;
        let end = start + (degrees.0 + 1) * (degrees.1 + 1);
        Net { degrees, points: self.points.get(start..end).unwrap_or_default() }
    }
}
