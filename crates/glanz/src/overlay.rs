//! Baked light and lux maps for the viewer's page.

use std::f32::consts::FRAC_1_PI;
use std::path::Path;
use std::sync::Arc;

use glanz_illumination::add_walls;
use glanz_light::Wavelengths;
use glanz_math::DVec3;
use glanz_radiosity::bake::LightMaps;
use glanz_scene::{Description, HitLocation, ParametricPoint, PlacedSurface, Scene};
use glanz_viewer::model::{LuxLookup, MapLabel, Model};
use glanz_viewer::server::SceneOverlay;

use crate::bake::{LightFile, divided};
use crate::error::Error;
use crate::illuminate::LuxFolder;

/// Number of values of baked light along each side of a patch, about that of light maps on a patch of some metres.
const BAKED_VALUES: usize = 65;

/// Additions of the page to a scene: walls of a room, and light on surfaces.
#[derive(Debug, Default)]
pub struct LightOverlay {
    /// Size of a box of walls, metres.
    room: Option<DVec3>,
    light: OverlaidLight,
}

#[derive(Debug, Default)]
enum OverlaidLight {
    #[default]
    None,
    Baked(Box<LightFile>),
    Lux(LuxFolder),
}

impl LightOverlay {
    /// Adds the walls of a box from the origin to `size`, metres, as
    /// [`IlluminateBuilder::room`](crate::IlluminateBuilder::room) does.
    #[must_use]
    pub fn room(self, size: DVec3) -> Self {
        Self { room: Some(size), ..self }
    }

    /// Shows the light of this checkpoint of a finished bake.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn baked(self, path: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self { light: OverlaidLight::Baked(Box::new(LightFile::read(path.as_ref())?)), ..self })
    }

    /// Shows the lux maps of a folder written by [`IlluminateOutcome::save`](crate::IlluminateOutcome::save).
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn lux(self, folder: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self { light: OverlaidLight::Lux(LuxFolder::read(folder)?), ..self })
    }

    /// Whether there are no additions.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.room.is_none() && matches!(self.light, OverlaidLight::None)
    }

    fn add_light(&self, scene: &Scene, content_hash: u128, model: Model) -> Result<Model, Error> {
        let placed = scene.placed_surfaces();
        match &self.light {
            OverlaidLight::None => Ok(model),
            OverlaidLight::Baked(light) => {
                light.check(content_hash)?;
                let elements = divided(scene, light.density())?;
                let maps = LightMaps::new(&elements, light.maps(&elements)?);
                let label = MapLabel { unit: "W/(m² sr)", is_colour: true, two_sided: true };
                let value = |surface, face, uv, back| {
                    radiance(scene, &placed, &maps, &ParametricPoint { surface, face, uv, back })
                };
                Ok(model.with_map(label, scene, BAKED_VALUES, |_| true, value)?)
            }
            OverlaidLight::Lux(folder) => {
                let maps = Arc::new(folder.place(scene)?);
                let label = MapLabel { unit: "lx", is_colour: false, two_sided: maps.is_two_sided() };
                let value = |surface: u32, face, uv, back| {
                    let at = placed.get(surface as usize)?.at(face, uv, back)?.at;
                    let at = HitLocation::new(&at, ParametricPoint { surface, face, uv, back });
                    maps.interpolated(&at).map(|lux| [lux; 3])
                };
                let model =
                    model.with_map(label, scene, maps.side(&placed), |surface| maps.is_on(surface), value)?;
                let model = model.with_lux(Arc::clone(&maps) as Arc<dyn LuxLookup>);
                let is_other = folder.content_hash().is_some_and(|hash| hash != content_hash);
                Ok(if is_other { model.with_note(changed_scene(folder)) } else { model })
            }
        }
    }
}

impl SceneOverlay for LightOverlay {
    fn add_shapes(&self, description: &mut Description) {
        if let Some(size) = self.room {
            add_walls(description, size);
        }
    }

    fn add_maps(&self, scene: &Scene, content_hash: u128, model: Model) -> Result<Model, String> {
        self.add_light(scene, content_hash, model).map_err(|error| error.to_string())
    }

    fn folder(&self) -> Option<&Path> {
        match &self.light {
            OverlaidLight::Lux(folder) => Some(folder.path()),
            _ => None,
        }
    }
}

/// The note that the scene is not as it was when lux maps were computed.
fn changed_scene(folder: &LuxFolder) -> String {
    // The name alone: pages on other machines need not know where it is.
    let path = folder.path();
    let whole = path.canonicalize();
    let name = whole.as_deref().unwrap_or(path).file_name().unwrap_or_default().to_string_lossy();
    format!(
        "the lux maps in {name} were computed for other content of the scene's files: run `glanz illuminate` again, then start `glanz view` again"
    )
}

/// Emitted and baked radiance at a point.
fn radiance(
    scene: &Scene,
    placed: &[PlacedSurface<'_>],
    maps: &LightMaps,
    place: &ParametricPoint,
) -> Option<[f32; 3]> {
    let wavelengths = Wavelengths::default();
    let at = placed.get(place.surface as usize)?.at(place.face, place.uv, place.back)?.at;
    let irradiance = maps.irradiance(place)?;
    let toward_viewer = if place.back { -DVec3::Z } else { DVec3::Z };
    let albedo = at.bsdf(scene, &wavelengths)?.reflected(toward_viewer);
    Some((albedo * irradiance * FRAC_1_PI + scene.emitted(&at, at.wo)).to_rgb(&wavelengths))
}
