//! Matrices whose columns are short and contiguous.

/// A matrix whose columns have their nonzero entries in a few consecutive rows.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct BandedColumns {
    rows: usize,
    /// First row of each column, and index of its first entry in `entries`.
    columns: Vec<(usize, usize)>,
    entries: Vec<f64>,
}

impl BandedColumns {
    pub(crate) fn with_rows(rows: usize) -> Self {
        Self { rows, ..Self::default() }
    }

    /// Appends a column; `first` + the number of entries must not exceed the rows.
    pub(crate) fn push(&mut self, first: usize, entries: &[f64]) {
        self.columns.push((first, self.entries.len()));
        self.entries.extend_from_slice(entries);
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns.len()
    }

    /// First row and entries of column `j`; empty beyond the last column.
    #[must_use]
    pub fn column(&self, j: usize) -> (usize, &[f64]) {
        let Some(&(first, begin)) = self.columns.get(j) else { return (0, &[]) };
        let end = self.columns.get(j + 1).map_or(self.entries.len(), |c| c.1);
        (first, &self.entries[begin..end])
    }

    /// The entry in row `i` and column `j`; 0 outside.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let (first, entries) = self.column(j);
        i.checked_sub(first).and_then(|k| entries.get(k)).copied().unwrap_or(0.0)
    }

    /// Adds the product with `x` to `y`.
    pub(crate) fn add_product(&self, x: &[f64], y: &mut [f64]) {
        for (j, &factor) in x.iter().enumerate().take(self.columns()) {
            let (first, entries) = self.column(j);
            for (y, e) in y[first..].iter_mut().zip(entries) {
                *y += factor * e;
            }
        }
    }

    /// The product of the transposed matrix with `x`.
    pub(crate) fn transposed_product(&self, x: &[f64]) -> Vec<f64> {
        (0..self.columns())
            .map(|j| {
                let (first, entries) = self.column(j);
                entries.iter().zip(&x[first..]).map(|(e, x)| e * x).sum()
            })
            .collect()
    }
}
