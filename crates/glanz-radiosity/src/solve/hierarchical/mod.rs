//! Hierarchical radiosity with links between nodes whose size depends on a bound of the error.
//!
//! The nodes of a hierarchy, from the whole scene down to small elements, are connected by links, each of which represents all pairs below
//! its two ends (@hanrahan1991). Above the start elements are clusters of near elements with similar normals, so that the triangles of a
//! fine mesh need not be linked one by one (@smits1994); below them are quarters, made where a link has to be divided. A link has a bound
//! on its error, from the range of the kernel over both ends and from shadow rays. Links whose error is too large are divided at their
//! larger end. Solving and dividing alternate with a decreasing bound (departure: importance, @smits1992, is not used, because light maps
//! need all surfaces).
//!
//! The last solution uses form factors from each leaf to the other ends of the links of all its ancestors, with a ray or two each: a link
//! between large nodes then selects the light that is sampled, but does not distribute it. (Departure: @hanrahan1991 distributes it
//! evenly, which makes corners too bright.)
//!
//! Meaning of a bound: for any distribution of light on one end, the irradiance at any point of the other end differs from the link's by at
//! most its error per area, provided that the ranges are correct. They are for flat elements and their clusters that are near for their
//! size, which spheres and cones bound. For elements farther apart the ranges are taken over corners and middles, and visibility is only
//! sampled by rays: the few rays of a link leave a small error if they agree, the whole exchange if they do not. An element on
//! both sides of a thin wall has one radiosity: the leak decreases with the smallest side, and nearly vanishes if the start elements
//! end at the wall ([`Elements::cut_at_walls`]). Where surfaces coincide, such as the bottom of a box and a floor, both
//! count when seen from inside the box.

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink};
use glanz_light::Spectrum;

use crate::elements::Elements;

mod extent;
mod gather;
mod hierarchy;
mod leaves;
mod link;
mod refine;

use gather::NodeLinks;
pub use hierarchy::Exitance;
use hierarchy::{ElementHierarchy, NodeLight};
use leaves::LeafFormFactors;
use refine::{Refinement, RefinementGoal};

/// Change, relative to the largest radiosity, at which the sweeps between two rounds end.
const ROUND_TOLERANCE: f64 = 0.01;

/// Ratio of the bounds of successive rounds.
const BOUND_RATIO: f64 = 0.25;

/// Largest number of form factors of leaves, relative to the largest number of links: links of a node count for all leaves below it.
const LEAF_FACTORS_PER_LINK: usize = 4;

/// Largest number of rounds with the last bound, since light that arrives late may need more links.
const LAST_ROUNDS: u32 = 4;

/// Settings of the hierarchical solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchicalSettings {
    /// Largest error of the flux of a link, relative to the flux of the whole scene (the sum of area times radiosity, of the largest
    /// band); above 0.
    pub bound: f64,
    /// Shortest longest side of a quarter, metres, above 0: larger elements may be divided.
    pub side: f64,
    /// Number of rounds of dividing and solving, each with a quarter of the previous bound, down to `bound`.
    pub rounds: u32,
    /// Change of an element in a sweep, relative to the largest radiosity, at which sweeps end; above 0.
    pub tolerance: f64,
    /// Largest number of sweeps per round.
    pub sweeps: u32,
    /// Largest number of links, approximately; the solver ends early when it is exceeded.
    pub links: usize,
    /// Largest number of elements, each of which takes about 2 KiB of memory; the solver ends early before dividing more. The start
    /// elements may be more.
    pub elements: usize,
    /// Whether the last solution uses form factors of each leaf. Without them links distribute light evenly over their leaves, which
    /// suffices to find where elements have to be small.
    pub leaf_form_factors: bool,
}

impl Default for HierarchicalSettings {
    fn default() -> Self {
        Self {
            bound: 1e-6,
            side: 0.02,
            rounds: 5,
            tolerance: 1e-4,
            sweeps: 200,
            links: 1 << 25,
            elements: 1 << 22,
            leaf_form_factors: true,
        }
    }
}

/// Invalid settings of the hierarchical solver.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HierarchicalError {
    /// Bound, side or tolerance is not positive and finite: its name and its value.
    #[error("{0} of the hierarchical solver is {1}; it must be above 0 and finite")]
    NotPositive(&'static str, f64),
}

/// Bounds on the errors of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkErrors {
    /// Largest error of a link, as in [`HierarchicalSettings::bound`]; it exceeds the requested bound where elements could not be divided further, or if
    /// the solver ended early.
    pub largest: f64,
    /// Number of links whose error exceeds the requested bound.
    pub above: usize,
    /// Sum of the errors of all links in both directions, relative to the flux: a bound on the mean error (over areas) of the irradiance
    /// by links, without its reflections. Errors of single links mostly cancel, so that observed errors are much smaller.
    pub sum: f64,
    /// The part of `sum` from links above the bound.
    pub sum_above: f64,
    /// Largest change of an element in the last sweep, relative to the largest radiosity; infinite if there was no sweep.
    pub change: f64,
}

/// Numbers that describe the work of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolverEffort {
    /// Links at the end.
    pub links: usize,
    /// Nodes of the hierarchy: clusters, and elements of all sizes.
    pub nodes: usize,
    /// Shadow rays of all rounds.
    pub rays: u64,
    /// Rounds of dividing and solving.
    pub rounds: u32,
    /// Sweeps over all links.
    pub sweeps: u32,
}

/// Solution of the hierarchical solver, with its elements.
#[derive(Debug)]
pub struct HierarchicalSolution<'a> {
    /// The smallest elements of the hierarchy. Those of a start element are contiguous, in the order of the start elements.
    pub elements: Elements<'a>,
    /// Radiosity of each element (the flux that leaves it per area), in units of radiance times pi.
    pub radiosity: Vec<Spectrum>,
    /// Irradiance of each element (the flux that arrives per area): radiosity is emission + reflectance x irradiance.
    pub irradiance: Vec<Spectrum>,
    /// Bounds on its errors.
    pub errors: LinkErrors,
    /// Whether all rounds were completed; `false` if it was cancelled or there were too many links or elements.
    pub finished: bool,
    /// Work of the solver.
    pub effort: SolverEffort,
}

/// Solves with emitted light on elements that are divided as needed; `start`: whole faces, or any other elements.
///
/// The result does not depend on the number of threads. `sink` receives the finished rounds; if `cancel` is raised, the result is the
/// solution so far, with its errors.
///
/// # Errors
/// [`HierarchicalError`] for a bound, side or tolerance that is not positive and finite.
///
/// # Source
/// @hanrahan1991, with clusters as in @smits1994 (links between clusters are those of isotropic clusters: a mean over the
/// elements, not one value for each).
pub fn hierarchical<'a>(
    start: Elements<'a>,
    settings: &HierarchicalSettings,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
) -> Result<HierarchicalSolution<'a>, HierarchicalError> {
    hierarchical_with_exitance(start, &|element| element.emission, settings, sink, cancel)
}

/// As [`hierarchical`], with another radiant exitance than the emission of elements, such as the once reflected light of lamps.
///
/// # Errors
/// Those of [`hierarchical`].
pub fn hierarchical_with_exitance<'a>(
    start: Elements<'a>,
    exitance: Exitance<'a>,
    settings: &HierarchicalSettings,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
) -> Result<HierarchicalSolution<'a>, HierarchicalError> {
    let HierarchicalSettings { bound, side, tolerance, .. } = *settings;
    for (name, value) in [("the bound", bound), ("the smallest side", side), ("the tolerance", tolerance)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(HierarchicalError::NotPositive(name, value));
        }
    }
    let mut solver = HierarchicalSolver::new(start, exitance, side);
    let rounds = settings.rounds.max(1);
    let start_time = Instant::now();
    let mut report_round = |round: u32| {
        let fraction = (f64::from(round) / f64::from(rounds + 1)).min(1.0);
        sink.on_progress(&JobProgress::by_work("light between surfaces", fraction, start_time.elapsed()));
        cancel.check()
    };
    for round in 0..rounds + LAST_ROUNDS - 1 {
        let is_last = round + 1 >= rounds;
        let coarser = if is_last { 1.0 } else { BOUND_RATIO.powi(round as i32 + 1 - rounds as i32) };
        let before = (round >= rounds).then_some(solver.refinement.links.len());
        let goal = RefinementGoal {
            error: bound * coarser * solver.hierarchy.flux(),
            links: settings.links,
            elements: settings.elements,
        };
        let mut pause = || report_round(round);
        solver.refinement.refine(&mut solver.hierarchy, &goal, &mut pause);
        if before == Some(solver.refinement.links.len()) {
            break;
        }
        let enough = tolerance.max(ROUND_TOLERANCE);
        solver.solve(enough, settings.sweeps, &mut pause);
        solver.effort.rounds += 1;
        if solver.refinement.stopped {
            break;
        }
    }
    if settings.leaf_form_factors {
        let rounds_made = solver.effort.rounds;
        solver.solve_at_leaves(settings, &mut || report_round(rounds_made));
    }
    Ok(solver.finish(bound))
}

/// State of the solver: hierarchy, links and statistics.
struct HierarchicalSolver<'a> {
    hierarchy: ElementHierarchy<'a>,
    refinement: Refinement,
    effort: SolverEffort,
    change: f64,
}

impl<'a> HierarchicalSolver<'a> {
    fn new(start: Elements<'a>, exitance: Exitance<'a>, side: f64) -> Self {
        let mut hierarchy = ElementHierarchy::new(start, exitance, side);
        hierarchy.pull(|_, _| Spectrum::BLACK);
        let refinement = Refinement::new(&hierarchy);
        Self { hierarchy, refinement, effort: SolverEffort::default(), change: f64::INFINITY }
    }

    /// Sweeps until the change is small enough: each node gathers over its links, then irradiance is pushed down and radiosity pulled up.
    fn solve(&mut self, enough: f64, sweeps: u32, pause: &mut dyn FnMut() -> Result<(), Interrupted>) {
        let node_links = NodeLinks::new(&self.hierarchy, &self.refinement.links, false);
        let gather = |hierarchy: &mut ElementHierarchy<'_>| {
            let pushed = hierarchy.push(&node_links.gather(hierarchy));
            hierarchy.pull(|leaf, node| {
                let (irradiance, sum) = pushed[leaf];
                irradiance * node.scale(sum)
            })
        };
        self.sweep(gather, enough, sweeps, pause);
    }

    /// Sweeps with form factors of the leaves, or over links if these form factors are too many.
    fn solve_at_leaves(
        &mut self,
        settings: &HierarchicalSettings,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let HierarchicalSettings { tolerance, sweeps, links, .. } = *settings;
        if self.refinement.stopped {
            // A cancelled solver must not trace many more rays.
            return self.solve(tolerance, sweeps, pause);
        }
        let node_links = NodeLinks::new(&self.hierarchy, &self.refinement.links, true);
        let Some(leaves) = LeafFormFactors::new(&self.hierarchy, &node_links, LEAF_FACTORS_PER_LINK * links)
        else {
            return self.solve(tolerance, sweeps, pause);
        };
        self.refinement.rays += leaves.rays;
        let gather = |hierarchy: &mut ElementHierarchy<'_>| {
            let gathered = leaves.gather(hierarchy);
            hierarchy.pull(|leaf, _| gathered[leaf])
        };
        self.sweep(gather, tolerance, sweeps, pause);
    }

    /// Sweeps until the change is `enough`; at least once, so that new elements have light.
    fn sweep(
        &mut self,
        gather: impl Fn(&mut ElementHierarchy<'_>) -> f32,
        enough: f64,
        sweeps: u32,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let last = self.effort.sweeps + sweeps;
        loop {
            let change = gather(&mut self.hierarchy);
            let largest =
                self.hierarchy.light.iter().map(|light| light.radiosity.max_component()).fold(0.0, f32::max);
            self.change = if largest > 0.0 { f64::from(change / largest) } else { 0.0 };
            self.effort.sweeps += 1;
            if self.change <= enough || self.effort.sweeps >= last || self.refinement.stopped {
                break;
            }
            self.refinement.stopped |= pause().is_err();
        }
    }

    fn errors(&self, bound: f64) -> LinkErrors {
        let mut errors = LinkErrors { change: self.change, ..LinkErrors::default() };
        let flux = self.hierarchy.flux();
        if flux > 0.0 {
            for link in &self.refinement.links {
                let ends = [link.a, link.b];
                let exchange_error = f64::from(link.error) / flux;
                let error = self.hierarchy.flux_error(ends, exchange_error);
                let radiosity = |node: u32| self.hierarchy.light[node as usize].radiosity.max_component();
                let one = |node: u32| f64::from(radiosity(node)) * exchange_error;
                let both = if link.a == link.b { one(link.a) } else { ends.map(one).iter().sum() };
                errors.largest = errors.largest.max(error);
                errors.sum += both;
                if error > bound {
                    errors.above += 1;
                    errors.sum_above += both;
                }
            }
        }
        errors
    }

    fn finish(self, bound: f64) -> HierarchicalSolution<'a> {
        let errors = self.errors(bound);
        let Refinement { links, rays, stopped } = self.refinement;
        let effort =
            SolverEffort { links: links.len(), nodes: self.hierarchy.nodes.len(), rays, ..self.effort };
        let (elements, light): (_, Vec<NodeLight>) = self.hierarchy.into_leaves();
        HierarchicalSolution {
            elements,
            radiosity: light.iter().map(|light| light.radiosity).collect(),
            irradiance: light.iter().map(|light| light.irradiance).collect(),
            errors,
            finished: !stopped,
            effort,
        }
    }
}

#[cfg(test)]
mod tests;
