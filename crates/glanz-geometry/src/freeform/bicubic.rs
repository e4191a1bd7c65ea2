//! Patches of degree 3 at most, the most frequent ones, in a layout for vector instructions.
//!
//! A patch is stored as coefficients of the powers of (s, t) in [-1, 1]^2 about its centre. Projected along the ray they are
//! two bivariate polynomials, to which Newton's method is applied for any leaf of the patch. The coefficients of a rational
//! patch are homogeneous coordinates about the centre, divided by the weight there.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::contraction::{LocalRoot, MapBounds, PlanarJet};
use super::control_net;
use super::leaf::{LeafProjection, PatchLeaf};
use super::parameter_rect::DyadicRect;
use super::projected_bicubic::{MOST_STEPS, NewtonExit, ProjectedBicubic, value};
use super::ray_space::RaySpace;
use super::root::{FirstOrderJet, SearchScratch, SurfaceRoot};
use super::subdivision::{self, SubdividablePatch};
use crate::bvh::simd::{Simd, Task};

/// Rounding of the powers, relative to that of the Bernstein form: the absolute values of the factors that convert a row
/// of one into the other add up to 5, for both directions to 25, applied to coefficients with a few roundings each.
pub(super) const POWERS: f64 = 4.0;

/// A patch of degrees up to (3, 3), with 3 coordinates, or 4 if weights differ.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Bicubic<const COORDINATES: usize> {
    /// Coefficients by power of s, coordinate, power of t. First, so that vectors of them do not cross cache lines.
    pub(super) powers: [[[f64; 4]; COORDINATES]; 4],
    pub(super) center: DVec3,
    /// Bound on half of any second derivative by (s, t) of the point times its weight.
    pub(super) curvature_bound: f64,
    /// The same for the weight, which is 1 at the centre, and bounds on the weight; rounded outward.
    pub(super) weight_curvature_bound: f32,
    pub(super) weights: [f32; 2],
    /// Constant terms that the powers omit: the rounding of the centre. Only restored control points need them.
    pub(super) remainder: [f32; 3],
}

/// Coefficients of the powers of t = 2 x - 1 from Bernstein coefficients of degree `n`.
fn powers_of(row: [DVec4; 4], n: usize) -> [DVec4; 4] {
    let [a, b, c, d] = row;
    match n {
        1 => [(a + b) * 0.5, (b - a) * 0.5, DVec4::ZERO, DVec4::ZERO],
        2 => [(a + b * 2.0 + c) * 0.25, (c - a) * 0.5, (a - b * 2.0 + c) * 0.25, DVec4::ZERO],
        _ => [
            ((a + d) + (b + c) * 3.0) * 0.125,
            ((d - a) + (c - b)) * 0.375,
            ((a + d) - (b + c)) * 0.375,
            ((d - a) - (c - b) * 3.0) * 0.125,
        ],
    }
}

impl<const COORDINATES: usize> Bicubic<COORDINATES> {
    /// The patch with the homogeneous net `points` of `degrees` up to (3, 3).
    pub(super) fn new(points: &[DVec4], (p, q): (usize, usize)) -> Self {
        let center = control_net::second_order_jet(points, (p, q), 0.5, 0.5).s;
        // About the centre, so that small patches keep their digits; a common factor of the weights drops out.
        let about = |h: DVec4| (h.truncate() - center * h.w).extend(h.w);
        let mut rows = [[DVec4::ZERO; 4]; 4];
        for (row, points) in rows.iter_mut().zip(points.chunks_exact(q + 1)) {
            let mut list = [DVec4::ZERO; 4];
            for (slot, &point) in list.iter_mut().zip(points) {
                *slot = about(point);
            }
            *row = powers_of(list, q);
        }
        let mut table = [[DVec4::ZERO; 4]; 4];
        for j in 0..4 {
            let column = powers_of([rows[0][j], rows[1][j], rows[2][j], rows[3][j]], p);
            for i in 0..4 {
                table[i][j] = column[i];
            }
        }
        let per = 1.0 / table[0][0].w;
        let powers: [[[f64; 4]; COORDINATES]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|list| std::array::from_fn(|j| table[i][j][list] * per))
        });
        let mut patch = Self {
            center,
            curvature_bound: 0.0,
            weight_curvature_bound: 0.0,
            weights: [1.0; 2],
            remainder: [0.0; 3],
            powers,
        };
        // The centre is rounded like the net: its remainder is part of that rounding.
        for (list, remainder) in patch.powers[0].iter_mut().zip(&mut patch.remainder) {
            (*remainder, list[0]) = (list[0] as f32, 0.0);
        }
        patch.curvature_bound = patch.second_order(0..3);
        if COORDINATES == 4 {
            let weights = || points.iter().map(|p| p.w * per);
            let (low, high) = (weights().fold(f64::INFINITY, f64::min), weights().fold(0.0, f64::max));
            patch.weights = [(low as f32).next_down(), (high as f32).next_up()];
            patch.weight_curvature_bound = (patch.second_order(3..COORDINATES) as f32).next_up();
        }
        patch
    }

    /// Bound on half of the second derivative in any direction over the square, for the vector of some coordinates:
    /// max(|f_ss|, |f_tt|) / 2 + |f_st| / 2.
    fn second_order(&self, lists: std::ops::Range<usize>) -> f64 {
        let (mut ss, mut st, mut tt) = (0.0_f64, 0.0, 0.0_f64);
        for (i, row) in self.powers.iter().enumerate() {
            for j in 0..4_usize {
                let lists = row.get(lists.clone()).unwrap_or_default();
                let size = lists.iter().map(|list| list[j] * list[j]).sum::<f64>().sqrt();
                ss += size * (i * i.saturating_sub(1) / 2) as f64;
                st += size * (i * j) as f64;
                tt += size * (j * j.saturating_sub(1) / 2) as f64;
            }
        }
        ss.max(tt) + 0.5 * st
    }

    /// The coefficients of the i-th power of s, in the direction of `axis`, of the point times its weight.
    #[inline(always)]
    fn projected_row<S: Simd>(&self, simd: S, axis: DVec3, i: usize) -> S::F64 {
        let row = &self.powers[i];
        let sum = simd.mul64(simd.load64(&row[0]), simd.splat64(axis.x));
        let sum = simd.mul_add64(simd.load64(&row[1]), simd.splat64(axis.y), sum);
        simd.mul_add64(simd.load64(&row[2]), simd.splat64(axis.z), sum)
    }

    /// Adds `shift`, the distance of the centre from the ray, times the weight.
    #[inline(always)]
    fn shifted<S: Simd>(&self, simd: S, rows: [S::F64; 4], shift: f64) -> [S::F64; 4] {
        let [a, b, c, d] = rows;
        if COORDINATES == 4 {
            let by = simd.splat64(shift);
            let [p, q, r, s] = self.weight_rows(simd);
            [
                simd.mul_add64(p, by, a),
                simd.mul_add64(q, by, b),
                simd.mul_add64(r, by, c),
                simd.mul_add64(s, by, d),
            ]
        } else {
            [simd.add64(a, simd.load64(&[shift, 0.0, 0.0, 0.0])), b, c, d]
        }
    }

    /// The weight at (s, t).
    #[inline(always)]
    fn weight<S: Simd>(&self, simd: S, at: DVec2) -> f64 {
        if COORDINATES < 4 { 1.0 } else { value(simd, &self.weight_rows(simd), at) }
    }

    #[inline(always)]
    fn weight_rows<S: Simd>(&self, simd: S) -> [S::F64; 4] {
        let [a, b, c, d] = &self.powers;
        [
            simd.load64(&a[COORDINATES - 1]),
            simd.load64(&b[COORDINATES - 1]),
            simd.load64(&c[COORDINATES - 1]),
            simd.load64(&d[COORDINATES - 1]),
        ]
    }

    /// The patch projected along the ray, with bounds over a leaf; `from` is the vector from the ray to the centre.
    #[inline(always)]
    fn project<S: Simd>(
        &self,
        simd: S,
        leaf: &PatchLeaf,
        space: &RaySpace,
        from: DVec3,
    ) -> (ProjectedBicubic<S>, MapBounds) {
        let [first, second] = space.axes;
        let c = space.across(from);
        let first = [
            self.projected_row(simd, first, 0),
            self.projected_row(simd, first, 1),
            self.projected_row(simd, first, 2),
            self.projected_row(simd, first, 3),
        ];
        let second = [
            self.projected_row(simd, second, 0),
            self.projected_row(simd, second, 1),
            self.projected_row(simd, second, 2),
            self.projected_row(simd, second, 3),
        ];
        let projected = ProjectedBicubic {
            first: self.shifted(simd, first, c.x),
            second: self.shifted(simd, second, c.y),
        };
        let curvature_bound = if COORDINATES == 4 {
            (self.curvature_bound + f64::from(self.weight_curvature_bound) * c.length())
                * leaf.part.width().max_element().powi(2)
        } else {
            leaf.curvature_bound()
        };
        let weights = self.weights.map(f64::from);
        (projected, MapBounds { noise: space.noise * POWERS, curvature_bound, weights, steps: MOST_STEPS })
    }

    /// The weight at (s, t), without vector instructions.
    fn weight_at(&self, at: DVec2) -> f64 {
        if COORDINATES < 4 {
            return 1.0;
        }
        cubic(self.powers.map(|row| cubic(row[COORDINATES - 1], at.y).0), at.x).0
    }

    #[inline(always)]
    fn root<S: Simd>(
        &self,
        simd: S,
        space: &RaySpace,
        x: DVec2,
        uncertainty: DVec2,
        from: DVec3,
    ) -> SurfaceRoot {
        let along = space.line.direction;
        let (a, b) = (self.projected_row(simd, along, 0), self.projected_row(simd, along, 1));
        let (c, d) = (self.projected_row(simd, along, 2), self.projected_row(simd, along, 3));
        let rows = [a, b, c, d];
        let s = along.dot(from) + value(simd, &rows, x) / self.weight(simd, x);
        let length = |i: usize, j: usize| {
            let row = &self.powers[i];
            DVec3::new(row[0][j], row[1][j], row[2][j]).length()
        };
        let distance_uncertainty = uncertainty.x * length(1, 0) + uncertainty.y * length(0, 1);
        // From parameters in [-1, 1] to those in [0, 1].
        SurfaceRoot { s, at: 0.5 + 0.5 * x, uncertainty: 0.5 * uncertainty, distance_uncertainty }
    }
}

impl<const COORDINATES: usize> Bicubic<COORDINATES> {
    /// Finds every root of the leaf: returns the only one, or puts all of them into `scratch.roots`, unordered.
    #[inline(always)]
    pub(super) fn roots<S: Simd>(
        &self,
        simd: S,
        leaf: &PatchLeaf,
        projection: &LeafProjection,
        space: &RaySpace,
        scratch: &mut SearchScratch,
    ) -> Option<SurfaceRoot> {
        let from = self.center - space.line.origin;
        // No closures around vectors: they would not be compiled for the instruction set.
        if projection.certified {
            let (projected, bounds) = self.project(simd, leaf, space, from);
            match projected.newton(simd, projection.start, leaf.part, &bounds) {
                NewtonExit::Converged(x) => {
                    let uncertainty = projection.uncertainty(&bounds) * leaf.part.width();
                    return Some(self.root(simd, space, x, uncertainty, from));
                }
                NewtonExit::Left { at, jet } => {
                    let half = leaf.part.width();
                    let x = (at - leaf.part.middle()) / half;
                    if projection.certificate.excludes(
                        x,
                        &PlanarJet { f: jet.f, fs: jet.fs * half.x, ft: jet.ft * half.y },
                        self.weight(simd, at),
                        projection.inverse_determinant,
                        &bounds,
                    ) {
                        return None;
                    }
                }
                NewtonExit::Open => {}
            }
        }
        simd.outlined(BicubicSubdivision { patch: self, leaf, space, scratch });
        None
    }
}

/// The search in a leaf for which Newton's method proves nothing: puts every root into `scratch.roots`.
struct BicubicSubdivision<'a, const COORDINATES: usize> {
    patch: &'a Bicubic<COORDINATES>,
    leaf: &'a PatchLeaf,
    space: &'a RaySpace,
    scratch: &'a mut SearchScratch,
}

impl<const COORDINATES: usize> Task for BicubicSubdivision<'_, COORDINATES> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { patch, leaf, space, scratch } = self;
        let from = patch.center - space.line.origin;
        let (projected, bounds) = patch.project(simd, leaf, space, from);
        let (middle, half) = (leaf.part.middle(), leaf.part.width());
        let weight = |at: DVec2| patch.weight_at(middle + half * at);
        scratch.local_roots.clear();
        if projected
            .part(simd, middle, half)
            .divide(simd, &bounds, &weight, &mut scratch.local_roots)
            .is_err()
        {
            subdivision::roots(&BicubicLeaf { patch, part: leaf.part }, space, scratch);
            for root in &mut scratch.roots {
                *root = root.of_part(leaf.part);
            }
            return;
        }
        for index in 0..scratch.local_roots.len() {
            let Some(&LocalRoot { at, uncertainty }) = scratch.local_roots.get(index) else { return };
            let root = patch.root(simd, space, middle + half * at, half * uncertainty, from);
            scratch.roots.push(root);
        }
    }
}

/// A leaf for [`subdivision`].
struct BicubicLeaf<'a, const COORDINATES: usize> {
    patch: &'a Bicubic<COORDINATES>,
    part: DyadicRect,
}

impl<const COORDINATES: usize> SubdividablePatch for BicubicLeaf<'_, COORDINATES> {
    fn degrees(&self) -> (usize, usize) {
        (3, 3)
    }

    fn project(&self, space: &RaySpace, cells: &mut Vec<f64>) -> f64 {
        cells.clear();
        let (powers, from) = (&self.patch.powers, self.patch.center - space.line.origin);
        for axis in space.axes {
            let shift = axis.dot(from);
            let mut table = powers.map(|row| {
                std::array::from_fn(|j| {
                    let seen = row[0][j] * axis.x + row[1][j] * axis.y + row[2][j] * axis.z;
                    seen + if COORDINATES == 4 { row[COORDINATES - 1][j] * shift } else { 0.0 }
                })
            });
            if COORDINATES == 3 {
                table[0][0] += shift;
            }
            cells.extend(self.bernstein(table));
        }
        if COORDINATES == 4 {
            cells.extend(self.bernstein(powers.map(|row| row[COORDINATES - 1])));
        }
        2.0 * POWERS * space.noise
    }

    fn jet(&self, x: f64, y: f64) -> FirstOrderJet {
        let (at, width) = (2.0 * self.part.at(DVec2::new(x, y)) - 1.0, self.part.width());
        let mut lists = [[0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4]];
        for k in 0..COORDINATES {
            let rows = self.patch.powers.map(|row| cubic(row[k], at.y));
            let (by_s, rise) = (cubic(rows.map(|r| r.0), at.x), cubic(rows.map(|r| r.1), at.x));
            // By (x, y), whose interval is half as long.
            [lists[0][k], lists[1][k], lists[2][k]] = [by_s.0, 2.0 * by_s.1, 2.0 * rise.0];
        }
        let [h, hu, hv] = lists.map(DVec4::from_array);
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let part = |d: DVec4, width: f64| (d.truncate() - s * d.w) * (per * width);
        FirstOrderJet { s: self.patch.center + s, su: part(hu, width.x), sv: part(hv, width.y) }
    }

    fn noise(&self, space: &RaySpace) -> f64 {
        POWERS * space.noise
    }
}

impl<const COORDINATES: usize> BicubicLeaf<'_, COORDINATES> {
    /// Bernstein coefficients over the leaf, those along s consecutive, from powers of (s, t) over the patch.
    fn bernstein(&self, table: [[f64; 4]; 4]) -> impl Iterator<Item = f64> + use<COORDINATES> {
        let (middle, half) = (self.part.middle(), self.part.width());
        let rows = table.map(|row| bernstein_of(moved_cubic(row, middle.y, half.y)));
        (0..4).flat_map(move |j| bernstein_of(moved_cubic(rows.map(|row| row[j]), middle.x, half.x)))
    }
}

/// The cubic at m + h x, as powers of x.
fn moved_cubic([a, b, c, d]: [f64; 4], m: f64, h: f64) -> [f64; 4] {
    let [value, slope] = [((d * m + c) * m + b) * m + a, (3.0 * d * m + 2.0 * c) * m + b];
    [value, slope * h, (3.0 * d * m + c) * (h * h), d * (h * h * h)]
}

/// A cubic and its derivative.
fn cubic([a, b, c, d]: [f64; 4], x: f64) -> (f64, f64) {
    (((d * x + c) * x + b) * x + a, (3.0 * d * x + 2.0 * c) * x + b)
}

/// Bernstein coefficients from powers of t in [-1, 1].
pub(super) fn bernstein_of([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let third = 1.0 / 3.0;
    [a - b + c - d, a - (b + c) * third + d, a + (b - c) * third - d, a + b + c + d]
}
