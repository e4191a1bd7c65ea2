//! Render requests of a page.

use std::collections::BTreeSet;

use glanz_sampling::SamplerKind;
use glanz_scene::description::{CameraDescription, FilmDescription};
use glanz_scene::{Camera, Description, SceneError};
use glanz_transport::{
    Aov, AovSet, Film, FilmError, FilmFormat, FilmSensor, Filter, FilterError, IntegratorError,
    IntegratorSettings, RenderSettings,
};
use serde::{Deserialize, Serialize};

use super::camera::{ViewCamera, ViewCameraError};

/// Largest side of a view in pixels; the page requests no more.
pub const MAX_SIDE: u32 = 4096;

/// Samples per pixel after which a view is done; a picture that still has visible noise then needs `glanz render`.
pub const MAX_SAMPLES: u32 = 4096;

/// The integrators that a page can choose from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum IntegratorName {
    /// Path tracing.
    #[default]
    Path,
    /// Path tracing guided by the learnt incident light.
    Guided,
}

impl IntegratorName {
    /// Its name in the table of integrators.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Guided => "guided",
        }
    }
}

/// A view to be rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderRequest {
    /// Its id, which all messages about it carry.
    pub id: u32,
    /// The camera.
    pub camera: ViewCamera,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Hidden leaves of the tree.
    pub hidden: BTreeSet<u32>,
    /// The integrator.
    pub integrator: IntegratorName,
    /// Whether noise is removed.
    pub denoise: bool,
}

/// Errors of a render request.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderRequestError {
    /// A size of 0 or beyond the limit.
    #[error("the picture has {0} x {1} pixels; its sides must be 1 to {MAX_SIDE}")]
    Size(u32, u32),
    /// An invalid camera.
    #[error(transparent)]
    Camera(#[from] ViewCameraError),
    /// A camera that the scene refuses, or an invalid scene after removing hidden leaves.
    #[error("{0}")]
    Scene(String),
    /// Settings of the scene that the integrator refuses.
    #[error(transparent)]
    Integrator(#[from] IntegratorError),
    /// An invalid filter.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// An invalid film, or too little memory for it.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// Removal of noise without a denoiser, with the reason.
    #[error("{0}")]
    Denoiser(String),
}

impl From<SceneError> for RenderRequestError {
    fn from(error: SceneError) -> Self {
        Self::Scene(error.kind.to_string())
    }
}

/// Everything that a render of the view needs, besides the scene.
#[derive(Clone, Debug)]
pub(crate) struct StreamPlan {
    pub(crate) camera: Camera,
    pub(crate) integrator: IntegratorSettings,
    pub(crate) settings: RenderSettings,
    pub(crate) format: FilmFormat,
}

impl RenderRequest {
    /// Number of pixels.
    pub(crate) fn pixels(&self) -> u64 {
        self.size.map(u64::from).iter().product()
    }

    /// Checks size and camera, which do not depend on the scene.
    ///
    /// # Errors
    /// [`RenderRequestError::Size`], [`RenderRequestError::Camera`].
    pub(crate) fn check(&self) -> Result<CameraDescription, RenderRequestError> {
        let [width, height] = self.size;
        if !self.size.iter().all(|side| (1..=MAX_SIDE).contains(side)) {
            return Err(RenderRequestError::Size(width, height));
        }
        Ok(self.camera.describe(self.size)?)
    }

    /// Plan of the request for a scene with this `description`: with its filter, seed and depth, and `threads`.
    ///
    /// # Errors
    /// [`RenderRequestError`].
    pub(crate) fn plan(
        &self,
        description: &Description,
        threads: usize,
    ) -> Result<StreamPlan, RenderRequestError> {
        let camera = self.check()?;
        let film = FilmDescription { resolution: self.size, ..FilmDescription::default() };
        let camera = Camera::try_new(&camera, &film)?;
        let mut integrator = description.integrator.clone();
        integrator.select(self.integrator.name());
        let integrator = IntegratorSettings::resolve(&integrator)?;
        let filter = Filter::try_new(&description.filter)?;
        let variance = AovSet::NONE.with(Aov::Variance);
        let aovs = match self.denoise {
            true => variance.with(Aov::Albedo).with(Aov::ShadingNormal),
            false => variance,
        };
        let format = FilmFormat {
            aovs,
            signed: filter.is_signed(),
            passes: integrator.is_guided(),
            ..FilmFormat::plain(self.size)
        };
        let settings = RenderSettings {
            filter,
            // The page has an exposure of its own.
            sensor: FilmSensor::default(),
            // Well distributed for every number of samples: the camera may move at any time.
            sampler: SamplerKind::Sobol,
            seed: description.sampler.seed,
            samples_per_pixel: MAX_SAMPLES,
            samples: 0..MAX_SAMPLES,
            threads,
            spectral: integrator.spectral,
            time_limit: None,
        };
        Ok(StreamPlan { camera, integrator, settings, format })
    }
}

impl StreamPlan {
    /// A film without samples.
    ///
    /// # Errors
    /// [`FilmError::Memory`].
    pub(crate) fn film(&self) -> Result<Film, FilmError> {
        Film::try_new(self.format)
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::ViewCameraKind;
    use super::*;

    fn request(size: [u32; 2]) -> RenderRequest {
        let camera = ViewCamera {
            kind: ViewCameraKind::Perspective,
            position: [0.0; 3],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 1.0, 0.0],
            forward: [0.0, 0.0, 1.0],
            field_of_view: Some(1.0),
            height: None,
            distance: None,
        };
        let (hidden, integrator) = (BTreeSet::new(), IntegratorName::Guided);
        RenderRequest { id: 1, camera, size, hidden, integrator, denoise: false }
    }

    #[test]
    fn sizes_are_bounded() {
        for size in [[1, 1], [4096, 4096], [4096, 1]] {
            assert!(request(size).check().is_ok(), "{size:?}");
        }
        for size in [[0, 5], [5, 0], [4097, 1], [1, 4097], [u32::MAX, u32::MAX]] {
            assert!(matches!(request(size).check(), Err(RenderRequestError::Size(..))), "{size:?}");
        }
    }

    #[test]
    fn plan_has_the_depth_and_seed_of_the_scene() {
        let mut description = Description::default();
        description.integrator.max_depth = Some(9);
        description.sampler.seed = 77;
        let plan = request([6, 4]).plan(&description, 3).unwrap();
        assert_eq!((plan.integrator.name(), plan.integrator.max_depth), ("guided", 9));
        assert_eq!((plan.settings.seed, plan.settings.threads), (77, 3));
        assert!(plan.format.passes && plan.format.resolution == [6, 4]);
    }

    #[test]
    fn only_a_denoised_view_records_albedo_and_normals() {
        let plan = |denoise| {
            let request = RenderRequest { denoise, ..request([6, 4]) };
            request.plan(&Description::default(), 3).unwrap().format.aovs
        };
        assert!(!plan(false).needs_first_hit());
        assert!([Aov::Albedo, Aov::ShadingNormal, Aov::Variance].iter().all(|aov| plan(true).contains(*aov)));
    }

    #[test]
    fn selected_integrator_does_not_take_the_branching_of_another() {
        let mut description = Description::default();
        description.integrator.name = "distributed".to_owned();
        description.integrator.branching = Some(4);
        let by_path = RenderRequest { integrator: IntegratorName::Path, ..request([6, 4]) };
        assert_eq!(by_path.plan(&description, 3).unwrap().integrator.branching, 1);
    }
}
