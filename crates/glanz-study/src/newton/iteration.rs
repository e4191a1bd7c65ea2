//! Newton's method for small systems, in the variants of document 000 chapter 3.
//!
//! An iteration leads from a start to a root or to none; which root it finds, and whether there are others, is not known
//! beforehand. The search of `glanz-geometry` bounds the Jacobian first and iterates only where there is exactly one root. These
//! are the plain iterations, for comparison.

use glanz_math::rounding::gamma;

/// Most halvings of a damped step, down to a thousandth of it. If none helps, the iteration is at a minimum of |f| that is
/// no root, except in contrived systems.
const MOST_HALVINGS: u32 = 10;

/// Partial derivatives: row i and column j hold that of the i-th component by the j-th variable.
pub(super) type Jacobian<const N: usize> = [[f64; N]; N];

/// A map f from R^N to R^N whose zeros are sought; N is 2 or 3.
///
/// A closure from a point to value and Jacobian is a system that is defined everywhere.
pub(super) trait NonlinearSystem<const N: usize> {
    /// f and its Jacobian at `x`.
    fn linear(&self, x: &[f64; N]) -> ([f64; N], Jacobian<N>);

    /// f at `x`.
    fn value(&self, x: &[f64; N]) -> [f64; N] {
        self.linear(x).0
    }

    /// Whether `x` lies in the domain of f.
    fn contains(&self, x: &[f64; N]) -> bool {
        let _ = x;
        true
    }
}

impl<const N: usize, F: Fn(&[f64; N]) -> ([f64; N], Jacobian<N>)> NonlinearSystem<N> for F {
    fn linear(&self, x: &[f64; N]) -> ([f64; N], Jacobian<N>) {
        self(x)
    }
}

/// The residual and the number of steps at which an iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StoppingCriteria {
    /// Largest Euclidean norm of f at a point that counts as a root, in the unit of f.
    pub(super) residual: f64,
    /// Most steps.
    pub(super) iterations: u32,
}

/// The last point of an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Iterate<const N: usize> {
    /// The point.
    pub(super) x: [f64; N],
    /// Euclidean norm of f there.
    pub(super) residual: f64,
    /// Number of steps.
    pub(super) iterations: u32,
    /// Number of evaluations of f, alone or with its Jacobian.
    pub(super) evaluations: u32,
}

/// The end of an iteration, with its last point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NewtonOutcome<const N: usize> {
    /// The residual is within its limit. A root is likely to be near, but not certain.
    Converged(Iterate<N>),
    /// The Jacobian has no inverse to within rounding, so that there is no next step.
    Singular(Iterate<N>),
    /// The next point is outside the domain or not finite; this is the last point inside, or the start.
    LeftDomain(Iterate<N>),
    /// No root within the number of steps; for [`damped`] also: no step in the direction reduces |f|.
    NotConverged(Iterate<N>),
}

impl<const N: usize> NewtonOutcome<N> {
    /// The last point.
    #[must_use]
    pub(super) fn iterate(&self) -> &Iterate<N> {
        match self {
            Self::Converged(iterate)
            | Self::Singular(iterate)
            | Self::LeftDomain(iterate)
            | Self::NotConverged(iterate) => iterate,
        }
    }

    /// The last point, if it is a root.
    #[must_use]
    pub(super) fn converged(&self) -> Option<&Iterate<N>> {
        match self {
            Self::Converged(iterate) => Some(iterate),
            _ => None,
        }
    }
}

/// General Newton's method: `x <- x - Df(x)^-1 f(x)`.
///
/// Converges quadratically from every start in some neighbourhood of a root where f is twice continuously differentiable
/// and Df invertible; the theorem gives no size of that neighbourhood. From elsewhere the iteration may diverge, cycle, or
/// end at a root far away.
///
/// # Source
/// @pumberger2010 algorithm 3.2.2.1 and section 3.2.4.
#[must_use]
pub(super) fn general<const N: usize>(
    system: &impl NonlinearSystem<N>,
    start: [f64; N],
    criteria: StoppingCriteria,
) -> NewtonOutcome<N> {
    run(system, start, criteria, |_, iterate, f, jacobian| {
        let step = solve(jacobian, f)?;
        Some(subtract(&iterate.x, &step, 1.0))
    })
}

/// Simplified Newton's method: `x <- x - Df(x0)^-1 f(x)` with the Jacobian of the start x0.
///
/// Let f be continuously differentiable with bounded derivatives on a convex domain G, Df(x0) invertible, and
/// (condition C) `|Df(x0)^-1| |Df(x0) - Df(z)| <= q < 1` for all z in G, in row sum norms. If the
/// ball of radius `q / (1 - q) |x1 - x0|` around the first iterate x1 lies in G, the iteration converges to the only
/// root of G, which lies in that ball, and every step is at most q times as long as the one before (largest component).
/// Convergence is linear.
///
/// # Source
/// @pumberger2010 theorem 3.2.3.1.
#[must_use]
pub(super) fn simplified<const N: usize>(
    system: &impl NonlinearSystem<N>,
    start: [f64; N],
    criteria: StoppingCriteria,
) -> NewtonOutcome<N> {
    let first = std::cell::Cell::new(None);
    run(system, start, criteria, |_, iterate, f, jacobian| {
        let kept = first.get().unwrap_or(*jacobian);
        first.set(Some(kept));
        Some(subtract(&iterate.x, &solve(&kept, f)?, 1.0))
    })
}

/// Damped Newton's method: `x <- x - 2^-i d` with `d = Df(x)^-1 f(x)` and i by Armijo's rule.
///
/// With `h = |f|^2`, let j be the smallest number for which the step of 2^-j reduces h by the share 2^-j / 2 at least; of
/// the steps 1, 1/2 ... 2^-j the one with the smallest h is taken. If j would be more than 10 the iteration
/// ends. If the set where h is at most that of the start is compact and Df is invertible on it, the limit points of
/// the iteration are roots; close to one, i is 0 and convergence quadratic.
///
/// # Source
/// @pumberger2010 algorithm 3.3.3.2; the bound on j is the M of section 3.3.2. Departures: gamma of its condition (3.22)
/// is the cosine between d and the gradient of h instead of the reciprocal condition number, which is a lower bound of
/// it: the right side becomes `(1 - 2^-j / 2) h` and no condition number is needed. The program of section 5.6 seeks the
/// zero of a difference of norms instead of i, which is not unique.
#[must_use]
pub(super) fn damped<const N: usize>(
    system: &impl NonlinearSystem<N>,
    start: [f64; N],
    criteria: StoppingCriteria,
) -> NewtonOutcome<N> {
    run(system, start, criteria, |system, iterate, f, jacobian| {
        let step = solve(jacobian, f)?;
        Some(armijo(system, iterate, &step))
    })
}

/// The loop of all variants. `advance` returns the next point, or `None` if the Jacobian is singular; it may count
/// evaluations, and returns the same point to give up.
fn run<const N: usize, S: NonlinearSystem<N>>(
    system: &S,
    start: [f64; N],
    criteria: StoppingCriteria,
    advance: impl Fn(&S, &mut Iterate<N>, &[f64; N], &Jacobian<N>) -> Option<[f64; N]>,
) -> NewtonOutcome<N> {
    let mut iterate = Iterate { x: start, residual: f64::INFINITY, iterations: 0, evaluations: 0 };
    if !inside(system, &start) {
        return NewtonOutcome::LeftDomain(iterate);
    }
    loop {
        let (f, jacobian) = system.linear(&iterate.x);
        iterate.evaluations += 1;
        iterate.residual = norm(&f);
        if iterate.residual <= criteria.residual {
            return NewtonOutcome::Converged(iterate);
        }
        if iterate.iterations >= criteria.iterations {
            return NewtonOutcome::NotConverged(iterate);
        }
        let Some(next) = advance(system, &mut iterate, &f, &jacobian) else {
            return NewtonOutcome::Singular(iterate);
        };
        if !inside(system, &next) {
            return NewtonOutcome::LeftDomain(iterate);
        }
        if next == iterate.x {
            return NewtonOutcome::NotConverged(iterate);
        }
        iterate.x = next;
        iterate.iterations += 1;
    }
}

/// The point `iterate.x - 2^-i step` by Armijo's rule; `iterate.x` itself if no step is good enough.
fn armijo<const N: usize>(
    system: &impl NonlinearSystem<N>,
    iterate: &mut Iterate<N>,
    step: &[f64; N],
) -> [f64; N] {
    let h = iterate.residual * iterate.residual;
    let mut best = (h, iterate.x);
    let mut length = 1.0;
    for _ in 0..=MOST_HALVINGS {
        let x = subtract(&iterate.x, step, length);
        // Outside the domain f has no value: a shorter step is needed.
        if inside(system, &x) {
            iterate.evaluations += 1;
            let at = norm(&system.value(&x)).powi(2);
            if at < best.0 {
                best = (at, x);
            }
            if at <= (1.0 - 0.5 * length) * h {
                return best.1;
            }
        }
        length *= 0.5;
    }
    iterate.x
}

fn inside<const N: usize>(system: &impl NonlinearSystem<N>, x: &[f64; N]) -> bool {
    x.iter().all(|x| x.is_finite()) && system.contains(x)
}

fn norm<const N: usize>(f: &[f64; N]) -> f64 {
    f.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn subtract<const N: usize>(x: &[f64; N], step: &[f64; N], length: f64) -> [f64; N] {
    std::array::from_fn(|i| x[i] - length * step[i])
}

/// The solution z of `matrix z = right`; `None` if the matrix has no inverse within rounding.
///
/// Gaussian elimination with row pivots. A pivot must exceed the rounding of the largest entry of its original column, since
/// variables may have any units.
fn solve<const N: usize>(matrix: &Jacobian<N>, right: &[f64; N]) -> Option<[f64; N]> {
    let (mut a, mut b) = (*matrix, *right);
    for k in 0..N {
        let largest = matrix.iter().fold(0.0_f64, |m, row| m.max(row[k].abs()));
        let pivot = (k..N).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        // This comparison also fails for NaN.
        if a[pivot][k].abs().partial_cmp(&(gamma(4 * N as u32) * largest))
            != Some(std::cmp::Ordering::Greater)
        {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        let row = a[k];
        for i in k + 1..N {
            let factor = a[i][k] / row[k];
            for (entry, above) in a[i].iter_mut().zip(row).skip(k) {
                *entry -= factor * above;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The q of condition C of [`simplified`], from the Jacobian at the start and the largest row sum norm by which that of
    /// another point of the domain differs; `None` if it has no inverse within rounding.
    ///
    /// # Source
    /// @pumberger2010 theorem 3.2.3.1 (C).
    #[must_use]
    fn contraction<const N: usize>(jacobian: &Jacobian<N>, deviation: f64) -> Option<f64> {
        // The i-th row sum of the inverse, column by column.
        let mut sums = [0.0; N];
        for j in 0..N {
            let unit = std::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
            let column = solve(jacobian, &unit)?;
            for (sum, x) in sums.iter_mut().zip(column) {
                *sum += x.abs();
            }
        }
        Some(sums.into_iter().fold(0.0, f64::max) * deviation)
    }

    fn criteria(iterations: u32) -> StoppingCriteria {
        StoppingCriteria { residual: 1e-13, iterations }
    }

    fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
        a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    }

    /// x^2 + y^2 = 2 and x = y^3: roots at (1, 1) and (-1, -1).
    fn circle_and_cubic(&[x, y]: &[f64; 2]) -> ([f64; 2], Jacobian<2>) {
        ([x * x + y * y - 2.0, x - y.powi(3)], [[2.0 * x, 2.0 * y], [1.0, -3.0 * y * y]])
    }

    /// Arc tangents: Newton's method for one diverges from starts beyond 1.3917, where a step leads to the point opposite.
    fn arc_tangents(x: &[f64; 2]) -> ([f64; 2], Jacobian<2>) {
        let slope = |x: f64| 1.0 / (1.0 + x * x);
        (x.map(f64::atan), [[slope(x[0]), 0.0], [0.0, slope(x[1])]])
    }

    #[test]
    fn circle_and_line_meet_at_one() {
        let system = |&[x, y]: &[f64; 2]| ([x * x + y * y - 2.0, x - y], [[2.0 * x, 2.0 * y], [1.0, -1.0]]);
        let criteria = StoppingCriteria { residual: 1e-12, iterations: 10 };
        let NewtonOutcome::Converged(iterate) = general(&system, [2.0, 0.5], criteria) else { panic!() };
        assert!(distance(&iterate.x, &[1.0, 1.0]) < 1e-12);
    }

    #[test]
    fn all_variants_reach_roots_of_closed_form() {
        // x + y + z = 6, x y z = 6, x^2 + y^2 + z^2 = 14 at (1, 2, 3) and its permutations.
        let symmetric = |&[x, y, z]: &[f64; 3]| {
            (
                [x + y + z - 6.0, x * y * z - 6.0, x * x + y * y + z * z - 14.0],
                [[1.0; 3], [y * z, x * z, x * y], [2.0 * x, 2.0 * y, 2.0 * z]],
            )
        };
        let start = [0.95, 2.04, 3.05];
        for outcome in [
            general(&symmetric, start, criteria(20)),
            simplified(&symmetric, start, criteria(100)),
            damped(&symmetric, start, criteria(20)),
        ] {
            let iterate = outcome.converged().unwrap();
            assert!(distance(&iterate.x, &[1.0, 2.0, 3.0]) < 1e-12, "{iterate:?}");
        }
        let iterate = *general(&circle_and_cubic, [2.0, 0.5], criteria(20)).converged().unwrap();
        assert!(distance(&iterate.x, &[1.0, 1.0]) < 1e-13);
    }

    #[test]
    fn general_method_converges_with_order_two() {
        // The n-th iterate is the end of a run of n steps.
        let error =
            |n| distance(&general(&circle_and_cubic, [2.0, 0.5], criteria(n)).iterate().x, &[1.0, 1.0]);
        let errors: Vec<f64> = (3..=6).map(error).filter(|e| *e > 1e-14).collect();
        assert!(errors.len() >= 3, "{errors:?}");
        for e in errors.windows(3) {
            let order = (e[2] / e[1]).ln() / (e[1] / e[0]).ln();
            assert!((1.7..2.4).contains(&order), "{order} of {errors:?}");
        }
    }

    #[test]
    fn simplified_method_contracts_by_the_factor_of_condition_c() {
        // Df of the circle and cubic differs within |z - x0| <= r by at most 2 r + 2 r in the first row, and by
        // 3 |y^2 - y0^2| <= 3 r (2 y0 + r) in the second.
        let (start, r): ([f64; 2], f64) = ([1.02, 0.98], 0.1);
        let (_, jacobian) = circle_and_cubic(&start);
        let q = contraction(&jacobian, (4.0 * r).max(3.0 * r * (2.0 * start[1] + r))).unwrap();
        let iterate = |n| simplified(&circle_and_cubic, start, criteria(n)).iterate().x;
        let points: Vec<[f64; 2]> = (0..8).map(iterate).collect();
        let first = distance(&points[1], &points[0]);
        let radius = q / (1.0 - q) * first;
        assert!(q < 0.5 && distance(&points[1], &start) + radius < r, "{q} {radius}");
        assert!(distance(&[1.0, 1.0], &points[1]) <= radius);
        for p in points.windows(3) {
            let (before, after) = (distance(&p[1], &p[0]), distance(&p[2], &p[1]));
            assert!(after <= q * before + 1e-15, "{after} {before} {q}");
        }
        // It is linear: the last of these steps is far from rounding.
        assert!(distance(&points[4], &points[3]) > 1e-12);
    }

    #[test]
    fn contraction_factor_is_the_norm_of_the_inverse_times_the_deviation() {
        // The inverse of ((2, 1), (1, 1)) is ((1, -1), (-1, 2)) with row sums 2 and 3.
        assert!((contraction(&[[2.0, 1.0], [1.0, 1.0]], 0.25).unwrap() - 0.75).abs() < 1e-15);
        assert_eq!(contraction(&[[1.0, 2.0], [2.0, 4.0]], 0.25), None);
    }

    #[test]
    fn armijo_descends_where_general_newton_diverges() {
        let start = [2.0, -3.0];
        let diverging = general(&arc_tangents, start, criteria(4));
        assert!(diverging.iterate().residual > norm(&arc_tangents(&start).0), "{diverging:?}");
        assert_eq!(general(&arc_tangents, start, criteria(50)).converged(), None);
        let mut last = f64::INFINITY;
        for n in 0..20 {
            let outcome = damped(&arc_tangents, start, criteria(n));
            let iterate = outcome.iterate();
            assert!(iterate.residual < last || outcome.converged().is_some(), "{n} {iterate:?}");
            last = iterate.residual;
        }
        let iterate = *damped(&arc_tangents, start, criteria(20)).converged().unwrap();
        assert!(distance(&iterate.x, &[0.0, 0.0]) < 1e-13 && iterate.iterations < 10);
        assert!(iterate.evaluations > iterate.iterations + 1, "no step was damped");
    }

    #[test]
    fn singular_jacobian_is_said_whatever_the_units() {
        for unit in [1.0, 1e-150, 1e150] {
            let fold = |&[x, y]: &[f64; 2]| ([unit * x * x + unit, y], [[2.0 * unit * x, 0.0], [0.0, 1.0]]);
            assert!(
                matches!(general(&fold, [0.0, 1.0], criteria(9)), NewtonOutcome::Singular(e) if e.iterations == 0)
            );
            assert!(!matches!(general(&fold, [1.0, 1.0], criteria(0)), NewtonOutcome::Singular(_)));
            // Columns of different units are no reason.
            let fine = |&[x, y]: &[f64; 2]| ([unit * x - unit, y - 2.0], [[unit, 0.0], [0.0, 1.0]]);
            let iterate = *general(&fine, [0.0, 0.0], criteria(3)).converged().unwrap();
            assert_eq!((iterate.x, iterate.iterations), ([1.0, 2.0], 1));
        }
    }

    #[test]
    fn ends_without_root_are_distinguished() {
        struct Half;
        impl NonlinearSystem<2> for Half {
            fn linear(&self, x: &[f64; 2]) -> ([f64; 2], Jacobian<2>) {
                ([x[0] + 1.0, x[1]], [[1.0, 0.0], [0.0, 1.0]])
            }
            fn contains(&self, x: &[f64; 2]) -> bool {
                x[0] >= 0.0
            }
        }
        assert!(
            matches!(general(&Half, [1.0, 1.0], criteria(9)), NewtonOutcome::LeftDomain(e) if e.x == [1.0, 1.0])
        );
        assert!(
            matches!(general(&Half, [-1.0, 1.0], criteria(9)), NewtonOutcome::LeftDomain(e) if e.evaluations == 0)
        );
        assert!(matches!(general(&Half, [f64::NAN, 1.0], criteria(9)), NewtonOutcome::LeftDomain(_)));
        // The damped method stays inside: its steps end at the border.
        assert!(damped(&Half, [1.0, 1.0], criteria(60)).iterate().x[0] >= 0.0);
        // x^2 + 1 has no root.
        let none = |&[x, y]: &[f64; 2]| ([x * x + 1.0, y], [[2.0 * x, 0.0], [0.0, 1.0]]);
        assert!(
            matches!(general(&none, [0.7, 1.0], criteria(9)), NewtonOutcome::NotConverged(e) if e.iterations == 9)
        );
        let stuck = damped(&none, [0.7, 1.0], criteria(200));
        assert!(stuck.converged().is_none() && stuck.iterate().residual >= 1.0);
    }
}
