//! A planned room of `glanz illuminate`.

use std::path::Path;
use std::sync::Arc;

use glanz::LoadedScene;
use glanz::illumination::planning::{LuminaireKind, PlanningRequest, RoomPlan};
use glanz::math::DVec3;
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::PlanArguments;
use crate::command::luminaire;

/// The room as a scene, and what is to be rated in it.
///
/// # Errors
/// A photometric file or a length that is refused.
pub(crate) fn planned_room(
    arguments: &PlanArguments,
    size: DVec3,
    file: &Path,
    messages: Messages,
) -> Result<(LoadedScene, PlanningRequest), CommandError> {
    let (photometry, _) = luminaire::read(file, messages)?;
    let named =
        |name: &str| if name.trim().is_empty() { file.display().to_string() } else { name.to_owned() };
    let plan = RoomPlan {
        size,
        reflectances: arguments.reflectances(),
        luminaire: LuminaireKind {
            name: named(&photometry.names.luminaire),
            maker: photometry.names.manufacturer.clone(),
            distribution: Arc::new(photometry.distribution),
            opening: photometry.opening,
            watts: photometry.input_watts,
        },
        grid: arguments.grid.unwrap_or([1, 1]),
        height: arguments.height.unwrap_or(size.z),
        turn: arguments.turn.to_radians(),
        work_plane: arguments.work_plane,
        margin: arguments.margin,
    };
    let description = plan.description().map_err(|error| CommandError::usage(error.to_string()))?;
    Ok((LoadedScene::from_description("room", description), plan.request()))
}
