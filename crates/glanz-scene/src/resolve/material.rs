//! Materials.

use glanz_light::{SpectralDistribution, Wavelengths};
use glanz_shading::{Material, SpectrumInput};

use super::Notes;
use super::texture::ResolvedTextures;
use crate::description::{Description, MaterialDescription, MaterialKind};
use crate::error::{SceneError, SceneErrorKind};

pub(super) fn materials(
    description: &Description,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
    notes: &mut Notes,
) -> Result<Vec<Material>, SceneError> {
    let resolve = |material: &MaterialDescription| {
        let resolved = self::material(material, textures, wavelengths)?;
        if let Some(excess) = resolved.energy_excess() {
            let message = format!(
                "material {}: diffuse plus specular is {excess}; path-traced light scales both down to a sum of 1",
                quoted(&material.name)
            );
            notes.warn(material.location, message);
        }
        Ok(resolved)
    };
    description.materials.iter().map(resolve).collect()
}

fn quoted(name: &str) -> String {
    if name.is_empty() { "without name".to_owned() } else { format!("\"{name}\"") }
}

fn material(
    material: &MaterialDescription,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
) -> Result<Material, SceneError> {
    let inputs = textures.inputs(wavelengths, material.location);
    let resolved = match &material.kind {
        MaterialKind::Diffuse { reflectance } => {
            Material::Diffuse { reflectance: inputs.reflectance(reflectance)? }
        }
        MaterialKind::Mirror { reflectance } => {
            Material::Mirror { reflectance: inputs.reflectance(reflectance)? }
        }
        MaterialKind::Conductor { eta, k } => Material::Conductor {
            eta: inputs.unbounded(eta)?,
            k: inputs.unbounded(k)?,
            tint: SpectrumInput::Constant(SpectralDistribution::Constant(1.0).reflectance(wavelengths)),
        },
        MaterialKind::Dielectric { eta, reflectance, transmittance, thin } => Material::Dielectric {
            eta: inputs.float(eta)?,
            reflectance: inputs.reflectance(reflectance)?,
            transmittance: inputs.reflectance(transmittance)?,
            thin: *thin,
        },
        MaterialKind::Phong { ambient, diffuse, specular, exponent } => Material::Phong {
            ambient: inputs.reflectance(ambient)?,
            diffuse: inputs.reflectance(diffuse)?,
            specular: inputs.reflectance(specular)?,
            exponent: inputs.float(exponent)?,
        },
        MaterialKind::Interface => Material::Interface,
    };
    resolved.check(&textures.textures).map_err(|reason| SceneError {
        location: material.location,
        kind: SceneErrorKind::Material { name: quoted(&material.name), reason },
    })?;
    Ok(resolved)
}
