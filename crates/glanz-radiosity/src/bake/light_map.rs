//! Light maps, from direct and indirect light on texels.

use glanz_light::Spectrum;
use rayon::prelude::*;

use super::direct;
use super::direct_light::DirectMap;
use super::fill;
use super::gather::FinalGather;
use super::receiver::BakeReceiver;
use crate::charts::Chart;

/// The light on one chart.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// The chart.
    pub chart: Chart,
    /// Irradiance of each texel, row by row, in units of radiance; empty if the chart is dark.
    pub irradiance: Vec<Spectrum>,
    /// Radiance that leaves each texel, diffusely reflected and emitted; empty if the chart is dark.
    pub radiance: Vec<Spectrum>,
    /// Whether it is on the dark inside of a closed solid, which is not visible.
    pub is_hidden: bool,
}

impl LightMap {
    /// Whether no light reaches or leaves the chart; it has no texels then.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        self.irradiance.is_empty()
    }
}

/// Light maps of all charts from their direct and indirect light.
pub(super) fn light_maps(
    gather: &FinalGather<'_>,
    direct: &[DirectMap],
    indirect: Vec<Vec<Option<Spectrum>>>,
) -> Vec<LightMap> {
    let map = |((number, direct), indirect)| light_map(gather, number, direct, indirect);
    (0..gather.charts.len()).into_par_iter().zip(direct).zip(indirect).map(map).collect()
}

/// Light map of a chart from its direct and indirect light.
fn light_map(
    gather: &FinalGather<'_>,
    number: usize,
    direct: &DirectMap,
    indirect: Vec<Option<Spectrum>>,
) -> LightMap {
    let (elements, chart) = (gather.elements, &gather.charts[number]);
    let is_hidden = gather.is_dark(number);
    let count = chart.texels();
    let (mut irradiance, mut radiance) = (vec![None; count], vec![None; count]);
    for (texel, light) in indirect.iter().enumerate() {
        let Some(indirect) = *light else { continue };
        let points = direct::texel_points(elements, chart, texel);
        let receivers = points.iter().filter_map(|point| BakeReceiver::new(elements, point));
        let mut receivers: Vec<(BakeReceiver, Spectrum)> =
            receivers.zip(direct.at(texel).iter().copied()).collect();
        if receivers.is_empty() {
            continue;
        }
        // Receivers without direct light may be inside a solid.
        if receivers.iter().any(|(_, light)| light.is_black())
            && receivers.iter().any(|(_, light)| !light.is_black())
        {
            receivers.retain(|(receiver, light)| !light.is_black() || gather.sees_light(receiver));
        }
        let (mut albedo, mut own, mut light) = (Spectrum::BLACK, Spectrum::BLACK, indirect);
        let share = 1.0 / receivers.len() as f32;
        for (receiver, direct) in &receivers {
            let (reflected, emitted) = receiver.albedo_and_emission(elements.scene);
            albedo += reflected * share;
            own += emitted * share;
            light += *direct * share;
        }
        irradiance[texel] = Some(light);
        radiance[texel] = Some(own + albedo * light * std::f32::consts::FRAC_1_PI);
    }
    let is_lit = |map: &[Option<Spectrum>]| map.iter().flatten().any(|light| !light.is_black());
    if !is_lit(&irradiance) && !is_lit(&radiance) {
        return LightMap { chart: chart.clone(), irradiance: Vec::new(), radiance: Vec::new(), is_hidden };
    }
    let size = chart.size.map(|n| n as usize);
    LightMap {
        chart: chart.clone(),
        irradiance: fill::filled(irradiance, size),
        radiance: fill::filled(radiance, size),
        is_hidden: false,
    }
}
