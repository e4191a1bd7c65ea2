//! Extent of a description, before a scene is built of it.

use glanz_math::{Bounds3, DMat4, DVec3};

use super::{Description, GeometryDescription, GroupDescription, ShapeDescription, TrimDescription};
use crate::resolve::surface_bounds;

impl Description {
    /// The bounding box of shapes and instances in world space, metres; empty if there are none.
    ///
    /// It contains all points of meshes and analytic surfaces and all control points of freeform surfaces. Trimmed surfaces count as a whole; infinite planes
    /// only within their trimming curves. Shapes that are invalid, such as those with coordinates that are not finite, are left out.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        let mut bounds = Bounds3::EMPTY;
        self.visit_extent(&mut |point| bounds = bounds.including(point));
        bounds
    }

    /// Calls `visit` with points in world space whose convex hull contains all shapes and instances, as [`Description::bounds`] counts them.
    pub(crate) fn visit_extent(&self, visit: &mut impl FnMut(DVec3)) {
        // Instances are represented by the box of their group, so that the time does not depend on how often groups contain each other.
        let mut groups: Vec<Bounds3> = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let mut bounds = Bounds3::EMPTY;
            visit_group(group, &groups, &mut |point| bounds = bounds.including(point));
            groups.push(bounds);
        }
        visit_group(&self.world, &groups, visit);
    }
}

/// `groups`: the bounds of the groups to which instances can refer.
fn visit_group(group: &GroupDescription, groups: &[Bounds3], visit: &mut impl FnMut(DVec3)) {
    for shape in &group.shapes {
        visit_shape(shape, &mut placed(shape.to_parent, visit));
    }
    for instance in &group.instances {
        if let Some(bounds) = groups.get(instance.group).filter(|bounds| !bounds.is_empty()) {
            bounds.corners().into_iter().for_each(placed(instance.to_parent, visit));
        }
    }
}

/// Calls `visit` with transformed points, if they are finite.
fn placed(to_parent: DMat4, visit: &mut impl FnMut(DVec3)) -> impl FnMut(DVec3) {
    move |point| {
        let point = to_parent.transform_point3(point);
        if point.is_finite() {
            visit(point);
        }
    }
}

/// Points in the frame of the surface.
fn visit_shape(shape: &ShapeDescription, visit: &mut impl FnMut(DVec3)) {
    match &shape.geometry {
        GeometryDescription::Triangles { positions, .. }
        | GeometryDescription::Bilinear { positions, .. } => {
            positions.iter().copied().for_each(visit);
        }
        GeometryDescription::Nurbs(surface) => visit_points(&surface.points, visit),
        GeometryDescription::BezierPatches(surface) => {
            surface.patches.iter().for_each(|patch| visit_points(patch, visit));
        }
        GeometryDescription::BezierTriangles(surface) => {
            surface.patches.iter().for_each(|patch| visit_points(patch, visit));
        }
        analytic => {
            let Some(bounds) = surface_bounds(analytic).filter(|bounds| !bounds.is_empty()) else { return };
            match &shape.trim {
                Some(trim) if !bounds.is_finite() => visit_plane(trim, bounds, visit),
                _ if bounds.is_finite() => bounds.corners().into_iter().for_each(visit),
                _ => {}
            }
        }
    }
}

/// Control points (w x, w y, w z, w).
fn visit_points(points: &[[f64; 4]], visit: &mut impl FnMut(DVec3)) {
    points.iter().for_each(|&[x, y, z, w]| visit(DVec3::new(x, y, z) / w));
}

/// The part of a plane with infinite sides that the trimming curves enclose.
fn visit_plane(trim: &TrimDescription, bounds: Bounds3, visit: &mut impl FnMut(DVec3)) {
    let at = |parameter: f64, low: f64, high: f64| {
        // Between two finite sides the parameter runs from 0 to 1; otherwise it is the coordinate.
        if (high - low).is_finite() { low + parameter * (high - low) } else { parameter }
    };
    for &[u, v, w] in trim.loops.iter().flat_map(|l| &l.curves).flat_map(|curve| &curve.points) {
        let (x, y) = (at(u / w, bounds.min.x, bounds.max.x), at(v / w, bounds.min.y, bounds.max.y));
        visit(DVec3::new(x, y, 0.0).clamp(bounds.min, bounds.max));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

    use super::*;
    use crate::description::{
        InstanceDescription, NurbsDescription, TrimCurveDescription, TrimLoopDescription,
    };

    fn world(shapes: Vec<ShapeDescription>) -> Description {
        let world = GroupDescription { shapes, ..GroupDescription::default() };
        Description { world, ..Description::default() }
    }

    fn assert_near(bounds: Bounds3, min: [f64; 3], max: [f64; 3]) {
        let (min, max) = (DVec3::from(min), DVec3::from(max));
        let off = (bounds.min - min).abs().max((bounds.max - max).abs()).max_element();
        assert!(off < 1e-12, "{bounds:?} is not {min} to {max}");
    }

    #[test]
    fn nothing_has_empty_bounds() {
        assert!(world(Vec::new()).bounds().is_empty());
        assert!(world(vec![ShapeDescription::plane()]).bounds().is_empty(), "infinite planes are left out");
        let invalid = ShapeDescription::sphere(-1.0);
        assert!(world(vec![invalid]).bounds().is_empty());
    }

    #[test]
    fn shapes_are_counted_where_they_are_placed() {
        let ball = ShapeDescription::sphere(2.0).translated([10.0, 0.0, 0.0]);
        let pipe = ShapeDescription::cylinder(1.0, [0.0, 5.0]).rotated(DVec3::X, -FRAC_PI_2);
        assert_near(world(vec![ball, pipe]).bounds(), [-1.0, -2.0, -2.0], [12.0, 5.0, 2.0]);
    }

    #[test]
    fn instances_of_instances_are_placed_by_both_transformations() {
        let bar = GroupDescription {
            shapes: vec![ShapeDescription::cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0])],
            ..GroupDescription::default()
        };
        let turned = InstanceDescription {
            name: String::new(),
            group: 0,
            to_parent: DMat4::from_rotation_z(FRAC_PI_4),
            location: None,
        };
        let moved = InstanceDescription {
            name: String::new(),
            group: 1,
            to_parent: DMat4::from_translation(DVec3::new(0.0, 0.0, 7.0)),
            location: None,
        };
        let missing =
            InstanceDescription { name: String::new(), group: 9, to_parent: DMat4::IDENTITY, location: None };
        let middle = GroupDescription { instances: vec![turned], ..GroupDescription::default() };
        let world = GroupDescription { instances: vec![moved, missing], ..GroupDescription::default() };
        let description = Description { groups: vec![bar, middle], world, ..Description::default() };
        assert_near(description.bounds(), [-SQRT_2, -SQRT_2, 7.0], [SQRT_2, SQRT_2, 8.0]);
    }

    #[test]
    fn groups_that_double_twenty_times_cost_no_time() {
        let ball = GroupDescription { shapes: vec![ShapeDescription::sphere(1.0)], ..Default::default() };
        let mut groups = vec![ball];
        for group in 0..20 {
            let at = |x: f64| InstanceDescription {
                name: String::new(),
                group,
                to_parent: DMat4::from_translation(DVec3::X * x),
                location: None,
            };
            let side = f64::from(1 << group);
            groups.push(GroupDescription { instances: vec![at(-side), at(side)], ..Default::default() });
        }
        let all = InstanceDescription {
            name: String::new(),
            group: 20,
            to_parent: DMat4::IDENTITY,
            location: None,
        };
        let world = GroupDescription { instances: vec![all], ..Default::default() };
        let description = Description { groups, world, ..Description::default() };
        let end = f64::from((1 << 20) - 1) + 1.0;
        assert_near(description.bounds(), [-end, -1.0, -1.0], [end, 1.0, 1.0]);
    }

    #[test]
    fn control_points_are_divided_by_their_weights() {
        let points =
            [[0.0, 0.0, 0.0, 1.0], [4.0, 0.0, 2.0, 2.0], [0.0, 1.5, 0.0, 0.5], [1.0, 1.0, -1.0, 1.0]];
        let surface = NurbsDescription {
            degree_u: 1,
            degree_v: 1,
            knots_u: vec![0.0, 0.0, 1.0, 1.0],
            knots_v: vec![0.0, 0.0, 1.0, 1.0],
            points: points.to_vec(),
            domain: None,
        };
        let shape = ShapeDescription::from(GeometryDescription::Nurbs(surface));
        assert_near(world(vec![shape]).bounds(), [0.0, 0.0, -1.0], [2.0, 3.0, 1.0]);
    }

    #[test]
    fn a_trimmed_infinite_plane_ends_at_its_curves() {
        let corners = [[1.0, 2.0], [4.0, 2.0], [4.0, 3.0], [1.0, 3.0], [1.0, 2.0]];
        let curve = TrimCurveDescription {
            degree: 1,
            knots: vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0],
            points: corners.map(|[u, v]| [2.0 * u, 2.0 * v, 2.0]).to_vec(),
            width: None,
            edge: None,
        };
        let trim = TrimDescription::from(vec![TrimLoopDescription { curves: vec![curve] }]);
        let shape = ShapeDescription::plane().trimmed(trim).translated([0.0, 0.0, 5.0]);
        assert_near(world(vec![shape]).bounds(), [1.0, 2.0, 5.0], [4.0, 3.0, 5.0]);
    }
}
