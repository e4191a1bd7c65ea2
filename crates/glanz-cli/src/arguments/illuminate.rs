//! What `glanz illuminate` can be asked.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};
use glanz_math::DVec3;

use super::{RECEIVER_CELLS, Verbosity};
use glanz_terminal::values::{positive, seconds};

const HELP: &str = "\
Receivers are the shapes of the scene that say \"string receiver\" \"NAME\", and with --room the six
walls of a box from the origin to (X, Y, Z), which absorb what they receive. For every receiver the
folder gets NAME.csv (position, area, lux, standard error per cell), NAME.exr (the same as floats,
a pixel per cell), NAME.png (false colours) and NAME.svg (isolux lines), for all of them together
report.html, report.json and summary.txt: least, mean and largest illuminance, the uniformities U0
(least over mean) and U1 (least over largest), and where the light went.

Without --rays, --time and --error it goes on until the standard error of the brightest cell and of
the mean of every receiver is 1 per cent.

\"integrate\" looks at the image of every lamp in the mirrors, without chance: what comes straight from
lamps and by one mirror. \"trace\" sends particles and counts all light. \"both\" tells how they agree.

Examples:
  glanz illuminate office.pbrt -o office
  glanz illuminate reflector.pbrt --room 10 10 10 -o lux --method both --time 60
  glanz illuminate old.pbrt --compare new.pbrt -o designs --texel 0.1
  glanz illuminate lamp.pbrt -o lamp --far-field lamp.ldt --far-field lamp.ies";

#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct IlluminateArguments {
    /// Scene file in pbrt's language (v3 or v4)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Folder for the results; made if it is not there
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) output: PathBuf,
    /// Walls of a box from the origin, metres: six receivers that absorb all light
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], value_parser = positive)]
    room: Option<Vec<f64>>,
    /// Cells along the longer direction of receivers that say nothing themselves
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=RECEIVER_CELLS))]
    pub(crate) cells: u32,
    /// Length of their cells in metres instead
    #[arg(long, value_name = "M", conflicts_with = "cells", value_parser = positive)]
    pub(crate) texel: Option<f64>,
    /// How light is found
    #[arg(long, value_name = "NAME", value_enum, default_value_t = MethodName::Trace)]
    pub(crate) method: MethodName,
    /// Stop after so many particles
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) rays: Option<u64>,
    /// Stop after this time, seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) time: Option<Duration>,
    /// Stop at this relative standard error of the brightest cell and of the mean of every receiver
    #[arg(long, value_name = "E", value_parser = positive)]
    pub(crate) error: Option<f64>,
    /// Relative error that "integrate" aims at in every cell
    #[arg(long, value_name = "E", default_value_t = 1e-2, hide_short_help = true, value_parser = positive)]
    pub(crate) tolerance: f64,
    /// A second design, calculated alike: the first goes to DIR/a, this to DIR/b, and a comparison to DIR
    #[arg(long, value_name = "SCENE", value_hint = ValueHint::FilePath, conflicts_with = "checkpoint")]
    pub(crate) compare: Option<PathBuf>,
    /// Candela distribution of all light that leaves the scene, .ldt or .ies; -z is gamma 0 (repeat for several)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "compare")]
    pub(crate) far_field: Vec<PathBuf>,
    /// Seed of the particles; another seed gives another, independent result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Surfaces that scatter a particle at most; what it carries then is told as given up
    #[arg(long, value_name = "N", default_value_t = 1000, hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_depth: u32,
    /// Threads to use; all processors if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// File that keeps what the particles brought, written every 30 seconds and at the end
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Go on from the checkpoint if it is there; without this an existing one is not touched
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
    /// Refuse a scene that needs a stand-in or a repair
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) talk: Verbosity,
}

/// How light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    // By particles.
    Trace,
    // By integration over mirrors.
    Integrate,
    // By both, and their difference.
    Both,
}

impl IlluminateArguments {
    /// Size of the room, metres.
    pub(crate) fn room(&self) -> Option<DVec3> {
        room(self.room.as_deref())
    }
}

/// Sides of a room from its three arguments.
pub(super) fn room(sides: Option<&[f64]>) -> Option<DVec3> {
    match sides {
        Some(&[x, y, z]) => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}
