//! `glanz info` of a photometric file: a summary of a luminaire.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use glanz::file::FileUses;
use glanz::formats::ContentKind;
use glanz::formats::photometry::{self, AngularSystem, IntensityDistribution, Photometry, PhotometryFormat};
use glanz::illumination::planning::{LuminaireAxis, LuminaireKind, UgrTable};
use glanz::illumination::report::PolarPlot;
use glanz::job::{CancelFlag, ResourceBudget};
use glanz::report::Table;
use glanz::report::number::significant;
use glanz_terminal::messages::{CommandError, Messages};
use serde::Serialize;

use crate::arguments::InfoArguments;
use crate::command_error::command_error;
use crate::file_help::{is_guess, named};
use crate::input;
use crate::report;

/// Step of the angles at which the brightest direction of a plane is searched, degrees.
const BEAM_STEP: f64 = 0.1;

/// The output of `--json`.
#[derive(Serialize)]
struct LuminaireReport {
    file: String,
    format: String,
    luminaire: String,
    manufacturer: String,
    /// From the intensities.
    flux_lm: f64,
    /// From the header: the flux of the luminaire in EULUMDAT, of its lamps in LM-63.
    header_flux_lm: Option<f64>,
    peak_cd: f64,
    /// C and gamma of the largest intensity; null if all is dark.
    peak_direction_degrees: Option<[f64; 2]>,
    /// Full angles within which the intensity is more than half, and a tenth, of the largest of the plane; planes C0 and C90.
    beam_angle_degrees: [Option<f64>; 2],
    field_angle_degrees: [Option<f64>; 2],
    watts: f64,
    planes: usize,
    gammas: usize,
    symmetry: String,
    opening: String,
    opening_size_m: [f64; 3],
    plot: Option<String>,
    /// UGR in standard rooms.
    #[serde(skip_serializing_if = "Option::is_none")]
    ugr: Option<Table>,
    warnings: Vec<String>,
}

/// Whether it is a photometric file by its extension or its content.
pub(crate) fn is_photometric(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    ["ies", "ldt"].iter().any(|known| extension.eq_ignore_ascii_case(known))
        || ContentKind::of_file(path).is_some_and(|kind| is_luminaire(&kind))
}

/// Whether a file has the candela distribution of a luminaire.
fn is_luminaire(kind: &ContentKind) -> bool {
    matches!(kind, ContentKind::Luminaire(format) if *format != "TM-25")
}

/// Reads a photometric file within the budget and prints its warnings, which are returned, too.
///
/// # Errors
/// A file that is refused, with line and column.
fn read(
    path: &Path,
    budget: &ResourceBudget,
    messages: Messages,
) -> Result<(Photometry, Vec<String>), CommandError> {
    let bytes = input::read(path, budget, messages)?;
    let at = |fault: &photometry::PhotometryError| format!("{}:{fault}", path.display());
    let file = photometry::read(&bytes)
        .map_err(|fault| CommandError::new(at(&fault)))
        .map_err(|error| named(error, path, |kind| is_luminaire(kind) || is_guess(kind)))?;
    let warnings: Vec<String> = file.warnings.iter().map(at).collect();
    warnings.iter().for_each(|warning| messages.warning(warning));
    Ok((file.photometry, warnings))
}

/// The luminaire of a photometric file that is read within the budget, for plans.
///
/// # Errors
/// A file that is refused, with line and column.
pub(crate) fn kind(
    path: &Path,
    budget: &ResourceBudget,
    messages: Messages,
) -> Result<LuminaireKind, CommandError> {
    let (photometry, _) = read(path, budget, messages)?;
    Ok(LuminaireKind {
        description: Arc::new(photometry.description(path)),
        distribution: Arc::new(photometry.distribution),
    })
}

/// Reads the file and prints its summary.
///
/// # Errors
/// A file that is refused, with line and column.
pub(crate) fn run(arguments: &InfoArguments, messages: Messages) -> Result<(), CommandError> {
    let path = &arguments.scene;
    let mut files = FileUses::default();
    files.add_input(path).map_err(command_error(messages))?;
    arguments
        .plot
        .as_deref()
        .map_or(Ok(()), |plot| files.add_output(plot))
        .map_err(command_error(messages))?;
    let budget = ResourceBudget::new(arguments.reading.limits(), CancelFlag::default());
    let (photometry, warnings) = read(path, &budget, messages)?;
    if let Some(plot) = &arguments.plot {
        let svg = polar(&photometry, path).svg();
        glanz::file::write(plot, svg.as_bytes()).map_err(command_error(messages))?;
    }
    let ugr = arguments.ugr.then(|| ugr_table(&photometry, path)).transpose()?;
    let report = LuminaireReport { ugr, ..report_of(&photometry, arguments, warnings) };
    if arguments.json { report::print(&report) } else { report::print_text(&text(&report)) }
}

/// The table of UGR; the axis of the luminaire is the length of its opening, as its format has it.
///
/// # Errors
/// A luminaire without a luminous opening.
fn ugr_table(photometry: &Photometry, path: &Path) -> Result<Table, CommandError> {
    let axis = match photometry.format {
        PhotometryFormat::Ies(_) => LuminaireAxis::X,
        PhotometryFormat::Eulumdat => LuminaireAxis::Y,
    };
    let distribution = Arc::new(photometry.distribution.clone());
    let table = UgrTable::try_new(&path.display().to_string(), &distribution, photometry.opening, axis);
    table.map(|table| table.table()).map_err(|error| CommandError::new(format!("--ugr: {error}")))
}

fn polar(photometry: &Photometry, path: &Path) -> PolarPlot {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    // Plotted by C and gamma, independent of the system of its angles.
    let candela = |c: f64, gamma: f64| photometry.intensity(AngularSystem::C.direction(c, gamma));
    PolarPlot::sample(name, 0.0, photometry.distribution.polars(), candela)
}

fn report_of(photometry: &Photometry, arguments: &InfoArguments, warnings: Vec<String>) -> LuminaireReport {
    let distribution = &photometry.distribution;
    let angles = |share: f64| [0.0, 90.0].map(|c| full_angle(distribution, c, share));
    LuminaireReport {
        file: arguments.scene.display().to_string(),
        format: match photometry.format {
            PhotometryFormat::Ies(year) => format!("IES LM-63-{year}"),
            PhotometryFormat::Eulumdat => "EULUMDAT".to_owned(),
        },
        luminaire: photometry.names.luminaire.clone(),
        manufacturer: photometry.names.manufacturer.clone(),
        flux_lm: photometry.flux(),
        header_flux_lm: photometry.header_flux(),
        peak_cd: distribution.peak(),
        peak_direction_degrees: distribution.beam().map(|beam| {
            let [azimuth, polar] = beam.peak_angles;
            let [c, gamma] = AngularSystem::C.angles(distribution.direction(azimuth, polar));
            [c.rem_euclid(360.0), gamma]
        }),
        beam_angle_degrees: angles(0.5),
        field_angle_degrees: angles(0.1),
        watts: photometry.input_watts,
        planes: distribution.azimuths().len(),
        gammas: distribution.polars().len(),
        symmetry: format!("{:?}", distribution.symmetry()),
        opening: format!("{:?}", photometry.opening.shape),
        opening_size_m: photometry.opening.size,
        plot: arguments.plot.as_ref().map(|plot| plot.display().to_string()),
        ugr: None,
        warnings,
    }
}

/// The angle around the brightest direction of the plane of C `c` and its opposite, within which the intensity is at least
/// `share` of the peak; `None` in a dark plane.
fn full_angle(distribution: &IntensityDistribution, c: f64, share: f64) -> Option<f64> {
    let at = |gamma: f64| distribution.intensity(AngularSystem::C.direction(c, gamma));
    let steps = (180.0 / BEAM_STEP) as i32;
    let even = (-steps..=steps).map(|step| f64::from(step) * BEAM_STEP);
    // A narrow beam has its peak at one of the angles of the file.
    let own = distribution.polars().iter().flat_map(|polar| [-polar, *polar]);
    let (top, peak) = even.chain(own).map(|gamma| (gamma, at(gamma))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [start, side] = [top, top + 90.0].map(|gamma| AngularSystem::C.direction(c, gamma));
    (peak > 0.0).then(|| distribution.full_angle(start, side, share * peak))
}

fn text(report: &LuminaireReport) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    line("file", &report.file);
    line("format", &report.format);
    line("luminaire", &report.luminaire);
    line("made by", &report.manufacturer);
    line("flux", &format!("{} lm", significant(report.flux_lm)));
    match report.header_flux_lm {
        Some(header) => {
            let percent = 100.0 * report.flux_lm / header;
            line("header", &format!("{} lm: the intensities give {percent:.2} % of it", significant(header)));
        }
        None => line("header", "no flux"),
    }
    let at = |[c, gamma]: [f64; 2]| format!(" at C {}, gamma {}", significant(c), significant(gamma));
    let direction = report.peak_direction_degrees.map_or_else(String::new, at);
    line("peak", &format!("{} cd{direction}", significant(report.peak_cd)));
    let angles = |[c0, c90]: [Option<f64>; 2]| {
        let digits = |a: f64| if a < 10.0 { significant(a) } else { format!("{a:.0}") };
        let angle = |a: Option<f64>| a.map_or("-".to_owned(), digits);
        format!("{} degrees in C0-C180, {} in C90-C270", angle(c0), angle(c90))
    };
    line("beam, 50 %", &angles(report.beam_angle_degrees));
    line("field, 10 %", &angles(report.field_angle_degrees));
    line("power", &format!("{} W", significant(report.watts)));
    line(
        "angles",
        &format!("{} planes, {} in each; symmetry: {}", report.planes, report.gammas, report.symmetry),
    );

    let [x, y, z] = report.opening_size_m.map(significant);
    line("opening", &format!("{}, {x} x {y} x {z} m", report.opening));
    if let Some(plot) = &report.plot {
        line("plot", plot);
    }
    if let Some(ugr) = &report.ugr {
        text += &format!("\n{}:\n{}", ugr.caption(), ugr.plain());
    }
    text
}
