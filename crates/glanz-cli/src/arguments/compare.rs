//! Arguments of `glanz compare`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use glanz_terminal::values::bound;

use super::common::LimitArguments;

const COMPARE_HELP: &str = "\
The second picture is the reference. The measures are
  rmse          root of the mean squared difference
  relmse        mean of the squared difference over the squared reference + 0.01
  display-rmse  rmse of the values clipped to [0, 1]
  max           largest difference
  flip          mean FLIP error, from 0 to 1: the perceived difference

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
    /// The measure that --fail-above tests
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Metric::Rmse)]
    pub(crate) metric: Metric,
    #[command(flatten)]
    pub(crate) limits: LimitArguments,
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
