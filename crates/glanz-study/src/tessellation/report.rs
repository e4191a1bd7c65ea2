//! The report of the study.

use glanz_light::Pixels;

use super::picture::{Difference, EXPONENT, SAMPLES};
use super::setup::{LEVEL, MeshCase, NARROW};
use crate::clock;
use crate::report::Report;
use crate::study::Settings;
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{Axis, Plot, ReferenceLine, Series, Table, TableCell};

/// Factor on the differences of the difference pictures.
pub(super) const GAIN: f64 = 8.0;

const COLUMNS: [(&str, &str); 12] = [
    ("surfaces", "surfaces"),
    ("kind", "made of"),
    ("triangles", "triangles"),
    ("build_ms", "build, ms"),
    ("render_s", "render, s"),
    ("total_s", "total, s"),
    ("memory_mb", "memory, MB"),
    ("normal_max_deg", "normal error, largest, degrees"),
    ("normal_rms_deg", "normal error, rms, degrees"),
    ("silhouette_px", "silhouette error, pixels"),
    ("highlight_rmse", "highlight RMSE, grey levels"),
    ("picture_rmse", "picture RMSE, grey levels"),
];

/// Results for a number of surfaces.
pub(super) struct SurfaceOutcome {
    pub(super) surfaces: usize,
    pub(super) exact: MeshCase,
    pub(super) cases: Vec<MeshCase>,
    pub(super) smallest: Option<MeshCase>,
    /// Length of the silhouettes, pixels.
    pub(super) length: f64,
    /// Share of the picture that shows a surface.
    pub(super) coverage: f64,
}

fn row(case: &MeshCase, surfaces: usize) -> [TableCell; 12] {
    let error =
        |value: f64| if case.triangles.is_some() { TableCell::Number(value) } else { TableCell::Missing };
    let Difference { normal_max, normal_rms, silhouette, .. } = case.difference;
    [
        (surfaces as u64).into(),
        if case.triangles.is_some() { "triangles" } else { "exact" }.into(),
        case.triangles.into(),
        (case.build.as_secs_f64() * 1e3).into(),
        case.render.as_secs_f64().into(),
        case.total().into(),
        (case.bytes as f64 / 1e6).into(),
        error(normal_max.to_degrees()),
        error(normal_rms.to_degrees()),
        error(silhouette),
        error(case.highlight),
        error(case.whole),
    ]
}

fn named(surfaces: usize) -> String {
    plural(surfaces as u64, "surface", "surfaces")
}

/// Builds the report; `pictures`: exact, coarsest and their difference, for each number of surfaces.
pub(super) fn build_report(
    results: &[SurfaceOutcome],
    pictures: Vec<(usize, Pixels, Pixels, Pixels)>,
    size: [u32; 2],
    settings: &Settings,
) -> Report {
    let caption = format!(
        "Pictures of {} x {} pixels, {SAMPLES} samples per pixel: the exact surface, and triangles with the surface's normals \
         at their vertices. Errors are against the exact picture.",
        size[0], size[1]
    );
    let mut summary = Table::new("summary", caption, &COLUMNS);
    for result in results {
        summary.push(row(&result.exact, result.surfaces));
        for case in &result.cases {
            summary.push(row(case, result.surfaces));
        }
    }
    let mut report =
        Report::new("Study tessellation: triangles compared with the surface that they approximate", summary);
    report.heading("Question");
    report.paragraph(
        "According to document 002, direct intersection of a spline surface is 17.6 % slower (its table 1: 4.04 s and 3.69 \
         s) than 31 250 triangles, the number at which facets are hardly visible. How many triangles does Glanz need for \
         highlights that cannot be distinguished from exact ones, and what do they cost in time and memory, compared with \
         the exact surface?",
    );
    report.paragraph(settings_text(results, settings));
    report.heading("Smallest sufficient number of triangles");
    report.table(smallest_table(results));
    report.heading("Plots");
    for (name, plot, caption) in plots(results) {
        report.plot(name, plot, caption);
    }
    report.heading("Pictures");
    for (surfaces, exact, coarsest, difference) in pictures {
        let fewest = results.iter().find(|r| r.surfaces == surfaces).and_then(|r| r.cases.first()?.triangles);
        let fewest = fewest.map(grouped).unwrap_or_default();
        report.picture(format!("exact_{surfaces}"), exact, format!("{}, exact.", named(surfaces)));
        report.picture(format!("coarse_{surfaces}"), coarsest, format!("The same as {fewest} triangles."));
        let caption = format!("Triangles minus exact, {GAIN} times, on grey.");
        report.picture(format!("difference_{surfaces}"), difference, caption);
    }
    report.heading("Findings");
    for sentence in results.iter().flat_map(findings) {
        report.paragraph(sentence);
    }
    report
}

fn settings_text(results: &[SurfaceOutcome], settings: &Settings) -> String {
    let clock = if clock::counts_processor_time() { "processor time" } else { "wall time" };
    let seen: Vec<String> = results
        .iter()
        .map(|r| {
            format!(
                "of {}, {} % of the picture and silhouettes of {} pixels",
                named(r.surfaces),
                significant(100.0 * r.coverage),
                significant(r.length)
            )
        })
        .collect();
    format!(
        "Settings: uniform bicubic B-spline surfaces of 8 x 8 patches, integrator `whitted`, Phong's model (diffuse 0.15, \
         specular 0.7, exponent {EXPONENT}), one distant light without shadows. Visible are: {}. Seed {}. One thread; times \
         are {clock}. *Build* is the time from control points to the scene with its hierarchy, including tessellation; *memory* is that \
         of the surfaces with their hierarchies. *Normal errors* and *silhouettes* are measured by rays through the middles of \
         pixels; the silhouette error is the differing area over the length of the silhouettes. *Highlight RMSE* covers the \
         pixels away from silhouettes that are brighter than diffuse light alone in the exact or the other picture, in grey \
         levels of an sRGB display from 0 to 255; *picture RMSE* is over all pixels.",
        seen.join("; "),
        settings.seed
    )
}

fn smallest_table(results: &[SurfaceOutcome]) -> Table {
    let caption = format!(
        "The smallest number of triangles with a highlight RMSE of at most {LEVEL} grey level (to {} % in grid lines), and the \
         exact surface.",
        100.0 * NARROW
    );
    let mut table = Table::new("smallest", caption, &COLUMNS);
    for result in results {
        table.push(row(&result.exact, result.surfaces));
        if let Some(case) = &result.smallest {
            table.push(row(case, result.surfaces));
        }
    }
    table
}

fn plots(results: &[SurfaceOutcome]) -> Vec<(&'static str, Plot, &'static str)> {
    let series = |x: fn(&MeshCase) -> f64, y: fn(&MeshCase) -> f64| -> Vec<Series> {
        let of = |r: &SurfaceOutcome| Series {
            name: format!("{} of triangles", named(r.surfaces)),
            points: r.cases.iter().map(|c| [x(c), y(c)]).collect(),
        };
        results.iter().map(of).collect()
    };
    let reference_lines = |value: fn(&MeshCase) -> f64, vertical: bool| -> Vec<ReferenceLine> {
        let of = |(i, r): (usize, &SurfaceOutcome)| {
            let name = format!("{} exact", r.surfaces);
            ReferenceLine { name, vertical, at: value(&r.exact), series: Some(i) }
        };
        results.iter().enumerate().map(of).collect()
    };
    let count = |c: &MeshCase| c.triangles.unwrap_or_default() as f64;
    let memory = |c: &MeshCase| c.bytes as f64 / 1e6;
    let level = ReferenceLine { name: "one grey level".to_owned(), vertical: false, at: LEVEL, series: None };
    let mut over_time = reference_lines(MeshCase::total, true);
    over_time.push(level.clone());
    let mut over_memory = reference_lines(memory, true);
    over_memory.push(level);
    let grey = || Axis::logarithmic("highlight RMSE, grey levels");
    vec![
        (
            "error_time",
            Plot {
                title: "Error of highlights over time".to_owned(),
                x: Axis::logarithmic("time from control points to picture, s"),
                y: grey(),
                series: series(MeshCase::total, |c| c.highlight),
                reference_lines: over_time,
            },
            "Highlight error over time of build and render; the exact surfaces have no error and appear as vertical lines.",
        ),
        (
            "error_memory",
            Plot {
                title: "Error of highlights over memory".to_owned(),
                x: Axis::logarithmic("memory, MB"),
                y: grey(),
                series: series(memory, |c| c.highlight),
                reference_lines: over_memory,
            },
            "Highlight error over memory; the exact surfaces have none and stand as vertical lines.",
        ),
        (
            "error_normal",
            Plot {
                title: "Largest error of normals".to_owned(),
                x: Axis::logarithmic("triangles"),
                y: Axis::logarithmic("largest normal error, degrees"),
                series: series(count, |c| c.difference.normal_max.to_degrees()),
                reference_lines: Vec::new(),
            },
            "Largest angle between the interpolated normal of the triangles and that of the surface.",
        ),
        (
            "error_silhouette",
            Plot {
                title: "Error of silhouettes".to_owned(),
                x: Axis::logarithmic("triangles"),
                y: Axis::logarithmic("mean displacement, pixels"),
                series: series(count, |c| c.difference.silhouette),
                reference_lines: Vec::new(),
            },
            "Mean displacement of the silhouettes; points without differing pixels are left out.",
        ),
    ]
}

/// Findings as sentences with their figures.
fn findings(result: &SurfaceOutcome) -> Vec<String> {
    let SurfaceOutcome { surfaces, exact, cases, smallest, .. } = result;
    let ratio = |a: f64, b: f64, better: &str, worse: &str| {
        if a <= b {
            format!("{} times {better}", significant(b / a))
        } else {
            format!("{} times {worse}", significant(a / b))
        }
    };
    let against = |case: &MeshCase| {
        format!(
            "the exact surface is {} from control points to picture ({} s and {} s; render alone {} s and {} s) and uses {} \
             memory ({} MB and {} MB)",
            ratio(exact.total(), case.total(), "faster", "slower"),
            significant(exact.total()),
            significant(case.total()),
            significant(exact.render.as_secs_f64()),
            significant(case.render.as_secs_f64()),
            ratio(exact.bytes as f64, case.bytes as f64, "less", "more"),
            significant(exact.bytes as f64 / 1e6),
            significant(case.bytes as f64 / 1e6),
        )
    };
    let mut found = Vec::new();
    found.push(match smallest {
        Some(case) => format!(
            "{}: highlights within {LEVEL} grey level require {} triangles; compared with these {}. Their silhouettes \
             deviate by {} pixels, their normals by up to {} degrees.",
            named(*surfaces),
            grouped(case.triangles.unwrap_or_default()),
            against(case),
            significant(case.difference.silhouette),
            significant(case.difference.normal_max.to_degrees())
        ),
        None => format!(
            "{}: no tested number of triangles gives highlights within {LEVEL} grey level.",
            named(*surfaces)
        ),
    });
    if let Some(finest) = cases.last() {
        found.push(format!(
            "Compared with the {} triangles of the finest mesh {}; the mesh deviates by {} grey levels and {} pixels.",
            grouped(finest.triangles.unwrap_or_default()),
            against(finest),
            significant(finest.highlight),
            significant(finest.difference.silhouette)
        ));
    }
    found
}
