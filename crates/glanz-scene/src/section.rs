//! Groups that are cut open by a plane.
//!
//! What a plane leaves of a ray is one piece, so that the ray is clipped and hits need not be. Where a ray crosses the plane above the inside of a solid it hits
//! the flat face of the cut, which the number of hits from just below to infinity decides. A face of the model that lies in the plane is neither above nor
//! below it within rounding: it is hit in place of the face of the cut if the solid ends there, and not at all if no solid is below.

use std::collections::BTreeSet;

use glanz_geometry::Hit;
use glanz_math::{DMat4, DVec3, Frame, Ray, Transform};

use crate::description::{SectionDescription, ShapeDescription};
use crate::hit::SceneHit;
use crate::object::SceneObject;
use crate::scene::{Primitive, Scene, SceneGroup};

/// Distance from the plane below which a point lies in it, relative to the size of the coordinates: ten times the distance within which a ray starts from a
/// surface.
pub(crate) const IN_PLANE: f64 = 1e-11;

/// The plane of a section, with its faces.
#[derive(Clone, Debug)]
pub(crate) struct GroupSection {
    /// Unit normal towards the part that is left out.
    normal: DVec3,
    offset: f64,
    /// Index of the plane among the objects of the group, of which its hierarchy knows nothing.
    pub(crate) object: u32,
    /// Direction of the rays that count surfaces: into the part that is left, and along no axis, since edges often are.
    inward: DVec3,
}

/// The part of a ray that a section leaves.
struct RayPart {
    start: f64,
    end: f64,
    /// Where it crosses the plane.
    crossing: Option<f64>,
}

impl GroupSection {
    /// `None` if the plane has no direction or place. `object`: index of its plane among the objects of the group.
    pub(crate) fn try_new(description: &SectionDescription, object: u32) -> Option<Self> {
        let length = description.normal.length();
        let (normal, offset) = (description.normal.try_normalize()?, description.offset / length);
        let inward = Frame::from_z(-normal).to_world(DVec3::new(0.317, 0.173, 1.0)).normalize();
        offset.is_finite().then_some(Self { normal, offset, object, inward })
    }

    /// The half space `normal . p <= offset` of the world that is left. `to_world`: from the frame of the group.
    pub(crate) fn half_space(&self, to_world: &Transform) -> (DVec3, f64) {
        let normal = to_world.normal(self.normal).normalize();
        (normal, normal.dot(to_world.point(self.offset * self.normal)))
    }

    /// The whole plane as a shape.
    pub(crate) fn shape(&self, material: usize) -> ShapeDescription {
        let Frame { x, y, z } = Frame::from_z(self.normal);
        let [x, y, z] = [x, y, z].map(|axis| axis.extend(0.0));
        let to_parent = DMat4::from_cols(x, y, z, (self.offset * self.normal).extend(1.0));
        ShapeDescription { to_parent, material, ..ShapeDescription::plane() }
    }

    /// Largest distance from the plane of points that lie in it, near a point in the frame of the group, metres.
    fn in_plane(&self, group: &SceneGroup, point: DVec3) -> f64 {
        let bounds = group.bvh.bounds();
        let size = if bounds.is_empty() { 0.0 } else { bounds.diagonal().length() };
        IN_PLANE * (size + point.length())
    }

    /// The end of a ray that leaves through the plane at `t`, without what lies in the plane.
    fn end_below(&self, group: &SceneGroup, ray: &Ray, t: f64) -> f64 {
        t - self.in_plane(group, ray.at(t)) / self.normal.dot(ray.direction)
    }

    /// The ray from `t`, where it arrives at the plane, without what lies in the plane.
    fn below(&self, group: &SceneGroup, ray: &Ray, t: f64) -> Ray {
        let point = ray.at(t);
        Ray::new(point - self.in_plane(group, point) * self.normal, ray.direction)
    }

    /// `None` if nothing is left of the ray with `0 < t < t_max`.
    ///
    /// A ray that begins in the plane has just left it, or begins below.
    fn part(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> Option<RayPart> {
        let (height, slope) = (self.normal.dot(ray.origin) - self.offset, self.normal.dot(ray.direction));
        if height.abs() <= self.in_plane(group, ray.origin) {
            return (slope <= 0.0).then_some(RayPart { start: 0.0, end: t_max, crossing: None });
        }
        let crossing = Some(-height / slope).filter(|&t| t > 0.0 && t < t_max);
        match (height > 0.0, crossing) {
            (true, None) => None,
            (true, Some(t)) => Some(RayPart { start: t, end: t_max, crossing }),
            (false, Some(t)) if slope > 0.0 => Some(RayPart { start: 0.0, end: t, crossing }),
            (false, _) => Some(RayPart { start: 0.0, end: t_max, crossing: None }),
        }
    }
}

impl Scene {
    /// The first hit of the ray with `0 < t < t_max` in a group.
    pub(crate) fn closest(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> Option<SceneHit> {
        let Some(section) = &group.section else { return self.closest_uncut(group, ray, t_max) };
        let RayPart { start, end, crossing } = section.part(group, ray, t_max)?;
        let face = || self.face_hit(group, section, ray, crossing?);
        if start > 0.0 {
            let beyond = || {
                let found = self.closest_uncut(group, &section.below(group, ray, start), end - start)?;
                let hit = Hit { t: start + found.hit.t, ..found.hit };
                Some(SceneHit { hit, ..found })
            };
            return face().or_else(beyond);
        }
        let end = crossing.map_or(end, |t| section.end_below(group, ray, t));
        self.closest_uncut(group, ray, end).or_else(face)
    }

    /// Whether the ray hits anything with `0 < t < t_max` in a group.
    pub(crate) fn any(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> bool {
        let Some(section) = &group.section else { return self.any_uncut(group, ray, t_max) };
        let Some(RayPart { start, end, crossing }) = section.part(group, ray, t_max) else { return false };
        let (inside, end) = match crossing {
            Some(_) if start > 0.0 => (section.below(group, ray, start), end),
            Some(t) => (*ray, section.end_below(group, ray, t)),
            None => (*ray, end),
        };
        crossing.is_some_and(|t| self.face_hit(group, section, ray, t).is_some())
            || self.any_uncut(group, &inside, end - start)
    }

    /// The hit with a face of the section at `t`, where the ray crosses its plane; with a face of the model that lies in the plane and ends a solid there.
    fn face_hit(&self, group: &SceneGroup, section: &GroupSection, ray: &Ray, t: f64) -> Option<SceneHit> {
        let (point, height) = (ray.at(t), section.in_plane(group, ray.at(t)) * section.normal);
        let is_inside = |point: DVec3| self.is_inside(group, &Ray::new(point, section.inward));
        if !is_inside(point - height) {
            return None;
        }
        let slope = section.normal.dot(ray.direction);
        let before = Ray::new(point - slope.signum() * height, ray.direction);
        let own = self.closest_uncut(group, &before, 2.0 * height.length() / slope.abs());
        if let Some(own) = own.filter(|_| !is_inside(point + height)) {
            return Some(SceneHit { hit: Hit { t, ..own.hit }, ..own });
        }
        let hit = group.objects.get(section.object as usize)?.intersect(ray, f64::INFINITY)?;
        Some(SceneHit::new(hit, section.object))
    }

    /// Whether the origin of a ray is inside of a solid of a group: of surfaces of the group itself, or of an instance in it.
    fn is_inside(&self, group: &SceneGroup, ray: &Ray) -> bool {
        let (mut inside_instance, mut count, mut hits) = (false, 0, Vec::new());
        let mut solids = BTreeSet::new();
        let mut visit = |primitive: Primitive| match primitive {
            Primitive::Object(object) => {
                let object = &group.objects[object as usize];
                if let Some(solid) = object.solid {
                    solids.insert(solid);
                    return;
                }
                hits.clear();
                object.all_hits(ray, &mut hits);
                count += hits.len();
            }
            Primitive::Instance(index) => {
                let instance = &group.instances[index as usize];
                let local = instance.to_parent.inverse().ray(ray);
                inside_instance |= self.is_inside(&self.groups[instance.group], &local);
            }
        };
        group.unbounded.iter().for_each(|&primitive| visit(primitive));
        group.bvh.any(ray, f64::INFINITY, |leaf| {
            group.bvh.leaf(leaf).iter().for_each(|&index| visit(group.bounded[index as usize]));
            false
        });
        let in_solid = || solids.iter().any(|&solid| group.solid_holds_origin(solid, ray));
        inside_instance || !count.is_multiple_of(2) || in_solid()
    }
}

impl SceneObject {
    /// Adds all hits with the ray, unless the object is an interface.
    fn all_hits(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        if !self.passable {
            glanz_geometry::RaySurface::all_hits(self.surface(), &self.local(ray), f64::INFINITY, hits);
        }
    }
}
