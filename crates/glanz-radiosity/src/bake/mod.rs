//! Light maps: irradiance per texel of the charts of a scene.
//!
//! *Direct light* is taken from the lights themselves, by shadow rays from several places of each texel, more where it varies. *Indirect
//! light* is a final gather (@jensen2001 section 8): rays over the hemisphere find the direct light map and the elements' indirect light at
//! the places that they meet. It varies slowly and is gathered at the corners of blocks of texels, which are divided where something
//! is near or corners differ (after the error bound of @ward1988), and linear within.
//!
//! Texels from which nothing but dark sides can be seen lie inside of something, and are filled from their neighbours.

use glanz_job::{CancelFlag, Interrupted, ProgressSink};
use glanz_light::{Spectrum, Wavelengths};
use glanz_scene::{Interaction, ParametricPoint, Scene};
use rayon::prelude::*;

use crate::charts::{Chart, charts};
use crate::elements::Elements;

mod atlas;
mod closed;
mod direct;
mod fill;
mod gather;
mod indirect;
mod lookup;
mod maps;
mod progress;
#[cfg(test)]
mod resume_tests;
mod state;
pub mod stored;
#[cfg(test)]
mod tests;

pub use atlas::{Atlas, BORDER, Page};
use direct::Lamps;
use gather::Gather;
use lookup::Index;
pub use maps::LightMaps;
use progress::BakeProgress;
pub use state::BakeState;

/// How carefully light maps are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Texels per metre at least.
    pub density: f64,
    /// Rays of a final gather.
    pub rays: u32,
    /// Shadow rays of a texel to a light at most.
    pub shadow_rays: u32,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self { density: 25.0, rays: 512, shadow_rays: 256 }
    }
}

/// Texels at most over all charts.
const LIMIT: usize = 1 << 24;

/// Borders without a surface that a ray may pass; more are taken for a ray that does not advance.
const PASSED: u32 = 1000;

/// Why there are no light maps.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Not a density.
    #[error("light maps need more than 0 texels per metre, not {0}")]
    Density(f64),
    /// More than can be kept.
    #[error("{0} texels per metre would make {1} texels, more than {LIMIT}")]
    TooMany(f64, usize),
    /// Not one radiosity per element.
    #[error("there are {0} elements, but {1} values of radiosity")]
    Radiosity(usize, usize),
    /// What was found before belongs to something else.
    #[error("what was found before is of other elements")]
    State,
    /// The bake was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// One chart with its light.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Where.
    pub chart: Chart,
    /// Irradiance of each texel, rows of the first coordinate one after the other, in units of radiance; empty if it is dark.
    pub irradiance: Vec<Spectrum>,
    /// Radiance that leaves each texel, diffusely reflected and its own.
    pub radiance: Vec<Spectrum>,
    /// Whether it is on the inside of a closed solid, where nothing is to be seen.
    pub is_hidden: bool,
}

impl LightMap {
    /// Whether no light reaches this side, and none leaves it: it has no texels then.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        self.irradiance.is_empty()
    }
}

/// Light on a place that is to be found: a side of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    at: Interaction,
    /// Unit normals of the surface and for shading, on the side of the spot.
    normal: glanz_math::DVec3,
    shading: glanz_math::DVec3,
}

impl Spot {
    pub(crate) fn new(elements: &Elements<'_>, place: &ParametricPoint) -> Option<Self> {
        let surface = elements.surfaces.get(place.surface as usize)?;
        let at = surface.at(place.face, place.uv, place.back)?.at;
        let side = if at.point.normal.dot(at.wo) < 0.0 { -1.0 } else { 1.0 };
        Some(Self { at, normal: side * at.point.normal, shading: side * at.point.shading_normal })
    }

    /// Share of light that is reflected, and radiance of its own.
    fn reflects(&self, scene: &Scene) -> (Spectrum, Spectrum) {
        let bsdf = self.at.bsdf(scene, &Wavelengths::default());
        let albedo = bsdf.map_or(Spectrum::BLACK, |bsdf| bsdf.albedo(self.at.frame().to_local(self.at.wo)));
        (albedo, scene.emitted(&self.at, self.at.wo))
    }
}

/// Light maps of all surfaces of `elements`: the two sides of a chart follow one another.
///
/// `radiosity`: of each element, in units of radiance times pi, as the solvers find it; without it the elements gather light from one another
/// here, along the rays of the final gather. What a material reflects in whatever way counts as if it were diffuse. `sink`: see [`resume`].
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    elements: &Elements<'_>,
    radiosity: Option<&[Spectrum]>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<Vec<LightMap>, BakeError> {
    resume(BakeState::default(), elements, radiosity, settings, sink, cancel)
}

/// As [`bake`], from what an earlier call for the same elements, radiosity and settings had found: the answer is the same to the bit as that of one
/// call. Light straight from lights is found again.
///
/// `sink`: receives the progress of three phases, and what was found so far after each interval and when the bake is cancelled.
///
/// # Errors
/// [`BakeError`].
pub fn resume(
    state: BakeState,
    elements: &Elements<'_>,
    radiosity: Option<&[Spectrum]>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<Vec<LightMap>, BakeError> {
    let BakeSettings { density, rays, shadow_rays } = *settings;
    if !(density > 0.0 && density.is_finite()) {
        return Err(BakeError::Density(density));
    }
    if let Some(radiosity) = radiosity.filter(|radiosity| radiosity.len() != elements.list.len()) {
        return Err(BakeError::Radiosity(elements.list.len(), radiosity.len()));
    }
    let charts = charts(&elements.surfaces, density);
    let texels = charts.iter().map(Chart::texels).sum();
    if texels > LIMIT {
        return Err(BakeError::TooMany(density, texels));
    }
    let lamps = Lamps::new(elements, shadow_rays);
    let mut direct = Vec::with_capacity(charts.len());
    let mut done = 0;
    let mut progress = BakeProgress::new(sink, cancel);
    for group in charts.chunks(64) {
        progress.report(done as f64 / texels as f64, || state.clone())?;
        let found: Vec<_> = group.par_iter().map(|chart| direct::of_chart(elements, &lamps, chart)).collect();
        direct.extend(found);
        done += group.iter().map(Chart::texels).sum::<usize>();
    }
    let index = Index::new(elements, &charts);
    let mut gather = Gather::new(elements, &index, &charts, &direct, rays);
    if !gather.resume(state) {
        return Err(BakeError::State);
    }
    match radiosity {
        Some(radiosity) => gather.take(radiosity),
        None if gather.is_solved() => {}
        // Nothing is gathered before elements have found their light.
        None => {
            progress.begin(2, "light between surfaces");
            gather.solve(&mut progress)?;
        }
    }
    progress.begin(3, "indirect light");
    let indirect = indirect::of_charts(&gather, &direct, &mut progress)?;
    let finish = |((number, direct), indirect)| finish(&gather, number, direct, indirect);
    Ok((0..charts.len()).into_par_iter().zip(&direct).zip(indirect).map(finish).collect())
}

/// Direct and indirect light of a chart together.
fn finish(
    gather: &Gather<'_>,
    number: usize,
    direct: &direct::DirectMap,
    indirect: Vec<Option<Spectrum>>,
) -> LightMap {
    let (elements, chart) = (gather.elements, &gather.charts[number]);
    let is_hidden = gather.is_dark(number);
    let count = chart.texels();
    let (mut irradiance, mut radiance) = (vec![None; count], vec![None; count]);
    for (texel, light) in indirect.iter().enumerate() {
        let Some(indirect) = *light else { continue };
        let places = direct::places(elements, chart, texel);
        let spots = places.iter().filter_map(|place| Spot::new(elements, place));
        let mut spots: Vec<(Spot, Spectrum)> = spots.zip(direct.at(texel).iter().copied()).collect();
        if spots.is_empty() {
            continue;
        }
        // Of places in the dark, some may lie inside of something.
        if spots.iter().any(|(_, light)| light.is_black()) && spots.iter().any(|(_, light)| !light.is_black())
        {
            spots.retain(|(spot, light)| !light.is_black() || gather.sees_out(spot));
        }
        let (mut albedo, mut own, mut light) = (Spectrum::BLACK, Spectrum::BLACK, indirect);
        let share = 1.0 / spots.len() as f32;
        for (spot, direct) in &spots {
            let (reflected, emitted) = spot.reflects(elements.scene);
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
