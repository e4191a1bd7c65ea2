//! Grids of samples on lines of constant u and v.

use glanz_math::{DVec2, DVec3};

use super::Sample;

/// A value at each crossing of lines of constant u and v.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    u: Vec<f64>,
    v: Vec<f64>,
    /// Values by rows of constant v.
    values: Vec<DVec3>,
}

impl Lattice {
    /// A grid of lines of constant u and v in [0, 1], both strictly ascending, with finite values by rows of constant v; `None` if a
    /// condition is violated.
    #[must_use]
    pub fn new(u: Vec<f64>, v: Vec<f64>, values: Vec<DVec3>) -> Option<Self> {
        let ascending = |line: &[f64]| {
            !line.is_empty()
                && line.is_sorted_by(|a, b| a < b)
                && line.iter().all(|x| (0.0..=1.0).contains(x))
        };
        let fine = ascending(&u) && ascending(&v) && u.len().checked_mul(v.len()) == Some(values.len());
        (fine && values.iter().all(|value| value.is_finite())).then_some(Self { u, v, values })
    }

    /// Parameters of the lines of constant u.
    #[must_use]
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// Parameters of the lines of constant v.
    #[must_use]
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// The values of each line of constant v.
    pub(super) fn rows(&self) -> impl Iterator<Item = &[DVec3]> {
        self.values.chunks_exact(self.u.len())
    }

    /// Adds a line at each side of the square that has none, with the values of the nearest line.
    pub(super) fn with_border(&self) -> Option<Self> {
        // Each line with the number of the line that its values come from.
        let wider = |line: &[f64]| -> Vec<(f64, usize)> {
            let inner = line.iter().copied().zip(0..);
            let below = line.first().filter(|x| **x > 0.0).map(|_| (0.0, 0));
            let above = line.last().filter(|x| **x < 1.0).map(|_| (1.0, line.len() - 1));
            below.into_iter().chain(inner).chain(above).collect()
        };
        let (u, v) = (wider(&self.u), wider(&self.v));
        let rows: Vec<&[DVec3]> = self.rows().collect();
        let values = v.iter().flat_map(|&(_, i)| u.iter().map(move |&(_, j)| (i, j)));
        let values = values.map(|(i, j)| rows[i][j]).collect();
        Self::new(u.iter().map(|line| line.0).collect(), v.iter().map(|line| line.0).collect(), values)
    }

    /// All values as samples.
    #[must_use]
    pub fn samples(&self) -> Vec<Sample> {
        let points = self.v.iter().flat_map(|&v| self.u.iter().map(move |&u| DVec2::new(u, v)));
        points.zip(&self.values).map(|(point, &value)| Sample { point, value }).collect()
    }
}

/// Index i of the interval [line[i], line[i + 1]] that contains `x` or is nearest to it, and the position of `x` relative to it: 0 and 1 at its
/// ends. For a single line both are 0.
pub(super) fn locate(line: &[f64], x: f64) -> (usize, f64) {
    let last = line.len().saturating_sub(2);
    let i = line.partition_point(|&end| end <= x).saturating_sub(1).min(last);
    match line.get(i..i + 2) {
        Some(&[a, b]) => (i, (x - a) / (b - a)),
        _ => (0, 0.0),
    }
}
