//! Light on the surfaces of a scene, with progress.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glanz_light::Spectrum;
use glanz_radiosity::bake::{BakeError, BakeSettings, LightMap, LightMaps, Stage, bake};
use glanz_radiosity::elements::{ElementSettings, Elements};
use glanz_scene::{Place, Scene};
use glanz_shading::Material;
use glanz_transport::StoredLight;

use crate::interrupt::Interrupt;
use crate::messages::{Failure, Messages};
use crate::progress::Progress;
use crate::report::plural;
use crate::scene_file::SceneFile;

/// Largest side of an element: metres, and per the diagonal of the scene.
const SIDE: f64 = 0.3;
const SIDE_OF_SCENE: f64 = 1.0 / 24.0;

/// Light maps as a picture asks them.
#[derive(Debug)]
struct Stored(LightMaps);

impl StoredLight for Stored {
    fn irradiance(&self, place: &Place) -> Option<Spectrum> {
        self.0.irradiance(place)
    }
}

/// The light of a scene for pictures; `None` if the user wanted an end.
///
/// # Errors
/// Why there is none.
pub(crate) fn stored(
    scene: &Scene,
    file: &mut SceneFile,
    messages: Messages,
    interrupt: &Interrupt,
) -> Result<Option<Arc<dyn StoredLight>>, Failure> {
    let settings = BakeSettings::default();
    let elements = elements(scene, settings.density, file, messages)?;
    let Some(maps) = baked(&elements, &settings, messages, interrupt)? else {
        return Ok(None);
    };
    Ok(Some(Arc::new(Stored(LightMaps::new(&elements, maps)))))
}

/// The elements of a scene for light maps of a density, texels per metre; says what is not as in a picture by path tracing.
///
/// # Errors
/// Why there are none.
pub(crate) fn elements<'a>(
    scene: &'a Scene,
    density: f64,
    file: &mut SceneFile,
    messages: Messages,
) -> Result<Elements<'a>, Failure> {
    let diagonal = scene.bounds().diagonal().length();
    let side = if diagonal > 0.0 { SIDE.min(SIDE_OF_SCENE * diagonal) } else { SIDE };
    let not_divided = |error| Failure::new(format!("the scene cannot be divided: {error}"));
    let mut elements = Elements::new(scene, &ElementSettings { side }).map_err(not_divided)?;
    if density.is_finite() {
        elements.cut_at_walls(density).map_err(not_divided)?;
    }
    let is_diffuse =
        |material: &&Material| matches!(material, Material::Diffuse { .. } | Material::Interface);
    let others = scene.materials().iter().filter(|material| !is_diffuse(material)).count();
    if others > 0 {
        let materials = plural(others as u64, "material is", "materials are");
        file.warn(
            &format!("{materials} not diffuse; what they reflect or pass counts as reflected diffusely"),
            messages,
        );
    }
    if elements.left_out > 0 {
        let surfaces = plural(elements.left_out as u64, "surface has", "surfaces have");
        file.warn(
            &format!("{surfaces} no parameters or no end: such throw shadows, but carry no light"),
            messages,
        );
    }
    Ok(elements)
}

/// The light maps; `None` if the user wanted an end.
///
/// # Errors
/// Why there are none.
pub(crate) fn baked(
    elements: &Elements<'_>,
    settings: &BakeSettings,
    messages: Messages,
    interrupt: &Interrupt,
) -> Result<Option<Vec<LightMap>>, Failure> {
    let mut progress = Progress::start(messages);
    let mut begun = (Stage::Direct, Instant::now());
    let outcome = bake(elements, None, settings, &mut |stage, fraction| {
        if stage != begun.0 {
            begun = (stage, Instant::now());
        }
        let what = match stage {
            Stage::Direct => "1 of 3: light from lamps",
            Stage::Between => "2 of 3: light between surfaces",
            Stage::Gather => "3 of 3: indirect light",
        };
        let passed = begun.1.elapsed().as_secs_f64();
        let left = if fraction > 0.0 { passed * (1.0 - fraction) / fraction } else { 0.0 };
        let left = Duration::try_from_secs_f64(left).unwrap_or_default();
        progress.show(fraction, left, what);
        !interrupt.is_raised()
    });
    progress.finish();
    match outcome {
        Ok(maps) => Ok(Some(maps)),
        Err(BakeError::Stopped) => Ok(None),
        Err(error @ BakeError::TooMany(..)) => {
            Err(Failure::new(error.to_string()).with_help("choose fewer with --texels-per-metre"))
        }
        Err(error) => Err(Failure::new(error.to_string())),
    }
}
