//! Arguments of `glanz optimize`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use glanz::illumination::optimize::{GradientMethod, OptimizeSettings};

use super::common::JobArguments;

const HELP: &str = "\
The scene names what may change (\"string free\") and what is wanted (\"string target\"), see
docs/optimize.md. The result is the same file with other numbers, which glanz illuminate
verifies with all light; the search itself counts the light after one reflection in a mirror.

Derivatives of the light lead to control points, and positions of lamps and mirrors; radii and
positions of receivers are found without. Ctrl-C ends the search and writes the best so far.

Examples:
  glanz optimize mirror.pbrt -o better.pbrt
  glanz illuminate better.pbrt -o lux
  glanz optimize mirror.pbrt -o better.pbrt --rays 500000 --checkpoint state --resume";

#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct OptimizeArguments {
    /// Scene file in pbrt's language (v3 or v4)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Scene file for the result: .pbrt
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Number of rays: more are slower, and needed for more cells of a receiver or more free numbers; at most 2^20
    #[arg(long, value_name = "N", default_value_t = 65536, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    rays: u32,
    /// Largest number of steps
    #[arg(long, value_name = "N", default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Seed of the rays; another seed gives slightly other numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Computation of gradients: by the derivatives of all rays or, for comparison, by differences of the merit
    #[arg(long, value_name = "NAME", value_enum, default_value_t = GradientName::Adjoint, hide_short_help = true)]
    gradient: GradientName,
    #[command(flatten)]
    pub(crate) job: JobArguments,
}

impl OptimizeArguments {
    /// The same for the engine.
    pub(crate) fn settings(&self) -> OptimizeSettings {
        OptimizeSettings {
            rays: self.rays as usize,
            iterations: self.steps,
            seed: self.seed,
            gradient: self.gradient.into(),
        }
    }
}

/// Computations of gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GradientName {
    // By the derivatives of the rays.
    Adjoint,
    // By differences.
    Differences,
}

impl From<GradientName> for GradientMethod {
    fn from(name: GradientName) -> Self {
        match name {
            GradientName::Adjoint => Self::Adjoint,
            GradientName::Differences => Self::Differences,
        }
    }
}
