//! Arguments of a planned room.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use glanz::illumination::planning::glare::SEATED_EYE;
use glanz::illumination::planning::{LightingTask, MaintenanceFactor, OFFICE_TASKS, PlanningSettings};
use glanz_terminal::values::positive;

/// A room with luminaires from a photometric file, instead of a scene.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "Options of planned rooms: from --luminaire instead of a scene, or with zones and observers in the scene"
)]
pub(crate) struct PlanArguments {
    /// Photometric file of the luminaires, .ldt or .ies: a room of the size of --room with diffuse walls, luminaires on a grid and a work plane
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, requires_all = ["room", "grid"], conflicts_with_all = ["scene", "compare", "far_field", "part", "cells", "texel"])]
    pub(crate) luminaire: Option<PathBuf>,
    /// Numbers of luminaires along x and y, half a spacing from the walls
    #[arg(long, value_name = "NxM", value_parser = grid, requires = "luminaire")]
    pub(crate) grid: Option<[u32; 2]>,
    /// Height of their photometric centres above the floor, metres [default: that of the room]
    #[arg(long, value_name = "H", value_parser = positive, requires = "luminaire")]
    pub(crate) height: Option<f64>,
    /// Turn of the luminaires about the vertical from x towards y, degrees: at 0 their C0 points along x
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite, requires = "luminaire")]
    pub(crate) turn: f64,
    /// Reflectances of ceiling, walls and floor, from 0 to below 1 [default: 0.7 0.5 0.2]
    #[arg(long, num_args = 3, value_names = ["C", "W", "F"], requires = "luminaire")]
    reflectances: Option<Vec<f64>>,
    /// Height of the work plane above the floor, metres
    #[arg(long, value_name = "H", default_value_t = 0.75, value_parser = positive, requires = "luminaire")]
    pub(crate) work_plane: f64,
    /// Height of eyes and of cylinders above the floor, metres: 1.2 seated, 1.6 standing
    #[arg(long, value_name = "H", default_value_t = SEATED_EYE, value_parser = positive, requires = "luminaire")]
    pub(crate) eye: f64,
    /// Band along the walls that is no part of the work plane, metres
    #[arg(long, value_name = "M", default_value_t = 0.5, hide_short_help = true, value_parser = finite, requires = "luminaire")]
    pub(crate) margin: f64,
    /// Number of directions from which light is gathered at each eye and cylinder; their errors fall with its square root
    #[arg(long, value_name = "N", default_value_t = PlanningSettings::default().directions, hide_short_help = true, value_parser = clap::value_parser!(u32).range(16..=1 << 20))]
    directions: u32,
    /// Task whose requirements are judged, a row of EN 12464-1:2021: 34.1 to 34.5.1 (offices)
    #[arg(long, value_name = "ROW", value_parser = task)]
    task: Option<LightingTask>,
    /// The luminaires are emergency lighting, too: judge the floor as an open area, and disability glare, after EN 1838
    #[arg(long, requires = "luminaire")]
    pub(crate) emergency: bool,
    /// Maintenance factor, or its parts LLMFxLSFxLMFxRSMF, such as 0.9x1x0.95x0.94
    #[arg(long, value_name = "MF", value_parser = maintenance)]
    maintenance: Option<MaintenanceFactor>,
}

impl PlanArguments {
    /// Reflectances of ceiling, walls and floor.
    pub(crate) fn reflectances(&self) -> [f64; 3] {
        match self.reflectances.as_deref() {
            Some(&[ceiling, walls, floor]) => [ceiling, walls, floor],
            _ => [0.7, 0.5, 0.2],
        }
    }

    /// Settings of the rating.
    pub(crate) fn settings(&self, seed: u64) -> PlanningSettings {
        let maintenance = self.maintenance.unwrap_or_default();
        PlanningSettings { task: self.task, maintenance, directions: self.directions, seed }
    }
}

/// Two numbers of luminaires.
fn grid(text: &str) -> Result<[u32; 2], String> {
    let counts: Option<Vec<u32>> = text.split(['x', 'X']).map(|count| count.parse().ok()).collect();
    match counts.as_deref() {
        Some(&[nx, ny]) if nx > 0 && ny > 0 => Ok([nx, ny]),
        _ => Err("it must be two numbers of luminaires from 1, such as 4x3".to_owned()),
    }
}

/// A number that is finite.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number.filter(|number| number.is_finite()).ok_or_else(|| "it must be a finite number".to_owned())
}

fn task(text: &str) -> Result<LightingTask, String> {
    LightingTask::of_reference(text).ok_or_else(|| {
        let known = OFFICE_TASKS.map(|task| format!("{} ({})", task.reference, task.name));
        format!("it must be one of {}", known.join(", "))
    })
}

pub(crate) fn maintenance(text: &str) -> Result<MaintenanceFactor, String> {
    let parts: Option<Vec<f64>> = text.split(['x', 'X']).map(|part| part.parse().ok()).collect();
    let factor = match parts.as_deref() {
        Some(&[lamp_lumens, lamp_survival, luminaire, room_surfaces]) => {
            MaintenanceFactor::Parts { lamp_lumens, lamp_survival, luminaire, room_surfaces }
        }
        Some(&[whole]) => MaintenanceFactor::Whole(whole),
        _ => return Err("it must be one factor or four, such as 0.8 or 0.9x1x0.95x0.94".to_owned()),
    };
    factor.value().map_err(|error| error.to_string())?;
    Ok(factor)
}
