//! `glanz road`: the lighting of a road.

use std::path::Path;

use glanz::illumination::planning::road::{LuminaireRow, RoadLayout, RoadRatingError, RoadSurface};
use glanz::job::{CancelFlag, ResourceBudget};
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::RoadArguments;
use crate::command::luminaire;
use crate::file_help::{is_guess, named};
use crate::input;
use crate::report;

/// Rates the road and prints its figures.
///
/// # Errors
/// A file, length or class that is refused.
pub(crate) fn run(arguments: &RoadArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let width = f64::from(arguments.lanes) * arguments.lane_width;
    let RoadArguments { spacing, overhang, .. } = *arguments;
    // Without a flag, so that the first Ctrl-C ends the command.
    let budget = ResourceBudget::new(arguments.limits.limits(), CancelFlag::default());
    let layout = RoadLayout {
        luminaire: luminaire::kind(&arguments.luminaire, &budget, messages)?,
        rows: LuminaireRow::of_arrangement(arguments.arrangement(), width, spacing, overhang),
        spacing,
        height: arguments.height,
        turn: arguments.turn.to_radians(),
        tilt: arguments.tilt.to_radians(),
        lanes: arguments.lanes,
        lane_width: arguments.lane_width,
    };
    let surface = arguments.surface.as_deref().map(|path| surface(path, &budget, messages)).transpose()?;
    let rated = layout.rate(surface.as_ref(), &arguments.maintenance(), arguments.class);
    let road = rated.map_err(|error| {
        let failure = CommandError::usage(error.to_string());
        match error {
            RoadRatingError::Surface(_) => failure.with_help("name an r-table with --surface FILE"),
            _ => failure,
        }
    })?;
    if arguments.json {
        report::print(&road)?
    } else {
        report::print_text(&road.text())?
    }
    Ok(CommandOutcome::Done)
}

/// The road surface of a file.
fn surface(path: &Path, budget: &ResourceBudget, messages: Messages) -> Result<RoadSurface, CommandError> {
    let bytes = input::read(path, budget, messages)?;
    let text = String::from_utf8_lossy(&bytes);
    RoadSurface::read(&text)
        .map_err(|error| CommandError::new(format!("{}:{error}", path.display())))
        .map_err(|error| named(error, path, is_guess))
}
