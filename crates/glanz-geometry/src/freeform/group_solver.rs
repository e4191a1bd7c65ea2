//! The roots of eight pairs of a ray and a leaf that wait in a group.

use glanz_math::DVec2;

use super::bicubic::Bicubic;
use super::leaf::PatchLeaf;
use super::net_lanes;
use super::newton_lanes;
use super::pair_lanes::{PairLanes, RootLanes};
use super::stream::StreamSearcher;
use super::subpatches::SubpatchList;
use crate::bvh::CompactRay;
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::{Simd, Task};

/// The search for the roots of the pairs of a group.
pub(super) struct GroupSolver<'a, 'b> {
    pub(super) searcher: &'a mut StreamSearcher<'b>,
    pub(super) rays: &'a mut [CompactRay],
    /// The group in the queue.
    pub(super) index: usize,
}

impl Task for GroupSolver<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { searcher, rays, index } = self;
        let surface = searcher.surface;
        let group = searcher.queue.group(index);
        let (ids, ordinals, mask) = (group.rays, group.leaves, group.mask());
        let Some(first) = surface.leaves.get(ordinals[0] as usize) else { return };
        // Lanes that are not in use repeat the first one.
        let mut leaves = [first; LANES];
        let mut pairs = ids;
        for (k, (leaf, ordinal)) in leaves.iter_mut().zip(ordinals).enumerate() {
            if mask >> k & 1 == 0 {
                pairs[k] = ids[0];
            } else if let Some(found) = surface.leaves.get(ordinal as usize) {
                *leaf = found;
            }
        }
        let pairs = group.pairs(simd, searcher.spaces(simd, &pairs, rays));
        let roots = match &*surface.subpatches {
            SubpatchList::Polynomial(list) => solve_bicubic(simd, list, &leaves, &pairs),
            SubpatchList::Rational(list) => solve_bicubic(simd, list, &leaves, &pairs),
            SubpatchList::General(list) => net_lanes::roots(simd, searcher.net, list, &leaves, &pairs),
        };
        let mut hard = mask;
        if let Some(RootLanes { converged, excluded, s, at }) = roots {
            let t = simd.store8(pairs.rays.t(simd, s));
            let (u, v) = (simd.store8(at[0]), simd.store8(at[1]));
            hard &= !(converged | excluded);
            let mut found = converged;
            while found != 0 {
                let k = found.trailing_zeros() as usize & (LANES - 1);
                found &= found - 1;
                searcher.add(leaves[k], ids[k], t[k], DVec2::new(u[k], v[k]), rays);
            }
        }
        while hard != 0 {
            let k = hard.trailing_zeros() as usize & (LANES - 1);
            hard &= hard - 1;
            searcher.search_one(simd, leaves[k], ids[k], rays);
        }
    }
}

/// The roots of eight pairs with bicubic patches.
#[inline(always)]
fn solve_bicubic<S: Simd, const COORDINATES: usize>(
    simd: S,
    list: &[Bicubic<COORDINATES>],
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> Option<RootLanes<S>> {
    let first = list.get(leaves[0].subpatch as usize)?;
    let mut patches = [first; LANES];
    let mut same = true;
    for (patch, leaf) in patches.iter_mut().zip(leaves) {
        if leaf.subpatch != leaves[0].subpatch {
            *patch = list.get(leaf.subpatch as usize)?;
            same = false;
        }
    }
    Some(if same {
        newton_lanes::roots(simd, &first, leaves, pairs)
    } else {
        newton_lanes::roots(simd, &patches, leaves, pairs)
    })
}
