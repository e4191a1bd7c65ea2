//! Evaluation and subdivision of control nets, as plain arrays.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use crate::bezier::bernstein::{BernsteinCoefficient, ROW_DEGREE, halve, pascal_triangle};
use crate::bvh::simd::{Isa, Simd, Task};

/// The largest degree of a patch in one direction; that of the common CAD kernels.
pub const MAX_DEGREE: usize = ROW_DEGREE;

/// Runs `$run` with `$n` as the length of rows for bases of `$degree`: most are short, and long rows cost time.
macro_rules! with_room {
    ($degree:expr, $n:ident => $run:expr) => {
        match $degree {
            0..=3 => {
                const $n: usize = 4;
                $run
            }
            4..=7 => {
                const $n: usize = 8;
                $run
            }
            _ => {
                const $n: usize = $crate::freeform::control_net::MAX_DEGREE + 1;
                $run
            }
        }
    };
}
pub(super) use with_room;

/// Rows of Pascal's triangle.
pub(super) const BINOMIALS: [[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1] = pascal_triangle();

/// The powers of x and of 1 - x in Bernstein polynomials of a degree less than `N`.
pub(super) struct BernsteinPowers<const N: usize> {
    degree: usize,
    x: [f64; N],
    y: [f64; N],
}

impl<const N: usize> BernsteinPowers<N> {
    #[inline(always)]
    pub(super) fn new(degree: usize, x: f64) -> Self {
        let mut powers = Self { degree, x: [1.0; N], y: [1.0; N] };
        let y = 1.0 - x;
        // Half-open ranges: loops over inclusive ones are not unrolled.
        for i in 1..degree + 1 {
            powers.x[i] = powers.x[i - 1] * x;
            powers.y[i] = powers.y[i - 1] * y;
        }
        powers
    }

    /// The polynomials of a degree lower by `less`; zero if there is no such degree.
    #[inline(always)]
    fn row(&self, less: usize) -> [f64; N] {
        let mut row = [0.0; N];
        let Some(n) = self.degree.checked_sub(less) else { return row };
        let binomials = &BINOMIALS[n];
        for i in 0..n + 1 {
            row[i] = binomials[i] * self.x[i] * self.y[n - i];
        }
        row
    }

    #[inline(always)]
    pub(super) fn values(&self) -> [f64; N] {
        self.row(0)
    }

    /// First derivatives.
    #[inline(always)]
    pub(super) fn first_derivatives(&self) -> [f64; N] {
        differences(&self.row(1), self.degree)
    }

    /// Second derivatives.
    #[inline(always)]
    pub(super) fn second_derivatives(&self) -> [f64; N] {
        let rise = differences(&self.row(2), self.degree.saturating_sub(1));
        differences(&rise, self.degree)
    }
}

/// Derivatives of polynomials from those of a degree lower by one: entry i is `degree` (row\[i - 1\] - row\[i\]).
#[inline(always)]
fn differences<const N: usize>(row: &[f64; N], degree: usize) -> [f64; N] {
    let mut out = [0.0; N];
    let factor = degree as f64;
    out[0] = -factor * row[0];
    for i in 1..N {
        out[i] = factor * (row[i - 1] - row[i]);
    }
    out
}

/// A point of a patch with its first and second derivatives by the parameters of the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondOrderJet {
    pub(super) s: DVec3,
    pub(super) su: DVec3,
    pub(super) sv: DVec3,
    pub(super) suu: DVec3,
    pub(super) suv: DVec3,
    pub(super) svv: DVec3,
}

/// The homogeneous net `points`, that of (i, j) at i (q + 1) + j, and its derivatives by u and by v at (u, v): zero without
/// `DERIVATIVES`.
#[inline(always)]
pub(super) fn first_order<S: Simd, const DERIVATIVES: bool>(
    simd: S,
    points: &[DVec4],
    degrees: (usize, usize),
    u: f64,
    v: f64,
) -> [DVec4; 3] {
    match degrees {
        // The most frequent ones, with loops of a fixed length.
        (3, 3) => first_order_in::<S, 4, DERIVATIVES>(simd, points, (3, 3), u, v),
        (4, 4) => first_order_in::<S, 5, DERIVATIVES>(simd, points, (4, 4), u, v),
        (5, 5) => first_order_in::<S, 6, DERIVATIVES>(simd, points, (5, 5), u, v),
        (6, 6) => first_order_in::<S, 7, DERIVATIVES>(simd, points, (6, 6), u, v),
        (7, 7) => first_order_in::<S, 8, DERIVATIVES>(simd, points, (7, 7), u, v),
        _ => {
            with_room!(degrees.0.max(degrees.1), N => first_order_in::<S, N, DERIVATIVES>(simd, points, degrees, u, v))
        }
    }
}

#[inline(always)]
fn first_order_in<S: Simd, const N: usize, const DERIVATIVES: bool>(
    simd: S,
    points: &[DVec4],
    (p, q): (usize, usize),
    u: f64,
    v: f64,
) -> [DVec4; 3] {
    let (by_u, by_v) = (BernsteinPowers::<N>::new(p, u), BernsteinPowers::<N>::new(q, v));
    let (bu, du, bv, dv) = (by_u.values(), by_u.first_derivatives(), by_v.values(), by_v.first_derivatives());
    let zero = simd.splat64(0.0);
    let (mut h, mut hu, mut hv) = (zero, zero, zero);
    for ((row, bu), du) in points.chunks_exact(q + 1).zip(bu).zip(du) {
        let (mut along, mut rise) = (zero, zero);
        for ((point, bv), dv) in row.iter().zip(bv).zip(dv) {
            let point = simd.load64(&point.to_array());
            along = simd.mul_add64(point, simd.splat64(bv), along);
            if DERIVATIVES {
                rise = simd.mul_add64(point, simd.splat64(dv), rise);
            }
        }
        h = simd.mul_add64(along, simd.splat64(bu), h);
        if DERIVATIVES {
            hu = simd.mul_add64(along, simd.splat64(du), hu);
            hv = simd.mul_add64(rise, simd.splat64(bu), hv);
        }
    }
    [unpack(simd, h), unpack(simd, hu), unpack(simd, hv)]
}

#[inline(always)]
fn unpack<S: Simd>(simd: S, v: S::F64) -> DVec4 {
    DVec4::from_array(simd.store64(v))
}

/// A point of a patch with its first derivatives by the parameters of the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchJet {
    pub(super) s: DVec3,
    pub(super) su: DVec3,
    pub(super) sv: DVec3,
}

impl PatchJet {
    /// The jet of the homogeneous net `points`, that of (i, j) at i (q + 1) + j, with the instructions of `isa`.
    pub(super) fn new(isa: Isa, points: &[DVec4], degrees: (usize, usize), u: f64, v: f64) -> Self {
        isa.run(FirstOrderEvaluation { points, degrees, u, v })
    }

    #[inline(always)]
    fn of([h, hu, hv]: [DVec4; 3]) -> Self {
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let [su, sv] = [hu, hv].map(|rise| (rise.truncate() - s * rise.w) * per);
        Self { s, su, sv }
    }
}

struct FirstOrderEvaluation<'a> {
    points: &'a [DVec4],
    degrees: (usize, usize),
    u: f64,
    v: f64,
}

impl Task for FirstOrderEvaluation<'_> {
    type Output = PatchJet;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> PatchJet {
        PatchJet::of(first_order::<S, true>(simd, self.points, self.degrees, self.u, self.v))
    }
}

/// Point and derivatives up to the second of the homogeneous net `points`, that of (i, j) at i (q + 1) + j.
pub(super) fn second_order_jet(points: &[DVec4], degrees: (usize, usize), u: f64, v: f64) -> SecondOrderJet {
    Isa::detect().run(JetEvaluation { points, degrees, u, v })
}

struct JetEvaluation<'a> {
    points: &'a [DVec4],
    degrees: (usize, usize),
    u: f64,
    v: f64,
}

impl Task for JetEvaluation<'_> {
    type Output = SecondOrderJet;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> SecondOrderJet {
        if let ((3, 3), [a, b, c, d]) = (self.degrees, self.points.as_chunks::<4>().0) {
            // The most frequent degrees, with loops of a fixed length.
            let rows = [a, b, c, d].into_iter().map(|row| row.as_slice());
            return second_order(simd, rows, cubics(self.u), cubics(self.v));
        }
        with_room!(self.degrees.0.max(self.degrees.1), N => self.run_in::<S, N>(simd))
    }
}

impl JetEvaluation<'_> {
    #[inline(always)]
    fn run_in<S: Simd, const N: usize>(self, simd: S) -> SecondOrderJet {
        let (p, q) = self.degrees;
        let (by_u, by_v) = (BernsteinPowers::<N>::new(p, self.u), BernsteinPowers::<N>::new(q, self.v));
        let by_u = [by_u.values(), by_u.first_derivatives(), by_u.second_derivatives()];
        let by_v = [by_v.values(), by_v.first_derivatives(), by_v.second_derivatives()];
        second_order(simd, self.points.chunks_exact(q + 1), by_u, by_v)
    }
}

/// The sums of the rows of a net, weighted by values, first and second derivatives of the bases.
#[inline(always)]
fn second_order<'a, S: Simd, const N: usize>(
    simd: S,
    rows: impl Iterator<Item = &'a [DVec4]>,
    [bu, du, ddu]: [[f64; N]; 3],
    [bv, dv, ddv]: [[f64; N]; 3],
) -> SecondOrderJet {
    let zero = simd.splat64(0.0);
    let (mut h, mut hu, mut hv) = (zero, zero, zero);
    let (mut huu, mut huv, mut hvv) = (zero, zero, zero);
    for (((row, bu), du), ddu) in rows.zip(bu).zip(du).zip(ddu) {
        let (mut along, mut rise, mut second) = (zero, zero, zero);
        for (((point, bv), dv), ddv) in row.iter().zip(bv).zip(dv).zip(ddv) {
            let point = simd.load64(&point.to_array());
            along = simd.mul_add64(point, simd.splat64(bv), along);
            rise = simd.mul_add64(point, simd.splat64(dv), rise);
            second = simd.mul_add64(point, simd.splat64(ddv), second);
        }
        let (bu, du, ddu) = (simd.splat64(bu), simd.splat64(du), simd.splat64(ddu));
        h = simd.mul_add64(along, bu, h);
        hu = simd.mul_add64(along, du, hu);
        huu = simd.mul_add64(along, ddu, huu);
        hv = simd.mul_add64(rise, bu, hv);
        huv = simd.mul_add64(rise, du, huv);
        hvv = simd.mul_add64(second, bu, hvv);
    }
    let (h, hu, hv) = (unpack(simd, h), unpack(simd, hu), unpack(simd, hv));
    SecondOrderJet::of(h, [hu, hv], [unpack(simd, huu), unpack(simd, huv), unpack(simd, hvv)])
}

/// Cubic Bernstein polynomials, their first and second derivatives.
#[inline(always)]
fn cubics(x: f64) -> [[f64; 4]; 3] {
    let y = 1.0 - x;
    let (xx, xy, yy) = (x * x, x * y, y * y);
    [
        [yy * y, 3.0 * (yy * x), 3.0 * (y * xx), xx * x],
        [-3.0 * yy, 3.0 * (yy - 2.0 * xy), 3.0 * (2.0 * xy - xx), 3.0 * xx],
        [6.0 * y, 6.0 * (x - 2.0 * y), 6.0 * (y - 2.0 * x), 6.0 * x],
    ]
}

impl SecondOrderJet {
    #[inline(always)]
    fn of(h: DVec4, [hu, hv]: [DVec4; 2], [huu, huv, hvv]: [DVec4; 3]) -> Self {
        // Quotient rule, order by order (@markgraf2019 eq. 14).
        let PatchJet { s, su, sv } = PatchJet::of([h, hu, hv]);
        let per = 1.0 / h.w;
        Self {
            s,
            su,
            sv,
            suu: (huu.truncate() - su * (2.0 * hu.w) - s * huu.w) * per,
            suv: (huv.truncate() - su * hv.w - sv * hu.w - s * huv.w) * per,
            svv: (hvv.truncate() - sv * (2.0 * hv.w) - s * hvv.w) * per,
        }
    }
}

/// Halves of the net `points` of (p + 1) (q + 1) coefficients, across the first direction or the second.
pub(super) fn split<T>(points: &[T], (p, q): (usize, usize), across_first: bool) -> [Vec<T>; 2]
where
    T: BernsteinCoefficient,
{
    let (mut low, mut high) = (points.to_vec(), points.to_vec());
    let (rows, length) = if across_first { (q + 1, p + 1) } else { (p + 1, q + 1) };
    let at = |row: usize, k: usize| if across_first { k * (q + 1) + row } else { row * (q + 1) + k };
    let (mut below, mut above) = (points[..length].to_vec(), points[..length].to_vec());
    for row in 0..rows {
        for (k, slot) in below.iter_mut().enumerate() {
            *slot = points[at(row, k)];
        }
        halve(&mut below, &mut above);
        for k in 0..length {
            low[at(row, k)] = below[k];
            high[at(row, k)] = above[k];
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bernstein_derivatives_are_differences_in_rows_of_every_room() {
        fn rows<const N: usize>(degree: usize, x: f64) -> [[f64; N]; 3] {
            let b = BernsteinPowers::<N>::new(degree, x);
            [b.values(), b.first_derivatives(), b.second_derivatives()]
        }
        fn check<const N: usize>(degree: usize) {
            for x in [0.0, 0.3, 0.5, 0.9, 1.0] {
                let [value, first, second] = rows::<N>(degree, x);
                assert!((value.iter().sum::<f64>() - 1.0).abs() < 1e-13);
                let h = 1e-5;
                let (up, down) = (rows::<N>(degree, x + h), rows::<N>(degree, x - h));
                let scale = (degree * degree) as f64;
                for i in 0..=degree {
                    let [rise, second_difference] = [0, 1].map(|k| (up[k][i] - down[k][i]) / (2.0 * h));
                    assert!((first[i] - rise).abs() < 1e-8 * scale * scale);
                    assert!((second[i] - second_difference).abs() < 1e-8 * scale * scale * scale);
                }
            }
        }
        for degree in 1..=MAX_DEGREE {
            with_room!(degree, N => check::<N>(degree));
        }
    }
}
