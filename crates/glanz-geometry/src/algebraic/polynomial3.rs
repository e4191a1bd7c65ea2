//! Polynomials in x, y and z of total degree at most 4.

use glanz_math::polynomial::compensated::{two_product, two_sum};
use glanz_math::{DMat3, DVec3};

use super::{MAX_DEGREE, PolynomialTerm};

/// Coefficients of a univariate polynomial, ascending.
pub(super) type Univariate = [f64; MAX_DEGREE + 1];

/// Number of coefficients per variable.
const SIZE: usize = MAX_DEGREE + 1;

/// A dense polynomial with coefficients in the order of Horner's rule: i, j, k descending from the degree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polynomial3 {
    degree: usize,
    coefficients: Vec<f64>,
}

/// Value and derivatives up to second order at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct TaylorExpansion {
    pub(super) value: f64,
    /// Sum of the moduli of all terms, the scale of rounding errors.
    pub(super) size: f64,
    pub(super) gradient: DVec3,
    pub(super) hessian: DMat3,
}

/// Coefficients by exponents, each an unevaluated sum of two numbers.
pub(super) type CoefficientCube = [[[(f64, f64); SIZE]; SIZE]; SIZE];

/// `c + a b` in twice the precision.
fn add_product(c: (f64, f64), a: f64, b: (f64, f64)) -> (f64, f64) {
    let (product, e) = two_product(a, b.0);
    let (sum, f) = two_sum(c.0, product);
    two_sum(sum, f + (e + a * b.1 + c.1))
}

/// Replaces x by x + `by` in `sum c_i x^i`, in twice the precision, by repeated Horner steps.
fn shift_line(c: &mut [(f64, f64); SIZE], by: f64) {
    for m in 0..SIZE - 1 {
        for l in (m..SIZE - 1).rev() {
            c[l] = add_product(c[l], by, c[l + 1]);
        }
    }
}

/// Substitutes coordinates relative to `center`, in units of `scale` (a power of two).
///
/// The precision is doubled, since large terms cancel in the constant term near a surface far from the origin.
pub(super) fn recenter(cube: &mut CoefficientCube, center: DVec3, scale: f64) {
    for line_number in 0..SIZE * SIZE {
        let (a, b) = (line_number / SIZE, line_number % SIZE);
        let mut line = std::array::from_fn(|i| cube[i][a][b]);
        shift_line(&mut line, center.x);
        line.iter().enumerate().for_each(|(i, c)| cube[i][a][b] = *c);
        let mut line = std::array::from_fn(|j| cube[a][j][b]);
        shift_line(&mut line, center.y);
        line.iter().enumerate().for_each(|(j, c)| cube[a][j][b] = *c);
    }
    for plane in cube.iter_mut() {
        for line in plane.iter_mut() {
            shift_line(line, center.z);
        }
    }
    for (i, plane) in cube.iter_mut().enumerate() {
        for (j, line) in plane.iter_mut().enumerate() {
            for (k, c) in line.iter_mut().enumerate() {
                // Exact; the total degree of at most 4 excludes overflow for boxes of any reasonable size.
                let factor = (0..i + j + k).fold(1.0, |f, _| f * scale);
                *c = (c.0 * factor, c.1 * factor);
            }
        }
    }
}

impl Polynomial3 {
    /// The rounded coefficients of `cube` up to the total degree `degree`.
    pub(super) fn new(cube: &CoefficientCube, degree: usize) -> Self {
        let mut coefficients = Vec::new();
        for i in (0..=degree).rev() {
            for j in (0..=degree - i).rev() {
                for k in (0..=degree - i - j).rev() {
                    coefficients.push(cube[i][j][k].0);
                }
            }
        }
        Self { degree, coefficients }
    }

    /// All terms, including those with the coefficient 0.
    pub(super) fn terms(&self) -> impl Iterator<Item = PolynomialTerm> + '_ {
        let n = self.degree as u32;
        let exponents = (0..=n).rev().flat_map(move |i| {
            (0..=n - i).rev().flat_map(move |j| (0..=n - i - j).rev().map(move |k| [i, j, k]))
        });
        exponents
            .zip(&self.coefficients)
            .map(|(exponents, &coefficient)| PolynomialTerm { exponents, coefficient })
    }

    /// The polynomial in s on the line `origin + s direction`.
    ///
    /// Horner's rule in three nested loops, with polynomials in s as coefficients: a term of total degree n has at most 2 n + 3
    /// roundings.
    pub(super) fn on_line(&self, origin: DVec3, direction: DVec3) -> Univariate {
        let n = self.degree;
        let mut rest = self.coefficients.iter();
        let mut outer = [0.0; SIZE];
        for i in (0..=n).rev() {
            let mut middle = [0.0; SIZE];
            for j in (0..=n - i).rev() {
                let mut inner = [0.0; SIZE];
                for k in (0..=n - i - j).rev() {
                    times_linear(&mut inner, n - i - j - k, origin.z, direction.z);
                    inner[0] += rest.next().copied().unwrap_or(0.0);
                }
                times_linear(&mut middle, n - i - j, origin.y, direction.y);
                add(&mut middle, &inner, n - i - j);
            }
            times_linear(&mut outer, n - i, origin.x, direction.x);
            add(&mut outer, &middle, n - i);
        }
        outer
    }

    /// Value, gradient and second derivatives at `p`.
    pub(super) fn expansion(&self, p: DVec3) -> TaylorExpansion {
        let powers = [p.x, p.y, p.z].map(|x| {
            let mut power = [1.0; SIZE];
            for i in 1..SIZE {
                power[i] = power[i - 1] * x;
            }
            power
        });
        // x^i, i x^(i-1), i (i-1) x^(i-2)
        let table = powers.map(|power| {
            std::array::from_fn::<[f64; 3], SIZE, _>(|i| {
                let first = if i >= 1 { i as f64 * power[i - 1] } else { 0.0 };
                let second = if i >= 2 { (i * (i - 1)) as f64 * power[i - 2] } else { 0.0 };
                [power[i], first, second]
            })
        });
        let mut expansion =
            TaylorExpansion { value: 0.0, size: 0.0, gradient: DVec3::ZERO, hessian: DMat3::ZERO };
        let (mut diagonal, mut mixed) = (DVec3::ZERO, DVec3::ZERO);
        let mut rest = self.coefficients.iter();
        for i in (0..=self.degree).rev() {
            for j in (0..=self.degree - i).rev() {
                for k in (0..=self.degree - i - j).rev() {
                    let c = rest.next().copied().unwrap_or(0.0);
                    let ([x, dx, ddx], [y, dy, ddy], [z, dz, ddz]) = (table[0][i], table[1][j], table[2][k]);
                    let term = c * x * y * z;
                    expansion.value += term;
                    expansion.size += term.abs();
                    expansion.gradient += DVec3::new(c * dx * y * z, c * x * dy * z, c * x * y * dz);
                    diagonal += DVec3::new(c * ddx * y * z, c * x * ddy * z, c * x * y * ddz);
                    mixed += DVec3::new(c * x * dy * dz, c * dx * y * dz, c * dx * dy * z);
                }
            }
        }
        expansion.hessian = DMat3::from_cols(
            DVec3::new(diagonal.x, mixed.z, mixed.y),
            DVec3::new(mixed.z, diagonal.y, mixed.x),
            DVec3::new(mixed.y, mixed.x, diagonal.z),
        );
        expansion
    }
}

/// Multiplies `p`, of degree below `degree`, by `c + d s`.
fn times_linear(p: &mut Univariate, degree: usize, c: f64, d: f64) {
    for m in (1..=degree.min(MAX_DEGREE)).rev() {
        p[m] = p[m] * c + p[m - 1] * d;
    }
    p[0] *= c;
}

fn add(p: &mut Univariate, q: &Univariate, degree: usize) {
    for (a, b) in p.iter_mut().zip(q).take(degree + 1) {
        *a += b;
    }
}
