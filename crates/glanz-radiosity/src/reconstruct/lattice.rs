//! Samples on lines of constant u and v.

use glanz_math::{DVec2, DVec3};

use super::Sample;

/// A value for each pair of a u and a v.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    u: Vec<f64>,
    v: Vec<f64>,
    /// Rows of u one after the other.
    values: Vec<DVec3>,
}

impl Lattice {
    /// Lines of constant u and v in [0, 1], both ascending, and a value for each pair, u fastest; `None` if they are not so.
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

    /// The lines of constant u.
    #[must_use]
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// The lines of constant v.
    #[must_use]
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// The values of one line of constant v.
    pub(super) fn rows(&self) -> impl Iterator<Item = &[DVec3]> {
        self.values.chunks_exact(self.u.len())
    }

    /// With a line more at each side of the square where there is none, of the values next to it.
    pub(super) fn with_border(&self) -> Option<Self> {
        // Each line with the number of the one whose values it has.
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

    /// All samples.
    #[must_use]
    pub fn samples(&self) -> Vec<Sample> {
        let points = self.v.iter().flat_map(|&v| self.u.iter().map(move |&u| DVec2::new(u, v)));
        points.zip(&self.values).map(|(point, &value)| Sample { point, value }).collect()
    }
}

/// The interval [line[i], line[i + 1]] that `x` is in or next to, and its place in it: 0 and 1 at the ends, beyond them outside. Of a
/// single line: 0.
pub(super) fn locate(line: &[f64], x: f64) -> (usize, f64) {
    let last = line.len().saturating_sub(2);
    let i = line.partition_point(|&end| end <= x).saturating_sub(1).min(last);
    match line.get(i..i + 2) {
        Some(&[a, b]) => (i, (x - a) / (b - a)),
        _ => (0, 0.0),
    }
}
