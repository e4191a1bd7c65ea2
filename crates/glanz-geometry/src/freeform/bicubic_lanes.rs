//! Bicubic patches of eight pairs of a ray and a leaf, projected along the rays: [`Bicubic`]'s projection lane by lane, with the
//! same bits.
//!
//! The coefficients of pairs of one patch are broadcast, those of other pairs transposed into lanes; all else is common.

use super::bicubic::Bicubic;
use super::pair_lanes::{JetLanes, PairLanes};
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// The patches of eight pairs.
pub(super) trait PatchLanes<S: Simd, const COORDINATES: usize> {
    /// Eight consecutive coefficients: the first of two powers of s, of two coordinates, and so on, as they are stored.
    fn coefficients(&self, simd: S, chunk: usize) -> [S::Wide; LANES];
    /// A constant of each patch.
    fn constant(&self, simd: S, constant: PatchConstant) -> S::Wide;
}

/// The constants of a patch that the iteration needs.
#[derive(Clone, Copy)]
pub(super) enum PatchConstant {
    /// A coordinate of its centre.
    Center(usize),
    /// The bound on its curvature.
    Curvature,
    /// The bound on the curvature of its weight.
    WeightCurvature,
    /// The lower or the upper bound on its weight.
    Weight(usize),
}

impl PatchConstant {
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
    fn constant(&self, simd: S, constant: PatchConstant) -> S::Wide {
        simd.splat8(constant.of(*self))
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
    fn constant(&self, simd: S, constant: PatchConstant) -> S::Wide {
        let mut lanes = [0.0; LANES];
        for (lane, patch) in lanes.iter_mut().zip(self) {
            *lane = constant.of(patch);
        }
        simd.load8(&lanes)
    }
}

/// Number of coefficients of a bicubic polynomial.
const COUNT: usize = 16;

/// Polynomials in (s, t) of eight pairs: the coefficient of s^i t^j at 4 i + j.
pub(super) type Polynomial<Wide> = [Wide; COUNT];

/// Eight patches projected along their rays.
pub(super) struct ProjectedLanes<S: Simd> {
    /// Distances from two planes through the ray, times weight.
    across: [Polynomial<S::Wide>; 2],
    /// Distance along the ray, times weight.
    pub(super) along: Polynomial<S::Wide>,
    pub(super) weight: Polynomial<S::Wide>,
}

/// A cubic at `x`.
#[inline(always)]
fn cubic<S: Simd>(simd: S, [a, b, c, d]: [S::Wide; 4], x: S::Wide, square: S::Wide) -> S::Wide {
    simd.mul_add8(simd.mul_add8(d, x, c), square, simd.mul_add8(b, x, a))
}

/// The derivative of a cubic at x, by 2 x and 3 x^2.
#[inline(always)]
fn slope<S: Simd>(simd: S, [_, b, c, d]: [S::Wide; 4], [double, triple]: [S::Wide; 2]) -> S::Wide {
    simd.mul_add8(d, triple, simd.mul_add8(c, double, b))
}

/// The polynomial at `x` by Horner's rule.
#[inline(always)]
pub(super) fn value<S: Simd>(simd: S, rows: &Polynomial<S::Wide>, x: [S::Wide; 2]) -> S::Wide {
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
    pub(super) fn new<const COORDINATES: usize>(
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
    pub(super) fn jet(&self, simd: S, x: [S::Wide; 2]) -> JetLanes<S> {
        let [s, t] = x;
        let (s2, t2, three) = (simd.mul8(s, s), simd.mul8(t, t), simd.splat8(3.0));
        let by_s = [simd.add8(s, s), simd.mul8(three, s2)];
        let by_t = [simd.add8(t, t), simd.mul8(three, t2)];
        let (mut f, mut fs, mut ft) = ([s; 2], [s; 2], [s; 2]);
        for (k, rows) in self.across.iter().enumerate() {
            let (mut values, mut slopes) = ([s; 4], [s; 4]);
            for j in 0..4 {
                let column = [rows[j], rows[4 + j], rows[8 + j], rows[12 + j]];
                values[j] = cubic(simd, column, s, s2);
                slopes[j] = slope(simd, column, by_s);
            }
            f[k] = cubic(simd, values, t, t2);
            fs[k] = cubic(simd, slopes, t, t2);
            ft[k] = slope(simd, values, by_t);
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
