//! Arguments of `glanz illuminate`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};
use glanz::illumination::{AngleStep, FarFieldResolution, GridResolution, TraceGoal};
use glanz::scene::description::MAX_RECEIVER_CELLS;
use glanz::{IlluminateMethod, IlluminateOptions};
use glanz_terminal::values::{positive, seconds};

use super::common::{JobArguments, PartArguments, RoomArgument};
use super::plan::PlanArguments;

/// Cells along a side of a receiver.
const RECEIVER_CELLS: i64 = MAX_RECEIVER_CELLS as i64;

const HELP: &str = "\
Receivers are the shapes of the scene with \"string receiver\" \"NAME\", and with --room the six
walls of a box from the origin to (X, Y, Z), which absorb all light. The command writes for
every receiver NAME.csv (position, area, lux, standard error per cell), NAME.exr (the same as
floats, one pixel per cell), NAME.png (false colours) and NAME.svg (isolux lines), and for all
receivers report.html, report.json and summary.txt: smallest, mean and largest illuminance, the
uniformities U0 (smallest over mean) and U1 (smallest over largest), and the flux balance.
report.html begins with what a client gets, on sheets of A4 when a browser prints it: summary,
luminaires, plan, requirements, assumptions, isolux lines and values of each area, other surfaces.
The reports state the version of Glanz, the scene and its content hash, the settings, times,
rates, the processor and the date: in report.json and with --json as numbers, texts and flags
under keys that end with their unit. If the variable SOURCE_DATE_EPOCH is set (seconds since
1970), it is the date, and times, rates and the machine are left out: equal calculations have
equal reports.

Without --rays, --time and --error, tracing ends when the standard error of the brightest cell,
of the darkest cell and of the mean of every receiver is 1 per cent; that of the darkest cell is
relative to a tenth of the mean at least, since a cell in full shadow would never be known.
Without a receiver, the peak of --far-field counts.

\"auto\" integrates direct light and light after one reflection in a mirror, without noise,
follows paths from the cells for the light between other surfaces, and particles from the lights
for the rest: what mirrors and glass focus, and what lamps send to surfaces close to them. It
includes all light, usually in a small part of the time of \"trace\", which traces particles
only. With --rays, --part, --far-field or the checkpoint of \"trace\" it is \"trace\".
\"integrate\" integrates and leaves out the rest. \"both\" is \"integrate\" and \"trace\", compared.

Photometric files are interpolated linearly between their angles. --far-field counts the light
for this: a file has the flux that left the scene, and its angles are dense where the intensity
bends with direction, for which 262 144 particles are traced first, beside those of --rays.
report.html and summary.txt have its peak, beam angle (half of the peak), field angle (a tenth) and errors.
--ray-file writes every ray of this light from the last surface that it left, for the near field: as
the file of a photometric light, or for other programs. It comes after all other results, which an
error of it does not cost. Interrupted, and if no light leaves the scene, it keeps its old content.

With --luminaire there is no scene: the box of --room then has diffuse walls of --reflectances, luminaires
of the file on a grid, and a work plane. The report has, besides, the unified glare rating of
observers who sit on a grid and look along both axes, cylindrical illuminance and modelling,
power per area, maintained illuminances, and with --task a verdict on each requirement, whose
interval decides: met, not met, undecided (docs/lighting.md). Zones and observers that a scene
declares are rated in the same way (docs/scene-format.md).

Examples:
  glanz illuminate office.pbrt -o office
  glanz illuminate --room 6 4 3 --luminaire panel.ldt --grid 3x2 --task 34.2 --maintenance 0.8 -o room
  glanz illuminate reflector.pbrt --room 10 10 10 -o lux --method both --time 60
  glanz illuminate old.pbrt --compare new.pbrt -o designs --texel 0.1
  glanz illuminate office.pbrt -o daylight --daylight
  glanz illuminate lamp.pbrt -o lamp --far-field lamp.ldt --far-field lamp.ies
  glanz illuminate lamp.pbrt -o lamp --far-field lamp.ldt --resolution 2.5x15
  glanz illuminate lamp.pbrt -o lamp --ray-file lamp.tm25ray --rays 5000000

  A third of the particles on each of three machines, with the bits of all particles on one:
  glanz illuminate office.pbrt --rays 900000000 --part 1/3 --checkpoint 1.lux
  glanz merge 1.lux 2.lux 3.lux --checkpoint whole.lux
  glanz illuminate office.pbrt -o office --rays 900000000 --checkpoint whole.lux --resume";

#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct IlluminateArguments {
    /// Scene file in pbrt's language (v3 or v4), or - for the standard input
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required_unless_present = "luminaire")]
    pub(crate) scene: Option<PathBuf>,
    /// Folder for the results; created if necessary
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath, required_unless_present = "part")]
    pub(crate) output: Option<PathBuf>,
    /// Title of the reports, such as the name of the project [default: the name of the scene]
    #[arg(long, value_name = "TEXT", requires = "output", conflicts_with = "compare")]
    pub(crate) title: Option<String>,
    #[command(flatten)]
    pub(crate) room: RoomArgument,
    /// Number of cells along the longer side of receivers without a resolution of their own
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=RECEIVER_CELLS))]
    cells: u32,
    /// Length of the cells of these receivers in metres, instead of --cells
    #[arg(long, value_name = "M", conflicts_with = "cells", value_parser = positive)]
    texel: Option<f64>,
    /// Method of computing the light
    #[arg(long, value_name = "NAME", value_enum, default_value_t = IlluminateMethodName::Auto)]
    method: IlluminateMethodName,
    /// Stop after this many particles
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    rays: Option<u64>,
    /// Stop after this time, seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, conflicts_with = "part")]
    time: Option<Duration>,
    /// Stop at this relative standard error of the brightest and darkest cell and of the mean of every receiver
    #[arg(long, value_name = "E", value_parser = positive, conflicts_with = "part")]
    error: Option<f64>,
    /// Relative error of the integration in every cell; with "auto" and a goal for the error, half of that
    #[arg(long, value_name = "E", default_value_t = 1e-2, hide_short_help = true, value_parser = positive)]
    tolerance: f64,
    /// Replace all light of the scene by an overcast sky (z is up), and report daylight factors, which no requirements judge
    #[arg(long, conflicts_with_all = ["luminaire", "task", "maintenance"])]
    daylight: bool,
    /// Second design for a comparison: the first is written to DIR/a, this one to DIR/b, the comparison to DIR
    #[arg(long, value_name = "SCENE", value_hint = ValueHint::FilePath, conflicts_with_all = ["checkpoint", "part"])]
    pub(crate) compare: Option<PathBuf>,
    /// Candela distribution of all light that leaves the scene, .ldt or .ies; -z is gamma 0 (repeat for several); every --part of the
    /// calculation needs this option and --resolution, too, and writes no file without -o
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "compare")]
    pub(crate) far_field: Vec<PathBuf>,
    /// Steps of gamma and of C of --far-field, such as 2.5x15, or one number for both, degrees [default: small steps where the intensity
    /// bends]
    #[arg(long, value_name = "GAMMAxC", value_parser = steps, requires = "far_field")]
    resolution: Option<FarFieldResolution>,
    /// Rays of all light that leaves the scene, .tm25ray (IES TM-25), of the particles of --rays, which are traced once more for it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, requires = "rays", conflicts_with_all = ["compare", "part", "time", "error"])]
    pub(crate) ray_file: Option<PathBuf>,
    /// Seed of the particles; another seed gives another, independent result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Largest number of scattering events of a particle; its remaining flux is reported as given up
    #[arg(long, value_name = "N", default_value_t = 1000, hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..))]
    max_depth: u32,
    #[command(flatten)]
    pub(crate) part: PartArguments,
    #[command(flatten)]
    pub(crate) job: JobArguments,
    // Last: its heading would be that of all options after it.
    #[command(flatten)]
    pub(crate) plan: PlanArguments,
}

impl IlluminateArguments {
    /// The same for the engine.
    pub(crate) fn options(&self) -> IlluminateOptions {
        IlluminateOptions {
            // A planned room is a scene of its own.
            room: self.room.size().filter(|_| self.plan.luminaire.is_none()),
            resolution: self.texel.map_or(GridResolution::Longer(self.cells), GridResolution::Texel),
            method: self.method.into(),
            goal: TraceGoal { particles: self.rays, time: self.time, error: self.error },
            part: self.part.part,
            tolerance: self.tolerance,
            daylight: self.daylight,
            far_field: (!self.far_field.is_empty()).then(|| self.resolution.unwrap_or_default()),
            seed: self.seed,
            max_depth: self.max_depth,
        }
    }
}

/// Steps of gamma and of C, degrees.
fn steps(text: &str) -> Result<FarFieldResolution, String> {
    let (gamma, plane) = text.split_once(['x', 'X']).unwrap_or((text, text));
    let step = |text: &str| {
        let degrees = text
            .parse()
            .map_err(|_| "it must be one or two numbers of degrees, such as 2.5x15".to_owned())?;
        AngleStep::try_new(degrees).map_err(|error| error.to_string())
    };
    Ok(FarFieldResolution::Steps { gamma: step(gamma)?, plane: step(plane)? })
}

/// Methods of computing the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum IlluminateMethodName {
    // Each part of the light by the best of the methods.
    Auto,
    // By particles.
    Trace,
    // By integration over mirrors.
    Integrate,
    // By both, and their difference.
    Both,
}

impl From<IlluminateMethodName> for IlluminateMethod {
    fn from(name: IlluminateMethodName) -> Self {
        match name {
            IlluminateMethodName::Auto => Self::Auto,
            IlluminateMethodName::Trace => Self::Trace,
            IlluminateMethodName::Integrate => Self::Integrate,
            IlluminateMethodName::Both => Self::Both,
        }
    }
}
