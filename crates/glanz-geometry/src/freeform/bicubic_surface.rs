//! The surface of a bicubic patch by its powers: points with derivatives, and control points.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::bicubic::{Bicubic, bernstein_of};
use super::control_net::{PatchJet, SecondOrderJet};
use crate::bvh::simd::{Simd, Task};

/// Evaluation of the point, first and second derivatives of a polynomial patch at parameters in [0, 1].
pub(super) struct BicubicJet<'a> {
    pub(super) patch: &'a Bicubic<3>,
    pub(super) x: f64,
    pub(super) y: f64,
}

/// Evaluation of the point and first derivatives of a polynomial patch at parameters in [0, 1].
pub(super) struct BicubicTangents<'a> {
    pub(super) patch: &'a Bicubic<3>,
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Task for BicubicTangents<'_> {
    type Output = PatchJet;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> PatchJet {
        // The compiler drops what is not used.
        let SecondOrderJet { s, su, sv, .. } = jet(simd, self.patch, self.x, self.y);
        PatchJet { s, su, sv }
    }
}

impl Task for BicubicJet<'_> {
    type Output = SecondOrderJet;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> SecondOrderJet {
        jet(simd, self.patch, self.x, self.y)
    }
}

/// Point, first and second derivatives by (x, y), by Horner's rule with one rounding per step.
#[inline(always)]
fn jet<S: Simd>(simd: S, patch: &Bicubic<3>, x: f64, y: f64) -> SecondOrderJet {
    let Bicubic { center, powers: [a, b, c, d], .. } = patch;
    let (s, t) = (simd.splat64(2.0 * x - 1.0), 2.0 * y - 1.0);
    let [two, three, six] = [simd.splat64(2.0), simd.splat64(3.0), simd.splat64(6.0)];
    // By coordinate: value, derivatives by s, t, ss, st and tt. No closures around vectors: they would not be compiled for the
    // instruction set.
    let mut terms = [[0.0; 6]; 3];
    for (k, term) in terms.iter_mut().enumerate() {
        let (a, b) = (simd.load64(&a[k]), simd.load64(&b[k]));
        let (c, d) = (simd.load64(&c[k]), simd.load64(&d[k]));
        let value = simd.mul_add64(simd.mul_add64(simd.mul_add64(d, s, c), s, b), s, a);
        let twice_c = simd.mul64(two, c);
        let rise = simd.mul_add64(simd.mul_add64(simd.mul64(three, d), s, twice_c), s, b);
        let second = simd.mul_add64(simd.mul64(six, d), s, twice_c);
        let (value, rise) = (simd.store64(value), simd.store64(rise));
        let [_, _, g, h] = value;
        *term = [
            cubic(value, t),
            cubic(rise, t),
            slope(value, t),
            cubic(simd.store64(second), t),
            slope(rise, t),
            (6.0 * h).mul_add(t, 2.0 * g),
        ];
    }
    // By (x, y), whose intervals are half as long as those of (s, t).
    let vector = |i: usize, factor: f64| DVec3::new(terms[0][i], terms[1][i], terms[2][i]) * factor;
    SecondOrderJet {
        s: *center + vector(0, 1.0),
        su: vector(1, 2.0),
        sv: vector(2, 2.0),
        suu: vector(3, 4.0),
        suv: vector(4, 4.0),
        svv: vector(5, 4.0),
    }
}

impl Bicubic<3> {
    /// Points and first derivatives at eight pairs of parameters, with the bits of [`BicubicTangents`].
    #[inline(always)]
    pub(super) fn tangent_lanes<S: Simd>(&self, simd: S, [x, y]: [S::Wide; 2]) -> [[S::Wide; 3]; 3] {
        let [one, two, three] = [simd.splat8(1.0), simd.splat8(2.0), simd.splat8(3.0)];
        let (s, t) = (simd.sub8(simd.mul8(two, x), one), simd.sub8(simd.mul8(two, y), one));
        let [a, b, c, d] = &self.powers;
        let zero = simd.splat8(0.0);
        let [mut point, mut by_x, mut by_y] = [[zero; 3]; 3];
        for k in 0..3 {
            let (mut value, mut rise) = ([zero; 4], [zero; 4]);
            for j in 0..4 {
                let (b, c, d) = (simd.splat8(b[k][j]), simd.splat8(c[k][j]), simd.splat8(d[k][j]));
                let sum = simd.mul_add8(simd.mul_add8(d, s, c), s, b);
                value[j] = simd.mul_add8(sum, s, simd.splat8(a[k][j]));
                let sum = simd.mul_add8(simd.mul8(three, d), s, simd.mul8(two, c));
                rise[j] = simd.mul_add8(sum, s, b);
            }
            let across = simd.mul_add8(simd.mul8(three, value[3]), t, simd.mul8(two, value[2]));
            point[k] = simd.add8(simd.splat8(self.center[k]), cubic_lanes(simd, value, t));
            by_x[k] = simd.mul8(cubic_lanes(simd, rise, t), two);
            by_y[k] = simd.mul8(simd.mul_add8(across, t, value[1]), two);
        }
        [point, by_x, by_y]
    }

    /// Homogeneous control points of these degrees, up to (3, 3), that of (i, j) at i (q + 1) + j: those from which the patch was made,
    /// up to a few roundings, if their weights are 1. The same bits in every call, on which
    /// [`NetCorrections`](super::net_corrections::NetCorrections) rely.
    pub(super) fn control_points(&self, (p, q): (usize, usize)) -> Vec<DVec4> {
        let mut nets = [[[0.0; 4]; 4]; 3];
        for (k, net) in nets.iter_mut().enumerate() {
            let mut powers = self.powers.map(|row| row[k]);
            powers[0][0] += f64::from(self.remainder[k]);
            let rows = powers.map(|row| bernstein_of_degree(row, q));
            for j in 0..=q {
                let column = bernstein_of_degree(rows.map(|row| row[j]), p);
                for (row, value) in net.iter_mut().zip(column) {
                    row[j] = value;
                }
            }
        }
        let point = |i: usize, j: usize| self.center + DVec3::from_array(nets.map(|net| net[i][j]));
        (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))).map(|(i, j)| point(i, j).extend(1.0)).collect()
    }
}

/// The value of eight cubics.
#[inline(always)]
fn cubic_lanes<S: Simd>(simd: S, [a, b, c, d]: [S::Wide; 4], t: S::Wide) -> S::Wide {
    simd.mul_add8(simd.mul_add8(simd.mul_add8(d, t, c), t, b), t, a)
}

/// The value of a cubic.
#[inline(always)]
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    d.mul_add(t, c).mul_add(t, b).mul_add(t, a)
}

/// The derivative of a cubic.
#[inline(always)]
fn slope([_, b, c, d]: [f64; 4], t: f64) -> f64 {
    (3.0 * d).mul_add(t, 2.0 * c).mul_add(t, b)
}

/// Bernstein coefficients of degree `n` up to 3 from powers of t in [-1, 1].
fn bernstein_of_degree([a, b, c, d]: [f64; 4], n: usize) -> [f64; 4] {
    match n {
        1 => [a - b, a + b, 0.0, 0.0],
        2 => [a - b + c, a - c, a + b + c, 0.0],
        _ => bernstein_of([a, b, c, d]),
    }
}
