//! Indirect light, gathered by rays over the hemisphere.

use std::collections::BTreeMap;

use glanz_light::Spectrum;
use glanz_math::DVec3;
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::warp;
use glanz_scene::ParametricPoint;
use rayon::prelude::*;

use super::closed::dark_insides;
use super::direct_light::DirectMap;
use super::lookup::SurfaceIndex;
use super::progress::BakeProgress;
use super::receiver::BakeReceiver;
use super::settings::MAX_LINK_BYTES;
use super::state::{BakeState, GatherCache};
use super::visibility::Visibility;
use super::{BakeError, BakeMethod, BakeSettings};
use crate::charts::Chart;
use crate::elements::{Element, Elements};

mod path;

use path::PathLight;

/// Paths that are traced together: enough for batches of rays, few enough for caches.
const PATHS_AT_ONCE: usize = 1024;

/// Elements whose rays are traced between two reports of progress.
const ELEMENTS_AT_ONCE: usize = 256;

/// Rays from an element, and from one of the smaller elements of the hierarchical solver.
const RAYS_PER_ELEMENT: usize = 256;
const RAYS_PER_SMALL_ELEMENT: usize = 128;

/// Largest number of links between elements: an element has at most one for each of its rays.
const MAX_LINKS: usize = MAX_LINK_BYTES / size_of::<ElementLink>();

/// Largest number of elements of the hierarchical solver: their rays make no more links than allowed.
pub(super) const MAX_SMALL_ELEMENTS: usize = MAX_LINKS / RAYS_PER_SMALL_ELEMENT;

/// Rays that decide whether a point lies inside a solid.
const INSIDE_RAYS: usize = 16;

/// Change of an element, relative to the brightest one, at which rounds between elements end, and their largest number.
const CONVERGED: f32 = 1e-4;
const MAX_ROUNDS: u32 = 1000;

/// Key of the sampled directions; the same for all texels, so that adjacent texels and charts agree.
const KEY: u64 = 0x6761_7468;

/// Everything that is needed to gather indirect light.
pub(super) struct FinalGather<'a> {
    pub(super) elements: &'a Elements<'a>,
    pub(super) charts: &'a [Chart],
    index: &'a SurfaceIndex,
    visibility: Visibility<'a>,
    /// Mean direct irradiance of the texels of each chart.
    direct: Vec<Vec<Spectrum>>,
    /// Directions around z, distributed by the cosine.
    directions: Vec<DVec3>,
    /// Indirect irradiance of each element.
    indirect: Vec<Spectrum>,
    /// Rays from an element.
    rays_per_element: usize,
    /// Whether light reaches each chart, and whether the chart is on the dark inside of a solid.
    is_lit: Vec<bool>,
    is_dark: Vec<bool>,
    /// Light that was gathered before.
    cache: GatherCache,
    /// Whether the indirect light of the elements is known.
    is_solved: bool,
    /// The state without the light of elements and of gathered points.
    before: BakeState,
}

/// Light gathered at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GatheredLight {
    /// Indirect irradiance, in units of radiance.
    pub(super) light: Spectrum,
    /// Harmonic mean of the distances of the hits, metres; infinite without hits.
    pub(super) distance: f64,
    /// Whether a ray leaves the scene or hits a chart that light reaches.
    pub(super) sees_light: bool,
}

impl<'a> FinalGather<'a> {
    pub(super) fn new(
        elements: &'a Elements<'a>,
        index: &'a SurfaceIndex,
        charts: &'a [Chart],
        direct: &[DirectMap],
        settings: &BakeSettings,
    ) -> Self {
        let rays = settings.rays;
        let sobol = ScrambledSobol::new(KEY);
        let direction = |i: u32| {
            let [x, y] = sobol.pair(i.reverse_bits(), 0).map(unit);
            warp::cosine_hemisphere(glanz_math::DVec2::new(x, y))
        };
        let of_chart = |(chart, direct): (&Chart, &DirectMap)| {
            let light = |texel| (!direct.at(texel).is_empty()).then(|| direct.mean(texel));
            let size = chart.size.map(|n| n as usize);
            super::fill::filled((0..chart.texels()).map(light).collect(), size)
        };
        Self {
            elements,
            charts,
            index,
            visibility: Visibility::new(settings.method, elements.scene),
            direct: charts.par_iter().zip(direct).map(of_chart).collect(),
            directions: (0..rays.max(INSIDE_RAYS as u32)).map(direction).collect(),
            indirect: vec![Spectrum::BLACK; elements.list.len()],
            rays_per_element: match settings.method {
                BakeMethod::Gather => RAYS_PER_ELEMENT,
                BakeMethod::Radiosity { .. } => RAYS_PER_SMALL_ELEMENT,
            },
            is_lit: direct.iter().map(DirectMap::is_lit).collect(),
            is_dark: dark_insides(elements, charts, direct),
            cache: GatherCache::default(),
            is_solved: false,
            before: BakeState::default(),
        }
    }

    /// Replaces the elements by others, whose light is not known.
    pub(super) fn with_elements<'b>(
        self,
        elements: &'b Elements<'b>,
        index: &'b SurfaceIndex,
    ) -> FinalGather<'b>
    where
        'a: 'b,
    {
        FinalGather { elements, index, indirect: vec![Spectrum::BLACK; elements.list.len()], ..self }
    }

    /// Keeps direct light and parts for the states to resume from.
    pub(super) fn keep(&mut self, state: &BakeState) {
        let (parts, direct) = (state.parts.clone(), state.direct.clone());
        self.before = BakeState { parts, direct, ..BakeState::default() };
    }

    /// Resumes from a state; `false` if it belongs to other elements.
    pub(super) fn resume(&mut self, state: BakeState) -> bool {
        self.keep(&state);
        let BakeState { indirect, gathered, solution, .. } = state;
        if solution.is_some() {
            return false;
        }
        self.cache = GatherCache::new(gathered);
        let Some(indirect) = indirect else { return true };
        if indirect.len() != self.indirect.len() {
            return false;
        }
        self.resume_indirect(indirect);
        true
    }

    /// Resumes with the indirect irradiance of each element.
    pub(super) fn resume_indirect(&mut self, indirect: Vec<Spectrum>) {
        self.indirect = indirect;
        self.mark_lit_charts();
    }

    /// State to resume from.
    pub(super) fn state(&self) -> BakeState {
        BakeState {
            indirect: self.is_solved.then(|| self.indirect.clone()),
            gathered: self.cache.to_map(),
            ..self.before.clone()
        }
    }

    /// Whether the indirect light of the elements is known.
    pub(super) fn is_solved(&self) -> bool {
        self.is_solved
    }

    /// Gathers light between elements until it no longer changes.
    ///
    /// # Errors
    /// [`BakeError::Memory`] if the elements have too many links.
    pub(super) fn solve(&mut self, progress: &mut BakeProgress<'_>) -> Result<(), BakeError> {
        let rows = self.rows(MAX_LINKS, progress)?;
        for _ in 0..MAX_ROUNDS {
            progress.report(1.0, || self.state())?;
            let (mut change, mut most) = (0.0_f32, 0.0_f32);
            for (i, row) in rows.iter().enumerate() {
                let mut light = row.direct;
                for &(j, weight) in &row.links {
                    light += weight * self.indirect[j as usize];
                }
                change = change.max((light - self.indirect[i]).map(f32::abs).max_component());
                most = most.max(light.max_component());
                self.indirect[i] = light;
            }
            if change <= CONVERGED * most {
                break;
            }
        }
        self.mark_lit_charts();
        Ok(())
    }

    /// Traces the rays of all elements.
    ///
    /// # Errors
    /// [`BakeError::Memory`] if they make more than `max_links` links.
    pub(super) fn rows(
        &self,
        max_links: usize,
        progress: &mut BakeProgress<'_>,
    ) -> Result<Vec<ElementRow>, BakeError> {
        let list = &self.elements.list;
        let mut rows: Vec<ElementRow> = Vec::with_capacity(list.len());
        let mut links = 0;
        for group in list.chunks(ELEMENTS_AT_ONCE) {
            // Rows are not part of a state: an interruption repeats this phase.
            progress.report(rows.len() as f64 / list.len() as f64, || self.state())?;
            let found: Vec<ElementRow> = group.par_iter().map(|element| self.row(element)).collect();
            links += found.iter().map(|row| row.links.len()).sum::<usize>();
            if links > max_links {
                return Err(BakeError::Memory(list.len()));
            }
            rows.extend(found);
        }
        Ok(rows)
    }

    /// Marks charts with lit elements, once the light of the elements is known.
    fn mark_lit_charts(&mut self) {
        self.is_solved = true;
        let elements = self.elements;
        let lit: Vec<bool> = self.indirect.iter().map(|light| !light.is_black()).collect();
        for (element, _) in elements.list.iter().zip(lit).filter(|(_, lit)| *lit) {
            self.mark_lit_chart(element);
        }
    }

    fn mark_lit_chart(&mut self, element: &Element) {
        if let Some((chart, _)) = self.index.texel(self.charts, &element_center(element)) {
            self.is_lit[chart] = !self.is_dark[chart];
        }
    }

    /// Irradiance of an element as a function of that of the others.
    fn row(&self, element: &Element) -> ElementRow {
        let mut row = ElementRow { direct: Spectrum::BLACK, links: Vec::new() };
        let mut links: BTreeMap<u32, Spectrum> = BTreeMap::new();
        let open = self.open_receivers(element);
        let weight = 1.0 / self.rays_per_element as f32;
        for light in self.trace_paths(open.iter().cycle().take(self.rays_per_element).zip(0..)) {
            row.direct += light.emitted * weight;
            row.direct += light.direct * weight;
            if let Some((other, share)) = light.element {
                *links.entry(other).or_default() += share * weight;
            }
        }
        row.links = links.into_iter().collect();
        row
    }

    /// Points of an element from which rays start: its quadrature points that are not inside a solid.
    fn open_receivers(&self, element: &Element) -> Vec<BakeReceiver> {
        let patch = &element.patch;
        if self.is_dark_at(&element_center(element)) {
            return Vec::new();
        }
        let points = patch.domain.quadrature_points().into_iter().map(|uv| ParametricPoint {
            surface: patch.surface,
            face: patch.face,
            back: patch.back,
            uv,
        });
        let receivers = points.filter_map(|point| BakeReceiver::new(self.elements, &point));
        receivers.filter(|receiver| self.sees(receiver, |place| !self.is_dark_at(place))).collect()
    }

    /// Number of receivers for which it is best to gather light together.
    pub(super) fn receivers_at_once(&self) -> usize {
        (PATHS_AT_ONCE / self.directions.len()).max(1)
    }

    /// Light gathered at receivers over their hemispheres.
    pub(super) fn gather(&self, receivers: &[BakeReceiver]) -> Vec<GatheredLight> {
        self.cache.get_or_gather(receivers, |receivers| self.gather_hemispheres(receivers))
    }

    fn gather_hemispheres(&self, receivers: &[&BakeReceiver]) -> Vec<GatheredLight> {
        // Rays in the same direction are neighbours.
        let starts = (0..self.directions.len()).flat_map(|i| receivers.iter().map(move |&at| (at, i)));
        let lights = self.trace_paths(starts);
        let of_receiver = |number| lights.iter().skip(number).step_by(receivers.len());
        (0..receivers.len()).map(|number| self.hemisphere_light(of_receiver(number))).collect()
    }

    /// Sum of the light of all directions of a receiver.
    fn hemisphere_light<'p>(&self, paths: impl Iterator<Item = &'p PathLight>) -> GatheredLight {
        let weight = 1.0 / self.directions.len() as f32;
        let (mut light, mut nearness, mut sees_light) = (Spectrum::BLACK, 0.0, false);
        for path in paths {
            light += path.emitted * weight;
            match path.end {
                None => sees_light = true,
                Some(end) => {
                    nearness += 1.0 / end.distance;
                    sees_light |= end.is_lit;
                    let indirect =
                        path.element.and_then(|(i, share)| Some(*self.indirect.get(i as usize)? * share));
                    light += (path.direct + indirect.unwrap_or_default()).map(|x| x.max(0.0)) * weight;
                }
            }
        }
        GatheredLight { light, distance: self.directions.len() as f64 / nearness, sees_light }
    }

    /// Whether one of a few rays leaves the scene or hits a chart that light reaches.
    pub(super) fn sees_light(&self, receiver: &BakeReceiver) -> bool {
        self.sees(receiver, |place| self.is_lit_at(place))
    }

    /// Whether a part of an element is outside of all solids.
    pub(super) fn is_open(&self, element: &Element) -> bool {
        !self.open_receivers(element).is_empty()
    }

    /// Indirect irradiance of each element, see [`FinalGather::solve`].
    pub(super) fn indirect(&self) -> &[Spectrum] {
        &self.indirect
    }

    /// Whether one of a few rays leaves the scene or hits a point that satisfies `condition`.
    fn sees(&self, receiver: &BakeReceiver, condition: impl Fn(&ParametricPoint) -> bool) -> bool {
        (0..INSIDE_RAYS).any(|number| self.ray_end(receiver, number).is_none_or(|end| condition(&end)))
    }

    fn is_dark_at(&self, place: &ParametricPoint) -> bool {
        self.index.texel(self.charts, place).is_some_and(|(chart, _)| self.is_dark[chart])
    }

    /// Whether light reaches the chart of a point; assumed for points without a chart.
    fn is_lit_at(&self, place: &ParametricPoint) -> bool {
        self.index.texel(self.charts, place).is_none_or(|(chart, _)| self.is_lit[chart])
    }

    /// Whether light reaches an element or texel of a chart.
    pub(super) fn is_lit(&self, chart: usize) -> bool {
        self.is_lit[chart]
    }

    /// Whether a chart is on the dark inside of a solid.
    pub(super) fn is_dark(&self, chart: usize) -> bool {
        self.is_dark[chart]
    }

    /// Mean direct irradiance of the texel next to a point; `None` without a chart.
    pub(super) fn direct_at(&self, place: &ParametricPoint) -> Option<Spectrum> {
        self.direct_on(self.index.texel(self.charts, place)?)
    }

    /// Mean direct irradiance of a texel, by the numbers of its chart and itself.
    fn direct_on(&self, (chart, texel): (usize, usize)) -> Option<Spectrum> {
        self.direct.get(chart)?.get(texel).copied()
    }
}

/// The point in the middle of an element's parameters.
fn element_center(element: &Element) -> ParametricPoint {
    let patch = &element.patch;
    ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv: patch.domain.center() }
}

/// Number of another element, and the factor on its indirect irradiance.
type ElementLink = (u32, Spectrum);

/// Indirect irradiance of an element: a constant and a linear function of that of others.
#[derive(Debug)]
pub(super) struct ElementRow {
    direct: Spectrum,
    pub(super) links: Vec<ElementLink>,
}
