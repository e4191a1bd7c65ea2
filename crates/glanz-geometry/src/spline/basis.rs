//! B-spline basis functions and their derivatives.

use super::knots::{KnotVector, MAX_DEGREE};

/// Values of the basis functions that do not vanish on a span; entries past the degree are 0.
pub type BasisRow = [f64; MAX_DEGREE + 1];

/// Entries of a row up to which most degrees have functions.
const SHORT: usize = 8;

/// The basis functions of a knot vector at one parameter.
#[derive(Clone, Copy, Debug)]
pub struct BasisFunctions<'a> {
    knots: &'a KnotVector,
    span: usize,
    u: f64,
}

impl<'a> BasisFunctions<'a> {
    /// The basis at `u`, which is moved into the domain if it lies outside.
    ///
    /// A knot belongs to the piece that starts there, the end of the domain to the last one.
    #[must_use]
    pub fn at(knots: &'a KnotVector, u: f64) -> Self {
        let u = knots.clamp(u);
        Self { knots, span: knots.find_span(u), u }
    }

    /// Index of the control point that the first entry of a row belongs to.
    #[must_use]
    pub fn first(&self) -> usize {
        self.span - self.knots.degree()
    }

    /// The basis functions number `first()` to `first() + degree`.
    #[must_use]
    pub fn values(&self) -> BasisRow {
        self.rows::<1>()[0]
    }

    /// Values and derivatives of the basis functions number `first()` to `first() + degree`: the derivatives of order k in row k, from the functions
    /// themselves in row 0 up to any order.
    ///
    /// # Source
    /// Values: @markgraf2019 eq. 4, corrected: all spans except the last are half-open, so that the sum is 1 everywhere. Order of evaluation:
    /// @piegl1997 algorithm A2.2. Derivatives: @markgraf2019 eq. 10, from the functions of degree `degree - order` upwards.
    #[must_use]
    pub fn rows<const N: usize>(&self) -> [BasisRow; N] {
        let mut rows = [[0.0; MAX_DEGREE + 1]; N];
        self.write_rows(&mut rows);
        rows
    }

    /// [`Self::rows`] from order 0 to `order`.
    #[must_use]
    pub fn rows_up_to(&self, order: usize) -> Vec<BasisRow> {
        let mut rows = vec![[0.0; MAX_DEGREE + 1]; order + 1];
        self.write_rows(&mut rows);
        rows
    }

    fn write_rows(&self, rows: &mut [BasisRow]) {
        let (degree, u) = (self.knots.degree(), self.u);
        let mut lower: BasisRow = [0.0; MAX_DEGREE + 1];
        lower[0] = 1.0;
        for q in 0..=degree {
            if q > 0 {
                self.knots.recursion_step(self.span, q, &mut lower, |value, left, right| {
                    let share = value / (right - left);
                    [(right - u) * share, (u - left) * share]
                });
            }
            if let Some(row) = rows.get_mut(degree - q) {
                // The rest is 0. Copies of unknown or large sizes are calls.
                match (row.first_chunk_mut::<SHORT>(), lower.first_chunk::<SHORT>()) {
                    (Some(row), Some(lower)) if q < SHORT => *row = *lower,
                    _ => *row = lower,
                }
            }
        }
        for (order, row) in rows.iter_mut().enumerate().take(degree + 1) {
            self.differentiate(row, order);
        }
    }

    /// Derivatives of this order from the functions of degree `degree - order`.
    fn differentiate(&self, row: &mut BasisRow, order: usize) {
        let (degree, t) = (self.knots.degree(), self.knots.knots());
        for q in degree - order + 1..=degree {
            // Entry j of degree q - 1 belongs to function span - q + 1 + j: one further right than entry j of degree
            // q. Each quotient is used twice: at its own place and, negative, one to the left.
            let mut right = 0.0;
            for j in (0..q).rev() {
                let i = self.span + 1 + j - q;
                let quotient = q as f64 * row[j] / (t[i + q] - t[i]);
                row[j + 1] = quotient - right;
                right = quotient;
            }
            row[0] = -right;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clamped, clamped with a double knot, not clamped, and of degree 1.
    fn vectors() -> Vec<KnotVector> {
        let clamped = vec![0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0];
        let double = vec![-1.0, -1.0, -1.0, 0.5, 0.5, 0.6, 3.0, 3.0, 3.0];
        let open = vec![-3.0, -1.0, 0.0, 0.5, 2.0, 2.0, 3.5, 4.0, 7.0, 7.5, 8.0];
        let lines = vec![0.0, 0.0, 0.3, 1.0, 1.5, 1.5];
        [(3, clamped), (2, double), (4, open), (1, lines)]
            .map(|(p, t)| KnotVector::try_new(p, t).unwrap())
            .to_vec()
    }

    fn parameters(knots: &KnotVector) -> Vec<f64> {
        let [a, b] = knots.domain();
        (0..=40).map(|i| a + (b - a) * f64::from(i) / 40.0).chain(knots.breaks()).collect()
    }

    /// The recursion word for word (@markgraf2019 eq. 4 with half-open spans).
    fn recursive(t: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            return f64::from(u8::from(t[i] <= u && u < t[i + 1]));
        }
        let ratio = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
        ratio(u - t[i], t[i + p] - t[i]) * recursive(t, i, p - 1, u)
            + ratio(t[i + p + 1] - u, t[i + p + 1] - t[i + 1]) * recursive(t, i + 1, p - 1, u)
    }

    #[test]
    fn functions_are_those_of_the_recursion() {
        for knots in vectors() {
            for u in parameters(&knots).into_iter().filter(|u| *u < knots.domain()[1]) {
                let basis = BasisFunctions::at(&knots, u);
                let row = basis.values();
                for i in 0..knots.count() {
                    let inside = i >= basis.first() && i <= basis.first() + knots.degree();
                    let value = if inside { row[i - basis.first()] } else { 0.0 };
                    let expected = recursive(knots.knots(), i, knots.degree(), u);
                    assert!((value - expected).abs() < 1e-15, "{i} {u}: {value} {expected}");
                }
            }
        }
    }

    #[test]
    fn functions_sum_to_one_on_the_closed_domain_and_their_derivatives_to_zero() {
        for knots in vectors() {
            for u in parameters(&knots) {
                let basis = BasisFunctions::at(&knots, u);
                let values = basis.values();
                assert!(values.iter().all(|v| *v >= 0.0));
                assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{u}");
                for order in 1..=knots.degree() + 1 {
                    let row = basis.rows_up_to(order)[order];
                    let size = row.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                    assert!(row.iter().sum::<f64>().abs() <= 1e-14 * size, "{u} {order}");
                }
            }
        }
    }

    #[test]
    fn derivatives_are_differences_of_the_order_below() {
        for knots in vectors() {
            for pair in knots.breaks().windows(2) {
                for i in 1..10 {
                    let u = pair[0] + (pair[1] - pair[0]) * f64::from(i) / 10.0;
                    let h = 1e-6;
                    for order in 1..=knots.degree() {
                        let row = BasisFunctions::at(&knots, u).rows_up_to(order)[order];
                        let (low, high) =
                            (BasisFunctions::at(&knots, u - h), BasisFunctions::at(&knots, u + h));
                        let [low, high] = [low, high].map(|basis| basis.rows_up_to(order - 1)[order - 1]);
                        for j in 0..=knots.degree() {
                            let difference = (high[j] - low[j]) / (2.0 * h);
                            assert!((row[j] - difference).abs() < 1e-6 * (1.0 + row[j].abs()));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn bezier_knots_give_bernstein_polynomials() {
        let knots = KnotVector::clamped_uniform(3, 4).unwrap();
        let u: f64 = 0.3;
        let row = BasisFunctions::at(&knots, u).values();
        let bernstein = [0.343, 0.441, 0.189, 0.027];
        for (a, b) in row.iter().zip(bernstein) {
            assert!((a - b).abs() < 1e-15);
        }
        // Third derivatives: 3! times the differences of the unit vectors.
        let rows: [BasisRow; 5] = BasisFunctions::at(&knots, u).rows();
        assert_eq!(rows[3][..4], [-6.0, 18.0, -18.0, 6.0]);
        assert_eq!(rows[4], [0.0; MAX_DEGREE + 1]);
    }
}
