//! Arguments of `glanz road`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use glanz::illumination::planning::MaintenanceFactor;
use glanz::illumination::planning::road::{RoadClass, RowArrangement};
use glanz_terminal::values::positive;

use super::common::LimitArguments;
use super::plan::{finite, maintenance};

const ROAD_HELP: &str = "\
A straight road with rows of luminaires, after EN 13201: mean luminance and its uniformities from
every lane, threshold increment, edge illuminance ratio, illuminances, and with --class a verdict
on each requirement (docs/lighting.md). All lanes are seen in the same direction.

Luminances need the reflection of the road surface, an r-table in a text file: its first line has
the word tan and the angles beta in degrees, each other line a tan epsilon and the reduced
luminance coefficients times 10,000 for these angles. # begins a comment. Q0 and S1 of the table
are printed, to be compared with those of the surface: 0.07 and 1.11 of R3.

Examples:
  glanz road lantern.ldt --spacing 30 --height 8 --class P3
  glanz road lantern.ldt --spacing 36 --height 10 --lanes 3 --arrangement opposite --surface r3.txt --class M3";

#[derive(Debug, Args)]
#[command(after_help = ROAD_HELP)]
pub(crate) struct RoadArguments {
    /// Photometric file of the luminaires, .ldt or .ies; C90 is the side of the road
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) luminaire: PathBuf,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
    /// Distance between luminaires of a row, metres
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) spacing: f64,
    /// Height of the photometric centres above the road, metres
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) height: f64,
    /// Number of lanes
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) lanes: u32,
    /// Width of a lane, metres
    #[arg(long, value_name = "M", default_value_t = 3.5, value_parser = positive)]
    pub(crate) lane_width: f64,
    /// Arrangement of the rows
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ArrangementName::Single)]
    arrangement: ArrangementName,
    /// Distance of the luminaires from the edge of the carriageway towards its middle, metres; below 0 beside it
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) overhang: f64,
    /// Turn of the luminaires about their own axis from C0 towards C90, degrees, for files whose C90 is not the side of the road
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) turn: f64,
    /// Tilt that raises the side of the road, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) tilt: f64,
    /// r-table of the road surface
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) surface: Option<PathBuf>,
    /// Lighting class whose requirements are judged: M1 to M6, C0 to C5, P1 to P6
    #[arg(long, value_name = "CLASS", value_parser = clap::value_parser!(RoadClass))]
    pub(crate) class: Option<RoadClass>,
    /// Maintenance factor, or its parts LLMFxLSFxLMFxRSMF
    #[arg(long, value_name = "MF", value_parser = maintenance)]
    maintenance: Option<MaintenanceFactor>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

impl RoadArguments {
    /// The same for the engine.
    pub(crate) fn arrangement(&self) -> RowArrangement {
        match self.arrangement {
            ArrangementName::Single => RowArrangement::SingleSided,
            ArrangementName::Opposite => RowArrangement::Opposite,
            ArrangementName::Staggered => RowArrangement::Staggered,
        }
    }

    /// The maintenance factor.
    pub(crate) fn maintenance(&self) -> MaintenanceFactor {
        self.maintenance.unwrap_or_default()
    }
}

/// Arrangements of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ArrangementName {
    // One row, on the right.
    Single,
    // Two rows face to face.
    Opposite,
    // Two rows, one moved by half a spacing.
    Staggered,
}
