//! Light that was found before, for the page that shows a scene: baked, or counted by receivers.

mod lux;

use std::f32::consts::FRAC_1_PI;
use std::path::PathBuf;

use glanz_illumination::add_walls;
use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3};
use glanz_radiosity::bake::LightMaps;
use glanz_scene::{Description, Place, PlacedSurface, Scene};
use glanz_viewer::model::{MapLabel, Model};
use glanz_viewer::server::Dress;

use crate::arguments::ViewArguments;
use crate::baking;
use crate::light_file::{self, LightFile};
use crate::messages::Failure;
use lux::LuxFolder;

/// Values along each side of a patch: as many as light maps have on a patch of some metres.
const SIDE: usize = 65;

/// What `glanz view` adds to a scene.
#[derive(Debug)]
pub(crate) struct SurfaceLight {
    /// Size of a box of walls, metres.
    room: Option<DVec3>,
    light: Light,
}

#[derive(Debug)]
enum Light {
    None,
    Baked(PathBuf, Box<LightFile>),
    Lux(LuxFolder),
}

impl SurfaceLight {
    /// What the arguments name; `None` if that is nothing.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn read(arguments: &ViewArguments) -> Result<Option<Self>, Failure> {
        let light = match (&arguments.light, &arguments.lux) {
            (Some(path), _) => Light::Baked(path.clone(), Box::new(light_file::read(path)?)),
            (None, Some(folder)) => Light::Lux(LuxFolder::read(folder)?),
            (None, None) => Light::None,
        };
        let room = arguments.room();
        Ok((room.is_some() || !matches!(light, Light::None)).then_some(Self { room, light }))
    }
}

impl Dress for SurfaceLight {
    fn furnish(&self, description: &mut Description) {
        if let Some(size) = self.room {
            add_walls(description, size);
        }
    }

    fn dress(&self, scene: &Scene, content_hash: u128, model: Model) -> Result<Model, String> {
        match &self.light {
            Light::None => Ok(model),
            Light::Baked(path, light) => {
                let said = |failure: Failure| failure.message;
                light.check(path, content_hash).map_err(said)?;
                let elements = baking::divided(scene, light.density()).map_err(said)?;
                let maps = LightMaps::new(&elements, light.maps(path, &elements).map_err(said)?);
                let placed = scene.placed_surfaces();
                let label = MapLabel { name: "baked light", unit: "W/(m² sr)" };
                let value = |surface, face, uv| radiance(scene, &placed, &maps, (surface, face, uv));
                model.with_map(label, scene, SIDE, value).map_err(|error| error.to_string())
            }
            Light::Lux(folder) => {
                let maps = folder.of_scene(scene)?;
                let placed = scene.placed_surfaces();
                let label = MapLabel { name: "illuminance", unit: "lx" };
                let value = |surface, face, uv| maps.lux(&placed, surface, face, uv).map(|lux| [lux; 3]);
                model.with_map(label, scene, SIDE, value).map_err(|error| error.to_string())
            }
        }
    }
}

/// What leaves a place by its own light and by the baked one, on its brighter side: surfaces are drawn alike on both.
fn radiance(
    scene: &Scene,
    placed: &[PlacedSurface<'_>],
    maps: &LightMaps,
    (surface, face, uv): (u32, u32, DVec2),
) -> Option<[f32; 3]> {
    let wavelengths = Wavelengths::default();
    let of_side = |back| {
        let at = placed.get(surface as usize)?.at(face, uv, back)?.at;
        let irradiance = maps.irradiance(&Place { surface, face, back, uv })?;
        let toward_viewer = if back { -DVec3::Z } else { DVec3::Z };
        let albedo = at.bsdf(scene, &wavelengths)?.albedo(toward_viewer);
        Some((albedo * irradiance * FRAC_1_PI + scene.emitted(&at, at.wo)).to_rgb(&wavelengths))
    };
    let sides = [false, true].into_iter().filter_map(of_side);
    sides.max_by(|a, b| a.iter().sum::<f32>().total_cmp(&b.iter().sum()))
}
