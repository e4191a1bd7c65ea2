//! The command line: commands, options and their help, also for completions and manual pages.

use clap::{Parser, Subcommand};

mod bake;
mod common;
mod compare;
mod convert;
mod illuminate;
mod info;
mod merge;
mod optimize;
mod plan;
mod render;
mod road;
#[cfg(test)]
mod tests;
mod view;

pub(crate) use bake::BakeArguments;
pub(crate) use common::{JobArguments, ModelArgument, ReadingArguments};
pub(crate) use compare::{CompareArguments, Metric};
pub(crate) use convert::ConvertArguments;
pub(crate) use illuminate::IlluminateArguments;
pub(crate) use info::InfoArguments;
pub(crate) use merge::MergeArguments;
pub(crate) use optimize::OptimizeArguments;
pub(crate) use plan::PlanArguments;
pub(crate) use render::{DemoArguments, RenderArguments, RenderCommandArguments};
pub(crate) use road::RoadArguments;
pub(crate) use view::ViewArguments;

/// Exact light for exact surfaces: renders pbrt scenes without tessellating curved surfaces.
#[derive(Debug, Parser)]
#[command(name = "glanz", version, propagate_version = true, max_term_width = 98, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  glanz demo                                   a built-in scene, into glanz-demo.png
  glanz render room.pbrt -o room.exr           a scene file with its own settings
  glanz render room.pbrt -o room.png --time 60 as many samples as fit into a minute
  glanz render part.ply -o part.png            a model, with camera, ground and light of a studio
  glanz bake room.pbrt -o room.glb             the light on its surfaces, for other programs
  glanz illuminate room.pbrt -o lux            illuminance on its receivers
  glanz optimize mirror.pbrt -o better.pbrt    a mirror bent until its light is as wanted
  glanz view room.pbrt                         an interactive view in the browser
  glanz convert part.step part.glb             triangles without gaps, to a tolerance
  glanz compare room.exr reference.exr         differences between two pictures

Exit status: 0 done, 1 failed, 2 wrong usage; 130, 143 or 129 interrupted after saving, by
Ctrl-C, SIGTERM or SIGHUP; 141 if nobody reads the standard output any longer.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a built-in scene that demonstrates Glanz
    Demo(DemoArguments),
    /// Render a scene file to pictures
    Render(RenderCommandArguments),
    /// Bake the light of a scene onto its surfaces: a model with light maps
    Bake(BakeArguments),
    /// Calculate illuminance in lux: on receivers of a scene or the walls of a room
    Illuminate(IlluminateArguments),
    /// Rate the lighting of a road: luminance, glare, illuminance
    Road(RoadArguments),
    /// Bend mirrors and move lamps until the light is as wanted: inverse design
    Optimize(OptimizeArguments),
    /// Join parts that were computed separately: into a picture, or one checkpoint
    Merge(MergeArguments),
    /// Summarise a scene, or the luminaire of a photometric file
    Info(InfoArguments),
    /// View a scene in the browser: exact surfaces at any zoom, then the rendered picture
    View(ViewArguments),
    /// Convert a model to a scene file, or a scene or a model to triangles: .glb, .obj, .ply
    Convert(ConvertArguments),
    /// Measure the differences between two pictures
    Compare(CompareArguments),
    /// Name the program that runs the studies
    #[command(hide = true)]
    Study {
        /// Arguments of a study
        #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Print a completion script for a shell
    #[command(hide = true)]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page of the program or of one of its commands
    #[command(hide = true)]
    Man {
        /// The command
        command: Option<String>,
    },
}
