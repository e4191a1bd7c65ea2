//! Patches of degree 3 at most, the most frequent ones: stored so that a ray is done with them in a few vector
//! instructions.
//!
//! A patch keeps the coefficients of the powers of (s, t) in [-1, 1]^2 about its centre. They are seen along the ray once,
//! as two bivariate polynomials, in which Newton's method then runs, for whichever leaf it is. Those of a rational patch
//! are homogeneous coordinates about the centre, divided by the weight there.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::cells::{self, Patch};
use super::contract::{Limits, Place};
use super::leaf::{Leaf, Look};
use super::net;
use super::part::Part;
use super::search::{OnRoot, Probe, Root, Scratch, Tangent};
use super::subpatches::Form;
use super::view::{Aim, MOST_STEPS, View, value};
use crate::bvh::simd::{Simd, Task};

/// Rounding of the powers, in terms of that of the Bernstein form: the absolute values of the factors that convert one row
/// into the other add up to 5, of both directions to 25, on coefficients that each are worth a few roundings.
pub(super) const POWERS: f64 = 4.0;

/// A patch of degrees up to (3, 3), with `LISTS` coordinates: 3, or 4 if weights differ.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Bicubic<const LISTS: usize> {
    center: DVec3,
    /// Bound on the half of any second derivative by (s, t), of the point times its weight.
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
    /// The patch with the homogeneous net `points` of `degrees` up to (3, 3).
    pub(super) fn new(points: &[DVec4], (p, q): (usize, usize)) -> Self {
        let center = net::jet(points, (p, q), 0.5, 0.5).s;
        // About the centre, so that small patches keep their digits; a weight that is common to all drops out.
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
        let powers: [[[f64; 4]; LISTS]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|list| std::array::from_fn(|j| table[i][j][list] * per))
        });
        let mut patch = Self { center, bend: 0.0, weight_bend: 0.0, weights: [1.0; 2], powers };
        // The centre itself is rounded as the net is: what is left of it here belongs to it.
        for list in patch.powers[0].iter_mut().take(3) {
            list[0] = 0.0;
        }
        patch.bend = patch.second_order(0..3);
        if LISTS == 4 {
            let weights = || points.iter().map(|p| p.w * per);
            let (low, high) = (weights().fold(f64::INFINITY, f64::min), weights().fold(0.0, f64::max));
            patch.weights = [(low as f32).next_down(), (high as f32).next_up()];
            patch.weight_bend = (patch.second_order(3..LISTS) as f32).next_up();
        }
        patch
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

    /// The patch as the ray sees it, and what is known about it over a leaf; `from` is the centre.
    #[inline(always)]
    fn view<S: Simd>(&self, simd: S, leaf: &Leaf, probe: &Probe, from: DVec3) -> (View<S>, Limits) {
        let [first, second] = probe.axes;
        let c = probe.across(from);
        let first = [
            self.seen(simd, first, 0),
            self.seen(simd, first, 1),
            self.seen(simd, first, 2),
            self.seen(simd, first, 3),
        ];
        let second = [
            self.seen(simd, second, 0),
            self.seen(simd, second, 1),
            self.seen(simd, second, 2),
            self.seen(simd, second, 3),
        ];
        let view = View { first: self.shifted(simd, first, c.x), second: self.shifted(simd, second, c.y) };
        let bend = if LISTS == 4 {
            (self.bend + f64::from(self.weight_bend) * c.length()) * leaf.part.width().max_element().powi(2)
        } else {
            leaf.bend()
        };
        let weights = self.weights.map(f64::from);
        (view, Limits { noise: probe.noise * POWERS, bend, weights, steps: MOST_STEPS })
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
        Root { s, at: 0.5 + 0.5 * x, blur: 0.5 * blur, reach }
    }
}

impl<const LISTS: usize> Form for Bicubic<LISTS> {
    #[inline(always)]
    fn roots<S: Simd>(
        &self,
        simd: S,
        leaf: &Leaf,
        look: &Look,
        probe: &Probe,
        scratch: &mut Scratch,
        report: &mut impl OnRoot,
    ) {
        let from = self.center - probe.line.origin;
        // No closures around vectors: they would not be compiled for the instruction set.
        if look.certified {
            let (view, limits) = self.view(simd, leaf, probe, from);
            match view.newton(simd, look.flat, leaf.part, &limits) {
                Aim::Root(x) => {
                    let blur = look.blur(&limits) * leaf.part.width();
                    report.root(self.root(simd, probe, x, blur, from));
                    return;
                }
                Aim::Left { at, f } => {
                    let x = (at - leaf.part.middle()) / leaf.part.width();
                    if look.certificate.excludes(x, f, self.weight(simd, at), look.per, &limits) {
                        return;
                    }
                }
                Aim::Open => {}
            }
        }
        simd.apart(Search { patch: self, leaf, probe, scratch: &mut *scratch });
        for root in scratch.roots.drain(..) {
            report.root(root);
        }
    }
}

/// What is done with a leaf if the first try proves nothing: every root into `scratch.roots`.
struct Search<'a, const LISTS: usize> {
    patch: &'a Bicubic<LISTS>,
    leaf: &'a Leaf,
    probe: &'a Probe,
    scratch: &'a mut Scratch,
}

impl<const LISTS: usize> Task for Search<'_, LISTS> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { patch, leaf, probe, scratch } = self;
        let from = patch.center - probe.line.origin;
        let (view, limits) = patch.view(simd, leaf, probe, from);
        let (middle, half) = (leaf.part.middle(), leaf.part.width());
        let weight = |at: DVec2| patch.weight_at(middle + half * at);
        scratch.places.clear();
        if view.part(simd, middle, half).divide(simd, &limits, &weight, &mut scratch.places).is_err() {
            cells::roots(&PatchLeaf { patch, part: leaf.part }, probe, scratch);
            for root in &mut scratch.roots {
                *root = root.of_part(leaf.part);
            }
            return;
        }
        for index in 0..scratch.places.len() {
            let Some(&Place { at, blur }) = scratch.places.get(index) else { return };
            let root = patch.root(simd, probe, middle + half * at, half * blur, from);
            scratch.roots.push(root);
        }
    }
}

/// A leaf for the slow way.
struct PatchLeaf<'a, const LISTS: usize> {
    patch: &'a Bicubic<LISTS>,
    part: Part,
}

impl<const LISTS: usize> Patch for PatchLeaf<'_, LISTS> {
    fn degrees(&self) -> (usize, usize) {
        (3, 3)
    }

    fn project(&self, probe: &Probe, cells: &mut Vec<f64>) -> f64 {
        cells.clear();
        let (powers, from) = (&self.patch.powers, self.patch.center - probe.line.origin);
        for axis in probe.axes {
            let shift = axis.dot(from);
            let mut table = powers.map(|row| {
                std::array::from_fn(|j| {
                    let seen = row[0][j] * axis.x + row[1][j] * axis.y + row[2][j] * axis.z;
                    seen + if LISTS == 4 { row[LISTS - 1][j] * shift } else { 0.0 }
                })
            });
            if LISTS == 3 {
                table[0][0] += shift;
            }
            cells.extend(self.bernstein(table));
        }
        if LISTS == 4 {
            cells.extend(self.bernstein(powers.map(|row| row[LISTS - 1])));
        }
        2.0 * POWERS * probe.noise
    }

    fn tangent(&self, x: f64, y: f64) -> Tangent {
        let (at, width) = (2.0 * self.part.at(DVec2::new(x, y)) - 1.0, self.part.width());
        let mut lists = [[0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4]];
        for k in 0..LISTS {
            let rows = self.patch.powers.map(|row| cubic(row[k], at.y));
            let (by_s, rise) = (cubic(rows.map(|r| r.0), at.x), cubic(rows.map(|r| r.1), at.x));
            // By (x, y), which are half as long.
            [lists[0][k], lists[1][k], lists[2][k]] = [by_s.0, 2.0 * by_s.1, 2.0 * rise.0];
        }
        let [h, hu, hv] = lists.map(DVec4::from_array);
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let part = |d: DVec4, width: f64| (d.truncate() - s * d.w) * (per * width);
        Tangent { s: self.patch.center + s, su: part(hu, width.x), sv: part(hv, width.y) }
    }

    fn noise(&self, probe: &Probe) -> f64 {
        POWERS * probe.noise
    }
}

impl<const LISTS: usize> PatchLeaf<'_, LISTS> {
    /// Bernstein coefficients over the leaf, those along s together, from powers of (s, t) over the patch.
    fn bernstein(&self, table: [[f64; 4]; 4]) -> impl Iterator<Item = f64> + use<LISTS> {
        let (middle, half) = (self.part.middle(), self.part.width());
        let rows = table.map(|row| bernstein_of(moved_cubic(row, middle.y, half.y)));
        (0..4).flat_map(move |j| bernstein_of(moved_cubic(rows.map(|row| row[j]), middle.x, half.x)))
    }
}

/// The cubic at m + h x, by powers of x.
fn moved_cubic([a, b, c, d]: [f64; 4], m: f64, h: f64) -> [f64; 4] {
    let [value, slope] = [((d * m + c) * m + b) * m + a, (3.0 * d * m + 2.0 * c) * m + b];
    [value, slope * h, (3.0 * d * m + c) * (h * h), d * (h * h * h)]
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
