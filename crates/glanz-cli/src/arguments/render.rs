//! Arguments of `glanz render` and `glanz demo`.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};
use glanz::sampling::SamplerKind;
use glanz::sampling::exact::MAX_TERMS;
use glanz::scene::description::GuideSettings;
use glanz::scene::studio::SectionPlane;
use glanz::transport::{Aov, AovSet, BRANCHING_LIMIT, INTEGRATORS};
use glanz::{EdgeLines, MAX_LINE_WIDTH, RenderOptions};
use glanz_terminal::values::{one_of, positive, sample_range, seconds, size, switch};

use super::common::{JobArguments, ModelArgument, PartArguments, ToneArguments};

/// The word for every extra channel.
const ALL_AOVS: &str = "all";

/// Samples per pixel that a film can hold.
const MAX_SAMPLES: i64 = MAX_TERMS as i64;

/// Most pictures of a turn: ten of each degree.
const MAX_FRAMES: i64 = 3600;

const DEMO_HELP: &str = "\
Without -o the picture is written to glanz-demo.png in the current folder.

Examples:
  glanz demo
  glanz demo --size 1920x1080 --spp 1024 -o big.png -o big.exr";

#[derive(Debug, Args)]
#[command(after_help = DEMO_HELP)]
pub(crate) struct DemoArguments {
    #[command(flatten)]
    pub(crate) render: RenderArguments,
}

const RENDER_HELP: &str = "\
Without -o the picture is written to the current folder under the film's file name in the scene,
as EXR if the scene has none or names a format that Glanz does not write.

The picture depends on the scene, the settings and the seed alone, not on the number of threads
or on interruptions. Ctrl-C, SIGTERM and SIGHUP complete the current pass, write picture and
checkpoint, and exit with status 130, 143 and 129; a second one ends the program at once.

The film may take half of what the scene leaves of --memory; a larger one is in a temporary file.

Examples:
  glanz render room.pbrt -o room.exr -o room.png --spp 256
  glanz render room.pbrt -o room.exr --checkpoint room.glanz --resume
  glanz render part.ply -o part.png --view front --material steel
  glanz render part.ply -o turn.png --turntable 36
  glanz render part.step -o part.png --edges
  generate | glanz render - -o png:- | display png:-

  Half of the samples on each of two machines, with the bits of all samples on one:
  glanz render room.pbrt --part 1/2 --checkpoint a.glanz
  glanz render room.pbrt --part 2/2 --checkpoint b.glanz
  glanz merge a.glanz b.glanz -o room.exr

  More samples for a picture of 256, later; --part divides such a range, too:
  glanz render room.pbrt --samples 256..512 --checkpoint c.glanz
  glanz merge a.glanz b.glanz c.glanz -o room.exr

  Learn a guide once, then render parts with it; without --guide-in the passes of \"guided\"
  depend on one another, and parts cannot be merged:
  glanz render room.pbrt --integrator guided --spp 64 --guide-out room.guide
  glanz render room.pbrt --integrator guided --guide-in room.guide --part 1/4 --checkpoint a.glanz

The default guide of \"guided\" is \"tree\": adaptively refined cells and directions, combined with
the BSDF by learnt weights. Comma-separated keys select a fixed grid, as in document 003:
  grid=N            N x N cells on each surface, 1 to 64
  basis=NAME        functions of the densities: haar (default), spline0, spline1, spline2, spline3
  scale=J           2^J segments along each axis of the hemisphere, 0 to 6 (3)
  mixture=on|off    whether the BSDF samples half of the diffuse directions, or none (off)
  hierarchical=on|off
                    whether densities start coarse and are refined from pass to pass (off)
  passes=N-N-...    samples per pixel of each learning pass, such as 1-2-4, after a first sample
                    that measures the brightness; by default every pass is twice as long as the last
With --samplelights on, grids learn indirect light alone (\"stratification\" in 003):
  glanz render room.pbrt --integrator guided --guide grid=8,basis=haar --samplelights off";

#[derive(Debug, Args)]
#[command(after_help = RENDER_HELP)]
pub(crate) struct RenderCommandArguments {
    #[command(flatten)]
    pub(crate) render: RenderArguments,
    #[command(flatten)]
    pub(crate) model: ModelArgument,
    /// Cut the model open by a plane: x=M, y=M or z=M, metres or per cent of its size (x=50%), without the part that
    /// faces the viewer; or NX,NY,NZ,D, without the points p with (NX, NY, NZ) . p > D. The model must be closed
    #[arg(long, value_name = "PLANE", value_parser = clap::value_parser!(SectionPlane), allow_negative_numbers = true)]
    pub(crate) section: Option<SectionPlane>,
    /// Write N pictures of a turn around the upward axis: NAME-1.png, NAME-2.png and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=MAX_FRAMES),
          conflicts_with_all = ["part", "checkpoint", "guide_out", "json"])]
    pub(crate) turntable: Option<u32>,
}

/// Options of a render; the defaults are those of the scene.
#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArguments {
    /// Picture to write; the extension selects the format: exr, png, hdr or pfm (repeat for several); png:- is the standard output
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,
    /// Algorithm that computes the light
    #[arg(long, value_name = "NAME", value_parser = one_of(INTEGRATORS.iter().map(|entry| entry.name)))]
    integrator: Option<String>,
    /// Samples per pixel
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..=MAX_SAMPLES))]
    spp: Option<u32>,
    /// Wall time of the render loop in seconds, instead of a number of samples
    #[arg(long, value_name = "SECONDS", value_parser = seconds, conflicts_with = "part")]
    time: Option<Duration>,
    /// Take samples until this standard error of a pixel, relative to the brightness around it (0.02: 2 %); some parts of the picture take more than
    /// others. --spp is then a limit; noise is first checked after 32 samples; EXR files get the channels of the variance [not for light, nor for guided without --guide-in]
    #[arg(long, value_name = "LEVEL", value_parser = positive, conflicts_with_all = ["samples", "part"])]
    pub(crate) noise: Option<f64>,
    /// Size of the full picture in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Distribution of the samples
    #[arg(long, value_name = "NAME", value_parser = one_of(SamplerKind::ALL.into_iter().map(SamplerKind::name)))]
    sampler: Option<String>,
    /// Seed of the samples; another seed gives another, independent picture
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Further channels for EXR files: all, or a comma-separated list
    #[arg(long, value_name = "LIST", value_delimiter = ',', ignore_case = true, value_parser = one_of(
        Aov::ALL.into_iter().map(Aov::name).chain([ALL_AOVS])
    ))]
    pub(crate) aov: Vec<String>,
    /// Draw the edges of CAD models over the picture, with lines of this many pixels, up to 64 [default: 1.5 where the shorter side has 720]
    #[arg(long, value_name = "WIDTH", num_args = 0..=1, require_equals = true, value_parser = line_width)]
    edges: Option<Option<f64>>,
    /// Remove the noise of the finished picture by Open Image Denoise 2, which is loaded from the folder OIDN_DIR or where the system keeps
    /// libraries; checkpoints keep the noise, EXR files get the channels of albedo and shading normals
    #[arg(long)]
    denoise: bool,
    /// Render only the samples of every pixel from A up to, but not including, B
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with = "time")]
    pub(crate) samples: Option<Range<u32>>,
    #[command(flatten)]
    pub(crate) part: PartArguments,
    /// Guide of "guided": tree, or the keys of a grid, explained in `glanz render --help`
    #[arg(long, value_name = "GUIDE", value_parser = clap::value_parser!(GuideSettings))]
    pub(crate) guide: Option<GuideSettings>,
    /// Whether lights are sampled at every hit; otherwise paths find them by chance
    #[arg(long, value_name = "on|off", value_parser = switch)]
    samplelights: Option<bool>,
    /// Carry light at four random wavelengths per path instead of red, green and blue: glass disperses it, spectra keep their shape
    #[arg(long)]
    spectral: bool,
    /// Number of paths into which a camera ray divides at its first rough surface (integrators path, default 1, and distributed, default 8)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(BRANCHING_LIMIT)))]
    pub(crate) branching: Option<u32>,
    /// Sample directions from this guide, without learning (integrator guided)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "guide_out")]
    pub(crate) guide_in: Option<PathBuf>,
    /// Write the guide learnt in the last complete pass (integrator guided)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) guide_out: Option<PathBuf>,
    /// Use the light of this checkpoint of `glanz bake` instead of baking (integrator radiosity)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) light_in: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) job: JobArguments,
}

impl RenderArguments {
    /// The same for the engine.
    pub(crate) fn options(&self) -> RenderOptions {
        RenderOptions {
            integrator: self.integrator.clone(),
            film_memory: None,
            size: self.size,
            // The parser admits only known names.
            sampler: self.sampler.as_deref().and_then(SamplerKind::from_name),
            seed: self.seed,
            samples: self.spp,
            noise: self.noise,
            sample_range: self.samples.clone(),
            part: self.part.part,
            time_limit: self.time,
            light_sampling: self.samplelights,
            spectral: self.spectral,
            branching: self.branching,
            guide: self.guide,
            guide_input: self.guide_in.clone(),
            guide_output: self.guide_out.clone(),
            light_input: self.light_in.clone(),
            aovs: self.aovs(),
            edges: self.edges.map(|width| EdgeLines { width }),
            denoise: self.denoise,
        }
    }

    /// Whether the scene must be read with its edges.
    pub(crate) fn draws_edges(&self) -> bool {
        self.edges.is_some()
    }

    fn aovs(&self) -> AovSet {
        if self.aov.iter().any(|name| name.eq_ignore_ascii_case(ALL_AOVS)) {
            return AovSet::ALL;
        }
        self.aov.iter().filter_map(|name| Aov::from_name(name)).collect()
    }
}

/// A width of lines, pixels.
fn line_width(text: &str) -> Result<f64, String> {
    let width = positive(text)?;
    if width <= MAX_LINE_WIDTH { Ok(width) } else { Err(format!("it must be at most {MAX_LINE_WIDTH}")) }
}
