//! Newton's method for eight pairs of a ray and a leaf at once: [`Bicubic::roots`] lane by lane, with the same bits.
//!
//! The coefficients of pairs of one patch are broadcast, those of other pairs transposed into lanes; all else is common. Lanes
//! that need more than Newton's method are left to the search for a single pair.

use super::bicubic::{Bicubic, POWERS};
use super::contraction::ROUNDED;
use super::leaf::PatchLeaf;
use super::projected_bicubic::FEW_STEPS;
use super::ray_lanes::{RaySpaceLanes, cross, dot2, dot3};
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// Eight pairs of a ray and a certified leaf.
pub(super) struct PairLanes<S: Simd> {
    /// The lanes in use.
    pub(super) mask: u32,
    pub(super) rays: RaySpaceLanes<S>,
    /// The projection of the leaf; see [`LeafProjection`](super::leaf::LeafProjection).
    pub(super) a: [S::Wide; 2],
    pub(super) b: [S::Wide; 2],
    pub(super) q: S::Wide,
    pub(super) inverse_determinant: S::Wide,
    pub(super) start: [S::Wide; 2],
}

/// Results of eight pairs.
pub(super) struct RootLanes<S: Simd> {
    /// Pairs with a root.
    pub(super) converged: u32,
    /// Pairs without one.
    pub(super) excluded: u32,
    /// Arc length along the ray.
    pub(super) s: S::Wide,
    /// Parameters in [0, 1]^2.
    pub(super) at: [S::Wide; 2],
}

/// The patches of eight pairs.
pub(super) trait PatchLanes<S: Simd, const COORDINATES: usize> {
    /// Eight consecutive coefficients: the first of two powers of s, of two coordinates, and so on, as they are stored.
    fn coefficients(&self, simd: S, chunk: usize) -> [S::Wide; LANES];
    /// One number per patch.
    fn number(&self, simd: S, of: impl PatchNumber) -> S::Wide;
}

/// A number of a patch.
pub(super) trait PatchNumber: Copy {
    fn of<const COORDINATES: usize>(self, patch: &Bicubic<COORDINATES>) -> f64;
}

/// Numbers of a patch by name.
#[derive(Clone, Copy)]
enum Number {
    Center(usize),
    Curvature,
    WeightCurvature,
    Weight(usize),
}

impl PatchNumber for Number {
    #[inline(always)]
    fn of<const COORDINATES: usize>(self, patch: &Bicubic<COORDINATES>) -> f64 {
        match self {
            Self::Center(axis) => patch.center[axis],
            Self::Curvature => patch.curvature_bound,
            Self::WeightCurvature => patch.weight_curvature_bound.into(),
            Self::Weight(side) => patch.weights[side].into(),
        }
    }
}

impl<const COORDINATES: usize> Bicubic<COORDINATES> {
    /// Eight consecutive coefficients.
    #[inline(always)]
    fn chunk(&self, chunk: usize) -> &[f64; LANES] {
        let all = self.powers.as_flattened().as_flattened().as_chunks().0;
        // There are 2 COORDINATES chunks.
        &all[chunk]
    }
}

/// The same patch in all lanes.
impl<S: Simd, const COORDINATES: usize> PatchLanes<S, COORDINATES> for &Bicubic<COORDINATES> {
    #[inline(always)]
    fn coefficients(&self, simd: S, chunk: usize) -> [S::Wide; LANES] {
        let [a, b, c, d, e, f, g, h] = *self.chunk(chunk);
        [
            simd.splat8(a),
            simd.splat8(b),
            simd.splat8(c),
            simd.splat8(d),
            simd.splat8(e),
            simd.splat8(f),
            simd.splat8(g),
            simd.splat8(h),
        ]
    }

    #[inline(always)]
    fn number(&self, simd: S, of: impl PatchNumber) -> S::Wide {
        simd.splat8(of.of(*self))
    }
}

/// A patch per lane.
impl<S: Simd, const COORDINATES: usize> PatchLanes<S, COORDINATES> for [&Bicubic<COORDINATES>; LANES] {
    #[inline(always)]
    fn coefficients(&self, simd: S, chunk: usize) -> [S::Wide; LANES] {
        let [a, b, c, d, e, f, g, h] = *self;
        simd.columns8(&[
            a.chunk(chunk),
            b.chunk(chunk),
            c.chunk(chunk),
            d.chunk(chunk),
            e.chunk(chunk),
            f.chunk(chunk),
            g.chunk(chunk),
            h.chunk(chunk),
        ])
    }

    #[inline(always)]
    fn number(&self, simd: S, of: impl PatchNumber) -> S::Wide {
        let mut lanes = [0.0; LANES];
        for (lane, patch) in lanes.iter_mut().zip(self) {
            *lane = of.of(*patch);
        }
        simd.load8(&lanes)
    }
}

/// A number per leaf.
#[inline(always)]
fn of_leaves<S: Simd>(simd: S, leaves: &[&PatchLeaf; LANES], number: LeafNumber) -> S::Wide {
    let mut lanes = [0.0; LANES];
    for (lane, leaf) in lanes.iter_mut().zip(leaves) {
        *lane = match number {
            LeafNumber::Middle(axis) => leaf.part.middle()[axis],
            LeafNumber::Width(axis) => leaf.part.width()[axis],
            LeafNumber::PerWidth(axis) => 1.0 / leaf.part.width()[axis],
            LeafNumber::Curvature => leaf.curvature_bound(),
        };
    }
    simd.load8(&lanes)
}

/// Numbers of a leaf by name.
#[derive(Clone, Copy)]
enum LeafNumber {
    Middle(usize),
    Width(usize),
    /// The inverse of the width, which is exact: a product with it is the quotient.
    PerWidth(usize),
    Curvature,
}

/// The parts of eight leaves: see [`DyadicRect`](super::parameter_rect::DyadicRect).
struct PartLanes<S: Simd> {
    middle: [S::Wide; 2],
    half: [S::Wide; 2],
    per_half: [S::Wide; 2],
}

impl<S: Simd> PartLanes<S> {
    #[inline(always)]
    fn new(simd: S, leaves: &[&PatchLeaf; LANES]) -> Self {
        Self {
            middle: [
                of_leaves(simd, leaves, LeafNumber::Middle(0)),
                of_leaves(simd, leaves, LeafNumber::Middle(1)),
            ],
            half: [
                of_leaves(simd, leaves, LeafNumber::Width(0)),
                of_leaves(simd, leaves, LeafNumber::Width(1)),
            ],
            per_half: [
                of_leaves(simd, leaves, LeafNumber::PerWidth(0)),
                of_leaves(simd, leaves, LeafNumber::PerWidth(1)),
            ],
        }
    }
}

/// Number of coefficients of a bicubic polynomial.
const COUNT: usize = 16;

/// Polynomials in (s, t) of eight pairs: the coefficient of s^i t^j at 4 i + j.
type Polynomial<Wide> = [Wide; COUNT];

/// Eight patches projected along their rays.
struct ProjectedLanes<S: Simd> {
    /// Distances from two planes through the ray, times weight.
    across: [Polynomial<S::Wide>; 2],
    /// Distance along the ray, times weight.
    along: Polynomial<S::Wide>,
    weight: Polynomial<S::Wide>,
}

/// Value and derivatives of a map of eight pairs.
pub(super) struct JetLanes<S: Simd> {
    pub(super) f: [S::Wide; 2],
    pub(super) fs: [S::Wide; 2],
    pub(super) ft: [S::Wide; 2],
}

/// A cubic at `x`.
#[inline(always)]
fn cubic<S: Simd>(simd: S, [a, b, c, d]: [S::Wide; 4], x: S::Wide, square: S::Wide) -> S::Wide {
    simd.mul_add8(simd.mul_add8(d, x, c), square, simd.mul_add8(b, x, a))
}

/// The derivative of a cubic at `x`.
#[inline(always)]
fn slope<S: Simd>(simd: S, [_, b, c, d]: [S::Wide; 4], x: S::Wide, square: S::Wide) -> S::Wide {
    let (two, three) = (simd.add8(c, c), simd.mul8(d, simd.splat8(3.0)));
    simd.mul_add8(three, square, simd.mul_add8(two, x, b))
}

/// The polynomial at `x` by Horner's rule.
#[inline(always)]
fn value<S: Simd>(simd: S, rows: &Polynomial<S::Wide>, x: [S::Wide; 2]) -> S::Wide {
    let mut by_t = [rows[0]; 4];
    for (j, out) in by_t.iter_mut().enumerate() {
        let sum = simd.mul_add8(rows[12 + j], x[0], rows[8 + j]);
        let sum = simd.mul_add8(sum, x[0], rows[4 + j]);
        *out = simd.mul_add8(sum, x[0], rows[j]);
    }
    let [a, b, c, d] = by_t;
    simd.mul_add8(simd.mul_add8(simd.mul_add8(d, x[1], c), x[1], b), x[1], a)
}

impl<S: Simd> ProjectedLanes<S> {
    /// The patches along the rays; `from` is the vector from the origin to the centre.
    #[inline(always)]
    fn new<const COORDINATES: usize>(
        simd: S,
        patches: &impl PatchLanes<S, COORDINATES>,
        pairs: &PairLanes<S>,
        shift: [S::Wide; 2],
    ) -> Self {
        let zero = simd.splat8(0.0);
        let mut projected = Self { across: [[zero; COUNT]; 2], along: [zero; COUNT], weight: [zero; COUNT] };
        let [first, second] = pairs.rays.axes;
        for half in 0..2 {
            // The coefficients of two powers of s: lists of 4, two in a chunk.
            let mut lists = [[zero; 4]; 8];
            for k in 0..COORDINATES {
                let [a, b, c, d, e, f, g, h] = patches.coefficients(simd, COORDINATES * half + k);
                (lists[2 * k], lists[2 * k + 1]) = ([a, b, c, d], [e, f, g, h]);
            }
            for (row, j) in [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (1, 3)] {
                let (at, list) = (4 * (2 * half + row) + j, COORDINATES * row);
                let coefficient = [lists[list][j], lists[list + 1][j], lists[list + 2][j]];
                let (f, g) = (chained(simd, coefficient, first), chained(simd, coefficient, second));
                projected.along[at] = chained(simd, coefficient, pairs.rays.direction);
                let [f, g] = if COORDINATES == 4 {
                    let weight = lists[list + 3][j];
                    projected.weight[at] = weight;
                    [simd.mul_add8(weight, shift[0], f), simd.mul_add8(weight, shift[1], g)]
                } else if at < 4 {
                    let by = if j == 0 { shift } else { [zero; 2] };
                    [simd.add8(f, by[0]), simd.add8(g, by[1])]
                } else {
                    [f, g]
                };
                projected.across[0][at] = f;
                projected.across[1][at] = g;
            }
        }
        projected
    }

    /// Value and derivatives at `x`.
    #[inline(always)]
    fn jet(&self, simd: S, x: [S::Wide; 2]) -> JetLanes<S> {
        let [s, t] = x;
        let (s2, t2) = (simd.mul8(s, s), simd.mul8(t, t));
        let (mut f, mut fs, mut ft) = ([s; 2], [s; 2], [s; 2]);
        for (k, rows) in self.across.iter().enumerate() {
            let (mut values, mut slopes) = ([s; 4], [s; 4]);
            for j in 0..4 {
                let column = [rows[j], rows[4 + j], rows[8 + j], rows[12 + j]];
                values[j] = cubic(simd, column, s, s2);
                slopes[j] = slope(simd, column, s, s2);
            }
            f[k] = cubic(simd, values, t, t2);
            fs[k] = cubic(simd, slopes, t, t2);
            ft[k] = slope(simd, values, t, t2);
        }
        JetLanes { f, fs, ft }
    }
}

/// The product of a coefficient and a direction, in the order of [`Bicubic`]'s projection.
#[inline(always)]
fn chained<S: Simd>(simd: S, c: [S::Wide; 3], axis: [S::Wide; 3]) -> S::Wide {
    let sum = simd.mul8(c[0], axis[0]);
    simd.mul_add8(c[2], axis[2], simd.mul_add8(c[1], axis[1], sum))
}

/// Bounds of eight pairs; see [`MapBounds`](super::contraction::MapBounds).
pub(super) struct BoundLanes<S: Simd> {
    pub(super) noise: S::Wide,
    pub(super) curvature_bound: S::Wide,
    pub(super) weights: [S::Wide; 2],
}

impl<S: Simd> JetLanes<S> {
    /// The step of Newton's method.
    #[inline(always)]
    pub(super) fn newton_step(&self, simd: S, det: S::Wide) -> [S::Wide; 2] {
        let Self { f, fs, ft } = *self;
        [simd.div8(cross(simd, f, ft), det), simd.div8(cross(simd, fs, f), det)]
    }

    /// Lanes in which the end of a step needs no evaluation.
    #[inline(always)]
    pub(super) fn ends(
        &self,
        simd: S,
        bounds: &BoundLanes<S>,
        det: S::Wide,
        step: [S::Wide; 2],
        per_unit: [S::Wide; 2],
    ) -> u32 {
        let noise = simd.mul8(bounds.noise, bounds.weights[0]);
        let length_squared = dot2(simd, step, step);
        let (s2, t2) = (dot2(simd, self.fs, self.fs), dot2(simd, self.ft, self.ft));
        let rounded = simd.mul8(simd.mul8(simd.splat8(ROUNDED * ROUNDED), s2), t2);
        let rounded = simd.mul8(simd.mul8(rounded, simd.add8(s2, t2)), length_squared);
        let relative = [simd.mul8(step[0], per_unit[0]), simd.mul8(step[1], per_unit[1])];
        let curved = simd.mul8(bounds.curvature_bound, dot2(simd, relative, relative));
        let clear = simd.mul8(simd.mul8(simd.mul8(noise, noise), det), det);
        simd.at_most8(curved, noise) & simd.at_most8(rounded, clear)
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
        simd.sub8(patches.number(simd, Number::Center(0)), pairs.rays.origin[0]),
        simd.sub8(patches.number(simd, Number::Center(1)), pairs.rays.origin[1]),
        simd.sub8(patches.number(simd, Number::Center(2)), pairs.rays.origin[2]),
    ];
    let shift = [dot3(simd, pairs.rays.axes[0], from), dot3(simd, pairs.rays.axes[1], from)];
    let projected = ProjectedLanes::new(simd, patches, pairs, shift);
    let part = PartLanes::new(simd, leaves);
    let one = simd.splat8(1.0);
    let bounds = if COORDINATES == 4 {
        let away = simd.sqrt8(dot2(simd, shift, shift));
        let sum = simd.add8(
            patches.number(simd, Number::Curvature),
            simd.mul8(patches.number(simd, Number::WeightCurvature), away),
        );
        let width = simd.max8(part.half[0], part.half[1]);
        BoundLanes {
            noise: simd.mul8(pairs.rays.noise, simd.splat8(POWERS)),
            curvature_bound: simd.mul8(sum, simd.mul8(width, width)),
            weights: [patches.number(simd, Number::Weight(0)), patches.number(simd, Number::Weight(1))],
        }
    } else {
        BoundLanes {
            noise: simd.mul8(pairs.rays.noise, simd.splat8(POWERS)),
            curvature_bound: of_leaves(simd, leaves, LeafNumber::Curvature),
            weights: [one; 2],
        }
    };
    let newton = newton(simd, &projected, pairs, &bounds, &part);
    let x = newton.x;
    let weight = if COORDINATES == 4 { Some(value(simd, &projected.weight, x)) } else { None };
    let left = newton.left;
    let excluded = if left == 0 { 0 } else { left & excludes(simd, pairs, &bounds, &newton, weight, &part) };
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
    part: &PartLanes<S>,
) -> NewtonLanes<S> {
    let PartLanes { middle, half, per_half } = *part;
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
    for _ in 0..FEW_STEPS {
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
    part: &PartLanes<S>,
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
        let x = simd.mul8(simd.sub8(newton.x[k], part.middle[k]), part.per_half[k]);
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
