//! Interpolation by natural cubic splines along u, then v.

use glanz_math::{DVec2, DVec3};

use super::lattice::locate;
use super::{Interpolant, InterpolatedTexture, Lattice};

/// Splines along each row of a grid, and across their values.
///
/// # Source
/// @pietrek2001 section 4.4.2.
pub(super) struct Spline {
    lattice: Lattice,
    /// Second derivatives of each row.
    moments: Vec<Vec<DVec3>>,
    /// Equations of the splines across.
    across: SplineSystem,
}

impl Spline {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let along = SplineSystem::new(lattice.u());
        let moments = lattice.rows().map(|row| along.moments(row)).collect();
        Self { moments, across: SplineSystem::new(lattice.v()), lattice: lattice.clone() }
    }

    /// Values of all rows at `u`, which the spline across interpolates.
    fn column(&self, u: f64) -> Vec<DVec3> {
        let rows = self.lattice.rows().zip(&self.moments);
        rows.map(|(row, moments)| evaluate(self.lattice.u(), row, moments, u)).collect()
    }
}

impl Interpolant for Spline {
    fn value(&self, point: DVec2) -> DVec3 {
        let column = self.column(point.x);
        evaluate(self.lattice.v(), &column, &self.across.moments(&column), point.y)
    }

    fn texture(&self, size: [usize; 2]) -> InterpolatedTexture {
        let mut texels = vec![DVec3::ZERO; size[0] * size[1]];
        for x in 0..size[0] {
            let column = self.column((x as f64 + 0.5) / size[0] as f64);
            let moments = self.across.moments(&column);
            for (y, texel) in texels.iter_mut().skip(x).step_by(size[0]).enumerate() {
                *texel = evaluate(self.lattice.v(), &column, &moments, (y as f64 + 0.5) / size[1] as f64);
            }
        }
        InterpolatedTexture::from_texels(size, texels)
            .unwrap_or_else(|| InterpolatedTexture::from_function(size, |p| self.value(p)))
    }
}

/// Factored tridiagonal equations for the second derivatives at the knots, which are 0 at both ends.
struct SplineSystem {
    knots: Vec<f64>,
    /// Reciprocal pivot of each inner knot.
    inverses: Vec<f64>,
}

impl SplineSystem {
    fn new(knots: &[f64]) -> Self {
        let mut inverses: Vec<f64> = Vec::new();
        for line in knots.windows(3) {
            let (before, after) = (line[1] - line[0], line[2] - line[1]);
            let eliminated = inverses.last().map_or(0.0, |inverse| before * before * inverse);
            inverses.push(1.0 / (2.0 * (before + after) - eliminated));
        }
        Self { knots: knots.to_vec(), inverses }
    }

    fn moments(&self, values: &[DVec3]) -> Vec<DVec3> {
        let mut moments = vec![DVec3::ZERO; self.knots.len()];
        // From M[i - 1] h + 2 M[i] (h + k) + M[i + 1] k = 6 (slope after - slope before).
        let mut before = DVec3::ZERO;
        for (i, inverse) in self.inverses.iter().enumerate() {
            let (h, k) = (self.knots[i + 1] - self.knots[i], self.knots[i + 2] - self.knots[i + 1]);
            let bend = (values[i + 2] - values[i + 1]) / k - (values[i + 1] - values[i]) / h;
            before = (6.0 * bend - h * before) * *inverse;
            moments[i + 1] = before;
        }
        for i in (0..self.inverses.len().saturating_sub(1)).rev() {
            let k = self.knots[i + 2] - self.knots[i + 1];
            let after = moments[i + 2];
            moments[i + 1] -= k * self.inverses[i] * after;
        }
        moments
    }
}

/// The spline at `x`; linear beyond the knots.
fn evaluate(knots: &[f64], values: &[DVec3], moments: &[DVec3], x: f64) -> DVec3 {
    let (i, b) = locate(knots, x);
    let (Some(&[low, high]), Some(&[from, to])) = (knots.get(i..i + 2), values.get(i..i + 2)) else {
        return values.first().copied().unwrap_or_default();
    };
    let h = high - low;
    let [start, end] = [moments[i], moments[i + 1]];
    if !(0.0..=1.0).contains(&b) {
        let chord = to - from;
        // The curvature at the end is 0.
        return if b < 0.0 {
            from + b * (chord - h * h / 6.0 * end)
        } else {
            to + (b - 1.0) * (chord + h * h / 6.0 * start)
        };
    }
    let a = 1.0 - b;
    a * from + b * to + h * h / 6.0 * ((a * a * a - a) * start + (b * b * b - b) * end)
}
