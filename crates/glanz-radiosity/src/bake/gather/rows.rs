//! Rays of elements, as rows of the equations of their light.

use std::collections::BTreeMap;
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::DVec2;
use glanz_sampling::hash::combine;
use glanz_sampling::sequence::owen::{ScrambledSobol, unit};
use glanz_scene::ParametricPoint;
use rayon::prelude::*;

use super::super::BakeError;
use super::super::progress::{BakeProgress, PhaseWork};
use super::super::receiver::BakeReceiver;
use super::super::state::BakeState;
use super::{FinalGather, KEY, direction, element_center};
use crate::elements::{Element, ParameterPatch};

/// Elements whose rays are traced between two reports of progress.
const ELEMENTS_AT_ONCE: usize = 256;

/// Largest number of links in a state, so that checkpoints are written in seconds.
const MAX_SAVED_LINKS: usize = 1 << 23;

/// Key of the points of elements from which rays start.
const POINT_KEY: u64 = 0x706f_696e;

/// Number of another element, and the factor on its indirect irradiance.
pub(super) type ElementLink = (u32, Spectrum);

/// Indirect irradiance of an element: a constant and a linear function of that of others.
#[derive(Debug, PartialEq)]
pub(in super::super) struct ElementRow {
    pub(in super::super) direct: Spectrum,
    pub(in super::super) links: Vec<ElementLink>,
}

impl FinalGather<'_> {
    /// State to resume from while light between elements is computed, with as many of their rays as fit.
    pub(super) fn state_with_rows(&self, rows: &[Arc<ElementRow>]) -> BakeState {
        let mut links = 0;
        let fits = |row: &&Arc<ElementRow>| {
            links += row.links.len();
            links <= MAX_SAVED_LINKS
        };
        BakeState { rows: Some(rows.iter().take_while(fits).cloned().collect()), ..self.state() }
    }

    /// Traces the rays of all elements, from those that are known.
    ///
    /// # Errors
    /// [`BakeError::Memory`] if they make more than `max_links` links.
    pub(in super::super) fn rows(
        &self,
        max_links: usize,
        progress: &mut BakeProgress<'_>,
    ) -> Result<Vec<Arc<ElementRow>>, BakeError> {
        let list = &self.elements.list;
        let count = |rows: &[Arc<ElementRow>]| rows.iter().map(|row| row.links.len()).sum::<usize>();
        let mut rows = self.rows.clone();
        let mut links = count(&rows);
        for group in list.get(rows.len()..).unwrap_or_default().chunks(ELEMENTS_AT_ONCE) {
            let [resumed, done, all] = [self.rows.len(), rows.len(), list.len()].map(|count| count as f64);
            progress.report(PhaseWork { resumed, done, all }, || self.state_with_rows(&rows))?;
            let own = |(number, element): (usize, &Element)| Arc::new(self.row(rows.len() + number, element));
            let found: Vec<Arc<ElementRow>> = group.par_iter().enumerate().map(own).collect();
            links += count(&found);
            if links > max_links {
                return Err(BakeError::Memory(list.len()));
            }
            rows.extend(found);
        }
        Ok(rows)
    }

    /// Irradiance of an element as a function of that of the others. Every element, by its number, has directions of its own, so that their
    /// errors have no common part, which would not be averaged in reflections.
    pub(super) fn row(&self, number: usize, element: &Element) -> ElementRow {
        let mut row = ElementRow { direct: Spectrum::BLACK, links: Vec::new() };
        let mut links: BTreeMap<u32, Spectrum> = BTreeMap::new();
        let open = self.open_receivers(number, element);
        let all: f64 = open.iter().map(|(_, area)| area).sum();
        let key = combine(KEY, number as u64);
        let sobol = ScrambledSobol::new(key);
        // Directions of a block are spread over the hemisphere, single ones of equal distance in the sequence over a part of it.
        let rays = self.rays_per_element;
        let start = |i: usize| open.get(i * open.len() / rays).map(|start| (i, start));
        let starts: Vec<_> = (0..rays).filter_map(start).collect();
        let paths = starts.iter().map(|&(i, (receiver, _))| {
            (receiver, direction(&sobol, i as u32), (key as u32 as usize).wrapping_add(i))
        });
        for (light, (_, (_, area))) in self.trace_paths(paths).iter().zip(&starts) {
            let weight = (area / all * open.len() as f64 / rays as f64) as f32;
            row.direct += light.emitted * weight;
            row.direct += light.direct * weight;
            if let Some((other, share)) = light.element {
                *links.entry(other).or_default() += share * weight;
            }
        }
        row.links = links.into_iter().collect();
        row
    }

    /// Points of an element from which rays start, one in each of 16 equal parts, without those inside solids; each with an area that it
    /// stands for, in any unit. `number`: selects the points.
    pub(super) fn open_receivers(&self, number: usize, element: &Element) -> Vec<(BakeReceiver, f64)> {
        let patch = &element.patch;
        if self.is_dark_at(&element_center(element)) {
            return Vec::new();
        }
        let sobol = ScrambledSobol::new(combine(POINT_KEY, number as u64));
        let quarters = patch.domain.quarters();
        let parts = quarters.iter().flat_map(ParameterPatch::quarters).zip(0_u32..);
        let receivers = parts.filter_map(|(part, i)| {
            let uv = part.at(DVec2::from(sobol.pair(i.reverse_bits(), 0).map(unit)));
            let place = ParametricPoint { surface: patch.surface, face: patch.face, back: patch.back, uv };
            let area = self
                .elements
                .surfaces
                .get(patch.surface as usize)?
                .at(place.face, uv, place.back)?
                .area_element;
            Some((BakeReceiver::new(self.elements, &place)?, area)).filter(|_| area > 0.0)
        });
        receivers.filter(|(receiver, _)| self.sees(receiver, |place| !self.is_dark_at(place))).collect()
    }
}
