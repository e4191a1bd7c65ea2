//! A planned room of `glanz illuminate`.

use std::path::Path;

use glanz::LoadedScene;
use glanz::formats::Options;
use glanz::illumination::planning::{PlanningRequest, RoomPlan};
use glanz::job::ResourceBudget;
use glanz::math::DVec3;
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::PlanArguments;
use crate::command::luminaire;

/// The room as a scene, with the limits and the flag of `options`, and what is to be rated in it.
///
/// # Errors
/// A photometric file or a length that is refused.
pub(crate) fn planned_room(
    arguments: &PlanArguments,
    size: DVec3,
    file: &Path,
    options: Options,
    messages: Messages,
) -> Result<(LoadedScene, PlanningRequest), CommandError> {
    let budget = ResourceBudget::new(options.limits.clone(), options.cancel.clone());
    let plan = RoomPlan {
        size,
        reflectances: arguments.reflectances(),
        luminaire: luminaire::kind(file, &budget, messages)?,
        grid: arguments.grid.unwrap_or([1, 1]),
        height: arguments.height.unwrap_or(size.z),
        turn: arguments.turn.to_radians(),
        work_plane: arguments.work_plane,
        eye: arguments.eye,
        margin: arguments.margin,
    };
    let description = plan.description().map_err(|error| CommandError::usage(error.to_string()))?;
    let mut request = plan.request();
    if arguments.emergency {
        request.open_area = plan.open_area().map_err(|error| CommandError::usage(error.to_string()))?;
    }
    let room = LoadedScene::from_description("room", description).limits(options.limits, options.cancel);
    Ok((room, request))
}
