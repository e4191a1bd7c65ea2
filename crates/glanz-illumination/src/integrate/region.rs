//! Integrals over parts of rectangles whose borders are known by where they are crossed.
//!
//! Rectangles that the region fills get a tensor rule. Of one that the border crosses, one direction is taken as height: along it every line is
//! crossed once at most. The crossings are found as roots, and the rule is laid between them; across the height, it is laid between
//! the places where the border leaves the rectangle through its floor and ceiling. So smooth borders lose no order of convergence. What has no such
//! direction is divided, as is whatever has the largest error, until the sum of errors is small enough.
//!
//! # Source
//! @saye2015 for the method, in two dimensions; departures: the direction of height is judged by a grid of samples instead of bounds on derivatives,
//! borders may also be known by yes and no only (shadows, trimming), and the error is estimated by an embedded rule.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glanz_math::DVec2;

use super::crossing::{GridSamples, ScanLine, root};
use super::rule::{GaussKronrod, NODES, integral, sharpened};

/// Something to integrate over a part of the plane; there are several such planes, told apart by `part`.
pub(super) trait Region {
    /// Data of a sample point.
    type Sample: Copy;

    /// Evaluates a sample point.
    fn see(&self, part: u32, at: DVec2) -> Self::Sample;

    /// Positive inside, and smooth near its zeros as far as it is finite.
    fn border(seen: &Self::Sample) -> f64;

    /// Which of several smooth functions the border function is here: where they meet, the border has corners.
    fn branch(_seen: &Self::Sample) -> u32 {
        0
    }

    /// The integrand; `None` where something hides the place. Only asked where [`Region::border`] is positive.
    fn value(&self, part: u32, seen: &Self::Sample) -> Option<f64>;
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

/// Tolerance of an integral: it stops when the error is below either bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Share of the result.
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

impl PartialEq for RegionCell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for RegionCell {}

impl PartialOrd for RegionCell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for RegionCell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.sum.error.total_cmp(&other.sum.error)
    }
}

/// Divisions after which a rectangle is left as it is.
const DEEPEST: u32 = 24;

/// The integral over the rectangles `cells` of the planes that they are given with.
///
/// `known`: what is known from elsewhere, which counts for the tolerance but is not in the result. At most about `budget` rectangles are made by dividing these.
pub(super) fn integrate<R: Region>(
    region: &R,
    cells: impl IntoIterator<Item = (u32, IntegrationRect)>,
    known: RegionIntegral,
    tolerance: Tolerance,
    budget: usize,
) -> RegionIntegral {
    let measured = |part, rect: IntegrationRect, depth| RegionCell {
        part,
        rect,
        sum: measure(region, part, &rect),
        depth,
    };
    let mut heap: BinaryHeap<RegionCell> =
        cells.into_iter().map(|(part, rect)| measured(part, rect, 0)).collect();
    let total = |heap: &BinaryHeap<RegionCell>| {
        let mut all: Vec<RegionIntegral> = heap.iter().map(|cell| cell.sum).collect();
        // In an order that does not depend on how the heap lies.
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        all.iter().fold(RegionIntegral::default(), |sum, s| RegionIntegral {
            value: sum.value + s.value,
            error: sum.error + s.error,
        })
    };
    let mut sum = total(&heap);
    let mut looked_at = 0;
    let is_done = |sum: &RegionIntegral| {
        let allowed = tolerance.absolute.max(tolerance.relative * (known.value + sum.value));
        known.error + sum.error <= allowed
    };
    while !is_done(&sum) && looked_at < budget {
        let Some(worst) = heap.pop() else { break };
        if worst.sum.error <= 0.0 || worst.depth >= DEEPEST {
            heap.push(worst);
            break;
        }
        for quarter in worst.rect.quarters() {
            let cell = measured(worst.part, quarter, worst.depth + 1);
            sum.value += cell.sum.value;
            sum.error += cell.sum.error;
            heap.push(cell);
        }
        sum.value -= worst.sum.value;
        sum.error -= worst.sum.error;
        looked_at += 4;
    }
    total(&heap)
}

/// Share of a rectangle whose border is known by yes and no only, or has a corner, that may be on the wrong side of it: half of a square between samples.
const UNTOLD: f64 = 0.05;

/// A rectangle in one go.
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
            // The border may turn back between samples, by a shadow or at a corner, and nothing would tell.
            RegionIntegral { error: sum.error.max(UNTOLD * samples.largest() * area(rect)), ..sum }
        }
        // No direction is crossed once only: it is to be divided. Anything up to all of it may be inside.
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

/// One that the region fills.
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

/// One that the border crosses once along every line of the direction `along`.
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
    let (first, last) = (line.look(region, low), line.look(region, high));
    let range = match (first.is_inside(), last.is_inside()) {
        (false, false) => return GaussKronrod::default(),
        (true, true) => [low, high],
        (true, false) => [low, root(region, line, &first, &last)],
        (false, true) => [root(region, line, &last, &first), high],
    };
    integral(range, |t| open_value(region, line.part, line.place(t)))
}

fn open_value<R: Region>(region: &R, part: u32, at: DVec2) -> f64 {
    let seen = region.see(part, at);
    if R::border(&seen) > 0.0 { region.value(part, &seen).unwrap_or(0.0) } else { 0.0 }
}

fn estimate(outer: GaussKronrod, inner_difference: f64) -> RegionIntegral {
    let difference = (outer.fine - outer.coarse).abs();
    let rounding = 1e-15 * outer.fine.abs();
    let error = sharpened(difference, outer.fine) + sharpened(inner_difference, outer.fine) + rounding;
    RegionIntegral { value: outer.fine, error }
}
