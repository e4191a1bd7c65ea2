//! Light that comes straight from lights.

use std::collections::HashMap;
use std::f64::consts::PI;

use glanz_job::Interrupted;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{Bounds3, DVec2, Frame};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::{mis, warp};
use glanz_scene::{Light, LightId, ParametricPoint, PlacedSurface, Scene};
use rayon::prelude::*;

use super::progress::BakeProgress;
use super::visibility::{MOST_PASSED, Visibility};
use super::{BakeMethod, BakeSettings, BakeState, CHARTS_AT_ONCE, Spot};
use crate::charts::Chart;
use crate::elements::Elements;

/// Lights that are looked at one by one; of more, some are picked.
const ONE_BY_ONE: usize = 64;

/// Samples of a light before it is asked whether they are enough.
const FIRST: u32 = 32;

/// Difference between two halves of the samples with which they are enough, per the light that is there.
const ENOUGH: f32 = 0.01;

/// The same two for a preview: 4 times as fast for an error that is not seen beside that of indirect light.
const FIRST_OF_PREVIEW: u32 = 16;
const ENOUGH_OF_PREVIEW: f32 = 0.05;

/// Distance of a light, per its size, within which rays over the hemisphere look for it too. Beyond, their weight is
/// below (area / (pi distance^2))^2 < 2e-3, and nothing is seen without them.
const NEAR: f64 = 2.0;

/// Key of the points that pick directions: the same everywhere, so that neighbours and charts that meet agree.
const KEY: u64 = 0x6c61_6d70;

/// The lights of a scene and the points to pick directions to them.
pub(super) struct Lamps<'a> {
    scene: &'a Scene,
    visibility: Visibility<'a>,
    lights: Vec<LightId>,
    /// Those of them that are surfaces.
    boxes: HashMap<LightId, Bounds3>,
    points: Vec<[f64; 3]>,
    /// Samples before the first test of whether they are enough, and the difference of halves with which they are.
    first: u32,
    enough: f32,
}

/// Direct light of a chart.
#[derive(Clone, Debug)]
pub(super) struct DirectMap {
    /// For each texel that at its places; none where there is no surface.
    of_texels: Vec<Vec<Spectrum>>,
    is_lit: bool,
}

impl DirectMap {
    /// Whether any light arrives.
    pub(super) fn is_lit(&self) -> bool {
        self.is_lit
    }

    /// The light at the places of a texel.
    pub(super) fn at(&self, texel: usize) -> &[Spectrum] {
        self.of_texels.get(texel).map_or(&[], Vec::as_slice)
    }

    /// Mean over the places of a texel.
    pub(super) fn mean(&self, texel: usize) -> Spectrum {
        let places = self.at(texel);
        if places.is_empty() { Spectrum::BLACK } else { mean(places) }
    }
}

fn mean(list: &[Spectrum]) -> Spectrum {
    list.iter().copied().sum::<Spectrum>() * (1.0 / list.len() as f32)
}

/// The places of a texel by its number.
pub(super) fn places(elements: &Elements<'_>, chart: &Chart, texel: usize) -> Vec<ParametricPoint> {
    let width = chart.size[0] as usize;
    let texel = [(texel % width) as u32, (texel / width) as u32];
    elements
        .surfaces
        .get(chart.surface as usize)
        .map_or_else(Vec::new, |surface| chart.places(surface, texel))
}

/// Direct light on all texels of charts. `state`: what was found before, for checkpoints.
pub(super) fn of_charts(
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    state: &BakeState,
    progress: &mut BakeProgress<'_>,
) -> Result<Vec<DirectMap>, Interrupted> {
    let lamps = Lamps::new(elements, settings);
    let texels: usize = charts.iter().map(Chart::texels).sum();
    let mut direct = Vec::with_capacity(charts.len());
    let mut done = 0;
    for group in charts.chunks(CHARTS_AT_ONCE) {
        progress.report(done as f64 / texels as f64, || state.clone())?;
        let found: Vec<_> = group.par_iter().map(|chart| of_chart(elements, &lamps, chart)).collect();
        direct.extend(found);
        done += group.iter().map(Chart::texels).sum::<usize>();
    }
    Ok(direct)
}

/// Direct light on all texels of a chart.
fn of_chart(elements: &Elements<'_>, lamps: &Lamps<'_>, chart: &Chart) -> DirectMap {
    let of_texel = |texel| {
        let places = places(elements, chart, texel);
        let spots: Vec<Spot> = places.iter().filter_map(|place| Spot::new(elements, place)).collect();
        lamps.light(&spots)
    };
    let of_texels: Vec<Vec<Spectrum>> = (0..chart.texels()).map(of_texel).collect();
    let is_lit = of_texels.iter().flatten().any(|light| !light.is_black());
    DirectMap { of_texels, is_lit }
}

impl<'a> Lamps<'a> {
    fn new(elements: &Elements<'a>, settings: &BakeSettings) -> Self {
        let most = settings.shadow_rays;
        let (first, enough) = match settings.method {
            BakeMethod::Gather => (FIRST, ENOUGH),
            BakeMethod::Radiosity { .. } => (FIRST_OF_PREVIEW, ENOUGH_OF_PREVIEW),
        };
        let scene = elements.scene;
        let light = |surface: &PlacedSurface<'_>| surface.light().map(|id| (id, surface.bounds()));
        let all = (0..).map(LightId).zip(scene.lights());
        let lights = all.filter(|(id, _)| scene.light_probability(*id) > 0.0).map(|(id, _)| id).collect();
        let sobol = ScrambledSobol::new(KEY);
        let point = |i: u32| {
            let coordinate = |d| unit(sobol.coordinate(i.reverse_bits(), d));
            [0, 1, 2].map(coordinate)
        };
        let boxes = elements.surfaces.iter().filter_map(light).collect();
        let visibility = Visibility::of(settings.method, scene);
        Self {
            scene,
            visibility,
            lights,
            boxes,
            points: (0..most.max(4)).map(point).collect(),
            first,
            enough,
        }
    }

    /// Irradiance at each of the spots, which are near one another: samples go round among them.
    fn light(&self, spots: &[Spot]) -> Vec<Spectrum> {
        let mut sums = vec![Spectrum::BLACK; spots.len()];
        if spots.is_empty() {
            return sums;
        }
        if self.lights.len() <= ONE_BY_ONE {
            let near: Vec<bool> = self.lights.iter().map(|&id| self.is_near(&spots[0], id)).collect();
            for (&id, &near) in self.lights.iter().zip(&near) {
                let is_delta = self.scene.light(id).is_some_and(Light::is_delta);
                self.sampled(spots, is_delta, &mut sums, |spot, [x, y, _]| {
                    self.sample(spot, id, DVec2::new(x, y), near.then_some(1.0))
                });
            }
            if near.contains(&true) {
                let density = |id| {
                    let number = self.lights.iter().position(|&light| light == id)?;
                    near[number].then_some(1.0)
                };
                self.sampled(spots, false, &mut sums, |spot, point| self.by_chance(spot, point, density));
            }
        } else {
            let is_area = |id| matches!(self.scene.light(id), Some(Light::Area(_)));
            let density = |id| is_area(id).then(|| self.scene.light_probability(id));
            self.sampled(spots, false, &mut sums, |spot, [x, y, z]| {
                let (id, probability) = self.scene.select_light(z)?;
                let light = self.sample(spot, id, DVec2::new(x, y), density(id))?;
                Some(light * (1.0 / probability) as f32)
            });
            self.sampled(spots, false, &mut sums, |spot, point| self.by_chance(spot, point, density));
        }
        sums
    }

    /// Whether rays over the hemisphere find the light often enough to be worth while.
    fn is_near(&self, spot: &Spot, id: LightId) -> bool {
        self.boxes.get(&id).is_some_and(|bounds| {
            let position = spot.at.point.position;
            let distance = position.distance(position.clamp(bounds.min, bounds.max));
            distance < NEAR * bounds.diagonal().length()
        })
    }

    /// Irradiance that a ray over the hemisphere finds from lights with a `density`, the probability with which they are picked, shared with
    /// light sampling (@veach1995).
    fn by_chance(
        &self,
        spot: &Spot,
        [x, y, _]: [f64; 3],
        density: impl Fn(LightId) -> Option<f64>,
    ) -> Option<Spectrum> {
        let local = warp::cosine_hemisphere(DVec2::new(x, y));
        let direction = Frame::from_z(spot.shading).to_world(local);
        if spot.normal.dot(direction) <= 0.0 {
            return None;
        }
        let (mut found, mut share) = (Spectrum::BLACK, Spectrum::ONE);
        let mut ray = spot.at.spawn(direction);
        for _ in 0..MOST_PASSED {
            let Some(hit) = self.scene.intersect(&ray, f64::INFINITY) else { break };
            if let Some((id, probability)) = hit.light().and_then(|id| Some((id, density(id)?))) {
                let pdf = self.scene.light_pdf(id, &spot.at.light_sample_context(), &hit).0 * probability;
                let weight = mis::power(by_cosine(local.z), pdf);
                found += share * self.scene.emitted(&hit, hit.wo) * (PI * weight) as f32;
            }
            share *= self.visibility.passed(&hit);
            if share.is_black() {
                break;
            }
            ray = hit.spawn(direction);
        }
        Some(found)
    }

    /// Adds the means of what `sample` finds to `sums`. `once`: whether one sample per spot is all there is.
    fn sampled(
        &self,
        spots: &[Spot],
        once: bool,
        sums: &mut [Spectrum],
        sample: impl Fn(&Spot, [f64; 3]) -> Option<Spectrum>,
    ) {
        let count = spots.len();
        let before = luminance(sums.iter().copied().sum::<Spectrum>()) / count as f32;
        let most = if once { count } else { self.points.len() };
        let mut found = vec![Spectrum::BLACK; count];
        // Of samples 0, 1, 4, 5 and so on of each spot, and of the others.
        let mut halves = [0.0_f32; 2];
        let mut taken = 0;
        let mut next = if once { count } else { (self.first as usize).min(most) };
        while taken < next {
            for (i, &point) in self.points.iter().enumerate().take(next).skip(taken) {
                if let Some(light) = sample(&spots[i % count], point) {
                    found[i % count] += light;
                    halves[(i / count) % 2] += luminance(light);
                }
            }
            taken = next;
            let difference = (halves[0] - halves[1]).abs() / taken as f32;
            let there = before + (halves[0] + halves[1]) / taken as f32;
            if difference > self.enough * there {
                next = (2 * taken).min(most);
            }
        }
        // How many samples each spot has had.
        let shares = |spot: usize| (taken + count - 1 - spot) / count;
        for (spot, (sum, found)) in sums.iter_mut().zip(found).enumerate() {
            *sum += found * (1.0 / shares(spot).max(1) as f32);
        }
    }

    /// Irradiance from one direction to a light, over its density. `probability`: with which the light is picked, if rays over the hemisphere
    /// look for it too.
    fn sample(&self, spot: &Spot, id: LightId, xi: DVec2, probability: Option<f64>) -> Option<Spectrum> {
        let sample = self.scene.sample_light(id, &spot.at, xi)?;
        let cos = spot.shading.dot(sample.wi);
        if cos <= 0.0 || spot.normal.dot(sample.wi) <= 0.0 {
            return None;
        }
        let share = self.visibility.along(&sample.shadow, sample.t_max);
        if share.is_black() {
            return None;
        }
        let weight = probability.map_or(1.0, |p| mis::power(sample.pdf.0 * p, by_cosine(cos)));
        Some(share * sample.radiance * (weight * cos / sample.pdf.0) as f32)
    }
}

/// Density of directions by the cosine, per solid angle.
fn by_cosine(cos: f64) -> f64 {
    warp::cosine_hemisphere_pdf(cos.max(0.0)).0
}

pub(super) fn luminance(light: Spectrum) -> f32 {
    light.luminance(&Wavelengths::default())
}
