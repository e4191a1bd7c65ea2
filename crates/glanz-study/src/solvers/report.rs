//! The report of the study.

use super::Furnace;
use super::descent::Descent;
use super::figures::{exponent, figures, over_elements, rays, stored, time};
use super::measure::{LEFT, RoomSolutions, SolverKind, SolverRun};
use crate::clock;
use crate::report::Report;
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{Table, TableCell};

const SUMMARY: [(&str, &str); 12] = [
    ("room", "room"),
    ("solver", "solver"),
    ("elements_min", "elements, fewest"),
    ("elements_max", "elements, most"),
    ("time_s", "time with most, s"),
    ("time_exponent", "exponent of time"),
    ("rays_exponent", "exponent of rays"),
    ("kept_exponent", "exponent of storage"),
    ("error_first", "error, fewest"),
    ("error_last", "error, most"),
    ("links_error_first", "error against links, fewest"),
    ("links_error_last", "error against links, most"),
];

const RUNS: [(&str, &str); 13] = [
    ("room", "room"),
    ("solver", "solver"),
    ("setting", "side, m, or bound"),
    ("elements", "elements"),
    ("processor_s", "processor time, s"),
    ("wall_s", "wall time, s"),
    ("rays", "rays"),
    ("kept", "factors or links"),
    ("memory_mb", "memory, MB"),
    ("steps", "sweeps or shots"),
    ("unfinished", "from convergence"),
    ("error", "error"),
    ("links_error", "error against links"),
];

const FURNACES: [(&str, &str); 9] = [
    ("reflectance", "rho"),
    ("solver", "solver"),
    ("elements", "elements"),
    ("mean", "mean"),
    ("least", "least"),
    ("largest", "largest"),
    ("sum_min", "least row sum"),
    ("sum_max", "largest row sum"),
    ("left", "unshot"),
];

const CONVERGENCE: [(&str, &str); 6] = [
    ("room", "room"),
    ("steps", "steps"),
    ("error", "error"),
    ("error_with_ambient", "error with ambient term"),
    ("left", "light unshot"),
    ("sweeps_error", "error of gathering"),
];

/// Builds the report.
pub(super) fn build_report(
    outcomes: &[RoomSolutions],
    furnaces: &[Furnace],
    most: usize,
    threads: usize,
) -> Report {
    let mut report = Report::new("Study solvers: radiosity over the number of elements", summary(outcomes));
    report.heading("Question");
    report.paragraph(
        "Radiosity is B = E + rho F B, with a form factor for each pair of elements. Document 003 (chapter 4) solves it with \
         all form factors. What are the cost and the error of this method, and of solvers that store fewer or none \
         (@cohen1988, @hanrahan1991)?",
    );
    report.paragraph(settings_text(most, threads));
    report.heading("Findings");
    for sentence in outcomes.iter().flat_map(findings).chain(furnace_finding(furnaces)) {
        report.paragraph(sentence);
    }
    report.table(runs(outcomes));
    report.heading("Furnaces");
    report.table(furnace_table(furnaces));
    for outcome in outcomes {
        report.heading(format!("Room {}", outcome.name));
        for figure in figures(outcome) {
            report.figure(figure);
        }
    }
    report.data(convergence(outcomes));
    report
}

fn settings_text(most: usize, threads: usize) -> String {
    let clock = if clock::counts_processor_time() { "processor times of all threads" } else { "wall times" };
    format!(
        "Settings: {}; times are {clock}, including elements and form factors. *All pairs*: up to {} elements of equal \
         sides, form factors of all pairs, Gauss-Seidel method until no radiosity changes by more than 1e-6 of the largest. \
         *Progressive*: the same elements, until {} of the lamps' flux is unshot; form factors are computed for each \
         shooting element and not stored. *Hierarchical*: refined from whole faces, by a bound on the error of the flux of a \
         link. The *error* is the root mean square difference (by area) of reflected luminance from the finest solution by \
         all pairs, relative to that solution, with means over its elements; emitted light is left out. That solution has \
         large elements and errors of its own; the *error against links*, from the finest hierarchical solution, shows them. \
         *From convergence* is the difference from the converged solution on the same elements.",
        plural(threads as u64, "thread", "threads"),
        grouped(most as u64),
        significant(LEFT),
    )
}

fn summary(outcomes: &[RoomSolutions]) -> Table {
    let caption = "Time over the number of elements: t ~ n^exponent, fitted; errors against the finest solution by all pairs, and against the finest by links.";
    let mut table = Table::new("summary", caption, &SUMMARY);
    for outcome in outcomes {
        for solver in SolverKind::ALL {
            let runs: Vec<&SolverRun> = outcome.of(solver).collect();
            let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
            let fitted = |quantity: &dyn Fn(&SolverRun) -> Option<f64>| {
                exponent(&over_elements(outcome, solver, quantity))
            };
            table.push([
                TableCell::Text(outcome.name.clone()),
                solver.name().into(),
                (first.elements as u64).into(),
                (last.elements as u64).into(),
                last.processors.as_secs_f64().into(),
                fitted(&time).into(),
                fitted(&rays).into(),
                fitted(&stored).into(),
                first.errors[0].into(),
                last.errors[0].into(),
                first.errors[1].into(),
                last.errors[1].into(),
            ]);
        }
    }
    table
}

fn runs(outcomes: &[RoomSolutions]) -> Table {
    let caption = "All solutions. Memory is that of form factors, or, if none are stored, of the light of elements; that of \
     links is unknown.";
    let mut table = Table::new("runs", caption, &RUNS);
    for outcome in outcomes {
        for run in SolverKind::ALL.into_iter().flat_map(|solver| outcome.of(solver)) {
            table.push([
                TableCell::Text(outcome.name.clone()),
                run.solver.name().into(),
                run.setting.into(),
                (run.elements as u64).into(),
                run.processors.as_secs_f64().into(),
                run.wall.as_secs_f64().into(),
                run.rays.into(),
                run.stored.map(|count| count as u64).into(),
                run.bytes.map(|bytes| bytes as f64 / 1e6).into(),
                (run.steps as u64).into(),
                run.unfinished.into(),
                run.errors[0].into(),
                run.errors[1].into(),
            ]);
        }
    }
    table
}

fn furnace_table(furnaces: &[Furnace]) -> Table {
    let caption = "A closed box whose walls all emit E and reflect rho: radiosity relative to E / (1 - rho) and sums of the \
     form factors of an element, which should both be 1; unshot share of the emitted light after progressive refinement.";
    let mut table = Table::new("furnaces", caption, &FURNACES);
    for furnace in furnaces {
        let [least, largest] = furnace.range;
        table.push([
            // Stored as f32: digits beyond the seventh are meaningless.
            ((furnace.reflectance * 1e6).round() / 1e6).into(),
            furnace.solver.name().into(),
            (furnace.elements as u64).into(),
            TableCell::Precise((furnace.mean * 1e7).round() / 1e7),
            TableCell::Precise((least * 1e7).round() / 1e7),
            TableCell::Precise((largest * 1e7).round() / 1e7),
            furnace.sums.map_or(TableCell::Missing, |sums| TableCell::Precise((sums[0] * 1e7).round() / 1e7)),
            furnace.sums.map_or(TableCell::Missing, |sums| TableCell::Precise((sums[1] * 1e7).round() / 1e7)),
            furnace.left.into(),
        ]);
    }
    table
}

fn convergence(outcomes: &[RoomSolutions]) -> Table {
    let mut table = Table::new("convergence", "The points of the plots of convergence:", &CONVERGENCE);
    for outcome in outcomes {
        let Descent { shooting, with_ambient, gathering, left, .. } = &outcome.descent;
        let name = || TableCell::Text(outcome.name.clone());
        for ((shot, ambient), &left) in shooting.iter().zip(with_ambient).zip(left) {
            table.push([name(), shot[0].into(), shot[1].into(), ambient[1].into(), left.into()]);
        }
        for &[steps, error] in gathering {
            let none = || TableCell::Missing;
            table.push([name(), steps.into(), none(), none(), none(), error.into()]);
        }
    }
    table
}

fn findings(outcome: &RoomSolutions) -> Vec<String> {
    let name = &outcome.name;
    let mut found = Vec::new();
    let slopes = SolverKind::ALL.map(|solver| (solver, exponent(&over_elements(outcome, solver, time))));
    let slopes: Vec<String> = slopes
        .into_iter()
        .filter_map(|(solver, slope)| Some(format!("{:.2} ({})", slope?, solver.name())))
        .collect();
    if !slopes.is_empty() {
        found.push(format!(
            "Room {name}: time grows with the number of elements to the power of {}.",
            slopes.join(", ")
        ));
    }
    found.extend(hierarchical_speed_up(outcome));
    found.extend(per_element(outcome));
    found.extend(ambient(outcome));
    found
}

/// Comparison of the hierarchical solver with the finest solution by all pairs.
fn hierarchical_speed_up(outcome: &RoomSolutions) -> Option<String> {
    let full = outcome.of(SolverKind::Full).last()?;
    let more = outcome.of(SolverKind::Hierarchical).find(|run| run.elements >= full.elements)?;
    let ratio = full.processors.as_secs_f64() / more.processors.as_secs_f64().max(1e-3);
    Some(format!(
        "Room {}: all pairs of {} elements take {} s, links between {} elements {} s, {} times less, with an error of {} \
         against the solution by all pairs.",
        outcome.name,
        grouped(full.elements as u64),
        significant(full.processors.as_secs_f64()),
        grouped(more.elements as u64),
        significant(more.processors.as_secs_f64()),
        significant(ratio),
        more.errors[0].map_or_else(|| "-".to_owned(), significant),
    ))
}

/// Growth of the number of links.
fn per_element(outcome: &RoomSolutions) -> Option<String> {
    let runs: Vec<&SolverRun> = outcome.of(SolverKind::Hierarchical).collect();
    let per = |run: &SolverRun| Some(significant(run.stored? as f64 / run.elements as f64));
    let (first, last) = (runs.first()?, runs.last()?);
    Some(format!(
        "Room {}: {} links per element with a bound of {}, and {} with {}: a tighter bound requires more links per element, \
         not only more elements.",
        outcome.name,
        per(first)?,
        significant(first.setting),
        per(last)?,
        significant(last.setting)
    ))
}

/// Steps to errors, with and without the ambient term.
fn ambient(outcome: &RoomSolutions) -> Option<String> {
    let Descent { shooting, with_ambient, elements, .. } = &outcome.descent;
    let sentence = |error: f64| {
        let steps = |curve: &[[f64; 2]]| {
            Descent::steps_to(curve, error).map_or_else(|| "more".to_owned(), |n| grouped(n as u64))
        };
        format!("{} and {} for {}", steps(shooting), steps(with_ambient), significant(error))
    };
    (!shooting.is_empty()).then(|| {
        format!(
            "Room {}, {} elements: number that must shoot to reach an error, without and with the ambient term: {}.",
            outcome.name,
            grouped(*elements as u64),
            [0.5, 0.2, 0.1, 0.01].map(sentence).join("; ")
        )
    })
}

fn furnace_finding(furnaces: &[Furnace]) -> Option<String> {
    let off = |solver: SolverKind| {
        let of = furnaces.iter().filter(|furnace| furnace.solver == solver);
        of.map(|furnace| (furnace.mean - 1.0).abs()).reduce(f64::max)
    };
    let sums = furnaces.iter().filter_map(|furnace| furnace.sums);
    let sum = sums.flatten().map(|sum| (sum - 1.0).abs()).reduce(f64::max)?;
    Some(format!(
        "In furnaces the largest error of the mean radiosity is {} (all pairs), {} (hierarchical) and {} (progressive, which \
         stops early); sums of the form factors of an element deviate from 1 by at most {}.",
        significant(off(SolverKind::Full)?),
        significant(off(SolverKind::Hierarchical)?),
        significant(off(SolverKind::Progressive)?),
        significant(sum)
    ))
}
