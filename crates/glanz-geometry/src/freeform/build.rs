//! Construction of a surface: leaves of its patches, and the hierarchy over them.

use std::sync::{Arc, OnceLock};

use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec2};

use super::control_net::MAX_DEGREE;
use super::leaf_builder::{LeafBuilder, is_line};
use super::leaf_list::LeafList;
use super::parameter_rect::DyadicRect;
use super::patch_list::PatchList;
use super::polynomial_patches::PolynomialPatches;
use super::ray_space::SurfaceFrame;
use super::subpatches::{Subpatch, SubpatchList, SubpatchLocation};
use super::surface_patch::PatchPlacement;
use super::{Freeform, SubdivisionCounters, SurfacePatch};
use crate::bezier::TensorPatch;
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

/// Smallest extent and largest coordinate of a surface, metres: the search has products of six lengths, and leaves have squares of
/// lengths in single precision.
const SIZES: [f64; 2] = [1e-18, 1e18];

/// Cost of a leaf relative to a test of a node: between a block of triangles, 1, and other surfaces, 2.
const LEAF_COST: f32 = 1.5;

/// Patches, or subpatches, that one thread divides at once.
pub(super) const CHUNK: usize = 64;

impl Freeform {
    /// A surface of `patches`.
    ///
    /// Rays meet patches with a common border without a gap if their control points there are the same bits. Points of the two patches on
    /// that border agree up to [`SurfacePoint::error`](crate::SurfacePoint::error), not bit by bit.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without patches, [`SurfaceError::DegreeTooHigh`] above [`MAX_DEGREE`],
    /// [`SurfaceError::Degenerate`] if all control points coincide, [`SurfaceError::OutOfRange`] if they are closer together than 1e-18 m or
    /// have a coordinate above 1e18 m, whose powers would overflow.
    pub fn try_new(patches: Vec<SurfacePatch>) -> Result<Self, SurfaceError> {
        Self::build(patches, None)
    }

    /// The part of a surface of `patches` that `region` keeps: [`Freeform::try_new`] and [`Freeform::trimmed`] without the leaves of the rest.
    ///
    /// # Errors
    /// Those of [`Freeform::try_new`].
    pub fn try_trimmed(patches: Vec<SurfacePatch>, region: Arc<TrimRegion>) -> Result<Self, SurfaceError> {
        Self::build(patches, Some(region))
    }

    fn build(patches: Vec<SurfacePatch>, region: Option<Arc<TrimRegion>>) -> Result<Self, SurfaceError> {
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
        let PatchSummary { hull, is_polynomial } = PatchSummary::new(&patches);
        let size = hull.min.abs().max(hull.max.abs()).max_element();
        let extent = hull.diagonal().length();
        if hull.diagonal().max_element() == 0.0 {
            return Err(SurfaceError::Degenerate {
                reason: "all control points coincide, extent",
                value: extent,
            });
        }
        let [min, max] = SIZES;
        if !(extent >= min && size <= max) {
            let (parameter, value) = if extent < min {
                ("the size of the surface", extent)
            } else {
                ("the largest coordinate", size)
            };
            return Err(SurfaceError::OutOfRange { parameter, value, min, max });
        }
        let frame = SurfaceFrame::new(&hull, size, degrees);
        let rules = LeafRules { smallest: SMALLEST * extent, frame, region: region.as_deref() };
        if is_polynomial && !frame.is_moved() {
            let PolynomialPatches { placements, corrections, powers, leaves } =
                PolynomialPatches::new(patches, &rules);
            let list = PatchList::Powers { placements, corrections };
            let (patches, subpatches) = (Arc::new(list), Arc::new(SubpatchList::Polynomial(powers)));
            return Ok(Self::assemble(patches, subpatches, Arc::new([]), extent, frame, leaves, region));
        }
        let own = if frame.is_moved() { moved(&patches, &frame)? } else { Vec::new() };
        let searched = if frame.is_moved() { &own } else { &patches };
        let subpatches = parallel_flat_map(searched, PARALLEL_CHUNK, |index, patch, done| {
            Subpatch::append_all(index as u32, patch, MOST_HALVINGS, done);
        });
        let leaves = LeafList::new(&subpatches, |index, subpatch, leaves| {
            let placement = &patches[subpatch.location.patch as usize].placement;
            leaves.push_all(&rules.leaves(index as u32, subpatch, placement), subpatch, &rules.frame);
        });
        let locations: Arc<[SubpatchLocation]> = if subpatches.len() == patches.len() {
            Arc::new([])
        } else {
            subpatches.iter().map(|subpatch| subpatch.location).collect()
        };
        let patches =
            if frame.is_moved() { PatchList::Moved { patches, own } } else { PatchList::Nets(patches) };
        let subpatches = SubpatchList::new(subpatches);
        Ok(Self::assemble(Arc::new(patches), Arc::new(subpatches), locations, extent, frame, leaves, region))
    }

    /// The part of the surface that `region` keeps, by its parameters [`SurfacePoint::uv`](crate::SurfacePoint::uv). Both share their
    /// patches.
    #[must_use]
    pub fn trimmed(&self, region: Arc<TrimRegion>) -> Self {
        let rules = LeafRules { smallest: SMALLEST * self.extent, frame: self.frame, region: Some(&region) };
        let faces: Vec<u32> = (0..self.patch_count() as u32).collect();
        let leaves = LeafList::new(&faces, |_, &face, leaves| {
            let Some(patch) = self.own_patch(face) else { return };
            let mut subpatches = Vec::new();
            Subpatch::append_all(face, &patch, MOST_HALVINGS, &mut subpatches);
            for (index, subpatch) in (self.first_subpatch(face)..).zip(&subpatches) {
                leaves.push_all(&rules.leaves(index, subpatch, &patch.placement), subpatch, &rules.frame);
            }
        });
        let (patches, subpatches) = (Arc::clone(&self.patches), Arc::clone(&self.subpatches));
        let locations = Arc::clone(&self.locations);
        Self::assemble(patches, subpatches, locations, self.extent, self.frame, leaves, Some(region))
    }

    /// Corners, in the parameters of the surface, of the rectangle over which a patch lies; `None` if that is another quadrilateral.
    pub(crate) fn patch_rectangle(&self, face: u32) -> Option<[DVec2; 2]> {
        let rect = self.patches.placement(face)?.rectangle()?;
        Some([0, 1].map(|end| DVec2::new(rect.u[end], rect.v[end])))
    }

    /// The number of the first subpatch of a patch.
    fn first_subpatch(&self, face: u32) -> u32 {
        if self.locations.is_empty() {
            face
        } else {
            self.locations.partition_point(|location| location.patch < face) as u32
        }
    }

    /// The surface with its leaves in the order of the hierarchy.
    fn assemble(
        patches: Arc<PatchList>,
        subpatches: Arc<SubpatchList>,
        locations: Arc<[SubpatchLocation]>,
        extent: f64,
        frame: SurfaceFrame,
        leaves: LeafList,
        region: Option<Arc<TrimRegion>>,
    ) -> Self {
        let LeafList { mut leaves, mut boxes, reduced_nets, lines, mut without_area } = leaves;
        if leaves.is_empty() {
            (leaves, boxes) = lines.into_iter().unzip();
        }
        without_area.sort_unstable();
        without_area.dedup();
        let options = BuildOptions { max_leaf: 1, block: 1, leaf_cost: LEAF_COST };
        let mut bvh = Bvh::build_over(boxes, &options);
        let order: Vec<_> = bvh.leaves().filter_map(|leaf| bvh.leaf(leaf).first()).collect();
        let ordered = parallel_map(&order, PARALLEL_CHUNK, |&&leaf| leaves[leaf as usize]);
        drop((leaves, order));
        bvh.forget_items();
        let (counters, areas) = (SubdivisionCounters::default(), OnceLock::new());
        Self {
            patches,
            region,
            extent,
            leaves: ordered,
            reduced_nets,
            without_area,
            subpatches,
            locations,
            frame,
            counters,
            areas,
            bvh,
        }
    }
}

/// The patches in the coordinates of the surface.
fn moved(patches: &[SurfacePatch], frame: &SurfaceFrame) -> Result<Vec<SurfacePatch>, SurfaceError> {
    let of = |patch: &SurfacePatch| {
        let (p, q) = patch.patch.degrees();
        let net = frame.own_net(patch.patch.control_points());
        Ok(SurfacePatch { patch: TensorPatch::try_new(p, q, net)?, placement: patch.placement.clone() })
    };
    parallel_map(patches, PARALLEL_CHUNK, of).into_iter().collect()
}

/// Properties of the patches that determine how they are stored.
struct PatchSummary {
    /// The box around the control points.
    hull: Bounds3,
    /// Whether all are polynomial, of degrees up to (3, 3).
    is_polynomial: bool,
}

impl PatchSummary {
    fn new(patches: &[SurfacePatch]) -> Self {
        let chunks: Vec<_> = patches.chunks(PARALLEL_CHUNK).collect();
        let of_chunk = |chunk: &&[SurfacePatch]| {
            let points = || chunk.iter().flat_map(|patch| patch.patch.control_points());
            let is_low = |patch: &SurfacePatch| patch.patch.degrees().0.max(patch.patch.degrees().1) <= 3;
            Self {
                hull: Bounds3::from_points(points().map(|p| p.truncate() / p.w)),
                is_polynomial: chunk.iter().all(is_low) && points().all(|p| p.w == 1.0),
            }
        };
        let empty = Self { hull: Bounds3::EMPTY, is_polynomial: true };
        parallel_map(&chunks, 1, of_chunk).into_iter().fold(empty, |all, part| Self {
            hull: all.hull.union(part.hull),
            is_polynomial: all.is_polynomial && part.is_polynomial,
        })
    }
}

/// A part of a subpatch that may be halved further.
struct OpenLeaf {
    part: DyadicRect,
    net: Vec<DVec4>,
    halvings: usize,
    /// Whether the region keeps all of it.
    inside: bool,
    /// Deviations of its parent and of the parent of that.
    before: [f64; 2],
}

/// The parts of a patch.
#[derive(Default)]
pub(super) struct PatchLeaves {
    pub(super) leaves: Vec<LeafBuilder>,
    /// Parts that are lines or points to within rounding, which no ray needs to search unless the surface has no others.
    pub(super) lines: Vec<LeafBuilder>,
}

/// Rules by which all patches of a surface are divided into leaves.
pub(super) struct LeafRules<'a> {
    /// Size below which leaves are not halved further, metres.
    smallest: f64,
    pub(super) frame: SurfaceFrame,
    /// The part of the surface that is kept; without it all of it.
    region: Option<&'a TrimRegion>,
}

impl LeafRules<'_> {
    /// The leaves of the subpatch number `index` of the patch at `placement`.
    pub(super) fn leaves(&self, index: u32, subpatch: &Subpatch, placement: &PatchPlacement) -> PatchLeaves {
        let degrees = subpatch.degrees;
        let limit = MOST_DEVIATION[usize::from(degrees.0.max(degrees.1) > 3)];
        let mut done = PatchLeaves::default();
        let mut open = vec![OpenLeaf {
            part: DyadicRect::WHOLE,
            net: subpatch.net.to_vec(),
            halvings: subpatch.location.part.count(),
            inside: self.region.is_none(),
            before: [f64::INFINITY; 2],
        }];
        while let Some(OpenLeaf { part, net, halvings, mut inside, before }) = open.pop() {
            let mut crossed = false;
            if let Some(region) = self.region.filter(|_| !inside) {
                let [low, high] = placement.range(&part.within(subpatch.location.part).rect());
                match region.classify(low, high) {
                    Containment::Outside => continue,
                    Containment::Inside => inside = true,
                    Containment::Crossed => crossed = true,
                }
            }
            let is_line = is_line(&net);
            let leaf = LeafBuilder { crossed, ..LeafBuilder::new(index, part, net, degrees) };
            if is_line {
                done.lines.push(leaf);
                continue;
            }
            let large = leaf.bounds.diagonal().length() > self.smallest;
            // NaN, of a leaf without area, is above every limit.
            let deviation = leaf.parallelogram.jacobian_deviation();
            // Next to a collapsed edge or a cusp the deviation stays large, however small the part.
            let is_reduced = deviation < SUFFICIENT_REDUCTION * before[1];
            // Before the first two halvings both are infinite where the tangents are parallel.
            let helps = halvings < FIRST_HALVINGS || deviation <= SUFFICIENT_REDUCTION * before[1];
            if deviation <= limit || !large || !helps || halvings == MOST_HALVINGS {
                done.leaves.push(leaf);
            } else {
                let halves = if is_reduced { leaf.halves() } else { leaf.less_deviating_halves() };
                open.extend(halves.map(|(part, net)| OpenLeaf {
                    part,
                    net,
                    halvings: halvings + 1,
                    inside,
                    before: [deviation, before[0]],
                }));
            }
        }
        done
    }
}
