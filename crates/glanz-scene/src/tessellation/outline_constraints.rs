//! The segments of the outline of a patch as constraints of its triangulation.
//!
//! Each segment becomes a chain of edges of the triangulation, so that the triangles inside have the segments as their border. A segment that would
//! cross another one, or pass through a vertex, takes a detour over a vertex of the other; the triangle between segment and detour (a flap) belongs to the
//! patch, too. Whoever makes the triangulation samples edges more closely where flaps are high, until the segments no longer cross.

use std::collections::HashMap;

use glanz_math::DVec3;
use spade::handles::FixedVertexHandle;
use spade::{Intersection, LineIntersectionIterator, Triangulation};

use super::outline::Outline;
use super::shared_edge::distance_to_segment;
use super::triangulation::SiteTriangulation;

/// Segments of the outline that cross or touch each other.
#[derive(Clone, Debug)]
pub(super) struct OutlineConflict {
    /// Indices of segments.
    pub(super) segments: Vec<usize>,
    /// Distance by which one of them is moved to the other one, metres.
    pub(super) height: f64,
}

/// The constraints that follow from the segments of an outline.
#[derive(Debug, Default)]
pub(super) struct OutlineConstraints {
    /// How much larger the winding number is on the left of an edge, by its ends.
    pub(super) changes: HashMap<[usize; 2], i32>,
    /// Triangles between segments and their detours, as counterclockwise as the segment.
    pub(super) flaps: Vec<[FixedVertexHandle; 3]>,
    pub(super) conflicts: Vec<OutlineConflict>,
    /// Whether segments are missing.
    pub(super) is_incomplete: bool,
    /// Segments by the edges over which they run, the smaller end first.
    segments: HashMap<[usize; 2], Vec<usize>>,
}

/// Largest number of vertices around which a segment takes a detour.
const MAX_DETOURS: usize = 64;

/// Largest number of flaps of an outline; loops that lie on each other have many.
const MAX_FLAPS: usize = 1 << 16;

/// Largest number of segments of an edge that are divided in a round because of a conflict.
const MAX_SEGMENTS: usize = 64;

impl OutlineConstraints {
    /// Adds all segments of an outline. `handles`: for each of its points.
    pub(super) fn new(
        sites: &mut SiteTriangulation,
        outline: &Outline,
        handles: &[Option<FixedVertexHandle>],
    ) -> Self {
        let mut made = Self::default();
        for (number, segment) in outline.segments.iter().enumerate() {
            match segment.ends.map(|i| handles.get(i as usize).copied().flatten()) {
                [Some(from), Some(to)] => made.add(sites, number, [from, to]),
                _ => made.is_incomplete = true,
            }
        }
        made
    }

    fn add(&mut self, sites: &mut SiteTriangulation, number: usize, ends: [FixedVertexHandle; 2]) {
        let mut waiting = vec![ends];
        let mut detours = 0;
        while let Some([from, to]) = waiting.pop() {
            if from == to {
                continue;
            }
            let Some((via, mut segments)) = self.obstacle(sites, [from, to]) else {
                self.constrain(sites, number, [from, to]);
                continue;
            };
            detours += 1;
            if detours > MAX_DETOURS {
                self.is_incomplete = true;
                return;
            }
            segments.push(number);
            if !self.add_flaps([from, to, via], 1) {
                return;
            }
            self.conflicts.push(OutlineConflict { segments, height: height(sites, via, [from, to]) });
            waiting.extend([[via, to], [from, via]]);
        }
    }

    /// The vertex around which a segment must go, and the segments that it would cross otherwise.
    fn obstacle(
        &self,
        sites: &SiteTriangulation,
        ends: [FixedVertexHandle; 2],
    ) -> Option<(FixedVertexHandle, Vec<usize>)> {
        let [from, to] = ends;
        let mut nearest: Option<(f64, FixedVertexHandle)> = None;
        let mut crossed = Vec::new();
        for intersection in LineIntersectionIterator::new_from_handles(sites, from, to) {
            let candidates = match intersection {
                Intersection::EdgeIntersection(edge) if edge.is_constraint_edge() => {
                    let known = self.segments.get(&ascending(edge.vertices().map(|end| end.index())));
                    crossed
                        .extend(known.into_iter().flatten().take(MAX_SEGMENTS.saturating_sub(crossed.len())));
                    edge.vertices().map(|end| end.fix()).to_vec()
                }
                Intersection::VertexIntersection(vertex) => vec![vertex.fix()],
                _ => Vec::new(),
            };
            for candidate in candidates.into_iter().filter(|candidate| !ends.contains(candidate)) {
                let distance = height(sites, candidate, ends);
                if nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, candidate));
                }
            }
        }
        nearest.map(|(_, vertex)| (vertex, crossed))
    }

    /// Adds a flap this many times. Returns whether there are not too many.
    pub(super) fn add_flaps(&mut self, corners: [FixedVertexHandle; 3], count: usize) -> bool {
        let is_few = count <= MAX_FLAPS - self.flaps.len();
        if is_few {
            self.flaps.extend(std::iter::repeat_n(corners, count));
        }
        self.is_incomplete |= !is_few;
        is_few
    }

    /// Notes that the segments along these edges are in the wrong order.
    pub(super) fn add_conflict(&mut self, edges: [[usize; 2]; 3], height: f64) {
        let known = edges.iter().filter_map(|&ends| self.segments.get(&ascending(ends)));
        let segments = known.flat_map(|numbers| numbers.iter().take(MAX_SEGMENTS)).copied().collect();
        self.conflicts.push(OutlineConflict { segments, height });
    }

    fn constrain(
        &mut self,
        sites: &mut SiteTriangulation,
        number: usize,
        [from, to]: [FixedVertexHandle; 2],
    ) {
        let edges = sites.try_add_constraint(from, to);
        self.is_incomplete |= edges.is_empty();
        for edge in edges {
            let ends = sites.directed_edge(edge).vertices().map(|end| end.index());
            *self.changes.entry(ends).or_insert(0) += 1;
            self.segments.entry(ascending(ends)).or_default().push(number);
        }
    }
}

fn ascending([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Distance of a vertex from a segment, metres.
fn height(sites: &SiteTriangulation, vertex: FixedVertexHandle, ends: [FixedVertexHandle; 2]) -> f64 {
    let point = |handle: FixedVertexHandle| -> DVec3 { sites.vertex(handle).data().point };
    distance_to_segment(point(vertex), point(ends[0]), point(ends[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_flaps_is_limited() {
        let mut outline = OutlineConstraints::default();
        let corners = [0, 1, 2].map(FixedVertexHandle::from_index);
        outline.add_flaps(corners, MAX_FLAPS);
        assert!(outline.flaps.len() == MAX_FLAPS && !outline.is_incomplete);
        outline.add_flaps(corners, usize::MAX);
        assert!(outline.flaps.len() == MAX_FLAPS && outline.is_incomplete);
    }
}
