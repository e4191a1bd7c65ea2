//! The search for the best displacements, in rounds.

use std::cell::{Cell, RefCell};
use std::time::Instant;

use argmin::core::{IterState, Problem, Solver, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::neldermead::NelderMead;
use argmin::solver::quasinewton::LBFGS;
use glanz_job::{CancelFlag, CheckpointTimer, JobEnd, JobProgress, ProgressSink, ResourceBudget, WorkCount};
use glanz_math::Bounds3;
use glanz_scene::Description;
use glanz_scene::description::{GeometryDescription, GroupDescription, TargetKind, VariableQuantity};
use serde::{Deserialize, Serialize};

use super::error::OptimizeError;
use super::merit::TargetMeasure;
use super::ray_model::RayModel;
use super::scaled_problem::{BestPoint, MeritFunction, ScaledProblem, VariableScale};

/// Steps of a round. After each round shadows and reflectances are computed anew, and the solver forgets its past.
const ROUND: u32 = 60;
/// Rounds after which the next finer level of distributions counts, too.
const LEVEL_ROUNDS: u32 = 2;
/// Steps of a round without derivatives, each of one or two evaluations.
const SIMPLEX_ROUND: u32 = 400;
/// Pairs of steps and changes of gradients from which the solver knows the curvature.
const MEMORY: usize = 12;
/// Evaluations after which a step is given up, besides one for each variable. A line search needs two or three.
const STEP_EVALUATIONS: u32 = 40;
/// Relative improvement of a round below which the search ends.
const IMPROVEMENT: f64 = 1e-3;
/// Merit at which there is nothing left to improve.
const IDEAL: f64 = 1e-15;
/// Usual displacement of a variable without bounds, in diagonals of what it moves.
const USUAL: f64 = 0.01;
/// First step of the simplex, in units of the scaled variables.
const SIMPLEX: f64 = 0.3;

/// Step of differences, in scaled variables. Of a smooth merit, their error is about its square.
const DIFFERENCE: f64 = 1e-5;

/// The way to the gradient of the merit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GradientMethod {
    /// Derivatives of the rays in reverse.
    #[default]
    Adjoint,
    /// Central differences: two evaluations of the merit for each variable. For comparison.
    Differences,
}

/// Settings of an inverse design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptimizeSettings {
    /// Number of rays, from 1.
    pub rays: usize,
    /// Largest number of steps.
    pub iterations: u32,
    /// Seed of the rays.
    pub seed: u64,
    /// How gradients are computed.
    pub gradient: GradientMethod,
}

impl Default for OptimizeSettings {
    /// 65,536 rays, 600 steps.
    fn default() -> Self {
        Self { rays: 1 << 16, iterations: 600, seed: 0, gradient: GradientMethod::default() }
    }
}

/// The state of a search at the beginning of a round: a search from it has the same bits as one without interruption.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OptimizeState {
    /// Displacements at the beginning of the round, metres.
    pub displacements: Vec<f64>,
    /// Steps before it.
    pub iterations: u32,
    /// Evaluations of the merit before it.
    pub evaluations: u64,
    /// Finest levels of distributions that do not count yet, and rounds since one was added.
    pub skipped_levels: [u32; 2],
    /// Whether the search has ended.
    pub is_complete: bool,
}

/// Result of an inverse design.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimizeOutcome {
    /// Displacements of the variables, metres.
    pub displacements: Vec<f64>,
    /// Merit of the scene as it was given and of the result; 0 is ideal.
    pub merit: [f64; 2],
    /// What each target reaches, before and after.
    pub measures: [Vec<TargetMeasure>; 2],
    /// Whether derivatives were used.
    pub by_gradient: bool,
    /// Number of rays.
    pub rays: usize,
    /// Number of steps.
    pub iterations: u32,
    /// Evaluations of the merit, with their gradients.
    pub evaluations: u64,
    /// Why the search ended.
    pub end: JobEnd,
    /// The state to continue from.
    pub state: OptimizeState,
}

/// Moves the variables of the scene until its targets are met as well as possible, from `state` if a search is resumed.
///
/// A cancelled search returns the best displacements so far. The limits of `budget`, whose flag does not count, hold for each scene on the way.
///
/// # Errors
/// [`OptimizeError`] if the scene has no variable, target or reflected light, or something that is not supported, if `state` has another number of displacements, or if a scene on the way
/// reaches a limit.
pub fn optimize(
    description: &Description,
    settings: &OptimizeSettings,
    state: Option<OptimizeState>,
    sink: &mut (dyn ProgressSink<OptimizeState> + '_),
    cancel: &CancelFlag,
    budget: &ResourceBudget,
) -> Result<OptimizeOutcome, OptimizeError> {
    let variables = &description.design.variables;
    if variables.is_empty() {
        return Err(OptimizeError::NoVariable);
    }
    if let Some(state) = &state
        && state.displacements.len() != variables.len()
    {
        let (found, expected) = (state.displacements.len(), variables.len());
        return Err(OptimizeError::State { found, expected });
    }
    let mut search = Search {
        description,
        settings,
        model: RayModel::new(description, settings.rays, settings.seed, budget)?,
        by_gradient: is_smooth(description),
        scales: scales(description),
        cancel,
        budget,
        start: Instant::now(),
        first_iteration: state.as_ref().map_or(0, |state| state.iterations),
        skipped: 0,
    };
    let before = search.model.value(&vec![0.0; variables.len()], false);
    let skipped_levels = [search.model.skip_levels(0) as u32, 0];
    let displacements = vec![0.0; variables.len()];
    let unmoved = || OptimizeState { displacements, skipped_levels, ..OptimizeState::default() };
    let mut state = state.unwrap_or_else(unmoved);
    let mut best = BestPoint { merit: f64::INFINITY, displacements: state.displacements.clone() };
    let (mut iterations, mut evaluations) = (state.iterations, state.evaluations);
    let mut timer = CheckpointTimer::new(sink.checkpoint_interval());
    while !state.is_complete && !cancel.is_cancelled() {
        let round = match search.round(&state, sink) {
            Ok(round) => round,
            Err(error) => {
                // The rounds before have kept to the limit.
                if error.budget().is_some() {
                    sink.on_checkpoint(&state);
                }
                return Err(error);
            }
        };
        (iterations, evaluations, best) = (round.iterations, round.evaluations, round.best);
        // The round did not see how its displacements move shadows.
        best.merit = search.measured(&best.displacements)?.merit;
        if best.merit.is_nan() || best.merit >= round.start_merit {
            best = BestPoint { merit: round.start_merit, displacements: state.displacements.clone() };
        }
        if cancel.is_cancelled() {
            break;
        }
        // A merit that is no number is not improved.
        let is_improved = best.merit <= (1.0 - IMPROVEMENT) * round.start_merit;
        let is_settled = !is_improved || best.merit <= IDEAL;
        let [skipped, rounds] = state.skipped_levels;
        let is_finest = skipped == 0;
        state = OptimizeState {
            displacements: best.displacements.clone(),
            iterations,
            evaluations,
            skipped_levels: match is_settled || rounds + 1 >= LEVEL_ROUNDS {
                true if !is_finest => [skipped - 1, 0],
                _ => [skipped, rounds.saturating_add(1)],
            },
            is_complete: is_settled && is_finest || iterations >= settings.iterations,
        };
        if timer.is_due() {
            timer.save(|| sink.on_checkpoint(&state));
        }
    }
    search.skipped = 0;
    let mut after = search.measured(&best.displacements)?;
    // Rounds that left levels out may have gone astray.
    if after.merit.is_nan() || after.merit > before.merit {
        best.displacements.fill(0.0);
        after = before.clone();
    }
    Ok(OptimizeOutcome {
        merit: [before.merit, after.merit],
        measures: [before.measures, after.measures],
        displacements: best.displacements,
        by_gradient: search.by_gradient,
        rays: search.model.len(),
        iterations,
        evaluations,
        end: if state.is_complete { JobEnd::Complete } else { JobEnd::Interrupted },
        state,
    })
}

struct Search<'a> {
    description: &'a Description,
    settings: &'a OptimizeSettings,
    model: RayModel,
    by_gradient: bool,
    scales: Vec<VariableScale>,
    cancel: &'a CancelFlag,
    budget: &'a ResourceBudget,
    start: Instant,
    /// Steps before this run.
    first_iteration: u32,
    /// Finest levels of distributions that do not count.
    skipped: usize,
}

/// State of a solver with gradients `G`.
type SolverState<G> = IterState<Vec<f64>, G, (), (), (), f64>;

/// Result of a round.
struct RoundOutcome {
    best: BestPoint,
    start_merit: f64,
    iterations: u32,
    evaluations: u64,
}

impl Search<'_> {
    /// The model with displacements that its rays do not know.
    fn rebuilt(&self, displacements: &[f64]) -> Result<RayModel, OptimizeError> {
        let displaced = self.description.displaced(displacements);
        let mut model = RayModel::new(&displaced, self.settings.rays, self.settings.seed, self.budget)?;
        model.skip_levels(self.skipped);
        Ok(model)
    }

    fn measured(&mut self, displacements: &[f64]) -> Result<super::ray_model::DesignValue, OptimizeError> {
        if !self.by_gradient {
            return Ok(self.rebuilt(displacements)?.value(&[], false));
        }
        self.model.refresh(self.description, displacements)?;
        self.model.skip_levels(self.skipped);
        Ok(self.model.value(displacements, false))
    }

    /// The merit with its gradient.
    fn with_gradient(&self, displacements: &[f64]) -> (f64, Vec<f64>) {
        if self.settings.gradient == GradientMethod::Adjoint {
            let value = self.model.value(displacements, true);
            return (value.merit, value.gradient);
        }
        let slope = |(axis, scale): (usize, &VariableScale)| {
            let step = DIFFERENCE * scale.size();
            let beside = |step: f64| {
                let mut moved = displacements.to_vec();
                moved.iter_mut().skip(axis).take(1).for_each(|t| *t += step);
                self.model.value(&moved, false).merit
            };
            (beside(step) - beside(-step)) / (2.0 * step)
        };
        let gradient = self.scales.iter().enumerate().map(slope).collect();
        (self.model.value(displacements, false).merit, gradient)
    }

    fn round(
        &mut self,
        state: &OptimizeState,
        sink: &mut (dyn ProgressSink<OptimizeState> + '_),
    ) -> Result<RoundOutcome, OptimizeError> {
        self.skipped = state.skipped_levels[0] as usize;
        let start_merit = self.measured(&state.displacements)?.merit;
        let best = RefCell::new(BestPoint { merit: start_merit, displacements: state.displacements.clone() });
        let (evaluations, failure) = (Cell::new(state.evaluations), RefCell::new(None));
        let budget = Cell::new(u32::MAX);
        let x: Vec<f64> =
            self.scales.iter().zip(&state.displacements).map(|(scale, &t)| scale.variable(t)).collect();
        let function: Box<MeritFunction<'_>> = if self.by_gradient {
            Box::new(|displacements| self.with_gradient(displacements))
        } else {
            Box::new(|displacements| {
                // A merit that is no number ends a step at once.
                if failure.borrow().is_some() {
                    return (f64::NAN, Vec::new());
                }
                let merit = match self.rebuilt(displacements) {
                    Ok(model) => model.value(&[], false).merit,
                    // What exceeds the resources may be better than all others.
                    Err(error) if error.ends_search() => {
                        *failure.borrow_mut() = Some(error);
                        f64::NAN
                    }
                    // What is no scene is worse.
                    Err(_) => f64::INFINITY,
                };
                (merit, Vec::new())
            })
        };
        let problem = ScaledProblem::new(&self.scales, &function, self.cancel, &best, &evaluations, &budget);
        let mut iterations = state.iterations;
        let mut on_step = |merit: f64| {
            iterations += 1;
            self.report(sink, iterations, merit);
            iterations < self.settings.iterations && merit > IDEAL && failure.borrow().is_none()
        };
        if self.by_gradient {
            let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
            take_steps(solver, IterState::new().param(x), problem, ROUND, &mut on_step);
        } else {
            let mut simplex = vec![x.clone()];
            simplex.extend((0..x.len()).map(|axis| {
                let mut corner = x.clone();
                corner.iter_mut().skip(axis).take(1).for_each(|x| *x += SIMPLEX);
                corner
            }));
            let state: SolverState<()> = IterState::new();
            take_steps(NelderMead::new(simplex), state, problem, SIMPLEX_ROUND, &mut on_step);
        }
        drop(function);
        if let Some(error) = failure.into_inner() {
            return Err(error);
        }
        Ok(RoundOutcome { best: best.into_inner(), start_merit, iterations, evaluations: evaluations.get() })
    }

    fn report(&self, sink: &mut (dyn ProgressSink<OptimizeState> + '_), iterations: u32, merit: f64) {
        let wanted = self.settings.iterations;
        // The time left follows from the steps of this run.
        let share = |before: u32| f64::from(iterations - before) / f64::from(wanted.max(iterations) - before);
        let count =
            WorkCount { done: iterations.into(), wanted: Some(wanted.into()), unit: ["step", "steps"] };
        let phase = format!("optimisation, merit {merit:.3e}");
        let progress = JobProgress::by_work(&phase, share(self.first_iteration), self.start.elapsed());
        sink.on_progress(&JobProgress { fraction: share(0), ..progress }.with_count(count));
    }
}

/// Takes up to `count` steps of a solver, while `on_step`, which receives the merit, agrees. What is found is the best point of the problem: a solver that ends with an error, such
/// as a line search without a better point at the accuracy of the numbers, has done what it can.
fn take_steps<'a, S, G>(
    mut solver: S,
    state: SolverState<G>,
    problem: ScaledProblem<'a>,
    count: u32,
    on_step: &mut dyn FnMut(f64) -> bool,
) where
    S: Solver<ScaledProblem<'a>, SolverState<G>>,
    SolverState<G>: State<Float = f64>,
{
    let (budget, variables) = (problem.budget, problem.scales.len() as u32);
    let mut problem = Problem::new(problem);
    let Ok((mut state, _)) = solver.init(&mut problem, state) else { return };
    state.update();
    for _ in 0..count {
        // The simplex method may evaluate all corners.
        budget.set(STEP_EVALUATIONS + variables);
        let Ok((next, _)) = solver.next_iter(&mut problem, state) else { return };
        state = next;
        // A line search without a result leaves a state without gradient, which must not be asked for more.
        if state.terminated() {
            return;
        }
        state.increment_iter();
        state.update();
        let is_converged = solver.terminate(&state).terminated();
        if !on_step(state.get_best_cost()) || is_converged {
            return;
        }
    }
}

/// The largest displacement of each variable that is usual, and its range.
fn scales(description: &Description) -> Vec<VariableScale> {
    let size = |quantity: &VariableQuantity| {
        let bounds = match *quantity {
            VariableQuantity::ControlPoints { shape, .. }
            | VariableQuantity::ShapeOffset { shape }
            | VariableQuantity::Radius { shape } => {
                description.world.shapes.get(shape).map(|shape| own_bounds(shape.geometry.clone()))
            }
            VariableQuantity::LightPosition { .. } => None,
        };
        let size = bounds.map_or(0.0, |bounds| bounds.diagonal().length());
        if size > 0.0 && size.is_finite() { USUAL * size } else { USUAL }
    };
    let variables = description.design.variables.iter();
    variables.map(|variable| VariableScale::new(variable.range, size(&variable.quantity))).collect()
}

/// The box of a surface in its own frame.
fn own_bounds(geometry: GeometryDescription) -> Bounds3 {
    let world = GroupDescription { shapes: vec![geometry.into()], ..GroupDescription::default() };
    Description { world, ..Description::default() }.bounds()
}

/// Whether rays with fixed parameters follow all variables: point lights, control points of mirrors, and lamps and mirrors as a whole. One variable of another kind takes the derivatives
/// from all.
fn is_smooth(description: &Description) -> bool {
    let design = &description.design;
    let on_receiver = |shape: usize| {
        let is_here = |kind: &TargetKind| !matches!(kind, TargetKind::Collimation { .. });
        design.targets.iter().any(|target| target.shape == shape && is_here(&target.kind))
    };
    let is_lamp =
        |shape: usize| description.world.shapes.get(shape).is_some_and(|shape| shape.emission.is_some());
    design.variables.iter().all(|variable| match variable.quantity {
        VariableQuantity::ControlPoints { shape, .. } => !on_receiver(shape) && !is_lamp(shape),
        VariableQuantity::LightPosition { .. } => true,
        VariableQuantity::ShapeOffset { shape } => !on_receiver(shape),
        VariableQuantity::Radius { .. } => false,
    })
}
