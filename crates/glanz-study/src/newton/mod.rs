//! Newton's method from one start, compared with the certified search (document 000 chapters 3 and 4).

mod compare;
mod evaluate;
mod example;
mod hull;
mod iteration;
mod patches;

pub(crate) use self::example::fan_ray;
pub(crate) use self::hull::Hull;
pub(crate) use self::patches::TRUE_POINTS;

use std::time::Duration;

use self::compare::{
    CertifiedTally, Comparison, RESIDUAL, STEPS, STEPS_OF_000, Variant, VariantTally, compare,
};
use crate::clock;
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{Axis, Plot, ReferenceLine, Series, Table, TableCell};

/// Default number of random rays.
const RAYS: u64 = 1_000_000;

/// Share of the example in the progress.
const EXAMPLE: f64 = 0.01;

const COLUMNS: [(&str, &str); 14] = [
    ("patches", "patches"),
    ("method", "method"),
    ("roots", "roots"),
    ("found", "found"),
    ("missed", "missed"),
    ("rays_first_root", "rays with first root found"),
    ("wrong_outside", "wrong: outside the domain"),
    ("wrong_inside", "wrong: no root"),
    ("singular", "ended singular"),
    ("steps_mean", "steps, mean"),
    ("steps_max", "steps, most"),
    ("evaluations_per_ray", "evaluations per ray"),
    ("time_ns_per_ray", "time per ray, ns"),
    ("time_ns_per_root", "time per root found, ns"),
];

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or no rays.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    let rays = settings.rays.unwrap_or(RAYS);
    if rays == 0 {
        return Err(StudyError::Setting { name: "rays", value: rays.to_string(), needed: "1 or more" });
    }
    progress.report(0.0, "the example of document 000");
    let example = example::solve()?;
    let groups = patches::groups()?;
    let all = compare(&groups, rays, EXAMPLE, settings, progress)?;

    let caption = format!(
        "{} random rays at patches of all kinds: roots by the certified search, and by Newton's method from one start per \
         ray.",
        grouped(rays)
    );
    let mut summary = Table::new("summary", caption, &COLUMNS);
    push_rows(&mut summary, "all", &all.truth, &all.tallies);
    let mut report = Report::new("Study newton: one start, one root, or none", summary);
    report.heading("Question");
    report.paragraph(
        "Document 000 intersects rays with a Bézier patch by Newton's method: it starts at the midpoint between the hits \
         with the hull of the control points and accepts every end with a small residual. How many of the roots does it \
         find, miss and invent, and at what cost, compared with the certified search of Glanz?",
    );
    settings_paragraph(rays, settings, &mut report);
    example.add_to(&mut report);
    report.heading("Random rays");
    let mut by_group = Table::new("rays", "The same for each kind of patch.", &COLUMNS);
    for (name, truth, tallies) in &all.groups {
        push_rows(&mut by_group, name, truth, tallies);
    }
    report.table(by_group);
    report.plot("found", found_plot(&all), "Roots found by the number of steps that are allowed.");
    report.heading("Findings");
    for sentence in findings(&all) {
        report.paragraph(sentence);
    }
    progress.report(1.0, "done");
    Ok(report)
}

fn settings_paragraph(rays: u64, settings: &Settings, report: &mut Report) {
    let clock = if clock::counts_processor_time() { "processor time of the thread" } else { "wall time" };
    report.paragraph(format!(
        "Settings: {} rays in three equal parts at the cubic triangle of document 000, the 32 bicubic patches of the Newell \
         teapot in turn, each alone, and an eighth of a sphere as a rational bicubic patch with a pole. Rays start on a \
         sphere of twice the patch's diagonal across and go to random points of the box around the control points. \
         Unknowns are (u, v) and the ray parameter; at most {STEPS} steps (document 000: {STEPS_OF_000}), residual {RESIDUAL:e} \
         of the patch's size. Seed {}. One thread; times are {clock}. Newton's method \
         and the certified search evaluate the patches by routines of fixed size; the search first divides triangles into \
         three bicubic patches. Its steps are not counted.",
        grouped(rays),
        settings.seed
    ));
    report.paragraph(
        "A root counts as *found* if an iteration ends there. *Outside the domain* counts ends that the residual test of \
         document 000 accepts although they lie beyond the border of the patch or behind the origin; *no root* counts ends \
         inside the domain at which the certified search has no root.",
    );
}

fn push_rows(table: &mut Table, patches: &str, truth: &CertifiedTally, tallies: &[VariantTally; 3]) {
    let per = |time: Duration, count: u64| (count > 0).then(|| time.as_secs_f64() * 1e9 / count as f64);
    for (variant, tally) in Variant::ALL.into_iter().zip(tallies) {
        let mean = (tally.converged > 0).then(|| tally.steps as f64 / tally.converged as f64);
        table.push([
            patches.into(),
            variant.name().into(),
            truth.roots.into(),
            tally.found.into(),
            truth.roots.saturating_sub(tally.found).into(),
            tally.first.into(),
            tally.outside.into(),
            tally.unknown.into(),
            tally.singular.into(),
            mean.into(),
            u64::from(tally.most_steps).into(),
            (tally.evaluations as f64 / truth.rays.max(1) as f64).into(),
            per(tally.time, truth.rays).into(),
            per(tally.time, tally.found).into(),
        ]);
    }
    let none = 0_u64;
    for (name, found, time) in [
        ("certified, all roots", truth.roots, truth.all),
        ("certified, first root", truth.hit, truth.closest),
    ] {
        let counted = if found == truth.roots { TableCell::from(none) } else { TableCell::Missing };
        table.push([
            patches.into(),
            name.into(),
            truth.roots.into(),
            found.into(),
            counted,
            truth.hit.into(),
            none.into(),
            none.into(),
            none.into(),
            TableCell::Missing,
            TableCell::Missing,
            TableCell::Missing,
            per(time, truth.rays).into(),
            per(time, found).into(),
        ]);
    }
}

fn found_plot(all: &Comparison) -> Plot {
    let roots = all.truth.roots.max(1) as f64;
    let series = Variant::ALL.into_iter().zip(&all.tallies).map(|(variant, tally)| {
        let mut sum = 0;
        let points = tally.found_after.iter().take(31).enumerate().map(|(n, count)| {
            sum += count;
            [n as f64, 100.0 * sum as f64 / roots]
        });
        Series { name: variant.name().to_owned(), points: points.collect() }
    });
    Plot {
        title: "Roots found within a number of steps".to_owned(),
        x: Axis::linear("steps allowed"),
        y: Axis::linear("roots found, %"),
        series: series.collect(),
        reference_lines: vec![
            ReferenceLine { name: "certified search".to_owned(), vertical: false, at: 100.0, series: None },
            ReferenceLine {
                name: "one root of every ray that has one".to_owned(),
                vertical: false,
                at: 100.0 * all.truth.hit as f64 / roots,
                series: Some(3),
            },
        ],
    }
}

/// Findings as sentences with their figures.
fn findings(all: &Comparison) -> Vec<String> {
    let CertifiedTally { rays, hit, roots, worst, undecided, all: all_time, .. } = &all.truth;
    let share = |count: u64, of: u64| {
        if of == 0 { "-".to_owned() } else { format!("{} %", significant(100.0 * count as f64 / of as f64)) }
    };
    let mut found = vec![format!(
        "{} of {} rays meet their patch, in {} roots. The certified search left {} undecided; its roots lie within {} of the \
         patch's size of both ray and patch.",
        grouped(*hit),
        grouped(*rays),
        grouped(*roots),
        if *undecided == 0 { "nothing".to_owned() } else { format!("{undecided} searches") },
        significant(*worst)
    )];
    for (variant, tally) in Variant::ALL.into_iter().zip(&all.tallies) {
        let early: u64 = tally.found_after.iter().take(STEPS_OF_000 as usize + 1).sum();
        found.push(format!(
            "The {} method finds {} of the roots ({} within {STEPS_OF_000} steps) and the first root of {} of the rays that \
             have one; {} of its {} accepted ends are not hits.",
            variant.name().split(' ').next().unwrap_or_default(),
            share(tally.found, *roots),
            share(early, *roots),
            share(tally.first, *hit),
            share(tally.outside + tally.unknown, tally.converged),
            grouped(tally.converged)
        ));
    }
    let unknown: u64 = all.tallies.iter().map(|t| t.unknown).sum();
    found.push(if unknown == 0 {
        "No iteration ended inside a patch at a root that the certified search does not have: this independently confirms \
         that it misses no root that the variants can find."
            .to_owned()
    } else {
        format!(
            "{} ended inside a patch where the certified search has no root; this needs investigation.",
            plural(unknown, "iteration", "iterations")
        )
    });
    let ns = |time: &Duration| time.as_secs_f64() * 1e9 / (*rays).max(1) as f64;
    let fastest = all.tallies.iter().map(|t| ns(&t.time)).fold(f64::INFINITY, f64::min);
    if ns(all_time) > 0.0 && fastest > 0.0 {
        let (ratio, word) = if fastest > ns(all_time) {
            (fastest / ns(all_time), "less")
        } else {
            (ns(all_time) / fastest, "more")
        };
        found.push(format!(
            "The certified search for all roots takes {} ns per ray, {} times {word} than one iteration per ray of the \
             fastest variant ({} ns).",
            significant(ns(all_time)),
            significant(ratio),
            significant(fastest)
        ));
    }
    found
}
