//! Light maps for the integrator `radiosity`.

use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_radiosity::bake::{BakeSettings, BakeState, LightMaps};
use glanz_scene::{ParametricPoint, Scene};
use glanz_transport::StoredLight;

use crate::bake::{LightFile, baked_maps, elements};
use crate::error::Error;
use crate::running_job::RunningJob;

/// Light maps in the form that the integrator queries.
#[derive(Debug)]
struct StoredMaps(LightMaps);

impl StoredLight for StoredMaps {
    fn irradiance(&self, place: &ParametricPoint) -> Option<Spectrum> {
        self.0.irradiance(place)
    }
}

/// The light of a scene, read from a file or baked.
pub(super) fn stored_light(
    scene: &Scene,
    file: Option<&LightFile>,
    job: &mut RunningJob<'_>,
) -> Result<Arc<dyn StoredLight>, Error> {
    let settings = BakeSettings::default();
    let maps = job.in_pool(|job| {
        let elements = elements(scene, &settings, job)?;
        let maps = match file {
            Some(file) => file.maps(&elements)?,
            None => baked_maps(BakeState::default(), &elements, &settings, None, job)?,
        };
        Ok(LightMaps::new(&elements, maps))
    })?;
    Ok(Arc::new(StoredMaps(maps)))
}
