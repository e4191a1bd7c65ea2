//! Edges in world space, and whether they are seen.

use glanz_math::glam::DMat3;
use glanz_math::{DVec3, Ray, Transform};

use crate::description::EdgeDescription;
use crate::edge_section::EdgeSection;
use crate::scene::{Scene, SceneGroup};

/// Surfaces that a line of sight may pass in front of a point that it shows, at most.
const MAX_PASSED: usize = 64;

/// The edges of one copy of a group.
#[derive(Clone, Debug)]
pub struct PlacedEdges<'a> {
    /// The edges in the frame of the group.
    pub edges: &'a [EdgeDescription],
    to_world: Transform,
    /// Bound on lengths in the world over those in the group.
    stretch: f64,
    section: Option<EdgeSection>,
}

impl<'a> PlacedEdges<'a> {
    /// `half_space`: the normal and the offset of what a section leaves of the world.
    fn new(edges: &'a [EdgeDescription], to_world: Transform, half_space: Option<(DVec3, f64)>) -> Self {
        let stretch = stretch(to_world.forward().matrix3);
        let section = half_space.map(|half_space| EdgeSection::new(half_space, edges, &to_world, stretch));
        Self { edges, to_world, stretch, section }
    }

    /// The points of an edge of the group in world space, metres, without what a section cuts away: several pieces where it cuts often.
    ///
    /// An edge that lies in the plane of the section is left if a shape that meets in it reaches below.
    #[must_use]
    pub fn pieces(&self, edge: &EdgeDescription) -> Vec<Vec<DVec3>> {
        let points: Vec<DVec3> = edge.points.iter().map(|&point| self.to_world.point(point)).collect();
        match &self.section {
            Some(section) => section.pieces(&points, self.deviation(edge), &edge.shapes),
            None => vec![points],
        }
    }

    /// Bound on the deviation of an edge of the group in world space, metres: the least one if the group is scaled alike in all directions.
    #[must_use]
    pub fn deviation(&self, edge: &EdgeDescription) -> f64 {
        self.stretch * edge.deviation
    }
}

/// Bound on the factor by which a map stretches lengths; the least one if it scales alike in all directions.
///
/// Its square is the largest sum of absolute values in a column of the Gram matrix, which bounds the largest eigenvalue; that of a turned scale is diagonal.
pub(crate) fn stretch(axes: DMat3) -> f64 {
    let gram = axes.transpose() * axes;
    let sums = [gram.x_axis, gram.y_axis, gram.z_axis].map(|column| column.abs().element_sum());
    sums.into_iter().fold(0.0, f64::max).sqrt()
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
            placed.push(PlacedEdges::new(&group.edges, to_world, section));
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

#[cfg(test)]
mod tests {
    use glanz_math::DMat4;

    use super::*;

    #[test]
    fn stretch_is_that_of_a_scale_and_bounds_that_of_other_maps() {
        let turn = DMat4::from_rotation_x(0.7) * DMat4::from_rotation_y(-0.4);
        for (scale, exact) in
            [(DVec3::ONE, true), (DVec3::splat(0.25), true), (DVec3::new(3.0, 1.0, 0.1), false)]
        {
            for matrix in [turn * DMat4::from_scale(scale), DMat4::from_scale(scale) * turn] {
                let found = stretch(DMat3::from_mat4(matrix));
                let ratio = found / scale.max_element();
                // The sums in the columns of a symmetric 3 x 3 matrix exceed its largest eigenvalue at most by a factor of the root of three.
                let most = if exact { 1.0 } else { 3.0_f64.sqrt().sqrt() };
                assert!((1.0 - 1e-12..=most + 1e-12).contains(&ratio), "{scale} {ratio}");
            }
        }
    }
}
