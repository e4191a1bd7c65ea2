//! The report of the study.

use std::time::Duration;

use glanz_radiosity::reconstruct::Border;

use super::figures;
use super::measure::{DivisionResult, QUADTREE, SceneResult};
use super::method::{FloorDivision, InterpolationMethod, methods};
use super::parameters::ExponentComparison;
use super::{picture, published, ranking};
use crate::clock;
use crate::report::Report;
use crate::study::StudyError;
use glanz_report::number::significant;
use glanz_report::{Table, TableCell};

/// Names of the tables of errors, by scene and division.
const TABLES: [&str; 12] = [
    "table_f_1",
    "table_f_2",
    "table_f_3",
    "table_f_4",
    "table_f_5",
    "table_f_6",
    "table_f_7",
    "table_f_8",
    "table_f_9",
    "table_f_10",
    "table_f_11",
    "table_f_12",
];

/// Builds the report.
///
/// # Errors
/// [`StudyError::Pixels`].
pub(super) fn build_report(
    outcomes: &[SceneResult],
    parameters: ExponentComparison,
    size: [usize; 2],
) -> Result<Report, StudyError> {
    let mut report = Report::new(
        "Study reconstruction: light on a floor from one value per element",
        ranking::summary(outcomes),
    );
    report.heading("Question");
    report.paragraph(
        "A radiosity solution has one value per element. Document 003 (chapter 4) makes a texture of it by interpolating \
         scattered samples, and concludes that natural neighbours are best for all kinds of shadows, and multiquadrics for \
         soft ones. Is this confirmed by its own tables and by new measurements?",
    );
    report.paragraph(settings_text(outcomes, size));
    report.paragraph(error_text(outcomes));
    report.heading("Ranking");
    ranking::findings(outcomes).into_iter().for_each(|sentence| report.paragraph(sentence));
    report.table(ranking::overall(outcomes));
    report.heading("A step (figures 4.4 to 4.10)");
    let (steps, table) = figures::steps()?;
    report.table(table);
    steps.into_iter().for_each(|figure| report.figure(figure));
    for (i, outcome) in outcomes.iter().enumerate() {
        add_scene(i, outcome, size, &mut report)?;
    }
    report.heading("Samples at the border (figures F.31 and F.32)");
    let halves = outcomes.split_at(outcomes.len() / 2);
    for (name, half) in [("border_f_31", halves.0), ("border_f_32", halves.1)] {
        let chosen: Vec<&SceneResult> = half.iter().collect();
        let caption = "Natural neighbours minus the reference, without samples at the border and with them; blue is too dark, red too bright, \
                       in the colours of the scene's other pictures.";
        report.picture(name, picture::borders(&chosen, size)?, caption);
    }
    report.heading("Parameters");
    let sentence = parameters.finding();
    report.table(parameters.table);
    report.paragraph(sentence);
    report.heading("Times (table 4.1)");
    report.table(times(outcomes, size));
    Ok(report)
}

fn settings_text(outcomes: &[SceneResult], size: [usize; 2]) -> String {
    let [width, height] = size;
    let number = |o: &SceneResult| format!("{} ({})", o.setup.number, o.setup.description);
    let scenes: Vec<String> = outcomes.iter().map(number).collect();
    format!(
        "Settings: a floor of 1 m under a square lamp and a panel that shades it (`scenes/reconstruction`; document 003 does \
         not give its scenes). Scenes: {}. Penumbrae are 0.16 m or 1 mm wide. The floor is divided into 16 x 16 elements, or as a quadtree: an element is \
         divided if the values of its four quarters differ by more than {} of the largest light, from level {} to level {} at most. The value of an \
         element is its mean radiosity by direct light, by form factors with rays between {} pairs of parts of lamp and element. Textures have {width} x {height} texels and are compared with exact means over these. \
         Errors are relative to the largest light; those of document 003 are in its own units, in which the depth of \
         hard shadows is about 0.64. Shepard's \
         exponent is 4; multiquadrics have the exponent 1/2 and the distance to the next sample as radius, as in the document.",
        scenes.join("; "),
        QUADTREE.threshold,
        QUADTREE.first,
        QUADTREE.deepest,
        4_u32.pow(super::room::halved(size))
    )
}

fn error_text(outcomes: &[SceneResult]) -> String {
    let largest = |of: &dyn Fn(&SceneResult) -> f64| outcomes.iter().map(of).fold(0.0, f64::max);
    let off = |i: usize| largest(&|o: &SceneResult| o.divisions.iter().map(|d| d.off[i]).fold(0.0, f64::max));
    format!(
        "The reference is Lambert's closed form for the visible part of the lamp, averaged over each texel by points that \
         are refined where light changes; the last refinement changed texels by {} (root mean square) and {} (largest) at most. Values \
         of elements by form factors with rays deviate from their exact means by up to {} (root mean square) and {} \
         (largest), because points and rays sample only a part of the border of a shadow.",
        significant(largest(&|o| o.reference.change[0])),
        significant(largest(&|o| o.reference.change[1])),
        significant(off(0)),
        significant(off(1))
    )
}

fn add_scene(
    i: usize,
    outcome: &SceneResult,
    size: [usize; 2],
    report: &mut Report,
) -> Result<(), StudyError> {
    let number = outcome.setup.number;
    report.heading(format!("Scene {number}: {}", outcome.setup.description));
    for (j, of) in outcome.divisions.iter().enumerate() {
        if let Some(name) = TABLES.get(2 * i + j) {
            report.table(errors(name, i, outcome, of));
        }
        let division = of.division.name();
        let caption = format!(
            "Scene {number}, {division}: reference, elements, and textures by {}, with border samples where these matter.",
            picture::listed(of)
        );
        report.picture(format!("scene_{number}_{division}"), picture::textures(outcome, of, size)?, caption);
        let caption = format!(
            "The same textures minus the reference: blue is too dark, red too bright, white exact; colours saturate at {}.",
            picture::full(outcome)
        );
        let name = format!("scene_{number}_{division}_difference");
        report.picture(name, picture::differences(outcome, of, size)?, caption);
    }
    for division in FloorDivision::ALL {
        if let Some(figure) = figures::profile(outcome, division, size) {
            report.figure(figure);
        }
    }
    Ok(())
}

/// Tables F.1 to F.12.
fn errors(name: &'static str, scene: usize, outcome: &SceneResult, of: &DivisionResult) -> Table {
    let caption = format!(
        "Scene {}, {}: errors, and those published in document 003; error away from borders of hard shadows; excess of \
         textures above and below all elements.",
        outcome.setup.number,
        of.division.name()
    );
    let mut table = Table::new(
        name,
        caption,
        &[
            ("interpolation", "interpolation"),
            ("border_samples", "border samples"),
            ("l1", "L1"),
            ("published_l1", "L1, 003"),
            ("l2", "L2"),
            ("published_l2", "L2, 003"),
            ("linf", "Linf"),
            ("published_linf", "Linf, 003"),
            ("l2_away", "L2 away from borders"),
            ("above", "above"),
            ("below", "below"),
        ],
    );
    for (made, printed) in of.made.iter().zip(published::errors(scene, of.division)) {
        let border = match (made.method.is_scattered(), made.method.border) {
            (false, _) => "-",
            (true, Border::Open) => "no",
            (true, Border::Sampled) => "yes",
        };
        let mut row: Vec<TableCell> = vec![made.method.name().into(), border.into()];
        row.extend(
            made.errors.iter().zip(printed).flat_map(|(ours, theirs)| [*ours, *theirs]).map(TableCell::from),
        );
        row.push(made.away.into());
        // Rounding errors are no overshoot.
        row.extend(made.overshoot.map(|over| TableCell::from(if over < 1e-12 { 0.0 } else { over })));
        table.push(row);
    }
    table
}

/// Table 4.1.
fn times(outcomes: &[SceneResult], size: [usize; 2]) -> Table {
    let clock = if clock::counts_processor_time() { "processor time" } else { "wall time" };
    let caption = format!(
        "Times for textures of {} x {} texels, with preparation and border samples, one thread, {clock} of one core of a current machine, ms; beside them those of document 003, \
         s (Celeron, 400 MHz). The reference of document 003 is a radiosity solution of 400 x 400 elements, ours the closed form.",
        size[0], size[1]
    );
    let mut table = Table::new(
        "table_4_1",
        caption,
        &[
            ("what", "what"),
            ("scene_1_ms", "1, ms"),
            ("scene_2_ms", "2, ms"),
            ("scene_3a_ms", "3a, ms"),
            ("scene_3b_ms", "3b, ms"),
            ("scene_4a_ms", "4a, ms"),
            ("scene_4b_ms", "4b, ms"),
            ("published_least_s", "003, least, s"),
            ("published_most_s", "003, most, s"),
        ],
    );
    let mut push = |what: String, ours: Vec<Option<Duration>>, theirs: Vec<f64>| {
        let mut row = vec![TableCell::Text(what)];
        row.extend(ours.into_iter().map(|time| TableCell::from(time.map(|time| time.as_secs_f64() * 1e3))));
        let most = theirs.iter().copied().reduce(f64::max);
        row.extend([theirs.into_iter().reduce(f64::min), most].map(TableCell::from));
        table.push(row);
    };
    let scenes = 0..outcomes.len();
    push(
        "reference".to_owned(),
        outcomes.iter().map(|o| Some(o.reference_time)).collect(),
        scenes.clone().filter_map(published::reference_time).collect(),
    );
    for division in FloorDivision::ALL {
        let of = |o: &'_ SceneResult| o.divisions.iter().position(|of| of.division == division);
        let name = division.name();
        let solved = outcomes.iter().map(|o| of(o).and_then(|d| Some(o.divisions.get(d)?.time)));
        push(format!("{name}, values of elements"), solved.collect(), Vec::new());
        let shown = methods(division)
            .into_iter()
            .filter(|method| !method.is_scattered() || method.border == Border::Sampled);
        for (place, InterpolationMethod { interpolation, border }) in shown.enumerate() {
            let time = |o: &SceneResult| {
                let of = o.divisions.get(of(o)?)?;
                Some(of.of(interpolation, border)?.time)
            };
            let theirs = scenes.clone().filter_map(|i| published::times(i, division).get(place).copied());
            push(
                format!("{name}, {}", super::method::name(interpolation)),
                outcomes.iter().map(time).collect(),
                theirs.collect(),
            );
        }
    }
    table
}
