//! The merit as a function of unbounded variables of about the same scale, for the optimiser.

use std::cell::{Cell, RefCell};

use argmin::core::{CostFunction, Error as SolverError, Gradient};
use glanz_job::CancelFlag;

/// Displacements by unbounded variables: linear where the range has no end, else by a sine, which reaches both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct VariableScale {
    middle: f64,
    half: f64,
    /// Radians of the sine per unit of the variable; `None` without bounds.
    rate: Option<f64>,
}

/// Part of the half range that is kept free where a displacement lies on an end, at which the sine has no slope.
const INSIDE: f64 = 0.99;

impl VariableScale {
    /// `size`: a usual displacement, metres, which a unit of the variable has at most. A single bound is given a second one far away.
    pub(super) fn new([low, high]: [f64; 2], size: f64) -> Self {
        if low.is_infinite() && high.is_infinite() {
            return Self { middle: 0.0, half: size, rate: None };
        }
        let far = 100.0 * size.max(low.abs().min(high.abs()));
        let (low, high) = (low.max(-far), high.min(far));
        let half = 0.5 * (high - low);
        Self { middle: 0.5 * (low + high), half, rate: Some((size / half).min(1.0)) }
    }

    /// Displacement of a unit of the variable, metres.
    pub(super) fn size(&self) -> f64 {
        self.half * self.rate.unwrap_or(1.0)
    }

    pub(super) fn displacement(&self, x: f64) -> f64 {
        self.middle + self.half * self.rate.map_or(x, |rate| (rate * x).sin())
    }

    fn slope(&self, x: f64) -> f64 {
        self.half * self.rate.map_or(1.0, |rate| rate * (rate * x).cos())
    }

    /// The variable of a displacement in its range.
    pub(super) fn variable(&self, displacement: f64) -> f64 {
        let x = (displacement - self.middle) / self.half;
        self.rate.map_or(x, |rate| x.clamp(-INSIDE, INSIDE).asin() / rate)
    }
}

/// The best variables that were tried.
#[derive(Clone, Debug)]
pub(super) struct BestPoint {
    pub(super) merit: f64,
    pub(super) displacements: Vec<f64>,
}

/// A merit by displacements, with its gradient if it has one.
pub(super) type MeritFunction<'a> = dyn Fn(&[f64]) -> (f64, Vec<f64>) + 'a;

/// The merit and its gradient by scaled variables.
struct EvaluatedPoint {
    x: Vec<f64>,
    merit: f64,
    gradient: Vec<f64>,
}

/// The merit by scaled variables. It remembers the last point, of which solvers ask merit and gradient in turn, and the best one.
pub(super) struct ScaledProblem<'a> {
    pub(super) scales: &'a [VariableScale],
    function: &'a MeritFunction<'a>,
    cancel: &'a CancelFlag,
    last: RefCell<Option<EvaluatedPoint>>,
    best: &'a RefCell<BestPoint>,
    evaluations: &'a Cell<u64>,
    /// Evaluations that are left to the step; `u32::MAX` before the first one.
    pub(super) budget: &'a Cell<u32>,
}

impl<'a> ScaledProblem<'a> {
    pub(super) fn new(
        scales: &'a [VariableScale],
        function: &'a MeritFunction<'a>,
        cancel: &'a CancelFlag,
        best: &'a RefCell<BestPoint>,
        evaluations: &'a Cell<u64>,
        budget: &'a Cell<u32>,
    ) -> Self {
        Self { scales, function, cancel, last: RefCell::new(None), best, evaluations, budget }
    }

    fn evaluated<T>(&self, x: &[f64], pick: impl Fn(f64, &[f64]) -> T) -> Result<T, SolverError> {
        // Another thread may set the flag between two tests of it.
        let (is_cancelled, is_beginning) = (self.cancel.is_cancelled(), self.budget.get() == u32::MAX);
        if is_cancelled && is_beginning {
            // The beginning of the simplex method panics on errors.
            return Ok(pick(f64::INFINITY, &vec![0.0; x.len()]));
        }
        // A line search may go on forever where rounding decides, or where steps are no numbers.
        let left = self.budget.get().saturating_sub(1);
        if left == 0 || is_cancelled || x.iter().any(|x| x.is_nan()) {
            return Err(SolverError::msg("no better point"));
        }
        if let Some(last) = &*self.last.borrow()
            && last.x == x
        {
            return Ok(pick(last.merit, &last.gradient));
        }
        let displacements: Vec<f64> =
            self.scales.iter().zip(x).map(|(scale, &x)| scale.displacement(x)).collect();
        let (merit, mut gradient) = (self.function)(&displacements);
        self.evaluations.set(self.evaluations.get() + 1);
        if merit.is_nan() {
            // No solver ends by itself on a merit that is no number.
            return match is_beginning {
                true => Ok(pick(f64::INFINITY, &vec![0.0; x.len()])),
                false => Err(SolverError::msg("no merit")),
            };
        }
        if !is_beginning {
            self.budget.set(left);
        }
        for (slope, (scale, &x)) in gradient.iter_mut().zip(self.scales.iter().zip(x)) {
            *slope *= scale.slope(x);
        }
        if merit < self.best.borrow().merit {
            *self.best.borrow_mut() = BestPoint { merit, displacements };
        }
        let picked = pick(merit, &gradient);
        *self.last.borrow_mut() = Some(EvaluatedPoint { x: x.to_vec(), merit, gradient });
        Ok(picked)
    }
}

impl CostFunction for ScaledProblem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, SolverError> {
        self.evaluated(x, |merit, _| merit)
    }
}

impl Gradient for ScaledProblem<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, SolverError> {
        self.evaluated(x, |_, gradient| gradient.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merit_that_is_no_number_ends_the_search_and_is_not_the_best() {
        let scales = [VariableScale::new([f64::NEG_INFINITY, f64::INFINITY], 1.0)];
        let function = |t: &[f64]| (if t[0] > 1.0 { f64::NAN } else { t[0] * t[0] }, vec![2.0 * t[0]]);
        let cancel = CancelFlag::default();
        let best = RefCell::new(BestPoint { merit: 9.0, displacements: vec![3.0] });
        let (evaluations, budget) = (Cell::new(0), Cell::new(u32::MAX));
        let problem = ScaledProblem::new(&scales, &function, &cancel, &best, &evaluations, &budget);
        assert_eq!(problem.cost(&vec![2.0]).unwrap(), f64::INFINITY);
        budget.set(10);
        assert!(problem.cost(&vec![3.0]).is_err());
        assert_eq!((problem.cost(&vec![0.5]).unwrap(), best.borrow().merit), (0.25, 0.25));
        cancel.cancel();
        assert!(problem.gradient(&vec![0.1]).is_err());
        budget.set(u32::MAX);
        assert_eq!(problem.cost(&vec![0.1]).unwrap(), f64::INFINITY);
    }

    #[test]
    fn scale_of_a_variable_is_the_smaller_of_its_size_and_its_half_range() {
        assert_eq!(VariableScale::new([-3.0, 1.0], 0.01).size(), 0.01);
        assert_eq!(VariableScale::new([-0.001, 0.003], 0.01).size(), 0.002);
        assert_eq!(VariableScale::new([0.0, f64::INFINITY], 0.01).size(), 0.01);
    }

    #[test]
    fn scaled_variables_stay_in_their_ranges_and_return_to_their_displacements() {
        for (range, inside) in
            [([-0.2, 0.1], 0.05), ([f64::NEG_INFINITY, f64::INFINITY], -7.0), ([0.0, f64::INFINITY], 0.5)]
        {
            let scale = VariableScale::new(range, 0.01);
            assert!(scale.size() <= 0.01 * (1.0 + 1e-12));
            let x = scale.variable(inside);
            assert!((scale.displacement(x) - inside).abs() < 1e-12, "{range:?}");
            let h = 1e-6;
            let slope = (scale.displacement(x + h) - scale.displacement(x - h)) / (2.0 * h);
            assert!((slope - scale.slope(x)).abs() < 1e-8 * slope.abs(), "{range:?}");
            for x in [-900.0, -1.0, 0.0, 2.0, 10_000.0] {
                let t = scale.displacement(x);
                assert!(t >= range[0] - 1e-15 && t <= range[1] + 1e-15);
            }
        }
    }
}
