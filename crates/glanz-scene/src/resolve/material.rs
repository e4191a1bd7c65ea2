//! Materials.

use glanz_job::ResourceBudget;
use glanz_light::Wavelengths;
use glanz_shading::Material;

use super::texture::ResolvedTextures;
use super::{WarningList, spend};
use crate::description::{Description, MaterialDescription, SurfaceDetailDescription};
use crate::error::{SceneError, SceneErrorKind};
use crate::light::picture_of;
use crate::surface_detail::SurfaceDetail;

pub(super) fn materials(
    description: &Description,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
    budget: &ResourceBudget,
    warnings: &mut WarningList,
) -> Result<Vec<Material>, SceneError> {
    let resolve = |MaterialDescription { name, kind, location, .. }: &MaterialDescription| {
        spend(budget, 0, size_of::<Material>() as u64, *location)?;
        let name = name_in_messages(name);
        match kind.resolve(&textures.inputs(wavelengths, *location)) {
            Ok(material) => {
                if let Some(warning) = material.warning() {
                    warnings.warn(*location, format!("material {name}: {warning}"));
                }
                Ok(material)
            }
            Err(reason) => {
                Err(SceneError { location: *location, kind: SceneErrorKind::Material { name, reason } })
            }
        }
    };
    let materials = description.materials.iter().map(resolve).collect::<Result<Vec<_>, _>>()?;
    check_mixtures(description, &materials)?;
    Ok(materials)
}

/// Largest number of mixtures within each other.
const MAX_MIXTURE_DEPTH: usize = 32;

/// Checks that the parts of mixtures exist, and that selecting one ends.
fn check_mixtures(description: &Description, materials: &[Material]) -> Result<(), SceneError> {
    let parts = |material: &Material| match material {
        Material::Mix(mix) => mix.materials.to_vec(),
        _ => Vec::new(),
    };
    let mut ends: Vec<bool> = materials.iter().map(|material| parts(material).is_empty()).collect();
    for _ in 0..MAX_MIXTURE_DEPTH {
        let end = |material| parts(material).iter().all(|&part| ends.get(part).copied().unwrap_or(true));
        ends = materials.iter().map(end).collect();
    }
    for ((described, material), ends) in description.materials.iter().zip(materials).zip(ends) {
        let (location, count) = (described.location, materials.len());
        if let Some(index) = parts(material).into_iter().find(|&part| part >= count) {
            let kind = SceneErrorKind::Reference { what: "material", index, count };
            return Err(SceneError { location, kind });
        }
        if !ends {
            let name = name_in_messages(&described.name);
            return Err(SceneError {
                location,
                kind: SceneErrorKind::Mixture { name, limit: MAX_MIXTURE_DEPTH },
            });
        }
    }
    Ok(())
}

fn name_in_messages(name: &str) -> String {
    if name.is_empty() { "without name".to_owned() } else { format!("\"{name}\"") }
}

/// The surface details of the materials, one each.
pub(super) fn surface_details(
    description: &Description,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
) -> Result<Vec<Option<SurfaceDetail>>, SceneError> {
    let resolve = |material: &MaterialDescription| {
        let Some(detail) = &material.surface_detail else { return Ok(None) };
        let location = material.location;
        Ok(Some(match *detail {
            SurfaceDetailDescription::Bump(height) => {
                SurfaceDetail::Bump(textures.inputs(wavelengths, location).number(&height)?)
            }
            SurfaceDetailDescription::NormalMap(index) => {
                let picture = picture_of(&description.images, index);
                let picture = picture.map_err(|kind| SceneError { location, kind })?;
                picture.check_finite().map_err(|reason| {
                    let name = name_in_messages(&material.name);
                    let (what, reason) = (format!("normal map of material {name}"), reason.to_string());
                    SceneError { location, kind: SceneErrorKind::Texture { name: what, reason } }
                })?;
                SurfaceDetail::NormalMap(picture.clone())
            }
        }))
    };
    description.materials.iter().map(resolve).collect()
}
