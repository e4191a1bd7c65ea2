//! Sections of the report on facets and closed forms.

use super::conics::{Conic, Deviation, HEIGHTS, MirrorModel, aberration};
use super::facets::{FacetOutcome, MirrorCase};
use super::particles::CELLS;
use crate::report::Report;
use glanz_report::number::{grouped, significant};
use glanz_report::{Axis, Plot, ReferenceLine, Series, Table, TableCell};

const COLUMNS: [(&str, &str); 12] = [
    ("kind", "mirror"),
    ("triangles", "triangles"),
    ("build_ms", "build, ms"),
    ("time_s", "time, s"),
    ("ns_per_particle", "time per particle, ns"),
    ("moved_percent", "particles that end elsewhere, %"),
    ("rms_lx", "error, rms, lx"),
    ("rms_noise_lx", "random part, lx"),
    ("rms_percent", "systematic error, % of the mean"),
    ("largest_lx", "largest error, lx"),
    ("largest_noise_lx", "standard error there, lx"),
    ("largest_percent", "largest error, % of the peak"),
];

fn kind(case: &MirrorCase) -> &'static str {
    match (case.triangles, case.smooth) {
        (None, _) => "exact",
        (_, false) => "flat facets",
        (_, true) => "facets, interpolated normals",
    }
}

/// The table of the mirrors.
pub(super) fn facets_table(outcome: &FacetOutcome) -> Table {
    let caption = format!(
        "Light reflected by the mirror on {CELLS} x {CELLS} cells of each wall: the mirror as triangles compared with the exact \
         one, with the same {} particles.",
        grouped(u64::from(outcome.particles))
    );
    let mut table = Table::new("facets", caption, &COLUMNS);
    for case in &outcome.cases {
        let time = case.time.as_secs_f64();
        let off =
            |value: f64| if case.triangles.is_some() { TableCell::Number(value) } else { TableCell::Missing };
        table.push([
            kind(case).into(),
            case.triangles.into(),
            (case.build.as_secs_f64() * 1e3).into(),
            time.into(),
            (1e9 * time / f64::from(outcome.particles)).into(),
            off(100.0 * case.error.moved),
            off(case.error.rms),
            off(case.error.noise),
            off(percent(case.error.systematic(), outcome)),
            off(case.error.largest),
            off(case.error.largest_noise),
            off(100.0 * case.error.largest / outcome.exact.peak),
        ]);
    }
    table
}

fn percent(lux: f64, outcome: &FacetOutcome) -> f64 {
    100.0 * lux / outcome.exact.mean
}

/// Adds the section on the room's mirror.
pub(super) fn add_facets(outcome: &FacetOutcome, report: &mut Report) {
    report.heading("The mirror as triangles");
    let exact = &outcome.exact;
    report.paragraph(format!(
        "{} particles start from the lamp towards the mirror; {} % of them hit it. The illuminance by light from the exact \
         mirror is {} lx in the mean of the lit cells and {} lx at most; the random error of the map is {} lx (root mean \
         square, as for independent particles). The same particles are traced with the mirror as triangles: only \
         particles that end elsewhere make a difference, whose random part is listed with it.",
        grouped(u64::from(outcome.particles)),
        significant(100.0 * exact.met),
        significant(exact.mean),
        significant(exact.peak),
        significant(exact.noise),
    ));
    report.table(facets_table(outcome));
    let floor = ReferenceLine {
        name: "random error of the map itself".to_owned(),
        vertical: false,
        at: percent(exact.noise, outcome),
        series: None,
    };
    let triangles = |case: &MirrorCase| case.triangles.unwrap_or_default() as f64;
    report.plot(
        "facets_triangles",
        Plot {
            title: "Error of the mirror's light over triangles".to_owned(),
            x: Axis::logarithmic("triangles"),
            y: Axis::logarithmic("root mean square error, % of the mean"),
            series: series(outcome, triangles),
            reference_lines: vec![floor.clone()],
        },
        "Error over the lit cells, measured with the same particles, and its random part.",
    );
    let seconds = |case: &MirrorCase| case.time.as_secs_f64();
    let mut reference_lines = vec![floor];
    if let Some(case) = outcome.cases.first() {
        let name = "time of the exact mirror".to_owned();
        reference_lines.push(ReferenceLine { name, vertical: true, at: seconds(case), series: None });
    }
    report.plot(
        "facets_time",
        Plot {
            title: "Error of the mirror's light over time".to_owned(),
            x: Axis::logarithmic("processor time for all particles, s"),
            y: Axis::logarithmic("root mean square error, % of the mean"),
            series: series(outcome, seconds),
            reference_lines,
        },
        "The same over the time to trace the particles, without building.",
    );
    facets_findings(outcome).into_iter().for_each(|sentence| report.paragraph(sentence));
}

fn series(outcome: &FacetOutcome, x: fn(&MirrorCase) -> f64) -> Vec<Series> {
    let of = |name: &str, smooth: bool, y: fn(&MirrorCase) -> f64| Series {
        name: name.to_owned(),
        points: outcome
            .cases
            .iter()
            .filter(|case| case.triangles.is_some() && case.smooth == smooth)
            .map(|case| [x(case), percent(y(case), outcome)])
            .collect(),
    };
    vec![
        of("flat facets", false, |case| case.error.rms),
        of("interpolated normals", true, |case| case.error.rms),
        of("random part, flat facets", false, |case| case.error.noise),
        of("random part, interpolated normals", true, |case| case.error.noise),
    ]
}

fn facets_findings(outcome: &FacetOutcome) -> Vec<String> {
    let mut found = Vec::new();
    let Some(exact) = outcome.cases.first() else { return found };
    for smooth in [false, true] {
        let series: Vec<&MirrorCase> =
            outcome.cases.iter().filter(|case| case.triangles.is_some() && case.smooth == smooth).collect();
        let Some((first, last)) = series.first().zip(series.last()) else { continue };
        let one_percent = series.iter().find(|case| percent(case.error.systematic(), outcome) < 1.0);
        let error_text = |case: &MirrorCase| {
            let error = percent(case.error.systematic(), outcome);
            if error > 0.0 {
                format!("{} %", significant(error))
            } else {
                "below the random error".to_owned()
            }
        };
        found.push(format!(
            "{}: the systematic error is {} of the mean with {} triangles and {} with {}; {} particles end elsewhere with \
             the finest mesh. {} Tracing a particle takes {} times as long with the finest mesh as with the exact mirror.",
            if smooth { "Facets with interpolated normals" } else { "Flat facets" },
            error_text(first),
            grouped(first.triangles.unwrap_or_default()),
            error_text(last),
            grouped(last.triangles.unwrap_or_default()),
            format_args!("{} % of the", significant(100.0 * last.error.moved)),
            match one_percent {
                Some(case) => format!(
                    "The smallest tested number of triangles with an error below 1 % of the mean is {}.",
                    grouped(case.triangles.unwrap_or_default())
                ),
                None => "It is not below 1 % of the mean for any tested number of triangles.".to_owned(),
            },
            significant(last.time.as_secs_f64() / exact.time.as_secs_f64().max(1e-9)),
        ));
    }
    found
}

/// Measurement of a mirror with a closed form.
pub(super) struct ConicRow {
    pub(super) conic: Conic,
    pub(super) model: MirrorModel,
    pub(super) triangles: Option<u64>,
    pub(super) deviation: Deviation,
}

/// Adds the section on mirrors with closed forms; `curves`: crossings of the axis of the sphere over the height of the rays.
pub(super) fn add_conics(rows: &[ConicRow], curves: Vec<Series>, report: &mut Report) {
    report.heading("Mirrors with closed forms");
    report.paragraph(
        "A paraboloid (focal length 0.5 m, radius 1 m) with a point at its focus: the angle of the reflected rays to the axis. An \
         ellipsoid (half axes 0.8 and 1 m): distance from the second focus at which rays from the first pass. A sphere (radius 1 m) and rays \
         along its axis at heights from 0.05 to 0.85 m: crossing of the axis by the reflected rays, compared with R / (2 cos \
         theta) from the middle, sin theta = h / R.",
    );
    let columns = [
        ("mirror", "mirror"),
        ("measure", "measure"),
        ("made_of", "made of"),
        ("triangles", "triangles"),
        ("largest", "largest"),
        ("rms", "root mean square"),
        ("rays", "rays"),
        ("missed", "rays that miss it"),
    ];
    let mut table = Table::new("closed_forms", "Deviations from the closed forms.", &columns);
    for ConicRow { conic, model, triangles, deviation } in rows {
        table.push([
            conic.name().into(),
            conic.measure().into(),
            model.name().into(),
            (*triangles).into(),
            deviation.largest.into(),
            deviation.rms.into(),
            deviation.rays.into(),
            deviation.missed.into(),
        ]);
    }
    report.table(table);
    for (conic, name, title) in [
        (Conic::Parabolic, "parabolic", "Divergence of a parabolic mirror's beam"),
        (Conic::Elliptic, "elliptic", "Blur in the second focus of an elliptic mirror"),
    ] {
        report.plot(name, deviation_plot(rows, conic, title), "Largest over all rays.");
    }
    report.plot(
        "aberration",
        Plot {
            title: "Longitudinal aberration of a spherical mirror, R = 1 m".to_owned(),
            x: Axis::linear("height of the ray, m"),
            y: Axis::linear("crossing of the axis, m from the middle"),
            series: curves,
            reference_lines: Vec::new(),
        },
        "Crossing of the axis after the reflection of rays parallel to it.",
    );
    for conic in Conic::ALL {
        report.paragraph(finding(rows, conic));
    }
}

fn deviation_plot(rows: &[ConicRow], conic: Conic, title: &str) -> Plot {
    let of = |name: &str, smooth: bool| Series {
        name: name.to_owned(),
        points: rows
            .iter()
            .filter(|row| row.conic == conic && matches!(row.model, MirrorModel::Smooth(_)) == smooth)
            .filter_map(|row| Some([row.triangles? as f64, row.deviation.largest]))
            .collect(),
    };
    let exact = rows.iter().filter(|row| row.conic == conic && row.triangles.is_none());
    let rule = |row: &ConicRow| ReferenceLine {
        name: format!("exact: {}", row.model.name()),
        vertical: false,
        at: row.deviation.largest,
        series: if row.model == MirrorModel::Quadric { None } else { Some(2) },
    };
    Plot {
        title: title.to_owned(),
        x: Axis::logarithmic("triangles"),
        y: Axis::logarithmic(conic.measure()),
        series: vec![of("flat facets", false), of("interpolated normals", true)],
        reference_lines: exact.map(rule).collect(),
    }
}

/// The closed form over heights.
pub(super) fn closed_form_curve() -> Series {
    let points = heights(76).into_iter().map(|h| [h, aberration(h)]).collect();
    Series { name: "closed form".to_owned(), points }
}

/// `count` heights over the range.
pub(super) fn heights(count: u32) -> Vec<f64> {
    let step = (HEIGHTS[1] - HEIGHTS[0]) / f64::from(count.max(2) - 1);
    (0..count).map(|i| HEIGHTS[0] + step * f64::from(i)).collect()
}

fn finding(rows: &[ConicRow], conic: Conic) -> String {
    let largest = |wanted: fn(MirrorModel) -> bool| {
        let of = rows.iter().filter(|row| row.conic == conic && wanted(row.model));
        of.map(|row| (row.triangles.unwrap_or_default(), row.deviation.largest)).collect::<Vec<_>>()
    };
    let exact = largest(|model| matches!(model, MirrorModel::Quadric | MirrorModel::Patches));
    let exact = exact.iter().map(|(_, off)| *off).fold(0.0, f64::max);
    let ends = |rows: &[(u64, f64)]| match (rows.first(), rows.last()) {
        (Some(first), Some(last)) => format!(
            "{} with {} triangles and {} with {}",
            significant(first.1),
            grouped(first.0),
            significant(last.1),
            grouped(last.0)
        ),
        _ => "not measured".to_owned(),
    };
    format!(
        "The {} mirror ({}): at most {} for the exact surfaces; flat facets {}, with interpolated normals {}.",
        conic.name(),
        conic.measure(),
        significant(exact),
        ends(&largest(|model| matches!(model, MirrorModel::Facets(_)))),
        ends(&largest(|model| matches!(model, MirrorModel::Smooth(_)))),
    )
}
