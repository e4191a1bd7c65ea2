//! Solutions of one room by all solvers.

use std::time::{Duration, Instant};

use glanz_job::Silent;
use glanz_radiosity::elements::{ElementSettings, Elements};
use glanz_radiosity::form_factor::FormFactors;
use glanz_radiosity::solve::{GaussSeidelSettings, HierarchicalSettings, gauss_seidel, hierarchical};
use glanz_scene::Scene;
use rayon::ThreadPool;

use super::descent::{Descent, descent};
use super::field::{Field, error_of};
use super::progressive::Progressive;
use crate::clock::{Stopwatch, TimeScope};
use crate::study::{Settings, StudyError};

/// Largest side of elements, metres, and the factor to the next smaller one.
const LONGEST: f64 = 2.0;
const FINER: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Largest number of divisions.
const DIVISIONS: u32 = 40;

/// Smallest growth of the number of elements from one division to the next.
const GROWTH: f64 = 1.2;

/// Unshot share of the emitted light at which progressive refinement ends.
pub(super) const LEFT: f64 = 0.1;

/// Bounds of the hierarchical solver: the first, the factor to the next, and their number.
const BOUND: f64 = 1e-2;
const TIGHTER: f64 = 0.316_227_766_016_837_94;
const BOUNDS: usize = 10;

/// Quarterings of an element of a reference for means over it: of all pairs, and of links, which have more elements.
const ACROSS: u32 = 2;
const ACROSS_LINKS: u32 = 1;

/// Number of elements at which the hierarchical solver ends, relative to the finest solution by all pairs.
const MORE: usize = 6;

/// The compared solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SolverKind {
    /// Form factors of all pairs, Gauss-Seidel method.
    Full,
    /// Progressive refinement.
    Progressive,
    /// Links by an error bound.
    Hierarchical,
}

impl SolverKind {
    pub(super) const ALL: [Self; 3] = [Self::Full, Self::Progressive, Self::Hierarchical];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Full => "all pairs",
            Self::Progressive => "progressive",
            Self::Hierarchical => "hierarchical",
        }
    }
}

/// Cost and errors of a solution.
#[derive(Clone, Debug)]
pub(super) struct SolverRun {
    pub(super) solver: SolverKind,
    /// Largest side of elements, metres; or the bound.
    pub(super) setting: f64,
    pub(super) elements: usize,
    /// Processor time of all threads.
    pub(super) processors: Duration,
    pub(super) wall: Duration,
    /// Number of stored form factors or links.
    pub(super) stored: Option<usize>,
    /// Memory of the form factors, if known, or of the light of the elements.
    pub(super) bytes: Option<usize>,
    pub(super) rays: u64,
    /// Sweeps, or elements that have shot.
    pub(super) steps: usize,
    /// Difference from the converged solution on the same elements.
    pub(super) unfinished: Option<f64>,
    /// Differences from the finest solution by all pairs, and from that by links; `None` for itself.
    pub(super) errors: [Option<f64>; 2],
}

/// Results of a room.
pub(super) struct RoomSolutions {
    pub(super) name: String,
    /// Solutions by solver, coarse before fine.
    pub(super) runs: Vec<SolverRun>,
    /// Convergence on the coarsest elements.
    pub(super) descent: Descent,
}

impl RoomSolutions {
    pub(super) fn of(&self, solver: SolverKind) -> impl Iterator<Item = &SolverRun> {
        self.runs.iter().filter(move |run| run.solver == solver)
    }
}

/// The value of `work`, with its processor time and wall time.
fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration, Duration) {
    let (watch, begun) = (Stopwatch::start(TimeScope::Process), Instant::now());
    let value = work();
    (value, watch.elapsed(), begun.elapsed())
}

/// Divisions of a scene with at most `most` elements, fine before coarse; at least the coarsest one.
fn divisions<'a>(scene: &'a Scene, most: usize) -> Result<Vec<(f64, Elements<'a>)>, StudyError> {
    let mut found: Vec<(f64, Elements<'a>)> = Vec::new();
    let mut side = LONGEST.min(0.5 * scene.bounds().diagonal().length());
    for _ in 0..DIVISIONS {
        let elements = Elements::new(scene, &ElementSettings { side })?;
        let before = found.last().map_or(0, |(_, before)| before.list.len());
        if before > 0 && elements.list.len() > most {
            break;
        }
        if elements.list.len() as f64 >= GROWTH * before as f64 {
            found.push((side, elements));
        }
        side *= FINER;
    }
    found.reverse();
    Ok(found)
}

/// Solves a room by all solvers. `on_progress` receives the completed share and the next step.
///
/// # Errors
/// [`StudyError::Interrupted`], or a room that cannot be divided.
pub(super) fn measure(
    name: &str,
    scene: &Scene,
    most: usize,
    settings: &Settings,
    pool: &ThreadPool,
    on_progress: &mut dyn FnMut(f64, &str),
) -> Result<RoomSolutions, StudyError> {
    let divisions = divisions(scene, most)?;
    let mut of_divisions: Vec<(SolverRun, &Elements<'_>, RadiosityValues)> = Vec::new();
    let mut last = None;
    // Both solvers scale with the square, and the hierarchy counts like the finest division.
    let square = |elements: &Elements<'_>| (elements.list.len() as f64).powi(2);
    let first = divisions.first().map_or(0.0, |(_, elements)| square(elements));
    let all = 2.0 * divisions.iter().map(|(_, elements)| square(elements)).sum::<f64>() + first;
    let mut done = 0.0;
    for (side, elements) in &divisions {
        let count = elements.list.len();
        on_progress(done / all, &format!("all pairs of {count} elements"));
        let (full, factors, radiosity) = pool.install(|| all_pairs(*side, elements, settings))?;
        done += square(elements);
        on_progress(done / all, &format!("progressive refinement, {count} elements"));
        let (mut shot, light) = pool.install(|| progressive(*side, elements, settings))?;
        done += square(elements);
        shot.unfinished = Some(error_of(&elements.list, &light, &radiosity));
        last = Some(descent(elements, &factors, &radiosity, settings)?);
        of_divisions.extend([(full, elements, radiosity), (shot, elements, light)]);
    }
    let (Some((full, elements, radiosity)), Some(descent)) = (of_divisions.first(), last) else {
        return Err(StudyError::Unreadable(format!("{name}: there is nothing to solve")));
    };
    let mut of_links: Vec<(SolverRun, Elements<'_>, RadiosityValues)> = Vec::new();
    let mut bound = BOUND;
    for _ in 0..BOUNDS {
        on_progress(done / all, &format!("hierarchical, bound {bound:.1e}"));
        of_links.push(pool.install(|| by_links(scene, bound, settings))?);
        if of_links.last().is_some_and(|(run, ..)| run.elements >= MORE * full.elements) {
            break;
        }
        bound *= TIGHTER;
    }
    let Some((_, finest, light)) = of_links.last() else {
        return Err(StudyError::Unreadable(format!("{name}: there are no links")));
    };
    let references = [(Field::new(elements, radiosity), ACROSS), (Field::new(finest, light), ACROSS_LINKS)];
    let mut runs = Vec::new();
    let all = of_divisions.iter().rev().map(|(run, elements, light)| (run, *elements, light));
    for (run, elements, light) in
        all.chain(of_links.iter().map(|(run, elements, light)| (run, elements, light)))
    {
        settings.cancel.check()?;
        let field = Field::new(elements, light);
        let itself = |reference: &Field<'_>| {
            reference.is_on(elements) && matches!(run.solver, SolverKind::Full | SolverKind::Hierarchical)
        };
        let errors = references
            .each_ref()
            .map(|(reference, levels)| (!itself(reference)).then(|| field.error(reference, *levels)));
        runs.push(SolverRun { errors, ..run.clone() });
    }
    Ok(RoomSolutions { name: name.to_owned(), runs, descent })
}

/// Radiosity of each element.
type RadiosityValues = Vec<glanz_light::Spectrum>;

fn all_pairs(
    side: f64,
    elements: &Elements<'_>,
    settings: &Settings,
) -> Result<(SolverRun, FormFactors, RadiosityValues), StudyError> {
    let solve = || {
        let factors = FormFactors::new(elements, &settings.cancel)?;
        let solution =
            gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &settings.cancel)?;
        Ok::<_, StudyError>((factors, solution))
    };
    let (result, processors, wall) = timed(solve);
    let (factors, solution) = result?;
    let run = SolverRun {
        solver: SolverKind::Full,
        setting: side,
        elements: elements.list.len(),
        processors,
        wall,
        stored: Some((0..factors.len()).map(|i| factors.row(i).len()).sum()),
        bytes: Some(factors.bytes()),
        rays: factors.rays(),
        steps: solution.sweeps as usize,
        unfinished: Some(0.0),
        errors: [None; 2],
    };
    Ok((run, factors, solution.radiosity))
}

fn progressive(
    side: f64,
    elements: &Elements<'_>,
    settings: &Settings,
) -> Result<(SolverRun, RadiosityValues), StudyError> {
    let solve = || {
        let (mut shot, mut steps) = (Progressive::new(elements), 0);
        while shot.left(elements) > LEFT && shot.shoot(elements) {
            settings.cancel.check()?;
            steps += 1;
        }
        Ok::<_, StudyError>((shot, steps))
    };
    let (result, processors, wall) = timed(solve);
    let (shot, steps) = result?;
    let run = SolverRun {
        solver: SolverKind::Progressive,
        setting: side,
        elements: elements.list.len(),
        processors,
        wall,
        stored: None,
        // Radiosity and unshot radiosity.
        bytes: Some(2 * size_of_val(shot.radiosity())),
        rays: shot.rays(),
        steps,
        unfinished: None,
        errors: [None; 2],
    };
    Ok((run, shot.radiosity().to_vec()))
}

fn by_links<'a>(
    scene: &'a Scene,
    bound: f64,
    settings: &Settings,
) -> Result<(SolverRun, Elements<'a>, RadiosityValues), StudyError> {
    // Undivided faces.
    let side = 2.0 * scene.bounds().diagonal().length();
    let method = HierarchicalSettings { bound, ..HierarchicalSettings::default() };
    let solve = || {
        let start = Elements::new(scene, &ElementSettings { side })?;
        hierarchical(start, &method, &mut Silent, &settings.cancel)
            .map_err(|error| StudyError::Unreadable(error.to_string()))
    };
    let (result, processors, wall) = timed(solve);
    let solution = result?;
    settings.cancel.check()?;
    let run = SolverRun {
        solver: SolverKind::Hierarchical,
        setting: bound,
        elements: solution.elements.list.len(),
        processors,
        wall,
        stored: Some(solution.effort.links),
        bytes: None,
        rays: solution.effort.rays,
        steps: solution.effort.sweeps as usize,
        unfinished: None,
        errors: [None; 2],
    };
    Ok((run, solution.elements, solution.radiosity))
}
