//! Lower degrees of the coefficients of small cells.
//!
//! Halving a polynomial of degree n divides its part of order k by 2^k: small cells of high degree are cubics to within rounding, which
//! take a tenth of the work. The polynomial of degree m through m + 1 points of a row, the ends among them, is raised to the old degree
//! again; the largest difference of a coefficient bounds the error.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::control_net::{BINOMIALS, MAX_DEGREE};
use crate::bezier::bernstein::binomial;
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::{Isa, Simd, Task};

/// Smallest degree to which rows are reduced.
const LEAST: usize = 3;

/// Largest number of lists that are kept: those of homogeneous points.
const MOST_KEPT: usize = 4;

/// Largest number of coefficients.
const COEFFICIENTS: usize = (MAX_DEGREE + 1) * (MAX_DEGREE + 1);

/// Matrices between Bernstein coefficients of a degree n and of a lower one, m.
struct Conversion {
    /// (m + 1) rows of n + 1 numbers.
    lower: Vec<f64>,
    /// (n + 1) rows of m + 1 numbers.
    raise: Vec<f64>,
}

static CONVERSIONS: [[OnceLock<Conversion>; MAX_DEGREE + 1]; MAX_DEGREE + 1] =
    [const { [const { OnceLock::new() }; MAX_DEGREE + 1] }; MAX_DEGREE + 1];

fn bernstein(n: usize, i: usize, x: f64) -> f64 {
    binomial(n, i) * x.powi(i as i32) * (1.0 - x).powi((n - i) as i32)
}

impl Conversion {
    fn new(n: usize, m: usize) -> Self {
        let node = |k: usize| 0.5 - 0.5 * (PI * k as f64 / m as f64).cos();
        // Both bases at the nodes, one beside the other.
        let (side, width) = (m + 1, m + n + 2);
        let mut table = vec![0.0; side * width];
        for (k, row) in table.chunks_exact_mut(width).enumerate() {
            let x = node(k);
            for (i, slot) in row.iter_mut().enumerate() {
                *slot = if i <= m { bernstein(m, i, x) } else { bernstein(n, i - side, x) };
            }
        }
        // Gauss and Jordan; the matrix is diagonally strong, so that no rows are exchanged.
        for k in 0..side {
            let pivot = 1.0 / table[k * width + k];
            table[k * width..(k + 1) * width].iter_mut().for_each(|x| *x *= pivot);
            for other in (0..side).filter(|&other| other != k) {
                let factor = table[other * width + k];
                for i in 0..width {
                    table[other * width + i] -= factor * table[k * width + i];
                }
            }
        }
        let mut lower: Vec<f64> =
            table.chunks_exact(width).flat_map(|row| row[side..].iter().copied()).collect();
        // The ends are kept to the bit.
        for (row, kept) in [(0, 0), (m, n)] {
            for (i, slot) in lower[row * (n + 1)..(row + 1) * (n + 1)].iter_mut().enumerate() {
                *slot = f64::from(u8::from(i == kept));
            }
        }
        let share = |i: usize, k: usize| {
            if k > i || i - k > n - m {
                0.0
            } else {
                binomial(m, k) * binomial(n - m, i - k) / binomial(n, i)
            }
        };
        let raise = (0..=n).flat_map(|i| (0..=m).map(move |k| share(i, k))).collect();
        Self { lower, raise }
    }

    fn between(n: usize, m: usize) -> Option<&'static Self> {
        Some(CONVERSIONS.get(n)?.get(m)?.get_or_init(|| Self::new(n, m)))
    }
}

/// The lowest degree to which rows of `length` numbers, at distance `step` in `list` from these starts, can be expected to be
/// reduced with this error.
#[inline(always)]
fn expected(list: &[f64], starts: &[usize], length: usize, step: usize, error: f64) -> usize {
    let n = length - 1;
    let mut largest = [[0.0_f64; LANES]; MAX_DEGREE + 1];
    for starts in starts.chunks(LANES) {
        // Rows side by side, for vector instructions.
        let mut rows = [[0.0; LANES]; MAX_DEGREE + 1];
        for (i, slots) in rows[..length].iter_mut().enumerate() {
            for (slot, start) in slots.iter_mut().zip(starts) {
                *slot = list[start + i * step];
            }
        }
        for (order, most) in largest[..length].iter_mut().enumerate().skip(1) {
            for i in 0..length - order {
                for (lane, most) in most.iter_mut().enumerate() {
                    let difference = rows[i + 1][lane] - rows[i][lane];
                    rows[i][lane] = difference;
                    *most = if difference.abs() > *most { difference.abs() } else { *most };
                }
            }
        }
    }
    // The best approximation omits the Chebyshev polynomials of higher orders.
    let (mut m, mut left) = (n, error);
    while m > LEAST {
        let most = largest[m].iter().copied().fold(0.0, f64::max);
        left -= BINOMIALS[n][m] * most * 0.5_f64.powi(2 * m as i32 - 1);
        if left < 0.0 {
            break;
        }
        m -= 1;
    }
    m
}

/// Reduces the degree along x, or along y, of the lists of coefficients from `start` on, that of (i, j) at j (p + 1) + i: `kept` lists of polynomials,
/// and perhaps one of weights, which only bounds the rounding. Returns the new degrees and the error of the polynomials, at most `error`, if that
/// succeeds.
pub(super) fn reduce(
    cells: &mut Vec<f64>,
    start: usize,
    degrees: (usize, usize),
    along_x: bool,
    error: f64,
    kept: usize,
) -> Option<((usize, usize), f64)> {
    Isa::detect().run(Reduction { cells, start, degrees, along_x, error, kept })
}

struct Reduction<'a> {
    cells: &'a mut Vec<f64>,
    start: usize,
    degrees: (usize, usize),
    along_x: bool,
    error: f64,
    kept: usize,
}

impl Task for Reduction<'_> {
    type Output = Option<((usize, usize), f64)>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Self::Output {
        let Self { cells, start, degrees: (p, q), along_x, error, kept } = self;
        let n = if along_x { p } else { q };
        if n <= LEAST {
            return None;
        }
        let size = (p + 1) * (q + 1);
        let (step, stride, rows) = if along_x { (1, p + 1, q + 1) } else { (p + 1, 1, p + 1) };
        let list = &cells[start..start + kept * size];
        let sampled = [0, rows / 2, rows - 1].map(|row| row * stride);
        let mut starts = [0; 3 * MOST_KEPT];
        for (k, start) in starts.iter_mut().enumerate() {
            *start = k / 3 * size + sampled[k % 3];
        }
        let m = expected(list, &starts[..3 * kept], n + 1, step, error);
        if 5 * (m + 1) > 4 * (n + 1) {
            return None;
        }
        let Conversion { lower, raise } = Conversion::between(n, m)?;
        let degrees = if along_x { (m, q) } else { (p, m) };
        let mut reduced = Vec::with_capacity((cells.len() - start) / (n + 1) * (m + 1));
        let mut worst = 0.0_f64;
        // Coefficients of one order side by side, for vector instructions.
        let (mut long, mut short, mut back) =
            ([0.0; COEFFICIENTS], [0.0; COEFFICIENTS], [0.0; MAX_DEGREE + 1]);
        let (long, short, back) =
            (&mut long[..(n + 1) * rows], &mut short[..(m + 1) * rows], &mut back[..rows]);
        for (number, list) in cells[start..].chunks_exact(size).enumerate() {
            for (i, order) in long.chunks_exact_mut(rows).enumerate() {
                for (line, slot) in order.iter_mut().enumerate() {
                    *slot = list[line * stride + i * step];
                }
            }
            if number < kept {
                for (order, factors) in short.chunks_exact_mut(rows).zip(lower.chunks_exact(n + 1)) {
                    combine(order, factors, long);
                }
                for (order, factors) in long.chunks_exact(rows).zip(raise.chunks_exact(m + 1)) {
                    combine(back, factors, short);
                    for (back, x) in back.iter().zip(order) {
                        // NaN is above every error.
                        let off = (back - x).abs();
                        worst = if off <= worst { worst } else { off };
                    }
                }
                if worst.is_nan() || worst > error {
                    return None;
                }
            } else {
                // Interpolated weights may lie below those that bound the rounding.
                for line in 0..rows {
                    let most = long.iter().skip(line).step_by(rows).copied().fold(0.0, f64::max);
                    short.iter_mut().skip(line).step_by(rows).for_each(|slot| *slot = most);
                }
            }
            let first = reduced.len();
            reduced.resize(first + (degrees.0 + 1) * (degrees.1 + 1), 0.0);
            let (out_step, out_stride) = if along_x { (1, m + 1) } else { (p + 1, 1) };
            for (k, order) in short.chunks_exact(rows).enumerate() {
                for (line, x) in order.iter().enumerate() {
                    reduced[first + line * out_stride + k * out_step] = *x;
                }
            }
        }
        cells.truncate(start);
        cells.extend(reduced);
        Some((degrees, worst))
    }
}

/// The sum of the rows of `list`, each times its factor.
#[inline(always)]
fn combine(sum: &mut [f64], factors: &[f64], list: &[f64]) {
    sum.fill(0.0);
    for (row, factor) in list.chunks_exact(sum.len()).zip(factors) {
        for (sum, x) in sum.iter_mut().zip(row) {
            *sum += factor * x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bernstein coefficients of degree n of x^k.
    fn power(n: usize, k: usize) -> Vec<f64> {
        (0..=n).map(|i| binomial(i, k) / binomial(n, k)).collect()
    }

    #[test]
    fn polynomials_of_lower_degree_keep_their_values_and_others_their_degree() {
        // x^2 + y^3 of degrees (20, 17), and the same with x^9 / 1000. Differences of all orders have thousands of times the rounding of the coefficients.
        let list = |extra: f64| -> Vec<f64> {
            let (x2, x9, y3) = (power(20, 2), power(20, 9), power(17, 3));
            y3.iter().flat_map(|y| x2.iter().zip(&x9).map(move |(a, b)| a + y + extra * b)).collect()
        };
        let both = [list(0.0), list(0.0)].concat();
        let mut cells = both.clone();
        let (degrees, error) = reduce(&mut cells, 0, (20, 17), true, 1e-12, 2).unwrap();
        assert_eq!((degrees, error <= 1e-12), ((3, 17), true));
        let (degrees, _) = reduce(&mut cells, 0, degrees, false, 1e-12, 2).unwrap();
        assert_eq!((degrees, cells.len()), ((3, 3), 32));
        for (j, y) in power(3, 3).iter().enumerate() {
            for (i, x) in power(3, 2).iter().enumerate() {
                assert!((cells[4 * j + i] - x - y).abs() < 1e-12);
            }
        }
        let mut uneven = [list(1e-3), list(0.0)].concat();
        let (degrees, error) = reduce(&mut uneven, 0, (20, 17), true, 1e-12, 2).unwrap();
        assert!(degrees.0 >= 9 && degrees.0 < 12 && error <= 1e-12, "{degrees:?} {error}");
    }
}
