//! Groups that are cut open by a plane.
//!
//! What a plane leaves of a ray is one piece, so that the ray is clipped and hits need not be. Where a ray crosses the plane inside of a solid it hits the
//! flat face of the cut, which the number of hits from there to infinity decides.

use glanz_geometry::Hit;
use glanz_math::{DMat4, DVec3, Frame, Ray};

use crate::description::{SectionDescription, ShapeDescription};
use crate::hit::SceneHit;
use crate::object::SceneObject;
use crate::scene::{Primitive, Scene, SceneGroup};

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

    /// The whole plane as a shape.
    pub(crate) fn shape(&self, material: usize) -> ShapeDescription {
        let Frame { x, y, z } = Frame::from_z(self.normal);
        let [x, y, z] = [x, y, z].map(|axis| axis.extend(0.0));
        let to_parent = DMat4::from_cols(x, y, z, (self.offset * self.normal).extend(1.0));
        ShapeDescription { to_parent, material, ..ShapeDescription::plane() }
    }

    /// `None` if nothing is left of the ray with `0 < t < t_max`.
    fn part(&self, ray: &Ray, t_max: f64) -> Option<RayPart> {
        let (height, slope) = (self.normal.dot(ray.origin) - self.offset, self.normal.dot(ray.direction));
        let crossing = Some(-height / slope).filter(|&t| t > 0.0 && t < t_max);
        match (height > 0.0, crossing) {
            (true, None) => None,
            (true, Some(t)) => Some(RayPart { start: t, end: t_max, crossing }),
            (false, Some(t)) if slope > 0.0 => Some(RayPart { start: 0.0, end: t, crossing }),
            // It begins in the plane or before it, and does not leave.
            (false, _) if slope > 0.0 && height == 0.0 => None,
            (false, _) => Some(RayPart { start: 0.0, end: t_max, crossing: None }),
        }
    }
}

impl Scene {
    /// The first hit of the ray with `0 < t < t_max` in a group.
    pub(crate) fn closest(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> Option<SceneHit> {
        let Some(section) = &group.section else { return self.closest_uncut(group, ray, t_max) };
        let RayPart { start, end, crossing } = section.part(ray, t_max)?;
        let face = || self.face_hit(group, section, ray, crossing?);
        if start > 0.0 {
            let inside = Ray::new(ray.at(start), ray.direction);
            let beyond = || {
                let found = self.closest_uncut(group, &inside, end - start)?;
                let hit = Hit { t: start + found.hit.t, ..found.hit };
                Some(SceneHit { hit, ..found })
            };
            return face().or_else(beyond);
        }
        self.closest_uncut(group, ray, end).or_else(face)
    }

    /// Whether the ray hits anything with `0 < t < t_max` in a group.
    pub(crate) fn any(&self, group: &SceneGroup, ray: &Ray, t_max: f64) -> bool {
        let Some(section) = &group.section else { return self.any_uncut(group, ray, t_max) };
        let Some(RayPart { start, end, crossing }) = section.part(ray, t_max) else { return false };
        let inside = Ray::new(ray.at(start), ray.direction);
        crossing.is_some_and(|t| self.face_hit(group, section, ray, t).is_some())
            || self.any_uncut(group, &inside, end - start)
    }

    /// The hit with a face of the section at `t`, where the ray crosses its plane.
    fn face_hit(&self, group: &SceneGroup, section: &GroupSection, ray: &Ray, t: f64) -> Option<SceneHit> {
        let from = Ray::new(ray.at(t), section.inward);
        if !self.is_inside(group, &from) {
            return None;
        }
        let hit = group.objects.get(section.object as usize)?.intersect(ray, f64::INFINITY)?;
        Some(SceneHit::new(hit, section.object))
    }

    /// Whether the origin of a ray is inside of a solid of a group: of surfaces of the group itself, or of an instance in it.
    fn is_inside(&self, group: &SceneGroup, ray: &Ray) -> bool {
        let (mut inside_instance, mut count, mut hits) = (false, 0, Vec::new());
        let mut visit = |primitive: Primitive| match primitive {
            Primitive::Object(object) => {
                hits.clear();
                group.objects[object as usize].all_hits(ray, &mut hits);
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
        inside_instance || !count.is_multiple_of(2)
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
