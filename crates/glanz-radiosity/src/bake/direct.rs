//! Light that comes straight from lights.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_scene::{Light, LightId, Place, Scene};

use super::Spot;
use crate::charts::Chart;
use crate::elements::Elements;

/// Lights that are looked at one by one; of more, some are picked.
const ONE_BY_ONE: usize = 64;

/// Samples of a light before it is asked whether they are enough.
const FIRST: u32 = 32;

/// Difference between two halves of the samples with which they are enough, per the light that is there.
const ENOUGH: f32 = 0.01;

/// Key of the points that pick directions: the same everywhere, so that neighbours and charts that meet agree.
const KEY: u64 = 0x6c61_6d70;

/// The lights of a scene and the points to pick directions to them.
pub(super) struct Lamps<'a> {
    scene: &'a Scene,
    lights: Vec<LightId>,
    points: Vec<[f64; 3]>,
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
pub(super) fn places(elements: &Elements<'_>, chart: &Chart, texel: usize) -> Vec<Place> {
    let width = chart.size[0] as usize;
    let texel = [(texel % width) as u32, (texel / width) as u32];
    elements
        .surfaces
        .get(chart.surface as usize)
        .map_or_else(Vec::new, |surface| chart.places(surface, texel))
}

/// Direct light on all texels of a chart.
pub(super) fn of_chart(elements: &Elements<'_>, lamps: &Lamps<'_>, chart: &Chart) -> DirectMap {
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
    /// `most`: samples of a light for a texel at most.
    pub(super) fn new(scene: &'a Scene, most: u32) -> Self {
        let all = (0..).map(LightId).zip(scene.lights());
        let lights = all.filter(|(id, _)| scene.light_probability(*id) > 0.0).map(|(id, _)| id).collect();
        let sobol = ScrambledSobol::new(KEY);
        let point = |i: u32| {
            let coordinate = |d| unit(sobol.coordinate(i.reverse_bits(), d));
            [0, 1, 2].map(coordinate)
        };
        Self { scene, lights, points: (0..most.max(4)).map(point).collect() }
    }

    /// Irradiance at each of the spots, which are near one another: samples go round among them.
    fn light(&self, spots: &[Spot]) -> Vec<Spectrum> {
        let mut sums = vec![Spectrum::BLACK; spots.len()];
        if spots.is_empty() {
            return sums;
        }
        if self.lights.len() <= ONE_BY_ONE {
            for &id in &self.lights {
                let is_delta = self.scene.light(id).is_some_and(Light::is_delta);
                self.sampled(spots, is_delta, &mut sums, |spot, [x, y, _]| {
                    self.sample(spot, id, DVec2::new(x, y))
                });
            }
        } else {
            self.sampled(spots, false, &mut sums, |spot, [x, y, z]| {
                let (id, probability) = self.scene.pick_light(z)?;
                Some(self.sample(spot, id, DVec2::new(x, y))? * (1.0 / probability) as f32)
            });
        }
        sums
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
        let mut next = if once { count } else { (FIRST as usize).min(most) };
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
            if difference > ENOUGH * there {
                next = (2 * taken).min(most);
            }
        }
        // How many samples each spot has had.
        let shares = |spot: usize| (taken + count - 1 - spot) / count;
        for (spot, (sum, found)) in sums.iter_mut().zip(found).enumerate() {
            *sum += found * (1.0 / shares(spot).max(1) as f32);
        }
    }

    /// Irradiance from one direction to a light, over its density.
    fn sample(&self, spot: &Spot, id: LightId, xi: DVec2) -> Option<Spectrum> {
        let sample = self.scene.sample_light(id, &spot.at, xi, &Wavelengths::default())?;
        let cos = spot.shading.dot(sample.wi);
        if cos <= 0.0
            || spot.normal.dot(sample.wi) <= 0.0
            || self.scene.occluded(&sample.shadow, sample.t_max)
        {
            return None;
        }
        Some(sample.radiance * (cos / sample.pdf.0) as f32)
    }
}

pub(super) fn luminance(light: Spectrum) -> f32 {
    light.luminance(&Wavelengths::default())
}
