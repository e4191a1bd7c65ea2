//! Integrals over parts of rectangles whose borders are found as roots along lines.
//!
//! Rectangles inside the region get a tensor rule. For a rectangle that the border crosses, one direction is selected as the height: the border crosses every line
//! along it at most once. The crossings are found as roots, and the rule is applied between them; across the height, it is applied between
//! the points where the border leaves the rectangle through its bottom and top. Smooth borders therefore do not reduce the order of convergence. Rectangles without such
//! a direction are divided, as is the rectangle with the largest error, until the sum of errors is small enough.
//!
//! # Source
//! @saye2015 for the method, in two dimensions; departures: the direction of the height is selected from a grid of samples instead of bounds on derivatives,
//! borders without a function, known as inside or outside only (shadows, trimming), are supported, and the error is estimated by an embedded rule.

use std::collections::BinaryHeap;

use glanz_math::DVec2;

use super::crossing::{GridSamples, ScanLine, root};
use super::queue::QueueEntry;
use super::rule::{GaussKronrod, NODES, integral, sharpened};

/// An integrand over a part of the plane, or of several planes, which are numbered by `part`.
pub(super) trait Region {
    /// Data of a sample point.
    type Sample: Copy;

    /// Evaluates a sample point.
    fn sample(&self, part: u32, at: DVec2) -> Self::Sample;

    /// The border function: positive inside, and smooth near its zeros where it is finite.
    fn border(sample: &Self::Sample) -> f64;

    /// Number of the smooth function that the border function equals here; the border has corners where two of them meet.
    fn branch(_sample: &Self::Sample) -> u32 {
        0
    }

    /// The integrand; `None` where the point is hidden. Called only where [`Region::border`] is positive.
    fn value(&self, part: u32, sample: &Self::Sample) -> Option<f64>;
}

/// An axis-parallel rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct IntegrationRect {
    pub(super) min: DVec2,
    pub(super) max: DVec2,
}

impl IntegrationRect {
    pub(super) const UNIT: Self = Self { min: DVec2::ZERO, max: DVec2::ONE };

    pub(super) fn center(&self) -> DVec2 {
        0.5 * (self.min + self.max)
    }

    pub(super) fn size(&self) -> DVec2 {
        self.max - self.min
    }

    pub(super) fn quarters(&self) -> [Self; 4] {
        let middle = self.center();
        [
            Self { min: self.min, max: middle },
            Self { min: DVec2::new(middle.x, self.min.y), max: DVec2::new(self.max.x, middle.y) },
            Self { min: DVec2::new(self.min.x, middle.y), max: DVec2::new(middle.x, self.max.y) },
            Self { min: middle, max: self.max },
        ]
    }
}

/// Tolerance of an integral: the integration ends when the error is below either bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// As a fraction of the result.
    pub relative: f64,
    /// In the unit of the result.
    pub absolute: f64,
}

/// An integral.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RegionIntegral {
    pub(super) value: f64,
    pub(super) error: f64,
}

/// A rectangle with its part of the integral.
#[derive(Clone, Copy, Debug)]
struct RegionCell {
    part: u32,
    rect: IntegrationRect,
    sum: RegionIntegral,
    depth: u32,
}

/// Largest number of divisions of a rectangle.
const DEEPEST: u32 = 24;

/// As [`integrate_counting`], without the number.
pub(super) fn integrate<R: Region>(
    region: &R,
    cells: impl IntoIterator<Item = (u32, IntegrationRect)>,
    known: RegionIntegral,
    tolerance: Tolerance,
    budget: usize,
) -> RegionIntegral {
    integrate_counting(region, cells, known, tolerance, budget).0
}

/// The integral over the rectangles `cells`, each with the number of its plane, and the number of rectangles that it took.
///
/// `known`: an integral computed elsewhere, which counts for the tolerance but is not in the result. Division creates about `budget` rectangles at most.
pub(super) fn integrate_counting<R: Region>(
    region: &R,
    cells: impl IntoIterator<Item = (u32, IntegrationRect)>,
    known: RegionIntegral,
    tolerance: Tolerance,
    budget: usize,
) -> (RegionIntegral, usize) {
    let measured = |part, rect: IntegrationRect, depth| {
        let sum = measure(region, part, &rect);
        QueueEntry { error: sum.error, part: RegionCell { part, rect, sum, depth } }
    };
    let mut heap: BinaryHeap<QueueEntry<RegionCell>> =
        cells.into_iter().map(|(part, rect)| measured(part, rect, 0)).collect();
    let total = |heap: &BinaryHeap<QueueEntry<RegionCell>>| {
        let mut all: Vec<RegionIntegral> = heap.iter().map(|entry| entry.part.sum).collect();
        // In an order that does not depend on the layout of the heap.
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        all.iter().fold(RegionIntegral::default(), |sum, s| RegionIntegral {
            value: sum.value + s.value,
            error: sum.error + s.error,
        })
    };
    let mut sum = total(&heap);
    let whole = heap.len();
    let mut divided = 0;
    let is_done = |sum: &RegionIntegral| {
        let allowed = tolerance.absolute.max(tolerance.relative * (known.value + sum.value));
        known.error + sum.error <= allowed
    };
    while !is_done(&sum) && divided < budget {
        let Some(entry) = heap.pop() else { break };
        let worst = entry.part;
        if worst.sum.error <= 0.0 || worst.depth >= DEEPEST {
            heap.push(entry);
            break;
        }
        for quarter in worst.rect.quarters() {
            let cell = measured(worst.part, quarter, worst.depth + 1);
            sum.value += cell.part.sum.value;
            sum.error += cell.part.sum.error;
            heap.push(cell);
        }
        sum.value -= worst.sum.value;
        sum.error -= worst.sum.error;
        divided += 4;
    }
    (total(&heap), whole + divided)
}

/// Fraction of a rectangle that may be on the wrong side of its border if the border has no function or has a corner: half of a square between samples.
const UNRESOLVED: f64 = 0.05;

/// The integral over one rectangle, without division.
fn measure<R: Region>(region: &R, part: u32, rect: &IntegrationRect) -> RegionIntegral {
    let samples = GridSamples::take(region, part, rect);
    if samples.is_uniform() {
        return if samples.is_inside(0, 0) { whole(region, part, rect) } else { RegionIntegral::default() };
    }
    match samples.height() {
        Some(along) => {
            let sum = crossed(region, part, rect, &samples, along);
            if samples.is_smooth() {
                return sum;
            }
            // The border may turn back between samples, by a shadow or at a corner, without a trace in the samples.
            RegionIntegral { error: sum.error.max(UNRESOLVED * samples.largest() * area(rect)), ..sum }
        }
        // No direction has single crossings only, so the rectangle must be divided. Any fraction of it may be inside.
        None => {
            let mean = samples.mean();
            RegionIntegral {
                value: mean * samples.share() * area(rect),
                error: samples.largest() * area(rect),
            }
        }
    }
}

fn area(rect: &IntegrationRect) -> f64 {
    rect.size().x * rect.size().y
}

/// The integral over a rectangle inside the region.
fn whole<R: Region>(region: &R, part: u32, rect: &IntegrationRect) -> RegionIntegral {
    let mut inner_difference = 0.0;
    let outer = integral([rect.min.y, rect.max.y], |v| {
        let inner = integral([rect.min.x, rect.max.x], |u| open_value(region, part, DVec2::new(u, v)));
        inner_difference += (inner.fine - inner.coarse).abs();
        inner.fine
    });
    // The mean of the lines' differences, over the interval.
    let inner_difference = inner_difference / NODES.len() as f64 * rect.size().y;
    estimate(outer, inner_difference)
}

/// The integral over a rectangle where the border crosses every line of the direction `along` at most once.
fn crossed<R: Region>(
    region: &R,
    part: u32,
    rect: &IntegrationRect,
    samples: &GridSamples<R::Sample>,
    along: usize,
) -> RegionIntegral {
    let across = 1 - along;
    let mut stops = samples.stops(region, across);
    stops.extend([rect.min[across], rect.max[across]]);
    stops.sort_by(f64::total_cmp);
    let least = 1e-12 * rect.size()[across];
    let mut sum = RegionIntegral::default();
    for ends in stops.windows(2) {
        let &[from, to] = ends else { continue };
        if to - from <= least {
            continue;
        }
        let mut inner_difference = 0.0;
        let outer = integral([from, to], |t| {
            let line = ScanLine { part, along, across: t };
            let inner = along_line(region, &line, [rect.min[along], rect.max[along]]);
            inner_difference += (inner.fine - inner.coarse).abs();
            inner.fine
        });
        let part_of_sum = estimate(outer, inner_difference / NODES.len() as f64 * (to - from));
        sum.value += part_of_sum.value;
        sum.error += part_of_sum.error;
    }
    sum
}

fn along_line<R: Region>(region: &R, line: &ScanLine, [low, high]: [f64; 2]) -> GaussKronrod {
    let (first, last) = (line.sample(region, low), line.sample(region, high));
    let range = match (first.is_inside(), last.is_inside()) {
        (false, false) => return GaussKronrod::default(),
        (true, true) => [low, high],
        (true, false) => [low, root(region, line, &first, &last)],
        (false, true) => [root(region, line, &last, &first), high],
    };
    integral(range, |t| open_value(region, line.part, line.place(t)))
}

fn open_value<R: Region>(region: &R, part: u32, at: DVec2) -> f64 {
    let sample = region.sample(part, at);
    if R::border(&sample) > 0.0 { region.value(part, &sample).unwrap_or(0.0) } else { 0.0 }
}

fn estimate(outer: GaussKronrod, inner_difference: f64) -> RegionIntegral {
    let difference = (outer.fine - outer.coarse).abs();
    let rounding = 1e-15 * outer.fine.abs();
    let error = sharpened(difference, outer.fine) + sharpened(inner_difference, outer.fine) + rounding;
    RegionIntegral { value: outer.fine, error }
}
