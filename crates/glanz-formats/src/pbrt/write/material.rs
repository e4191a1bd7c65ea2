//! Materials.

use std::fmt::Write;

use glanz_light::SpectralDistribution;
use glanz_scene::description::{FloatParameter, MaterialKind, SpectrumParameter};

use super::PbrtWriteError;
use super::parameters::{ParameterWriter, quoted};

/// The name of a material by its number.
pub(super) fn name(number: usize) -> String {
    format!("material {}", number + 1)
}

/// Writes the definition of a material.
pub(super) fn write(text: &mut String, number: usize, kind: &MaterialKind) -> Result<(), PbrtWriteError> {
    // Writing to a text cannot fail.
    let _ = write!(text, "MakeNamedMaterial {}", quoted(&name(number)));
    let mut list = ParameterWriter::new(text);
    match kind {
        MaterialKind::Diffuse(material) => {
            list.text("type", "diffuse");
            spectrum(&mut list, "reflectance", &material.reflectance)?;
        }
        MaterialKind::Mirror(material) => {
            list.text("type", "mirror");
            spectrum(&mut list, "reflectance", &material.reflectance)?;
        }
        MaterialKind::Conductor(material) => {
            list.text("type", "conductor");
            spectrum(&mut list, "eta", &material.eta)?;
            spectrum(&mut list, "k", &material.k)?;
        }
        MaterialKind::Dielectric(material) => {
            list.text("type", if material.thin { "thindielectric" } else { "dielectric" });
            number_or_texture(&mut list, "eta", material.eta)?;
            spectrum(&mut list, "Kr", &material.reflectance)?;
            spectrum(&mut list, "Kt", &material.transmittance)?;
        }
        MaterialKind::Phong(material) => {
            list.text("type", "phong");
            spectrum(&mut list, "Ka", &material.ambient)?;
            spectrum(&mut list, "Kd", &material.diffuse)?;
            spectrum(&mut list, "Ks", &material.specular)?;
            number_or_texture(&mut list, "exponent", material.exponent)?;
        }
        MaterialKind::Interface => list.text("type", "interface"),
        _ => return Err(PbrtWriteError::Unsupported("a material")),
    }
    list.finish().map_err(|_| PbrtWriteError::Unsupported("a material with numbers that are not finite"))
}

fn number_or_texture(
    list: &mut ParameterWriter<'_>,
    name: &str,
    value: FloatParameter,
) -> Result<(), PbrtWriteError> {
    match value {
        FloatParameter::Value(value) => list.singles("float", name, [value]),
        FloatParameter::Texture(_) => return Err(PbrtWriteError::Unsupported("a texture")),
    }
    Ok(())
}

fn spectrum(
    list: &mut ParameterWriter<'_>,
    name: &str,
    value: &SpectrumParameter,
) -> Result<(), PbrtWriteError> {
    match value {
        SpectrumParameter::Value(SpectralDistribution::Constant(value)) => {
            list.singles("float", name, [*value]);
        }
        SpectrumParameter::Value(SpectralDistribution::Rgb(rgb)) => list.singles("rgb", name, *rgb),
        SpectrumParameter::Value(SpectralDistribution::Sampled(samples)) => {
            let pairs = samples.points().iter().flat_map(|&(nm, value)| [nm, value]);
            list.singles("spectrum", name, pairs);
        }
        SpectrumParameter::Value(_) => {
            return Err(PbrtWriteError::Unsupported("the spectrum of a black body"));
        }
        SpectrumParameter::Texture(_) => return Err(PbrtWriteError::Unsupported("a texture")),
    }
    Ok(())
}
