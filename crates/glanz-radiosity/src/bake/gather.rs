//! Light that comes from other surfaces.

use std::collections::BTreeMap;

use glanz_light::Spectrum;
use glanz_math::{DVec3, Frame};
use glanz_sampling::hash::permute;
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_sampling::warp;
use glanz_scene::{Interaction, Light, ParametricPoint, Scene};
use rayon::prelude::*;

use super::closed::dark_insides;
use super::direct::{DirectMap, luminance};
use super::lookup::Index;
use super::progress::BakeProgress;
use super::state::{BakeState, Memory};
use super::visibility::{MOST_PASSED, Visibility};
use super::{BakeError, BakeMethod, BakeSettings, Spot};
use crate::charts::Chart;
use crate::elements::{Element, Elements};

/// Rays from an element, and from one of those that the hierarchical solver made.
const FROM_ELEMENT: usize = 256;
const FROM_SMALL_ELEMENT: usize = 128;

/// Bounces between things that are near.
const BOUNCES: u32 = 8;

/// Rays that decide whether a place lies inside of something.
const LOOK: usize = 16;

/// Change of the brightest element with which elements have found their light, and rounds at most.
const SETTLED: f32 = 1e-4;
const ROUNDS: u32 = 1000;

/// Key of the points that pick directions: the same everywhere, so that neighbours and charts that meet agree.
const KEY: u64 = 0x6761_7468;

/// What is asked when light is gathered.
pub(super) struct Gather<'a> {
    pub(super) elements: &'a Elements<'a>,
    pub(super) charts: &'a [Chart],
    index: &'a Index,
    visibility: Visibility<'a>,
    direct: Vec<Vec<Spectrum>>,
    /// Directions around z, by the cosine.
    directions: Vec<DVec3>,
    /// Irradiance of each element, but for direct light.
    indirect: Vec<Spectrum>,
    /// Rays from an element.
    from_element: usize,
    /// Whether light comes to each chart, and whether it is known that none does.
    is_lit: Vec<bool>,
    is_dark: Vec<bool>,
    /// What was gathered before.
    memory: Memory,
    /// Whether elements have found their light by gathering it here.
    is_solved: bool,
}

/// What was found at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gathered {
    /// Irradiance.
    pub(super) light: Spectrum,
    /// Harmonic mean of the distances, metres; infinite if nothing is met.
    pub(super) distance: f64,
    /// Whether anything is met that light reaches, or nothing at all.
    pub(super) sees_out: bool,
}

/// Where a ray ended.
struct End {
    at: Interaction,
    place: ParametricPoint,
    /// Factor on what leaves there.
    share: Spectrum,
}

impl<'a> Gather<'a> {
    pub(super) fn new(
        elements: &'a Elements<'a>,
        index: &'a Index,
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
            visibility: Visibility::of(settings.method, elements.scene),
            direct: charts.par_iter().zip(direct).map(of_chart).collect(),
            directions: (0..rays.max(LOOK as u32)).map(direction).collect(),
            indirect: vec![Spectrum::BLACK; elements.list.len()],
            from_element: match settings.method {
                BakeMethod::Gather => FROM_ELEMENT,
                BakeMethod::Radiosity { .. } => FROM_SMALL_ELEMENT,
            },
            is_lit: direct.iter().map(DirectMap::is_lit).collect(),
            is_dark: dark_insides(elements, charts, direct),
            memory: Memory::default(),
            is_solved: false,
        }
    }

    /// The same with other elements.
    pub(super) fn on<'b>(self, elements: &'b Elements<'b>, index: &'b Index) -> Gather<'b>
    where
        'a: 'b,
    {
        Gather { elements, index, indirect: vec![Spectrum::BLACK; elements.list.len()], ..self }
    }

    /// Resumes what was found before; `false` if that is of other elements.
    pub(super) fn resume(&mut self, state: BakeState) -> bool {
        let BakeState { indirect, gathered, solution } = state;
        if solution.is_some() {
            return false;
        }
        self.memory = Memory::new(gathered);
        let Some(indirect) = indirect else { return true };
        if indirect.len() != self.indirect.len() {
            return false;
        }
        self.resume_indirect(indirect);
        true
    }

    /// Resumes with the light of elements, one each.
    pub(super) fn resume_indirect(&mut self, indirect: Vec<Spectrum>) {
        self.indirect = indirect;
        self.light_all_up();
    }

    /// What was found so far.
    pub(super) fn state(&self) -> BakeState {
        BakeState {
            indirect: self.is_solved.then(|| self.indirect.clone()),
            gathered: self.memory.everything(),
            solution: None,
        }
    }

    /// Whether elements have found their light by gathering it.
    pub(super) fn is_solved(&self) -> bool {
        self.is_solved
    }

    /// Elements gather light from one another until it no longer changes.
    pub(super) fn solve(&mut self, progress: &mut BakeProgress<'_>) -> Result<(), BakeError> {
        let list = &self.elements.list;
        let mut rows: Vec<Row> = Vec::with_capacity(list.len());
        for group in list.chunks(256) {
            // Nothing of this phase is kept.
            progress.report(rows.len() as f64 / list.len() as f64, BakeState::default)?;
            let found: Vec<Row> = group.par_iter().map(|element| self.row(element)).collect();
            rows.extend(found);
        }
        for _ in 0..ROUNDS {
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
            if change <= SETTLED * most {
                break;
            }
        }
        self.light_all_up();
        Ok(())
    }

    /// Elements have found their light: what is lit is known.
    fn light_all_up(&mut self) {
        self.is_solved = true;
        let elements = self.elements;
        let lit: Vec<bool> = self.indirect.iter().map(|light| !light.is_black()).collect();
        for (element, _) in elements.list.iter().zip(lit).filter(|(_, lit)| *lit) {
            self.light_up(element);
        }
    }

    fn light_up(&mut self, element: &Element) {
        if let Some((chart, _)) = self.index.texel(self.charts, &place_of(element)) {
            self.is_lit[chart] = !self.is_dark[chart];
        }
    }

    /// What an element gathers, as a function of the others.
    fn row(&self, element: &Element) -> Row {
        let mut row = Row { direct: Spectrum::BLACK, links: Vec::new() };
        let mut links: BTreeMap<u32, Spectrum> = BTreeMap::new();
        let open = self.open_spots(element);
        let weight = 1.0 / self.from_element as f32;
        for i in 0..if open.is_empty() { 0 } else { self.from_element } {
            let spot = &open[i % open.len()];
            let direction = self.directions[i % self.directions.len()];
            let (own, end) = self.follow(spot, Frame::from_z(spot.shading).to_world(direction), i);
            row.direct += own * weight;
            let Some(end) = end else { continue };
            let (light, last) = self.walk(spot, end, i);
            row.direct += light * weight;
            if let Some((other, share)) = last {
                *links.entry(other).or_default() += share * weight;
            }
        }
        row.links = links.into_iter().collect();
        row
    }

    /// Places of an element from which rays start: those inside of something stand for nothing.
    fn open_spots(&self, element: &Element) -> Vec<Spot> {
        let patch = &element.patch;
        if self.is_dark_at(&place_of(element)) {
            return Vec::new();
        }
        let places = patch.part.nodes().into_iter().map(|uv| ParametricPoint {
            surface: patch.surface,
            face: patch.face,
            back: patch.back,
            uv,
        });
        let spots = places.filter_map(|place| Spot::new(self.elements, &place));
        spots.filter(|spot| self.sees(spot, |place| !self.is_dark_at(place))).collect()
    }

    /// Irradiance at a spot from all its surroundings.
    pub(super) fn at(&self, spot: &Spot) -> Gathered {
        self.memory.recall(spot, || self.around(spot))
    }

    fn around(&self, spot: &Spot) -> Gathered {
        let frame = Frame::from_z(spot.shading);
        let weight = 1.0 / self.directions.len() as f32;
        let (mut light, mut nearness, mut sees_out) = (Spectrum::BLACK, 0.0, false);
        for (i, &direction) in self.directions.iter().enumerate() {
            let (own, end) = self.follow(spot, frame.to_world(direction), i);
            light += own * weight;
            match end {
                None => sees_out = true,
                Some(end) => {
                    nearness += 1.0 / end.at.point.position.distance(spot.at.point.position);
                    sees_out |= self.is_lit_at(&end.place);
                    let (direct, last) = self.walk(spot, end, i);
                    let indirect = last.and_then(|(i, share)| Some(*self.indirect.get(i as usize)? * share));
                    light += (direct + indirect.unwrap_or_default()).map(|x| x.max(0.0)) * weight;
                }
            }
        }
        Gathered { light, distance: self.directions.len() as f64 / nearness, sees_out }
    }

    /// Whether a spot sees anything that light reaches, by a few rays.
    pub(super) fn sees_out(&self, spot: &Spot) -> bool {
        self.sees(spot, |place| self.is_lit_at(place))
    }

    /// Whether an element is not all inside of something.
    pub(super) fn is_open(&self, element: &Element) -> bool {
        !self.open_spots(element).is_empty()
    }

    /// The light of the elements, see [`Gather::solve`].
    pub(super) fn indirect(&self) -> &[Spectrum] {
        &self.indirect
    }

    /// Whether a spot sees nothing at all in some direction, or a place that `is_it`, by a few rays.
    fn sees(&self, spot: &Spot, is_it: impl Fn(&ParametricPoint) -> bool) -> bool {
        let frame = Frame::from_z(spot.shading);
        self.directions.iter().take(LOOK).enumerate().any(|(i, &direction)| {
            let (_, end) = self.follow(spot, frame.to_world(direction), i);
            end.is_none_or(|end| is_it(&end.place))
        })
    }

    fn is_dark_at(&self, place: &ParametricPoint) -> bool {
        self.index.texel(self.charts, place).is_some_and(|(chart, _)| self.is_dark[chart])
    }

    /// Whether light reaches the side of the chart that a place is on; what has no chart is not known.
    fn is_lit_at(&self, place: &ParametricPoint) -> bool {
        self.index.texel(self.charts, place).is_none_or(|(chart, _)| self.is_lit[chart])
    }

    /// Whether light reaches any element or texel of a chart.
    pub(super) fn is_lit(&self, chart: usize) -> bool {
        self.is_lit[chart]
    }

    /// Whether a chart is on the dark inside of a solid.
    pub(super) fn is_dark(&self, chart: usize) -> bool {
        self.is_dark[chart]
    }

    pub(super) fn direct_at(&self, place: &ParametricPoint) -> Option<Spectrum> {
        let (chart, texel) = self.index.texel(self.charts, place)?;
        self.direct.get(chart)?.get(texel).copied()
    }

    /// Radiosity at the end of a ray: what direct light leads to, and the share of an element's indirect light.
    ///
    /// An element that is nearer than it is large does not tell what light there is: the ray goes on from there by the cosine, in a gap under a
    /// vase from wall to wall, until it is far enough.
    fn walk(&self, from: &Spot, end: End, ray: usize) -> (Spectrum, Option<(u32, Spectrum)>) {
        let (mut light, mut share) = (Spectrum::BLACK, Spectrum::ONE);
        let (mut from, mut end) = (*from, end);
        for bounce in 1.. {
            if self.is_dark_at(&end.place) {
                break;
            }
            share *= end.share * self.visibility.reflected(&end.at);
            light += share * self.direct_at(&end.place).unwrap_or_default();
            let Some(number) = self.index.element(self.elements, &end.place) else { break };
            let area = self.elements.list.get(number as usize).map_or(0.0, |element| element.area);
            let way = end.at.point.position.distance_squared(from.at.point.position);
            if way >= area || bounce > BOUNCES || share.is_black() {
                return (light, Some((number, share)));
            }
            let Some(next) = Spot::new(self.elements, &end.place) else { break };
            // The same for all places, so that neighbours agree; another one at each bounce.
            let pick = permute(ray as u32, self.directions.len() as u32, KEY + u64::from(bounce));
            let Some(&direction) = self.directions.get(pick as usize) else { break };
            let (own, there) =
                self.follow(&next, Frame::from_z(next.shading).to_world(direction), pick as usize);
            light += share * own;
            let Some(there) = there else { break };
            (from, end) = (next, there);
        }
        (light, None)
    }

    /// Where a ray ends, and pi times the radiance of lights on the way that no shadow ray can look for.
    ///
    /// At clear glass it passes straight on or ends, with the probability of either.
    fn follow(&self, spot: &Spot, direction: DVec3, ray: usize) -> (Spectrum, Option<End>) {
        let (mut found, mut share) = (Spectrum::BLACK, Spectrum::ONE);
        if spot.normal.dot(direction) <= 0.0 {
            // Below the surface though not below the shading normal: nothing comes from there.
            return (found, None);
        }
        let scene = self.elements.scene;
        let mut way = spot.at.spawn(direction);
        for passed in 0..MOST_PASSED {
            let Some((at, place)) = scene.intersect_parametric(&way, f64::INFINITY) else {
                return (found, None);
            };
            if is_found_by_chance(scene, &at) {
                found += share * scene.emitted(&at, at.wo) * std::f32::consts::PI;
            }
            let through = self.visibility.passed(&at);
            let probability = luminance(through);
            // The same for all places, so that neighbours agree.
            let turn = permute(ray as u32, self.directions.len() as u32, KEY ^ (u64::from(passed) << 32));
            let pick = (turn as f32 + 0.5) / self.directions.len() as f32;
            if pick >= probability {
                share *= 1.0 / (1.0 - probability);
                return (found, Some(End { at, place, share }));
            }
            share *= through * (1.0 / probability);
            way = at.spawn(direction);
        }
        (found, None)
    }
}

/// Whether a surface shines, and cannot be picked by light sampling.
fn is_found_by_chance(scene: &Scene, at: &Interaction) -> bool {
    at.light().is_some_and(|id| match scene.light(id) {
        Some(Light::Area(light)) => luminance(scene.emitted(at, at.wo)) > 0.0 && !light.can_be_sampled(),
        _ => false,
    })
}

/// The middle of an element.
fn place_of(element: &Element) -> ParametricPoint {
    let patch = &element.patch;
    ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv: patch.part.center() }
}

/// Irradiance of an element but for direct light: a constant, and shares of that of others.
struct Row {
    direct: Spectrum,
    links: Vec<(u32, Spectrum)>,
}
