//! Edges that a section cuts.

use std::collections::BTreeMap;

use glanz_math::{DVec3, Transform};

use crate::description::EdgeDescription;
use crate::section::IN_PLANE;

/// What a section leaves of the edges of one copy of a group.
///
/// Within rounding, and within the deviation of its edge, a point lies in the plane. Of an edge in the plane, the other edges of its shapes tell whether
/// these are left, below the plane, or above it.
#[derive(Clone, Debug)]
pub(crate) struct EdgeSection {
    /// Unit normal towards the part that is left out, in world space as all that follows.
    normal: DVec3,
    offset: f64,
    /// Distance from the plane, by rounding, of points that lie in it, metres.
    rounding: f64,
    /// The lowest and the highest point over the plane, metres, of the edges of each shape some of whose points lie in it.
    extents: BTreeMap<usize, [f64; 2]>,
}

impl EdgeSection {
    /// `half_space`: the normal and the offset of what is left of the world. `edges`: those of the group, in its frame. `stretch`: bound on lengths in
    /// the world over those in the group.
    pub(crate) fn new(
        half_space: (DVec3, f64),
        edges: &[EdgeDescription],
        to_world: &Transform,
        stretch: f64,
    ) -> Self {
        let (normal, offset) = half_space;
        let distances =
            edges.iter().flat_map(|edge| &edge.points).map(|&point| to_world.point(point).length());
        // Of coordinates in the frame of the group, too.
        let size = distances.fold(0.0, f64::max) + to_world.forward().translation.length();
        let mut section = Self { normal, offset, rounding: IN_PLANE * size, extents: BTreeMap::new() };
        let mut extents: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for edge in edges {
            let heights = edge
                .points
                .iter()
                .map(|&point| section.height(to_world.point(point), stretch * edge.deviation));
            let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
                [height.min(low), height.max(high)]
            });
            for &shape in &edge.shapes {
                let extent = extents.entry(shape).or_insert([low, high]);
                *extent = [extent[0].min(low), extent[1].max(high)];
            }
        }
        extents.retain(|_, [low, high]| *low <= 0.0 && *high >= 0.0);
        section.extents = extents;
        section
    }

    /// Height over the plane of a point of an edge of this deviation, metres; 0 in the plane.
    fn height(&self, point: DVec3, deviation: f64) -> f64 {
        let height = self.normal.dot(point) - self.offset;
        if height.abs() <= self.rounding + deviation { 0.0 } else { height }
    }

    /// Whether something is left of shapes that meet in an edge in the plane.
    fn leaves(&self, shapes: &[usize]) -> bool {
        let extents = || shapes.iter().filter_map(|shape| self.extents.get(shape));
        extents().any(|[low, _]| *low < 0.0) || extents().all(|[_, high]| *high <= 0.0)
    }

    /// What is left of an edge of this deviation through `points`, metres: several pieces where the plane cuts it often.
    pub(crate) fn pieces(&self, points: &[DVec3], deviation: f64, shapes: &[usize]) -> Vec<Vec<DVec3>> {
        let leaves_in_plane = self.leaves(shapes);
        let mut pieces: Vec<Vec<DVec3>> = Vec::new();
        for pair in points.windows(2) {
            let [start, end] = [pair[0], pair[1]];
            let [from, to] = [start, end].map(|point| self.height(point, deviation));
            let cut = || start + (from / (from - to)) * (end - start);
            let part = match (from.min(to) < 0.0, from.max(to) <= 0.0) {
                (true, true) => [start, end],
                (true, false) if from < 0.0 => [start, cut()],
                (true, false) => [cut(), end],
                (false, true) if leaves_in_plane => [start, end],
                (false, _) => continue,
            };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&part[0]) => piece.push(part[1]),
                _ => pieces.push(part.to_vec()),
            }
        }
        pieces
    }
}
