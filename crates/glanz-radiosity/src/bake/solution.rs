//! Elements whose size the hierarchical solver selects, with their indirect light.

use std::collections::HashMap;

use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_scene::{Light, ParametricPoint};
use rayon::prelude::*;

use super::gather::FinalGather;
use super::progress::BakeProgress;
use super::{BakeError, BakeSettings, BakeState};
use crate::elements::{Element, ElementSettings, Elements, ParameterPatch, Patch};
use crate::solve::{HierarchicalSettings, hierarchical_with_exitance};

/// Largest error of the flux of a link, relative to the flux of the scene.
const BOUND: f64 = 1e-4;

/// Shortest side of an element, texels.
const SHORTEST_SIDE: f64 = 2.0;

/// Largest number of quarterings of an element to sample the direct light on it.
const MAX_QUARTERINGS: f64 = 4.0;

/// Area of parameters that elements of a side of a face may have in common, from rounding.
const OVERLAP: f64 = 1e-6;

/// Patches of the elements, with the indirect irradiance of each in units of radiance; `None` inside solids.
pub(super) type Solution = Vec<(Patch, Option<Spectrum>)>;

/// The elements of patches; `None` if a patch belongs to other surfaces, leaves the parameters of its face, or patches overlap: stored ones
/// may say anything, and many large ones would fill the lookup of elements.
pub(super) fn elements_of<'a>(
    elements: &Elements<'a>,
    patches: impl IndexedParallelIterator<Item = Patch>,
) -> Option<Elements<'a>> {
    let list: Option<Vec<Element>> = patches.map(|patch| elements.element(patch)).collect();
    let mut areas: HashMap<(u32, u32, bool), f64> = HashMap::new();
    for Element { patch, .. } in list.iter().flatten() {
        let is_inside = |corner: &DVec2| corner.clamp(DVec2::ZERO, DVec2::ONE).distance(*corner) <= OVERLAP;
        if !patch.domain.corners().iter().all(is_inside) {
            return None;
        }
        *areas.entry((patch.surface, patch.face, patch.back)).or_default() += patch.domain.size();
    }
    if areas.values().any(|area| *area > 1.0 + OVERLAP) {
        return None;
    }
    let Elements { scene, left_out, .. } = *elements;
    Some(Elements { scene, surfaces: elements.surfaces.clone(), list: list?, left_out })
}

/// Elements that are small where light between surfaces changes. `gather`: with direct light.
pub(super) fn refined<'a>(
    gather: &FinalGather<'_>,
    elements: &Elements<'a>,
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<Elements<'a>, BakeError> {
    // Starts with whole faces, cut at thin walls.
    let side = 2.0 * elements.scene.bounds().diagonal().length();
    let whole = ElementSettings { side: if side > 0.0 { side } else { 1.0 } };
    let mut start = Elements::new(elements.scene, &whole)?;
    start.cut_at_walls(settings.density)?;
    let solver = HierarchicalSettings {
        bound: BOUND,
        side: SHORTEST_SIDE / settings.density,
        leaf_form_factors: false,
        ..HierarchicalSettings::default()
    };
    let cancel = progress.cancel();
    let exitance = |element: &Element| exitance(gather, settings.density, element);
    let solved = hierarchical_with_exitance(start, &exitance, &solver, progress, cancel)?;
    progress.report(1.0, BakeState::default)?;
    let patches = solved.elements.list.par_iter().map(|element| element.patch);
    elements_of(elements, patches).ok_or(BakeError::State)
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
