//! Points on the charts of light maps, with their irradiance by paths.

use std::f64::consts::PI;

use glanz::light::{Spectrum, Wavelengths};
use glanz::math::{DVec2, DVec3, Frame};
use glanz::radiosity::bake::LightMap;
use glanz::sampling::{PixelSampler, SamplerKind, mis, warp};
use glanz::scene::description::IntegratorDescription;
use glanz::scene::{
    CameraRay, LightId, LightSampleContext, ParametricPoint, PlacedPoint, PlacedSurface, Scene,
};
use glanz::transport::{Context, ContextOptions, Integrator, IntegratorSettings};

/// Independent estimates of the irradiance at a point, the spread of which is its standard error.
const REPLICATES: u32 = 16;

/// Samples of each replicate before the first test of their spread.
const FIRST_SAMPLES: u32 = 16;

/// Paths of a point none of which has found light, after which it counts as one that no light reaches: light that one path in a thousand
/// finds is missed by all of them with a probability of 2 %.
const DARK_SAMPLES: u32 = 4096;

/// Largest number of random positions on charts per wanted point.
const MAX_TRIES_PER_POINT: u64 = 1000;

/// Largest sine of the angle between two normals of a flat surface.
const FLATNESS: f64 = 1e-6;

/// The points to find, and the accuracy of their irradiance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointSettings {
    /// Number of points that light reaches.
    pub(crate) count: u32,
    /// Standard error, relative to the irradiance, at which a point has paths enough.
    pub(crate) error: f64,
    /// Largest number of paths of a point; with fewer than 4096, dimly lit points count as ones that no light reaches.
    pub(crate) samples: u32,
    /// Texels per metre of the charts.
    pub(crate) density: f64,
    /// 0: all processors of the machine. The points and their irradiance do not depend on it.
    pub(crate) threads: usize,
}

/// A random point of a chart.
#[derive(Clone, Debug)]
pub(crate) struct ReferencePoint {
    pub(crate) place: ParametricPoint,
    /// Metres.
    pub(crate) position: DVec3,
    /// Unit normal on the side of the chart.
    pub(crate) normal: DVec3,
    /// Kind of the surface, and the number of its shape in the scene.
    pub(crate) kind: &'static str,
    pub(crate) shape: u32,
    pub(crate) is_curved: bool,
    /// Whether its light map has any light.
    pub(crate) is_lit: bool,
    /// Luminance of the irradiance, in units of radiance, and its standard error.
    pub(crate) irradiance: f64,
    pub(crate) deviation: f64,
}

/// Points with a reference.
#[derive(Debug)]
pub(crate) struct ReferencePoints {
    pub(crate) points: Vec<ReferencePoint>,
    /// Points beside these, of light maps with light, where none of 4096 paths finds light: another object covers them.
    pub(crate) covered: u32,
}

pub(crate) fn luminance(light: Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}

/// Points uniform by area on all charts of `maps` that are not the dark inside of a solid: on curved and flat ones, on both sides of sheets.
/// Points that no light reaches are left out.
///
/// # Errors
/// What is wrong: no light map has light, charts have fewer texels than `settings` say, or there are too few points that light reaches among 1000 random
/// positions per wanted point.
pub(crate) fn reference_points(
    scene: &Scene,
    maps: &[LightMap],
    settings: &PointSettings,
) -> Result<ReferencePoints, String> {
    check(maps, settings)?;
    let surfaces = scene.placed_surfaces();
    let path = IntegratorSettings::resolve(&IntegratorDescription {
        name: "path".into(),
        max_depth: Some(64),
        ..IntegratorDescription::default()
    })
    .unwrap()
    .build();
    let mut candidates = Candidates::new(&surfaces, maps, settings);
    let (mut points, mut covered) = (Vec::new(), 0);
    let threads = match settings.threads {
        0 => std::thread::available_parallelism().map_or(1, |count| count.get()),
        threads => threads,
    };
    while points.len() < settings.count as usize {
        // The same points with any number of threads.
        let group: Vec<(u32, PlacedPoint, ReferencePoint)> = candidates.by_ref().take(64).collect();
        if group.is_empty() {
            return Err(format!(
                "light reaches {} of {} points after {} random positions on charts; ask for fewer points, or light more surfaces",
                points.len(),
                settings.count,
                candidates.tries
            ));
        }
        let estimate = |(number, at, point): &(u32, PlacedPoint, ReferencePoint)| {
            let [irradiance, deviation] = irradiance_by_paths(scene, path.as_ref(), at, settings, *number);
            ReferencePoint { irradiance, deviation, ..point.clone() }
        };
        let estimates: Vec<ReferencePoint> = std::thread::scope(|scope| {
            let parts = group.chunks(group.len().div_ceil(threads).max(1));
            let parts: Vec<_> = parts
                .map(|part| scope.spawn(move || part.iter().map(estimate).collect::<Vec<_>>()))
                .collect();
            parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
        });
        for point in estimates {
            if points.len() == settings.count as usize {
                break;
            }
            if point.irradiance > 0.0 {
                points.push(point);
            } else {
                // Texels beneath an object are filled from their neighbours.
                covered += u32::from(point.is_lit);
            }
        }
    }
    Ok(ReferencePoints { points, covered })
}

/// Tests whether points can be drawn on the charts of `maps`.
fn check(maps: &[LightMap], settings: &PointSettings) -> Result<(), String> {
    let shown = || maps.iter().filter(|map| !map.is_hidden);
    if shown().all(LightMap::is_dark) {
        return Err("no light map has light; the scene needs a light that reaches a surface".into());
    }
    // The largest area of a cell would not be known.
    let coarse = shown().filter(|map| map.chart.is_coarse).count();
    if coarse > 0 {
        return Err(format!(
            "{coarse} charts have fewer than {} texels per metre; lower the density",
            settings.density
        ));
    }
    Ok(())
}

/// Random points of charts, with their numbers; it ends after `max_tries` random positions.
struct Candidates<'a> {
    surfaces: &'a [PlacedSurface<'a>],
    maps: Vec<(&'a LightMap, bool)>,
    /// Sums of the numbers of cells between four texels of the charts.
    cells: Vec<f64>,
    largest_cell: f64,
    random: PixelSampler,
    count: u32,
    tries: u64,
    max_tries: u64,
}

impl<'a> Candidates<'a> {
    fn new(surfaces: &'a [PlacedSurface<'a>], maps: &'a [LightMap], settings: &PointSettings) -> Self {
        let shown = maps.iter().filter(|map| !map.is_hidden);
        let maps: Vec<_> =
            shown.map(|map| (map, is_chart_curved(map, &surfaces[map.chart.surface as usize]))).collect();
        let mut sum = 0.0;
        let cells = maps.iter().map(|(map, _)| {
            let last = last_texel(map);
            sum += last.x * last.y;
            sum
        });
        let cells = cells.collect();
        let random = PixelSampler::new(SamplerKind::Independent, 1, 3, [0, 0], 0);
        Self {
            surfaces,
            maps,
            cells,
            largest_cell: settings.density.powi(-2),
            random,
            count: 0,
            tries: 0,
            max_tries: MAX_TRIES_PER_POINT * u64::from(settings.count),
        }
    }

    /// A candidate, kept with the probability of its cell's area over the largest one.
    fn candidate(&mut self) -> Option<(u32, PlacedPoint, ReferencePoint)> {
        let pick = self.random.next_1d() * self.cells.last()?;
        let (map, is_curved) = *self.maps.get(self.cells.partition_point(|sum| *sum <= pick))?;
        let last = last_texel(map);
        let texel = self.random.next_2d() * last;
        let keep = self.random.next_1d();
        let surface = &self.surfaces[map.chart.surface as usize];
        let at = |texel: DVec2| {
            let place = map.chart.surface_point(surface, texel)?;
            Some((place, surface.at(place.face, place.uv, place.back)?))
        };
        let (place, placed) = at(texel)?;
        // Charts on both sides of a thin wall overlap; a point belongs to one of them.
        map.chart.to_texel(place.face, place.uv)?;
        // Area of a cell, from neighbours a hundredth of one away, towards the middle of the chart: beyond its last texels there are none.
        let position = |texel| Some(at(texel)?.1.at.point.position);
        let here = placed.at.point.position;
        let step = |axis: DVec2| {
            let inwards = if 2.0 * texel.dot(axis) < last.dot(axis) { 0.01 } else { -0.01 };
            Some((position(texel + inwards * axis)? - here) / inwards)
        };
        let area = step(DVec2::X)?.cross(step(DVec2::Y)?).length();
        if keep * self.largest_cell > area {
            return None;
        }
        self.count += 1;
        let point = ReferencePoint {
            place,
            position: here,
            normal: placed.at.wo,
            kind: surface.surface().kind(),
            shape: map.chart.shape,
            is_curved,
            is_lit: !map.is_dark(),
            irradiance: 0.0,
            deviation: 0.0,
        };
        Some((self.count, placed, point))
    }
}

impl Iterator for Candidates<'_> {
    type Item = (u32, PlacedPoint, ReferencePoint);

    fn next(&mut self) -> Option<Self::Item> {
        while self.tries < self.max_tries {
            self.tries += 1;
            let candidate = self.candidate();
            if candidate.is_some() {
                return candidate;
            }
        }
        None
    }
}

fn last_texel(map: &LightMap) -> DVec2 {
    DVec2::new(f64::from(map.chart.size[0]) - 1.0, f64::from(map.chart.size[1]) - 1.0)
}

/// Whether normals of a chart differ.
fn is_chart_curved(map: &LightMap, surface: &PlacedSurface<'_>) -> bool {
    is_curved(|share| {
        let place = map.chart.surface_point(surface, share * last_texel(map))?;
        Some(surface.at(place.face, place.uv, place.back)?.at.wo)
    })
}

/// Whether the unit normals at 25 points of the unit square differ. `normal`: that of a point; `None` where there is no surface.
pub(crate) fn is_curved(normal: impl Fn(DVec2) -> Option<DVec3>) -> bool {
    let points = (0..25).map(|i| DVec2::new(f64::from(i % 5), f64::from(i / 5)) / 4.0);
    let normals: Vec<DVec3> = points.filter_map(normal).collect();
    normals.iter().any(|normal| normal.cross(normals[0]).length() > FLATNESS)
}

/// Irradiance at a place with its standard error: by rays over the hemisphere, which paths continue, and by as many samples of each light,
/// combined by the power heuristic.
fn irradiance_by_paths(
    scene: &Scene,
    path: &dyn Integrator,
    at: &PlacedPoint,
    settings: &PointSettings,
    number: u32,
) -> [f64; 2] {
    let most = (settings.samples / REPLICATES).max(1);
    let (mut sums, mut samples) = ([0.0; REPLICATES as usize], 0);
    loop {
        let next = if samples == 0 { FIRST_SAMPLES.min(most) } else { (2 * samples).min(most) };
        for (replicate, sum) in (0..).zip(&mut sums) {
            for i in samples..next {
                let sampler = PixelSampler::new(SamplerKind::Sobol, most, 7, [number, replicate], i);
                *sum += sample(scene, path, at, sampler);
            }
        }
        samples = next;
        let n = f64::from(REPLICATES);
        let means = sums.map(|sum| sum / f64::from(samples));
        let mean = means.iter().sum::<f64>() / n;
        let squares = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let deviation = (squares / (n * (n - 1.0))).sqrt();
        let is_accurate = if mean > 0.0 {
            deviation <= settings.error * mean
        } else {
            REPLICATES * samples >= DARK_SAMPLES
        };
        if samples == most || is_accurate {
            return [mean, deviation];
        }
    }
}

/// One sample of the irradiance.
fn sample(scene: &Scene, path: &dyn Integrator, at: &PlacedPoint, mut sampler: PixelSampler) -> f64 {
    let at = &at.at;
    let from = LightSampleContext { normal: Some(at.wo), ..at.light_sample_context() };
    let local = warp::cosine_hemisphere(sampler.next_2d());
    let cosine_pdf = |cos: f64| warp::cosine_hemisphere_pdf(cos).0;
    let mut light = 0.0;
    for id in (0..scene.lights().len() as u32).map(LightId) {
        let Some(sample) = scene.sample_light(id, at, sampler.next_2d()) else { continue };
        let cos = at.wo.dot(sample.wi);
        if cos > 0.0 && !scene.occluded(&sample.shadow, sample.t_max) {
            let weight = if sample.is_delta { 1.0 } else { mis::power(sample.pdf.0, cosine_pdf(cos)) };
            light += weight * luminance(sample.radiance) * cos / sample.pdf.0;
        }
    }
    let ray = at.spawn(Frame::from_z(at.wo).to_world(local));
    // The path counts the light of the first hit whole; where it escapes, that of the backdrop, if the scene has one, instead of the infinite
    // lights.
    let own = scene.intersect(&ray, f64::INFINITY).map_or_else(
        || {
            let weighted = |&id: &LightId| {
                let pdf = scene.infinite_pdf(id, &from, ray.direction).0;
                luminance(scene.infinite_radiance(id, &ray)) * mis::power(cosine_pdf(local.z), pdf)
            };
            let lights = scene.infinite_lights().iter().map(weighted).sum::<f64>();
            luminance(scene.backdrop_radiance(&ray, &Wavelengths::Rgb)) - lights
        },
        |hit| {
            let emitted = luminance(scene.emitted(&hit, hit.wo));
            let pdf = hit.light().map_or(0.0, |id| scene.light_pdf(id, &from, &hit).0);
            emitted * (1.0 - mis::power(cosine_pdf(local.z), pdf))
        },
    );
    let mut context = Context::new(
        scene,
        Some(CameraRay { ray, weight: 1.0, differential: None }),
        sampler,
        ContextOptions::new(false),
    );
    light + PI * (luminance(path.radiance(&mut context)) - own)
}
