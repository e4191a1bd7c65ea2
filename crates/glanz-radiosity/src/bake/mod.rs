//! Light maps: irradiance per texel of the charts of a scene.
//!
//! *Direct light* is estimated by samples of the lights at several points of each texel, more where it varies. *Indirect light* is a final
//! gather (@jensen2001 section 8): rays over the hemisphere, whose hits have the direct light of their texels and the indirect light of
//! their elements. It varies slowly and is gathered at the corners of blocks of texels, which are divided near other surfaces and where
//! corners differ (after the error bound of @ward1988), and interpolated within. The other method interpolates the light of the elements
//! of the hierarchical solver.
//!
//! Texels from which only dark sides are visible are inside solids; they are filled from their neighbours.

use glanz_job::{CancelFlag, ProgressSink};
use glanz_light::Spectrum;
use rayon::prelude::*;

use crate::charts::{Chart, charts};
use crate::elements::Elements;
use crate::reconstruct::{Interpolation, ReconstructError};

mod atlas;
mod closed;
mod direct;
mod fill;
mod gather;
#[cfg(test)]
mod glass_tests;
mod indirect;
mod light_map;
mod lookup;
mod maps;
mod progress;
mod receiver;
mod reconstruction;
#[cfg(test)]
mod resume_tests;
mod settings;
mod solution;
mod state;
pub mod stored;
#[cfg(test)]
mod tests;
mod visibility;

pub use atlas::{Atlas, AtlasPage, BORDER};
use gather::{FinalGather, MAX_SMALL_ELEMENTS};
pub use light_map::LightMap;
use light_map::light_maps;
use lookup::SurfaceIndex;
pub use maps::LightMaps;
use progress::BakeProgress;
use receiver::BakeReceiver;
use reconstruction::Reconstruction;
pub use settings::{BakeError, BakeMethod, BakeSettings, CoarseElements};
pub use state::BakeState;

/// Charts that are computed between two reports of progress.
const CHARTS_AT_ONCE: usize = 64;

/// Result of a bake.
#[derive(Clone, Debug)]
pub struct BakedLight {
    /// Light maps of all surfaces; those of the two sides of a chart are adjacent.
    pub maps: Vec<LightMap>,
    /// The elements of the hierarchical solver, if memory made them larger than its error bound requires.
    pub coarse_elements: Option<CoarseElements>,
}

/// Computes light maps of all surfaces of `elements`.
///
/// All reflection of materials counts as diffuse. In the final gather all glass is opaque; with [`BakeMethod::Radiosity`] clear glass
/// transmits light. `sink`: see [`resume`].
///
/// # Errors
/// [`BakeError::Density`] and [`BakeError::TooMany`] for an invalid or too high number of texels per metre, [`BakeError::Memory`] if the
/// light between the elements takes too much memory, [`BakeError::Interrupted`] if `cancel` is raised.
///
/// With [`BakeMethod::Radiosity`] also [`BakeError::Interpolation`] for an exponent that the interpolation refuses, or with which its
/// equations have no solution, [`BakeError::Elements`] if the scene has more faces than can be stored, and [`BakeError::Solver`] for a
/// density that makes the shortest sides of elements 0 or infinite.
pub fn bake(
    elements: &Elements<'_>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<BakedLight, BakeError> {
    resume(BakeState::default(), elements, settings, sink, cancel)
}

/// As [`bake`], from the state of an earlier call with the same elements and settings; the result has the same bits as that of a single
/// call. Direct light is computed again.
///
/// `sink` receives the progress of three or four phases, and the state at its interval and when the bake is cancelled.
///
/// # Errors
/// Those of [`bake`], and [`BakeError::State`] for the state of other elements or of another method.
pub fn resume(
    state: BakeState,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<BakedLight, BakeError> {
    if let BakeMethod::Radiosity { reconstruction } = settings.method {
        reconstruction.check()?;
    }
    let density = settings.density;
    if !(density > 0.0 && density.is_finite()) {
        return Err(BakeError::Density(density));
    }
    let charts = charts(&elements.surfaces, density);
    let texels = charts.iter().map(Chart::texels).sum();
    if texels > settings::MAX_TEXELS {
        return Err(BakeError::TooMany(density, texels));
    }
    let phases = if settings.method == BakeMethod::Gather { 3 } else { 4 };
    let mut progress = BakeProgress::new(sink, cancel, phases);
    match settings.method {
        BakeMethod::Gather => bake_by_gather(state, elements, &charts, settings, &mut progress),
        BakeMethod::Radiosity { reconstruction } => {
            bake_by_radiosity(state, elements, &charts, settings, reconstruction, &mut progress)
        }
    }
}

/// Light maps by a final gather.
fn bake_by_gather(
    state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<BakedLight, BakeError> {
    let direct = direct::light_on_charts(elements, charts, settings, &state, progress)?;
    let index = SurfaceIndex::new(elements, charts);
    let mut gather = FinalGather::new(elements, &index, charts, &direct, settings);
    if !gather.resume(state) {
        return Err(BakeError::State);
    }
    // A state with gathered light also has the light of the elements.
    if !gather.is_solved() {
        progress.begin(2, "light between surfaces");
        gather.solve(progress)?;
    }
    progress.begin(3, "indirect light");
    let indirect = indirect::light_on_charts(&gather, &direct, progress)?;
    Ok(BakedLight { maps: light_maps(&gather, &direct, indirect), coarse_elements: None })
}

/// Light maps by the hierarchical solver.
fn bake_by_radiosity(
    state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    reconstruction: Interpolation,
    progress: &mut BakeProgress<'_>,
) -> Result<BakedLight, BakeError> {
    let direct = direct::light_on_charts(elements, charts, settings, &state, progress)?;
    let index = SurfaceIndex::new(elements, charts);
    let gather = FinalGather::new(elements, &index, charts, &direct, settings);
    let (refined, coarse_error) = match &state.solution {
        Some(solution) => {
            (solution::stored(elements, settings, solution)?.ok_or(BakeError::State)?, state.coarse_error)
        }
        None if state.is_empty() => {
            progress.begin(2, "elements");
            solution::refined(&gather, elements, settings, MAX_SMALL_ELEMENTS, progress)?
        }
        None => return Err(BakeError::State),
    };
    let index = SurfaceIndex::new(&refined, charts);
    let mut gather = gather.with_elements(&refined, &index);
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
            BakeState { solution: Some(light.collect()), coarse_error, ..BakeState::default() }
        }
    };
    progress.begin(4, "light on texels");
    let solution = state.solution.as_ref().ok_or(BakeError::State)?;
    let reconstruction = Reconstruction::new(&refined, solution, &index, reconstruction);
    let mut indirect = Vec::with_capacity(charts.len());
    for numbers in (0..charts.len()).collect::<Vec<_>>().chunks(CHARTS_AT_ONCE) {
        progress.report(indirect.len() as f64 / charts.len() as f64, || state.clone())?;
        let texels = |&number: &usize| {
            let light = gather.is_lit(number).then(|| reconstruction.texels(&charts[number])).transpose()?;
            Ok(without_hidden_texels(&gather, &direct, number, light))
        };
        indirect.extend(numbers.par_iter().map(texels).collect::<Result<Vec<_>, ReconstructError>>()?);
    }
    let coarse = |error| CoarseElements { count: refined.list.len(), error, bound: solution::BOUND };
    let maps = light_maps(&gather, &direct, indirect);
    Ok(BakedLight { maps, coarse_elements: coarse_error.map(coarse) })
}

/// The indirect light of the texels of a chart, `None` for texels inside solids.
fn without_hidden_texels(
    gather: &FinalGather<'_>,
    direct: &[direct::DirectMap],
    number: usize,
    light: Option<Vec<Spectrum>>,
) -> Vec<Option<Spectrum>> {
    let chart = &gather.charts[number];
    let Some(light) = light else { return vec![Some(Spectrum::BLACK); chart.texels()] };
    let is_open = |texel: usize| {
        let lights = direct[number].at(texel);
        let places = || direct::texel_points(gather.elements, chart, texel);
        let is_lit = lights.iter().any(|light| !light.is_black());
        is_lit
            || places().iter().any(|place| {
                BakeReceiver::new(gather.elements, place).is_some_and(|receiver| gather.sees_light(&receiver))
            })
    };
    light.into_par_iter().enumerate().map(|(texel, light)| is_open(texel).then_some(light)).collect()
}
