//! Construction of a surface: leaves of its patches, and the hierarchy over them.

use std::sync::atomic::AtomicU64;
use std::sync::{Arc, OnceLock};

use glanz_math::Bounds3;

use super::control_net::MAX_DEGREE;
use super::leaf::PatchLeaf;
use super::leaf_builder::LeafBuilder;
use super::parameter_rect::DyadicRect;
use super::patch_list::PatchList;
use super::ray_space::SurfaceFrame;
use super::subpatches::{self, Subpatch, SubpatchList, SubpatchLocation};
use super::{Freeform, SurfacePatch};
use crate::bvh::{BuildOptions, Bvh, PARALLEL_CHUNK, parallel_flat_map, parallel_map};
use crate::error::SurfaceError;
use crate::trim::{Containment, TrimRegion};

/// Largest Jacobian deviation of a leaf, projected along its normal, for degrees up to 3 and above: less than the limit of
/// the search, so that leaves are certified for most rays. Measured: for degrees up to 3 rays cost the same from 0.2 to 0.3,
/// with a third less memory. Leaves of higher degree cost more to evaluate, so that the better start of 0.2 pays; 0.15 would
/// be 4 % faster with half as much memory again.
const MOST_DEVIATION: [f64; 2] = [0.3, 0.2];

/// Largest number of halvings of a patch.
const MOST_HALVINGS: usize = 12;

/// Number of halvings after which further ones must reduce the deviation: two of them should halve it in any smooth patch...
const FIRST_HALVINGS: usize = 5;

/// ... and are continued only if they reduce it to this fraction.
const SUFFICIENT_REDUCTION: f64 = 0.75;

/// Size, relative to the surface, below which leaves are not halved further; the search halves them if a ray needs it.
const SMALLEST: f64 = 1e-6;

/// Cost of a leaf relative to a test of a node: between a block of triangles, 1, and other surfaces, 2.
const LEAF_COST: f32 = 1.5;

/// Subpatches that one thread divides at once.
const CHUNK: usize = 64;

impl Freeform {
    /// A surface of `patches`.
    ///
    /// Rays meet patches with a common border without a gap if their control points there are the same bits. Points of the two patches on
    /// that border agree up to [`SurfacePoint::error`](crate::SurfacePoint::error), not bit by bit.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without patches, [`SurfaceError::DegreeTooHigh`] above [`MAX_DEGREE`],
    /// [`SurfaceError::Degenerate`] if all control points coincide.
    pub fn try_new(patches: Vec<SurfacePatch>) -> Result<Self, SurfaceError> {
        if patches.is_empty() {
            return Err(SurfaceError::TooFew { parameter: "patches", count: 0, min: 1 });
        }
        let degrees = patches.iter().fold((0, 0), |(p, q), patch| {
            let (r, s) = patch.patch.degrees();
            (p.max(r), q.max(s))
        });
        let highest = degrees.0.max(degrees.1);
        if highest > MAX_DEGREE {
            let (degree, max) = (highest as u32, MAX_DEGREE as u32);
            return Err(SurfaceError::DegreeTooHigh { parameter: "the patch", degree, max });
        }
        let hull = hull(&patches);
        let size = hull.min.abs().max(hull.max.abs()).max_element();
        let extent = hull.diagonal().length();
        if !(extent > 0.0 && extent.is_finite()) {
            return Err(SurfaceError::Degenerate {
                reason: "all control points coincide, extent",
                value: extent,
            });
        }
        let frame = SurfaceFrame::new(&hull, size, degrees);
        let subpatches = subpatches::split(&patches, MOST_HALVINGS);
        let leaves = all_leaves(&subpatches, extent, &frame);
        Ok(Self::assemble(patches, extent, frame, subpatches, leaves, None))
    }

    /// The part of the surface that `region` keeps, by its parameters [`SurfacePoint::uv`](crate::SurfacePoint::uv).
    #[must_use]
    pub fn trimmed(&self, region: Arc<TrimRegion>) -> Self {
        let patches: Vec<SurfacePatch> = self.patches().collect();
        let subpatches = subpatches::split(&patches, MOST_HALVINGS);
        let mut leaves = all_leaves(&subpatches, self.extent, &self.frame);
        leaves.retain_mut(|BoundedLeaf { leaf, .. }| {
            let Some(subpatch) = subpatches.get(leaf.subpatch as usize) else { return false };
            let SubpatchLocation { patch, part } = subpatch.location;
            let Some(placement) = self.patches.placement(patch) else { return false };
            let [low, high] = placement.range(&leaf.part.within(part).rect());
            let containment = region.classify(low, high);
            leaf.crossed = containment == Containment::Crossed;
            containment != Containment::Outside
        });
        Self::assemble(patches, self.extent, self.frame, subpatches, leaves, Some(region))
    }

    /// The surface with its leaves in the order of the hierarchy.
    fn assemble(
        patches: Vec<SurfacePatch>,
        extent: f64,
        frame: SurfaceFrame,
        subpatches: Vec<Subpatch>,
        leaves: Vec<BoundedLeaf>,
        region: Option<Arc<TrimRegion>>,
    ) -> Self {
        let boxes: Vec<_> = leaves.iter().map(|leaf| leaf.bounds).collect();
        let options = BuildOptions { max_leaf: 1, block: 1, leaf_cost: LEAF_COST };
        let mut bvh = Bvh::build(&boxes, &options);
        drop(boxes);
        let order: Vec<_> = bvh.leaves().filter_map(|leaf| bvh.leaf(leaf).first()).collect();
        let ordered = parallel_map(&order, PARALLEL_CHUNK, |&&leaf| leaves[leaf as usize].leaf);
        drop((leaves, order));
        bvh.forget_items();
        let locations = if subpatches.len() == patches.len() {
            Vec::new()
        } else {
            subpatches.iter().map(|subpatch| subpatch.location).collect()
        };
        let subpatches = SubpatchList::new(subpatches);
        let patches = PatchList::new(patches, &subpatches);
        let (undecided, areas) = (AtomicU64::new(0), OnceLock::new());
        Self { patches, region, extent, leaves: ordered, subpatches, locations, frame, undecided, areas, bvh }
    }
}

/// The box around the control points.
fn hull(patches: &[SurfacePatch]) -> Bounds3 {
    let chunks: Vec<_> = patches.chunks(PARALLEL_CHUNK).collect();
    let of_chunk = |chunk: &&[SurfacePatch]| {
        let points = chunk.iter().flat_map(|patch| patch.patch.control_points());
        Bounds3::from_points(points.map(|p| p.truncate() / p.w))
    };
    parallel_map(&chunks, 1, of_chunk).into_iter().fold(Bounds3::EMPTY, Bounds3::union)
}

/// A leaf before the hierarchy is built. The control points of its part are gone: those of a million patches would take more memory than
/// the surface.
struct BoundedLeaf {
    leaf: PatchLeaf,
    bounds: Bounds3,
}

/// The leaves of all subpatches of a surface of this extent and frame.
fn all_leaves(subpatches: &[Subpatch], extent: f64, frame: &SurfaceFrame) -> Vec<BoundedLeaf> {
    parallel_flat_map(subpatches, CHUNK, |index, subpatch, leaves| {
        let finished = leaves_of(index as u32, subpatch, SMALLEST * extent).into_iter();
        leaves.extend(
            finished
                .map(|leaf| BoundedLeaf { leaf: PatchLeaf::new(&leaf, frame.center), bounds: leaf.bounds }),
        );
    })
}

/// A part of a subpatch that may be halved further.
struct OpenLeaf {
    leaf: LeafBuilder,
    halvings: usize,
    /// Deviations of its parent and of the parent of that.
    before: [f64; 2],
}

/// The leaves of one subpatch.
fn leaves_of(index: u32, subpatch: &Subpatch, smallest: f64) -> Vec<LeafBuilder> {
    let degrees = subpatch.degrees;
    let limit = MOST_DEVIATION[usize::from(degrees.0.max(degrees.1) > 3)];
    let whole = LeafBuilder::new(index, DyadicRect::WHOLE, subpatch.net.to_vec(), degrees);
    let mut done = Vec::new();
    let mut open =
        vec![OpenLeaf { leaf: whole, halvings: subpatch.location.part.count(), before: [f64::INFINITY; 2] }];
    while let Some(OpenLeaf { leaf, halvings, before }) = open.pop() {
        let large = leaf.bounds.diagonal().length() > smallest;
        // NaN, of a leaf without area, is above every limit.
        let deviation = leaf.parallelogram.jacobian_deviation();
        // Next to a collapsed edge or a cusp the deviation stays large, however small the part.
        let helps = halvings < FIRST_HALVINGS || deviation <= SUFFICIENT_REDUCTION * before[1];
        if deviation <= limit || !large || !helps || halvings == MOST_HALVINGS {
            done.push(leaf);
        } else {
            let halves = leaf.halves();
            open.extend(halves.map(|leaf| OpenLeaf {
                leaf,
                halvings: halvings + 1,
                before: [deviation, before[0]],
            }));
        }
    }
    done
}
