//! Changes of basis.

use crate::basis::{BandedColumns, FunctionBasis, GaussLegendre, GramMatrix, check_length};
use crate::error::DensityError;

/// The refinement matrix P: column i holds the coefficients of the coarse function i in the fine basis, so that
/// Phi_coarse = Phi_fine P and c_fine = P c_coarse (@pietrek2001 equation C.1).
///
/// # Errors
/// [`DensityError::NotNested`] if the degrees differ or a coarse knot is missing among the fine ones.
///
/// # Source
/// Second algorithm of @cohen1980.
pub fn refinement(coarse: &FunctionBasis, fine: &FunctionBasis) -> Result<BandedColumns, DensityError> {
    let d = coarse.degree();
    let (tau, t) = (coarse.knots().knots(), fine.knots().knots());
    if fine.degree() != d || !contains(t, tau) {
        return Err(DensityError::NotNested);
    }
    let ratio = coarse.sum() / fine.sum();
    // For each coarse function, the first fine function with a nonzero coefficient, and the coefficients.
    let mut columns: Vec<(usize, Vec<f64>)> = vec![(0, Vec::new()); coarse.len()];
    for k in 0..fine.len() {
        let m = coarse.knots().find_span(t[k]);
        let row = coarse.knots().blossoms(m, |r| t[k + r]);
        for (i, &value) in row.iter().take(d + 1).enumerate() {
            let (first, entries) = &mut columns[m - d + i];
            // An exact zero is outside the support.
            if entries.is_empty() && value == 0.0 {
                continue;
            }
            if entries.is_empty() {
                *first = k;
            }
            entries.push(value * ratio);
        }
    }
    let mut matrix = BandedColumns::with_rows(fine.len());
    for (first, mut entries) in columns {
        while entries.last() == Some(&0.0) {
            entries.pop();
        }
        matrix.push(first, &entries);
    }
    Ok(matrix)
}

/// Whether the ascending list `all` contains the ascending list `some`, repetitions included.
fn contains(all: &[f64], some: &[f64]) -> bool {
    let mut rest = all.iter();
    some.iter().all(|s| rest.any(|a| a == s))
}

/// The conversion of coefficients from one basis to another: exact if the function lies in the other space, otherwise the
/// orthogonal projection in L2.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangeOfBasis {
    /// Column j holds the inner products of function j of the old basis with the functions of the new basis.
    mixed: BandedColumns,
    gram: GramMatrix,
}

impl ChangeOfBasis {
    /// The conversion from `from` to `to`, whose degrees and knots may differ.
    ///
    /// # Errors
    /// [`DensityError::Pivot`] as [`FunctionBasis::gram`].
    pub fn try_new(from: &FunctionBasis, to: &FunctionBasis) -> Result<Self, DensityError> {
        let mut breaks: Vec<f64> = from.knots().knots().iter().chain(to.knots().knots()).copied().collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        // Exact to degree 2 n - 1.
        let gauss = GaussLegendre::new((from.degree() + to.degree()) / 2 + 1);
        let mut columns: Vec<(usize, Vec<f64>)> = vec![(usize::MAX, Vec::new()); from.len()];
        for w in breaks.windows(2) {
            for &(node, weight) in gauss.rule() {
                let x = w[0] + (w[1] - w[0]) * node;
                let (first_old, old) = from.nonzero(x);
                let (first_new, new) = to.nonzero(x);
                for (j, o) in old.iter().enumerate().take(from.degree() + 1) {
                    let (first, entries) = &mut columns[first_old + j];
                    *first = (*first).min(first_new);
                    let begin = first_new - *first;
                    if entries.len() < begin + to.degree() + 1 {
                        entries.resize(begin + to.degree() + 1, 0.0);
                    }
                    for (e, n) in entries[begin..].iter_mut().zip(&new) {
                        *e += (w[1] - w[0]) * weight * o * n;
                    }
                }
            }
        }
        let mut mixed = BandedColumns::with_rows(to.len());
        for (first, entries) in columns {
            mixed.push(first, &entries);
        }
        Ok(Self { mixed, gram: to.gram()? })
    }

    /// The coefficients in the new basis.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn apply(&self, coefficients: &[f64]) -> Result<Vec<f64>, DensityError> {
        check_length(coefficients, self.mixed.columns())?;
        let mut changed = vec![0.0; self.mixed.rows()];
        self.mixed.add_product(coefficients, &mut changed);
        self.gram.solve(&mut changed);
        Ok(changed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::UnitKnots;

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|i| (2.3 * i as f64).sin()).collect()
    }

    #[test]
    fn refinement_keeps_the_function_on_any_knots() {
        for d in 0..=5 {
            let knots = |inner: &[f64]| {
                let mut all = vec![0.0; d + 1];
                all.extend_from_slice(inner);
                all.extend(vec![1.0; d + 1]);
                FunctionBasis::bspline(UnitKnots::try_new(d, all).unwrap())
            };
            let coarse = knots(&[0.1, 0.15, 0.8]);
            let fine =
                if d == 0 { knots(&[0.1, 0.15, 0.5, 0.8]) } else { knots(&[0.1, 0.1, 0.15, 0.5, 0.8, 0.99]) };
            let p = refinement(&coarse, &fine).unwrap();
            let c = wave(coarse.len());
            let mut refined = vec![0.0; fine.len()];
            p.add_product(&c, &mut refined);
            for i in 0..=500 {
                let x = f64::from(i) / 500.0;
                let error = coarse.evaluate(&c, x).unwrap() - fine.evaluate(&refined, x).unwrap();
                assert!(error.abs() < 1e-14, "degree {d} at {x}: {error}");
            }
        }
    }

    #[test]
    fn spaces_that_are_not_nested_are_refused() {
        let of = |degree, segments| FunctionBasis::bspline(UnitKnots::uniform(degree, segments).unwrap());
        assert_eq!(refinement(&of(1, 2), &of(1, 3)), Err(DensityError::NotNested));
        assert_eq!(refinement(&of(1, 2), &of(2, 4)), Err(DensityError::NotNested));
    }

    #[test]
    fn change_of_basis_is_exact_into_a_larger_space_of_another_degree() {
        let lines = FunctionBasis::uniform_bspline(1, 2).unwrap();
        // Cubics that may bend at the quarters lie over lines that do: knots there three times.
        let mut knots = vec![0.0; 4];
        knots.extend([0.25, 0.5, 0.75].iter().flat_map(|&t| [t; 3]));
        knots.extend(vec![1.0; 4]);
        let cubics = FunctionBasis::bspline(UnitKnots::try_new(3, knots).unwrap());
        let c = wave(lines.len());
        let changed = ChangeOfBasis::try_new(&lines, &cubics).unwrap().apply(&c).unwrap();
        let back = ChangeOfBasis::try_new(&cubics, &lines).unwrap().apply(&changed).unwrap();
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let error = lines.evaluate(&c, x).unwrap() - cubics.evaluate(&changed, x).unwrap();
            assert!(error.abs() < 1e-13, "{x}: {error}");
        }
        assert!(c.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    #[test]
    fn change_of_basis_into_a_smaller_space_is_the_proximum() {
        // x^2 in lines: (-1/6, 5/6) (appendix B of document 003, example B.20).
        let square = FunctionBasis::uniform_bspline(2, 0).unwrap();
        let lines = FunctionBasis::uniform_bspline(1, 0).unwrap();
        let found = ChangeOfBasis::try_new(&square, &lines).unwrap().apply(&[0.0, 0.0, 1.0]).unwrap();
        assert!((found[0] + 1.0 / 6.0).abs() < 1e-14 && (found[1] - 5.0 / 6.0).abs() < 1e-14);
    }
}
