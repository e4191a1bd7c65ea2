//! Cutting a rational Bézier piece where it turns in u or in v.

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::curve::project;
use crate::bezier::bernstein::{binomials, halve, split};

/// How often an interval is halved in search of a turning point: down to 4e-15, where a smooth curve is flat to twice
/// as many digits.
const MAX_SPLITS: u32 = 48;

/// The parts of a rational Bézier piece between its turning points: each is monotone in u and in v, up to rounding.
pub(super) fn monotone_parts(points: &[DVec3]) -> Vec<Vec<DVec3>> {
    let mut cuts = Vec::new();
    for axis in 0..2 {
        let mut search = Search { known: None, turns: Vec::new() };
        search.interval(&hodograph(points, axis), 0.0, 1.0, MAX_SPLITS);
        cuts.append(&mut search.turns);
    }
    cuts.sort_by(f64::total_cmp);
    let (mut parts, mut rest, mut from) = (Vec::new(), points.to_vec(), 0.0);
    for cut in cuts {
        let share = (cut - from) / (1.0 - from);
        if share > 0.0 && share < 1.0 {
            let (part, after) = split(&rest, share);
            parts.push(part);
            (rest, from) = (after, cut);
        }
    }
    parts.push(rest);
    parts
}

/// Bernstein coefficients of the numerator `x' w - x w'` of the derivative of `x / w` along one axis, of degree 2 n - 1:
/// each as (value, bound on its error, also after [`MAX_SPLITS`] halvings).
///
/// The bound goes with the coefficients of its neighbourhood, so that small weights keep their own scale.
fn hodograph(points: &[DVec3], axis: usize) -> Vec<DVec2> {
    let n = points.len() - 1;
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &p| {
        let x = project(p)[axis];
        (low.min(x), high.max(x))
    });
    let middle = 0.5 * low + 0.5 * high;
    // (x relative to the middle, what its rounding is relative to, w).
    let terms: Vec<[f64; 3]> =
        points.iter().map(|p| [p[axis] - middle * p.z, p[axis].abs() + middle.abs() * p.z, p.z]).collect();
    let [slopes, values, products] = [n - 1, n, 2 * n - 1].map(|n| binomials(n).collect::<Vec<_>>());
    let mut coefficients = vec![DVec2::ZERO; 2 * n];
    for (i, pair) in terms.windows(2).enumerate() {
        let ([x0, size0, w0], [x1, size1, w1]) = (pair[0], pair[1]);
        for (j, [x, size, w]) in terms.iter().enumerate() {
            let share = slopes[i] * values[j] / products[i + j];
            let value = (x1 - x0) * w - x * (w1 - w0);
            coefficients[i + j] += DVec2::new(value, (size0 + size1) * w + size * (w0 + w1)) * share;
        }
    }
    // Each halving rounds 2 n - 1 times, the products and sums before it 4 n + 8 times.
    let roundings = (n as u32) * (4 + 2 * MAX_SPLITS) + 8;
    coefficients.iter().map(|c| DVec2::new(c.x, c.y * gamma(roundings))).collect()
}

/// A walk along the parameter: where the sign of a polynomial, as far as it is certain, changes.
struct Search {
    /// The latest certain sign (positive?) and the end of the interval that had it.
    known: Option<(bool, f64)>,
    turns: Vec<f64>,
}

impl Search {
    fn interval(&mut self, b: &[DVec2], low: f64, high: f64, splits: u32) {
        let (up, down) = (b.iter().any(|c| c.x > c.y), b.iter().any(|c| c.x < -c.y));
        if up && down {
            // What is too small to be halved lies between two intervals with a sign of their own.
            if splits > 0 {
                let (mut left, mut right) = (b.to_vec(), b.to_vec());
                halve(&mut left, &mut right);
                let middle = 0.5 * low + 0.5 * high;
                self.interval(&left, low, middle, splits - 1);
                self.interval(&right, middle, high, splits - 1);
            }
        } else if up || down {
            if let Some((before, end)) = self.known
                && before != up
            {
                self.turns.push(0.5 * end + 0.5 * low);
            }
            self.known = Some((up, high));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::evaluate;
    use super::*;

    fn monotone(points: &[DVec3]) -> bool {
        let samples: Vec<DVec2> = (0..=200).map(|i| evaluate(points, f64::from(i) / 200.0)).collect();
        (0..2).all(|axis| {
            let steps = || samples.windows(2).map(|pair| pair[1][axis] - pair[0][axis]);
            steps().all(|d| d > -1e-13) || steps().all(|d| d < 1e-13)
        })
    }

    #[test]
    fn cubic_with_three_turns_falls_into_four_parts() {
        // u' = 3 (2 (1 - t)^2 - 6 t (1 - t) + 2 t^2) = 6 (1 - 5 t + 5 t^2), roots (5 -+ sqrt(5)) / 10;
        // v = 3 t (1 - t), root 1/2.
        let points = [(0.0, 0.0), (2.0, 1.0), (-1.0, 1.0), (1.0, 0.0)].map(|(u, v)| DVec3::new(u, v, 1.0));
        let parts = monotone_parts(&points);
        assert_eq!(parts.len(), 4);
        assert!(parts.iter().all(|p| monotone(p)));
        let root = (5.0 - 5.0_f64.sqrt()) / 10.0;
        let turn = project(parts[0][3]);
        // Level in u there, so that the uncertainty of the root shows along v only.
        let offset = turn - evaluate(&points, root);
        assert!(offset.x.abs() < 1e-15 && offset.y.abs() < 1e-12, "{offset}");
        assert_eq!(parts[0][3], parts[1][0]);
    }

    #[test]
    fn straight_lines_and_inflections_stay_whole() {
        let parts = |p: &[DVec3]| monotone_parts(p).len();
        let on_line = [0.1, 0.3, 0.35, 0.7].map(|t| DVec3::new(3.0 * t, 5.0 - t, 1.0));
        assert_eq!(parts(&on_line), 1);
        assert_eq!(parts(&on_line.map(|p| DVec3::new(p.x, 0.3, 1.0))), 1);
        // (t, (2 t - 1)^3): level in the middle, but no turn.
        let cubic = [(0.0, -1.0), (1.0 / 3.0, 1.0), (2.0 / 3.0, -1.0), (1.0, 1.0)];
        assert_eq!(parts(&cubic.map(|(u, v)| DVec3::new(u, v, 1.0))), 1);
    }

    #[test]
    fn turn_at_the_middle_of_the_interval_is_found() {
        // The first halving puts the root of the hodograph on the common end of both halves.
        let parabola = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)].map(|(u, v)| DVec3::new(u, v, 1.0));
        assert_eq!(monotone_parts(&parabola).len(), 2);
    }

    #[test]
    fn weights_of_a_thousand_and_a_thousandth_keep_parts_monotone() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 * 2.0_f64.powi(-53)
        };
        for _ in 0..2_000 {
            let points: Vec<DVec3> = (0..5)
                .map(|_| {
                    let w = 10.0_f64.powf(6.0 * random() - 3.0);
                    DVec3::new(random() * w, random() * w, w)
                })
                .collect();
            let parts = monotone_parts(&points);
            assert!(parts.iter().all(|p| monotone(p)), "{points:?}");
            assert!(parts.len() <= 13);
        }
    }
}
