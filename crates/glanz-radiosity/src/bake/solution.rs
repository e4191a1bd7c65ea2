//! Elements whose size the hierarchical solver selects, with their indirect light.

use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_scene::{Light, ParametricPoint};
use rayon::prelude::*;

use super::gather::FinalGather;
use super::progress::{BakeProgress, PhaseWork};
use super::{BakeError, BakeSettings};
use crate::elements::{Element, ElementSettings, Elements, ParameterPatch, Patch};
use crate::solve::{HierarchicalSettings, hierarchical_with_exitance};

/// Largest error of the flux of a link, relative to the flux of the scene.
pub(super) const BOUND: f64 = 1e-4;

/// Shortest side of an element, texels.
const SHORTEST_SIDE: f64 = 2.0;

/// Largest number of quarterings of an element to sample the direct light on it.
const MAX_QUARTERINGS: f64 = 4.0;

/// Largest number of times that a stored element was quartered.
const MAX_DEPTH: u32 = 40;

/// Patches of the elements, with the indirect irradiance of each in units of radiance; `None` inside solids.
pub(super) type Solution = Vec<(Patch, Option<Spectrum>)>;

/// The elements of stored patches; `None` unless these are quarters of the start elements that cover all of them once, in the order of
/// the solver.
pub(super) fn stored<'a>(
    elements: &Elements<'a>,
    settings: &BakeSettings,
    solution: &Solution,
) -> Result<Option<Elements<'a>>, BakeError> {
    let start = start(elements, settings)?;
    let patches: Vec<Patch> = solution.iter().map(|(patch, _)| *patch).collect();
    let mut rest = patches.as_slice();
    let is_covered = start.list.iter().all(|element| take(&start, element.patch, &mut rest, MAX_DEPTH));
    Ok(if is_covered && rest.is_empty() { of_patches(elements, patches.into_par_iter()) } else { None })
}

/// Removes the quarters of a patch from the front of `rest`; `false` if they do not cover what trimming leaves of it.
fn take(elements: &Elements<'_>, whole: Patch, rest: &mut &[Patch], depth: u32) -> bool {
    if let Some((_, others)) = rest.split_first().filter(|(first, _)| **first == whole) {
        *rest = others;
        return true;
    }
    if elements.element(whole).is_none() {
        return true;
    }
    let before = rest.len();
    let quarters = || whole.domain.quarters().into_iter().map(|domain| Patch { domain, ..whole });
    depth > 0 && quarters().all(|quarter| take(elements, quarter, rest, depth - 1)) && rest.len() < before
}

/// The elements of patches; `None` if one of them has none.
fn of_patches<'a>(
    elements: &Elements<'a>,
    patches: impl IndexedParallelIterator<Item = Patch>,
) -> Option<Elements<'a>> {
    let list = patches.map(|patch| elements.element(patch)).collect::<Option<_>>()?;
    let Elements { scene, left_out, .. } = *elements;
    Some(Elements { scene, surfaces: elements.surfaces.clone(), list, left_out })
}

/// Whole faces, cut at thin walls.
fn start<'a>(elements: &Elements<'a>, settings: &BakeSettings) -> Result<Elements<'a>, BakeError> {
    let side = 2.0 * elements.scene.bounds().diagonal().length();
    let whole = ElementSettings { side: if side > 0.0 { side } else { 1.0 } };
    let mut start = Elements::new(elements.scene, &whole)?;
    start.cut_at_walls(settings.density)?;
    Ok(start)
}

/// Elements that are small where light between surfaces changes, at most `max_elements` unless there are more faces; and the largest error
/// of a link if it exceeds [`BOUND`] for lack of memory. `gather`: with direct light.
pub(super) fn refined<'a>(
    gather: &FinalGather<'_>,
    elements: &Elements<'a>,
    settings: &BakeSettings,
    max_elements: usize,
    progress: &mut BakeProgress<'_>,
) -> Result<(Elements<'a>, Option<f64>), BakeError> {
    let solver = HierarchicalSettings {
        bound: BOUND,
        side: SHORTEST_SIDE / settings.density,
        elements: max_elements,
        leaf_form_factors: false,
        ..HierarchicalSettings::default()
    };
    let cancel = progress.cancel();
    let exitance = |element: &Element| exitance(gather, settings.density, element);
    let solved =
        hierarchical_with_exitance(start(elements, settings)?, &exitance, &solver, progress, cancel)?;
    progress.report(PhaseWork::fraction(1.0), || gather.state())?;
    let patches = solved.elements.list.par_iter().map(|element| element.patch);
    let refined = of_patches(elements, patches).ok_or(BakeError::State)?;
    // The bake was not cancelled: a solver that is not finished has too many elements or links.
    let coarse_error = Some(solved.errors.largest).filter(|&error| !solved.finished && error > BOUND);
    Ok((refined, coarse_error))
}

/// Radiant exitance of an element: reflected direct light, and emitted light if the element cannot be sampled as a light.
fn exitance(gather: &FinalGather<'_>, density: f64, element: &Element) -> Spectrum {
    let patch = &element.patch;
    let surface = gather.elements.surfaces.get(patch.surface as usize);
    let light = surface.and_then(|surface| gather.elements.scene.light(surface.light()?));
    let own = match light {
        Some(Light::Area(light)) if !light.can_be_sampled() => element.emission,
        _ => Spectrum::BLACK,
    };
    let texels = element.area.sqrt() * density;
    let mut parts = vec![patch.domain];
    for _ in 0..texels.log2().ceil().clamp(1.0, MAX_QUARTERINGS) as u32 {
        parts = parts.iter().flat_map(ParameterPatch::quarters).collect();
    }
    let place =
        |uv: DVec2| ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv };
    let found: Vec<Spectrum> =
        parts.iter().filter_map(|part| gather.direct_at(&place(part.center()))).collect();
    own + element.reflectance * found.iter().copied().sum::<Spectrum>() * (1.0 / found.len().max(1) as f32)
}
