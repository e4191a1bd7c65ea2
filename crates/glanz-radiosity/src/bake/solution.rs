//! Elements that the hierarchical solver chooses, with the light that they gather from one another.

use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_scene::{Light, ParametricPoint};
use rayon::prelude::*;

use super::gather::Gather;
use super::progress::BakeProgress;
use super::{BakeError, BakeSettings, BakeState};
use crate::elements::{Element, ElementSettings, Elements, Part, Patch};
use crate::solve::{Hierarchical, hierarchical_with};

/// Largest flux that a link may carry too much or too little, as a share of all.
const BOUND: f64 = 1e-4;

/// Smallest side of an element, texels.
const SMALLEST: f64 = 2.0;

/// How often a part is halved at most to find the direct light on it.
const HALVED: f64 = 4.0;

/// Patches of the elements, and the indirect irradiance of each in units of radiance; none inside of something.
pub(super) type Solution = Vec<(Patch, Option<Spectrum>)>;

/// The elements of patches; `None` if these are of other surfaces.
pub(super) fn elements_of<'a>(
    elements: &Elements<'a>,
    patches: impl IndexedParallelIterator<Item = Patch>,
) -> Option<Elements<'a>> {
    let list: Option<Vec<Element>> = patches.map(|patch| elements.element(patch)).collect();
    let Elements { scene, left_out, .. } = *elements;
    Some(Elements { scene, surfaces: elements.surfaces.clone(), list: list?, left_out })
}

/// Elements that are small where light between surfaces changes. `gather`: knows the direct light.
pub(super) fn refined<'a>(
    gather: &Gather<'_>,
    elements: &Elements<'a>,
    settings: &BakeSettings,
    progress: &mut BakeProgress<'_>,
) -> Result<Elements<'a>, BakeError> {
    // Over whole faces, but for borders at thin walls.
    let side = 2.0 * elements.scene.bounds().diagonal().length();
    let whole = ElementSettings { side: if side > 0.0 { side } else { 1.0 } };
    let mut start = Elements::new(elements.scene, &whole)?;
    start.cut_at_walls(settings.density)?;
    let solver = Hierarchical {
        bound: BOUND,
        side: SMALLEST / settings.density,
        factors_of_leaves: false,
        ..Hierarchical::default()
    };
    let cancel = progress.cancel();
    let exitance = |element: &Element| exitance(gather, settings.density, element);
    let solved = hierarchical_with(start, &exitance, &solver, progress, cancel)?;
    progress.report(1.0, BakeState::default)?;
    let patches = solved.elements.list.par_iter().map(|element| element.patch);
    elements_of(elements, patches).ok_or(BakeError::State)
}

/// What leaves an element: the direct light that it reflects, and what no shadow ray finds of its own.
fn exitance(gather: &Gather<'_>, density: f64, element: &Element) -> Spectrum {
    let patch = &element.patch;
    let surface = gather.elements.surfaces.get(patch.surface as usize);
    let light = surface.and_then(|surface| gather.elements.scene.light(surface.light()?));
    let own = match light {
        Some(Light::Area(light)) if !light.can_be_sampled() => element.emission,
        _ => Spectrum::BLACK,
    };
    let texels = element.area.sqrt() * density;
    let mut parts = vec![patch.part];
    for _ in 0..texels.log2().ceil().clamp(1.0, HALVED) as u32 {
        parts = parts.iter().flat_map(Part::quarters).collect();
    }
    let place =
        |uv: DVec2| ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv };
    let found: Vec<Spectrum> =
        parts.iter().filter_map(|part| gather.direct_at(&place(part.center()))).collect();
    own + element.reflectance * found.iter().copied().sum::<Spectrum>() * (1.0 / found.len().max(1) as f32)
}
