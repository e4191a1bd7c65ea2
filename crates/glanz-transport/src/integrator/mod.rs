//! Integrators: estimates of the radiance along camera rays.
//!
//! Every integrator has one file and one line in [`INTEGRATORS`]. They share [`Context`] (the scene, the numbers of the
//! sample, the counters), `vertex` (a point where light is scattered) and `path_tracer` (a path from the camera).

use std::fmt;
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_scene::Scene;
use glanz_scene::description::{GuideSettings, IntegratorDescription, PhotonSettings};

use crate::guide::{GridError, Guide};
use crate::photon::{PHOTON_LIMIT, PHOTON_RADII, PhotonTracer};

mod context;
mod distributed;
mod grid_guided;
mod guided;
mod irradiance;
mod light;
mod mirrors;
mod path;
mod path_state;
mod path_tracer;
mod sppm;
mod stored;
mod tracking;
mod vertex;
mod whitted;

pub use context::{Context, ContextOptions, Counters, FIRST_DIMENSION};
pub use distributed::Distributed;
pub use guided::Guided;
pub use irradiance::{IrradianceTracer, KnownLight};
pub use light::LightPaths;
pub use mirrors::SMALLEST_WEIGHT;
pub use path::Path;
pub(crate) use path_tracer::{INTERFACE_LIMIT, ROULETTE_FROM};
pub use sppm::Sppm;
pub use stored::{Stored, StoredLight};
pub(crate) use vertex::{ScatteredRay, Vertex, pass_interface, roulette};
pub use whitted::Whitted;

/// Estimator of the radiance along camera rays.
pub trait Integrator: Send + Sync {
    /// An estimate of the radiance that arrives along [`Context::camera_ray`].
    ///
    /// The estimate depends on the ray, the scene, the numbers of the sampler, the photons of the sample number and, for learning integrators, the film's training alone.
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum;

    /// Estimates for many samples, the same as one by one. `contexts`: of one scene, one training and the photons of one sample number; `radiance` is replaced.
    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        radiance.clear();
        radiance.extend(contexts.iter_mut().map(|context| self.radiance(context)));
    }

    /// Number of samples with which [`Integrator::radiance_batch`] is fastest; 1 if it takes them one by one.
    fn batch(&self) -> usize {
        1
    }

    /// Whether it learns from earlier passes. If so, samples must be taken in order, into a film with
    /// [`FilmFormat::passes`](crate::FilmFormat::passes).
    fn learns(&self) -> bool {
        false
    }

    /// Whether it splats to pixels other than that of the sample. If so, it needs a film with
    /// [`FilmFormat::splats`](crate::FilmFormat::splats).
    fn splats(&self) -> bool {
        false
    }

    /// The tracer of its photons for a picture of `resolution` pixels; `None` without photons. The photons of a sample number must be in the contexts of these samples.
    fn photon_tracer(&self, scene: &Scene, seed: u64, resolution: [u32; 2]) -> Option<PhotonTracer> {
        let _ = (scene, seed, resolution);
        None
    }

    /// An untrained guide for `scene`, of the kind that the integrator trains.
    ///
    /// # Errors
    /// [`GridError`] if a grid cannot be built.
    fn new_guide(&self, scene: &Scene) -> Result<Guide, GridError> {
        Guide::new(scene, &GuideSettings::Tree)
    }
}

/// [`Integrator::radiance`] of an integrator that works in batches.
fn radiance_of_one(integrator: &impl Integrator, context: &mut Context<'_>) -> Spectrum {
    let mut radiance = Vec::new();
    integrator.radiance_batch(std::slice::from_mut(context), &mut radiance);
    radiance.first().copied().unwrap_or(Spectrum::BLACK)
}

/// An integrator of this crate.
#[derive(Debug)]
pub struct IntegratorEntry {
    /// Its name in scene files and on the command line.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    /// Default for the largest number of scattering events of a path.
    pub default_max_depth: u32,
    /// Default for [`IntegratorSettings::branching`]; `None` if it is not used.
    pub default_branching: Option<u32>,
    /// Whether it uses [`IntegratorSettings::light_sampling`].
    pub light_sampling_is_optional: bool,
    /// Whether it uses a [`Guide`].
    pub guided: bool,
    /// Whether it sees participating media; others treat them as empty space.
    pub sees_media: bool,
    build: fn(&IntegratorSettings) -> Box<dyn Integrator>,
}

/// The integrator with photons.
const SPPM: &str = "sppm";

/// The integrator that shows stored light.
const RADIOSITY: &str = "radiosity";

/// Table of integrators.
///
/// The default depth is that of pbrt, on which its scenes rely.
pub static INTEGRATORS: [IntegratorEntry; 7] = [
    IntegratorEntry {
        name: "path",
        description: "unidirectional path tracing with light sampling and multiple importance sampling",
        default_max_depth: 5,
        default_branching: Some(1),
        light_sampling_is_optional: true,
        guided: false,
        sees_media: true,
        build: |settings| Box::new(Path::new(settings)),
    },
    IntegratorEntry {
        name: "light",
        description: "paths from the lights and from the camera combined: caustics of mirrors and glass",
        default_max_depth: 5,
        default_branching: None,
        light_sampling_is_optional: false,
        guided: false,
        sees_media: false,
        build: |settings| Box::new(LightPaths::new(settings)),
    },
    IntegratorEntry {
        name: SPPM,
        description: "path tracing with photons: caustics that are seen by mirror or glass",
        default_max_depth: 5,
        default_branching: None,
        light_sampling_is_optional: false,
        guided: false,
        sees_media: true,
        build: |settings| Box::new(Sppm::new(settings)),
    },
    IntegratorEntry {
        name: "guided",
        description: "path tracing that learns where light comes from (document 003 chapter 3)",
        default_max_depth: 5,
        default_branching: None,
        light_sampling_is_optional: true,
        guided: true,
        sees_media: true,
        build: |settings| Box::new(Guided::new(settings)),
    },
    IntegratorEntry {
        name: "distributed",
        description: "several rays from the first scattering surface (document 003 section 3.1.1)",
        default_max_depth: 5,
        default_branching: Some(8),
        light_sampling_is_optional: true,
        guided: false,
        sees_media: false,
        build: |settings| Box::new(Distributed::new(settings)),
    },
    IntegratorEntry {
        name: "whitted",
        description: "classical ray tracing: Phong shading, shadows, mirrors, refraction (document 001)",
        default_max_depth: 5,
        default_branching: None,
        light_sampling_is_optional: false,
        guided: false,
        sees_media: false,
        build: |settings| Box::new(Whitted::new(settings)),
    },
    IntegratorEntry {
        name: RADIOSITY,
        description: "light stored on surfaces, the same from everywhere, and mirrors (document 003 section 5.7.3)",
        default_max_depth: 5,
        default_branching: None,
        light_sampling_is_optional: false,
        guided: false,
        sees_media: false,
        build: |settings| Box::new(Stored::new(settings, None)),
    },
];

/// Largest depth: between perfect mirrors every path reaches its limit.
pub const DEPTH_LIMIT: u32 = 1 << 16;

/// Largest number of rays from the first rough surface. A thread holds the states of all of them, some hundred bytes each.
pub const BRANCHING_LIMIT: u32 = 1 << 16;

/// Errors of resolving an integrator's description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegratorError {
    /// A name that is not in the table.
    #[error("there is no integrator \"{name}\" (there are {known})")]
    Unknown {
        /// The name.
        name: String,
        /// The known names.
        known: String,
    },
    /// A depth beyond [`DEPTH_LIMIT`].
    #[error("a depth of {0} is more than {DEPTH_LIMIT}")]
    Depth(u32),
    /// No branches or more than [`BRANCHING_LIMIT`].
    #[error("a branching of {0} is not between 1 and {BRANCHING_LIMIT}")]
    Branching(u32),
    /// A radius of photons outside its range.
    #[error("a radius of photons of {0} m is not between 1e-9 and 1e9")]
    Radius(f64),
    /// No photons or more than [`PHOTON_LIMIT`].
    #[error("a number of photons of {0} is not between 1 and {PHOTON_LIMIT}")]
    Photons(u32),
}

/// An integrator with all settings; those that it does not use have fixed values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorSettings {
    name: &'static str,
    /// Largest number of scattering events of a path: 0 shows lights alone, 1 direct light, 2 light scattered twice.
    pub max_depth: u32,
    /// Whether lights are sampled at every hit; otherwise they are found by BSDF sampling alone.
    pub light_sampling: bool,
    /// Number of rays from the first rough surface or scattering point in a medium on the way of a camera ray, from 1 to [`BRANCHING_LIMIT`].
    pub branching: u32,
    /// The kind of guide to train.
    pub guide: GuideSettings,
    /// The photons.
    pub photons: PhotonSettings,
    /// Whether each sample carries light at wavelengths of its own instead of red, green and blue.
    pub spectral: bool,
}

impl IntegratorSettings {
    /// The settings of `description`, with defaults.
    ///
    /// # Errors
    /// [`IntegratorError`] if the name is unknown or a number out of range.
    pub fn resolve(description: &IntegratorDescription) -> Result<Self, IntegratorError> {
        let name = &description.name;
        let Some(entry) = INTEGRATORS.iter().find(|e| e.name == name) else {
            let known: Vec<_> = INTEGRATORS.iter().map(|e| e.name).collect();
            return Err(IntegratorError::Unknown { name: name.clone(), known: known.join(", ") });
        };
        let max_depth = description.max_depth.unwrap_or(entry.default_max_depth);
        if max_depth > DEPTH_LIMIT {
            return Err(IntegratorError::Depth(max_depth));
        }
        let branching = match entry.default_branching {
            Some(default) => description.branching.unwrap_or(default),
            None => 1,
        };
        if branching == 0 || branching > BRANCHING_LIMIT {
            return Err(IntegratorError::Branching(branching));
        }
        let light_sampling = description.light_sampling || !entry.light_sampling_is_optional;
        let guide = if entry.guided { description.guide } else { GuideSettings::Tree };
        let photons = if entry.name == SPPM { description.photons } else { PhotonSettings::default() };
        match photons {
            PhotonSettings { radius: Some(radius), .. } if !PHOTON_RADII.contains(&radius) => {
                return Err(IntegratorError::Radius(radius));
            }
            PhotonSettings { count: Some(count), .. } if count == 0 || count > PHOTON_LIMIT => {
                return Err(IntegratorError::Photons(count));
            }
            _ => {}
        }
        let spectral = description.spectral;
        Ok(Self { name: entry.name, max_depth, light_sampling, branching, guide, photons, spectral })
    }

    /// The settings from the parts of earlier ones.
    ///
    /// `name`: output of [`IntegratorSettings::full_name`].
    pub(crate) fn by_name(
        name: &str,
        max_depth: u32,
        [light_sampling, spectral]: [bool; 2],
        branching: u32,
    ) -> Option<Self> {
        let (mut guide, mut photons) = (GuideSettings::Tree, PhotonSettings::default());
        let name = match name.split_once(' ') {
            Some((SPPM, settings)) => {
                photons = settings.parse().ok()?;
                SPPM
            }
            Some((name, settings)) => {
                guide = settings.parse().ok()?;
                name
            }
            None => name,
        };
        let description = IntegratorDescription {
            name: name.to_owned(),
            max_depth: Some(max_depth),
            light_sampling,
            branching: Some(branching),
            guide,
            photons,
            spectral,
            location: None,
        };
        Self::resolve(&description).ok()
    }

    /// The name of the integrator.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The name, followed by a space and the guide or the photons unless they are the default.
    pub(crate) fn full_name(&self) -> String {
        match &self.guide {
            grid @ GuideSettings::Grid(_) => format!("{} {grid}", self.name),
            GuideSettings::Tree if self.photons != PhotonSettings::default() => {
                format!("{} {}", self.name, self.photons)
            }
            GuideSettings::Tree => self.name.to_owned(),
        }
    }

    /// Whether the integrator uses a [`Guide`].
    #[must_use]
    pub fn is_guided(&self) -> bool {
        INTEGRATORS.iter().any(|entry| entry.name == self.name && entry.guided)
    }

    /// Whether the integrator has photons, in scenes without participating media and with red, green and blue light.
    #[must_use]
    pub fn has_photons(&self) -> bool {
        self.name == SPPM
    }

    /// Whether the integrator sees participating media.
    #[must_use]
    pub fn sees_media(&self) -> bool {
        INTEGRATORS.iter().any(|entry| entry.name == self.name && entry.sees_media)
    }

    /// The integrator with a fixed guide; `guide` is ignored by those that are not
    /// [guided](IntegratorSettings::is_guided).
    #[must_use]
    pub fn build_with_guide(&self, guide: Arc<Guide>) -> Box<dyn Integrator> {
        if self.is_guided() { Box::new(Guided::with_guide(self, guide)) } else { self.build() }
    }

    /// Whether the integrator shows [`StoredLight`].
    #[must_use]
    pub fn shows_stored_light(&self) -> bool {
        self.name == RADIOSITY
    }

    /// The integrator with stored light; `light` is ignored by those that do not
    /// [show it](IntegratorSettings::shows_stored_light).
    #[must_use]
    pub fn build_with_light(&self, light: Arc<dyn StoredLight>) -> Box<dyn Integrator> {
        if self.shows_stored_light() { Box::new(Stored::new(self, Some(light))) } else { self.build() }
    }

    /// The integrator.
    #[must_use]
    pub fn build(&self) -> Box<dyn Integrator> {
        match INTEGRATORS.iter().find(|e| e.name == self.name) {
            Some(entry) => (entry.build)(self),
            // Names come from the table alone.
            None => Box::new(Path::new(self)),
        }
    }
}

impl fmt::Display for IntegratorSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lights = if self.light_sampling { "sampled" } else { "not sampled" };
        write!(f, "{} (depth {}, branching {}, lights {lights}", self.name, self.max_depth, self.branching)?;
        if self.spectral {
            f.write_str(", spectral")?;
        }
        match &self.guide {
            GuideSettings::Tree if self.photons != PhotonSettings::default() => {
                write!(f, ", {})", self.photons)
            }
            GuideSettings::Tree => f.write_str(")"),
            grid @ GuideSettings::Grid(_) => write!(f, ", {grid})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description(name: &str) -> IntegratorDescription {
        IntegratorDescription { name: name.to_owned(), ..IntegratorDescription::default() }
    }

    #[test]
    fn every_integrator_of_the_table_can_be_built() {
        for entry in &INTEGRATORS {
            let settings = IntegratorSettings::resolve(&description(entry.name)).unwrap();
            assert_eq!(settings.name(), entry.name);
            assert_eq!(settings.max_depth, entry.default_max_depth);
            let _ = settings.build();
        }
    }

    #[test]
    fn unknown_names_and_numbers_out_of_range_are_refused() {
        let error = IntegratorSettings::resolve(&description("mlt")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "there is no integrator \"mlt\" (there are path, light, sppm, guided, distributed, whitted, radiosity)"
        );
        let deep = IntegratorDescription { max_depth: Some(100_000), ..description("path") };
        assert_eq!(IntegratorSettings::resolve(&deep), Err(IntegratorError::Depth(100_000)));
        let bare = IntegratorDescription { branching: Some(0), ..description("distributed") };
        assert_eq!(IntegratorSettings::resolve(&bare), Err(IntegratorError::Branching(0)));
        let with = |photons| IntegratorDescription { photons, ..description("sppm") };
        let flat = with(PhotonSettings { radius: Some(0.0), count: None });
        assert_eq!(IntegratorSettings::resolve(&flat), Err(IntegratorError::Radius(0.0)));
        let empty = with(PhotonSettings { radius: None, count: Some(0) });
        assert_eq!(IntegratorSettings::resolve(&empty), Err(IntegratorError::Photons(0)));
    }

    #[test]
    fn name_with_settings_is_read_back() {
        for photons in [PhotonSettings::default(), PhotonSettings { radius: Some(1.0 / 3.0), count: Some(9) }]
        {
            let settings =
                IntegratorSettings::resolve(&IntegratorDescription { photons, ..description("sppm") })
                    .unwrap();
            assert_eq!(
                IntegratorSettings::by_name(&settings.full_name(), 5, [true, false], 1),
                Some(settings)
            );
        }
    }

    #[test]
    fn unused_settings_do_not_change_the_identity() {
        let plain = IntegratorSettings::resolve(&description("whitted")).unwrap();
        let odd =
            IntegratorDescription { branching: Some(7), light_sampling: false, ..description("whitted") };
        assert_eq!(IntegratorSettings::resolve(&odd), Ok(plain));
    }
}
