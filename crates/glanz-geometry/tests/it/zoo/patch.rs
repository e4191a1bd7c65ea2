//! Rational patches by their control points, for the reference.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::interval::Interval;

/// Extension of the parameters beyond [0, 1], so that roots next to a border are isolated on both sides of it.
pub const EXTENSION: f64 = 1.0 / (1 << 26) as f64;

/// Largest number of coefficients in a row.
const MAX_ROW: usize = 26;

/// A rational tensor patch.
#[derive(Clone, Debug)]
pub struct ReferencePatch {
    pub degrees: (usize, usize),
    pub points: Vec<DVec4>,
    /// Coefficients x, y, z, w over [-`EXTENSION`, 1 + `EXTENSION`]^2, that of (i, j) at i (q + 1) + j.
    pub net: Vec<[Interval; 4]>,
    /// Centre and radius of a ball around the control points.
    pub center: DVec3,
    pub radius: f64,
}

/// The rows of a net along a parameter: their count and length, the distances between rows and between coefficients.
pub struct NetRows {
    pub count: usize,
    pub length: usize,
    pub stride: usize,
    pub step: usize,
}

impl NetRows {
    pub fn along((p, q): (usize, usize), u: bool) -> Self {
        if u {
            Self { count: q + 1, length: p + 1, stride: 1, step: q + 1 }
        } else {
            Self { count: p + 1, length: q + 1, stride: q + 1, step: 1 }
        }
    }

    /// Applies `change` to every row of `net`.
    pub fn map(&self, net: &mut [Interval], mut change: impl FnMut(&mut [Interval])) {
        let mut row = [Interval::ONE; MAX_ROW];
        for line in 0..self.count {
            let at = |k: usize| line * self.stride + k * self.step;
            for k in 0..self.length {
                row[k] = net[at(k)];
            }
            change(&mut row[..self.length]);
            for k in 0..self.length {
                net[at(k)] = row[k];
            }
        }
    }
}

/// Replaces coefficients over [0, 1] by those over [a, b]: the blossom at k times b and n - k times a, by de Casteljau's
/// scheme.
pub fn restrict(row: &mut [Interval], a: f64, b: f64) {
    let n = row.len() - 1;
    let (a, b) = (Interval::of(a), Interval::of(b));
    let mut out = [Interval::ONE; MAX_ROW];
    for (k, out) in out.iter_mut().enumerate().take(n + 1) {
        let mut work = [Interval::ONE; MAX_ROW];
        work[..=n].copy_from_slice(row);
        for level in 0..n {
            let t = if level < k { b } else { a };
            for i in 0..n - level {
                work[i] = work[i].blend(work[i + 1], t);
            }
        }
        *out = work[0];
    }
    row.copy_from_slice(&out[..=n]);
}

/// The value of a row at `t`; overwrites the row.
pub fn value(row: &mut [Interval], t: Interval) -> Interval {
    for last in (1..row.len()).rev() {
        for i in 0..last {
            row[i] = row[i].blend(row[i + 1], t);
        }
    }
    row[0]
}

/// The value of a net at (u, v), by de Casteljau's scheme along v and then along u.
pub fn value_at(net: &[Interval], (p, q): (usize, usize), u: Interval, v: Interval) -> Interval {
    let mut across = [Interval::ONE; MAX_ROW];
    for (across, row) in across.iter_mut().zip(net.chunks_exact(q + 1)) {
        let mut work = [Interval::ONE; MAX_ROW];
        work[..=q].copy_from_slice(row);
        *across = value(&mut work[..=q], v);
    }
    value(&mut across[..=p], u)
}

/// Bernstein polynomials of degree n at x, and their derivatives.
pub fn bernstein(n: usize, x: f64) -> [[f64; MAX_ROW]; 2] {
    let mut row = [0.0; MAX_ROW];
    row[0] = 1.0;
    let mut before = row;
    for d in 1..=n {
        before = row;
        for i in 0..=d {
            row[i] = (1.0 - x) * before[i] + if i > 0 { x * before[i - 1] } else { 0.0 };
        }
    }
    let mut rise = [0.0; MAX_ROW];
    for i in 0..=n {
        let (left, right) = (if i > 0 { before[i - 1] } else { 0.0 }, if i < n { before[i] } else { 0.0 });
        rise[i] = n as f64 * (left - right);
    }
    [row, rise]
}

impl ReferencePatch {
    pub fn new(degrees: (usize, usize), points: Vec<DVec4>) -> Self {
        let spatial = || points.iter().map(|p| p.truncate() / p.w);
        let low = spatial().fold(DVec3::INFINITY, DVec3::min);
        let high = spatial().fold(DVec3::NEG_INFINITY, DVec3::max);
        let center = 0.5 * (low + high);
        let radius = spatial().map(|p| p.distance(center)).fold(0.0, f64::max);
        let polynomial = points.iter().all(|p| p.w == 1.0);
        let mut lists: [Vec<Interval>; 4] =
            [0, 1, 2, 3].map(|k| points.iter().map(|p| Interval::of(p[k])).collect());
        for list in &mut lists {
            for u in [true, false] {
                NetRows::along(degrees, u).map(list, |row| restrict(row, -EXTENSION, 1.0 + EXTENSION));
            }
        }
        let net = (0..points.len()).map(|k| {
            let [x, y, z, w] = [0, 1, 2, 3].map(|c: usize| lists[c][k]);
            [x, y, z, if polynomial { Interval::ONE } else { w }]
        });
        Self { net: net.collect(), degrees, points, center, radius }
    }

    /// Point and first derivatives by u and v. The derivatives are those of the net about the point, so that nothing cancels.
    pub fn tangent(&self, u: f64, v: f64) -> [DVec3; 3] {
        let (p, q) = self.degrees;
        let ([bu, du], [bv, dv]) = (bernstein(p, u), bernstein(q, v));
        let sum = |a: &[f64], b: &[f64], about: DVec3| {
            self.points.iter().enumerate().fold(DVec4::ZERO, |sum, (k, point)| {
                let moved = (point.truncate() - about * point.w).extend(point.w);
                sum + moved * (a[k / (q + 1)] * b[k % (q + 1)])
            })
        };
        let first = sum(&bu, &bv, self.center);
        let s = self.center + first.truncate() / first.w;
        let [su, sv] = [sum(&du, &bv, s), sum(&bu, &dv, s)].map(|d| d.truncate() / first.w);
        [s, su, sv]
    }
}
