//! Polynomial patches of low degrees turned into powers and leaves, while memory of their control points is given back.

use super::SurfacePatch;
use super::bicubic::Bicubic;
use super::build::{CHUNK, LeafRules};
use super::leaf_list::LeafList;
use super::net_corrections::NetCorrections;
use super::subpatches::Subpatch;
use super::surface_patch::PatchPlacement;
use crate::bvh::parallel_map;
use crate::bvh::simd::prefer_large_pages;

/// Number of patches whose control points are released together, a multiple of [`CHUNK`].
const PATCHES_PER_SEGMENT: usize = 256 * CHUNK;

/// Polynomial patches of degrees up to (3, 3) by their powers, with the leaves of all.
#[derive(Default)]
pub(super) struct PolynomialPatches {
    pub(super) placements: Vec<PatchPlacement>,
    pub(super) corrections: NetCorrections,
    pub(super) powers: Vec<Bicubic<3>>,
    pub(super) leaves: LeafList,
}

impl PolynomialPatches {
    /// Turns patches into powers and leaves, from the last to the first: memory that was allocated last goes back to the system first.
    pub(super) fn new(mut patches: Vec<SurfacePatch>, rules: &LeafRules<'_>) -> Self {
        let mut all = Self {
            placements: Vec::with_capacity(patches.len()),
            powers: Vec::with_capacity(patches.len()),
            ..Self::default()
        };
        prefer_large_pages(&mut all.powers);
        // A few are given back before: allocators keep the first of a size for reuse, and those must not be the last allocated.
        let few = CHUNK.min(patches.len());
        let mut first = Self::reversed(0, patches.get(..few).unwrap_or(&[]), rules);
        first.placements.extend(patches.drain(..few).rev().map(|patch| patch.placement));
        while !patches.is_empty() {
            let start = (patches.len() - 1) / PATCHES_PER_SEGMENT * PATCHES_PER_SEGMENT;
            let segment = patches.get(start..).unwrap_or(&[]);
            let chunks: Vec<_> = ((start + few) as u32..).step_by(CHUNK).zip(segment.chunks(CHUNK)).collect();
            let parts = parallel_map(&chunks, 1, |&(first, patches)| Self::reversed(first, patches, rules));
            parts.into_iter().rev().for_each(|part| all.append(part));
            all.placements.extend(patches.drain(start..).rev().map(|patch| patch.placement));
            patches.shrink_to_fit();
        }
        all.append(first);
        all.placements.reverse();
        all.corrections.reverse();
        all.powers.reverse();
        all.leaves.reverse();
        all
    }

    fn append(&mut self, part: Self) {
        self.placements.extend(part.placements);
        self.corrections.append(&part.corrections);
        self.powers.extend(part.powers);
        self.leaves.append(part.leaves);
    }

    /// Those of `patches`, of which the first is number `first`, without placements, in reverse order.
    fn reversed(first: u32, patches: &[SurfacePatch], rules: &LeafRules<'_>) -> Self {
        let mut part = Self { powers: Vec::with_capacity(patches.len()), ..Self::default() };
        for (index, patch) in (first..first + patches.len() as u32).zip(patches).rev() {
            let subpatch = Subpatch::whole(index, patch);
            let powers = Bicubic::new(&subpatch.net, subpatch.degrees);
            part.corrections.push(&subpatch.net, &powers.control_points(subpatch.degrees));
            part.powers.push(powers);
            let mut leaves = rules.leaves(index, &subpatch, &patch.placement);
            leaves.leaves.reverse();
            part.leaves.push_all(&leaves, &subpatch, &rules.frame);
        }
        part
    }
}
