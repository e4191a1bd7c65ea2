//! Materials.

use glanz_light::Wavelengths;
use glanz_shading::Material;
use glanz_shading::texture::MipMap;

use super::WarningList;
use super::texture::ResolvedTextures;
use crate::description::{Description, MaterialDescription, SurfaceDetailDescription};
use crate::error::{SceneError, SceneErrorKind};
use crate::surface_detail::SurfaceDetail;

pub(super) fn materials(
    description: &Description,
    textures: &ResolvedTextures,
    wavelengths: &Wavelengths,
    warnings: &mut WarningList,
) -> Result<Vec<Material>, SceneError> {
    let resolve = |MaterialDescription { name, kind, location, .. }: &MaterialDescription| {
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
    description.materials.iter().map(resolve).collect()
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
                let count = description.images.len();
                let kind = SceneErrorKind::Reference { what: "picture", index, count };
                let source = description.images.get(index).ok_or(SceneError { location, kind })?;
                let picture = MipMap::try_new(&source.pixels, false).map_err(|reason| {
                    let name = name_in_messages(&material.name);
                    let (what, reason) = (format!("normal map of material {name}"), reason.to_string());
                    SceneError { location, kind: SceneErrorKind::Texture { name: what, reason } }
                })?;
                SurfaceDetail::NormalMap(picture)
            }
        }))
    };
    description.materials.iter().map(resolve).collect()
}
