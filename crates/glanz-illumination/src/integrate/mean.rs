//! Means of the illuminance over the cells of a receiver.

use std::cell::Cell;
use std::collections::{BinaryHeap, VecDeque};

use glanz_math::{DVec2, DVec3};

use super::queue::QueueEntry;
use super::region::{IntegrationRect, Tolerance};
use super::shadow::ShadowSum;
use super::{Reflections, light_position};

/// Nodes and weights of Gauss' rules of two and three points in [0, 1].
const TWO: [(f64, f64); 2] = [(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)];
const THREE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// Number of points of both rules in a square.
const POINTS: usize = TWO.len() * TWO.len() + THREE.len() * THREE.len();
/// Largest number of squares around lights that are close to a cell, and the number of times that it is quartered for them.
const MOST_SQUARES: usize = 2048;
const MOST_QUARTERINGS: u32 = 24;
/// Fraction of the tolerance for the illuminance at the points.
const SHARE: f64 = 0.25;
/// Fraction of the tolerance for the smooth part of the light if a part is not smooth.
const SMOOTH_SHARE: f64 = 0.5;

/// Illuminance over a part of a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellMean {
    /// Mean, lx; 0 without area.
    pub mean: f64,
    /// Estimated bound on the error of `mean`, lx.
    pub error: f64,
    /// m^2.
    pub area: f64,
}

/// A rectangle of the cell. The error of its queue entry is the difference of the rules, lm.
#[derive(Clone, Copy, Debug)]
struct CellRegion {
    rect: IntegrationRect,
    /// Integral of the illuminance, lm.
    flux: f64,
    /// Integral of the errors of the illuminance at the points, lm.
    inner: f64,
    /// m^2.
    area: f64,
}

/// The mean without the light of some sources, and a source of which something hides a part from a point.
#[derive(Clone, Copy, Debug)]
struct SmoothMean {
    mean: CellMean,
    shadow: Option<usize>,
}

/// Position in metres, unit normal and area per unit of the parameters (m^2) of a cell by parameters in the unit square; `None` where there is no surface.
pub(super) trait CellPatch: Fn(DVec2) -> Option<(DVec3, DVec3, f64)> {}

impl<P: Fn(DVec2) -> Option<(DVec3, DVec3, f64)>> CellPatch for P {}

/// A cell with its squares.
pub(super) struct DividedCell<'a, P> {
    pub(super) patch: &'a P,
    pub(super) squares: &'a [IntegrationRect],
}

impl Reflections<'_> {
    /// The mean of [`Reflections::illuminance`] over a part of a surface.
    ///
    /// `patch`: position in metres, unit normal and area per unit of the parameters (m^2) by parameters in the unit square; `None` where there is no
    /// surface. `points`: approximate limit of the number of evaluated points, in each square that is no larger than the distance of the nearest light. These are quartered
    /// where Gauss' rules of two and three points differ most, until the difference is within `tolerance`; details smaller than the distance of these points (a fifth of the
    /// square) may be missed. Direct light that something hides from a part of the cell is integrated over the cell and the light at once.
    pub fn cell_mean(
        &self,
        patch: impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)>,
        tolerance: Tolerance,
        points: usize,
    ) -> CellMean {
        let squares = self.around_lights(&patch);
        let cell = DividedCell { patch: &patch, squares: &squares };
        let sources = if self.integrates_shadows { 0..self.source_count() } else { 0..0 };
        let sums = sources.map(|source| ShadowSum::of_source(self, &cell, source));
        let mut shadows: Vec<ShadowSum> = sums.filter(ShadowSum::is_border).collect();
        let Tolerance { relative, absolute } = tolerance;
        loop {
            let left_out: Vec<usize> = shadows.iter().map(ShadowSum::source).collect();
            let share = if left_out.is_empty() { 1.0 } else { SMOOTH_SHARE };
            let lit: f64 = shadows.iter().map(|sum| sum.mean()[0]).sum();
            let of_smooth =
                Tolerance { relative: share * relative, absolute: share * absolute.max(relative * lit) };
            let SmoothMean { mut mean, shadow } = self.smooth_mean(&cell, of_smooth, points, &left_out);
            if let Some(source) = shadow.filter(|_| self.integrates_shadows) {
                shadows.push(ShadowSum::of_source(self, &cell, source));
                continue;
            }
            if mean.area > 0.0 {
                let allowed = (1.0 - SMOOTH_SHARE) * absolute.max(relative * (mean.mean + lit));
                for sum in &mut shadows {
                    sum.converge(self, &cell, allowed / left_out.len() as f64);
                    let [lux, error] = sum.mean();
                    mean.mean += lux;
                    mean.error += error;
                }
            }
            return mean;
        }
    }

    /// The mean by Gauss' rules, without direct light of the sources `left_out`. It ends at a point in the half shadow of another source.
    fn smooth_mean<P: CellPatch>(
        &self,
        cell: &DividedCell<'_, P>,
        tolerance: Tolerance,
        points: usize,
        left_out: &[usize],
    ) -> SmoothMean {
        let at_points =
            Tolerance { relative: SHARE * tolerance.relative, absolute: SHARE * tolerance.absolute };
        let points = points.saturating_mul(cell.squares.len());
        let mut evaluated = cell.squares.len() * POINTS;
        let shadow = Cell::new(None);
        let piece = |rect: IntegrationRect| {
            let (piece, hidden) = self.piece(cell, rect, at_points, left_out);
            shadow.set(shadow.get().or(hidden));
            piece
        };
        let mut heap: BinaryHeap<_> = cell.squares.iter().map(|square| piece(*square)).collect();
        let mean = loop {
            let mean = total(&heap);
            let allowed = tolerance.absolute.max(tolerance.relative * mean.mean);
            if shadow.get().is_some() || mean.error <= allowed || evaluated + 4 * POINTS > points {
                break mean;
            }
            let Some(worst) = heap.pop() else { break mean };
            heap.extend(worst.part.rect.quarters().map(piece));
            evaluated += 4 * POINTS;
        };
        SmoothMean { mean, shadow: shadow.get() }
    }

    /// A division of the cell into squares that are no larger than their distance from lights.
    pub(super) fn around_lights(&self, patch: &impl CellPatch) -> Vec<IntegrationRect> {
        let points: Vec<DVec3> = self.points.iter().filter_map(|(_, light)| light_position(light)).collect();
        let mut waiting = VecDeque::from([(IntegrationRect::UNIT, 0)]);
        let mut squares = Vec::new();
        while let Some((rect, quarterings)) = waiting.pop_front() {
            let place = |at: [f64; 2]| patch(rect.min + rect.size() * DVec2::from(at));
            let corners = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(place);
            let middle = place([0.5, 0.5]).or(corners.into_iter().flatten().next());
            let places: Vec<DVec3> = corners.iter().chain([&middle]).flatten().map(|(at, ..)| *at).collect();
            // Corners may be off the surface, or coincide: the area counts as well.
            let diagonal = |area_element: f64| (2.0 * area_element * rect.size().element_product()).sqrt();
            let by_area = middle.map_or(0.0, |(_, _, area_element)| diagonal(area_element));
            let distances = places.iter().flat_map(|a| places.iter().map(|b| a.distance(*b)));
            let size = distances.fold(by_area, f64::max);
            let is_close = |(middle, ..): (DVec3, DVec3, f64)| {
                let is_near = |place: DVec3| place.distance_squared(middle) < size * size;
                points.iter().any(|point| is_near(*point))
                    || self.emitters.iter().any(|emitter| {
                        let is_dark = || places.iter().all(|at| emitter.is_dark_in(*at, 0.0));
                        is_near(emitter.nearest_of_axis(middle)) && !is_dark()
                    })
            };
            let is_limit = quarterings == MOST_QUARTERINGS || squares.len() + waiting.len() >= MOST_SQUARES;
            if !is_limit && middle.is_some_and(is_close) {
                waiting.extend(rect.quarters().map(|quarter| (quarter, quarterings + 1)));
            } else {
                squares.push(rect);
            }
        }
        squares
    }

    /// A rectangle, and a source of which something hides a part from one of its points.
    fn piece<P: CellPatch>(
        &self,
        cell: &DividedCell<'_, P>,
        rect: IntegrationRect,
        tolerance: Tolerance,
        left_out: &[usize],
    ) -> (QueueEntry<CellRegion>, Option<usize>) {
        let scale = rect.size().x * rect.size().y;
        let mut shadow = None;
        let mut at = |at: DVec2| {
            let Some((point, normal, area_element)) = (cell.patch)(rect.min + rect.size() * at) else {
                return [0.0; 3];
            };
            let (found, hidden) = self.with_shadows(point, normal, tolerance, 0, left_out);
            shadow = shadow.or(hidden);
            let area = area_element * scale;
            [found.total() * area, found.error * area, area]
        };
        let ([flux, inner, area], [coarse, ..]) = (rule(&THREE, &mut at), rule(&TWO, &mut at));
        (QueueEntry { error: (flux - coarse).abs(), part: CellRegion { rect, flux, inner, area } }, shadow)
    }
}

/// The integral over the unit square by a rule of equal nodes along both axes.
fn rule<const N: usize>(nodes: &[(f64, f64)], mut values: impl FnMut(DVec2) -> [f64; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for &(x, at_x) in nodes {
        for &(y, at_y) in nodes {
            for (sum, value) in sums.iter_mut().zip(values(DVec2::new(x, y))) {
                *sum += at_x * at_y * value;
            }
        }
    }
    sums
}

fn total(heap: &BinaryHeap<QueueEntry<CellRegion>>) -> CellMean {
    let sum = |of: fn(&QueueEntry<CellRegion>) -> f64| heap.iter().map(of).sum::<f64>();
    let area = sum(|entry| entry.part.area);
    if area <= 0.0 {
        return CellMean::default();
    }
    let error = sum(|entry| entry.error) + sum(|entry| entry.part.inner);
    CellMean { mean: sum(|entry| entry.part.flux) / area, error: error / area, area }
}
