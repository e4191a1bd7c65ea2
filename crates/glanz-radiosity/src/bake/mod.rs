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
#[cfg(test)]
mod closed_form_tests;
mod direct;
mod direct_light;
mod fill;
mod fine_elements;
mod gather;
#[cfg(test)]
mod glass_tests;
mod indirect;
mod light_map;
mod lookup;
mod maps;
mod part;
#[cfg(test)]
mod part_tests;
mod phase_times;
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
use direct_light::DirectMap;
pub use fill::filled;
use gather::{FinalGather, MAX_FINE_ELEMENTS, MAX_SMALL_ELEMENTS};
pub use light_map::LightMap;
use light_map::light_maps;
use lookup::SurfaceIndex;
pub use maps::LightMaps;
pub use part::{BakeConflict, BakePart, BakeParts};
use phase_times::PhaseTimes;
use progress::{BakeProgress, PhaseWork};
use receiver::BakeReceiver;
use reconstruction::Reconstruction;
pub use settings::{BakeError, BakeMethod, BakeSettings, CoarseElements};
pub use state::BakeState;

/// Charts that are computed between two reports of progress.
const CHARTS_AT_ONCE: usize = 64;

/// Result of a bake.
#[derive(Clone, Debug)]
pub struct BakedLight {
    /// Light maps of all surfaces. Those of one [`Sheet`](crate::charts::Sheet) follow one another, of both sides; thin walls may divide
    /// either side.
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
/// call.
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
    let charts = checked_charts(elements, settings)?;
    let phases = if settings.method == BakeMethod::Gather { 3 } else { 4 };
    let mut progress = BakeProgress::new(sink, cancel, phases);
    // The parts that it was joined from no longer matter.
    let state = BakeState { parts: None, ..state };
    match settings.method {
        BakeMethod::Gather => bake_by_gather(state, elements, &charts, settings, &mut progress),
        BakeMethod::Radiosity { reconstruction } => {
            bake_by_radiosity(state, elements, &charts, settings, reconstruction, &mut progress)
        }
    }
}

/// The state with the light of a part of a bake by a final gather. States of all parts, joined by [`BakeState::merge`], hold all light for [`resume`].
///
/// A part has its share of the direct light, the light between surfaces, and its share of the gathered light. It computes the direct light
/// that `state` lacks, that of other parts included: if that takes long, parts that end with the direct light come first, and `state` is
/// joined from them. The state of the finished part is returned as it is.
///
/// # Errors
/// Those of [`bake`], and [`BakeError::State`] for the state of other elements or another part, and [`BakeError::Indivisible`] for [`BakeMethod::Radiosity`].
pub fn bake_part(
    state: BakeState,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    part: BakePart,
    sink: &mut dyn ProgressSink<BakeState>,
    cancel: &CancelFlag,
) -> Result<BakeState, BakeError> {
    if settings.method != BakeMethod::Gather {
        return Err(BakeError::Indivisible);
    }
    if state.parts.as_ref().is_some_and(|parts| !parts.is_only(part)) {
        return Err(BakeError::State);
    }
    // It no longer has the direct light of other parts, which would be computed again.
    if state.parts == Some(BakeParts::of(part, true)) {
        return Ok(state);
    }
    let charts = checked_charts(elements, settings)?;
    let mut progress = BakeProgress::new(sink, cancel, if part.direct_only { 1 } else { 3 });
    let mut state = BakeState { parts: Some(BakeParts::of(part, false)), ..state };
    if part.direct_only {
        direct::add_runs(elements, &charts, settings, Some(part.part), None, &mut state, &mut progress)?;
    } else {
        let elements = &divided(elements, settings, &state, &mut progress)?;
        let index = SurfaceIndex::new(elements, &charts);
        let share = 1.0 / f64::from(part.part.count());
        let times = PhaseTimes::new(elements, &index, &charts, settings, share);
        direct::add_runs(elements, &charts, settings, None, Some(&times), &mut state, &mut progress)?;
        let direct = direct_light::maps(&charts, &state.direct);
        let gather = solved_gather(state, elements, &index, &charts, &direct, settings, &mut progress)?;
        indirect::gather_part(&gather, &direct, part.part, &mut progress)?;
        state = gather.state();
    }
    let runs = charts.iter().map(Chart::texels).sum::<usize>().div_ceil(direct_light::RUN);
    state.direct.retain(|number, _| part::has_piece(Some(part.part), *number as usize, runs));
    Ok(BakeState { parts: Some(BakeParts::of(part, true)), ..state })
}

/// The charts of valid settings.
fn checked_charts(elements: &Elements<'_>, settings: &BakeSettings) -> Result<Vec<Chart>, BakeError> {
    let density = settings.density;
    if !(density > 0.0 && density.is_finite()) {
        return Err(BakeError::Density(density));
    }
    let charts = charts(&elements.surfaces, density);
    let texels = charts.iter().map(Chart::texels).sum();
    if texels > settings::MAX_TEXELS {
        return Err(BakeError::TooMany(density, texels));
    }
    Ok(charts)
}

/// Light maps by a final gather.
fn bake_by_gather(
    mut state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<BakedLight, BakeError> {
    let elements = &divided(elements, settings, &state, progress)?;
    let index = SurfaceIndex::new(elements, charts);
    let times = PhaseTimes::new(elements, &index, charts, settings, 1.0);
    let direct = direct::light_on_charts(elements, charts, settings, Some(&times), &mut state, progress)?;
    let gather = solved_gather(state, elements, &index, charts, &direct, settings, progress)?;
    let indirect = indirect::light_on_charts(&gather, &direct, progress)?;
    Ok(BakedLight { maps: light_maps(&gather, &direct, indirect), coarse_elements: None })
}

/// The elements of a final gather, before its first phase.
fn divided<'a>(
    elements: &Elements<'a>,
    settings: &BakeSettings,
    state: &BakeState,
    progress: &mut BakeProgress<'_>,
) -> Result<Elements<'a>, BakeError> {
    let check = || progress.check(|| state.clone());
    fine_elements::divided(elements, settings.density, MAX_FINE_ELEMENTS, check)
}

/// A final gather with the light of the elements, at the beginning of its phase.
fn solved_gather<'a>(
    state: BakeState,
    elements: &'a Elements<'a>,
    index: &'a SurfaceIndex,
    charts: &'a [Chart],
    direct: &[DirectMap],
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<FinalGather<'a>, BakeError> {
    let mut gather = FinalGather::new(elements, index, charts, direct, settings);
    if !gather.resume(state) {
        return Err(BakeError::State);
    }
    // A state with gathered light also has the light of the elements.
    if !gather.is_solved() {
        progress.begin(2, "light between surfaces");
        gather.solve(progress)?;
    }
    progress.begin(3, "indirect light");
    Ok(gather)
}

/// Light maps by the hierarchical solver.
fn bake_by_radiosity(
    mut state: BakeState,
    elements: &Elements<'_>,
    charts: &[Chart],
    settings: &BakeSettings,
    reconstruction: Interpolation,
    progress: &mut BakeProgress<'_>,
) -> Result<BakedLight, BakeError> {
    let index = SurfaceIndex::new(elements, charts);
    let times = PhaseTimes::new(elements, &index, charts, settings, 1.0);
    let direct = direct::light_on_charts(elements, charts, settings, Some(&times), &mut state, progress)?;
    let mut gather = FinalGather::new(elements, &index, charts, &direct, settings);
    gather.keep(&state);
    let (refined, coarse_error) = match &state.solution {
        Some(solution) => {
            (solution::stored(elements, settings, solution)?.ok_or(BakeError::State)?, state.coarse_error)
        }
        None if state.is_empty() => {
            progress.begin(2, "elements");
            let (refined, coarse_error) =
                solution::refined(&gather, elements, settings, MAX_SMALL_ELEMENTS, progress)?;
            // The solver makes no elements smaller than texels allow, through the neck of a vase too large ones.
            let check = || progress.report(PhaseWork::fraction(1.0), || gather.state());
            let refined = fine_elements::with_divided_curves(&refined, MAX_SMALL_ELEMENTS, check)?;
            let patches = refined.list.iter().map(|element| (element.patch, None)).collect();
            state = BakeState { solution: Some(patches), coarse_error, rows: Some(Vec::new()), ..state };
            (refined, coarse_error)
        }
        None => return Err(BakeError::State),
    };
    let index = SurfaceIndex::new(&refined, charts);
    let mut gather = gather.with_elements(&refined, &index);
    match state.rows.take() {
        Some(rows) => {
            progress.begin(3, "light between surfaces");
            gather.keep(&state);
            if !gather.resume_rows(rows) {
                return Err(BakeError::State);
            }
            gather.solve(progress)?;
            let light = refined.list.par_iter().zip(gather.indirect()).enumerate();
            let light = light.map(|(i, (e, light))| (e.patch, gather.is_open(i, e).then_some(*light)));
            state.solution = Some(light.collect());
        }
        None => {
            let light = state.solution.iter().flatten().map(|(_, light)| light.unwrap_or_default());
            gather.resume_indirect(light.collect());
        }
    }
    progress.begin(4, "light on texels");
    let solution = state.solution.as_ref().ok_or(BakeError::State)?;
    let reconstruction = Reconstruction::new(&refined, solution, &index, reconstruction);
    let mut indirect = Vec::with_capacity(charts.len());
    for numbers in (0..charts.len()).collect::<Vec<_>>().chunks(CHARTS_AT_ONCE) {
        progress
            .report(PhaseWork::fraction(indirect.len() as f64 / charts.len() as f64), || state.clone())?;
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
    direct: &[DirectMap],
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
