//! Evaluation, splitting and bounding of Bézier nets, as plain arrays.

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

/// The largest degree of a patch in one direction; that of the common CAD kernels.
pub const MAX_DEGREE: usize = 25;

/// Room for the basis of one direction.
pub(super) type Basis = [f64; MAX_DEGREE + 1];

/// Bernstein polynomials of `degree` at `x` and their derivatives up to the second.
pub(super) fn bernstein(degree: usize, x: f64) -> [Basis; 3] {
    let mut out = [[0.0; MAX_DEGREE + 1]; 3];
    let y = 1.0 - x;
    // Row d from row d - 1, keeping the last rows but one and two for the derivatives.
    let mut row: Basis = [0.0; MAX_DEGREE + 1];
    row[0] = 1.0;
    for d in 1..=degree {
        let (first, second) = (degree - d == 0, degree - d == 1);
        if first {
            out[1] = differences(&row, degree, degree as f64);
        } else if second {
            let rise = differences(&row, degree - 1, 1.0);
            out[2] = differences(&rise, degree, (degree * (degree - 1)) as f64);
        }
        for i in (0..=d).rev() {
            let below = if i > 0 { row[i - 1] } else { 0.0 };
            row[i] = y * row[i] + x * below;
        }
    }
    out[0] = row;
    out
}

/// Derivative of a Bernstein basis: entry i is `factor` (row\[i - 1\] - row\[i\]), for i up to `degree`.
fn differences(row: &Basis, degree: usize, factor: f64) -> Basis {
    let mut out = [0.0; MAX_DEGREE + 1];
    for (i, value) in out.iter_mut().enumerate().take(degree + 1) {
        let below = if i > 0 { row[i - 1] } else { 0.0 };
        *value = factor * (below - row[i]);
    }
    out
}

/// A point of a patch with its derivatives by its own parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) s: DVec3,
    pub(super) su: DVec3,
    pub(super) sv: DVec3,
    pub(super) suu: DVec3,
    pub(super) suv: DVec3,
    pub(super) svv: DVec3,
}

/// Point and derivatives up to the second of the homogeneous net `points`, that of (i, j) at i (q + 1) + j.
pub(super) fn jet(points: &[DVec4], (p, q): (usize, usize), u: f64, v: f64) -> Jet {
    let (bu, bv) = (bernstein(p, u), bernstein(q, v));
    let mut sums = [[DVec4::ZERO; 3]; 3];
    for (i, row) in points.chunks_exact(q + 1).enumerate().take(p + 1) {
        let mut along = [DVec4::ZERO; 3];
        for (j, &point) in row.iter().enumerate() {
            for (sum, basis) in along.iter_mut().zip(&bv) {
                *sum += point * basis[j];
            }
        }
        for (sums, basis) in sums.iter_mut().zip(&bu) {
            for (sum, along) in sums.iter_mut().zip(along) {
                *sum += along * basis[i];
            }
        }
    }
    let [[h, hv, hvv], [hu, huv, _], [huu, _, _]] = sums;
    // Quotient rule, order by order (@markgraf2019 eq. 14).
    let per = 1.0 / h.w;
    let s = h.truncate() * per;
    let su = (hu.truncate() - s * hu.w) * per;
    let sv = (hv.truncate() - s * hv.w) * per;
    Jet {
        s,
        su,
        sv,
        suu: (huu.truncate() - su * (2.0 * hu.w) - s * huu.w) * per,
        suv: (huv.truncate() - su * hv.w - sv * hu.w - s * huv.w) * per,
        svv: (hvv.truncate() - sv * (2.0 * hv.w) - s * hvv.w) * per,
    }
}

/// Halves of a row of coefficients: those below and above 1/2.
///
/// The additions are symmetric, so that a row and its reverse give the same bits.
pub(super) fn halve<T>(row: &mut [T], upper: &mut [T])
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let n = row.len();
    for k in 0..n {
        // What is finished of the upper half is the last entry of each level.
        upper[n - 1 - k] = row[n - 1];
        for i in (k + 1..n).rev() {
            row[i] = (row[i - 1] + row[i]) * 0.5;
        }
    }
}

/// Halves of the net `points` of (p + 1) (q + 1) coefficients, across the first direction or the second.
pub(super) fn split<T>(points: &[T], (p, q): (usize, usize), across_first: bool) -> [Vec<T>; 2]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let (mut low, mut high) = (points.to_vec(), points.to_vec());
    let (rows, length) = if across_first { (q + 1, p + 1) } else { (p + 1, q + 1) };
    let at = |row: usize, k: usize| if across_first { k * (q + 1) + row } else { row * (q + 1) + k };
    for row in 0..rows {
        let mut below: Vec<T> = (0..length).map(|k| points[at(row, k)]).collect();
        let mut above = below.clone();
        halve(&mut below, &mut above);
        for k in 0..length {
            low[at(row, k)] = below[k];
            high[at(row, k)] = above[k];
        }
    }
    [low, high]
}

/// A polynomial in two variables with its degrees: coefficient (i, j) at i (q + 1) + j.
#[derive(Clone, Debug)]
pub(super) struct Poly<T> {
    pub(super) degrees: (usize, usize),
    pub(super) coefficients: Vec<T>,
}

impl<T> Poly<T>
where
    T: Copy
        + Default
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f64, Output = T>,
{
    /// The product with `other`.
    pub(super) fn times(&self, other: &Poly<f64>) -> Self {
        let ((p, q), (r, s)) = (self.degrees, other.degrees);
        let (m, n) = (p + r, q + s);
        let mut coefficients = vec![T::default(); (m + 1) * (n + 1)];
        for i in 0..=m {
            for j in 0..=n {
                let mut sum = T::default();
                for k in i.saturating_sub(r)..=p.min(i) {
                    for l in j.saturating_sub(s)..=q.min(j) {
                        let share = choose(p, k) * choose(r, i - k) * choose(q, l) * choose(s, j - l);
                        let factor = other.coefficients[(i - k) * (s + 1) + j - l];
                        sum = sum + self.coefficients[k * (q + 1) + l] * (share * factor);
                    }
                }
                coefficients[i * (n + 1) + j] = sum * (1.0 / (choose(m, i) * choose(n, j)));
            }
        }
        Self { degrees: (m, n), coefficients }
    }

    /// The derivative by the first variable, or the second; of degree 0 there if it was.
    pub(super) fn derivative(&self, by_first: bool) -> Self {
        let (p, q) = self.degrees;
        let at = |i: usize, j: usize| self.coefficients[i * (q + 1) + j];
        let (m, n) = if by_first { (p.saturating_sub(1), q) } else { (p, q.saturating_sub(1)) };
        let rise = |i: usize, j: usize| match by_first {
            true if p > 0 => (at(i + 1, j) - at(i, j)) * p as f64,
            false if q > 0 => (at(i, j + 1) - at(i, j)) * q as f64,
            _ => T::default(),
        };
        let coefficients =
            (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| rise(i, j)).collect();
        Self { degrees: (m, n), coefficients }
    }
}

/// Binomial coefficient.
fn choose(n: usize, k: usize) -> f64 {
    (0..k.min(n - k)).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bernstein_derivatives_are_differences() {
        for degree in 1..=MAX_DEGREE {
            for x in [0.0, 0.3, 0.5, 0.9, 1.0] {
                let [value, first, second] = bernstein(degree, x);
                assert!((value.iter().sum::<f64>() - 1.0).abs() < 1e-13);
                let h = 1e-5;
                let (up, down) = (bernstein(degree, x + h), bernstein(degree, x - h));
                for i in 0..=degree {
                    let scale = (degree * degree) as f64;
                    assert!((first[i] - (up[0][i] - down[0][i]) / (2.0 * h)).abs() < 1e-8 * scale * scale);
                    assert!(
                        (second[i] - (up[1][i] - down[1][i]) / (2.0 * h)).abs()
                            < 1e-8 * scale * scale * scale
                    );
                }
            }
        }
    }

    #[test]
    fn halves_of_a_reversed_row_are_the_reversed_halves_bit_by_bit() {
        let row = [0.1, 0.7, -0.3, 0.9, 0.2];
        let (mut low, mut high) = (row, row);
        halve(&mut low, &mut high);
        let mut reversed = row;
        reversed.reverse();
        let (mut low_r, mut high_r) = (reversed, reversed);
        halve(&mut low_r, &mut high_r);
        low_r.reverse();
        high_r.reverse();
        assert_eq!((low, high), (high_r, low_r));
        assert_eq!(low[4], high[0]);
    }

    #[test]
    fn product_of_polynomials_is_the_product_of_their_values() {
        let a = Poly { degrees: (2, 1), coefficients: vec![1.0, 2.0, -1.0, 0.5, 3.0, 0.25] };
        let b = Poly { degrees: (1, 2), coefficients: vec![0.5, 1.5, 1.0, 2.0, -0.5, 1.0] };
        let value = |p: &Poly<f64>, u: f64, v: f64| {
            let net: Vec<DVec4> = p.coefficients.iter().map(|&c| DVec4::new(c, 0.0, 0.0, 1.0)).collect();
            jet(&net, p.degrees, u, v).s.x
        };
        let product = a.times(&b);
        for (u, v) in [(0.0, 0.0), (0.2, 0.9), (1.0, 0.4)] {
            assert!((value(&product, u, v) - value(&a, u, v) * value(&b, u, v)).abs() < 1e-14);
        }
    }
}
