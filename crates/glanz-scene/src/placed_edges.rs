//! Edges in world space, and whether they are seen.

use glanz_math::{DVec3, Ray, Transform};

use crate::description::EdgeDescription;
use crate::scene::{Scene, SceneGroup};

/// Surfaces that a line of sight may pass in front of a point that it shows, at most.
const MAX_PASSED: usize = 64;

/// The edges of one copy of a group.
#[derive(Clone, Debug)]
pub struct PlacedEdges<'a> {
    /// The edges in the frame of the group.
    pub edges: &'a [EdgeDescription],
    to_world: Transform,
    /// The half space `normal . p <= offset` of the world that a section leaves.
    section: Option<(DVec3, f64)>,
}

impl PlacedEdges<'_> {
    /// The points of an edge of the group in world space, metres, without what a section cuts away: several pieces where it cuts often.
    #[must_use]
    pub fn pieces(&self, edge: &EdgeDescription) -> Vec<Vec<DVec3>> {
        let points: Vec<DVec3> = edge.points.iter().map(|&point| self.to_world.point(point)).collect();
        let Some((normal, offset)) = self.section else { return vec![points] };
        let mut pieces = vec![Vec::new()];
        for pair in points.windows(2) {
            let [start, end] = [pair[0], pair[1]];
            let [h0, h1] = [start, end].map(|point| normal.dot(point) - offset);
            let cut = || start + (h0 / (h0 - h1)) * (end - start);
            let part = match (h0 <= 0.0, h1 <= 0.0) {
                (true, true) => [start, end],
                (true, false) => [start, cut()],
                (false, true) => [cut(), end],
                (false, false) => continue,
            };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&part[0]) => piece.push(part[1]),
                _ => pieces.push(part.to_vec()),
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    /// The deviation of an edge of the group in world space, metres.
    #[must_use]
    pub fn deviation(&self, edge: &EdgeDescription) -> f64 {
        let stretch = DVec3::AXES.map(|axis| self.to_world.vector(axis).length_squared());
        edge.deviation * stretch.iter().sum::<f64>().sqrt()
    }
}

impl Scene {
    /// The number of edges, each copy of a group counted.
    #[must_use]
    pub fn edge_count(&self) -> u64 {
        let mut counts: Vec<u64> = Vec::with_capacity(self.groups.len());
        for group in self.groups.iter() {
            let inner = group.instances.iter().filter_map(|instance| counts.get(instance.group));
            counts.push(inner.fold(group.edges.len() as u64, |sum, &count| sum.saturating_add(count)));
        }
        counts.last().copied().unwrap_or_default()
    }

    /// The edges of all copies of groups that have some.
    ///
    /// There may be very many, see [`Scene::edge_count`].
    #[must_use]
    pub fn placed_edges(&self) -> Vec<PlacedEdges<'_>> {
        let mut placed = Vec::new();
        self.collect_edges(self.world(), Transform::IDENTITY, None, &mut placed);
        placed
    }

    fn collect_edges<'a>(
        &'a self,
        group: &'a SceneGroup,
        to_world: Transform,
        around: Option<(DVec3, f64)>,
        placed: &mut Vec<PlacedEdges<'a>>,
    ) {
        let own = group.section.as_ref().map(|section| section.half_space(&to_world));
        let section = own.or(around);
        if !group.edges.is_empty() {
            placed.push(PlacedEdges { edges: &group.edges, to_world, section });
        }
        for instance in &group.instances {
            let Some(inner) = self.groups.get(instance.group).filter(|inner| inner.has_edges) else {
                continue;
            };
            self.collect_edges(inner, to_world.after(&instance.to_parent), section, placed);
        }
    }

    /// The number of the faces of a section, as [`Interaction::id`](crate::Interaction::id) has it; `None` without a section.
    #[must_use]
    pub fn section_id(&self) -> Option<u32> {
        self.groups.iter().find_map(|group| {
            let plane = group.objects.get(group.section.as_ref()?.object as usize)?;
            Some(plane.attributes(0).id)
        })
    }

    /// Whether a straight line of sight from `eye` reaches `point`, which lies on surfaces to within `tolerance` (all metres).
    ///
    /// A surface in front of the point does not hide it if its tangent plane passes the point within the tolerance: it is one of the surfaces
    /// on which the point lies, however flat the line of sight meets it. Interfaces hide nothing.
    #[must_use]
    pub fn sees(&self, eye: DVec3, point: DVec3, tolerance: f64) -> bool {
        let Some(direction) = (point - eye).try_normalize() else { return true };
        let mut ray = Ray::new(eye, direction);
        for _ in 0..MAX_PASSED {
            let left = (point - ray.origin).dot(direction);
            if left.is_nan() || left <= 0.0 {
                return true;
            }
            let Some(hit) = self.intersect(&ray, left) else { return true };
            let surface = &hit.point;
            let off = (point - surface.position).dot(surface.normal).abs();
            let rounding = surface.error.dot(surface.normal.abs());
            if off > tolerance + rounding && !self.material(hit.material).is_interface() {
                return false;
            }
            ray = hit.spawn(direction);
        }
        false
    }
}
