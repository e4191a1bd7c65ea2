//! From patches to leaves and their hierarchy.

use std::sync::atomic::AtomicU64;
use std::sync::{Arc, OnceLock};

use glanz_math::DVec3;

use super::draft::Draft;
use super::leaf::Leaf;
use super::net::MAX_DEGREE;
use super::part::Part;
use super::search::Sight;
use super::subpatches::{self, Forms, Subpatch};
use super::{Freeform, Piece};
use crate::bvh::{BuildOptions, Bvh, map};
use crate::error::SurfaceError;
use crate::trim::{Containment, TrimRegion};

/// A leaf is halved while the Jacobian strays by more than this from that of its parallelogram, seen along the
/// normal: below the search's own limit, so that rays from most sides find their leaf certified. Measured: for degrees up
/// to 3 rays cost the same from 0.2 to 0.3, and memory is a third less. A look at a leaf of higher degree is dearer, so
/// that the better start of 0.2 pays; 0.15 would be 4 % faster with half as much memory again.
const UNEVEN: [f64; 2] = [0.3, 0.2];

/// Halvings of a patch at most.
const MOST_HALVINGS: usize = 12;

/// Halvings after which they must help: two of them should make a part of any smooth patch half as uneven...
const FIRST_HALVINGS: usize = 5;

/// ... and have helped if it is this much of what it was.
const HELPFUL: f64 = 0.75;

/// Leaves smaller than this share of the surface are not halved further: the search does it if a ray comes.
const SMALLEST: f64 = 1e-6;

/// Cost of asking a leaf relative to that of testing a node: between a block of triangles, 1, and other surfaces, 2.
const LEAF_COST: f32 = 1.5;

impl Freeform {
    /// A surface of `pieces`.
    ///
    /// Pieces with a common border meet without gap if their control points there are the same bits.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without pieces, [`SurfaceError::DegreeTooHigh`] above [`MAX_DEGREE`],
    /// [`SurfaceError::Degenerate`] if all control points coincide.
    pub fn try_new(pieces: Vec<Piece>) -> Result<Self, SurfaceError> {
        if pieces.is_empty() {
            return Err(SurfaceError::TooFew { parameter: "patches", count: 0, min: 1 });
        }
        let degrees = pieces.iter().fold((0, 0), |(p, q), piece| {
            let (r, s) = piece.patch.degrees();
            (p.max(r), q.max(s))
        });
        let highest = degrees.0.max(degrees.1);
        if highest > MAX_DEGREE {
            let (degree, max) = (highest as u32, MAX_DEGREE as u32);
            return Err(SurfaceError::DegreeTooHigh { parameter: "the patch", degree, max });
        }
        let points =
            || pieces.iter().flat_map(|piece| piece.patch.control_points()).map(|p| p.truncate() / p.w);
        let size = points().fold(DVec3::ZERO, |most, p| most.max(p.abs())).max_element();
        let hull = glanz_math::Bounds3::from_points(points());
        let extent = hull.diagonal().length();
        if !(extent > 0.0 && extent.is_finite()) {
            return Err(SurfaceError::Degenerate {
                reason: "all control points coincide, extent",
                value: extent,
            });
        }
        let sight = Sight::new(&hull, size, degrees);
        let subpatches = subpatches::cut(&pieces, MOST_HALVINGS);
        let drafts = drafts(&subpatches, extent);
        Ok(Self::assemble(pieces, extent, sight, subpatches, &drafts, None))
    }

    /// What `region` keeps of the surface, by its parameters [`SurfacePoint::uv`](crate::SurfacePoint::uv).
    #[must_use]
    pub fn trimmed(&self, region: Arc<TrimRegion>) -> Self {
        let subpatches = subpatches::cut(&self.pieces, MOST_HALVINGS);
        let mut drafts = drafts(&subpatches, self.extent);
        drafts.retain_mut(|draft| {
            let place = subpatches.get(draft.subpatch as usize).map(|subpatch| subpatch.place);
            let of = place.and_then(|place| Some((self.pieces.get(place.piece as usize)?, place.part)));
            let Some((piece, part)) = of else { return false };
            let [low, high] = piece.range(&draft.part.within(part).rect());
            let cell = region.classify(low, high);
            draft.crossed = cell == Containment::Crossed;
            cell != Containment::Outside
        });
        Self::assemble(self.pieces.clone(), self.extent, self.sight, subpatches, &drafts, Some(region))
    }

    /// Lays the leaves out in the order of the hierarchy.
    fn assemble(
        pieces: Vec<Piece>,
        extent: f64,
        sight: Sight,
        subpatches: Vec<Subpatch>,
        drafts: &[Draft],
        region: Option<Arc<TrimRegion>>,
    ) -> Self {
        let boxes: Vec<_> = drafts.iter().map(|d| d.bounds).collect();
        let options = BuildOptions { max_leaf: 1, block: 1, leaf_cost: LEAF_COST };
        let bvh = Bvh::build(&boxes, &options);
        // Every leaf of the hierarchy is one of ours.
        let ordered = bvh.leaves().filter_map(|leaf| drafts.get(*bvh.leaf(leaf).first()? as usize));
        let leaves = ordered.map(|draft| Leaf::new(draft, sight.center)).collect();
        let places = subpatches.iter().map(|subpatch| subpatch.place).collect();
        let forms = Forms::new(subpatches);
        let (undecided, areas) = (AtomicU64::new(0), OnceLock::new());
        Self { pieces, region, extent, leaves, forms, places, sight, undecided, areas, bvh }
    }
}

/// The leaves of all subpatches of a surface of that extent.
fn drafts(subpatches: &[Subpatch], extent: f64) -> Vec<Draft> {
    let numbered: Vec<(usize, &Subpatch)> = subpatches.iter().enumerate().collect();
    map(&numbered, 16, |&(index, subpatch)| leaves(index as u32, subpatch, SMALLEST * extent)).concat()
}

/// A part of a subpatch that may be halved further.
struct Open {
    draft: Draft,
    halvings: usize,
    /// Unevenness of the part of which it is a half, and of that of which that was one.
    before: [f64; 2],
}

/// The leaves of one subpatch.
fn leaves(index: u32, subpatch: &Subpatch, smallest: f64) -> Vec<Draft> {
    let degrees = subpatch.degrees;
    let limit = UNEVEN[usize::from(degrees.0.max(degrees.1) > 3)];
    let whole = Draft::new(index, Part::WHOLE, subpatch.net.clone(), degrees);
    let mut done = Vec::new();
    let mut open =
        vec![Open { draft: whole, halvings: subpatch.place.part.count(), before: [f64::INFINITY; 2] }];
    while let Some(Open { draft, halvings, before }) = open.pop() {
        let large = draft.bounds.diagonal().length() > smallest;
        // NaN, of a leaf without area, is uneven.
        let uneven = draft.frame.unevenness();
        // Next to a collapsed edge or a cusp no part is ever even, however small.
        let helps = halvings < FIRST_HALVINGS || uneven <= HELPFUL * before[1];
        if uneven <= limit || !large || !helps || halvings == MOST_HALVINGS {
            done.push(draft);
        } else {
            let halves = draft.halves();
            open.extend(halves.map(|draft| Open {
                draft,
                halvings: halvings + 1,
                before: [uneven, before[0]],
            }));
        }
    }
    done
}
