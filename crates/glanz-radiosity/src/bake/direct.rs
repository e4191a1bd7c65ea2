//! Direct light on texels, by samples of the lights.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glanz_job::JobPart;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{Bounds3, DVec2};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::{mis, warp};
use glanz_scene::{Light, LightId, LightSampleContext, ParametricPoint, PlacedSurface, Scene, SelectedLight};
use rayon::prelude::*;

use super::direct_light::{self, DirectMap, DirectRun, RUN, texels_of_run};
use super::part::has_piece;
use super::phase_times::PhaseTimes;
use super::progress::{BakeProgress, PhaseWork};
use super::receiver::BakeReceiver;
use super::visibility::{MAX_PASSED, Visibility};
use super::{BakeError, BakeMethod, BakeSettings, BakeState};
use crate::charts::Chart;
use crate::elements::Elements;

/// Largest number of lights that are all sampled; of more, some are selected at random.
const MAX_SAMPLED_LIGHTS: usize = 64;

/// Samples of a light before the first test of their error.
const FIRST_SAMPLES: u32 = 32;

/// Difference between the halves of the samples, relative to the light, below which they suffice.
const MAX_DIFFERENCE: f32 = 0.01;

/// The same two for `--method radiosity`: 4 times as fast, with an error that is small compared with that of indirect light.
const PREVIEW_FIRST_SAMPLES: u32 = 16;
const PREVIEW_MAX_DIFFERENCE: f32 = 0.05;

/// Largest number of consecutive samples that belong to the same half of all samples.
const MAX_SAMPLES_OF_HALF: usize = 4;

/// Distance of a light, relative to its size, up to which rays over the hemisphere sample it too. Beyond, their weight is
/// below (area / (pi distance^2))^2 < 2e-3.
const NEAR_DISTANCE: f64 = 2.0;

/// Runs of texels that are computed between two reports of progress.
const RUNS_AT_ONCE: usize = 16;

/// Key of the sample points; the same for all texels, so that adjacent texels and charts agree.
const KEY: u64 = 0x6c61_6d70;

/// Estimator of direct light: the lights of a scene and the sample points.
pub(super) struct DirectLighting<'a> {
    scene: &'a Scene,
    visibility: Visibility<'a>,
    lights: Vec<LightId>,
    /// Bounds of the lights that rays can hit.
    boxes: HashMap<LightId, Bounds3>,
    points: Vec<[f64; 3]>,
    /// Number of samples before the first test of their error, and the difference of the halves below which they suffice.
    first: u32,
    max_difference: f32,
}

/// The points of a texel, given by its number.
pub(super) fn texel_points(elements: &Elements<'_>, chart: &Chart, texel: usize) -> Vec<ParametricPoint> {
    let width = chart.size[0] as usize;
    let texel = [(texel % width) as u32, (texel / width) as u32];
    elements
        .surfaces
        .get(chart.surface as usize)
        .map_or_else(Vec::new, |surface| chart.texel_points(surface, texel))
}

/// Direct light on all texels of charts, see [`add_runs`].
pub(super) fn light_on_charts(
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    times: Option<&PhaseTimes>,
    state: &mut BakeState,
    progress: &mut BakeProgress<'_>,
) -> Result<Vec<DirectMap>, BakeError> {
    add_runs(elements, charts, settings, None, times, state, progress)?;
    Ok(direct_light::maps(charts, &state.direct))
}

/// Adds the direct light that the state lacks, of a part or of all texels. `times`: those of the phases that follow.
pub(super) fn add_runs(
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    part: Option<JobPart>,
    times: Option<&PhaseTimes>,
    state: &mut BakeState,
    progress: &mut BakeProgress<'_>,
) -> Result<(), BakeError> {
    let lighting = DirectLighting::new(elements, settings);
    let mut ends = Vec::with_capacity(charts.len());
    let mut texels = 0;
    for chart in charts {
        texels += chart.texels();
        ends.push(texels);
    }
    let count = texels.div_ceil(RUN);
    let has_length = |(&number, run): (&u32, &Arc<DirectRun>)| {
        run.texels() == texels_of_run(number as usize, texels).len()
    };
    if !state.direct.iter().all(has_length) {
        return Err(BakeError::State);
    }
    let is_missing =
        |number: &u32| has_piece(part, *number as usize, count) && !state.direct.contains_key(number);
    let mut missing: Vec<u32> = (0..count as u32).filter(is_missing).collect();
    // Spread over all charts, so that the first runs tell how long all take, and how many are lit.
    missing.sort_unstable_by_key(|number| number.reverse_bits());
    let (mut lit, mut lit_texels) = (vec![false; charts.len()], 0);
    let mut mark_lit = |number: u32, run: &DirectRun| {
        for (texel, number) in texels_of_run(number as usize, texels).enumerate() {
            if run.at(texel).iter().any(|light| !light.is_black()) {
                let chart = ends.partition_point(|end| *end <= number);
                if !std::mem::replace(&mut lit[chart], true) {
                    lit_texels += charts[chart].texels();
                }
            }
        }
        lit_texels
    };
    let mut expect = |runs: &mut dyn Iterator<Item = (u32, &DirectRun)>, progress: &mut BakeProgress<'_>| {
        let lit_texels = runs.map(|(number, run)| mark_lit(number, run)).last();
        if let Some((times, lit_texels)) = times.zip(lit_texels) {
            times.expect(lit_texels as f64, progress);
        }
    };
    expect(&mut state.direct.iter().map(|(number, run)| (*number, &**run)), progress);
    let of_texel = |texel: usize| {
        let chart = ends.partition_point(|end| *end <= texel);
        let own = &charts[chart];
        let points = texel_points(elements, own, texel + own.texels() - ends[chart]);
        let receivers: Vec<BakeReceiver> =
            points.iter().filter_map(|place| BakeReceiver::new(elements, place)).collect();
        lighting.light(&receivers)
    };
    for (done, group) in missing.chunks(RUNS_AT_ONCE).enumerate() {
        let fraction = (done * RUNS_AT_ONCE) as f64 / missing.len() as f64;
        progress.report(PhaseWork::fraction(fraction), || state.clone())?;
        let run = |&number: &u32| {
            let light: Vec<_> =
                texels_of_run(number as usize, texels).into_par_iter().map(of_texel).collect();
            (number, Arc::new(DirectRun::new(light)))
        };
        let found: Vec<(u32, Arc<DirectRun>)> = group.par_iter().map(run).collect();
        expect(&mut found.iter().map(|(number, run)| (*number, &**run)), progress);
        state.direct.extend(found);
    }
    Ok(())
}

impl<'a> DirectLighting<'a> {
    fn new(elements: &Elements<'a>, settings: &BakeSettings) -> Self {
        let most = settings.shadow_rays;
        let (first, max_difference) = match settings.method {
            BakeMethod::Gather => (FIRST_SAMPLES, MAX_DIFFERENCE),
            BakeMethod::Radiosity { .. } => (PREVIEW_FIRST_SAMPLES, PREVIEW_MAX_DIFFERENCE),
        };
        let scene = elements.scene;
        let seen = |&id: &LightId| scene.light(id).is_some_and(Light::can_be_hit);
        let light = |surface: &PlacedSurface<'_>| Some((surface.light().filter(seen)?, surface.bounds()));
        let all = (0..).map(LightId).zip(scene.lights());
        let lights = all.filter(|(id, _)| scene.is_selectable(*id)).map(|(id, _)| id).collect();
        let sobol = ScrambledSobol::new(KEY);
        let point = |i: u32| {
            let coordinate = |d| unit(sobol.coordinate(i.reverse_bits(), d));
            [0, 1, 2].map(coordinate)
        };
        let boxes = elements.surfaces.iter().filter_map(light).collect();
        let visibility = Visibility::new(settings.method, scene);
        Self {
            scene,
            visibility,
            lights,
            boxes,
            points: (0..most.max(4)).map(point).collect(),
            first,
            max_difference,
        }
    }

    /// Irradiance at each of a few near receivers, to which samples are assigned in turn.
    fn light(&self, receivers: &[BakeReceiver]) -> Vec<Spectrum> {
        let mut sums = vec![Spectrum::BLACK; receivers.len()];
        if receivers.is_empty() {
            return sums;
        }
        if self.lights.len() <= MAX_SAMPLED_LIGHTS {
            let near: Vec<bool> = self.lights.iter().map(|&id| self.is_near(&receivers[0], id)).collect();
            for (&id, &near) in self.lights.iter().zip(&near) {
                let is_delta = self.scene.light(id).is_some_and(Light::is_delta);
                self.add_estimate(receivers, is_delta, &mut sums, |receiver, [x, y, _]| {
                    self.sample_light(receiver, id, DVec2::new(x, y), near.then_some(1.0))
                });
            }
            if near.contains(&true) {
                let density = |id| {
                    let number = self.lights.iter().position(|&light| light == id)?;
                    near[number].then_some(1.0)
                };
                self.add_estimate(receivers, false, &mut sums, |receiver, point| {
                    self.sample_hemisphere(receiver, point, density)
                });
            }
        } else {
            let is_seen = |id| self.boxes.contains_key(&id);
            self.add_estimate(receivers, false, &mut sums, |receiver, [x, y, z]| {
                let SelectedLight { id, probability, .. } = self.scene.select_light(&context(receiver), z)?;
                let density = is_seen(id).then_some(probability);
                let light = self.sample_light(receiver, id, DVec2::new(x, y), density)?;
                Some(light * (1.0 / probability) as f32)
            });
            self.add_estimate(receivers, false, &mut sums, |receiver, point| {
                let from = context(receiver);
                let density = |id| is_seen(id).then(|| self.scene.light_probability(id, &from));
                self.sample_hemisphere(receiver, point, density)
            });
        }
        sums
    }

    /// Whether the light is near enough to be sampled by rays over the hemisphere too.
    fn is_near(&self, receiver: &BakeReceiver, id: LightId) -> bool {
        self.boxes.get(&id).is_some_and(|bounds| {
            let position = receiver.at.point.position;
            let distance = position.distance(position.clamp(bounds.min, bounds.max));
            distance < NEAR_DISTANCE * bounds.diagonal().length()
        })
    }

    /// Sample of the irradiance by a ray over the hemisphere, weighted by the power heuristic (@veach1995). `density`: probability with which
    /// light sampling selects a light; `None` for lights that these rays do not sample.
    fn sample_hemisphere(
        &self,
        receiver: &BakeReceiver,
        [x, y, _]: [f64; 3],
        density: impl Fn(LightId) -> Option<f64>,
    ) -> Option<Spectrum> {
        let local = warp::cosine_hemisphere(DVec2::new(x, y));
        let direction = receiver.frame().to_world(local);
        if receiver.normal.dot(direction) <= 0.0 {
            return None;
        }
        let (mut found, mut throughput) = (Spectrum::BLACK, Spectrum::ONE);
        let mut ray = receiver.at.spawn(direction);
        for _ in 0..MAX_PASSED {
            let Some(hit) = self.scene.intersect(&ray, f64::INFINITY) else { break };
            if let Some((id, probability)) = hit.light().and_then(|id| Some((id, density(id)?))) {
                let pdf = self.scene.light_pdf(id, &receiver.at.light_sample_context(), &hit).0 * probability;
                let weight = mis::power(cosine_pdf(local.z), pdf);
                found += throughput * self.scene.emitted(&hit, hit.wo) * (PI * weight) as f32;
            }
            throughput *= self.visibility.surface_transmittance(&hit);
            if throughput.is_black() {
                break;
            }
            ray = hit.spawn(direction);
        }
        Some(found)
    }

    /// Adds the means of the samples by `sample` to `sums`. `once`: whether one sample per receiver is exact.
    ///
    /// Receivers take turns after blocks of samples: those of a block are spread over the whole light, single ones of equal distance in the
    /// sequence over a part of it.
    fn add_estimate(
        &self,
        receivers: &[BakeReceiver],
        once: bool,
        sums: &mut [Spectrum],
        sample: impl Fn(&BakeReceiver, [f64; 3]) -> Option<Spectrum>,
    ) {
        let count = receivers.len();
        let before = luminance(sums.iter().copied().sum::<Spectrum>()) / count as f32;
        let most = if once { count } else { self.points.len() };
        let mut found = vec![Spectrum::BLACK; count];
        let mut shares = vec![0_u32; count];
        // Sums over the samples of both halves of the blocks.
        let mut halves = [0.0_f32; 2];
        let mut used = 0;
        let mut next = if once { count } else { (self.first as usize).min(most) };
        let block = (next / count).max(1);
        // Every receiver has samples of both halves, of which the difference would otherwise be that of the receivers.
        let half = (block / 2).clamp(1, MAX_SAMPLES_OF_HALF);
        while used < next {
            for (i, &point) in self.points.iter().enumerate().take(next).skip(used) {
                let number = i / block % count;
                shares[number] += 1;
                if let Some(light) = sample(&receivers[number], point) {
                    found[number] += light;
                    halves[(i / half) % 2] += luminance(light);
                }
            }
            used = next;
            let difference = (halves[0] - halves[1]).abs() / used as f32;
            let total = before + (halves[0] + halves[1]) / used as f32;
            if difference > self.max_difference * total {
                next = (2 * used).min(most);
            }
        }
        for ((sum, found), share) in sums.iter_mut().zip(found).zip(shares) {
            *sum += found * (1.0 / share.max(1) as f32);
        }
    }

    /// Sample of the irradiance by a direction to a light. `probability`: with which the light is selected, if rays over the hemisphere
    /// sample it too.
    fn sample_light(
        &self,
        receiver: &BakeReceiver,
        id: LightId,
        xi: DVec2,
        probability: Option<f64>,
    ) -> Option<Spectrum> {
        let sample = self.scene.sample_light(id, &receiver.at, xi)?;
        let cos = receiver.shading.dot(sample.wi);
        if cos <= 0.0 || receiver.normal.dot(sample.wi) <= 0.0 {
            return None;
        }
        let transmittance = self.visibility.transmittance(&sample.shadow, sample.t_max);
        if transmittance.is_black() {
            return None;
        }
        let weight = probability.map_or(1.0, |p| mis::power(sample.pdf.0 * p, cosine_pdf(cos)));
        Some(transmittance * sample.radiance * (weight * cos / sample.pdf.0) as f32)
    }
}

/// The receiver as the origin of light samples.
fn context(receiver: &BakeReceiver) -> LightSampleContext {
    LightSampleContext { normal: Some(receiver.shading), ..receiver.at.light_sample_context() }
}

/// Density of directions over the hemisphere, per solid angle.
fn cosine_pdf(cos: f64) -> f64 {
    warp::cosine_hemisphere_pdf(cos.max(0.0)).0
}

pub(super) fn luminance(light: Spectrum) -> f32 {
    light.luminance(&Wavelengths::default())
}
