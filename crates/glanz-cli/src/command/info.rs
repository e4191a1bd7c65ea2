//! `glanz info`: a summary of a scene or a photometric file.

use std::collections::BTreeMap;
use std::fmt::Write;

use glanz::math::Bounds3;
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::InfoArguments;
use crate::command::cad::CadSummary;
use crate::command::{files, luminaire};
use crate::command_error::command_error;
use crate::notes::note_warning;
use crate::report::{self, grouped};
use crate::scene_file;

/// The output of `--json`.
#[derive(Serialize)]
struct InfoReport {
    scene: String,
    files: Vec<String>,
    /// Unit of lengths of the scene.
    units: &'static str,
    /// Smallest and largest corner of the bounded shapes; null if there are none.
    bounds: Option<Corners>,
    /// Surfaces by kind; one in a group counts once, however often the group is copied.
    shapes: BTreeMap<&'static str, usize>,
    triangles: usize,
    groups: usize,
    instances: usize,
    lights: BTreeMap<&'static str, usize>,
    materials: usize,
    textures: usize,
    images: usize,
    resolution: [u32; 2],
    integrator: String,
    sampler: String,
    samples_per_pixel: u32,
    warnings: Vec<String>,
    /// Of a CAD file, the outcome for each of its faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    cad: Option<CadSummary>,
}

#[derive(Serialize)]
struct Corners {
    min: [f64; 3],
    max: [f64; 3],
}

/// Reads the scene, resolves it, and prints its summary.
///
/// # Errors
/// A scene that is refused.
pub(crate) fn run(arguments: &InfoArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    if arguments.files && scene_file::is_standard_input(&arguments.scene) {
        return Err(CommandError::usage(
            "--files lists the files of a scene file, not of the standard input",
        ));
    }
    if arguments.files {
        return files::run(arguments, messages);
    }
    if !scene_file::is_standard_input(&arguments.scene) && luminaire::is_photometric(&arguments.scene) {
        luminaire::run(arguments, messages)?;
        return Ok(CommandOutcome::Done);
    }
    if arguments.plot.is_some() {
        return Err(CommandError::usage("--plot draws the distribution of a photometric file: .ies or .ldt"));
    }
    if arguments.ugr {
        return Err(CommandError::usage("--ugr rates the luminaire of a photometric file: .ies or .ldt"));
    }
    let cancel = interrupt::listen()?;
    let scene = scene_file::open(&arguments.scene, &arguments.reading, &cancel, messages)?;
    let name = scene.name().to_owned();
    let mut warnings: Vec<String> = scene.diagnostics().iter().map(|d| d.sentence()).collect();
    let description = scene.description();
    let (textures, images) = (description.textures.len(), description.images.len());
    let (resolution, files) = (description.film.resolution, description.files.clone());
    let integrator = description.integrator.name.clone();
    let cad = scene.cad().map(CadSummary::from);
    let sampler = description.sampler.clone();
    let (scene, resolved) = scene.resolve().map_err(command_error(messages))?;
    for warning in resolved {
        note_warning(&warning, messages);
        warnings.push(warning.to_string());
    }
    let statistics = scene.statistics();
    let report = InfoReport {
        scene: name,
        files,
        units: "metres",
        bounds: corners(&scene.bounds()),
        shapes: statistics.surfaces,
        triangles: statistics.triangles,
        groups: statistics.groups,
        instances: statistics.instances,
        lights: statistics.lights,
        materials: statistics.materials,
        textures,
        images,
        resolution,
        integrator,
        sampler: sampler.name,
        samples_per_pixel: sampler.samples_per_pixel,
        warnings,
        cad,
    };
    if arguments.json {
        report::print(&report)?
    } else {
        let cad = report.cad.as_ref().map(|cad| cad.text(arguments.verbose)).unwrap_or_default();
        report::print_text(&(text(&report) + &cad))?
    }
    Ok(CommandOutcome::Done)
}

fn corners(bounds: &Bounds3) -> Option<Corners> {
    let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
    (!bounds.is_empty()).then_some(Corners { min, max })
}

fn text(report: &InfoReport) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    line("scene", &report.scene);
    if report.files.len() > 1 {
        line("files", &report.files.join(", "));
    }
    line("shapes", &counts(&report.shapes));
    if report.triangles > 0 {
        line("triangles", &grouped(report.triangles as u64));
    }
    if report.instances > 0 {
        line("instances", &format!("{} of {} groups", grouped(report.instances as u64), report.groups));
    }
    line("lights", &counts(&report.lights));
    line("materials", &report.materials.to_string());
    line("textures", &format!("{}, {} images", report.textures, report.images));
    match &report.bounds {
        Some(Corners { min, max }) => {
            let corner = |[x, y, z]: &[f64; 3]| format!("({x:.6}, {y:.6}, {z:.6})");
            line("bounds", &format!("{} to {}", corner(min), corner(max)));
        }
        None => line("bounds", "empty"),
    }
    line("units", report.units);
    let [width, height] = report.resolution;
    line("picture", &format!("{width} x {height}, {} samples per pixel", report.samples_per_pixel));
    line("integrator", &report.integrator);
    line("sampler", &report.sampler);
    line("warnings", &report.warnings.len().to_string());
    text
}

fn counts(counts: &BTreeMap<&'static str, usize>) -> String {
    let list: Vec<String> =
        counts.iter().map(|(kind, count)| format!("{} {kind}", grouped(*count as u64))).collect();
    if list.is_empty() { "none".to_owned() } else { list.join(", ") }
}
