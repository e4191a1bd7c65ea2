//! Filter banks between two levels.

use crate::basis::{BandedColumns, FunctionBasis, GramMatrix, refinement};
use crate::error::DensityError;
use crate::multiresolution::wavelets::wavelets;

/// The analysis and synthesis filters between a level and the next finer one.
///
/// Synthesis is c_fine = P c_coarse + Q d, analysis c_coarse = A c_fine and d = B c_fine; \[A; B\] is the inverse of
/// \[P | Q\] (@pietrek2001 equation C.4). P and Q are banded; A and B are full, and are applied by solving banded systems:
/// as the wavelets are orthogonal to the coarse functions, A = (P^T G P)^-1 P^T G and B = (Q^T G Q)^-1 Q^T G with the
/// matrix G of the inner products of the fine basis.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterBank {
    p: BandedColumns,
    q: BandedColumns,
    fine: GramMatrix,
    coarse: GramMatrix,
    wavelets: GramMatrix,
}

impl FilterBank {
    /// The filters between two bases, of which the finer one halves every segment of the coarser one.
    ///
    /// # Errors
    /// [`DensityError::NotNested`], [`DensityError::Pivot`].
    pub(super) fn try_new(coarse: &FunctionBasis, fine: &FunctionBasis) -> Result<Self, DensityError> {
        let p = refinement(coarse, fine)?;
        let gram = fine.gram()?;
        let q = wavelets(coarse, fine, &p, &gram);
        let wavelets = gram_of(&q, &gram)?;
        Ok(Self { p, q, fine: gram, coarse: coarse.gram()?, wavelets })
    }

    /// The matrix P (fine by coarse): coarse functions in the fine basis.
    #[must_use]
    pub fn p(&self) -> &BandedColumns {
        &self.p
    }

    /// The matrix Q (fine by wavelets): wavelets of norm 1 in the fine basis.
    #[must_use]
    pub fn q(&self) -> &BandedColumns {
        &self.q
    }

    /// A and B as full matrices, by rows.
    #[must_use]
    pub fn analysis_filters(&self) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let rows = |columns: Vec<Vec<f64>>, count: usize| {
            (0..count).map(|i| columns.iter().map(|column| column[i]).collect()).collect()
        };
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for j in 0..self.p.rows() {
            let mut unit = vec![0.0; self.p.rows()];
            unit[j] = 1.0;
            let (c, d) = self.split(&unit);
            a.push(c);
            b.push(d);
        }
        (rows(a, self.p.columns()), rows(b, self.q.columns()))
    }

    /// P c: the same function in the fine basis.
    pub(crate) fn refined(&self, coarse: &[f64]) -> Vec<f64> {
        let mut fine = vec![0.0; self.p.rows()];
        self.p.add_product(coarse, &mut fine);
        fine
    }

    /// A c and B c: the orthogonal projection to the coarse basis, and the details.
    pub(super) fn split(&self, fine: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut coarse, mut details) = self.projections(fine);
        // One step of iterative refinement, since the inner products are rounded.
        let mut missing = fine.to_vec();
        missing.iter_mut().zip(self.join(&coarse, &details)).for_each(|(m, j)| *m -= j);
        let (c, d) = self.projections(&missing);
        coarse.iter_mut().zip(c).for_each(|(a, b)| *a += b);
        details.iter_mut().zip(d).for_each(|(a, b)| *a += b);
        (coarse, details)
    }

    /// The projections on the coarse functions and on the wavelets.
    fn projections(&self, fine: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let dual = self.fine.multiply(fine);
        let mut coarse = self.p.transposed_product(&dual);
        self.coarse.solve(&mut coarse);
        let mut details = self.q.transposed_product(&dual);
        self.wavelets.solve(&mut details);
        (coarse, details)
    }

    /// P c + Q d: the inverse of [`FilterBank::split`].
    pub(super) fn join(&self, coarse: &[f64], details: &[f64]) -> Vec<f64> {
        let mut fine = self.refined(coarse);
        self.q.add_product(details, &mut fine);
        fine
    }
}

/// The matrix Q^T G Q.
fn gram_of(q: &BandedColumns, gram: &GramMatrix) -> Result<GramMatrix, DensityError> {
    let count = q.columns();
    // Columns farther apart have the inner product 0: G couples neighbours up to its band.
    let reach = |k: usize| {
        let (first, entries) = q.column(k);
        let end = first + entries.len() + gram.band();
        (k + 1..count).take_while(|&l| q.column(l).0 < end).count()
    };
    let band = (0..count).map(reach).max().unwrap_or(0);
    let mut entries = vec![0.0; count * (band + 1)];
    for i in 0..count {
        for k in 0..=band.min(i) {
            entries[i * (band + 1) + k] = gram.product(q.column(i), q.column(i - k));
        }
    }
    GramMatrix::try_new(count, band, entries)
}
