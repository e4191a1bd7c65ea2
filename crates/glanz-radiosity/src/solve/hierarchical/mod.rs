//! Every pair of surfaces exchanges light between parts that are as large as its share of the error allows.
//!
//! Nodes of a hierarchy, from the whole scene down to small elements, are joined by links of which each stands for all pairs below its
//! two ends (@hanrahan1991). Above the start elements are clusters of what is near and faces one way, so that the many triangles of a
//! fine mesh do not meet one by one (@smits1994); below are quarters, made where a link asks for them. A link carries a bound on how
//! much more or less it may be than what it says, from the ranges of the kernel over both ends and from rays; links whose error
//! is too large are divided at their larger end, and solving and dividing take turns with a bound that falls
//! (departure: the importance of what is seen, @smits1992, is not used: light maps are wanted everywhere).
//!
//! In the end each leaf computes its form factors to the other ends of the links of all nodes above it, with a ray or two each: a link
//! between large nodes then decides what light is sampled, not where it goes. (Departure: @hanrahan1991 spreads it evenly, which
//! makes corners too light.)
//!
//! What a bound says: light of whatever distribution on one end makes at any place of the other an irradiance that differs from the
//! link's by its error per area at most, if the ranges hold. They do for flat elements and clusters of them that are near for their
//! size, as spheres and cones bound those; for elements farther apart they are ranges over corners and middles, and of visibility only
//! rays are known: few that agree leave a rest of doubt, and those that disagree leave all of it. An element that reaches behind a thin
//! wall has one radiosity on both of its sides: what leaks so goes down with the smallest side, or is next to nothing if the start elements end at the
//! wall ([`Elements::cut_at_walls`]). Surfaces that lie in one another, as the bottom of a box on a floor, both count where the box is
//! seen from inside.

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink};
use glanz_light::Spectrum;

use crate::elements::Elements;

mod extent;
mod gather;
mod leaves;
mod link;
mod refine;
mod tree;

use gather::Neighbours;
use leaves::Leaves;
use refine::{Demand, Refinement};
pub use tree::Exitance;
use tree::{Light, Tree};

/// Sweeps between two rounds stop at this change.
const BETWEEN: f64 = 0.01;

/// How much smaller the bound of a round is than that of the one before.
const STEP: f64 = 0.25;

/// Form factors of leaves for each link that there may be, at most: links of a node count for all leaves below it.
const PER_LINK: usize = 4;

/// Rounds with the last bound, at most: light that came late may ask for more links.
const LAST: u32 = 4;

/// How well to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hierarchical {
    /// Largest flux that a link may carry too much or too little, as a share of the flux of the whole scene (the sum of area times
    /// radiosity, of the largest band).
    pub bound: f64,
    /// Elements are not divided into quarters whose longest side is shorter than this, metres.
    pub side: f64,
    /// Rounds of dividing and solving, each with a quarter of the bound before, down to `bound`.
    pub rounds: u32,
    /// Largest change of an element in the last sweep, per the largest radiosity.
    pub tolerance: f64,
    /// Sweeps per round, at most.
    pub sweeps: u32,
    /// Links at most, about: then the answer is what can be said with these.
    pub links: usize,
    /// Whether each leaf finds form factors of its own in the end. Without them light is that of links, even where a leaf sees
    /// less than those above it: enough for those who only want to know where elements are to be small.
    pub factors_of_leaves: bool,
}

impl Default for Hierarchical {
    fn default() -> Self {
        Self {
            bound: 1e-6,
            side: 0.02,
            rounds: 5,
            tolerance: 1e-4,
            sweeps: 200,
            links: 1 << 25,
            factors_of_leaves: true,
        }
    }
}

/// Why there is nothing to solve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HierarchicalError {
    /// Bound, side or tolerance are no such thing.
    #[error("{0} must be above 0, not {1}")]
    NotPositive(&'static str, f64),
}

/// How wrong the answer may be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// The largest error of a link, as in [`Hierarchical::bound`]; larger than what was asked for where elements could not be divided
    /// further, or where the solver was stopped.
    pub largest: f64,
    /// Links with a larger error than was asked for.
    pub above: usize,
    /// The sum of the errors of all links, both ways, as a share of the flux: a bound on the mean error of the irradiance
    /// (over areas) made by the links, before the light is reflected again. Errors of single links mostly cancel: it is
    /// much larger than what is observed.
    pub sum: f64,
    /// What links above the bound have of it.
    pub sum_above: f64,
    /// Largest change in the last sweep, per the largest radiosity; infinite if there was none.
    pub change: f64,
}

/// What it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Links in the end.
    pub links: usize,
    /// Nodes of the hierarchy: clusters, and elements of all sizes.
    pub nodes: usize,
    /// Rays of all rounds.
    pub rays: u64,
    /// Rounds of dividing and solving.
    pub rounds: u32,
    /// Sweeps over all links.
    pub sweeps: u32,
}

/// A solution on elements of its own.
#[derive(Debug)]
pub struct Refined<'a> {
    /// The smallest elements of the hierarchy. Those of a start element follow one another, in its place.
    pub elements: Elements<'a>,
    /// Radiosity of each element: what leaves a unit of its area, in units of radiance times pi.
    pub radiosity: Vec<Spectrum>,
    /// What meets a unit of its area: radiosity is emission + reflectance x irradiance.
    pub irradiance: Vec<Spectrum>,
    /// What is known of its errors.
    pub errors: Errors,
    /// Whether all rounds were made: not if it was stopped, or links became too many.
    pub finished: bool,
    /// What it took.
    pub effort: Effort,
}

/// Solves on elements that it divides itself, from `start`: whole faces, or whatever is there.
///
/// The answer does not depend on the number of threads. `sink` receives the rounds that are finished; after
/// `cancel` is raised, the answer is what there is, with its errors.
///
/// # Errors
/// [`HierarchicalError`].
///
/// # Source
/// @hanrahan1991, with clusters as in @smits1994 (links between clusters are those of isotropic clusters: a mean over the
/// elements, not one value for each).
pub fn hierarchical<'a>(
    start: Elements<'a>,
    settings: &Hierarchical,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
) -> Result<Refined<'a>, HierarchicalError> {
    hierarchical_with(start, &|element| element.emission, settings, sink, cancel)
}

/// The same with light that elements have otherwise than from their own emission, such as that of lamps, reflected once.
///
/// # Errors
/// [`HierarchicalError`].
pub fn hierarchical_with<'a>(
    start: Elements<'a>,
    exitance: Exitance<'a>,
    settings: &Hierarchical,
    sink: &mut dyn ProgressSink,
    cancel: &CancelFlag,
) -> Result<Refined<'a>, HierarchicalError> {
    let Hierarchical { bound, side, tolerance, .. } = *settings;
    for (name, value) in [("the bound", bound), ("the smallest side", side), ("the tolerance", tolerance)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(HierarchicalError::NotPositive(name, value));
        }
    }
    let mut solver = Solver::new(start, exitance, side);
    let rounds = settings.rounds.max(1);
    let begun = Instant::now();
    let mut report_round = |round: u32| {
        let fraction = (f64::from(round) / f64::from(rounds + 1)).min(1.0);
        sink.on_progress(&JobProgress::by_work("light between surfaces", fraction, begun.elapsed()));
        cancel.check()
    };
    for round in 0..rounds + LAST - 1 {
        let is_last = round + 1 >= rounds;
        let coarser = if is_last { 1.0 } else { STEP.powi(round as i32 + 1 - rounds as i32) };
        let before = (round >= rounds).then_some(solver.refinement.links.len());
        let demand = Demand { error: bound * coarser * solver.tree.flux(), links: settings.links };
        let mut pause = || report_round(round);
        solver.refinement.refine(&mut solver.tree, &demand, &mut pause);
        if before == Some(solver.refinement.links.len()) {
            break;
        }
        let enough = tolerance.max(BETWEEN);
        solver.solve(enough, settings.sweeps, &mut pause);
        solver.effort.rounds += 1;
        if solver.refinement.stopped {
            break;
        }
    }
    if settings.factors_of_leaves {
        let rounds_made = solver.effort.rounds;
        solver.solve_at_leaves(settings, &mut || report_round(rounds_made));
    }
    Ok(solver.finish(bound))
}

/// Hierarchy and links on their way.
struct Solver<'a> {
    tree: Tree<'a>,
    refinement: Refinement,
    effort: Effort,
    change: f64,
}

impl<'a> Solver<'a> {
    fn new(start: Elements<'a>, exitance: Exitance<'a>, side: f64) -> Self {
        let mut tree = Tree::new(start, exitance, side);
        tree.pull(|_, _| Spectrum::BLACK);
        let refinement = Refinement::new(&tree);
        Self { tree, refinement, effort: Effort::default(), change: f64::INFINITY }
    }

    /// Sweeps until the change is small enough: each node gathers over its links, then all is pushed down and pulled up.
    fn solve(&mut self, enough: f64, sweeps: u32, pause: &mut dyn FnMut() -> Result<(), Interrupted>) {
        let neighbours = Neighbours::new(&self.tree, &self.refinement.links, false);
        let gather = |tree: &mut Tree<'_>| {
            let pushed = tree.push(&neighbours.gather(tree));
            tree.pull(|leaf, branch| {
                let (irradiance, sum) = pushed[leaf];
                irradiance * branch.scale(sum)
            })
        };
        self.sweep(gather, enough, sweeps, pause);
    }

    /// Sweeps with form factors of the leaves to the other ends of links, unless these are too many.
    fn solve_at_leaves(
        &mut self,
        settings: &Hierarchical,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let Hierarchical { tolerance, sweeps, links, .. } = *settings;
        if self.refinement.stopped {
            // Whoever stops does not want to wait for many more rays.
            return self.solve(tolerance, sweeps, pause);
        }
        let neighbours = Neighbours::new(&self.tree, &self.refinement.links, true);
        let Some(leaves) = Leaves::new(&self.tree, &neighbours, PER_LINK * links) else {
            return self.solve(tolerance, sweeps, pause);
        };
        self.refinement.rays += leaves.rays;
        let gather = |tree: &mut Tree<'_>| {
            let gathered = leaves.gather(tree);
            tree.pull(|leaf, _| gathered[leaf])
        };
        self.sweep(gather, tolerance, sweeps, pause);
    }

    /// There is one sweep in any case, so that what was divided has its light.
    fn sweep(
        &mut self,
        gather: impl Fn(&mut Tree<'_>) -> f32,
        enough: f64,
        sweeps: u32,
        pause: &mut dyn FnMut() -> Result<(), Interrupted>,
    ) {
        let last = self.effort.sweeps + sweeps;
        loop {
            let change = gather(&mut self.tree);
            let largest =
                self.tree.light.iter().map(|light| light.radiosity.max_component()).fold(0.0, f32::max);
            self.change = if largest > 0.0 { f64::from(change / largest) } else { 0.0 };
            self.effort.sweeps += 1;
            if self.change <= enough || self.effort.sweeps >= last || self.refinement.stopped {
                break;
            }
            self.refinement.stopped |= pause().is_err();
        }
    }

    fn errors(&self, bound: f64) -> Errors {
        let mut errors = Errors { change: self.change, ..Errors::default() };
        let flux = self.tree.flux();
        if flux > 0.0 {
            for link in &self.refinement.links {
                let ends = [link.a, link.b];
                let doubt = f64::from(link.doubt) / flux;
                let error = self.tree.error(ends, doubt);
                let one =
                    |node: u32| f64::from(self.tree.light[node as usize].radiosity.max_component()) * doubt;
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

    fn finish(self, bound: f64) -> Refined<'a> {
        let errors = self.errors(bound);
        let Refinement { links, rays, stopped } = self.refinement;
        let effort = Effort { links: links.len(), nodes: self.tree.branches.len(), rays, ..self.effort };
        let (elements, light): (_, Vec<Light>) = self.tree.into_leaves();
        Refined {
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
