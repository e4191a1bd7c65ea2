//! The command line: what can be asked, and the help that explains it. Completions and man page come from here too.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use glanz_sampling::SamplerKind;
use glanz_sampling::exact::MAX_TERMS;
use glanz_scene::description::{GuideSettings, MAX_RECEIVER_CELLS};
use glanz_terminal::Verbosity;
use glanz_terminal::values::{bound, one_of, positive, sample_range, seconds, size, stops, switch};
use glanz_transport::{Aov, INTEGRATORS};

mod illuminate;
mod view;

pub(crate) use illuminate::{IlluminateArguments, MethodName};
pub(crate) use view::ViewArguments;

/// Exact light for exact surfaces: renders pbrt scenes without turning curved surfaces into facets.
#[derive(Debug, Parser)]
#[command(name = "glanz", version, propagate_version = true, max_term_width = 98, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  glanz demo                                   a built-in scene, into glanz-demo.png
  glanz render room.pbrt -o room.exr           a scene file, as it says itself
  glanz render room.pbrt -o room.png --time 60 the best picture of one minute
  glanz bake room.pbrt -o room.glb             the light on its surfaces, for other programs
  glanz illuminate room.pbrt -o lux            how many lux arrive where
  glanz view room.pbrt                         a page that shows it and lets you look around
  glanz compare room.exr reference.exr         how far apart two pictures are

Exit status: 0 done, 1 failed, 2 wrong usage, 130 interrupted after saving.";

/// The word for every extra channel.
pub(crate) const ALL_AOVS: &str = "all";

/// Samples per pixel that a film can hold.
const MAX_SAMPLES: i64 = MAX_TERMS as i64;

/// Cells along a side of a receiver.
const RECEIVER_CELLS: i64 = MAX_RECEIVER_CELLS as i64;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a built-in scene that shows what Glanz is for
    Demo(DemoArguments),
    /// Render a scene file to pictures
    Render(RenderArguments),
    /// Bake the light of a scene onto its surfaces: a model with light maps
    Bake(BakeArguments),
    /// Say how many lux arrive where: on receivers of a scene or the walls of a room
    Illuminate(IlluminateArguments),
    /// Join checkpoints of disjoint sample ranges into one picture
    Merge(MergeArguments),
    /// Say what is in a scene, or what light the luminaire of a photometric file gives
    Info(InfoArguments),
    /// Show a scene in the browser: surfaces exact at any zoom, then the rendered picture
    View(ViewArguments),
    /// Measure how far apart two pictures are
    Compare(CompareArguments),
    /// Name the program that the studies now have
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

const DEMO_HELP: &str = "\
Without -o the picture goes to glanz-demo.png in the current folder.

Examples:
  glanz demo
  glanz demo --size 1920x1080 --spp 1024 -o big.png -o big.exr";

#[derive(Debug, Args)]
#[command(after_help = DEMO_HELP)]
pub(crate) struct DemoArguments {
    #[command(flatten)]
    pub(crate) options: RenderOptions,
}

const RENDER_HELP: &str = "\
Without -o the picture goes to the current folder under the film's file name in the scene; as
EXR if the scene names none, or one in a format that Glanz does not write.

The picture depends on the scene, the settings and the seed alone: not on threads, not on
interruptions. Ctrl-C and SIGTERM finish the pass, write picture and checkpoint, and exit
with 130; a second Ctrl-C kills.

Examples:
  glanz render room.pbrt -o room.exr -o room.png --spp 256
  glanz render room.pbrt -o room.exr --checkpoint room.glanz --resume

  on one machine, on another, and the same bits as 256 samples at once:
  glanz render room.pbrt --samples 0..128 --checkpoint a.glanz
  glanz render room.pbrt --samples 128..256 --checkpoint b.glanz
  glanz merge a.glanz b.glanz -o room.exr

  learn once where light comes from, then render parts with that; without --guide-in the
  samples of \"guided\" build on one another, and parts cannot be merged:
  glanz render room.pbrt --integrator guided --spp 64 --guide-out room.guide
  glanz render room.pbrt --integrator guided --guide-in room.guide --samples 0..512

The guide of \"guided\" is \"tree\" unless --guide says otherwise: cells and directions that refine
themselves, and a learnt share beside the BSDF. Keys with commas make it a fixed grid, as in
document 003:
  grid=N            N x N cells on each surface, 1 to 64
  basis=NAME        functions of the densities: haar (default), spline0, spline1, spline2, spline3
  scale=J           2^J segments along each axis of the hemisphere, 0 to 6 (3)
  mixture=on|off    whether the BSDF draws half of the diffuse directions, or none (off)
  hierarchical=on|off
                    whether densities begin coarse and become finer from pass to pass (off)
  passes=N-N-...    samples per pixel of each pass that learns, such as 1-2-4, after a first sample
                    that tells the brightness; without it passes double for ever
With --samplelights on they learn indirect light alone (\"stratification\" in 003), else all light:
  glanz render room.pbrt --integrator guided --guide grid=8,basis=haar --samplelights off";

#[derive(Debug, Args)]
#[command(after_help = RENDER_HELP)]
pub(crate) struct RenderArguments {
    /// Scene file in pbrt's language (v3 or v4)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) options: RenderOptions,
}

/// How to render; what is not given is as the scene says.
#[derive(Debug, Args)]
pub(crate) struct RenderOptions {
    /// Picture to write; the extension decides: exr, png or hdr (repeat for several)
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,
    /// How light is gathered
    #[arg(long, value_name = "NAME", value_parser = one_of(INTEGRATORS.iter().map(|entry| entry.name)))]
    pub(crate) integrator: Option<String>,
    /// Samples per pixel
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..=MAX_SAMPLES))]
    pub(crate) spp: Option<u32>,
    /// Wall time of the render loop in seconds, instead of a number of samples
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) time: Option<Duration>,
    /// Size of the full picture in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// How samples are spread
    #[arg(long, value_name = "NAME", value_parser = one_of(SamplerKind::ALL.into_iter().map(SamplerKind::name)))]
    pub(crate) sampler: Option<String>,
    /// Threads to use; all processors if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Seed of the samples; another seed gives another, independent picture
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Further channels for EXR files: all, or a list with commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', ignore_case = true, value_parser = one_of(
        Aov::ALL.into_iter().map(Aov::name).chain([ALL_AOVS])
    ))]
    pub(crate) aov: Vec<String>,
    /// File that keeps the state of the render, written every 30 seconds and at the end
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Go on from the checkpoint if it is there; without this an existing one is not touched
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
    /// Only the samples from A up to, not including, B of every pixel
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with = "time")]
    pub(crate) samples: Option<Range<u32>>,
    /// What "guided" learns with: tree, or the keys of a grid, which `glanz render --help` explains
    #[arg(long, value_name = "GUIDE", value_parser = clap::value_parser!(GuideSettings))]
    pub(crate) guide: Option<GuideSettings>,
    /// Whether lights are sampled at every hit, or found by chance alone
    #[arg(long, value_name = "on|off", value_parser = switch)]
    pub(crate) samplelights: Option<bool>,
    /// Let this guide draw directions and learn nothing (integrator guided)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "guide_out")]
    pub(crate) guide_in: Option<PathBuf>,
    /// Write the guide that the last whole pass left (integrator guided)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) guide_out: Option<PathBuf>,
    /// Show the light of this checkpoint of `glanz bake` instead of baking it (integrator radiosity)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) light_in: Option<PathBuf>,
    /// Brighten PNG pictures by this many stops
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, default_value_t = 0.0, value_parser = stops)]
    pub(crate) exposure: f32,
    /// How PNG pictures show light: bright light cut, or compressed by a curve
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ToneName::Linear)]
    pub(crate) tone: ToneName,
    /// Refuse a scene that needs a stand-in or a repair
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) talk: Verbosity,
}

/// The tone curves; help on each would make that of the whole command long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ToneName {
    // Light up to 1 as it is, brighter light as 1.
    Linear,
    // Luminance Y as Y / (1 + Y).
    Reinhard,
    // A filmic curve.
    Filmic,
}

const BAKE_HELP: &str = "\
The model is binary glTF 2.0 with materials that need no light of their own: a picture on each
surface shows the light that leaves it (TEXCOORD_1), as three.js, Blender and others do without
further settings. The irradiance itself, in the scene's units of radiance, goes beside it as
OpenEXR, laid out in the same way. Sides that no light reaches are black and take no texels. The
scene's camera is in the model.

Light is that of radiosity: mirrors, glass and gloss count as if they reflected diffusely.
Ctrl-C and SIGTERM end it with 130; nothing is written then but the checkpoint, if there is one, with
which --resume goes on to the same bits. A second Ctrl-C kills. When all light is found, the
checkpoint keeps it: for further models of the same scene, and for `glanz render --light-in`.

Examples:
  glanz bake room.pbrt -o room.glb
  glanz bake room.pbrt -o room.glb --checkpoint room.light --resume
  glanz render room.pbrt --integrator radiosity --light-in room.light
  glanz bake room.pbrt -o fine.glb --texels-per-metre 100 --tone filmic";

#[derive(Debug, Args)]
#[command(after_help = BAKE_HELP)]
pub(crate) struct BakeArguments {
    /// Scene file in pbrt's language (v3 or v4)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Model to write, .glb; light maps go beside it
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Texels of the light maps per metre, where they are least dense
    #[arg(long, value_name = "N", default_value_t = 25.0, value_parser = positive)]
    pub(crate) texels_per_metre: f64,
    /// Format of the irradiance beside the model; PNG is for looking at
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = LightMapName::Exr)]
    pub(crate) lightmap: LightMapName,
    /// Distance of triangles from the surface at most, metres; 0.001, or less in a small scene
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) tolerance: Option<f64>,
    /// Brighten the pictures by this many stops
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, default_value_t = 0.0, value_parser = stops)]
    pub(crate) exposure: f32,
    /// How the pictures show light: bright light cut, or compressed by a curve
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ToneName::Linear)]
    pub(crate) tone: ToneName,
    /// Rays that gather indirect light at a place
    #[arg(long, value_name = "N", hide_short_help = true, default_value_t = 512, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pub(crate) rays: u32,
    /// Threads to use; all processors if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// File that keeps the light found so far, written every 30 seconds and at the end
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

/// Formats of light maps beside the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LightMapName {
    // Floating point.
    Exr,
    // Eight bits, as the tone curve makes them.
    Png,
}

const MERGE_HELP: &str = "\
The parts must be of the same scene with the same settings, and no sample may come twice.

Example:
  glanz merge a.glanz b.glanz -o room.exr --checkpoint whole.glanz";

#[derive(Debug, Args)]
#[command(after_help = MERGE_HELP)]
pub(crate) struct MergeArguments {
    /// Checkpoints written by `glanz render --samples A..B --checkpoint PART`
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) parts: Vec<PathBuf>,
    /// Picture to write; the extension decides: exr, png or hdr (repeat for several)
    #[arg(short, long, value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,
    /// Also write the joined checkpoint
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Brighten PNG pictures by this many stops
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, default_value_t = 0.0, value_parser = stops)]
    pub(crate) exposure: f32,
    /// How PNG pictures show light: bright light cut, or compressed by a curve
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ToneName::Linear)]
    pub(crate) tone: ToneName,
    #[command(flatten)]
    pub(crate) talk: Verbosity,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArguments {
    /// Scene file in pbrt's language (v3 or v4), or photometric file: .ies, .ldt
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Draw the candela distribution of a photometric file: polar plot, .svg
    #[arg(long, value_name = "SVG", value_hint = ValueHint::FilePath)]
    pub(crate) plot: Option<PathBuf>,
    /// Refuse a scene that needs a stand-in or a repair
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const COMPARE_HELP: &str = "\
The second picture is the reference. Measured are
  rmse          root of the mean squared difference
  relmse        mean of the squared difference over the squared reference + 0.01
  display-rmse  rmse of the values clipped to [0, 1]
  max           largest difference
  flip          mean FLIP error, from 0 to 1: how much the eye notices

Example:
  glanz compare render.exr reference.exr --metric relmse --fail-above 0.01";

#[derive(Debug, Args)]
#[command(after_help = COMPARE_HELP)]
pub(crate) struct CompareArguments {
    /// A picture: exr, png or hdr
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub(crate) picture: PathBuf,
    /// The reference: exr, png or hdr
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,
    /// Exit with 1 if the measure of --metric is larger than this, or not a number
    #[arg(long, value_name = "X", value_parser = bound)]
    pub(crate) fail_above: Option<f64>,
    /// The measure that --fail-above looks at
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Metric::Rmse)]
    pub(crate) metric: Metric,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// The measures of difference, explained below the options.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Metric {
    // Root of the mean squared difference.
    Rmse,
    // Mean squared difference relative to the squared reference.
    Relmse,
    // Root of the mean squared difference of values clipped to [0, 1].
    DisplayRmse,
    // Largest difference.
    Max,
    // Mean FLIP error.
    Flip,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn parse(line: &str) -> Result<Arguments, clap::Error> {
        Arguments::try_parse_from(line.split(' '))
    }

    #[test]
    fn definition_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn values_are_read_as_they_are_written() {
        let Ok(Arguments { command: Command::Render(render) }) = parse(
            "glanz render a.pbrt -o a.exr -o a.png --size 64x48 --samples 3..7 --aov N,Z --exposure -1.5",
        ) else {
            panic!("a valid command line is refused");
        };
        let options = render.options;
        assert_eq!(options.output, [PathBuf::from("a.exr"), PathBuf::from("a.png")]);
        assert_eq!(options.size, Some([64, 48]));
        assert_eq!(options.samples, Some(3..7));
        assert_eq!(options.aov, ["N", "Z"]);
        assert_eq!(options.exposure, -1.5);
    }

    #[test]
    fn nonsense_is_wrong_usage() {
        for line in [
            "glanz",
            "glanz paint",
            "glanz render",
            "glanz render a.pbrt --spp 0",
            "glanz render a.pbrt --spp 4 --time 2",
            "glanz render a.pbrt --time -1",
            "glanz render a.pbrt --time nan",
            "glanz render a.pbrt --time 1e40",
            "glanz render a.pbrt --size 64",
            "glanz render a.pbrt --size 0x5",
            "glanz render a.pbrt --samples 5..5",
            "glanz render a.pbrt --samples 5..x",
            "glanz render a.pbrt --resume",
            "glanz render a.pbrt --threads 0",
            "glanz render a.pbrt --exposure inf",
            "glanz render a.pbrt --guide grid=0",
            "glanz render a.pbrt --guide bush",
            "glanz render a.pbrt --samplelights yes",
            "glanz merge a.glanz",
            "glanz bake a.pbrt",
            "glanz bake a.pbrt -o a.glb --texels-per-metre 0",
            "glanz bake a.pbrt -o a.glb --tolerance -1",
            "glanz bake a.pbrt -o a.glb --lightmap jpg",
            "glanz bake a.pbrt -o a.glb --resume",
            "glanz bake a.pbrt -o a.glb --threads 0",
            "glanz compare a.exr b.exr --fail-above -1",
            "glanz compare a.exr b.exr --metric beauty",
            "glanz view",
            "glanz view a.pbrt --port 65536",
            "glanz view a.pbrt --integrator whitted",
            "glanz view a.pbrt --threads 0",
        ] {
            assert_eq!(parse(line).map(|_| ()).map_err(|e| e.exit_code()), Err(2), "{line}");
        }
    }
}
