//! Arguments of `glanz convert`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use glanz::{ChordalDeviation, MeshSettings};
use glanz_terminal::Verbosity;
use glanz_terminal::values::positive;

use super::common::{ReadingArguments, ThreadArguments};

const CONVERT_HELP: &str = "\
The extension of OUT selects the format:
  .pbrt a scene file with the same exact surfaces, of a model; it renders as the model does
  .glb  binary glTF 2.0: assemblies with names and instances, materials, normals; y is up
  .obj  Wavefront OBJ, with its materials beside it as .mtl
  .ply  binary PLY with a colour per triangle

Triangles are as close to the surfaces as --tolerance and --angle demand. An edge that faces
share is divided once, so that they leave no gap; the last line tells how many solids are
watertight. Lights, camera and textures are not converted. Lengths are metres.

Ctrl-C, SIGTERM and SIGHUP end the command with exit status 130, 143 and 129 and write nothing. A
second one ends the program at once.

Examples:
  glanz convert part.step part.glb
  glanz convert part.step part.pbrt
  glanz convert part.step part.ply --tolerance 0.01mm --angle 10
  glanz convert assembly.step assembly.obj --tolerance 0.02%";

#[derive(Debug, Args)]
#[command(after_help = CONVERT_HELP)]
pub(crate) struct ConvertArguments {
    /// Scene file in pbrt's language, or model: .step, .stp, .igs, .iges, .glb, .gltf, .obj, .stl, .ply, .rib, or - for the standard input
    #[arg(value_name = "IN", value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,
    /// File to write: .pbrt, .glb, .obj, .ply
    #[arg(value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,
    /// Largest distance of triangles from the surface: a length with unit (um, mm, cm, m, in), or a part of the diagonal
    /// of the model [default: 0.1%]
    #[arg(long, value_name = "LENGTH|%", value_parser = deviation)]
    tolerance: Option<ChordalDeviation>,
    /// Largest angle between the normals at the corners of a triangle, degrees, up to 180 [default: 20]
    #[arg(long, value_name = "DEGREES", value_parser = angle)]
    angle: Option<f64>,
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    #[command(flatten)]
    pub(crate) reading: ReadingArguments,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

impl ConvertArguments {
    /// How close triangles are to surfaces.
    pub(crate) fn mesh(&self) -> MeshSettings {
        let default = MeshSettings::default();
        MeshSettings {
            deviation: self.tolerance.unwrap_or(default.deviation),
            angle: self.angle.map_or(default.angle, f64::to_radians),
        }
    }

    /// Whether it is said how close triangles are to be.
    pub(crate) fn has_mesh_settings(&self) -> bool {
        self.tolerance.is_some() || self.angle.is_some()
    }
}

/// A length with its unit, or a percentage.
fn deviation(text: &str) -> Result<ChordalDeviation, String> {
    /// Metres per unit; longer names before those that they end with.
    const UNITS: [(&str, f64); 5] = [("um", 1e-6), ("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("m", 1.0)];
    let form = || "it must be a length such as 0.1mm, or a percentage such as 0.1%".to_owned();
    let number = |text: &str| positive(text.trim()).map_err(|_| form());
    if let Some(percentage) = text.strip_suffix('%') {
        return Ok(ChordalDeviation::OfSize(0.01 * number(percentage)?));
    }
    let unit = UNITS.iter().find_map(|&(unit, metres)| Some((text.strip_suffix(unit)?, metres)));
    let (length, metres) = unit.ok_or_else(form)?;
    Ok(ChordalDeviation::Metres(metres * number(length)?))
}

/// Degrees above 0 and up to 180.
fn angle(text: &str) -> Result<f64, String> {
    positive(text)
        .ok()
        .filter(|angle| *angle <= 180.0)
        .ok_or_else(|| "it must be above 0 and at most 180".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_lengths_with_units_or_percentages() {
        assert_eq!(deviation("0.5%"), Ok(ChordalDeviation::OfSize(0.005)));
        assert_eq!(deviation("2m"), Ok(ChordalDeviation::Metres(2.0)));
        assert_eq!(deviation("2 mm"), Ok(ChordalDeviation::Metres(0.002)));
        assert_eq!(deviation("1in"), Ok(ChordalDeviation::Metres(0.0254)));
        for wrong in ["2", "mm", "-1mm", "0%", "nanm", "infm", "1 ft", ""] {
            assert!(deviation(wrong).is_err(), "{wrong}");
        }
        assert!(angle("180").is_ok() && angle("0").is_err() && angle("181").is_err());
    }
}
