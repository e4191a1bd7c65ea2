//! Leaves of degree 3 at most, the most frequent ones: stored so that a ray is done with them in a few vector instructions.
//!
//! A leaf keeps the coefficients of the powers of (s, t) in [-1, 1]^2 about its centre. The first ones are centre and
//! half tangents of the thick parallelogram; the next, of second order, give the place where the search starts. All are
//! seen along the ray once, as two bivariate polynomials, in which Newton's method then runs. Those of a rational leaf
//! are homogeneous coordinates about the centre, divided by the weight there.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::cells::{self, Patch};
use super::contract::{Certificate, Limits, Place};
use super::leaf::Frame;
use super::search::{OnRoot, Probe, Root, Scratch, Tangent, cross};
use super::view::{Aim, CERTIFIED, MOST_STEPS, View, value};
use crate::bvh::simd::{Simd, Task};

/// Rounding of the powers, in terms of that of the Bernstein form: the absolute values of the factors that convert one row
/// into the other add up to 5, of both directions to 25, on coefficients that each are worth a few roundings.
const POWERS: f64 = 4.0;

/// A leaf of degrees up to (3, 3), with `LISTS` coordinates: 3, or 4 if weights differ.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Bicubic<const LISTS: usize> {
    center: DVec3,
    /// See [`Frame`].
    reach: f64,
    stray_squared: f64,
    bend: f64,
    /// The same for the weight, whose value at the centre is 1, and bounds on it; rounded outward.
    weight_bend: f32,
    weights: [f32; 2],
    /// By power of s, coordinate, power of t.
    powers: [[[f64; 4]; LISTS]; 4],
}

/// From Bernstein coefficients of degree `n` to the powers of t = 2 x - 1.
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

impl<const LISTS: usize> Bicubic<LISTS> {
    /// The leaf with the homogeneous net `points` of `degrees` up to (3, 3) and its frame.
    pub(super) fn new(points: &[DVec4], (p, q): (usize, usize), frame: &Frame) -> Self {
        // About the centre, so that small leaves keep their digits; a weight that is common to all drops out.
        let about = |h: DVec4| (h.truncate() - frame.center * h.w).extend(h.w);
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
        let powers: [[[f64; 4]; LISTS]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|list| std::array::from_fn(|j| table[i][j][list] * per))
        });
        let mut leaf = Self {
            center: frame.center,
            reach: frame.reach,
            stray_squared: frame.stray_squared,
            bend: 0.0,
            weight_bend: 0.0,
            weights: [1.0; 2],
            powers,
        };
        // The centre itself is rounded as the net is: what is left of it here belongs to it.
        for list in leaf.powers[0].iter_mut().take(3) {
            list[0] = 0.0;
        }
        leaf.bend = leaf.second_order(0..3);
        if LISTS == 4 {
            let weights = || points.iter().map(|p| p.w * per);
            let (low, high) = (weights().fold(f64::INFINITY, f64::min), weights().fold(0.0, f64::max));
            leaf.weights = [(low as f32).next_down(), (high as f32).next_up()];
            leaf.weight_bend = (leaf.second_order(3..LISTS) as f32).next_up();
        }
        leaf
    }

    /// Bound on the sum of |f_ss| / 2, |f_st| and |f_tt| / 2 over the square, of the vector of the given lists.
    fn second_order(&self, lists: std::ops::Range<usize>) -> f64 {
        let mut sum = 0.0;
        for (i, row) in self.powers.iter().enumerate() {
            for j in 0..4_usize {
                let lists = row.get(lists.clone()).unwrap_or_default();
                let size = lists.iter().map(|list| list[j] * list[j]).sum::<f64>().sqrt();
                sum += size * (i * i.saturating_sub(1) / 2 + i * j + j * j.saturating_sub(1) / 2) as f64;
            }
        }
        sum
    }

    /// The coefficients of the powers i of s, seen along `axis`, of the point times its weight.
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, axis: DVec3, i: usize) -> S::F64 {
        let row = &self.powers[i];
        let sum = simd.mul64(simd.load64(&row[0]), simd.splat64(axis.x));
        let sum = simd.mul_add64(simd.load64(&row[1]), simd.splat64(axis.y), sum);
        simd.mul_add64(simd.load64(&row[2]), simd.splat64(axis.z), sum)
    }

    /// Adds `shift`, the centre seen from the ray, times the weight.
    #[inline(always)]
    fn shifted<S: Simd>(&self, simd: S, seen: [S::F64; 4], shift: f64) -> [S::F64; 4] {
        let [a, b, c, d] = seen;
        if LISTS == 4 {
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
        if LISTS < 4 { 1.0 } else { value(simd, &self.weight_rows(simd), at) }
    }

    #[inline(always)]
    fn weight_rows<S: Simd>(&self, simd: S) -> [S::F64; 4] {
        let [a, b, c, d] = &self.powers;
        [
            simd.load64(&a[LISTS - 1]),
            simd.load64(&b[LISTS - 1]),
            simd.load64(&c[LISTS - 1]),
            simd.load64(&d[LISTS - 1]),
        ]
    }

    /// Asks the memory for what the first look needs: most leaves get no second one.
    #[inline(always)]
    pub(super) fn prefetch<S: Simd>(&self, simd: S) {
        simd.prefetch(&self.center);
        simd.prefetch(&self.powers[0]);
        simd.prefetch(&self.powers[1]);
    }

    /// Reports every root of the leaf, in no order.
    #[inline(always)]
    pub(super) fn roots<S: Simd>(
        &self,
        simd: S,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    ) {
        let noise = probe.noise * POWERS;
        let from = self.center - probe.line.origin;
        let c = probe.across(from);
        // No closures around vectors: they would not be compiled for the instruction set.
        let [first, second] = probe.axes;
        let (f0, f1) = (self.seen(simd, first, 0), self.seen(simd, first, 1));
        let (g0, g1) = (self.seen(simd, second, 0), self.seen(simd, second, 1));
        let (p0, p1, q0, q1) = (simd.store64(f0), simd.store64(f1), simd.store64(g0), simd.store64(g1));
        let (a, b) = (DVec2::new(p1[0], q1[0]), DVec2::new(p0[1], q0[1]));
        let det = cross(a, b);
        let (s, t) = (-cross(c, b), -cross(a, c));
        let (a2, b2) = (a.length_squared(), b.length_squared());
        let reach = self.reach + noise;
        // |s| > 1 + reach |b| / |det| without a division; squares would need a root either way.
        let outside = |s: f64, across: f64| {
            let beyond = s.abs() - det.abs();
            beyond > 0.0 && beyond * beyond > reach * reach * across
        };
        if outside(s, b2) || outside(t, a2) {
            return;
        }
        // Where rounding moves the root by more than a part of the leaf, nothing is certified. NaN says no.
        let stray_squared = self.stray_squared + (16.0 * noise) * (16.0 * noise);
        if stray_squared * (a2 + b2) < CERTIFIED * CERTIFIED * det * det {
            let (view, limits) = self.view(simd, probe, [[f0, f1], [g0, g1]], c);
            let per = 1.0 / det;
            let q = (stray_squared * (a2 + b2)).sqrt() * per.abs();
            match view.newton(simd, &Certificate { a, b, q }, per, DVec2::new(s, t) * per, &limits) {
                Aim::Root(x) => {
                    let blur = DVec2::new(b2, a2).map(f64::sqrt) * (2.0 * noise * per.abs());
                    report.root(self.root(simd, probe, x, blur, from));
                    return;
                }
                Aim::Excluded => return,
                Aim::Open => {}
            }
        }
        simd.apart(Search { leaf: self, probe, scratch: &mut *scratch });
        for root in scratch.roots.drain(..) {
            report.root(root);
        }
    }

    /// The leaf as the ray sees it, from what it has seen of it already; `c` is the centre.
    #[inline(always)]
    fn view<S: Simd>(
        &self,
        simd: S,
        probe: &Probe,
        [[f0, f1], [g0, g1]]: [[S::F64; 2]; 2],
        c: DVec2,
    ) -> (View<S>, Limits) {
        let [first, second] = probe.axes;
        let first = [f0, f1, self.seen(simd, first, 2), self.seen(simd, first, 3)];
        let second = [g0, g1, self.seen(simd, second, 2), self.seen(simd, second, 3)];
        let view = View { first: self.shifted(simd, first, c.x), second: self.shifted(simd, second, c.y) };
        let bend = self.bend + if LISTS == 4 { f64::from(self.weight_bend) * c.length() } else { 0.0 };
        (
            view,
            Limits {
                noise: probe.noise * POWERS,
                bend,
                weights: self.weights.map(f64::from),
                steps: MOST_STEPS,
            },
        )
    }

    /// The weight at (s, t), outside of vector code.
    fn weight_at(&self, at: DVec2) -> f64 {
        if LISTS < 4 {
            return 1.0;
        }
        cubic(self.powers.map(|row| cubic(row[LISTS - 1], at.y).0), at.x).0
    }

    #[inline(always)]
    fn root<S: Simd>(&self, simd: S, probe: &Probe, x: DVec2, blur: DVec2, from: DVec3) -> Root {
        let along = probe.line.direction;
        let (a, b) = (self.seen(simd, along, 0), self.seen(simd, along, 1));
        let (c, d) = (self.seen(simd, along, 2), self.seen(simd, along, 3));
        let rows = [a, b, c, d];
        let s = along.dot(from) + value(simd, &rows, x) / self.weight(simd, x);
        let length = |i: usize, j: usize| {
            let row = &self.powers[i];
            DVec3::new(row[0][j], row[1][j], row[2][j]).length()
        };
        let reach = blur.x * length(1, 0) + blur.y * length(0, 1);
        // From parameters in [-1, 1] to those in [0, 1].
        Root { s, x: 0.5 + 0.5 * x.x, y: 0.5 + 0.5 * x.y, blur: 0.5 * blur, reach }
    }
}

/// What is done with a leaf if the first try proves nothing: every root into `scratch.roots`.
struct Search<'a, const LISTS: usize> {
    leaf: &'a Bicubic<LISTS>,
    probe: &'a Probe,
    scratch: &'a mut Scratch,
}

impl<const LISTS: usize> Task for Search<'_, LISTS> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { leaf, probe, scratch } = self;
        let from = leaf.center - probe.line.origin;
        let [first, second] = probe.axes;
        let seen = [
            [leaf.seen(simd, first, 0), leaf.seen(simd, first, 1)],
            [leaf.seen(simd, second, 0), leaf.seen(simd, second, 1)],
        ];
        let (view, limits) = leaf.view(simd, probe, seen, probe.across(from));
        scratch.places.clear();
        if view.divide(simd, &limits, &|at| leaf.weight_at(at), &mut scratch.places).is_err() {
            return cells::roots(leaf, probe, scratch);
        }
        for index in 0..scratch.places.len() {
            let Some(&Place { at, blur }) = scratch.places.get(index) else { return };
            let root = leaf.root(simd, probe, at, blur, from);
            scratch.roots.push(root);
        }
    }
}

impl<const LISTS: usize> Patch for Bicubic<LISTS> {
    fn degrees(&self) -> (usize, usize) {
        (3, 3)
    }

    fn project(&self, probe: &Probe, cells: &mut Vec<f64>) -> f64 {
        cells.clear();
        let from = self.center - probe.line.origin;
        for axis in probe.axes {
            let shift = axis.dot(from);
            let mut table = self.powers.map(|row| {
                std::array::from_fn(|j| {
                    let seen = row[0][j] * axis.x + row[1][j] * axis.y + row[2][j] * axis.z;
                    seen + if LISTS == 4 { row[LISTS - 1][j] * shift } else { 0.0 }
                })
            });
            if LISTS == 3 {
                table[0][0] += shift;
            }
            let rows = table.map(bernstein_of);
            let columns: [[f64; 4]; 4] = std::array::from_fn(|j| bernstein_of(rows.map(|row| row[j])));
            cells.extend(columns.into_iter().flatten());
        }
        if LISTS == 4 {
            let rows = self.powers.map(|row| bernstein_of(row[LISTS - 1]));
            cells.extend((0..4).flat_map(|j| bernstein_of(rows.map(|row| row[j]))));
        }
        2.0 * POWERS * probe.noise
    }

    fn tangent(&self, x: f64, y: f64) -> Tangent {
        let (s, t) = (2.0 * x - 1.0, 2.0 * y - 1.0);
        let mut lists = [[0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4]];
        for k in 0..LISTS {
            let rows = self.powers.map(|row| cubic(row[k], t));
            let (by_s, rise) = (cubic(rows.map(|r| r.0), s), cubic(rows.map(|r| r.1), s));
            // By (x, y), which are half as long.
            [lists[0][k], lists[1][k], lists[2][k]] = [by_s.0, 2.0 * by_s.1, 2.0 * rise.0];
        }
        let [h, hu, hv] = lists.map(DVec4::from_array);
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let part = |d: DVec4| (d.truncate() - s * d.w) * per;
        Tangent { s: self.center + s, su: part(hu), sv: part(hv) }
    }

    fn noise(&self, probe: &Probe) -> f64 {
        POWERS * probe.noise
    }
}

/// A cubic and its derivative.
fn cubic([a, b, c, d]: [f64; 4], x: f64) -> (f64, f64) {
    (((d * x + c) * x + b) * x + a, (3.0 * d * x + 2.0 * c) * x + b)
}

/// From powers of t in [-1, 1] to Bernstein coefficients.
fn bernstein_of([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let third = 1.0 / 3.0;
    [a - b + c - d, a - (b + c) * third + d, a + (b - c) * third - d, a + b + c + d]
}
