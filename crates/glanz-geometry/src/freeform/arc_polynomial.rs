//! Polynomials of one variable in Bernstein form: products, values and roots, for the contact curve of a cell.

use super::contact_arc::MOST_DEGREE;
use crate::bezier::bernstein::pascal_triangle;

/// Length of the longest eliminant.
pub(super) const LONGEST: usize = 8 * MOST_DEGREE - 2;

/// Steps of the search for a root of the eliminant: bisection to the last bit.
const MOST_STEPS: usize = 64;

/// A polynomial in Bernstein form whose coefficients are multiplied by the binomials, so that products are convolutions.
#[derive(Clone, Copy)]
pub(super) struct ScaledBernstein<const N: usize> {
    pub(super) coefficients: [f64; N],
    pub(super) length: usize,
}

impl<const N: usize> ScaledBernstein<N> {
    pub(super) const ZERO: Self = Self { coefficients: [0.0; N], length: 1 };

    pub(super) fn of(list: impl ExactSizeIterator<Item = f64>) -> Self {
        let mut scaled = Self { coefficients: [0.0; N], length: list.len() };
        let degree = list.len().saturating_sub(1);
        for ((slot, c), factor) in scaled.coefficients.iter_mut().zip(list).zip(&BINOMIALS[degree]) {
            *slot = c * factor;
        }
        scaled
    }

    /// Adds a product of degree `self.length - 1`.
    pub(super) fn add_product<const K: usize, const L: usize>(
        &mut self,
        a: &ScaledBernstein<K>,
        b: &ScaledBernstein<L>,
        sign: f64,
    ) {
        for (i, x) in a.coefficients[..a.length].iter().enumerate() {
            let x = x * sign;
            for (slot, y) in self.coefficients[i..].iter_mut().zip(&b.coefficients[..b.length]) {
                *slot += x * y;
            }
        }
    }

    pub(super) fn unscaled(&self) -> Self {
        let mut plain = *self;
        for (slot, factor) in plain.coefficients.iter_mut().zip(&BINOMIALS[self.length - 1][..self.length]) {
            *slot /= factor;
        }
        plain
    }

    pub(super) fn is_finite(&self) -> bool {
        self.coefficients[..self.length].iter().all(|c| c.is_finite())
    }

    /// Bound on the absolute value: the largest coefficient.
    pub(super) fn largest(&self) -> f64 {
        let factors = &BINOMIALS[self.length - 1][..self.length];
        self.coefficients.iter().zip(factors).fold(0.0, |most, (c, factor)| most.max((c / factor).abs()))
    }
}

/// Rows of Pascal's triangle up to the degree of the longest eliminant.
static BINOMIALS: [[f64; LONGEST]; LONGEST] = pascal_triangle();

/// Value and derivative of Bernstein coefficients.
pub(super) fn value(row: &[f64], x: f64) -> (f64, f64) {
    let Some((&first, rest)) = row.split_first() else { return (0.0, 0.0) };
    let n = rest.len();
    if n == 0 {
        return (first, 0.0);
    }
    // Horner's rule in x / (1 - x), for the polynomial and for the differences.
    let (y, row_n, row_d) = (1.0 - x, &BINOMIALS[n], &BINOMIALS[n - 1]);
    let (mut power, mut sum, mut slope, mut before) = (1.0, first * y, 0.0, first);
    for (i, &c) in rest.iter().enumerate() {
        slope = slope * y + power * row_d[i] * (c - before);
        power *= x;
        sum += power * row_n[i + 1] * c;
        if i + 1 < n {
            sum *= y;
        }
        before = c;
    }
    (sum, n as f64 * slope)
}

/// Where `f`, with its derivative, changes from negative at `from` to positive at `to`, to within `accuracy` of `f`; the end if it does not.
/// The search begins at `start`, between both.
pub(super) fn crossing(
    f: impl Fn(f64) -> (f64, f64),
    [from, to]: [f64; 2],
    start: f64,
    accuracy: f64,
) -> f64 {
    if f(from).0 >= 0.0 {
        return from;
    }
    if f(to).0 <= 0.0 {
        return to;
    }
    let (mut below, mut above) = (from, to);
    let mut x = start;
    let mut last = (to - from).abs();
    for _ in 0..MOST_STEPS {
        let (y, slope) = f(x);
        if y.abs() <= accuracy {
            return x;
        }
        *(if y < 0.0 { &mut below } else { &mut above }) = x;
        let newton = x - y / slope;
        let inside = newton > below.min(above) && newton < below.max(above);
        // Steps that do not halve may go on in a circle.
        let is_shorter = inside && (newton - x).abs() <= 0.5 * last;
        let next = if is_shorter { newton } else { 0.5 * (below + above) };
        last = (next - x).abs();
        if (next - x).abs() <= f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_those_of_the_closed_form() {
        // x^3 - x + 1/4.
        let row = [0.25, 0.25 - 1.0 / 3.0, 0.25 - 2.0 / 3.0, 0.25];
        for x in [-0.5, 0.0, 0.3, 0.5, 1.0, 1.5] {
            let (y, slope) = value(&row, x);
            assert!((y - (x * x * x - x + 0.25)).abs() < 1e-15, "{x}: {y}");
            assert!((slope - (3.0 * x * x - 1.0)).abs() < 1e-14, "{x}: {slope}");
        }
        assert_eq!((value(&[], 0.3), value(&[2.0], 0.3)), ((0.0, 0.0), (2.0, 0.0)));
    }

    #[test]
    fn crossing_is_the_root_or_the_end_beyond_which_it_lies() {
        let line = |level: f64| move |x: f64| (x * x - level, 2.0 * x);
        assert!((crossing(line(0.25), [0.0, 1.0], 0.9, 0.0) - 0.5).abs() <= f64::EPSILON);
        // From right to left.
        let falling = |x: f64| (0.25 - x * x, -2.0 * x);
        assert!((crossing(falling, [1.0, 0.0], 0.9, 0.0) - 0.5).abs() <= f64::EPSILON);
        assert_eq!(crossing(line(-1.0), [0.0, 1.0], 0.5, 0.0), 0.0);
        assert_eq!(crossing(line(2.0), [0.0, 1.0], 0.5, 0.0), 1.0);
        assert_eq!(crossing(line(0.25), [0.7, 0.7], 0.7, 0.0), 0.7);
    }
}
