//! Arguments of `glanz bake`.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};
use glanz::ModelSettings;
use glanz::formats::image::Format;
use glanz::radiosity::bake::BakeMethod;
use glanz::radiosity::reconstruct::Interpolation;
use glanz_terminal::values::positive;

use super::common::{JobArguments, PartArguments, SceneArgument, ToneArguments};

const BAKE_HELP: &str = "\
The model is binary glTF 2.0 with unlit materials: a picture on each surface shows the light
that leaves it (TEXCOORD_1); three.js, Blender and others display it without further settings.
The irradiance itself, in the scene's units of radiance, is written beside it as OpenEXR in the
same layout. Sides that no light reaches are black and take no texels. The model has the scene's
camera.

The light is computed by radiosity: mirrors, glass and glossy materials are treated as diffuse.
With --method radiosity, light passes clear glass; direct light comes from all lights by fewer
shadow rays, and light between surfaces is interpolated from elements as large as the solver
allows.

Ctrl-C, SIGTERM and SIGHUP end the command with exit status 130, 143 and 129 and write only the
checkpoint, if one is named; --resume continues from it to the same bits. A second one ends the
program at once. The finished checkpoint holds all light, for further models of the same scene and
for `glanz render --light-in`.

Examples:
  glanz bake room.pbrt -o room.glb
  glanz bake room.pbrt -o room.glb --checkpoint room.light --resume
  glanz render room.pbrt --integrator radiosity --light-in room.light
  glanz bake room.pbrt -o preview.glb --method radiosity
  glanz bake room.pbrt -o fine.glb --texels-per-metre 100 --tone filmic

  Half of the light on each of two machines, with the bits of one:
  glanz bake room.pbrt --part 1/2 --checkpoint 1.light
  glanz bake room.pbrt --part 2/2 --checkpoint 2.light
  glanz merge 1.light 2.light --checkpoint whole.light
  glanz bake room.pbrt -o room.glb --checkpoint whole.light --resume

  Each of these parts computes all direct light by itself. With many parts or many texels, divide
  the direct light first:
  glanz bake room.pbrt --part 1/2 --direct-only --checkpoint d1.light
  glanz merge d1.light d2.light --checkpoint direct.light
  glanz bake room.pbrt --part 1/2 --light-in direct.light --checkpoint 1.light";

#[derive(Debug, Args)]
#[command(after_help = BAKE_HELP)]
pub(crate) struct BakeArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArgument,
    /// Model to write, .glb; light maps are written beside it
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, required_unless_present = "part", conflicts_with = "part")]
    pub(crate) output: Option<PathBuf>,
    /// Smallest density of the light maps, texels per metre
    #[arg(long, value_name = "N", default_value_t = 50.0, value_parser = positive)]
    pub(crate) texels_per_metre: f64,
    /// Format of the irradiance beside the model; PNG is only for viewing
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = LightMapName::Exr)]
    lightmap: LightMapName,
    /// Largest distance of triangles from the surface, metres [default: 0.001, or less in a small scene]
    #[arg(long, value_name = "M", value_parser = positive)]
    tolerance: Option<f64>,
    /// Computation of light between surfaces: by a final gather, or for a preview in a tenth of the time
    /// by radiosity of elements
    #[arg(long, value_name = "METHOD", value_enum, default_value_t = BakeMethodName::Gather)]
    method: BakeMethodName,
    /// Interpolation of --method radiosity from elements to texels [default: natural, by natural
    /// neighbours]
    #[arg(long, value_name = "NAME", value_parser = interpolation_parser())]
    reconstruct: Option<Interpolation>,
    /// Number of rays that gather indirect light at a point; --method radiosity has 128 rays per element
    /// instead
    #[arg(long, value_name = "N", hide_short_help = true, default_value_t = 512, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pub(crate) rays: u32,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) part: PartArguments,
    /// End the part with the direct light; the joined parts are the --light-in of parts with all light
    #[arg(long, requires = "part", conflicts_with = "light_in")]
    pub(crate) direct_only: bool,
    /// Begin the part with the direct light of joined parts, from `glanz merge`
    #[arg(long, value_name = "FILE", requires = "part", value_hint = ValueHint::FilePath)]
    pub(crate) light_in: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) job: JobArguments,
}

impl BakeArguments {
    /// Method of computing light between surfaces.
    ///
    /// # Errors
    /// A reconstruction for a method without one.
    pub(crate) fn method(&self) -> Result<BakeMethod, &'static str> {
        match (self.method, self.reconstruct) {
            (BakeMethodName::Gather, None) => Ok(BakeMethod::Gather),
            (BakeMethodName::Gather, Some(_)) => Err("--reconstruct requires --method radiosity"),
            (BakeMethodName::Radiosity, interpolation) => Ok(BakeMethod::Radiosity {
                reconstruction: interpolation.unwrap_or(Interpolation::NaturalNeighbour),
            }),
        }
    }

    /// Settings of the model.
    pub(crate) fn model(&self) -> ModelSettings {
        let irradiance = match self.lightmap {
            LightMapName::Exr => Format::Exr,
            LightMapName::Png => Format::Png,
        };
        ModelSettings { tolerance: self.tolerance, tone: self.tone.tone(), irradiance }
    }
}

/// Formats of light maps beside the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LightMapName {
    // Floating point.
    Exr,
    // Eight bits, after the tone curve.
    Png,
}

/// The methods of the bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BakeMethodName {
    // Rays over the hemisphere from points on each surface.
    Gather,
    // The hierarchical solver.
    Radiosity,
}

/// The interpolations by their names.
fn interpolation_parser() -> impl TypedValueParser<Value = Interpolation> {
    let by_name = |name: String| Interpolation::ALL.into_iter().find(|method| method.name() == name);
    PossibleValuesParser::new(Interpolation::ALL.map(|method| method.name()))
        .try_map(move |name| by_name(name).ok_or("there is no such interpolation"))
}
