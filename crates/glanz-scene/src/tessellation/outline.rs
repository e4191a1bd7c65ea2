//! The border of a patch as samples in its parameters.

use std::collections::HashMap;

use glanz_math::DVec2;

use super::grid::lengths;
use super::patch::MeshPatch;
use super::shared_edge::{EdgePlace, EdgeSampler, EdgeUse, SharedEdge};

/// Part of the window below which parameters are the same.
const SAME: f64 = 1e-10;

/// Part of the window by which edges may leave it where it does not go on: they are meant to lie on its side.
const BEYOND: f64 = 1e-3;

/// The parameters of a patch, with what lies beyond its sides.
pub(super) struct Window {
    low: DVec2,
    high: DVec2,
    /// Whether the sides of each axis are one line of the surface.
    pub(super) closed: [bool; 2],
    /// Parts of the window by which points may be off the sides of each axis and are meant to lie on them.
    same: [f64; 2],
}

impl Window {
    /// `tolerance`: the distance within which a point lies on a side, metres.
    pub(super) fn new(patch: &MeshPatch, closed: [bool; 2], tolerance: f64) -> Self {
        /// Largest part of the window that counts as rounding.
        const MOST: f64 = 1e-6;
        let [low, high] = patch.window();
        let same = lengths(patch).to_array().map(|length| (tolerance / length).clamp(SAME, MOST));
        Self { low, high, closed, same }
    }

    /// Distances of a point from the sides in the order of the patch, inside positive, parts of the window; 0 where they are the same.
    fn distances(&self, uv: DVec2) -> [f64; 4] {
        let (low, high) =
            ((uv - self.low) / (self.high - self.low), (self.high - uv) / (self.high - self.low));
        let snapped = |distance: f64, axis: usize| {
            let same = self.same[axis];
            let beyond = if self.closed[axis] { same } else { BEYOND };
            if distance.abs() <= same || distance < 0.0 && distance >= -beyond { 0.0 } else { distance }
        };
        [snapped(low.y, 1), snapped(high.x, 0), snapped(high.y, 1), snapped(low.x, 0)]
    }

    fn contains(&self, uv: DVec2) -> bool {
        self.distances(uv).iter().all(|&distance| distance >= 0.0)
    }

    /// The point moved onto the sides on which it lies, and those.
    fn snapped(&self, uv: DVec2) -> (DVec2, [bool; 4]) {
        let on = self.distances(uv).map(|distance| distance == 0.0);
        let mut moved = uv;
        for (side, value) in [(0, self.low.y), (1, self.high.x), (2, self.high.y), (3, self.low.x)] {
            if on[side] {
                moved[1 - side % 2] = value;
            }
        }
        (moved, on)
    }

    /// The side on which all points of a curve lie.
    fn side_of(&self, points: &[DVec2]) -> Option<usize> {
        let mut common = [true; 4];
        for &point in points {
            let distances = self.distances(point);
            (0..4).for_each(|side| common[side] &= distances[side] == 0.0);
        }
        common.iter().position(|&on| on)
    }

    /// The fraction of a point on a side, from its corner to the next.
    fn along(&self, side: usize, uv: DVec2) -> f64 {
        let t = (uv - self.low) / (self.high - self.low);
        match side {
            0 => t.x,
            1 => t.y,
            2 => 1.0 - t.x,
            _ => 1.0 - t.y,
        }
    }

    /// Whether a point is not on a straight segment, but for rounding.
    fn is_apart(&self, uv: DVec2, ends: [DVec2; 2]) -> bool {
        let [at, from, to] = [uv, ends[0], ends[1]].map(|uv| (uv - self.low) / (self.high - self.low));
        (to - from).perp_dot(at - from).abs() > SAME * (to - from).length()
    }

    /// Whether any part of a curve through these points lies inside, or on a side.
    pub(super) fn meets(&self, points: &[DVec2]) -> bool {
        let inside = |point: &DVec2| self.distances(*point).iter().all(|&distance| distance > 0.0);
        let middles = points.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        points.iter().copied().chain(middles).any(|point| inside(&point))
            || self.side_of(points).is_some() && points.iter().any(|&point| self.contains(point))
    }

    /// Places at which a curve crosses the sides. `places`: dense places in [0, 1], ascending.
    pub(super) fn crossings(&self, places: &[f64], curve: impl Fn(f64) -> DVec2) -> Vec<f64> {
        /// Halvings to the last digit.
        const HALVINGS: u32 = 60;
        let mut found = Vec::new();
        let points: Vec<[f64; 4]> = places.iter().map(|&t| self.distances(curve(t))).collect();
        for side in 0..4 {
            let distance = |t: f64| self.distances(curve(t))[side];
            let mut last: Option<(f64, f64)> = None;
            for (i, (&t, distances)) in places.iter().zip(&points).enumerate() {
                let now = distances[side];
                if now == 0.0 {
                    let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
                    let stays = beside.filter_map(|i| points.get(i)).all(|other| other[side] == 0.0);
                    if !stays {
                        // The curve turns onto the side or off it here.
                        found.push(t);
                    }
                    continue;
                }
                if let Some((before, sign)) = last.filter(|(_, sign)| *sign != now.signum()) {
                    let (mut low, mut high) = (before, t);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        let at = distance(middle);
                        if at == 0.0 {
                            (low, high) = (middle, middle);
                            break;
                        }
                        *(if at.signum() == sign { &mut low } else { &mut high }) = middle;
                    }
                    found.push(0.5 * (low + high));
                }
                last = Some((t, now.signum()));
            }
        }
        found.retain(|&t| t > 0.0 && t < 1.0 && self.contains(curve(t)));
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    }
}

/// A sample of the border, or a point added inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlinePoint {
    pub(super) uv: DVec2,
    /// Its vertex in the group.
    pub(super) vertex: u32,
}

/// A chord of the border, the patch on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlineSegment {
    /// Indices of its points.
    pub(super) ends: [u32; 2],
    /// Number of its edge.
    pub(super) edge: usize,
    /// The fractions of the edge at its ends.
    pub(super) fractions: [f64; 2],
    /// Whether the edge is not straight in the parameters of the patch: then samples between the ends move it.
    pub(super) curved: bool,
}

/// The border of a patch: segments between samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    pub(super) points: Vec<OutlinePoint>,
    pub(super) segments: Vec<OutlineSegment>,
    /// Pairs of vertices that are at the same parameters.
    pub(super) same: Vec<[u32; 2]>,
    /// Points by the cell of their parameters.
    cells: HashMap<[i64; 2], Vec<u32>>,
}

/// Samples on the sides of a patch: the side, the fraction of it from its corner to the next, the vertex.
pub(super) type SidePoint = (usize, f64, u32);

/// Ranges of sides on which curves lie.
pub(super) type SideRange = (usize, [f64; 2]);

impl Outline {
    /// The index of the point at `uv`, which is added if there is none.
    fn point(&mut self, window: &Window, uv: DVec2, vertex: u32) -> u32 {
        let at = (uv - window.low) / (window.high - window.low);
        let cell = |x: f64| (x / (4.0 * SAME)).floor() as i64;
        let [x, y] = [cell(at.x), cell(at.y)];
        for near in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])) {
            for &known in self.cells.get(&near).into_iter().flatten() {
                let Some(point) = self.points.get(known as usize) else { continue };
                let apart = (point.uv - uv) / (window.high - window.low);
                if apart.abs().max_element() <= SAME {
                    if point.vertex != vertex {
                        self.same.push([point.vertex, vertex]);
                    }
                    return known;
                }
            }
        }
        let number = self.points.len() as u32;
        self.points.push(OutlinePoint { uv, vertex });
        self.cells.entry([x, y]).or_default().push(number);
        number
    }

    /// Adds the parts of a curve of the boundary that lie inside the window. Returns its samples on the sides and the parts of sides that it covers.
    pub(super) fn add_curve(
        &mut self,
        patch: &MeshPatch,
        window: &Window,
        edge: &SharedEdge,
        [edge_number, number]: [usize; 2],
        sampler: &EdgeSampler<'_>,
    ) -> (Vec<SidePoint>, Vec<SideRange>) {
        let (mut on_sides, mut covered) = (Vec::new(), Vec::new());
        let Some(a_use) = edge.uses.get(number) else { return (on_sides, covered) };
        let samples = use_samples(edge, number, sampler);
        let mut last: Option<(UseSample, DVec2, [bool; 4])> = None;
        for sample in samples {
            let UseSample { t, vertex, .. } = sample;
            let (uv, sides) = window.snapped(a_use.at(patch, t));
            if window.contains(uv) {
                on_sides.extend(
                    (0..4).filter(|&side| sides[side]).map(|side| (side, window.along(side, uv), vertex)),
                );
            }
            if let Some((before, from, from_sides)) = last {
                let middle = window.snapped(a_use.at(patch, 0.5 * (before.t + t)));
                let common = (0..4).find(|&side| sides[side] && from_sides[side] && middle.1[side]);
                let inside = window.contains(middle.0) && window.contains(uv) && window.contains(from);
                match common {
                    Some(side) if inside => {
                        let ends = [from, uv].map(|uv| window.along(side, uv));
                        covered.push((side, [ends[0].min(ends[1]), ends[0].max(ends[1])]));
                    }
                    None if inside => {
                        let ends = [self.point(window, from, before.vertex), self.point(window, uv, vertex)];
                        if ends[0] != ends[1] {
                            self.segments.push(OutlineSegment {
                                ends,
                                edge: edge_number,
                                fractions: [before.fraction, sample.fraction],
                                curved: window.is_apart(middle.0, [from, uv]),
                            });
                        }
                    }
                    _ => {}
                }
            }
            last = Some((sample, uv, sides));
        }
        (on_sides, covered)
    }

    /// Adds a side of the polygon of parameters.
    pub(super) fn add_side(
        &mut self,
        patch: &MeshPatch,
        window: &Window,
        edge: &SharedEdge,
        [edge_number, number]: [usize; 2],
        sampler: &EdgeSampler<'_>,
    ) {
        let Some(a_use) = edge.uses.get(number) else { return };
        let mut last: Option<(u32, f64)> = None;
        for UseSample { t, fraction, vertex } in use_samples(edge, number, sampler) {
            let next = self.point(window, a_use.at(patch, t), vertex);
            if let Some((last, before)) = last.filter(|&(last, _)| last != next) {
                let fractions = [before, fraction];
                self.segments.push(OutlineSegment {
                    ends: [last, next],
                    edge: edge_number,
                    fractions,
                    curved: false,
                });
            }
            last = Some((next, fraction));
        }
    }
}

/// A sample of an edge in one of its uses.
#[derive(Clone, Copy)]
struct UseSample {
    /// Its place in the use, in [0, 1].
    t: f64,
    fraction: f64,
    vertex: u32,
}

/// The samples of an edge within a use, in its order.
fn use_samples(edge: &SharedEdge, number: usize, sampler: &EdgeSampler<'_>) -> Vec<UseSample> {
    let Some(&EdgeUse { range: [from, to], place, .. }) = edge.uses.get(number) else { return Vec::new() };
    let (low, high) = (from.min(to), from.max(to));
    let within = edge.samples.iter().filter(|(fraction, _)| (low..=high).contains(fraction));
    let mut samples: Vec<UseSample> = within
        .map(|&(fraction, vertex)| {
            let t = match place {
                // Fractions of sides are distances in the parameters.
                EdgePlace::Side(_) => edge.uses[number].place_of(fraction),
                EdgePlace::Curve { .. } => sampler.place(number, fraction),
            };
            UseSample { t, fraction, vertex }
        })
        .collect();
    if from > to {
        samples.reverse();
    }
    // Nearest places are in order but for rounding where curves are slow.
    let mut least = 0.0_f64;
    for sample in &mut samples {
        least = least.max(sample.t);
        sample.t = least;
    }
    samples
}
