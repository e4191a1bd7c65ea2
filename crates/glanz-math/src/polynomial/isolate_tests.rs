//! The solver against two independent references: Sturm's count in exact integers, and signs from exact expansions.

use super::super::compensated::{compensated_horner, two_product, two_sum};
use super::*;

/// SplitMix64: test cases, not statistics.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [-1, 1).
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-52) - 1.0
    }

    fn integer(&mut self, reach: i128) -> i128 {
        i128::from(self.bits() >> 32) % (2 * reach + 1) - reach
    }
}

/// The sign of the exact value of `sum c_i t^i`, by expansions without any rounding (@shewchuk1997 section 2).
fn exact_sign(coefficients: &[f64], t: f64) -> i8 {
    let mut expansion: Vec<f64> = Vec::new();
    for &c in coefficients.iter().rev() {
        let mut next: Vec<f64> = vec![c];
        for &part in &expansion {
            let (high, low) = two_product(part, t);
            for piece in [low, high] {
                let mut carry = piece;
                for term in &mut next {
                    let (sum, rest) = two_sum(carry, *term);
                    *term = rest;
                    carry = sum;
                }
                next.push(carry);
            }
        }
        next.retain(|&x| x != 0.0);
        expansion = next;
    }
    // Non-overlapping, ascending: the last one has the sign.
    expansion.last().map_or(0, |&x| if x > 0.0 { 1 } else { -1 })
}

/// The coefficients of `leading * product (t - r)`, each rounded.
fn from_roots<const N: usize>(leading: f64, known: &[f64]) -> [f64; N] {
    let mut c = [0.0; N];
    c[0] = leading;
    for (k, &r) in known.iter().enumerate() {
        for i in (0..=k + 1).rev() {
            c[i] = (if i > 0 { c[i - 1] } else { 0.0 }) - r * c[i];
        }
    }
    c
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

/// Number of different real roots of an integer polynomial in (low, high], by Sturm's theorem. Exact.
fn sturm_count(coefficients: &[i128], low: i128, high: i128) -> usize {
    let trim = |mut p: Vec<i128>| {
        while p.last() == Some(&0) {
            p.pop();
        }
        let g = p.iter().fold(0, |g, &c| gcd(g, c));
        p.iter().map(|c| c / g.max(1)).collect::<Vec<_>>()
    };
    let p = trim(coefficients.to_vec());
    let derivative = trim(p.iter().enumerate().skip(1).map(|(i, c)| c * i as i128).collect());
    let mut chain = vec![p, derivative];
    loop {
        let [.., a, b] = chain.as_slice() else { unreachable!() };
        if b.is_empty() {
            chain.pop();
            break;
        }
        // -(a mod b) up to a positive factor: multiply by |lead b| before every step of the division.
        let (lead, mut rest) = (*b.last().unwrap(), a.clone());
        while rest.len() >= b.len() {
            let (top, shift) = (*rest.last().unwrap(), rest.len() - b.len());
            let mut next: Vec<i128> = rest.iter().map(|c| c * lead.abs()).collect();
            for (i, c) in b.iter().enumerate() {
                next[i + shift] -= c * top * lead.signum();
            }
            next.pop();
            let zeros = next.len();
            rest = next;
            assert!(rest.len() == zeros);
        }
        chain.push(trim(rest.iter().map(|c| -c).collect()));
    }
    let changes = |t: i128| {
        let signs =
            chain.iter().map(|p| p.iter().rev().fold(0, |y, c| y * t + c).signum()).filter(|&s| s != 0);
        let signs: Vec<_> = signs.collect();
        signs.windows(2).filter(|w| w[0] != w[1]).count()
    };
    changes(low) - changes(high)
}

#[test]
fn expansion_has_the_sign_that_doubles_lose() {
    assert_eq!(exact_sign(&[-1.0, 3.0, -3.0, 1.0], 1.0 + f64::EPSILON), 1);
    assert_eq!(exact_sign(&[-1.0, 3.0, -3.0, 1.0], 1.0 - f64::EPSILON), -1);
    assert_eq!(exact_sign(&[-1.0, 3.0, -3.0, 1.0], 1.0), 0);
}

#[test]
fn sturm_counts_known_roots() {
    assert_eq!(sturm_count(&[-6, 11, -6, 1], 0, 10), 3);
    assert_eq!(sturm_count(&[4, 0, -4, 0, 1], -10, 10), 2);
    assert_eq!(sturm_count(&[1, 0, 0, 0, 1], -10, 10), 0);
}

#[test]
fn number_of_roots_is_sturms_for_random_integer_polynomials() {
    let mut random = Random(1);
    for reach in [3, 20, 1000] {
        for _ in 0..20_000 {
            let c: [i128; 5] = std::array::from_fn(|_| random.integer(reach));
            if c.iter().all(|&x| x == 0) {
                continue;
            }
            let (low, high) = (-3, 4);
            let at_low = i8::from(exact_sign(&c.map(|x| x as f64), low as f64) == 0);
            let expected = sturm_count(&c, low, high) + at_low as usize;
            let found = roots(&c.map(|x| x as f64), low as f64, high as f64);
            assert_eq!(found.len(), expected, "{c:?}: {:?}", &*found);
        }
    }
}

#[test]
fn double_roots_of_integer_polynomials_appear_once() {
    // (a t^2 + b t + c)^2: roots are irrational in general, so that no double hits them.
    let mut random = Random(2);
    let mut seen = 0;
    for _ in 0..20_000 {
        let [c, b, a]: [i128; 3] = std::array::from_fn(|_| random.integer(50));
        if a == 0 {
            continue;
        }
        let square = [c * c, 2 * b * c, b * b + 2 * a * c, 2 * a * b, a * a];
        let expected = sturm_count(&square, -200, 200);
        let found = roots(&square.map(|x| x as f64), -200.0, 200.0);
        assert_eq!(found.len(), expected, "{square:?}: {:?}", &*found);
        seen += expected;
    }
    assert!(seen > 15_000);
}

#[test]
fn double_roots_appear_once_when_the_derivative_must_be_rounded() {
    // (a t^2 + b t + c)^2 with 25 digits each: all coefficients are exact, three times one of them is not.
    let mut random = Random(5);
    let mut seen = 0;
    for _ in 0..20_000 {
        let [c, b, a]: [i128; 3] = std::array::from_fn(|_| random.integer(1 << 25));
        let (at_1, at_minus_1) = (a + b + c, a - b + c);
        if b * b <= 4 * a * c || a == 0 || at_1 * a <= 0 || at_minus_1 * a <= 0 || b.abs() >= 2 * a.abs() {
            continue;
        }
        // The parabola has two real roots, its vertex lies in (-1, 1) and it has the sign of a at -1 and 1.
        let square = [c * c, 2 * b * c, b * b + 2 * a * c, 2 * a * b, a * a].map(|x| x as f64);
        assert_eq!(roots(&square, -1.0, 1.0).len(), 2, "{square:?}");
        seen += 1;
    }
    assert!(seen > 1_000, "{seen}");
}

/// Compares with sign changes of the exact polynomial on a grid that is dense around `known` at every scale.
fn check_against_grid<const N: usize>(c: &[f64; N], known: &[f64], low: f64, high: f64) -> usize {
    let found = roots(c, low, high);
    let mut grid = vec![low, high];
    for i in 0..=64 {
        grid.push(low + (high - low) * f64::from(i) / 64.0);
    }
    for &r in known {
        grid.push(r);
        for exponent in 0..56 {
            let step = (high - low) * 0.75_f64.powi(2 * exponent) * 0.3;
            grid.extend([r - step, r + step]);
        }
    }
    grid.retain(|t| (low..=high).contains(t));
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    // Grid points where the exact polynomial vanishes are roots; so is one in every gap with a change of sign.
    let signs: Vec<i8> = grid.iter().map(|&t| exact_sign(c, t)).collect();
    let mut certain = 0;
    for i in 0..grid.len() {
        if signs[i] == 0 {
            certain += 1;
            assert!(
                found.iter().any(|&t| (t - grid[i]).abs() <= 2.0 * f64::EPSILON * grid[i].abs()),
                "{c:?} vanishes at {}, found {:?}",
                grid[i],
                &*found
            );
        }
        if i > 0 && signs[i] * signs[i - 1] < 0 {
            certain += 1;
            assert!(
                found.iter().any(|t| {
                    (grid[i - 1].next_down().next_down()..=grid[i].next_up().next_up()).contains(t)
                }),
                "{c:?} changes sign in {:?}, found {:?}",
                (grid[i - 1], grid[i]),
                &*found
            );
        }
    }
    // Nothing is invented: the exact polynomial changes sign within two units in the last place of a root, or is zero
    // to twice the precision.
    for &t in found.iter() {
        let (mut a, mut b) = (t, t);
        for _ in 0..2 {
            (a, b) = (a.next_down(), b.next_up());
        }
        let changes = exact_sign(c, a.max(low)) * exact_sign(c, b.min(high)) <= 0;
        assert!(changes || compensated_horner(c, t).sign() == 0, "{c:?}: {t} is no root");
    }
    assert!(found.windows(2).all(|w| w[0] < w[1]));
    certain
}

#[test]
fn known_roots_are_found_at_every_scale() {
    let mut random = Random(3);
    let mut certain = 0;
    for i in 0..1_000 {
        let scale = 10.0_f64.powi(i % 13 - 6);
        let known: [f64; 4] = std::array::from_fn(|_| random.signed() * scale);
        let c: [f64; 5] = from_roots(random.signed() + 2.0, &known);
        certain += check_against_grid(&c, &known, -scale, scale);
        certain += check_against_grid::<4>(&from_roots(1.0, &known[..3]), &known[..3], -scale, scale);
    }
    assert!(certain >= 1_000 * 7 - 10, "{certain}");
}

#[test]
fn roots_in_clusters_are_separated() {
    let mut random = Random(4);
    for i in 0..2_000 {
        let scale = 10.0_f64.powi(i % 13 - 6);
        let gap = 10.0_f64.powi(-(i % 9));
        let center = random.signed() * 0.5;
        // Two, three or four near each other; the coefficients are rounded, so only their own exact roots count.
        let near = 2 + i as usize % 3;
        let known: [f64; 4] = std::array::from_fn(|k| {
            let offset =
                if k < near { 0.3 * gap * (k as f64 + 0.5 * random.signed()) } else { random.signed() };
            (center + offset) * scale
        });
        let c: [f64; 5] = from_roots(1.0, &known);
        check_against_grid(&c, &known, -2.0 * scale, 2.0 * scale);
    }
}

#[test]
fn pairs_a_hundred_millionth_apart_are_two_roots_if_the_coefficients_say_so() {
    // Around 0 the coefficients of (t - d)(t + d)(t - 3)(t + 5) hold every digit of d.
    for exponent in 1..=40 {
        let d = 2.0_f64.powi(-exponent);
        let c: [f64; 5] = from_roots(1.0, &[d, -d, 3.0, -5.0]);
        let found = roots(&c, -1.0, 1.0);
        assert_eq!(found.len(), 2, "d = {d:e}");
        assert!(
            (found[0] + d).abs() <= 1e-15 * d + 4.0 * d * d
                && (found[1] - d).abs() <= 1e-15 * d + 4.0 * d * d
        );
    }
    // Around 1, exactly: (t - 1)^2 - d^2 has the roots 1 -+ d, and 1 - d^2 is representable down to d = 2^-26.
    for exponent in 1..=26 {
        let d = 2.0_f64.powi(-exponent);
        assert_eq!(*roots(&[1.0 - d * d, -2.0, 1.0], 0.0, 2.0), [1.0 - d, 1.0 + d]);
    }
}

#[test]
fn roots_at_the_ends_belong_to_the_interval() {
    let c: [f64; 5] = from_roots(2.0, &[-1.0, 0.5, 2.0, 4.0]);
    assert_eq!(*roots(&c, -1.0, 4.0), [-1.0, 0.5, 2.0, 4.0]);
    assert_eq!(*roots(&c, 0.5, 2.0), [0.5, 2.0]);
    assert_eq!(*roots(&c, 0.6, 1.9), []);
    assert_eq!(*roots(&c, 0.5, 0.5), [0.5]);
    // A double root at an end, and a triple one inside.
    let c: [f64; 6] = from_roots(1.0, &[1.0, 1.0, -1.0, -1.0, -1.0]);
    assert_eq!(*roots(&c, -3.0, 1.0), [-1.0, 1.0]);
}

#[test]
fn lower_degrees_and_invalid_input() {
    assert_eq!(*roots(&[3.0, -1.5, 0.0, 0.0, 0.0], -10.0, 10.0), [2.0]);
    assert_eq!(*roots(&[1.0, 0.0, 0.0], -10.0, 10.0), []);
    assert_eq!(*roots(&[0.0; 5], -10.0, 10.0), []);
    assert_eq!(*roots(&[0.0, 0.0, 0.0, 1.0], -10.0, 10.0), [0.0]);
    assert_eq!(*roots(&[0.0, f64::NAN, 1.0], -1.0, 1.0), []);
    assert_eq!(*roots(&[0.0, 1.0], 1.0, -1.0), []);
    assert_eq!(*roots(&[0.0, 1.0], f64::NEG_INFINITY, 1.0), []);
    // Leading coefficients far below the others, and all of them far from 1.
    let found = roots(&[-1e-290, 1e-290, 1e-305, -1e-308], -2.0, 2.0);
    assert!(found.len() == 1 && (found[0] - 1.0).abs() < 1e-14);
    let found = roots(&[-1e300, 0.0, 1e300], -2.0, 2.0);
    assert_eq!(*found, [-1.0, 1.0]);
}

#[test]
fn subdivision_and_derivatives_agree() {
    let mut random = Random(6);
    let mut count = 0;
    for _ in 0..20_000 {
        let c: [f64; 5] = std::array::from_fn(|_| random.signed());
        let (fast, slow) = (roots(&c, -1.5, 1.25), solve(&c, -1.5, 1.25));
        assert_eq!(fast.len(), slow.len(), "{c:?}");
        for (a, b) in fast.iter().zip(slow.iter()) {
            assert!((a - b).abs() <= 2.0 * f64::EPSILON * a.abs(), "{c:?}: {a} {b}");
            count += 1;
        }
    }
    assert!(count > 10_000);
}

#[test]
fn first_root_does_not_depend_on_later_ones() {
    let mut random = Random(7);
    for _ in 0..5_000 {
        let known: [f64; 4] = std::array::from_fn(|_| random.signed());
        let c: [f64; 5] = from_roots(1.0, &known);
        let first = visit_roots(&c, -1.0, 1.0, ControlFlow::Break).break_value();
        assert_eq!(first, roots(&c, -1.0, 1.0).first().copied());
    }
}
