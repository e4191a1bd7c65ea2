//! Splitting of rational Bézier pieces at their turning points in u and in v.

use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};

use super::curve::{evaluate, project};
use crate::bezier::bernstein::{binomials, halve, split};

/// Largest number of halvings in the search for a turning point: down to 4e-15, where a smooth curve is flat to twice as many
/// digits.
const MAX_SPLITS: u32 = 48;

/// A rational Bézier curve that is monotone in u and in v, up to rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct MonotonePiece {
    /// Start point. The region is on the left.
    pub start: DVec2,
    /// End point.
    pub end: DVec2,
    /// Homogeneous control points (w u, w v, w), degree + 1 of them.
    pub control_points: Vec<DVec3>,
    /// Distance from it within which points are kept, in the coordinates of the region.
    pub width: f64,
}

impl MonotonePiece {
    /// The point at `t`, from 0 at the start to 1 at the end.
    #[must_use]
    pub fn point(&self, t: f64) -> DVec2 {
        evaluate(&self.control_points, t)
    }

    /// The direction in which it runs at `t`, of any length; that of its chord where it stands still.
    #[must_use]
    pub fn direction(&self, t: f64) -> DVec2 {
        // The last step of de Casteljau's algorithm joins two points of the tangent.
        let Some((_, before)) = self.control_points.split_last() else { return DVec2::ZERO };
        let behind = self.control_points.get(1..).unwrap_or_default();
        let along = evaluate(behind, t) - evaluate(before, t);
        if along == DVec2::ZERO { self.end - self.start } else { along }
    }
}

/// Control points of the pieces of a rational Bézier piece between its turning points.
pub(super) fn monotone_pieces(points: &[DVec3]) -> Vec<Vec<DVec3>> {
    let mut cuts = Vec::new();
    for axis in (0..2).filter(|&axis| !is_monotone(points, axis)) {
        let mut search = TurningPointSearch { last_sign: None, turning_points: Vec::new() };
        search.interval(&hodograph(points, axis), 0.0, 1.0, MAX_SPLITS);
        cuts.append(&mut search.turning_points);
    }
    cuts.sort_by(f64::total_cmp);
    let (mut pieces, mut rest, mut from) = (Vec::new(), points.to_vec(), 0.0);
    for cut in cuts {
        let share = (cut - from) / (1.0 - from);
        if share > 0.0 && share < 1.0 {
            let (part, after) = split(&rest, share);
            pieces.push(part);
            (rest, from) = (after, cut);
        }
    }
    pieces.push(rest);
    pieces
}

/// Whether the control polygon is monotone along one axis: a line meets the curve at most as often as it meets the polygon, so that the
/// curve is monotone too.
///
/// # Source
/// @farin2002 chapter 13 (variation diminution).
fn is_monotone(points: &[DVec3], axis: usize) -> bool {
    let at = |point: &DVec3| project(*point)[axis];
    points.is_sorted_by(|a, b| at(a) <= at(b)) || points.is_sorted_by(|a, b| at(a) >= at(b))
}

/// Bernstein coefficients of the numerator `x' w - x w'` of the derivative of `x / w` along one axis, of degree 2 n - 1, each
/// as (value, bound on its error, which is valid for [`MAX_SPLITS`] halvings).
///
/// The bound is local to the coefficient, so that small weights keep their own scale.
fn hodograph(points: &[DVec3], axis: usize) -> Vec<DVec2> {
    let n = points.len() - 1;
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &p| {
        let x = project(p)[axis];
        (low.min(x), high.max(x))
    });
    let middle = 0.5 * low + 0.5 * high;
    // (x relative to the middle, the magnitude that its rounding is relative to, w).
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

/// A search along the parameter for changes of the sign of a polynomial, as far as the sign is certain.
struct TurningPointSearch {
    /// Whether the last certain sign was positive, and the end of its interval.
    last_sign: Option<(bool, f64)>,
    turning_points: Vec<f64>,
}

impl TurningPointSearch {
    fn interval(&mut self, b: &[DVec2], low: f64, high: f64, splits: u32) {
        let (up, down) = (b.iter().any(|c| c.x > c.y), b.iter().any(|c| c.x < -c.y));
        if up && down {
            // An interval too short to be halved lies between two intervals of certain sign.
            if splits > 0 {
                let (mut left, mut right) = (b.to_vec(), b.to_vec());
                halve(&mut left, &mut right);
                let middle = 0.5 * low + 0.5 * high;
                self.interval(&left, low, middle, splits - 1);
                self.interval(&right, middle, high, splits - 1);
            }
        } else if up || down {
            if let Some((before, end)) = self.last_sign
                && before != up
            {
                self.turning_points.push(0.5 * end + 0.5 * low);
            }
            self.last_sign = Some((up, high));
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
        let pieces = monotone_pieces(&points);
        assert_eq!(pieces.len(), 4);
        assert!(pieces.iter().all(|p| monotone(p)));
        let root = (5.0 - 5.0_f64.sqrt()) / 10.0;
        let turn = project(pieces[0][3]);
        // Level in u there, so that the uncertainty of the root shows along v only.
        let offset = turn - evaluate(&points, root);
        assert!(offset.x.abs() < 1e-15 && offset.y.abs() < 1e-12, "{offset}");
        assert_eq!(pieces[0][3], pieces[1][0]);
    }

    #[test]
    fn straight_lines_and_inflections_stay_whole() {
        let pieces = |p: &[DVec3]| monotone_pieces(p).len();
        let on_line = [0.1, 0.3, 0.35, 0.7].map(|t| DVec3::new(3.0 * t, 5.0 - t, 1.0));
        assert_eq!(pieces(&on_line), 1);
        assert_eq!(pieces(&on_line.map(|p| DVec3::new(p.x, 0.3, 1.0))), 1);
        // (t, (2 t - 1)^3): level in the middle, but no turn.
        let cubic = [(0.0, -1.0), (1.0 / 3.0, 1.0), (2.0 / 3.0, -1.0), (1.0, 1.0)];
        assert_eq!(pieces(&cubic.map(|(u, v)| DVec3::new(u, v, 1.0))), 1);
    }

    #[test]
    fn turn_at_the_middle_of_the_interval_is_found() {
        // The first halving puts the root of the hodograph on the common end of both halves.
        let parabola = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)].map(|(u, v)| DVec3::new(u, v, 1.0));
        assert_eq!(monotone_pieces(&parabola).len(), 2);
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
            let pieces = monotone_pieces(&points);
            assert!(pieces.iter().all(|p| monotone(p)), "{points:?}");
            assert!(pieces.len() <= 13);
        }
    }
}
