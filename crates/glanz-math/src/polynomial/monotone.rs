//! Roots between critical points: slower than subdivision, but certain where subdivision is not.

use super::compensated::{Bounded, compensated_horner, horner, horner_with_slope, two_product, value};
use super::isolate::{MAX_DEGREE, Roots};
use super::quadratic;
use crate::rounding::UNIT_ROUNDOFF;

/// All roots in [low, high] of `p`, whose leading coefficient is not zero.
pub(super) fn solve(p: &[f64], low: f64, high: f64) -> Roots {
    let degree = p.len() - 1;
    if degree == 0 {
        return Roots::NONE;
    }
    // The roots of each derivative, from the quadratic one on, divide the interval for the next.
    let mut cuts = Roots::NONE;
    for order in (1..degree).rev() {
        let mut derivative = [0.0; MAX_DEGREE + 1];
        differentiate(p, order, &mut derivative);
        let q = derivative.get(..=degree - order).unwrap_or(&[]);
        cuts = if let [c, b, a] = *q {
            quadratic_cuts(a, b, c, low, high)
        } else {
            let ends = with_ends(&cuts, low, high);
            cut_at_roots(q, &ends, horner)
        };
    }
    sharpen(p, &mut cuts, low, high);
    let ends = with_ends(&cuts, low, high);
    cut_at_roots(p, &ends, adaptive_value)
}

/// The value of `p`, in twice the precision where its sign is uncertain in working precision.
///
/// The bound then includes the change of `p` over the last digit of `t`: a sign of 0 means that `t` is as close to a root as a
/// number can be.
pub(super) fn adaptive_value(p: &[f64], t: f64) -> Bounded {
    let (plain, slope) = horner_with_slope(p, t);
    if plain.sign() != 0 {
        return plain;
    }
    let fine = compensated_horner(p, t);
    Bounded { error: fine.error + slope.abs() * UNIT_ROUNDOFF * t.abs(), ..fine }
}

/// Refines the cuts where `p` almost vanishes by a Newton step for its critical points in twice the precision.
///
/// An error d of a cut changes the value by `p'' d^2 / 2`, which hides a double root unless d is in the last digit. The derivative
/// includes the remainders of its rounded coefficients, as its additional digits would be wrong without them.
fn sharpen(p: &[f64], cuts: &mut Roots, low: f64, high: f64) {
    let mut first = [0.0; MAX_DEGREE + 1];
    let mut remainders = [0.0; MAX_DEGREE + 1];
    let mut second = [0.0; MAX_DEGREE + 1];
    let mut ready = false;
    let degree = p.len() - 1;
    for i in 0..cuts.count {
        let Some(t) = cuts.get(i).copied() else { return };
        if horner(p, t).sign() != 0 {
            continue;
        }
        if !ready {
            for (i, &c) in p.iter().enumerate().skip(1) {
                let (product, remainder) = two_product(i as f64, c);
                if let (Some(a), Some(b)) = (first.get_mut(i - 1), remainders.get_mut(i - 1)) {
                    (*a, *b) = (product, remainder);
                }
            }
            differentiate(p, 2, &mut second);
            ready = true;
        }
        let slope = compensated_horner(first.get(..degree).unwrap_or(&[]), t).value + value(&remainders, t);
        let moved = t - slope / value(second.get(..degree.saturating_sub(1)).unwrap_or(&[]), t);
        // Only the last digits may change: a larger step, as at a multiple root of the derivative, is noise.
        if (moved - t).abs() <= UNIT_ROUNDOFF.sqrt() * t.abs()
            && let Some(cut) = cuts.values.get_mut(i)
        {
            *cut = moved.clamp(low, high);
        }
    }
    // Neighbours may have been exchanged.
    if let Some(used) = cuts.values.get_mut(..cuts.count) {
        used.sort_by(f64::total_cmp);
    }
}

/// Writes the coefficients of the derivative of the given order to the start of `derivative`.
fn differentiate(p: &[f64], order: usize, derivative: &mut [f64]) {
    for (i, (&c, d)) in p.iter().skip(order).zip(derivative).enumerate() {
        // (i + 1) ... (i + order), exact.
        *d = (1..=order).fold(1.0, |f, k| f * (i + k) as f64) * c;
    }
}

fn quadratic_cuts(a: f64, b: f64, c: f64, low: f64, high: f64) -> Roots {
    let mut cuts = Roots::NONE;
    for t in quadratic::roots(a, b, c).into_iter().flatten() {
        if t > low && t < high {
            cuts.push(t);
        }
    }
    cuts
}

fn with_ends(cuts: &Roots, low: f64, high: f64) -> Roots {
    let mut ends = Roots::NONE;
    ends.push(low);
    for &t in cuts.iter() {
        ends.push(t);
    }
    ends.push(high);
    ends
}

/// The roots of `p`, which is monotone between neighbours in `ends`, with the signs of `evaluate`.
fn cut_at_roots(p: &[f64], ends: &[f64], evaluate: impl Fn(&[f64], f64) -> Bounded) -> Roots {
    let mut roots = Roots::NONE;
    let Some((&first, rest)) = ends.split_first() else {
        return roots;
    };
    let (mut a, mut sign_a) = (first, evaluate(p, first).sign());
    if sign_a == 0 {
        roots.push(a);
    }
    for &b in rest {
        let sign_b = evaluate(p, b).sign();
        if sign_b == 0 {
            // A monotone function that is zero at both ends: the same root.
            if sign_a != 0 {
                roots.push(b);
            }
        } else if sign_a * sign_b < 0 {
            roots.push(refine(p, a, b, sign_a, 0.5 * a + 0.5 * b, &evaluate));
        }
        (a, sign_a) = (b, sign_b);
    }
    roots
}

/// The root between `a`, where the sign is `sign_a`, and `b`, where it is the opposite, searched from `start`.
///
/// Newton's step is used if it stays in the bracket and is at most half of the previous step; otherwise the bracket is halved. One
/// or the other shrinks geometrically, so that the loop ends.
pub(super) fn refine(
    p: &[f64],
    mut a: f64,
    mut b: f64,
    sign_a: i8,
    start: f64,
    evaluate: &impl Fn(&[f64], f64) -> Bounded,
) -> f64 {
    let mut t = start;
    let mut last_step = b - a;
    loop {
        let (plain, slope) = horner_with_slope(p, t);
        // Where working precision is not enough, `evaluate` decides: in twice the precision for the polynomial itself.
        let y = if plain.sign() == 0 { evaluate(p, t) } else { plain };
        let sign = y.sign();
        if sign == 0 {
            return t;
        }
        if sign == sign_a {
            a = t;
        } else {
            b = t;
        }
        let newton = t - y.value / slope;
        let good = newton > a && newton < b && (newton - t).abs() <= 0.5 * last_step;
        let next = if good { newton } else { 0.5 * a + 0.5 * b };
        last_step = (next - t).abs();
        if last_step <= f64::EPSILON * next.abs() || next <= a || next >= b {
            return next;
        }
        t = next;
    }
}
