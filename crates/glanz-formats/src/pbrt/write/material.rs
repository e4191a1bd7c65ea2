//! Materials.

use std::fmt::Write;

use glanz_light::SpectralDistribution;
use glanz_scene::description::{DescriptionForm, FloatParameter, MaterialKind, SpectrumParameter};
use glanz_shading::model::{FinishModel, MetalColor, PrincipledMaterial, Roughness, SurfaceFinish};

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
        MaterialKind::OrenNayar(material) => {
            list.text("type", "matte");
            spectrum(&mut list, "Kd", &material.reflectance)?;
            number_or_texture(&mut list, "sigma", material.sigma)?;
        }
        MaterialKind::Mirror(material) => {
            list.text("type", "mirror");
            spectrum(&mut list, "reflectance", &material.reflectance)?;
            finish(&mut list, material.finish.as_ref())?;
        }
        MaterialKind::Conductor(material) => {
            list.text("type", "conductor");
            metal(&mut list, ["eta", "k"], &material.color)?;
            facets(&mut list, &material.roughness, material.multiple_scattering)?;
            finish(&mut list, material.finish.as_ref())?;
        }
        MaterialKind::Dielectric(material) => {
            list.text("type", if material.thin { "thindielectric" } else { "dielectric" });
            match &material.dispersion {
                Some(index) => spectrum(&mut list, "eta", &SpectrumParameter::Value(index.clone()))?,
                None => number_or_texture(&mut list, "eta", material.eta)?,
            }
            spectrum(&mut list, "Kr", &material.reflectance)?;
            spectrum(&mut list, "Kt", &material.transmittance)?;
            // A pane has no facets.
            if !material.thin {
                facets(&mut list, &material.roughness, material.multiple_scattering)?;
            }
        }
        MaterialKind::CoatedDiffuse(material) => {
            list.text("type", "coateddiffuse");
            spectrum(&mut list, "reflectance", &material.reflectance)?;
            number_or_texture(&mut list, "eta", material.eta)?;
            facets(&mut list, &material.roughness, material.multiple_scattering)?;
        }
        MaterialKind::DiffuseTransmission(material) => {
            list.text("type", "diffusetransmission");
            spectrum(&mut list, "reflectance", &material.reflectance)?;
            spectrum(&mut list, "transmittance", &material.transmittance)?;
        }
        MaterialKind::Principled(material) => principled(&mut list, material)?,
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

fn principled(
    list: &mut ParameterWriter<'_>,
    material: &PrincipledMaterial<DescriptionForm>,
) -> Result<(), PbrtWriteError> {
    list.text("type", "principled");
    spectrum(list, "basecolor", &material.base_color)?;
    number_or_texture(list, "metallic", material.metallic)?;
    if let Some(color) = &material.metal {
        metal(list, ["metal.eta", "metal.k"], color)?;
    }
    roughness(list, ["uroughness", "vroughness"], &material.roughness)?;
    number_or_texture(list, "eta", material.eta)?;
    spectrum(list, "specular", &material.specular)?;
    number_or_texture(list, "transmission", material.transmission)?;
    flag(list, "thin", material.thin, false);
    number_or_texture(list, "coat", material.coat)?;
    roughness(list, ["coat.uroughness", "coat.vroughness"], &material.coat_roughness)?;
    number_or_texture(list, "coat.eta", material.coat_eta)?;
    spectrum(list, "sheen", &material.sheen)?;
    number_or_texture(list, "sheen.roughness", material.sheen_roughness)?;
    flag(list, "remaproughness", false, true);
    flag(list, "multiplescattering", material.multiple_scattering, true);
    Ok(())
}

/// The optical constants of a metal.
fn metal(
    list: &mut ParameterWriter<'_>,
    [eta_name, k_name]: [&str; 2],
    color: &MetalColor<DescriptionForm>,
) -> Result<(), PbrtWriteError> {
    match color {
        MetalColor::Index { eta, k } => {
            spectrum(list, eta_name, eta)?;
            spectrum(list, k_name, k)
        }
        MetalColor::Reflectance(reflectance) => spectrum(list, "reflectance", reflectance),
    }
}

/// The surface finish of a mirror.
fn finish(list: &mut ParameterWriter<'_>, finish: Option<&SurfaceFinish>) -> Result<(), PbrtWriteError> {
    let (kind, numbers): (_, &[_]) = match finish.map(SurfaceFinish::model) {
        None => return Ok(()),
        Some(FinishModel::Gaussian { sigma, fraction }) => {
            ("gaussian", &[("sigma", sigma), ("fraction", fraction)])
        }
        Some(FinishModel::Abg { a, b, g }) => ("abg", &[("A", a), ("B", b), ("g", g)]),
        Some(_) => return Err(PbrtWriteError::Unsupported("a surface finish")),
    };
    list.text("finish", kind);
    numbers.iter().for_each(|&(name, value)| list.float(name, value));
    Ok(())
}

/// The facets of a material of one surface.
fn facets(
    list: &mut ParameterWriter<'_>,
    surface: &Roughness<DescriptionForm>,
    multiple_scattering: bool,
) -> Result<(), PbrtWriteError> {
    if *surface != Roughness::smooth() {
        roughness(list, ["uroughness", "vroughness"], surface)?;
        flag(list, "remaproughness", false, true);
    }
    flag(list, "multiplescattering", multiple_scattering, true);
    Ok(())
}

/// The widths of facets.
fn roughness(
    list: &mut ParameterWriter<'_>,
    names: [&str; 2],
    roughness: &Roughness<DescriptionForm>,
) -> Result<(), PbrtWriteError> {
    for (name, value) in names.into_iter().zip([roughness.u, roughness.v]) {
        let FloatParameter::Value(value) = value else {
            return Err(PbrtWriteError::Unsupported("a texture"));
        };
        list.singles("float", name, [roughness.scale.alpha(value) as f32]);
    }
    Ok(())
}

/// A truth value that differs from its default.
fn flag(list: &mut ParameterWriter<'_>, name: &str, value: bool, default: bool) {
    if value != default {
        list.boolean(name, value);
    }
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

/// A spectrum as a parameter.
pub(super) fn spectrum(
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
