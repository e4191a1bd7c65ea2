//! Newton's method for eight pairs of a ray and a leaf at once: [`Bicubic::roots`](super::bicubic::Bicubic::roots) lane by lane, with
//! the same bits. Lanes that need more than Newton's method are left to the search for a single pair.

use super::bicubic::POWERS;
use super::bicubic_lanes::{PatchConstant, PatchLanes, ProjectedLanes, value};
use super::contraction::HIT_TOLERANCE;
use super::leaf::PatchLeaf;
use super::pair_lanes::{BoundLanes, JetLanes, PairLanes, RootLanes};
use super::projected_bicubic::MAX_NEWTON_STEPS;
use super::ray_lanes::{cross, dot2, dot3};
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// The constants of a leaf that the iteration needs.
#[derive(Clone, Copy)]
enum LeafConstant {
    Middle(usize),
    Width(usize),
    /// The inverse of the width, which is exact: a product with it is the quotient.
    PerWidth(usize),
    Curvature,
}

impl LeafConstant {
    /// The constant of each leaf.
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, leaves: &[&PatchLeaf; LANES]) -> S::Wide {
        let mut lanes = [0.0; LANES];
        for (lane, leaf) in lanes.iter_mut().zip(leaves) {
            *lane = match self {
                Self::Middle(axis) => leaf.part.middle()[axis],
                Self::Width(axis) => leaf.part.width()[axis],
                Self::PerWidth(axis) => 1.0 / leaf.part.width()[axis],
                Self::Curvature => leaf.curvature_bound(),
            };
        }
        simd.load8(&lanes)
    }
}

/// The rectangles of eight leaves in the square [-1, 1]^2; see [`DyadicRect`](super::parameter_rect::DyadicRect).
struct RectLanes<S: Simd> {
    middle: [S::Wide; 2],
    half: [S::Wide; 2],
    per_half: [S::Wide; 2],
}

impl<S: Simd> RectLanes<S> {
    #[inline(always)]
    fn new(simd: S, leaves: &[&PatchLeaf; LANES]) -> Self {
        Self {
            middle: [LeafConstant::Middle(0).of(simd, leaves), LeafConstant::Middle(1).of(simd, leaves)],
            half: [LeafConstant::Width(0).of(simd, leaves), LeafConstant::Width(1).of(simd, leaves)],
            per_half: [
                LeafConstant::PerWidth(0).of(simd, leaves),
                LeafConstant::PerWidth(1).of(simd, leaves),
            ],
        }
    }
}

/// The roots of eight pairs of a ray and a certified leaf.
#[inline(always)]
pub(super) fn roots<S: Simd, const COORDINATES: usize>(
    simd: S,
    patches: &impl PatchLanes<S, COORDINATES>,
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> RootLanes<S> {
    let from = [
        simd.sub8(patches.constant(simd, PatchConstant::Center(0)), pairs.rays.origin[0]),
        simd.sub8(patches.constant(simd, PatchConstant::Center(1)), pairs.rays.origin[1]),
        simd.sub8(patches.constant(simd, PatchConstant::Center(2)), pairs.rays.origin[2]),
    ];
    let shift = [dot3(simd, pairs.rays.axes[0], from), dot3(simd, pairs.rays.axes[1], from)];
    let projected = ProjectedLanes::new(simd, patches, pairs, shift);
    let rect = RectLanes::new(simd, leaves);
    let one = simd.splat8(1.0);
    let bounds = if COORDINATES == 4 {
        let away = simd.sqrt8(dot2(simd, shift, shift));
        let sum = simd.add8(
            patches.constant(simd, PatchConstant::Curvature),
            simd.mul8(patches.constant(simd, PatchConstant::WeightCurvature), away),
        );
        let width = simd.max8(rect.half[0], rect.half[1]);
        BoundLanes {
            noise: simd.mul8(pairs.rays.noise, simd.splat8(POWERS)),
            curvature_bound: simd.mul8(sum, simd.mul8(width, width)),
            weights: [
                patches.constant(simd, PatchConstant::Weight(0)),
                patches.constant(simd, PatchConstant::Weight(1)),
            ],
        }
    } else {
        BoundLanes {
            noise: simd.mul8(pairs.rays.noise, simd.splat8(POWERS)),
            curvature_bound: LeafConstant::Curvature.of(simd, leaves),
            weights: [one; 2],
        }
    };
    let newton = newton(simd, &projected, pairs, &bounds, &rect);
    let x = newton.x;
    let weight = if COORDINATES == 4 { Some(value(simd, &projected.weight, x)) } else { None };
    let left = newton.left;
    let excluded = if left == 0 { 0 } else { left & excludes(simd, pairs, &bounds, &newton, weight, &rect) };
    let along = value(simd, &projected.along, x);
    let along = match weight {
        Some(weight) => simd.div8(along, weight),
        None => along,
    };
    let s = simd.add8(dot3(simd, pairs.rays.direction, from), along);
    let middle = simd.splat8(0.5);
    let at = [simd.add8(middle, simd.mul8(middle, x[0])), simd.add8(middle, simd.mul8(middle, x[1]))];
    RootLanes { converged: newton.converged, excluded, s, at }
}

/// The end of Newton's method for eight pairs.
struct NewtonLanes<S: Simd> {
    converged: u32,
    left: u32,
    /// The root, or the last point before a step that left the leaf.
    x: [S::Wide; 2],
    /// The jet at `x` in the lanes of `left`; any in others.
    jet: JetLanes<S>,
}

/// Newton's method from the projections; see [`ProjectedBicubic::newton`](super::projected_bicubic::ProjectedBicubic::newton).
#[inline(always)]
fn newton<S: Simd>(
    simd: S,
    map: &ProjectedLanes<S>,
    pairs: &PairLanes<S>,
    bounds: &BoundLanes<S>,
    rect: &RectLanes<S>,
) -> NewtonLanes<S> {
    let RectLanes { middle, half, per_half } = *rect;
    let (one, minus) = (simd.splat8(1.0), simd.splat8(-1.0));
    let low = [simd.sub8(middle[0], half[0]), simd.sub8(middle[1], half[1])];
    let high = [simd.add8(middle[0], half[0]), simd.add8(middle[1], half[1])];
    let mut x = [one; 2];
    for k in 0..2 {
        let start = simd.min8(simd.max8(pairs.start[k], minus), one);
        x[k] = simd.add8(middle[k], simd.mul8(half[k], start));
    }
    let jet = map.jet(simd, x);
    let step = jet.newton_step(simd, cross(simd, jet.fs, jet.ft));
    for k in 0..2 {
        x[k] = simd.min8(simd.max8(simd.sub8(x[k], step[k]), low[k]), high[k]);
    }
    let mut end = NewtonLanes { converged: 0, left: 0, x, jet };
    let mut open = pairs.mask;
    for _ in 0..MAX_NEWTON_STEPS {
        let jet = map.jet(simd, x);
        let det = cross(simd, jet.fs, jet.ft);
        let step = jet.newton_step(simd, det);
        let next = [simd.sub8(x[0], step[0]), simd.sub8(x[1], step[1])];
        let inside = simd.at_most8(low[0], next[0])
            & simd.at_most8(low[1], next[1])
            & simd.at_most8(next[0], high[0])
            & simd.at_most8(next[1], high[1]);
        let left = open & !inside;
        let converged = open & inside & jet.ends(simd, bounds, det, step, per_half);
        for k in 0..2 {
            end.x[k] = simd.select8(left, x[k], simd.select8(converged, next[k], end.x[k]));
            end.jet.f[k] = simd.select8(left, jet.f[k], end.jet.f[k]);
            end.jet.fs[k] = simd.select8(left, jet.fs[k], end.jet.fs[k]);
            end.jet.ft[k] = simd.select8(left, jet.ft[k], end.jet.ft[k]);
        }
        end.converged |= converged;
        end.left |= left;
        open &= !(left | converged);
        if open == 0 {
            break;
        }
        x = next;
    }
    end
}

/// Lanes in which the last point before a step out of the leaf proves that there is no root; see
/// [`Certificate::excludes`](super::contraction::Certificate::excludes).
#[inline(always)]
fn excludes<S: Simd>(
    simd: S,
    pairs: &PairLanes<S>,
    bounds: &BoundLanes<S>,
    newton: &NewtonLanes<S>,
    weight: Option<S::Wide>,
    rect: &RectLanes<S>,
) -> u32 {
    let PairLanes { a, b, q, inverse_determinant, .. } = *pairs;
    let (zero, one) = (simd.splat8(0.0), simd.splat8(1.0));
    let RectLanes { middle, half, per_half } = *rect;
    let noise = simd.mul8(simd.mul8(simd.splat8(HIT_TOLERANCE), bounds.noise), bounds.weights[1]);
    let JetLanes { f, fs: [fsx, fsy], ft: [ftx, fty] } = newton.jet;
    let fs = [simd.mul8(fsx, half[0]), simd.mul8(fsy, half[0])];
    let ft = [simd.mul8(ftx, half[1]), simd.mul8(fty, half[1])];
    let jet = JetLanes { f, fs, ft };
    let per = inverse_determinant;
    let simple = [simd.mul8(cross(simd, f, b), per), simd.mul8(cross(simd, a, f), per)];
    let sum_a = simd.add8(simd.abs8(a[0]), simd.abs8(a[1]));
    let sum_b = simd.add8(simd.abs8(b[0]), simd.abs8(b[1]));
    let unsure = simd.mul8(simd.add8(sum_a, sum_b), simd.mul8(noise, simd.abs8(per)));
    let contraction = simd.sub8(one, q);
    let scale = match weight {
        Some(weight) => simd.mul8(weight, contraction),
        None => contraction,
    };
    let sum = simd.add8(simd.sqrt8(dot2(simd, simple, simple)), unsure);
    let mut distance = simd.div8(sum, scale);
    let det = cross(simd, fs, ft);
    let step = jet.newton_step(simd, det);
    let per = simd.div8(one, det);
    let per2 = simd.mul8(per, per);
    let rows = [simd.mul8(dot2(simd, ft, ft), per2), simd.mul8(dot2(simd, fs, fs), per2)];
    let size = simd.sqrt8(simd.add8(rows[0], rows[1]));
    let length = simd.sqrt8(dot2(simd, step, step));
    for _ in 0..2 {
        let remainder = remainder(simd, bounds, distance, noise);
        distance = simd.min8(simd.add8(length, simd.mul8(size, remainder)), distance);
    }
    let remainder = remainder(simd, bounds, distance, noise);
    let remainder2 = simd.mul8(remainder, remainder);
    let mut excluded = 0;
    for k in 0..2 {
        let x = simd.mul8(simd.sub8(newton.x[k], middle[k]), per_half[k]);
        let beyond = simd.sub8(simd.abs8(simd.sub8(x, step[k])), one);
        let off = simd.mul8(rows[k], remainder2);
        excluded |= simd.less8(zero, beyond) & simd.less8(off, simd.mul8(beyond, beyond));
    }
    excluded
}

/// Bound on the error of a linear step of length `distance`.
#[inline(always)]
fn remainder<S: Simd>(simd: S, bounds: &BoundLanes<S>, distance: S::Wide, noise: S::Wide) -> S::Wide {
    simd.add8(simd.mul8(bounds.curvature_bound, simd.mul8(distance, distance)), noise)
}
