//! Indirect light, gathered by rays over the hemisphere.

use std::sync::Arc;
use std::time::Instant;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::warp;
use glanz_scene::ParametricPoint;
use rayon::prelude::*;

use super::closed::dark_insides;
use super::direct_light::DirectMap;
use super::lookup::SurfaceIndex;
use super::progress::{BakeProgress, PhaseWork};
use super::receiver::BakeReceiver;
use super::settings::MAX_LINK_BYTES;
use super::state::{BakeState, GatherCache};
use super::visibility::Visibility;
use super::{BakeError, BakeMethod, BakeSettings};
use crate::charts::Chart;
use crate::elements::{Element, Elements};

mod path;
mod rows;

use path::PathLight;
use rows::ElementLink;
pub(super) use rows::ElementRow;

/// Paths that are traced together: enough for batches of rays, few enough for caches.
const PATHS_AT_ONCE: usize = 1024;

/// Trials that estimate the times of elements and points, for each thread.
const TRIALS_PER_THREAD: usize = 16;

/// Rays from an element, and from one of the smaller elements of the hierarchical solver.
const RAYS_PER_ELEMENT: usize = 256;
const RAYS_PER_SMALL_ELEMENT: usize = 128;

/// Largest number of links between elements: an element has at most one for each of its rays.
const MAX_LINKS: usize = MAX_LINK_BYTES / size_of::<ElementLink>();

/// Largest number of elements of a final gather that are divided further: their rays make no more links than allowed.
pub(super) const MAX_FINE_ELEMENTS: usize = MAX_LINKS / RAYS_PER_ELEMENT;

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
    /// Rays of the first elements.
    rows: Vec<Arc<ElementRow>>,
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
            directions: (0..rays.max(INSIDE_RAYS as u32)).map(|i| direction(&sobol, i)).collect(),
            indirect: vec![Spectrum::BLACK; elements.list.len()],
            rays_per_element: match settings.method {
                BakeMethod::Gather => RAYS_PER_ELEMENT,
                BakeMethod::Radiosity { .. } => RAYS_PER_SMALL_ELEMENT,
            },
            is_lit: direct.iter().map(DirectMap::is_lit).collect(),
            is_dark: dark_insides(elements, charts, direct),
            cache: GatherCache::default(),
            rows: Vec::new(),
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

    /// Keeps what other phases computed for the states to resume from.
    pub(super) fn keep(&mut self, state: &BakeState) {
        let BakeState { parts, direct, solution, coarse_error, .. } = state.clone();
        self.before = BakeState { parts, direct, solution, coarse_error, ..BakeState::default() };
    }

    /// Resumes from a state; `false` if it belongs to other elements.
    pub(super) fn resume(&mut self, state: BakeState) -> bool {
        self.keep(&state);
        let BakeState { rows, indirect, gathered, solution, .. } = state;
        if solution.is_some() || !self.resume_rows(rows.unwrap_or_default()) {
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

    /// Resumes with the rays of the first elements; `false` if they belong to other elements.
    pub(super) fn resume_rows(&mut self, rows: Vec<Arc<ElementRow>>) -> bool {
        let count = self.elements.list.len();
        let is_known = |&(other, _): &ElementLink| (other as usize) < count;
        let fits = rows.len() <= count && rows.iter().flat_map(|row| &row.links).all(is_known);
        self.rows = rows;
        fits
    }

    /// Resumes with the indirect irradiance of each element.
    pub(super) fn resume_indirect(&mut self, indirect: Vec<Spectrum>) {
        self.indirect = indirect;
        self.mark_lit_charts();
    }

    /// State to resume from.
    pub(super) fn state(&self) -> BakeState {
        let indirect = self.is_solved.then(|| self.indirect.clone());
        BakeState { indirect, gathered: self.cache.to_map(), ..self.before.clone() }
    }

    /// Whether the indirect light of the elements is known.
    pub(super) fn is_solved(&self) -> bool {
        self.is_solved
    }

    /// Gathers light between elements until it no longer changes.
    ///
    /// # Errors
    /// [`BakeError::Memory`] if the elements have too many links, [`BakeError::NotConverged`] if their light still changes after
    /// [`MAX_ROUNDS`].
    pub(super) fn solve(&mut self, progress: &mut BakeProgress<'_>) -> Result<(), BakeError> {
        let rows = self.rows(MAX_LINKS, progress)?;
        let mut has_converged = false;
        for _ in 0..MAX_ROUNDS {
            progress.report(PhaseWork::fraction(1.0), || self.state_with_rows(&rows))?;
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
                has_converged = true;
                break;
            }
        }
        if !has_converged {
            return Err(BakeError::NotConverged(MAX_ROUNDS));
        }
        // Those of a resumed state would take memory until the end.
        self.rows = Vec::new();
        self.mark_lit_charts();
        Ok(())
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

    /// Times, seconds, that an element and a point take of all threads together, from a few trials.
    pub(super) fn trial_times(&self) -> [f64; 2] {
        let list = &self.elements.list;
        let count = (TRIALS_PER_THREAD * rayon::current_num_threads()).min(list.len()).max(1);
        let spaced = || (0..count).filter_map(|i| Some((i, list.get(i * list.len() / count)?)));
        let seconds = |start: Instant| start.elapsed().as_secs_f64() / count as f64;
        let places = spaced().map(|(_, element)| element_center(element));
        let receivers: Vec<BakeReceiver> =
            places.filter_map(|place| BakeReceiver::new(self.elements, &place)).collect();
        let start = Instant::now();
        spaced().collect::<Vec<_>>().into_par_iter().for_each(|(i, element)| drop(self.row(i, element)));
        let of_element = seconds(start);
        let start = Instant::now();
        let together = receivers.par_chunks(self.receivers_at_once());
        together.for_each(|group| drop(self.gather_hemispheres(&group.iter().collect::<Vec<_>>())));
        [of_element, seconds(start)]
    }

    /// Number of points whose light a resumed state had.
    pub(super) fn points(&self) -> usize {
        self.cache.resumed()
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
        let numbered = self.directions.iter().zip(0..);
        let starts = numbered.flat_map(|(&way, i)| receivers.iter().map(move |&at| (at, way, i)));
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
                None => sees_light |= path.leaves_scene,
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
    pub(super) fn is_open(&self, number: usize, element: &Element) -> bool {
        !self.open_receivers(number, element).is_empty()
    }

    /// Indirect irradiance of each element, see [`FinalGather::solve`].
    pub(super) fn indirect(&self) -> &[Spectrum] {
        &self.indirect
    }

    /// Whether one of a few rays leaves the scene or hits a point that satisfies `condition`.
    fn sees(&self, receiver: &BakeReceiver, condition: impl Fn(&ParametricPoint) -> bool) -> bool {
        (0..INSIDE_RAYS).any(|number| self.ray_sees(receiver, number, &condition))
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

/// Direction `i` of a sequence around z, distributed by the cosine.
fn direction(sobol: &ScrambledSobol, i: u32) -> DVec3 {
    let [x, y] = sobol.pair(i.reverse_bits(), 0).map(unit);
    warp::cosine_hemisphere(DVec2::new(x, y))
}

/// The point in the middle of an element's parameters.
fn element_center(element: &Element) -> ParametricPoint {
    let patch = &element.patch;
    ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv: patch.domain.center() }
}
