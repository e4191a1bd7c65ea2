//! Newton's method for eight pairs of a ray and a leaf at once: [`Bicubic::roots`](super::bicubic::Bicubic::roots) lane by lane, with
//! the same bits. Lanes that need more than Newton's method are left to the search for a single pair.

use super::bicubic::POWERS;
use super::bicubic_lanes::{PatchConstant, PatchLanes, ProjectedLanes, value};
use super::leaf::PatchLeaf;
use super::pair_lanes::{BoundLanes, PairLanes, RootLanes};
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
    /// The value at the last point.
    f: [S::Wide; 2],
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
    let mut end = NewtonLanes { converged: 0, left: 0, x, f: [one; 2] };
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
            end.f[k] = simd.select8(left, jet.f[k], end.f[k]);
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
    let PairLanes { a, b, q, inverse_determinant: per, .. } = *pairs;
    let f = match weight {
        Some(weight) => [simd.div8(newton.f[0], weight), simd.div8(newton.f[1], weight)],
        None => newton.f,
    };
    let simple = [simd.mul8(cross(simd, f, b), per), simd.mul8(cross(simd, a, f), per)];
    let factor =
        simd.mul8(simd.mul8(simd.mul8(simd.splat8(2.0), bounds.noise), bounds.weights[1]), simd.abs8(per));
    let one = simd.splat8(1.0);
    let ball = simd.div8(simd.mul8(simd.sqrt8(dot2(simd, simple, simple)), q), simd.sub8(one, q));
    let (mut away, mut unsure) = ([one; 2], [one; 2]);
    for k in 0..2 {
        let x = simd.mul8(simd.sub8(newton.x[k], rect.middle[k]), rect.per_half[k]);
        away[k] = simd.abs8(simd.sub8(x, simple[k]));
        let side = if k == 0 { b } else { a };
        unsure[k] = simd.mul8(simd.sqrt8(dot2(simd, side, side)), factor);
        if let Some(weight) = weight {
            unsure[k] = simd.div8(unsure[k], weight);
        }
    }
    let limit = simd.add8(simd.add8(one, ball), simd.max8(unsure[0], unsure[1]));
    simd.less8(limit, simd.max8(away[0], away[1]))
}
