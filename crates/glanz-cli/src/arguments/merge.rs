//! Arguments of `glanz merge`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use glanz_terminal::Verbosity;

use super::common::ToneArguments;

const MERGE_HELP: &str = "\
The parts must be of the same scene with the same settings, and must not share samples.

Example:
  glanz merge a.glanz b.glanz -o room.exr --checkpoint whole.glanz";

#[derive(Debug, Args)]
#[command(after_help = MERGE_HELP)]
pub(crate) struct MergeArguments {
    /// Checkpoints written by `glanz render --samples A..B --checkpoint PART`
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) parts: Vec<PathBuf>,
    /// Picture to write; the extension selects the format: exr, png, hdr or pfm (repeat for several)
    #[arg(short, long, value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,
    /// Also write the joined checkpoint
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}
