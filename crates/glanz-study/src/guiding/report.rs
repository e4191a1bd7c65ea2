//! The report of the study.

use super::GuidingPlan;
use super::curve::{CurvePoint, Norm};
use super::figures::{figures, light_words};
use super::method::{FROZEN_SAMPLES, MOST_LEARNT, RenderMethod};
use super::outcome::{MethodComparison, MethodOutcome, RoomOutcome};
use crate::clock;
use crate::report::Report;
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{Table, TableCell};

const SUMMARY: [(&str, &str); 13] = [
    ("room", "room"),
    ("light_sampling", "lights sampled"),
    ("method", "method"),
    ("samples", "samples per pixel"),
    ("time_s", "time, s"),
    ("l2", "L2 error"),
    ("modified_l2", "modified L2 error"),
    ("factor_min", "smallest factor, L2"),
    ("factor_max", "largest factor, L2"),
    ("modified_factor_min", "smallest factor, modified L2"),
    ("modified_factor_max", "largest factor, modified L2"),
    ("frozen_l2", "L2 error, frozen guide"),
    ("frozen_modified_l2", "modified L2 error, frozen guide"),
];

const POINTS: [(&str, &str); 8] = [
    ("room", "room"),
    ("light_sampling", "lights sampled"),
    ("method", "method"),
    ("samples", "samples per pixel"),
    ("time_s", "time, s"),
    ("processor_s", "processor time, s"),
    ("l2", "L2 error"),
    ("modified_l2", "modified L2 error"),
];

const SPEED_UPS: [(&str, &str); 9] = [
    ("room", "room"),
    ("light_sampling", "lights sampled"),
    ("method", "method"),
    ("norm", "norm"),
    ("error", "error"),
    ("path_s", "path, s"),
    ("method_s", "method, s"),
    ("factor", "factor"),
    ("processor_factor", "factor by processor time"),
];

/// The factors of document 003, tables 3.1 to 3.4.
const PUBLISHED: &str = "Document 003 found factors of 5.20 to 2.76 (scene 2, without stratification), 3.11 to 2.41 (scene 2, \
     with), 16.08 to 3.38 (scene 3, without) and 4.68 to 2.20 (scene 3, with), and no significant speed-up in scene 1.";

fn yes(lights: bool) -> TableCell {
    if lights { "yes" } else { "no" }.into()
}

/// Builds the report.
pub(super) fn build_report(rooms: Vec<RoomOutcome>, plan: &GuidingPlan) -> Report {
    let mut report = Report::new("Study guiding: directions learnt from the incident light", summary(&rooms));
    report.heading("Question");
    report.paragraph(
        "Document 003 (chapter 3) lets a path tracer learn the incident light on a grid of cells on every surface, and \
         samples directions from the learnt densities. How much faster does it reach the error of a plain path tracer, with \
         which basis, scale and subdivision, and how much faster is Glanz's own guide?",
    );
    report.paragraph(settings_text(plan));
    report.paragraph(reference_text(&rooms));
    for room in &rooms {
        for why in &room.refused {
            report.paragraph(format!("Left out of room {}: {why}.", room.name));
        }
    }
    report.heading("Speed-up");
    report.paragraph(PUBLISHED);
    report.table(shown_speed_ups(&rooms));
    report.data(all_speed_ups(&rooms));
    report.heading("Findings");
    for sentence in rooms.iter().flat_map(findings) {
        report.paragraph(sentence);
    }
    report.heading("Error over samples and time");
    report.data(points(&rooms, "curves", "The points of all curves:", |o| &o.curve));
    let caption = format!(
        "Pictures of {FROZEN_SAMPLES} samples per pixel by frozen guides; samples count those learnt from, times are those \
         of the picture:"
    );
    report.data(points(&rooms, "frozen", &caption, |o| &o.frozen));
    for room in &rooms {
        report.heading(format!("Room {}", room.name));
        for figure in figures(room) {
            report.figure(figure);
        }
    }
    report.heading("Pictures at equal time");
    for room in rooms {
        if let Some(sheet) = room.sheet {
            let caption = format!(
                "Room {}, {} s each: without light sampling above, with it below; the reference ({} samples per pixel) at the \
                 right. Above each picture its samples per pixel, L2 and modified L2 error; names of grids are basis, cells and \
                 scale.",
                room.name,
                plan.seconds,
                grouped(room.reference_samples)
            );
            report.picture(format!("equal_time_{}", room.name), sheet, caption);
        }
    }
    report
}

fn settings_text(plan: &GuidingPlan) -> String {
    let processors =
        if clock::counts_processor_time() { "processor time of all threads" } else { "wall time" };
    format!(
        "Settings: pictures of {} x {} pixels, curves to {} samples per pixel with a point at every power of two, {}, {}, seed \
         {}. Times are wall times of the render loop, including learning, without reading the scene; the CSV files also \
         contain {processors}, which is not affected by other work of the machine. *L2* is the root of the mean squared difference \
         from the reference over pixels and channels, *modified L2* the same with both pictures clipped to 1, the brightest \
         value of a display (document 003, section 3.4.1.2). *With light sampling* one light is sampled at every hit, which document \
         003 calls stratification; without it paths find lights by chance alone. A *factor* is the time of `path` to an \
         error over the time of the method to the same error. Both times are those after which the error is no longer \
         exceeded, for errors that both curves reach (a late outlier can remove some, mostly in the L2 norm, which is why \
         the document modified it); logarithms are interpolated between points. A *frozen* guide has learnt from up to {MOST_LEARNT} samples of each \
         pixel, learns no more, and is assessed by a new picture of {FROZEN_SAMPLES} samples.",
        plan.size[0],
        plan.size[1],
        grouped(u64::from(plan.samples)),
        plural(u64::from(plan.rounds), "run of each kind", "runs of each kind (errors averaged as squares)"),
        plural(plan.threads as u64, "thread", "threads"),
        plan.seed
    )
}

fn reference_text(rooms: &[RoomOutcome]) -> String {
    let each: Vec<String> = rooms
        .iter()
        .map(|room| {
            let error = room.reference_error().map_or_else(|| "-".to_owned(), significant);
            format!("{} {} samples, {error}", room.name, grouped(room.reference_samples))
        })
        .collect();
    format!(
        "References are rendered by `path` with light sampling. Samples per pixel, and an upper bound of the contribution of \
         their own noise to an L2 error (the error of `path` at the end of its curve, scaled by the inverse root of the \
         number of samples): {}.",
        each.join("; ")
    )
}

fn summary(rooms: &[RoomOutcome]) -> Table {
    let caption = "The end of each curve, and the speed-up over `path` to the same error: the smallest and the largest \
     factor over all errors that both reach.";
    let mut table = Table::new("summary", caption, &SUMMARY);
    for room in rooms {
        // Methods with listed passes are measured by their frozen guides only.
        for outcome in room.outcomes.iter().filter(|o| o.method.passes().is_none()) {
            let Some(last) = outcome.last() else { continue };
            let is_path = outcome.method == RenderMethod::path();
            let range = |norm| {
                room.comparison(outcome, norm).filter(|_| !is_path).and_then(|comparison| comparison.range())
            };
            let (plain, shown) = (range(Norm::Plain), range(Norm::Shown));
            table.push([
                room.name.as_str().into(),
                yes(outcome.lights),
                outcome.method.name.as_str().into(),
                u64::from(last.samples).into(),
                last.wall.into(),
                last.error.plain.into(),
                last.error.shown.into(),
                plain.map(|r| r[0]).into(),
                plain.map(|r| r[1]).into(),
                shown.map(|r| r[0]).into(),
                shown.map(|r| r[1]).into(),
                outcome.frozen.last().map(|p| p.error.plain).into(),
                outcome.frozen.last().map(|p| p.error.shown).into(),
            ]);
        }
    }
    table
}

fn points(
    rooms: &[RoomOutcome],
    name: &'static str,
    caption: &str,
    of: fn(&MethodOutcome) -> &Vec<CurvePoint>,
) -> Table {
    let mut table = Table::new(name, caption, &POINTS);
    for room in rooms {
        for outcome in &room.outcomes {
            for point in of(outcome) {
                table.push([
                    room.name.as_str().into(),
                    yes(outcome.lights),
                    outcome.method.name.as_str().into(),
                    u64::from(point.samples).into(),
                    point.wall.into(),
                    point.processors.into(),
                    point.error.plain.into(),
                    point.error.shown.into(),
                ]);
            }
        }
    }
    table
}

fn push_comparison(table: &mut Table, room: &RoomOutcome, comparison: &MethodComparison<'_>) {
    for speed_up in &comparison.wall {
        let processors = comparison.processors.iter().find(|s| s.error == speed_up.error);
        table.push([
            room.name.as_str().into(),
            yes(comparison.outcome.lights),
            comparison.outcome.method.name.as_str().into(),
            comparison.norm.name().into(),
            speed_up.error.into(),
            speed_up.plain.into(),
            speed_up.other.into(),
            speed_up.factor().into(),
            processors.map(|s| s.factor()).into(),
        ]);
    }
}

/// Speed-ups of the tree and of the best grid, in the norm of document 003 first.
fn shown_speed_ups(rooms: &[RoomOutcome]) -> Table {
    let caption = "Time to the same error as the path tracer, with the same use of light sampling (document 003, tables \
                   3.1 to 3.4): Glanz's own guide, and the grid with the largest speed-up in the modified norm.";
    let mut table = Table::new("speed_up", caption, &SPEED_UPS);
    for room in rooms {
        for lights in [false, true] {
            for comparison in shown_comparisons(room, lights) {
                push_comparison(&mut table, room, &comparison);
            }
        }
    }
    table
}

/// Comparisons of the tree and of the best grid, in the modified norm first.
fn shown_comparisons(room: &RoomOutcome, lights: bool) -> Vec<MethodComparison<'_>> {
    let shown = [room.outcome(&RenderMethod::tree().key, lights), room.best_grid(lights)];
    let norms = shown.into_iter().flatten().flat_map(|o| [Norm::Shown, Norm::Plain].map(|norm| (o, norm)));
    norms.filter_map(|(outcome, norm)| room.comparison(outcome, norm)).collect()
}

fn all_speed_ups(rooms: &[RoomOutcome]) -> Table {
    let mut table = Table::new("speed_ups", "The same for all methods and both norms:", &SPEED_UPS);
    for room in rooms {
        for comparison in Norm::ALL.into_iter().flat_map(|norm| room.comparisons(norm)) {
            push_comparison(&mut table, room, &comparison);
        }
    }
    table
}

/// Findings as sentences with their figures.
fn findings(room: &RoomOutcome) -> Vec<String> {
    let describe = |comparison: &MethodComparison<'_>| {
        let [least, most] = comparison.range()?;
        let (first, last) = (comparison.wall.first()?, comparison.wall.last()?);
        Some(format!(
            "`{}` is {} to {} times as fast as `path` for {} errors from {} to {}, {} times at the smallest",
            comparison.outcome.method.name,
            significant(least),
            significant(most),
            comparison.norm.name(),
            significant(first.error),
            significant(last.error),
            significant(last.factor())
        ))
    };
    let sentence = |lights: bool| {
        let (_, words) = light_words(lights);
        let sentences: Vec<String> = shown_comparisons(room, lights).iter().filter_map(describe).collect();
        match sentences.len() {
            0 => format!("Room {}, {words}: the curves have no errors in common.", room.name),
            _ => format!("Room {}, {words}: {}.", room.name, sentences.join("; ")),
        }
    };
    [false, true].map(sentence).into()
}
