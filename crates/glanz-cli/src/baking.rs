//! Light on the surfaces of a scene, with progress.

use std::path::Path;
use std::sync::Arc;

use glanz_job::CancelFlag;
use glanz_light::Spectrum;
use glanz_radiosity::bake::{BakeError, BakeSettings, BakeState, LightMap, LightMaps, resume};
use glanz_radiosity::elements::{ElementSettings, Elements};
use glanz_scene::{Place, Scene};
use glanz_transport::StoredLight;

use crate::light_file::{Keeper, LightFile};
use crate::messages::{Failure, Messages};
use crate::report::plural;
use crate::saving::{SaveState, SavingProgress};
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

/// Bakes with so many threads from now on; with one for each processor if nothing is said.
///
/// # Errors
/// Threads that cannot be started.
pub(crate) fn use_threads(threads: Option<u16>) -> Result<(), Failure> {
    let Some(threads) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
    pool.build_global().map_err(|error| Failure::new(format!("cannot start threads: {error}")))
}

/// The light of a scene for pictures, `given` in a file or made here; `None` if the user wanted an end.
///
/// # Errors
/// Why there is none.
pub(crate) fn stored(
    scene: &Scene,
    given: Option<(&Path, &LightFile)>,
    file: &mut SceneFile,
    messages: Messages,
    cancel: &CancelFlag,
) -> Result<Option<Arc<dyn StoredLight>>, Failure> {
    let settings = BakeSettings::default();
    let elements = elements(scene, settings.density, file, messages)?;
    let maps = match given {
        Some((path, light)) => Some(light.maps(path, &elements)?),
        None => baked(BakeState::default(), &elements, &settings, None, messages, cancel)?,
    };
    let Some(maps) = maps else { return Ok(None) };
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
    let elements = divided(scene, density)?;
    let others = scene.materials().iter().filter(|material| !material.is_diffuse()).count();
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

/// The elements of a scene for light maps of a density, texels per metre.
///
/// # Errors
/// Why there are none.
pub(crate) fn divided(scene: &Scene, density: f64) -> Result<Elements<'_>, Failure> {
    let diagonal = scene.bounds().diagonal().length();
    let side = if diagonal > 0.0 { SIDE.min(SIDE_OF_SCENE * diagonal) } else { SIDE };
    let not_divided = |error| Failure::new(format!("the scene cannot be divided: {error}"));
    let mut elements = Elements::new(scene, &ElementSettings { side }).map_err(not_divided)?;
    if density.is_finite() {
        elements.cut_at_walls(density).map_err(not_divided)?;
    }
    Ok(elements)
}

/// The light maps, from what was found before; `None` if the user wanted an end. `keeper`: keeps what is found, now and then and in the end.
///
/// # Errors
/// Why there are none, or why what was found cannot be kept.
pub(crate) fn baked(
    state: BakeState,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    keeper: Option<&Keeper<'_>>,
    messages: Messages,
    cancel: &CancelFlag,
) -> Result<Option<Vec<LightMap>>, Failure> {
    let save =
        keeper.map(|keeper| -> SaveState<'_, BakeState> { Box::new(|state| keeper.keep_state(state)) });
    let mut sink = SavingProgress::start(save, cancel, messages);
    let outcome = resume(state, elements, None, settings, &mut sink, cancel);
    let saved = sink.finish();
    match outcome {
        Ok(maps) => {
            // Before anything else is written: it is what cannot be had again.
            keeper.map_or(Ok(()), |keeper| keeper.keep(&maps))?;
            Ok(Some(maps))
        }
        Err(BakeError::Interrupted(_)) => saved.map(|()| None),
        Err(error @ BakeError::TooMany(..)) => {
            Err(Failure::new(error.to_string()).with_help("choose fewer with --texels-per-metre"))
        }
        Err(error) => Err(Failure::new(error.to_string())),
    }
}
