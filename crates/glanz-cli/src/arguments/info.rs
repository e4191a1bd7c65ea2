//! Arguments of `glanz info`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::common::Strictness;

#[derive(Debug, Args)]
pub(crate) struct InfoArguments {
    /// Scene file in pbrt's language (v3 or v4), model: .step, .igs, .glb, .gltf, .obj, .stl, .ply, .rib, or photometric file: .ies, .ldt
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// Draw the candela distribution of a photometric file: polar plot, .svg
    #[arg(long, value_name = "SVG", value_hint = ValueHint::FilePath)]
    pub(crate) plot: Option<PathBuf>,
    /// Of a CAD file, list every repair and everything that is left out, with entity numbers
    #[arg(short, long)]
    pub(crate) verbose: bool,
    #[command(flatten)]
    pub(crate) strictness: Strictness,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
