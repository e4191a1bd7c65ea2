//! Polynomials in x, y and z of total degree 4 at most.

use glanz_math::polynomial::compensated::{two_product, two_sum};
use glanz_math::{DMat3, DVec3};

use super::{MAX_DEGREE, Term};

/// Coefficients of a univariate polynomial, ascending.
pub(super) type Univariate = [f64; MAX_DEGREE + 1];

const SIDE: usize = MAX_DEGREE + 1;

/// A dense polynomial, in the order in which Horner's rule wants its coefficients: i, j, k falling from the degree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polynomial3 {
    degree: usize,
    coefficients: Vec<f64>,
}

/// Value and derivatives at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) value: f64,
    /// Sum of the moduli of all terms, in which rounding errors are measured.
    pub(super) size: f64,
    pub(super) gradient: DVec3,
    pub(super) hessian: DMat3,
}

/// Coefficients by exponents, each as a sum of two numbers.
pub(super) type Cube = [[[(f64, f64); SIDE]; SIDE]; SIDE];

/// `c + a b` in twice the precision.
fn add_product(c: (f64, f64), a: f64, b: (f64, f64)) -> (f64, f64) {
    let (product, e) = two_product(a, b.0);
    let (sum, f) = two_sum(c.0, product);
    two_sum(sum, f + (e + a * b.1 + c.1))
}

/// Replaces x by x + `by` in `sum c_i x^i`, in twice the precision, by repeated Horner steps.
fn shift_line(c: &mut [(f64, f64); SIDE], by: f64) {
    for m in 0..SIDE - 1 {
        for l in (m..SIDE - 1).rev() {
            c[l] = add_product(c[l], by, c[l + 1]);
        }
    }
}

/// The polynomial seen from `center`: its argument is the distance from there, over `scale` (a power of two).
///
/// In twice the precision, since the constant term near a surface far from the origin is what large terms leave over.
pub(super) fn recenter(cube: &mut Cube, center: DVec3, scale: f64) {
    for line_number in 0..SIDE * SIDE {
        let (a, b) = (line_number / SIDE, line_number % SIDE);
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
                // Exact; a total degree of at most 4 keeps its distance from overflow for any box that means something.
                let factor = (0..i + j + k).fold(1.0, |f, _| f * scale);
                *c = (c.0 * factor, c.1 * factor);
            }
        }
    }
}

impl Polynomial3 {
    /// The rounded coefficients of `cube` up to the total degree `degree`.
    pub(super) fn new(cube: &Cube, degree: usize) -> Self {
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

    /// All terms, also those with the factor 0.
    pub(super) fn terms(&self) -> impl Iterator<Item = Term> + '_ {
        let n = self.degree as u32;
        let exponents = (0..=n).rev().flat_map(move |i| {
            (0..=n - i).rev().flat_map(move |j| (0..=n - i - j).rev().map(move |k| [i, j, k]))
        });
        exponents.zip(&self.coefficients).map(|(exponents, &coefficient)| Term { exponents, coefficient })
    }

    /// The polynomial in s on the line `origin + s direction`.
    ///
    /// Horner's rule three deep, with polynomials in s for numbers: every term of total degree n passes 2 n + 3
    /// roundings at most.
    pub(super) fn on_line(&self, origin: DVec3, direction: DVec3) -> Univariate {
        let n = self.degree;
        let mut rest = self.coefficients.iter();
        let mut outer = [0.0; SIDE];
        for i in (0..=n).rev() {
            let mut middle = [0.0; SIDE];
            for j in (0..=n - i).rev() {
                let mut inner = [0.0; SIDE];
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
    pub(super) fn jet(&self, p: DVec3) -> Jet {
        let powers = [p.x, p.y, p.z].map(|x| {
            let mut power = [1.0; SIDE];
            for i in 1..SIDE {
                power[i] = power[i - 1] * x;
            }
            power
        });
        // x^i, i x^(i-1), i (i-1) x^(i-2)
        let table = powers.map(|power| {
            std::array::from_fn::<[f64; 3], SIDE, _>(|i| {
                let first = if i >= 1 { i as f64 * power[i - 1] } else { 0.0 };
                let second = if i >= 2 { (i * (i - 1)) as f64 * power[i - 2] } else { 0.0 };
                [power[i], first, second]
            })
        });
        let mut jet = Jet { value: 0.0, size: 0.0, gradient: DVec3::ZERO, hessian: DMat3::ZERO };
        let (mut diagonal, mut mixed) = (DVec3::ZERO, DVec3::ZERO);
        let mut rest = self.coefficients.iter();
        for i in (0..=self.degree).rev() {
            for j in (0..=self.degree - i).rev() {
                for k in (0..=self.degree - i - j).rev() {
                    let c = rest.next().copied().unwrap_or(0.0);
                    let ([x, dx, ddx], [y, dy, ddy], [z, dz, ddz]) = (table[0][i], table[1][j], table[2][k]);
                    let term = c * x * y * z;
                    jet.value += term;
                    jet.size += term.abs();
                    jet.gradient += DVec3::new(c * dx * y * z, c * x * dy * z, c * x * y * dz);
                    diagonal += DVec3::new(c * ddx * y * z, c * x * ddy * z, c * x * y * ddz);
                    mixed += DVec3::new(c * x * dy * dz, c * dx * y * dz, c * dx * dy * z);
                }
            }
        }
        jet.hessian = DMat3::from_cols(
            DVec3::new(diagonal.x, mixed.z, mixed.y),
            DVec3::new(mixed.z, diagonal.y, mixed.x),
            DVec3::new(mixed.y, mixed.x, diagonal.z),
        );
        jet
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
