//! Bilinear interpolation.

use glanz_math::{DVec2, DVec3};

use super::lattice::locate;
use super::{Interpolant, InterpolatedTexture, Lattice};

/// Bilinear interpolant of the samples of a grid, constant beyond them.
pub(super) struct Bilinear {
    lattice: Lattice,
    rows: usize,
}

impl Bilinear {
    pub(super) fn new(lattice: &Lattice) -> Self {
        Self { rows: lattice.v().len(), lattice: lattice.clone() }
    }

    /// Row `i` at positions along u.
    fn row(&self, i: usize, places: &[(usize, f64)]) -> Vec<DVec3> {
        let row = self.lattice.rows().nth(i).unwrap_or_default();
        places.iter().map(|&(j, t)| between(row, j, t)).collect()
    }
}

/// Linear interpolation between the values j and j + 1; t is clamped to [0, 1].
fn between(values: &[DVec3], j: usize, t: f64) -> DVec3 {
    let at = |k: usize| values.get(k.min(values.len().saturating_sub(1))).copied().unwrap_or_default();
    at(j).lerp(at(j + 1), t.clamp(0.0, 1.0))
}

impl Interpolant for Bilinear {
    fn value(&self, point: DVec2) -> DVec3 {
        let (i, t) = locate(self.lattice.v(), point.y);
        let place = [locate(self.lattice.u(), point.x)];
        let at = |row: usize| self.row(row.min(self.rows - 1), &place)[0];
        at(i).lerp(at(i + 1), t.clamp(0.0, 1.0))
    }

    fn texture(&self, size: [usize; 2]) -> InterpolatedTexture {
        let middles = |n: usize| (0..n).map(move |x| (x as f64 + 0.5) / n as f64);
        let places: Vec<_> = middles(size[0]).map(|u| locate(self.lattice.u(), u)).collect();
        let rows: Vec<Vec<DVec3>> = (0..self.rows).map(|i| self.row(i, &places)).collect();
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for v in middles(size[1]) {
            let (i, t) = locate(self.lattice.v(), v);
            let t = t.clamp(0.0, 1.0);
            let (low, high) = (&rows[i], &rows[(i + 1).min(self.rows - 1)]);
            texels.extend(low.iter().zip(high).map(|(&a, &b)| a.lerp(b, t)));
        }
        InterpolatedTexture::from_texels(size, texels)
            .unwrap_or_else(|| InterpolatedTexture::from_function(size, |p| self.value(p)))
    }
}
