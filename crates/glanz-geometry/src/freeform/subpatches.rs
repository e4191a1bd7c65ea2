//! Subpatches: the patches of a surface, split where their weights differ much, in the form in which rays search them.

use std::sync::Arc;

use glanz_math::glam::DVec4;

use super::bicubic::Bicubic;
use super::control_net;
use super::leaf::{LeafProjection, PatchLeaf};
use super::leaf_builder::is_more_curved_along_u;
use super::net_search::{self, HomogeneousNet};
use super::parameter_rect::DyadicRect;
use super::ray_space::RaySpace;
use super::reduced_net::ReducedNet;
use super::root::{SearchScratch, SurfaceRoot};
use super::surface_patch::SurfacePatch;
use crate::bvh::simd::{Simd, Task};
use crate::bvh::{PARALLEL_CHUNK, parallel_map};

/// Largest ratio of the weights of a subpatch. The rounding of powers is that of the largest weight, and counts by the
/// smallest; and next to a small weight one bit of a parameter is far on the surface.
const EVEN_WEIGHTS: f64 = 4.0;

/// A patch, or a part of it.
#[derive(Debug)]
pub(super) struct Subpatch {
    pub(super) location: SubpatchLocation,
    pub(super) degrees: (usize, usize),
    /// Homogeneous control points, shared with the patch if it is a whole one.
    pub(super) net: Arc<[DVec4]>,
    /// Whether it is evaluated with weights: where one of its patch is not 1, and in a [`SubpatchList::General`] where one of the surface
    /// is not.
    pub(super) rational: bool,
}

/// The patch and the part of it that a subpatch is.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubpatchLocation {
    pub(super) patch: u32,
    pub(super) part: DyadicRect,
}

/// The subpatches of a surface, all in one representation, so that the branch on it is predicted.
#[derive(Debug)]
pub(super) enum SubpatchList {
    /// Degrees up to (3, 3), all weights 1. Where patches have no control points of their own, these are restored with that weight.
    Polynomial(Vec<Bicubic<3>>),
    /// Degrees up to (3, 3), weights that vary little.
    Rational(Vec<Bicubic<4>>),
    /// Any degrees and weights.
    General(Vec<Subpatch>),
}

/// The search for the roots of one leaf: a function of its own that all queries share, since it is long.
pub(super) struct LeafSearch<'a> {
    pub(super) subpatches: &'a SubpatchList,
    pub(super) reduced_nets: &'a [ReducedNet],
    pub(super) leaf: &'a PatchLeaf,
    pub(super) projection: &'a LeafProjection,
    pub(super) space: &'a RaySpace,
    pub(super) scratch: &'a mut SearchScratch,
}

impl Task for LeafSearch<'_> {
    /// The only root; several are in `scratch.roots`, unordered. In the parameters of the subpatch.
    type Output = Option<SurfaceRoot>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<SurfaceRoot> {
        let Self { subpatches, reduced_nets, leaf, projection, space, scratch } = self;
        let index = leaf.subpatch as usize;
        match subpatches {
            SubpatchList::Polynomial(list) => list.get(index)?.roots(simd, leaf, projection, space, scratch),
            SubpatchList::Rational(list) => list.get(index)?.roots(simd, leaf, projection, space, scratch),
            SubpatchList::General(list) => {
                let net = list.get(index)?.homogeneous_net();
                let reduced = reduced_nets.get(leaf.reduced_net as usize);
                net_search::roots(simd, net, reduced, leaf, projection, space, scratch)
            }
        }
    }
}

impl Subpatch {
    /// Adds the subpatches of the patch number `index` to `done`, none halved more often than `most_halvings`.
    pub(super) fn append_all(index: u32, patch: &SurfacePatch, most_halvings: usize, done: &mut Vec<Self>) {
        let mut open = vec![Self::whole(index, patch)];
        while let Some(subpatch) = open.pop() {
            if subpatch.weight_ratio() <= EVEN_WEIGHTS || subpatch.location.part.count() == most_halvings {
                done.push(subpatch);
            } else {
                open.extend(subpatch.halves());
            }
        }
    }

    pub(super) fn whole(patch: u32, from: &SurfacePatch) -> Self {
        let location = SubpatchLocation { patch, part: DyadicRect::WHOLE };
        let net = from.patch.shared_control_points();
        let rational = net.iter().any(|p| p.w != 1.0);
        Self { location, degrees: from.patch.degrees(), net, rational }
    }

    #[inline(always)]
    pub(super) fn homogeneous_net(&self) -> HomogeneousNet<'_> {
        HomogeneousNet { degrees: self.degrees, points: &self.net, rational: self.rational }
    }

    /// The largest weight over the smallest.
    fn weight_ratio(&self) -> f64 {
        let weights = || self.net.iter().map(|p| p.w);
        weights().fold(0.0, f64::max) / weights().fold(f64::INFINITY, f64::min)
    }

    /// Whether it can be stored as powers.
    fn is_simple(&self) -> bool {
        self.degrees.0.max(self.degrees.1) <= 3 && self.weight_ratio() <= EVEN_WEIGHTS
    }

    fn powers<const K: usize>(&self) -> Bicubic<K> {
        Bicubic::new(&self.net, self.degrees)
    }

    fn halves(&self) -> [Self; 2] {
        let Self { location: SubpatchLocation { patch, part }, degrees, ref net, rational } = *self;
        let across_u = is_more_curved_along_u(net, degrees);
        let [low, high] = part.halves(across_u);
        let [below, above] = control_net::split(net, degrees, across_u);
        [(low, below), (high, above)].map(|(part, net)| Self {
            location: SubpatchLocation { patch, part },
            degrees,
            net: net.into(),
            rational,
        })
    }
}

impl SubpatchList {
    /// The list of subpatches in the form that their degrees and weights allow.
    pub(super) fn new(mut subpatches: Vec<Subpatch>) -> Self {
        let rational = subpatches.iter().any(|subpatch| subpatch.rational);
        if subpatches.iter().all(Subpatch::is_simple) {
            if rational {
                Self::Rational(parallel_map(&subpatches, PARALLEL_CHUNK, Subpatch::powers))
            } else {
                // Those of a surface with coordinates of its own.
                Self::Polynomial(parallel_map(&subpatches, PARALLEL_CHUNK, Subpatch::powers))
            }
        } else {
            // All of them in one way, so that pairs of any two can be solved side by side.
            subpatches.iter_mut().for_each(|subpatch| subpatch.rational = rational);
            Self::General(subpatches)
        }
    }

    /// Memory, bytes, without control points that the patches share.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Polynomial(list) => size_of_val(&**list),
            Self::Rational(list) => size_of_val(&**list),
            Self::General(list) => {
                let own = list.iter().filter(|s| s.location.part.count() > 0);
                size_of_val(&**list) + own.map(|s| size_of_val(&*s.net)).sum::<usize>()
            }
        }
    }
}
