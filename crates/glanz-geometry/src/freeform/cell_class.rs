//! What the coefficients of a cell say about its roots.

use glanz_math::DVec2;

use super::contraction::Certificate;
use super::ray_space::cross;
use crate::bvh::simd::lanes::{LANES, first_lanes};
use crate::bvh::simd::{Simd, Task};

/// Largest contraction at which a cell is certified.
const CERTIFIED: f64 = 0.75;

/// Largest shift by rounding of the root of a certified cell, as a fraction of half the cell.
const MOST_UNCERTAINTY: f64 = 0.0625;

/// Result of a test of a cell for roots.
pub(super) enum CellClass {
    /// No root.
    Excluded,
    /// One at most.
    Certified(Certificate),
    /// All coefficients are zero to within rounding, or those across the only direction of the projection.
    Flat,
    /// Unknown; with the means of the derivatives.
    Open { across_x: bool, slopes: [DVec2; 2] },
}

/// The test of a cell with the Bernstein coefficients `lists` of both distances, that of (i, j) at j (p + 1) + i, for `degrees` (p, q).
pub(super) struct CellTest<'a> {
    pub(super) lists: [&'a [f64]; 2],
    pub(super) degrees: (usize, usize),
    /// Bound on the rounding of the coefficients.
    pub(super) noise: f64,
}

/// Smallest and largest of some numbers, lane by lane; NaN is ignored.
struct Range<S: Simd> {
    low: S::Wide,
    high: S::Wide,
}

impl<S: Simd> Range<S> {
    #[inline(always)]
    fn empty(simd: S) -> Self {
        Self { low: simd.splat8(f64::INFINITY), high: simd.splat8(f64::NEG_INFINITY) }
    }

    #[inline(always)]
    fn include(&mut self, simd: S, value: S::Wide) {
        (self.low, self.high) = (simd.min8(value, self.low), simd.max8(value, self.high));
    }

    /// That of all lanes.
    #[inline(always)]
    fn ends(&self, simd: S) -> (f64, f64) {
        let low = simd.store8(self.low).into_iter().fold(f64::INFINITY, f64::min);
        (low, largest(simd, self.high))
    }
}

#[inline(always)]
fn largest<S: Simd>(simd: S, lanes: S::Wide) -> f64 {
    simd.store8(lanes).into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Eight numbers of `list` from `start` on; behind its end the last one is repeated.
#[inline(always)]
fn eight<S: Simd>(simd: S, list: &[f64], start: usize) -> S::Wide {
    let rest = list.get(start..).unwrap_or(&[]);
    if let Some(lanes) = rest.first_chunk::<LANES>() {
        return simd.load8(lanes);
    }
    let mut lanes = [list.last().copied().unwrap_or(0.0); LANES];
    for (lane, x) in lanes.iter_mut().zip(rest) {
        *lane = *x;
    }
    simd.load8(&lanes)
}

/// Differences between eight numbers of `list` from `start` on and those `step` behind them, times `factor`.
#[inline(always)]
fn differences<S: Simd>(simd: S, list: &[f64], start: usize, step: usize, factor: S::Wide) -> S::Wide {
    simd.mul8(simd.sub8(eight(simd, list, start + step), eight(simd, list, start)), factor)
}

/// The z component of the cross product of (x, y) with `b`.
#[inline(always)]
fn cross8<S: Simd>(simd: S, x: S::Wide, y: S::Wide, b: DVec2) -> S::Wide {
    simd.sub8(simd.mul8(x, simd.splat8(b.y)), simd.mul8(y, simd.splat8(b.x)))
}

impl Task for CellTest<'_> {
    type Output = CellClass;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> CellClass {
        let Self { lists: [first, second], degrees: (p, q), noise } = self;
        let n = first.len();
        let one_sided = |(low, high): (f64, f64), noise: f64| low > noise || high < -noise;
        let (mut range1, mut range2) = (Range::empty(simd), Range::empty(simd));
        for k in (0..n).step_by(LANES) {
            range1.include(simd, eight(simd, first, k));
            range2.include(simd, eight(simd, second, k));
        }
        let (range1, range2) = (range1.ends(simd), range2.ends(simd));
        if one_sided(range1, noise) || one_sided(range2, noise) {
            return CellClass::Excluded;
        }
        let at = |i: usize, j: usize| DVec2::new(first[j * (p + 1) + i], second[j * (p + 1) + i]);
        // The mean of the derivatives; the sums telescope.
        let a = (0..=q).map(|j| at(p, j) - at(0, j)).sum::<DVec2>() / (q + 1) as f64;
        let b = (0..=p).map(|i| at(i, q) - at(i, 0)).sum::<DVec2>() / (p + 1) as f64;
        // Combinations in which one of the derivatives drops out: where both are parallel, the curvature remains.
        let (a_length, b_length) = (a.length(), b.length());
        let (mut across_a, mut across_b) = (Range::empty(simd), Range::empty(simd));
        for k in (0..n).step_by(LANES) {
            let (x, y) = (eight(simd, first, k), eight(simd, second, k));
            across_a.include(simd, cross8(simd, x, y, -a));
            across_b.include(simd, cross8(simd, x, y, b));
        }
        let (across_a, across_b) = (across_a.ends(simd), across_b.ends(simd));
        if one_sided(across_b, 1.5 * noise * b_length) || one_sided(across_a, 1.5 * noise * a_length) {
            return CellClass::Excluded;
        }
        if is_one_sided(first, second, noise) {
            return CellClass::Excluded;
        }
        let spread = (range1.1 - range1.0).max(range2.1 - range2.0);
        let narrow = |(low, high): (f64, f64), noise: f64| low >= -noise && high <= noise;
        let seen = a_length.max(b_length);
        if spread <= 2.0 * noise
            || (seen >= 0.25 * spread
                && narrow(across_b, 2.0 * noise * b_length)
                && narrow(across_a, 2.0 * noise * a_length))
        {
            return CellClass::Flat;
        }
        let det = cross(a, b);
        // Largest entries of J0^-1 J - I over the cell, bounded by the coefficients of the derivatives.
        let by_x = self.derivatives(simd, true, a, [a, b]);
        let by_y = self.derivatives(simd, false, b, [a, b]);
        let deviation = (by_x.across[1] + by_y.across[1]).max(by_x.across[0] + by_y.across[0]);
        // If rounding may move the root by more than a part of the cell, it is next to a tangency: smaller cells are flat.
        let clear = noise * seen <= MOST_UNCERTAINTY * det.abs();
        if clear && deviation < CERTIFIED * det.abs() {
            // By (s, t), whose interval is twice as long.
            return CellClass::Certified(Certificate { a: 0.5 * a, b: 0.5 * b, q: deviation / det.abs() });
        }
        // Along the direction in which the coefficients vary more, so that projected cells become as wide as long.
        CellClass::Open { across_x: by_x.rise >= by_y.rise, slopes: [a, b] }
    }
}

/// Bounds on a derivative over a cell.
struct SlopeBounds {
    /// Square of its length.
    rise: f64,
    /// Its deviations from the mean, across both mean derivatives and times their lengths.
    across: [f64; 2],
}

impl CellTest<'_> {
    /// Bounds on the derivative by x, or by y, whose mean is `mean`; by the means of both.
    #[inline(always)]
    fn derivatives<S: Simd>(&self, simd: S, by_x: bool, mean: DVec2, [a, b]: [DVec2; 2]) -> SlopeBounds {
        let Self { lists: [first, second], degrees: (p, q), .. } = *self;
        let (degree, step) = if by_x { (p, 1) } else { (q, p + 1) };
        let factor = simd.splat8(degree as f64);
        let means = [simd.splat8(mean.x), simd.splat8(mean.y)];
        // Bit i: coefficient i of the rows is not the last one of its row.
        let mut inner = u64::MAX;
        if by_x {
            (p..u64::BITS as usize).step_by(p + 1).for_each(|last| inner &= !(1 << last));
        }
        let (zero, mut column) = (simd.splat8(0.0), 0);
        let (mut rise, mut across) = (zero, [zero; 2]);
        let count = if degree == 0 { 0 } else { first.len() - step };
        for k in (0..count).step_by(LANES) {
            let mask = first_lanes(count - k) & (inner >> column) as u32;
            column = (column + LANES) % (p + 1);
            // The mean is within all bounds.
            let x = simd.select8(mask, differences(simd, first, k, step, factor), means[0]);
            let y = simd.select8(mask, differences(simd, second, k, step, factor), means[1]);
            rise = simd.max8(simd.add8(simd.mul8(x, x), simd.mul8(y, y)), rise);
            let (x, y) = (simd.sub8(x, means[0]), simd.sub8(y, means[1]));
            across[0] = simd.max8(simd.abs8(cross8(simd, x, y, a)), across[0]);
            across[1] = simd.max8(simd.abs8(cross8(simd, x, y, b)), across[1]);
        }
        let across = [largest(simd, across[0]), largest(simd, across[1])];
        SlopeBounds { rise: largest(simd, rise), across }
    }
}

/// Whether all coefficients lie on one side of a line at a distance of more than the noise from 0: that across the bisector of the
/// outermost directions, if they enclose less than half a turn.
#[inline(always)]
fn is_one_sided(first: &[f64], second: &[f64], noise: f64) -> bool {
    let mut points = first.iter().zip(second).map(|(&x, &y)| DVec2::new(x, y));
    let Some(start) = points.next() else { return false };
    let (mut right, mut left) = (start, start);
    for point in points {
        let (beyond_right, beyond_left) = (cross(right, point) < 0.0, cross(left, point) > 0.0);
        if beyond_right && beyond_left {
            return false;
        }
        if beyond_right {
            right = point;
        } else if beyond_left {
            left = point;
        }
        if cross(right, left) < 0.0 {
            return false;
        }
    }
    let across = right.normalize_or_zero() + left.normalize_or_zero();
    // The noise bounds each of the coordinates.
    let limit = 1.5 * noise * across.length();
    limit > 0.0 && first.iter().zip(second).all(|(x, y)| across.x * x + across.y * y > limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::simd::Isa;

    /// The class of a cell, its numbers as bits.
    fn bits(class: &CellClass) -> (&'static str, Vec<u64>) {
        let of = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect();
        match class {
            CellClass::Excluded => ("excluded", Vec::new()),
            CellClass::Certified(Certificate { a, b, q }) => ("certified", of(&[a.x, a.y, b.x, b.y, *q])),
            CellClass::Flat => ("flat", Vec::new()),
            CellClass::Open { across_x, slopes: [a, b] } => {
                (if *across_x { "across x" } else { "across y" }, of(&[a.x, a.y, b.x, b.y]))
            }
        }
    }

    /// Squares of the largest derivatives by x and by y, and the largest deviation from their means, coefficient after coefficient.
    fn slow(test: &CellTest<'_>, [a, b]: [DVec2; 2]) -> ([f64; 2], f64) {
        let (p, q) = test.degrees;
        let at =
            |i: usize, j: usize| DVec2::new(test.lists[0][j * (p + 1) + i], test.lists[1][j * (p + 1) + i]);
        let (mut rises, mut across) = ([0.0_f64; 2], [[0.0_f64; 2]; 2]);
        let mut meet = |k: usize, derivative: DVec2, mean: DVec2| {
            rises[k] = rises[k].max(derivative.length_squared());
            let off = derivative - mean;
            across[k] = [across[k][0].max(cross(off, a).abs()), across[k][1].max(cross(off, b).abs())];
        };
        for (i, j) in (0..=q).flat_map(|j| (0..=p).map(move |i| (i, j))) {
            if i < p {
                meet(0, (at(i + 1, j) - at(i, j)) * p as f64, a);
            }
            if j < q {
                meet(1, (at(i, j + 1) - at(i, j)) * q as f64, b);
            }
        }
        (rises, (across[0][1] + across[1][1]).max(across[0][0] + across[1][0]))
    }

    #[test]
    fn cells_of_all_degrees_have_the_bounds_of_their_coefficients_with_all_instructions() {
        let mut seen = std::collections::BTreeMap::<_, usize>::new();
        for (p, q) in (0..=25).flat_map(|p| [0, 1, 2, 3, 7, 8, 25].map(|q| (p, q))) {
            for bend in [0.02, 0.5, 4.0] {
                let list = |turn: f64| -> Vec<f64> {
                    let entry = |k: usize| {
                        let (x, y) =
                            ((k % (p + 1)) as f64 / p.max(1) as f64, (k / (p + 1)) as f64 / q.max(1) as f64);
                        let bent = bend * (2.3 * k as f64 + turn).sin() / p.max(q).max(1) as f64;
                        turn.cos() * (x - 0.4) + turn.sin() * (y - 0.6) + bent
                    };
                    (0..(p + 1) * (q + 1)).map(entry).collect()
                };
                let (first, second) = (list(0.3), list(1.7));
                let test = CellTest { lists: [&first, &second], degrees: (p, q), noise: 1e-14 };
                let class = Isa::all()[0].run(test);
                for isa in Isa::all() {
                    let test = CellTest { lists: [&first, &second], degrees: (p, q), noise: 1e-14 };
                    assert_eq!(bits(&isa.run(test)), bits(&class), "{isa:?} {p} {q}");
                }
                let test = CellTest { lists: [&first, &second], degrees: (p, q), noise: 1e-14 };
                match class {
                    CellClass::Open { across_x, slopes } => {
                        let (rises, deviation) = slow(&test, slopes);
                        assert_eq!(across_x, rises[0] >= rises[1], "{p} {q} {rises:?}");
                        assert!(deviation >= CERTIFIED * cross(slopes[0], slopes[1]).abs());
                    }
                    CellClass::Certified(Certificate { a, b, q: found }) => {
                        let slopes = [2.0 * a, 2.0 * b];
                        let expected = slow(&test, slopes).1 / cross(slopes[0], slopes[1]).abs();
                        assert_eq!(found.to_bits(), expected.to_bits(), "{p} {q}");
                    }
                    _ => {}
                }
                *seen.entry(bits(&class).0).or_default() += 1;
            }
        }
        assert!(
            ["certified", "across x", "across y", "excluded"].iter().all(|class| seen[class] > 20),
            "{seen:?}"
        );
    }
}
