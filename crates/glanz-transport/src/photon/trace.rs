//! Tracing of photons.

use std::ops::Range;

use glanz_job::Interrupted;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::{BatchedPath, Interaction, Light, LightId, LightRay, Scene, SceneHit};
use glanz_shading::Material;
use rayon::prelude::*;

use super::Photon;
use super::emission::{EmissionDensity, EmissionNumbers};
use crate::integrator::{Counters, ROULETTE_FROM, Vertex, pass_interface, roulette};

/// Paths that are traced together.
const BATCH: u32 = 1024;

/// Dimensions of the sampler before the first event: direction and position on the light in one group, the selection of the light in the next.
const EMISSION_DIMENSION: u32 = 4;
const SELECTION_DIMENSION: u32 = EMISSION_DIMENSION + 4;
const FIRST_EVENT_DIMENSION: u32 = SELECTION_DIMENSION + 4;

/// Dimensions per event: direction, lobe, survival.
const DIMENSIONS_PER_EVENT: u32 = 4;

/// A row of samplers for no pixel.
const PHOTON_ROW: u32 = u32::MAX;

/// A photon where it arrives.
#[derive(Clone, Copy, Debug)]
pub(super) struct PhotonArrival {
    /// Number of its path.
    pub(super) path: u32,
    /// World space, metres.
    pub(super) position: DVec3,
    pub(super) photon: Photon,
}

/// What the photon paths of a sample share.
pub(super) struct PhotonPass<'a> {
    scene: &'a Scene,
    density: Option<&'a EmissionDensity>,
    wavelengths: Wavelengths,
    /// Number of paths.
    paths: u32,
    /// Largest number of scattering events before a photon is seen.
    max_events: u32,
    /// The sampler of the path 0.
    first: PixelSampler,
}

impl<'a> PhotonPass<'a> {
    /// The paths of the sample number `sample`. `max_depth`: largest number of scattering events of a whole path.
    pub(super) fn new(
        scene: &'a Scene,
        density: Option<&'a EmissionDensity>,
        max_depth: u32,
        seed: u64,
        [sample, paths]: [u32; 2],
    ) -> Self {
        let first = PixelSampler::new(SamplerKind::Sobol, 1, seed, [sample, PHOTON_ROW], 0);
        // The last event is that at which the photon is seen.
        let max_events = max_depth.saturating_sub(1);
        Self { scene, density, wavelengths: Wavelengths::default(), paths, max_events, first }
    }

    /// The arrivals in the order of paths, and the rays traced. `is_stopped`: asked before every batch of a thousand paths.
    ///
    /// # Errors
    /// [`Interrupted`] if `is_stopped`.
    pub(super) fn trace(
        &self,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<(Vec<PhotonArrival>, Counters), Interrupted> {
        let paths = if self.max_events > 0 { self.paths } else { 0 };
        let batches = (0..paths.div_ceil(BATCH))
            .into_par_iter()
            .map(|i| {
                if is_stopped() {
                    return Err(Interrupted);
                }
                let mut batch =
                    PhotonBatch { pass: self, counters: Counters::default(), arrivals: Vec::new() };
                batch.trace(i * BATCH..paths.min((i + 1) * BATCH));
                Ok((batch.arrivals, batch.counters))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut counters = Counters::default();
        let mut all = Vec::with_capacity(batches.iter().map(|(arrivals, _)| arrivals.len()).sum());
        for (arrivals, traced) in batches {
            all.extend(arrivals);
            counters.merge(traced);
        }
        Ok((all, counters))
    }

    /// The numbers by which the path `number` leaves its light, and their density.
    pub(super) fn numbers(&self, number: u32) -> (EmissionNumbers, f64) {
        let [x, y, u, v] = self.sampler(number, EMISSION_DIMENSION).next_group();
        let [selection, xi, ..] = self.sampler(number, SELECTION_DIMENSION).next_group();
        let uniform = EmissionNumbers { direction: DVec2::new(x, y), place: DVec2::new(u, v), selection };
        self.density.map_or((uniform, 1.0), |density| density.sample(uniform, xi))
    }

    /// The sampler of a path, continued at `dimension`.
    fn sampler(&self, path: u32, dimension: u32) -> PixelSampler {
        let mut sampler = self.first.with_index(path);
        sampler.skip_to_dimension(dimension);
        sampler
    }
}

/// Photon paths that are traced together.
struct PhotonBatch<'a> {
    pass: &'a PhotonPass<'a>,
    counters: Counters,
    arrivals: Vec<PhotonArrival>,
}

impl PhotonBatch<'_> {
    /// Traces the paths of a range.
    fn trace(&mut self, range: Range<u32>) {
        let pass = self.pass;
        let mut paths: Vec<_> = range.filter_map(|number| PhotonPath::new(pass, number)).collect();
        pass.scene.trace_paths(&mut paths, self);
        // Stable: arrivals of a path keep their order.
        self.arrivals.sort_by_key(|arrival| arrival.path);
    }
}

/// State of a photon path.
struct PhotonPath {
    number: u32,
    id: LightId,
    /// Probability of selecting the light.
    probability: f64,
    light: LightRay,
    /// `None` if it has ended.
    ray: Option<Ray>,
    flux: Spectrum,
    /// Factor on the flux since the light.
    left: Spectrum,
    emission: f64,
    events: u32,
    interfaces: u32,
}

impl PhotonPath {
    /// `None` where there is nothing to trace.
    fn new(pass: &PhotonPass<'_>, number: u32) -> Option<Self> {
        let (EmissionNumbers { direction, place, selection }, density) = pass.numbers(number);
        let (id, probability) = pass.scene.select_emitter(selection)?;
        let light = pass.scene.emit(id, place, direction)?;
        (probability > 0.0).then(|| Self {
            number,
            id,
            probability,
            light,
            ray: Some(light.ray),
            flux: light.power * (1.0 / (probability * density)) as f32,
            left: Spectrum::one(&pass.wavelengths),
            emission: 0.0,
            events: 0,
            interfaces: 0,
        })
    }

    /// Stores the photon at a scattering surface, and continues from the hit of `ray` along delta lobes; `None` if the path ends.
    fn next_ray(&mut self, batch: &mut PhotonBatch<'_>, ray: &Ray, found: &SceneHit) -> Option<Ray> {
        let pass = batch.pass;
        let scene = pass.scene;
        let material = scene.hit_material(found);
        if material.absorbs_all() {
            return None;
        }
        let is_mixture = matches!(material, Material::Mix(_));
        let hit = scene.interaction(ray, found);
        let bsdf = hit.bsdf(scene, &pass.wavelengths);
        // The path from the camera selects a part of a mixture: selected here as well, its probability would count twice.
        if self.events > 0 && (is_mixture || bsdf.as_ref().is_some_and(|bsdf| !bsdf.is_delta())) {
            let photon = self.photon(&hit, pass.paths, scene.hit_opacity(ray, found));
            batch.arrivals.push(PhotonArrival { path: self.number, position: hit.point.position, photon });
        }
        let Some(bsdf) = bsdf else {
            return pass_interface(&hit, ray.direction, &mut self.interfaces);
        };
        self.interfaces = 0;
        let vertex = Vertex::new(&hit, bsdf);
        if self.events == 0 {
            let distance = (hit.point.position - self.light.ray.origin).length();
            self.flux *= self.light.range.attenuation(distance);
            self.emission = self.emission_at(scene, hit.point.position, hit.wo);
        }
        if self.events == pass.max_events {
            return None;
        }
        let dimension = FIRST_EVENT_DIMENSION + DIMENSIONS_PER_EVENT.wrapping_mul(self.events);
        let [x, y, xi_lobe, xi_roulette] = pass.sampler(self.number, dimension).next_group();
        let scattered = vertex.sample_flux(DVec2::new(x, y), xi_lobe)?;
        // No path from the camera takes a direction for which the shading normal turns.
        if !scattered.is_delta || !vertex.is_seen_alike(scattered.direction) {
            return None;
        }
        self.events += 1;
        self.flux *= scattered.weight;
        self.left *= scattered.weight;
        if self.events >= ROULETTE_FROM {
            let factor = roulette(self.left, xi_roulette)?;
            self.flux *= factor;
            self.left *= factor;
        }
        Some(hit.spawn(scattered.direction))
    }

    /// Density of emission at the first hit, with the probability of the light; infinite for lights that no ray can hit.
    fn emission_at(&self, scene: &Scene, at: DVec3, to_light: DVec3) -> f64 {
        if !scene.light(self.id).is_some_and(Light::can_be_hit) {
            return f64::INFINITY;
        }
        self.probability * scene.emission_pdf(self.id, at, to_light, self.light.area_pdf())
    }

    /// The photon at a point of a surface with this `opacity`.
    fn photon(&self, at: &Interaction, paths: u32, opacity: f64) -> Photon {
        Photon {
            from: at.wo.as_vec3(),
            normal: at.point.normal.as_vec3(),
            // The path from the camera is stopped here with this probability, too.
            flux: self.flux * (1.0 / (f64::from(paths) * opacity)) as f32,
            emission: self.emission as f32,
            events: self.events,
        }
    }
}

impl BatchedPath<PhotonBatch<'_>> for PhotonPath {
    fn ray(&self) -> Option<Ray> {
        self.ray
    }

    fn advance(&mut self, batch: &mut PhotonBatch<'_>, hit: Option<&SceneHit>, _: &mut Vec<Self>) {
        batch.counters.closest += 1;
        self.ray = self.ray.take().zip(hit).and_then(|(ray, hit)| self.next_ray(batch, &ray, hit));
    }
}
