//! The levels of an analysis, and the wavelet transformation.

use crate::basis::{Basis, check_length};
use crate::error::DensityError;
use crate::multiresolution::Step;

/// Scaling bases on levels 0 to [`MultiResolution::finest`], and the filters between them.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiResolution {
    /// From coarse to fine, at least one.
    bases: Vec<Basis>,
    /// `steps[j]` goes between levels j and j + 1.
    steps: Vec<Step>,
}

impl MultiResolution {
    /// Haar's analysis: orthonormal boxes on 2^level equal segments.
    ///
    /// # Errors
    /// [`DensityError::Level`] above 16.
    pub fn haar(finest: usize) -> Result<Self, DensityError> {
        Self::of_bases(finest, Basis::haar)
    }

    /// B-splines of `degree` on 2^level equal segments, with semiorthogonal wavelets of minimal support and norm 1.
    ///
    /// # Errors
    /// [`DensityError::Degree`]; [`DensityError::Level`] above 16.
    pub fn bspline(degree: usize, finest: usize) -> Result<Self, DensityError> {
        Self::of_bases(finest, |level| Basis::uniform_bspline(degree, level))
    }

    fn of_bases(
        finest: usize,
        basis: impl Fn(usize) -> Result<Basis, DensityError>,
    ) -> Result<Self, DensityError> {
        /// 2^16 segments: finer than any density that samples can teach.
        const HIGHEST: usize = 16;
        if finest > HIGHEST {
            return Err(DensityError::Level { level: finest, lowest: 0, highest: HIGHEST });
        }
        let bases = (0..=finest).map(basis).collect::<Result<Vec<_>, _>>()?;
        let steps = bases.windows(2).map(|w| Step::try_new(&w[0], &w[1])).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { bases, steps })
    }

    /// The finest level.
    #[must_use]
    pub fn finest(&self) -> usize {
        self.steps.len()
    }

    /// The scaling basis of a level.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn basis(&self, level: usize) -> Result<&Basis, DensityError> {
        self.bases.get(level).ok_or(DensityError::Level { level, lowest: 0, highest: self.finest() })
    }

    /// The filters between levels `level` - 1 and `level`.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn step(&self, level: usize) -> Result<&Step, DensityError> {
        let step = level.checked_sub(1).and_then(|j| self.steps.get(j));
        step.ok_or(DensityError::Level { level, lowest: 1, highest: self.finest() })
    }

    /// The coefficients on level `to` of the function with these coefficients on level `from`, no finer: a synthesis
    /// without details.
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
            refined = self.step(level)?.refined(&refined);
        }
        Ok(refined)
    }

    /// The value at `x` of wavelet `k` between levels `level` - 1 and `level`; 0 if there is none such, and outside
    /// [0, 1].
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn wavelet(&self, level: usize, k: usize, x: f64) -> Result<f64, DensityError> {
        let step = self.step(level)?;
        let mut coefficients = vec![0.0; step.q().rows()];
        let (first, values) = step.q().column(k);
        coefficients[first..first + values.len()].copy_from_slice(values);
        self.basis(level)?.evaluate(&coefficients, x)
    }

    /// The wavelet transformation: coefficients c on `level` become c^0, d^0, d^1, ..., in this order and place.
    ///
    /// Takes time proportional to their number.
    ///
    /// # Errors
    /// [`DensityError::Level`], [`DensityError::Length`].
    pub fn transform(&self, coefficients: &mut [f64], level: usize) -> Result<(), DensityError> {
        check_length(coefficients, self.basis(level)?.len())?;
        for j in (1..=level).rev() {
            let step = self.step(j)?;
            self.write(&mut coefficients[..step.p().rows()], |c| step.split(c));
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
            let step = self.step(j)?;
            let (c, d) = coefficients[..step.p().rows()].split_at(step.p().columns());
            let joined = step.join(c, d);
            coefficients[..joined.len()].copy_from_slice(&joined);
        }
        Ok(())
    }

    fn write(&self, place: &mut [f64], split: impl Fn(&[f64]) -> (Vec<f64>, Vec<f64>)) {
        let (c, d) = split(place);
        for (to, from) in place.iter_mut().zip(c.into_iter().chain(d)) {
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
            let step = analysis.step(case.level).unwrap();
            let name = format!("degree {}, level {}", case.degree, case.level);
            for (i, row) in matrix(case.p).iter().enumerate() {
                for (j, expected) in row.iter().enumerate() {
                    assert!((step.p().entry(i, j) - expected).abs() < 1e-15, "{name}: P {i} {j}");
                }
            }
            let q = matrix(case.q);
            for (k, norm) in case.norms.iter().enumerate() {
                let column: Vec<f64> = q.iter().map(|row| row[k] / norm).collect();
                let largest =
                    column.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap().0;
                let sign = (step.q().entry(largest, k) * column[largest]).signum();
                for (i, expected) in column.iter().enumerate() {
                    let found = sign * step.q().entry(i, k);
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
            let step = haar.step(level).unwrap();
            let (a, b) = step.analysis_filters();
            for i in 0..step.p().rows() {
                for j in 0..step.p().columns() {
                    let p = if i / 2 == j { std::f64::consts::FRAC_1_SQRT_2 } else { 0.0 };
                    // The wavelets of the second half are mirrored.
                    let mirrored = if 2 * j >= step.p().columns() && level > 1 { -1.0 } else { 1.0 };
                    let q = if i % 2 == 0 { p } else { -p } * mirrored;
                    for (found, expected) in
                        [(step.p().entry(i, j), p), (step.q().entry(i, j), q), (a[j][i], p), (b[j][i], q)]
                    {
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
                let step = analysis.step(level).unwrap();
                let (a, b) = step.analysis_filters();
                let (coarse, count) = (step.p().columns(), step.q().columns());
                assert_eq!(coarse + count, step.p().rows());
                let mut worst = 0.0_f64;
                for j in 0..coarse + count {
                    let (first, column) =
                        if j < coarse { step.p().column(j) } else { step.q().column(j - coarse) };
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
    fn higher_degrees_are_orthogonal_and_come_back_too() {
        for degree in 4..=7 {
            let analysis = MultiResolution::bspline(degree, 6).unwrap();
            let original = wave(analysis.basis(6).unwrap().len());
            let mut c = original.clone();
            analysis.transform(&mut c, 6).unwrap();
            analysis.inverse_transform(&mut c, 6).unwrap();
            assert!(c.iter().zip(&original).all(|(a, b)| (a - b).abs() < 1e-12), "degree {degree}");
            let step = analysis.step(6).unwrap();
            let gram = analysis.basis(6).unwrap().gram().unwrap();
            for k in 0..step.q().columns() {
                for i in 0..step.p().columns() {
                    let product = gram.product(step.p().column(i), step.q().column(k));
                    assert!(product.abs() < 1e-13, "degree {degree}: {i} {k}: {product:e}");
                }
            }
        }
    }

    #[test]
    fn wavelets_are_orthogonal_to_coarse_functions_short_and_of_norm_one() {
        for analysis in all() {
            for level in 1..=8 {
                let step = analysis.step(level).unwrap();
                let (coarse, fine) = (analysis.basis(level - 1).unwrap(), analysis.basis(level).unwrap());
                let gram = fine.gram().unwrap();
                for k in 0..step.q().columns() {
                    let (first, values) = step.q().column(k);
                    assert!(values.len() <= 3 * fine.degree() + 2, "level {level} wavelet {k}");
                    let mut wavelet = vec![0.0; fine.len()];
                    wavelet[first..first + values.len()].copy_from_slice(values);
                    let dual = gram.multiply(&wavelet);
                    let norm: f64 = wavelet.iter().zip(&dual).map(|(a, b)| a * b).sum();
                    assert!((norm - 1.0).abs() < 1e-13);
                    for (product, w) in step.p().transposed_product(&dual).iter().zip(coarse.weights()) {
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
    fn wavelets_have_as_many_vanishing_moments_as_the_degree_asks_for() {
        let gauss = crate::basis::GaussLegendre::new(6);
        for degree in 0..=3 {
            let analysis = MultiResolution::bspline(degree, 4).unwrap();
            let fine = analysis.basis(4).unwrap();
            for k in 0..8 {
                for power in 0..=degree as i32 {
                    let moment: f64 = fine
                        .knots()
                        .segments()
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
    fn transformation_comes_back_and_keeps_the_function() {
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
        let (coarse, _) = analysis.step(5).unwrap().analyse(&c).unwrap();
        let basis = analysis.basis(4).unwrap();
        // Quadrature on the fine cells: 3 nodes on half a coarse segment are a rule on fine ones.
        let change = crate::basis::ChangeOfBasis::try_new(fine, basis).unwrap();
        let proximum = change.apply(&c).unwrap();
        assert!(coarse.iter().zip(&proximum).all(|(a, b)| (a - b).abs() < 1e-12));
        // A coarse function has no details.
        c = analysis.refine(&coarse, 4, 5).unwrap();
        let (same, details) = analysis.step(5).unwrap().analyse(&c).unwrap();
        assert!(same.iter().zip(&coarse).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(details.iter().all(|d| d.abs() < 1e-13));
    }

    #[test]
    fn levels_and_lengths_that_are_not_there_are_refused() {
        let analysis = MultiResolution::haar(3).unwrap();
        assert!(matches!(analysis.basis(4), Err(DensityError::Level { level: 4, .. })));
        assert!(matches!(analysis.step(0), Err(DensityError::Level { level: 0, .. })));
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
