//! Arguments of `glanz merge`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use glanz::job::byte_size;
use glanz_terminal::Verbosity;

use super::common::{ThreadArguments, ToneArguments};

const MERGE_HELP: &str = "\
The parts must be of the same scene with the same settings, and have nothing in common. Their order
does not matter; the result has the bits of one run of the whole. Parts that are missing, given twice,
of something else or damaged are named, and nothing is written; --partial leaves out what is missing
or damaged, and the joined checkpoint can be completed by its command with --resume.

Examples:
  glanz merge a.glanz b.glanz -o room.exr --checkpoint whole.glanz
  glanz merge part-*.glanz -o preview.png --partial";

#[derive(Debug, Args)]
#[command(after_help = MERGE_HELP)]
pub(crate) struct MergeArguments {
    /// Checkpoints of `glanz render --part K/N --checkpoint PART`, or of parts of one `glanz illuminate` or `glanz bake`
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) parts: Vec<PathBuf>,
    /// Picture to write, of parts of a picture; the extension selects the format: exr, png, hdr or pfm (repeat for several); png:- is the standard output
    #[arg(short, long, value_name = "FILE", required_unless_present = "checkpoint", value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,
    /// Write the joined checkpoint
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Join what is there: parts that are missing or damaged are left out, with a warning
    #[arg(long)]
    pub(crate) partial: bool,
    /// Largest memory, half of it for the film of a picture, such as 2G or 512M [default: three quarters of what is available];
    /// a larger film is in a temporary file
    #[arg(long, value_name = "SIZE", value_parser = byte_size)]
    pub(crate) memory: Option<u64>,
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    #[command(flatten)]
    pub(crate) tone: ToneArguments,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}
