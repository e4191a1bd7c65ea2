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
use crate::elements::{ElementError, Elements};
use crate::reconstruct::Interpolation;
use crate::solve::hierarchical::HierarchicalError;

mod atlas;
mod closed;
mod direct;
mod fill;
mod gather;
mod indirect;
mod lookup;
mod maps;
mod progress;
mod reconstruction;
#[cfg(test)]
mod resume_tests;
mod solution;
mod state;
pub mod stored;
#[cfg(test)]
mod tests;
mod visibility;

pub use atlas::{Atlas, BORDER, Page};
use gather::Gather;
use lookup::Index;
pub use maps::LightMaps;
use progress::BakeProgress;
use reconstruction::Reconstruction;
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
    /// How indirect light is found.
    pub method: BakeMethod,
}

/// How indirect light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BakeMethod {
    /// By a final gather: rays over the hemisphere from places on each chart.
    #[default]
    Gather,
    /// By the hierarchical solver, for elements as large as its bound allows: a preview in a tenth of the time.
    Radiosity {
        /// How the light of elements becomes that of texels.
        reconstruction: Interpolation,
    },
}

impl BakeMethod {
    /// Name in messages.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gather => "gather",
            Self::Radiosity { reconstruction } => reconstruction.name(),
        }
    }

    /// Number in files: 0 for the gather, then the interpolations in the order of [`Interpolation::ALL`].
    #[must_use]
    pub fn number(&self) -> u8 {
        (0..)
            .zip(Self::all())
            .find(|(_, method)| method.name() == self.name())
            .map_or(0, |(number, _)| number)
    }

    /// The method of a number; `None` if there is none.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::all().nth(usize::from(number))
    }

    /// The method of a name; `None` if there is none.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|method| method.name() == name)
    }

    fn all() -> impl Iterator<Item = Self> {
        let by_solver =
            Interpolation::ALL.into_iter().map(|reconstruction| Self::Radiosity { reconstruction });
        std::iter::once(Self::Gather).chain(by_solver)
    }
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self { density: 25.0, rays: 512, shadow_rays: 256, method: BakeMethod::Gather }
    }
}

/// Texels at most over all charts.
const LIMIT: usize = 1 << 24;

/// Charts that are computed between two reports of progress.
const CHARTS_AT_ONCE: usize = 64;

/// Why there are no light maps.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// Not a density.
    #[error("light maps need more than 0 texels per metre, not {0}")]
    Density(f64),
    /// More than can be kept.
    #[error("{0} texels per metre would make {1} texels, more than {LIMIT}")]
    TooMany(f64, usize),
    /// What was found before belongs to something else.
    #[error("what was found before is of other elements")]
    State,
    /// Elements cannot be made.
    #[error(transparent)]
    Elements(#[from] ElementError),
    /// The solver refuses its settings.
    #[error(transparent)]
    Solver(#[from] HierarchicalError),
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
/// Light is diffuse: what a material reflects in whatever way counts as if it were diffuse. To the final gather all glass is opaque; the
/// solver's light passes clear glass. `sink`: see [`resume`].
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    elements: &Elements<'_>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<Vec<LightMap>, BakeError> {
    resume(BakeState::default(), elements, settings, sink, cancel)
}

/// As [`bake`], from what an earlier call for the same elements and settings had found: the answer is the same to the bit as that of one
/// call. Light straight from lights is found again.
///
/// `sink`: receives the progress of three phases, and what was found so far after each interval and when the bake is cancelled.
///
/// # Errors
/// [`BakeError`].
pub fn resume(
    state: BakeState,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<Vec<LightMap>, BakeError> {
    let density = settings.density;
    if !(density > 0.0 && density.is_finite()) {
        return Err(BakeError::Density(density));
    }
    let charts = charts(&elements.surfaces, density);
    let texels = charts.iter().map(Chart::texels).sum();
    if texels > LIMIT {
        return Err(BakeError::TooMany(density, texels));
    }
    let phases = if settings.method == BakeMethod::Gather { 3 } else { 4 };
    let mut progress = BakeProgress::new(sink, cancel, phases);
    match settings.method {
        BakeMethod::Gather => gathered(state, elements, &charts, settings, &mut progress),
        BakeMethod::Radiosity { reconstruction } => {
            reconstructed(state, elements, &charts, settings, reconstruction, &mut progress)
        }
    }
}

/// Light maps by a final gather.
fn gathered(
    state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<Vec<LightMap>, BakeError> {
    let direct = direct::of_charts(elements, charts, settings, &state, progress)?;
    let index = Index::new(elements, charts);
    let mut gather = Gather::new(elements, &index, charts, &direct, settings);
    if !gather.resume(state) {
        return Err(BakeError::State);
    }
    // Nothing is gathered before elements have found their light.
    if !gather.is_solved() {
        progress.begin(2, "light between surfaces");
        gather.solve(progress)?;
    }
    progress.begin(3, "indirect light");
    let indirect = indirect::of_charts(&gather, &direct, progress)?;
    Ok(finished(&gather, &direct, indirect))
}

/// Light maps by the hierarchical solver.
fn reconstructed(
    state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    reconstruction: Interpolation,
    progress: &mut BakeProgress<'_>,
) -> Result<Vec<LightMap>, BakeError> {
    let direct = direct::of_charts(elements, charts, settings, &state, progress)?;
    let index = Index::new(elements, charts);
    let gather = Gather::new(elements, &index, charts, &direct, settings);
    let refined = match &state.solution {
        Some(solution) => solution::elements_of(elements, solution.par_iter().map(|(patch, _)| *patch))
            .ok_or(BakeError::State)?,
        None if state.is_empty() => {
            progress.begin(2, "elements");
            solution::refined(&gather, elements, settings, progress)?
        }
        None => return Err(BakeError::State),
    };
    let index = Index::new(&refined, charts);
    let mut gather = gather.on(&refined, &index);
    let state = match &state.solution {
        Some(solution) => {
            gather.resume_indirect(solution.iter().map(|(_, light)| light.unwrap_or_default()).collect());
            state
        }
        None => {
            progress.begin(3, "light between surfaces");
            gather.solve(progress)?;
            let light = refined.list.par_iter().zip(gather.indirect());
            let light = light.map(|(e, light)| (e.patch, gather.is_open(e).then_some(*light)));
            BakeState { solution: Some(light.collect()), ..BakeState::default() }
        }
    };
    progress.begin(4, "light on texels");
    let solution = state.solution.as_ref().ok_or(BakeError::State)?;
    let reconstruction = Reconstruction::new(&refined, solution, &index, reconstruction);
    let mut indirect = Vec::with_capacity(charts.len());
    for numbers in (0..charts.len()).collect::<Vec<_>>().chunks(CHARTS_AT_ONCE) {
        progress.report(indirect.len() as f64 / charts.len() as f64, || state.clone())?;
        let texels = |&number: &usize| gather.is_lit(number).then(|| reconstruction.texels(&charts[number]));
        indirect.extend(numbers.par_iter().map(texels).collect::<Vec<_>>());
    }
    let indirect =
        indirect.into_iter().enumerate().map(|(number, light)| masked(&gather, &direct, number, light));
    let indirect: Vec<Vec<Option<Spectrum>>> = indirect.collect();
    Ok(finished(&gather, &direct, indirect))
}

/// The indirect light of the texels of a chart without those that lie inside of something.
fn masked(
    gather: &Gather<'_>,
    direct: &[direct::DirectMap],
    number: usize,
    light: Option<Vec<Spectrum>>,
) -> Vec<Option<Spectrum>> {
    let chart = &gather.charts[number];
    let Some(light) = light else { return vec![Some(Spectrum::BLACK); chart.texels()] };
    let is_open = |texel: usize| {
        let lights = direct[number].at(texel);
        let places = || direct::places(gather.elements, chart, texel);
        let is_lit = lights.iter().any(|light| !light.is_black());
        is_lit
            || places()
                .iter()
                .any(|place| Spot::new(gather.elements, place).is_some_and(|spot| gather.sees_out(&spot)))
    };
    light.into_par_iter().enumerate().map(|(texel, light)| is_open(texel).then_some(light)).collect()
}

fn finished(
    gather: &Gather<'_>,
    direct: &[direct::DirectMap],
    indirect: Vec<Vec<Option<Spectrum>>>,
) -> Vec<LightMap> {
    let finish = |((number, direct), indirect)| finish(gather, number, direct, indirect);
    (0..gather.charts.len()).into_par_iter().zip(direct).zip(indirect).map(finish).collect()
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
