//! State of one sample for an integrator.

use glanz_light::{SampledWavelengths, Spectrum, Wavelengths};
use glanz_math::{DVec2, Ray};
use glanz_sampling::PixelSampler;
use glanz_scene::{CameraRay, Interaction, LightId, ParametricPoint, RayDifferential, Scene};

use super::irradiance::KnownLight;
use super::vertex::Vertex;
use crate::filter::Filter;
use crate::guide::{PathRecords, Training};
use crate::photon::PhotonMap;
use crate::pixel::{FirstHit, PixelSample};
use crate::pixel_rect::PixelRect;
use crate::sensor::FilmSensor;
use crate::splat::Splat;

/// Counts of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Rays traced for the closest hit.
    pub closest: u64,
    /// Rays traced for any hit.
    pub shadow: u64,
}

impl Counters {
    /// Number of rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.closest + self.shadow
    }

    /// Adds the counts of `other`.
    pub fn merge(&mut self, other: Self) {
        self.closest += other.closest;
        self.shadow += other.shadow;
    }
}

/// State of one sample for an integrator.
pub struct Context<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera ray; `None` if no light reaches the point of the film.
    pub camera_ray: Option<CameraRay>,
    /// The numbers of this sample; the camera uses the dimensions below [`FIRST_DIMENSION`].
    pub sampler: PixelSampler,
    /// Wavelengths of the spectra's lanes.
    pub wavelengths: Wavelengths,
    /// Counts of rays so far.
    pub counters: Counters,
    /// Training state of learning integrators.
    pub(crate) training: Option<&'a Training>,
    /// Photons of the sample.
    pub(crate) photons: Option<&'a PhotonMap>,
    /// Light that paths leave out.
    pub(super) known: Option<&'a KnownLight>,
    /// Memory that is reused by the next sample.
    pub(crate) records: PathRecords,
    /// Splats of the sample to other pixels.
    pub(crate) splats: Vec<Splat>,
    options: ContextOptions,
    first_hit: Option<FirstHit>,
}

/// The first dimension of the sampler for the integrator; those before are used for pixel and lens.
pub const FIRST_DIMENSION: u32 = 4;

/// The dimension for the wavelengths, which no integrator reaches.
const WAVELENGTH_DIMENSION: u32 = u32::MAX - 3;

/// Settings common to all samples of a render.
#[derive(Clone, Copy, Debug)]
pub struct ContextOptions {
    /// Whether [`Context::first_hit`] is needed.
    wants_first_hit: bool,
    /// Whether samples have wavelengths of their own.
    spectral: bool,
    splats: SplatWindow,
    sensor: FilmSensor,
}

/// The part of the film that receives splats.
#[derive(Clone, Copy, Debug, Default)]
struct SplatWindow {
    /// Smallest and largest coordinates, pixels.
    min: DVec2,
    max: DVec2,
    /// Number of light paths per sample of every pixel: the number of rendered pixels.
    samples: f64,
}

impl SplatWindow {
    fn contains(&self, film: DVec2) -> bool {
        film.cmpge(self.min).all() && film.cmple(self.max).all()
    }
}

impl ContextOptions {
    /// `wants_first_hit`: whether [`Context::first_hit`] is needed.
    #[must_use]
    pub fn new(wants_first_hit: bool) -> Self {
        let (splats, sensor) = (SplatWindow::default(), FilmSensor::default());
        Self { wants_first_hit, spectral: false, splats, sensor }
    }

    /// `spectral`: whether each sample carries light at wavelengths of its own instead of red, green and blue.
    #[must_use]
    pub fn with_spectral(self, spectral: bool) -> Self {
        Self { spectral, ..self }
    }

    /// The wavelengths of a sample.
    fn wavelengths(&self, mut sampler: PixelSampler) -> Wavelengths {
        if !self.spectral {
            return Wavelengths::Rgb;
        }
        sampler.skip_to_dimension(WAVELENGTH_DIMENSION);
        Wavelengths::Sampled(SampledWavelengths::sample(sampler.next_1d()))
    }

    /// Records the samples by this sensor.
    #[must_use]
    pub fn with_sensor(self, sensor: FilmSensor) -> Self {
        Self { sensor, ..self }
    }

    /// Enables splats for a film of the pixels `crop` with this filter.
    #[must_use]
    pub fn with_splats(self, crop: &PixelRect, filter: &Filter) -> Self {
        let corner = |pixel: [u32; 2]| DVec2::new(f64::from(pixel[0]), f64::from(pixel[1]));
        // The filter of a pixel is centred at its middle.
        let margin = filter.radius() - 0.5;
        let min = corner(crop.min) - margin;
        let max = corner(crop.min) + corner(crop.size) + margin;
        Self { splats: SplatWindow { min, max, samples: crop.len() as f64 }, ..self }
    }
}

impl<'a> Context<'a> {
    /// The state for one sample.
    #[must_use]
    pub fn new(
        scene: &'a Scene,
        camera_ray: Option<CameraRay>,
        sampler: PixelSampler,
        options: ContextOptions,
    ) -> Self {
        let (wavelengths, counters) = (options.wavelengths(sampler), Counters::default());
        let (training, photons, known, first_hit) = (None, None, None, None);
        let (records, splats) = (PathRecords::default(), Vec::new());
        Self {
            scene,
            camera_ray,
            sampler,
            wavelengths,
            counters,
            training,
            photons,
            known,
            records,
            splats,
            options,
            first_hit,
        }
    }

    /// For a pass that trains.
    pub(crate) fn with_training(self, training: Option<&'a Training>) -> Self {
        Self { training, ..self }
    }

    /// For samples with photons.
    pub(crate) fn with_photons(self, photons: Option<&'a PhotonMap>) -> Self {
        Self { photons, ..self }
    }

    /// For paths that leave out light.
    pub(super) fn with_known(self, known: Option<&'a KnownLight>) -> Self {
        Self { known, ..self }
    }

    /// The same for another sample.
    pub(crate) fn restart(&mut self, camera_ray: Option<CameraRay>, sampler: PixelSampler) {
        self.camera_ray = camera_ray;
        self.sampler = sampler;
        self.wavelengths = self.options.wavelengths(sampler);
        self.counters = Counters::default();
        self.first_hit = None;
    }

    /// The ray with which paths from the camera start.
    pub(super) fn start(&self) -> Option<Ray> {
        self.camera_ray.map(|camera| camera.ray)
    }

    /// Its differential, if textures are filtered.
    pub(super) fn start_differential(&self) -> Option<RayDifferential> {
        self.camera_ray.and_then(|camera| camera.differential)
    }

    /// The sample for the film; `light`: the radiance, `negative`: whether the filter is negative there.
    pub(crate) fn pixel_sample(&self, light: Spectrum, negative: bool) -> PixelSample {
        let index = self.sampler.sample_index();
        // Of realistic lenses alone; the others keep their bits in any case.
        let weighted = light * self.camera_ray.map_or(0.0, |camera| camera.weight as f32);
        let rgb = self.options.sensor.exposed(weighted.to_rgb(&self.wavelengths));
        PixelSample { index, rgb, negative, first_hit: self.first_hit }
    }

    /// Light of the light `id`, which the queries of the scene give in RGB, at the wavelengths of the sample.
    #[inline]
    pub(super) fn light_at(&self, id: LightId, rgb: Spectrum) -> Spectrum {
        self.scene.light_at(id, rgb, &self.wavelengths)
    }

    /// Light emitted by the surface at `hit` to where the ray came from.
    #[inline]
    pub(super) fn emitted(&self, hit: &Interaction) -> Spectrum {
        let light = hit.light();
        light.map_or(Spectrum::BLACK, |id| self.light_at(id, self.scene.emitted(hit, hit.wo)))
    }

    /// Radiance of the infinite light `id` along a ray that left the scene.
    #[inline]
    pub(super) fn infinite_radiance(&self, id: LightId, ray: &Ray) -> Spectrum {
        self.light_at(id, self.scene.infinite_radiance(id, ray))
    }

    /// As [`Scene::backdrop_radiance`].
    pub(super) fn backdrop_radiance(&self, ray: &Ray) -> Spectrum {
        self.scene.backdrop_radiance(ray, &self.wavelengths)
    }

    /// The closest hit on `ray`, with its parameters.
    pub fn intersect_parametric(
        &mut self,
        ray: &Ray,
        differential: Option<&RayDifferential>,
    ) -> Option<(Interaction, ParametricPoint)> {
        self.counters.closest += 1;
        self.scene.intersect_differential(ray, differential)
    }

    /// Whether nothing blocks light on `ray` for `0 < t < t_max`.
    pub fn is_free(&mut self, ray: &Ray, t_max: f64) -> bool {
        self.counters.shadow += 1;
        !self.scene.occluded(ray, t_max)
    }

    /// Number of light paths for one sample of every pixel, which is the number of pixels. 0 if the film
    /// takes no splats.
    pub(super) fn light_paths(&self) -> f64 {
        self.options.splats.samples
    }

    /// Whether light at the film point `film`, pixels, contributes to any pixel.
    pub(super) fn takes_splats_at(&self, film: DVec2) -> bool {
        self.scene.camera().film_points(film).any(|film| self.options.splats.contains(film))
    }

    /// Splats `light` to the film point `film`, pixels: the radiance that the path would contribute to a single pixel.
    /// `xi`: a number uniform in [0, 1).
    pub(super) fn splat(&mut self, film: DVec2, light: Spectrum, xi: f64) {
        let light = Spectrum::from_rgb(light.to_rgb(&self.wavelengths)) * (1.0 / self.light_paths()) as f32;
        let window = self.options.splats;
        let points = self.scene.camera().film_points(film).filter(|&film| window.contains(film));
        self.splats.extend(points.map(|film| Splat { film, light, xi }));
    }

    /// The first scattering surface on the camera ray.
    #[must_use]
    pub fn first_hit(&self) -> Option<FirstHit> {
        self.first_hit
    }

    /// Records the first scattering surface, if the camera sees it without scattering in a medium before; the first call counts.
    pub(super) fn note_first_hit(&mut self, vertex: &Vertex<'_>) {
        if self.options.wants_first_hit && self.first_hit.is_none() {
            let point = &vertex.at.point;
            self.first_hit = Some(FirstHit {
                position: point.position,
                normal: point.normal,
                shading_normal: point.shading_normal,
                uv: point.uv,
                // There may be interfaces in between, so the parameter of the last ray is not the whole distance.
                distance: self.start().map_or(0.0, |ray| (point.position - ray.origin).length()),
                object: vertex.at.id,
                albedo: vertex.rgb_albedo(self.scene, &self.wavelengths),
            });
        }
    }
}
