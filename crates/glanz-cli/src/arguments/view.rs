//! The arguments of `glanz view`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use glanz_math::DVec3;
use glanz_viewer::server::DEFAULT_PORT;
use glanz_viewer::stream::IntegratorName;

use super::illuminate::room;
use glanz_terminal::values::positive;

const VIEW_HELP: &str = "\
The page draws the surfaces themselves, not facets of them, and when the camera rests the picture
that `glanz render` would make comes in. Its address is printed on the standard output. Ctrl-C
ends it.

Only this machine reaches the page, unless --host gives the name or number under which others
do: then the address carries a token, which admits whoever has it. What is sent is not encrypted:
use it in networks that you trust, or forward the port through ssh instead.

Files that are dropped on the page are shown on that page alone, and may read each other but no
other file of this machine.

Examples:
  glanz view room.pbrt
  glanz view room.pbrt --watch                      shows every change of the file when it is saved
  glanz view room.pbrt --light room.light           what glanz bake --checkpoint room.light found
  glanz view lamp.pbrt --lux lux --room 10 10 10    what glanz illuminate -o lux found
  glanz view room.pbrt --host 0.0.0.0 --no-open     for other machines
  ssh -L 7870:localhost:7870 far glanz view room.pbrt --no-open";

/// What `glanz view` is to show, and to whom.
#[derive(Debug, Args)]
#[command(after_help = VIEW_HELP)]
pub(crate) struct ViewArguments {
    /// Scene file in pbrt's language (v3 or v4)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Print the address without opening the browser
    #[arg(long)]
    pub(crate) no_open: bool,
    #[arg(long, value_name = "N", help = format!(
        "Port to serve from; 0 takes any that is free [default: {DEFAULT_PORT}, or any if that is taken]"
    ))]
    pub(crate) port: Option<u16>,
    /// Let other machines in, by this name or number of this machine; 0.0.0.0 for all its numbers
    #[arg(long, value_name = "ADDR", value_hint = ValueHint::Hostname)]
    pub(crate) host: Option<String>,
    /// Read the scene again when one of its files changes
    #[arg(long)]
    pub(crate) watch: bool,
    /// What renders unless the page chooses
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ViewIntegrator::Path)]
    pub(crate) integrator: ViewIntegrator,
    /// Threads of a render; all processors if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Show the light of this checkpoint of `glanz bake` on the surfaces
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "lux")]
    pub(crate) light: Option<PathBuf>,
    /// Show the lux maps that `glanz illuminate` wrote into this folder
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) lux: Option<PathBuf>,
    /// Add the walls of a box from the origin, metres, as `glanz illuminate` does
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], value_parser = positive)]
    room: Option<Vec<f64>>,
    /// Refuse a scene that needs a stand-in or a repair
    #[arg(long)]
    pub(crate) strict: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

impl ViewArguments {
    /// Size of the room, metres.
    pub(crate) fn room(&self) -> Option<DVec3> {
        room(self.room.as_deref())
    }
}

/// The integrators that a page can choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewIntegrator {
    /// Path tracing
    Path,
    /// Path tracing that learns where light comes from
    Guided,
}

impl From<ViewIntegrator> for IntegratorName {
    fn from(name: ViewIntegrator) -> Self {
        match name {
            ViewIntegrator::Path => Self::Path,
            ViewIntegrator::Guided => Self::Guided,
        }
    }
}
