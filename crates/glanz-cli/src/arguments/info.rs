//! Arguments of `glanz info`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::common::ReadingArguments;

const INFO_HELP: &str = "\
Examples:
  glanz info -v part.step
  glanz info --ugr luminaire.ldt
  glanz info --files room.pbrt | tar -chf room.tar -T -";

#[derive(Debug, Args)]
#[command(after_help = INFO_HELP)]
pub(crate) struct InfoArguments {
    /// Scene file in pbrt's language (v3 or v4), model: .step, .igs, .glb, .gltf, .obj, .stl, .ply, .rib, or photometric file: .ies, .ldt; - is a scene or a model from the standard input
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Draw the candela distribution of a photometric file: polar plot, .svg
    #[arg(long, value_name = "SVG", value_hint = ValueHint::FilePath)]
    pub(crate) plot: Option<PathBuf>,
    /// Of a photometric file, the unified glare rating (UGR) in the 19 standard rooms of CIE 117 and 190, across and along the luminaire, for the flux
    /// of the file; it needs a luminous opening
    #[arg(long)]
    pub(crate) ugr: bool,
    /// List every file that the scene needs, one path per line; files that are missing are named by warnings, and the exit status is 1
    #[arg(long, conflicts_with_all = ["plot", "ugr", "verbose", "strict"])]
    pub(crate) files: bool,
    /// Of a CAD file, list every repair and everything that is left out, with entity numbers
    #[arg(short, long)]
    pub(crate) verbose: bool,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
