//! Arguments of `glanz view`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use glanz::viewer::server::DEFAULT_PORT;
use glanz::viewer::stream::IntegratorName;

use super::common::{ReadingArguments, RoomArgument, StudioArguments, ThreadArguments};

const VIEW_HELP: &str = "\
The page draws the surfaces themselves, not facets of them; when the camera rests, it shows the
picture that `glanz render` would make. Its address is printed on the standard output. Ctrl-C
ends the command.

Only this machine can open the page, unless --host names an address for other machines; the
printed address then contains a token that grants access. The connection is not encrypted: use
it in trusted networks only, or forward the port through ssh instead.

Files that are dropped on the page are shown on that page alone, and can refer to each other but
to no other file of this machine.

Examples:
  glanz view room.pbrt
  glanz view part.ply --up z --material brass       a model, in a studio
  glanz view room.pbrt --watch                      updated when the file is saved
  glanz view room.pbrt --light room.light           with light of glanz bake --checkpoint
  glanz view lamp.pbrt --lux lux --room 10 10 10    with the lux maps of glanz illuminate -o lux
  glanz view old.pbrt --compare new.pbrt --lux designs   two designs side by side, with the lux
                                                    maps of illuminate --compare -o designs
  glanz view room.pbrt --lux day --lux night        two calculations of one scene side by side
  glanz view room.pbrt --host 0.0.0.0 --no-open     for other machines
  ssh -L 7870:localhost:7870 far glanz view room.pbrt --no-open";

/// Arguments of `glanz view`.
#[derive(Debug, Args)]
#[command(after_help = VIEW_HELP)]
pub(crate) struct ViewArguments {
    /// Print the address without opening the browser
    #[arg(long)]
    pub(crate) no_open: bool,
    #[arg(long, value_name = "N", help = format!(
        "Port of the server; 0 selects a free one [default: {DEFAULT_PORT}, or a free one if that is taken]"
    ))]
    pub(crate) port: Option<u16>,
    /// Admit other machines at this host name or IP address; 0.0.0.0 for all addresses
    #[arg(long, value_name = "ADDR", value_hint = ValueHint::Hostname)]
    pub(crate) host: Option<String>,
    /// Read the scene again when one of its files changes
    #[arg(long)]
    pub(crate) watch: bool,
    /// Default integrator of the page
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ViewIntegrator::Path)]
    pub(crate) integrator: ViewIntegrator,
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    /// Show the light of this checkpoint of `glanz bake` on the surfaces
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "lux")]
    pub(crate) light: Option<PathBuf>,
    /// Show the lux maps that `glanz illuminate` wrote into this folder; give it twice, or the folder of a comparison, for two designs
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) lux: Vec<PathBuf>,
    /// Show this second design beside the first one
    #[arg(long, value_name = "SCENE", value_hint = ValueHint::FilePath, conflicts_with = "light")]
    pub(crate) compare: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) room: RoomArgument,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Scene file in pbrt's language (v3 or v4), or model: .step, .igs, .glb, .gltf, .obj, .stl, .ply, .rib
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    // Last: its heading would be that of all options after it.
    #[command(flatten)]
    pub(crate) studio: StudioArguments,
}

/// The integrators that a page can choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewIntegrator {
    /// Path tracing
    Path,
    /// Path tracing guided by the learnt incident light
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
