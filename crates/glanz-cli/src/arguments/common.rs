//! Options that several commands have.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};
use glanz::file::FileUses;
use glanz::formats::Options;
use glanz::job::{CancelFlag, JobPart, Resource, ResourceLimits, byte_size};
use glanz::light::{Tone, ToneCurve};
use glanz::math::DVec3;
use glanz::scene::studio::{SrgbColor, StudioMaterial, StudioSettings, StudioView, UpAxis};
use glanz_terminal::Verbosity;
use glanz_terminal::values::{positive, stops, switch};

/// The scene file of a command.
#[derive(Debug, Args)]
pub(crate) struct SceneArgument {
    /// Scene file in pbrt's language (v3 or v4), or - for the standard input
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
}

/// The scene or model of a command.
#[derive(Debug, Args)]
pub(crate) struct ModelArgument {
    /// Scene file in pbrt's language (v3 or v4), or model: .step, .igs, .glb, .gltf, .obj, .stl, .ply, .rib; - is the
    /// standard input, whose scene names files in the current folder
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) studio: StudioArguments,
}

/// The picture of a model, which has no camera and light of its own.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options of models, which have no camera and light of their own")]
pub(crate) struct StudioArguments {
    /// Direction from which the model is seen [default: that of its own camera, else iso, from the front, the right and above]
    #[arg(long, value_name = "VIEW", value_parser = view_parser())]
    view: Option<StudioView>,
    /// Upward axis of the model: y or z [default: that of its format]
    #[arg(long, value_name = "AXIS", value_parser = clap::value_parser!(UpAxis))]
    up: Option<UpAxis>,
    /// Colour of background and ground: #rrggbb or a name such as white [default: #d6d6d6]
    #[arg(long, value_name = "COLOUR", value_parser = clap::value_parser!(SrgbColor))]
    background: Option<SrgbColor>,
    /// Whether the model stands on a ground that receives its shadow [default: on]
    #[arg(long, value_name = "on|off", value_parser = switch)]
    ground: Option<bool>,
    /// Material instead of those of the model: steel, aluminium, gold, silver, copper, brass, glass, plastic:#rrggbb
    #[arg(long, value_name = "NAME", value_parser = clap::value_parser!(StudioMaterial))]
    material: Option<StudioMaterial>,
}

impl StudioArguments {
    /// The same for the engine.
    pub(crate) fn settings(&self) -> StudioSettings {
        let default = StudioSettings::default();
        StudioSettings {
            view: self.view,
            up: self.up,
            background: self.background.unwrap_or(default.background),
            ground: self.ground.unwrap_or(default.ground),
            material: self.material,
            ..default
        }
    }

    /// A warning if an option is given that has no effect on a scene.
    pub(crate) fn warning(&self) -> Option<String> {
        let given = [
            ("--view", self.view.is_some()),
            ("--up", self.up.is_some()),
            ("--background", self.background.is_some()),
            ("--ground", self.ground.is_some()),
            ("--material", self.material.is_some()),
        ];
        let names: Vec<&str> = given.into_iter().filter_map(|(name, given)| given.then_some(name)).collect();
        (!names.is_empty()).then(|| {
            format!("{}: only for models; a scene has its own camera, light and materials", names.join(", "))
        })
    }
}

/// The views by their names.
fn view_parser() -> impl TypedValueParser<Value = StudioView> {
    let by_name = |name: String| StudioView::ALL.into_iter().find(|view| view.name() == name);
    PossibleValuesParser::new(StudioView::ALL.map(StudioView::name))
        .try_map(move |name| by_name(name).ok_or("there is no such view"))
}

/// How strictly a scene is read, and what that may cost.
#[derive(Clone, Debug, Args)]
pub(crate) struct ReadingArguments {
    /// Treat every repair or substitute in the scene as an error
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    limits: LimitArguments,
}

impl ReadingArguments {
    /// Options for reading a scene, which ends when the flag is raised.
    pub(crate) fn options(&self, cancel: &CancelFlag) -> Options {
        Options { strict: self.strict, limits: self.limits(), cancel: cancel.clone(), ..Options::default() }
    }

    /// The limits.
    pub(crate) fn limits(&self) -> ResourceLimits {
        self.limits.limits()
    }
}

/// What reading may cost.
#[derive(Clone, Debug, Args)]
pub(crate) struct LimitArguments {
    /// Largest memory for what is read, such as 2G or 512M [default: three quarters of what is available]
    #[arg(long, value_name = "SIZE", value_parser = byte_size)]
    memory: Option<u64>,
    /// Limit of what reading and preparing the scene may use, such as tokens=2e9 or time=30s; names: memory, bytes, files, depth,
    /// tokens, objects, pixels, time
    #[arg(long = "limit", value_name = "NAME=VALUE", value_parser = limit)]
    limits: Vec<(Resource, String)>,
}

impl LimitArguments {
    /// Limits of these options, with the defaults of the machine for the others; `--memory` goes before `--limit memory=`.
    pub(crate) fn limits(&self) -> ResourceLimits {
        let mut limits = ResourceLimits::default();
        for (resource, value) in &self.limits {
            // The values have been tried when the command line was parsed.
            let _ = limits.set(*resource, value);
        }
        limits.memory = self.memory.unwrap_or(limits.memory);
        limits
    }
}

/// A limit: its name and its value.
fn limit(text: &str) -> Result<(Resource, String), String> {
    let names = || Resource::ALL.map(Resource::name).join(", ");
    let form = || format!("it must be a name and a value, such as tokens=2e9; the names are {}", names());
    let (name, value) = text.split_once('=').ok_or_else(form)?;
    let resource = Resource::ALL.into_iter().find(|resource| resource.name() == name).ok_or_else(form)?;
    ResourceLimits::default().set(resource, value).map_err(|error| error.to_string())?;
    Ok((resource, value.to_owned()))
}

/// The number of threads.
#[derive(Clone, Debug, Args)]
pub(crate) struct ThreadArguments {
    /// Number of threads [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

impl ThreadArguments {
    /// The number; 0 for all processors.
    pub(crate) fn count(&self) -> usize {
        self.threads.map_or(0, usize::from)
    }
}

/// The checkpoint of a job.
#[derive(Clone, Debug, Args)]
pub(crate) struct CheckpointArguments {
    /// File for the state of the job, written a second after the start, then at growing intervals of up to 30 seconds (less often if that takes more than 5 % of the time), and at the end
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Resume from the checkpoint if it exists; without this option, an existing file is an error
    #[arg(long, requires = "checkpoint")]
    pub(crate) resume: bool,
}

impl CheckpointArguments {
    /// Refuses a checkpoint that cannot be written, that exists and is not to be resumed, or that is another file of the command.
    pub(crate) fn add_to(&self, files: &mut FileUses) -> Result<(), glanz::Error> {
        self.checkpoint.as_deref().map_or(Ok(()), |path| files.add_checkpoint(path, self.resume))
    }
}

/// The part of a job that is split over several runs or machines.
#[derive(Clone, Debug, Args)]
pub(crate) struct PartArguments {
    /// Compute part K of N only, with K from 1, into the checkpoint, without -o; `glanz merge` joins the parts
    #[arg(long, value_name = "K/N", value_parser = clap::value_parser!(JobPart), requires = "checkpoint")]
    pub(crate) part: Option<JobPart>,
}

/// Options of all long-running commands.
#[derive(Clone, Debug, Args)]
pub(crate) struct JobArguments {
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    #[command(flatten)]
    pub(crate) checkpoint: CheckpointArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

/// Conversion of light to eight bits.
#[derive(Clone, Debug, Args)]
pub(crate) struct ToneArguments {
    /// Brighten PNG pictures by this many stops
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, default_value_t = 0.0, value_parser = stops)]
    pub(crate) exposure: f32,
    /// Tone curve of PNG pictures: bright light is clipped (linear) or compressed
    #[arg(long, value_name = "NAME", value_enum, default_value_t = ToneName::Linear)]
    tone: ToneName,
}

impl ToneArguments {
    /// Exposure and curve.
    pub(crate) fn tone(&self) -> Tone {
        let curve = match self.tone {
            ToneName::Linear => ToneCurve::Linear,
            ToneName::Reinhard => ToneCurve::Reinhard,
            ToneName::Filmic => ToneCurve::Filmic,
        };
        Tone { exposure_stops: self.exposure, curve }
    }
}

/// The tone curves, without help texts, which would lengthen that of the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ToneName {
    // Light up to 1 as it is, brighter light as 1.
    Linear,
    // Luminance Y as Y / (1 + Y).
    Reinhard,
    // A filmic curve.
    Filmic,
}

/// The walls of a room around the scene.
#[derive(Debug, Args)]
pub(crate) struct RoomArgument {
    /// Add the walls of a box from the origin to (X, Y, Z), metres: six receivers that absorb all light
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], value_parser = positive)]
    room: Option<Vec<f64>>,
}

impl RoomArgument {
    /// Size of the room, metres.
    pub(crate) fn size(&self) -> Option<DVec3> {
        match self.room.as_deref() {
            Some(&[x, y, z]) => Some(DVec3::new(x, y, z)),
            _ => None,
        }
    }
}
