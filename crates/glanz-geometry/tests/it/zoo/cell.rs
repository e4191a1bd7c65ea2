//! Rectangles of a patch's parameters with the coefficients of both equations over them.

use super::interval::Interval;
use super::patch::{NetRows, bernstein, restrict, value_at};

/// Margin of a certified box around its cell, in widths of the cell.
const MARGIN: f64 = 0.125;

/// Smallest width that is halved: the ends of narrower cells do not fit in 52 bits.
const NARROWEST: f64 = 1.0 / (1_u64 << 46) as f64;

/// Ratio of the range of the coefficients to their uncertainty below which a cell is hidden.
const HIDDEN: f64 = 6.0;

pub struct PatchCell {
    from: [f64; 2],
    width: [f64; 2],
    /// First equation, then second.
    pub coefficients: Vec<Interval>,
    /// Whether u varies more; of a cell that was examined.
    across_u: bool,
}

/// Result of [`PatchCell::examine`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchCellClass {
    /// No root.
    Excluded,
    /// The map is probably injective over the cell, by the middles of its coefficients; a proof is tried.
    Injective,
    /// The coefficients are too uncertain: smaller cells would not decide either.
    Hidden,
    Open,
}

/// Result of [`PatchCell::certify`].
pub enum CellProof {
    /// No root.
    Nothing,
    /// Exactly one root, in this box of the parameters of the patch.
    Root([Interval; 2]),
    Unknown,
}

/// `x1 y2 - x2 y1`, where y is exact.
fn cross(x: [Interval; 2], y: [f64; 2]) -> Interval {
    x[0] * y[1] - x[1] * y[0]
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

fn determinant(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn one_sided(x: Interval) -> bool {
    x.low > 0.0 || x.high < 0.0
}

/// Bounds on I - J0^-1 J over a net, J0 = (a, b): the largest sum of a row.
fn jacobian_deviation(net: &[Interval], (p, q): (usize, usize), a: [f64; 2], b: [f64; 2]) -> f64 {
    let (first, second) = net.split_at(net.len() / 2);
    let at = |i: usize, j: usize| [first[i * (q + 1) + j], second[i * (q + 1) + j]];
    let rise = |x: [Interval; 2], y: [Interval; 2], n: usize, mean: [f64; 2]| {
        [0, 1].map(|k| (y[k] - x[k]) * n as f64 - Interval::of(mean[k]))
    };
    let mut most = [0.0_f64; 4];
    for i in 0..=p {
        for j in 0..=q {
            if i < p {
                let d = rise(at(i, j), at(i + 1, j), p, a);
                most[0] = most[0].max(cross(d, b).magnitude());
                most[1] = most[1].max(cross(d, a).magnitude());
            }
            if j < q {
                let d = rise(at(i, j), at(i, j + 1), q, b);
                most[2] = most[2].max(cross(d, b).magnitude());
                most[3] = most[3].max(cross(d, a).magnitude());
            }
        }
    }
    // The determinant is rounded, a few units of the products that it is made of.
    let det = determinant(a, b).abs() - 4.0 * f64::EPSILON * length(a) * length(b);
    if det > 0.0 { (most[0] + most[2]).max(most[1] + most[3]) / det * (1.0 + 1e-12) } else { f64::INFINITY }
}

/// Approximate means of the derivatives by u and v.
fn slopes(net: &[Interval], (p, q): (usize, usize)) -> [[f64; 2]; 2] {
    let half = net.len() / 2;
    let at = |list: usize, i: usize, j: usize| net[list * half + i * (q + 1) + j].middle();
    let by_u = [0, 1].map(|l| (0..=q).map(|j| at(l, p, j) - at(l, 0, j)).sum::<f64>() / (q + 1) as f64);
    let by_v = [0, 1].map(|l| (0..=p).map(|i| at(l, i, q) - at(l, i, 0)).sum::<f64>() / (p + 1) as f64);
    [by_u, by_v]
}

impl PatchCell {
    /// The cell of a whole patch.
    pub fn whole(coefficients: Vec<Interval>) -> Self {
        Self { from: [0.0; 2], width: [1.0; 2], coefficients, across_u: true }
    }

    /// The box of the cell in the parameters of the patch.
    pub fn sides(&self) -> [Interval; 2] {
        [0, 1].map(|k| Interval { low: self.from[k], high: self.from[k] + self.width[k] })
    }

    /// Classifies the cell: it has no root if a linear combination of both equations has one sign over it.
    pub fn examine(&mut self, degrees: (usize, usize)) -> PatchCellClass {
        let (first, second) = self.coefficients.split_at(self.coefficients.len() / 2);
        let hull = |list: &[Interval]| list.iter().fold(list[0], |hull, &x| hull.hull(x));
        let ranges = [hull(first), hull(second)];
        if ranges.iter().any(|&range| one_sided(range)) {
            return PatchCellClass::Excluded;
        }
        let [a, b] = slopes(&self.coefficients, degrees);
        let across = |d: [f64; 2]| {
            let all = first.iter().zip(second).map(|(&x, &y)| cross([x, y], d));
            all.reduce(Interval::hull).unwrap_or(Interval::ONE)
        };
        // Across a the derivative by u vanishes; across the mean value, cells on one side of 0 are excluded.
        let sum = |list: &[Interval]| list.iter().map(|x| x.middle()).sum::<f64>();
        let (across_a, across_b) = (across(a), across(b));
        if one_sided(across_a) || one_sided(across_b) || one_sided(across([-sum(second), sum(first)])) {
            return PatchCellClass::Excluded;
        }
        let unsure = self.coefficients.iter().map(|x| x.width()).fold(0.0, f64::max);
        let seen = ranges[0].width().max(ranges[1].width());
        let hidden = |range: Interval, d: [f64; 2]| {
            length(d) > 0.25 * seen && range.width() <= HIDDEN * unsure * length(d)
        };
        let tiny = self.width.iter().all(|&w| w < NARROWEST);
        if seen <= HIDDEN * unsure || hidden(across_a, a) || hidden(across_b, b) || tiny {
            return PatchCellClass::Hidden;
        }
        if jacobian_deviation(&self.coefficients, degrees, a, b) < 0.6 {
            return PatchCellClass::Injective;
        }
        self.across_u = self.varies_by_u(degrees);
        PatchCellClass::Open
    }

    fn varies_by_u(&self, degrees: (usize, usize)) -> bool {
        let half = self.coefficients.len() / 2;
        let largest = |u: bool| {
            let NetRows { count, length, stride, step } = NetRows::along(degrees, u);
            let mut most = 0.0_f64;
            for line in 0..2 * count {
                let start = line / count * half + line % count * stride;
                for k in 1..length {
                    let at = |k: usize| self.coefficients[start + k * step].middle();
                    most = most.max((at(k) - at(k - 1)).abs());
                }
            }
            most * (length - 1) as f64
        };
        let wide = |k: usize| self.width[k] > NARROWEST;
        wide(0) && (largest(true) >= largest(false) || !wide(1))
    }

    /// Halves the cell, which becomes the lower half; returns the upper one in the memory of `high`.
    pub fn split(&mut self, degrees: (usize, usize), mut high: Vec<Interval>) -> Self {
        high.clear();
        high.extend_from_slice(&self.coefficients);
        let NetRows { count, length, stride, step } = NetRows::along(degrees, self.across_u);
        let half = self.coefficients.len() / 2;
        for line in 0..2 * count {
            let start = line / count * half + line % count * stride;
            let low = &mut self.coefficients;
            for k in 0..length {
                high[start + (length - 1 - k) * step] = low[start + (length - 1) * step];
                for i in (k + 1..length).rev() {
                    let at = start + i * step;
                    low[at] = low[at - step].mean(low[at]);
                }
            }
        }
        let side = usize::from(!self.across_u);
        self.width[side] *= 0.5;
        let mut upper = Self { coefficients: high, ..*self };
        upper.from[side] += self.width[side];
        upper
    }

    /// Proof that a box around the cell has one root, or that the cell has none.
    ///
    /// With q the bound of [`jacobian_deviation`] over the box, all roots x in it keep |x - z| <= |J0^-1 f(z)| / (1 - q) for any z there;
    /// and if all of that ball lies in the box, the step x - J0^-1 f(x) maps it into itself: there is one.
    pub fn certify(&self, degrees: (usize, usize)) -> CellProof {
        let mut net = self.coefficients.clone();
        let half = net.len() / 2;
        for list in [0..half, half..2 * half] {
            for u in [true, false] {
                NetRows::along(degrees, u)
                    .map(&mut net[list.clone()], |row| restrict(row, -MARGIN, 1.0 + MARGIN));
            }
        }
        let [a, b] = slopes(&net, degrees);
        let q = jacobian_deviation(&net, degrees, a, b);
        if q >= 0.9 {
            return CellProof::Unknown;
        }
        // From here on in the parameters of the box.
        let z = newton(&net, degrees, [a, b]);
        let [u, v] = z.map(Interval::of);
        let f = [&net[..half], &net[half..]].map(|list| value_at(list, degrees, u, v));
        let det = determinant(a, b).abs() - 4.0 * f64::EPSILON * length(a) * length(b);
        let step = cross(f, b).magnitude().max(cross(f, a).magnitude()) / det;
        let radius = step / (1.0 - q) * (1.0 + 1e-12);
        let sides = z.map(|z| Interval::of(z).widened(radius));
        // The cell within the box; rounding must not open a gap between neighbours.
        let inner = MARGIN / (1.0 + 2.0 * MARGIN) * (1.0 - 1e-9);
        if sides.iter().any(|side| side.high < inner || side.low > 1.0 - inner) {
            return CellProof::Nothing;
        }
        if sides.iter().any(|side| side.low <= 0.0 || side.high >= 1.0) {
            return CellProof::Unknown;
        }
        CellProof::Root([0, 1].map(|k| {
            let own = sides[k] * (1.0 + 2.0 * MARGIN) - Interval::of(MARGIN);
            own * self.width[k] + Interval::of(self.from[k])
        }))
    }
}

/// An approximation of the root, without a guarantee.
fn newton(net: &[Interval], (p, q): (usize, usize), slopes: [[f64; 2]; 2]) -> [f64; 2] {
    let half = net.len() / 2;
    let mut z = [0.5; 2];
    for _ in 0..8 {
        let ([bu, du], [bv, dv]) = (bernstein(p, z[0]), bernstein(q, z[1]));
        let mut sums = [[0.0; 2]; 3];
        for (list, part) in net.chunks_exact(half).enumerate() {
            for (k, x) in part.iter().enumerate() {
                let (i, j) = (k / (q + 1), k % (q + 1));
                let x = x.middle();
                sums[0][list] += x * bu[i] * bv[j];
                sums[1][list] += x * du[i] * bv[j];
                sums[2][list] += x * bu[i] * dv[j];
            }
        }
        let [f, mut a, mut b] = sums;
        if determinant(a, b).abs() < 0.1 * determinant(slopes[0], slopes[1]).abs() {
            [a, b] = slopes;
        }
        let det = determinant(a, b);
        let step = [determinant(f, b) / det, determinant(a, f) / det];
        let next = [0, 1].map(|k| (z[k] - step[k]).clamp(0.0, 1.0));
        let moved = (next[0] - z[0]).abs().max((next[1] - z[1]).abs());
        z = next;
        if moved < 1e-15 {
            break;
        }
    }
    z
}
