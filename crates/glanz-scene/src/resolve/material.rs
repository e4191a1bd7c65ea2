//! Materials.

use glanz_light::Wavelengths;
use glanz_shading::Material;

use super::WarningList;
use super::texture::ResolvedTextures;
use crate::description::{Description, MaterialDescription};
use crate::error::{SceneError, SceneErrorKind};

pub(super) fn materials(
    description: &Description,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
    warnings: &mut WarningList,
) -> Result<Vec<Material>, SceneError> {
    let resolve = |MaterialDescription { name, kind, location }: &MaterialDescription| {
        let name = if name.is_empty() { "without name".to_owned() } else { format!("\"{name}\"") };
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
    description.materials.iter().map(resolve).collect()
}
