//! Means of the illuminance over the cells of a receiver.

use std::collections::BinaryHeap;

use glanz_math::{DVec2, DVec3};

use super::queue::QueueEntry;
use super::region::{IntegrationRect, Tolerance};
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

impl Reflections<'_> {
    /// The mean of [`Reflections::illuminance`] over a part of a surface.
    ///
    /// `patch`: position in metres, unit normal and area per unit of the parameters (m^2) by parameters in the unit square; `None` where there is no
    /// surface. `points`: approximate limit of the number of evaluated points, in each square that is no larger than the distance of the nearest light. These are quartered
    /// where Gauss' rules of two and three points differ most, until the difference is within `tolerance`; details smaller than the distance of these points (a fifth of the
    /// square) may be missed.
    pub fn cell_mean(
        &self,
        patch: impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)>,
        tolerance: Tolerance,
        points: usize,
    ) -> CellMean {
        let at_points =
            Tolerance { relative: SHARE * tolerance.relative, absolute: SHARE * tolerance.absolute };
        let squares = self.around_lights(&patch);
        let points = points.saturating_mul(squares.len());
        let mut evaluated = squares.len() * POINTS;
        let pieces = squares.into_iter().map(|rect| self.piece(&patch, rect, at_points));
        let mut heap: BinaryHeap<_> = pieces.collect();
        loop {
            let result = total(&heap);
            let allowed = tolerance.absolute.max(tolerance.relative * result.mean);
            if result.error <= allowed || evaluated + 4 * POINTS > points {
                return result;
            }
            let Some(worst) = heap.pop() else { return result };
            heap.extend(worst.part.rect.quarters().map(|rect| self.piece(&patch, rect, at_points)));
            evaluated += 4 * POINTS;
        }
    }

    /// A division of the cell into squares that are no larger than their distance from lights.
    fn around_lights(&self, patch: &impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)>) -> Vec<IntegrationRect> {
        let points: Vec<DVec3> = self.points.iter().filter_map(|(_, light)| light_position(light)).collect();
        let mut waiting = vec![(IntegrationRect::UNIT, 0)];
        let mut squares = Vec::new();
        while let Some((rect, quarterings)) = waiting.pop() {
            let place = |at: DVec2| patch(rect.min + rect.size() * at).map(|(position, ..)| position);
            let corners = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|at| place(DVec2::from(at)));
            let length = |[a, b]: [Option<DVec3>; 2]| a.zip(b).map_or(0.0, |(a, b)| a.distance(b));
            let size = length([corners[0], corners[1]]).max(length([corners[2], corners[3]]));
            let middle = place(DVec2::splat(0.5)).or(corners.into_iter().flatten().next());
            let is_close = |middle: DVec3| {
                let is_near = |place: DVec3| place.distance_squared(middle) < size * size;
                points.iter().any(|point| is_near(*point))
                    || self.emitters.iter().any(|emitter| {
                        let is_dark = || corners.iter().flatten().all(|at| emitter.is_dark_in(*at, 0.0));
                        emitter.middles().any(is_near) && !is_dark()
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

    fn piece(
        &self,
        patch: &impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)>,
        rect: IntegrationRect,
        tolerance: Tolerance,
    ) -> QueueEntry<CellRegion> {
        let scale = rect.size().x * rect.size().y;
        let at = |x: f64, y: f64| {
            let (point, normal, area_element) = patch(rect.min + rect.size() * DVec2::new(x, y))?;
            let found = self.illuminance(point, normal, tolerance);
            let area = area_element * scale;
            Some([found.total() * area, found.error * area, area])
        };
        let rule = |nodes: &[(f64, f64)]| {
            let mut sums = [0.0; 3];
            for &(x, at_x) in nodes {
                for &(y, at_y) in nodes {
                    let values = at(x, y).unwrap_or_default();
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += at_x * at_y * value;
                    }
                }
            }
            sums
        };
        let ([flux, inner, area], [coarse, ..]) = (rule(&THREE), rule(&TWO));
        QueueEntry { error: (flux - coarse).abs(), part: CellRegion { rect, flux, inner, area } }
    }
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
