//! Multiresolution analyses and the wavelet transform.

use crate::basis::{FunctionBasis, check_length};
use crate::error::DensityError;
use crate::multiresolution::FilterBank;

/// Scaling bases on levels 0 to [`MultiResolution::finest`], and the filter banks between them.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiResolution {
    /// Scaling bases from coarse to fine, at least one.
    bases: Vec<FunctionBasis>,
    /// Filter bank j is between levels j and j + 1.
    filter_banks: Vec<FilterBank>,
}

impl MultiResolution {
    /// Haar's analysis: orthonormal boxes on 2^level equal segments.
    ///
    /// # Errors
    /// [`DensityError::Level`] above 16.
    pub fn haar(finest: usize) -> Result<Self, DensityError> {
        Self::from_bases(finest, FunctionBasis::haar)
    }

    /// B-splines of `degree` on 2^level equal segments, with semiorthogonal wavelets of minimal support and norm 1.
    ///
    /// # Errors
    /// [`DensityError::Degree`]; [`DensityError::Level`] above 16.
    pub fn bspline(degree: usize, finest: usize) -> Result<Self, DensityError> {
        Self::from_bases(finest, |level| FunctionBasis::uniform_bspline(degree, level))
    }

    fn from_bases(
        finest: usize,
        basis: impl Fn(usize) -> Result<FunctionBasis, DensityError>,
    ) -> Result<Self, DensityError> {
        /// 2^16 segments: finer than any density that can be fitted to samples.
        const HIGHEST: usize = 16;
        if finest > HIGHEST {
            return Err(DensityError::Level { level: finest, lowest: 0, highest: HIGHEST });
        }
        let bases = (0..=finest).map(basis).collect::<Result<Vec<_>, _>>()?;
        let filter_banks =
            bases.windows(2).map(|w| FilterBank::try_new(&w[0], &w[1])).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { bases, filter_banks })
    }

    /// The finest level.
    #[must_use]
    pub fn finest(&self) -> usize {
        self.filter_banks.len()
    }

    /// The scaling basis of a level.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn basis(&self, level: usize) -> Result<&FunctionBasis, DensityError> {
        self.bases.get(level).ok_or(DensityError::Level { level, lowest: 0, highest: self.finest() })
    }

    /// The filter bank between levels `level` - 1 and `level`.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn filter_bank(&self, level: usize) -> Result<&FilterBank, DensityError> {
        let filter_bank = level.checked_sub(1).and_then(|j| self.filter_banks.get(j));
        filter_bank.ok_or(DensityError::Level { level, lowest: 1, highest: self.finest() })
    }

    /// Converts coefficients from level `from` to level `to`, which must not be coarser: a synthesis without details.
    ///
    /// # Errors
    /// [`DensityError::Level`], [`DensityError::Length`].
    pub fn refine(&self, coefficients: &[f64], from: usize, to: usize) -> Result<Vec<f64>, DensityError> {
        if to < from {
            return Err(DensityError::Level { level: to, lowest: from, highest: self.finest() });
        }
        check_length(coefficients, self.basis(from)?.len())?;
        let mut refined = coefficients.to_vec();
        for level in from + 1..=to {
            refined = self.filter_bank(level)?.refined(&refined);
        }
        Ok(refined)
    }

    /// The value at `x` of wavelet `k` between levels `level` - 1 and `level`; 0 beyond the last wavelet and outside [0, 1].
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn wavelet(&self, level: usize, k: usize, x: f64) -> Result<f64, DensityError> {
        let filter_bank = self.filter_bank(level)?;
        let mut coefficients = vec![0.0; filter_bank.q().rows()];
        let (first, values) = filter_bank.q().column(k);
        coefficients[first..first + values.len()].copy_from_slice(values);
        self.basis(level)?.evaluate(&coefficients, x)
    }

    /// The wavelet transform in place: coefficients c on `level` become c^0, d^0, d^1, ..., in this order.
    ///
    /// The time is proportional to their number.
    ///
    /// # Errors
    /// [`DensityError::Level`], [`DensityError::Length`].
    pub fn transform(&self, coefficients: &mut [f64], level: usize) -> Result<(), DensityError> {
        check_length(coefficients, self.basis(level)?.len())?;
        for j in (1..=level).rev() {
            let filter_bank = self.filter_bank(j)?;
            self.write(&mut coefficients[..filter_bank.p().rows()], |c| filter_bank.split(c));
        }
        Ok(())
    }

    /// The inverse of [`MultiResolution::transform`].
    ///
    /// # Errors
    /// [`DensityError::Level`], [`DensityError::Length`].
    pub fn inverse_transform(&self, coefficients: &mut [f64], level: usize) -> Result<(), DensityError> {
        check_length(coefficients, self.basis(level)?.len())?;
        for j in 1..=level {
            let filter_bank = self.filter_bank(j)?;
            let (c, d) = coefficients[..filter_bank.p().rows()].split_at(filter_bank.p().columns());
            let joined = filter_bank.join(c, d);
            coefficients[..joined.len()].copy_from_slice(&joined);
        }
        Ok(())
    }

    fn write(&self, coefficients: &mut [f64], split: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>)) {
        let (c, d) = split(coefficients);
        for (to, from) in coefficients.iter_mut().zip(c.into_iter().chain(d)) {
            *to = from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{FILTERS, matrix};

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|i| (2.3 * i as f64).sin()).collect()
    }

    fn all() -> Vec<MultiResolution> {
        let splines = (0..=3).map(|d| MultiResolution::bspline(d, 8).unwrap());
        splines.chain([MultiResolution::haar(8).unwrap()]).collect()
    }

    #[test]
    fn filters_are_the_exact_ones_up_to_the_signs_of_wavelets() {
        for case in FILTERS {
            let analysis = MultiResolution::bspline(case.degree, case.level).unwrap();
            let filter_bank = analysis.filter_bank(case.level).unwrap();
            let name = format!("degree {}, level {}", case.degree, case.level);
            for (i, row) in matrix(case.p).iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    assert!((filter_bank.p().entry(i, j) - expected).abs() < 1e-15, "{name}: P {i} {j}");
                }
            }
            let q = matrix(case.q);
            for (k, norm) in case.norms.iter().enumerate() {
                let column: Vec<f64> = q.iter().map(|row| row[k] / norm).collect();
                let largest =
                    column.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap().0;
                let sign = (filter_bank.q().entry(largest, k) * column[largest]).signum();
                for (i, expected) in column.iter().enumerate() {
                    let found = sign * filter_bank.q().entry(i, k);
                    assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{name}: Q {i} {k}");
                }
            }
        }
    }

    #[test]
    fn haar_filters_are_one_over_root_two() {
        // B.haar.P_Q: P[2i, i] = P[2i + 1, i] = Q[2i, i] = -Q[2i + 1, i]; A and B are their transposes.
        let haar = MultiResolution::haar(3).unwrap();
        for level in 1..=3 {
            let filter_bank = haar.filter_bank(level).unwrap();
            let (a, b) = filter_bank.analysis_filters();
            for i in 0..filter_bank.p().rows() {
                for j in 0..filter_bank.p().columns() {
                    let p = if i / 2 == j { std::f64::consts::FRAC_1_SQRT_2 } else { 0.0 };
                    // The wavelets of the second half are mirrored.
                    let mirrored = if 2 * j >= filter_bank.p().columns() && level > 1 { -1.0 } else { 1.0 };
                    let q = if i % 2 == 0 { p } else { -p } * mirrored;
                    for (found, expected) in [
                        (filter_bank.p().entry(i, j), p),
                        (filter_bank.q().entry(i, j), q),
                        (a[j][i], p),
                        (b[j][i], q),
                    ] {
                        assert!((found - expected).abs() < 1e-15, "level {level}: {i} {j}");
                    }
                }
            }
        }
    }

    #[test]
    fn analysis_filters_invert_synthesis_filters() {
        for analysis in all() {
            for level in 1..=8 {
                let filter_bank = analysis.filter_bank(level).unwrap();
                let (a, b) = filter_bank.analysis_filters();
                let (coarse, count) = (filter_bank.p().columns(), filter_bank.q().columns());
                assert_eq!(coarse + count, filter_bank.p().rows());
                let mut worst = 0.0_f64;
                for j in 0..coarse + count {
                    let (first, column) = if j < coarse {
                        filter_bank.p().column(j)
                    } else {
                        filter_bank.q().column(j - coarse)
                    };
                    for (i, row) in a.iter().chain(&b).enumerate() {
                        let product: f64 = column.iter().zip(&row[first..]).map(|(c, r)| c * r).sum();
                        let delta = if i == j { 1.0 } else { 0.0 };
                        worst = worst.max((product - delta).abs());
                    }
                }
                assert!(
                    worst < 1e-12,
                    "degree {} level {level}: {worst:e}",
                    analysis.basis(0).unwrap().degree()
                );
            }
        }
    }

    #[test]
    fn higher_degrees_are_orthogonal_and_invertible() {
        for degree in 4..=7 {
            let analysis = MultiResolution::bspline(degree, 6).unwrap();
            let original = wave(analysis.basis(6).unwrap().len());
            let mut c = original.clone();
            analysis.transform(&mut c, 6).unwrap();
            analysis.inverse_transform(&mut c, 6).unwrap();
            assert!(c.iter().zip(&original).all(|(a, b)| (a - b).abs() < 1e-12), "degree {degree}");
            let filter_bank = analysis.filter_bank(6).unwrap();
            let gram = analysis.basis(6).unwrap().gram().unwrap();
            for k in 0..filter_bank.q().columns() {
                for i in 0..filter_bank.p().columns() {
                    let product = gram.product(filter_bank.p().column(i), filter_bank.q().column(k));
                    assert!(product.abs() < 1e-13, "degree {degree}: {i} {k}: {product:e}");
                }
            }
        }
    }

    #[test]
    fn wavelets_are_orthogonal_to_coarse_functions_short_and_of_norm_one() {
        for analysis in all() {
            for level in 1..=8 {
                let filter_bank = analysis.filter_bank(level).unwrap();
                let (coarse, fine) = (analysis.basis(level - 1).unwrap(), analysis.basis(level).unwrap());
                let gram = fine.gram().unwrap();
                for k in 0..filter_bank.q().columns() {
                    let (first, values) = filter_bank.q().column(k);
                    assert!(values.len() <= 3 * fine.degree() + 2, "level {level} wavelet {k}");
                    let mut wavelet = vec![0.0; fine.len()];
                    wavelet[first..first + values.len()].copy_from_slice(values);
                    let dual = gram.multiply(&wavelet);
                    let norm: f64 = wavelet.iter().zip(&dual).map(|(a, b)| a * b).sum();
                    assert!((norm - 1.0).abs() < 1e-13);
                    for (product, w) in filter_bank.p().transposed_product(&dual).iter().zip(coarse.weights())
                    {
                        // The norm of the coarse function is about the root of its weight.
                        assert!(
                            product.abs() < 1e-14 * w.sqrt().max(1.0),
                            "level {level} wavelet {k}: {product:e}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn wavelets_have_degree_plus_one_vanishing_moments() {
        let gauss = crate::basis::GaussLegendre::new(6);
        for degree in 0..=3 {
            let analysis = MultiResolution::bspline(degree, 4).unwrap();
            let fine = analysis.basis(4).unwrap();
            for k in 0..8 {
                for power in 0..=degree as i32 {
                    let moment: f64 = fine
                        .knots()
                        .spans()
                        .map(|(_, a, b)| {
                            gauss.integrate(a, b, |x| analysis.wavelet(4, k, x).unwrap() * x.powi(power))
                        })
                        .sum();
                    assert!(moment.abs() < 1e-14, "degree {degree} wavelet {k} power {power}: {moment:e}");
                }
            }
        }
    }

    #[test]
    fn inverse_transform_restores_and_keeps_the_function() {
        for analysis in all() {
            let basis = analysis.basis(6).unwrap();
            let original = wave(basis.len());
            let mut c = original.clone();
            analysis.transform(&mut c, 6).unwrap();
            // The function as c^0 and the wavelets of all levels.
            for i in 0..=50 {
                let x = f64::from(i) / 50.0;
                let coarse = analysis.basis(0).unwrap();
                let mut value = coarse.evaluate(&c[..coarse.len()], x).unwrap();
                for level in 1..=6 {
                    let begin = analysis.basis(level - 1).unwrap().len();
                    for (k, d) in c[begin..analysis.basis(level).unwrap().len()].iter().enumerate() {
                        value += d * analysis.wavelet(level, k, x).unwrap();
                    }
                }
                assert!((value - basis.evaluate(&original, x).unwrap()).abs() < 1e-12);
            }
            analysis.inverse_transform(&mut c, 6).unwrap();
            assert!(c.iter().zip(&original).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }

    #[test]
    fn coarser_coefficients_are_those_of_the_proximum() {
        let analysis = MultiResolution::bspline(2, 5).unwrap();
        let fine = analysis.basis(5).unwrap();
        let mut c = wave(fine.len());
        let (coarse, _) = analysis.filter_bank(5).unwrap().split(&c);
        let basis = analysis.basis(4).unwrap();
        // Quadrature on the fine cells: 3 nodes on half a coarse segment are a rule on fine ones.
        let change = crate::basis::ChangeOfBasis::try_new(fine, basis).unwrap();
        let projection = change.apply(&c).unwrap();
        assert!(coarse.iter().zip(&projection).all(|(a, b)| (a - b).abs() < 1e-12));
        // A coarse function has no details.
        c = analysis.refine(&coarse, 4, 5).unwrap();
        let (same, details) = analysis.filter_bank(5).unwrap().split(&c);
        assert!(same.iter().zip(&coarse).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(details.iter().all(|d| d.abs() < 1e-13));
    }

    #[test]
    fn invalid_levels_and_lengths_are_refused() {
        let analysis = MultiResolution::haar(3).unwrap();
        assert!(matches!(analysis.basis(4), Err(DensityError::Level { level: 4, .. })));
        assert!(matches!(analysis.filter_bank(0), Err(DensityError::Level { level: 0, .. })));
        assert!(matches!(
            analysis.transform(&mut [0.0; 7], 3),
            Err(DensityError::Length { found: 7, expected: 8 })
        ));
        assert!(matches!(
            analysis.refine(&[0.0; 4], 2, 1),
            Err(DensityError::Level { level: 1, lowest: 2, .. })
        ));
        assert!(MultiResolution::bspline(8, 1).is_err() && MultiResolution::haar(17).is_err());
    }
}
