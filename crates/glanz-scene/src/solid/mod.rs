//! Solids, bounded by several objects of a group.
//!
//! Trimming curves of two faces agree with the common edge only up to their widths, so that both faces extend beyond it: next to an edge a
//! ray may hit one face, both, or beyond the edge a face that it should pass. Hits in the border of a trimming curve are therefore optional
//! if their object bounds a solid: of all crossings of the ray's line with the boundary, [`accepted_crossings`] accepts those by which the line
//! enters and leaves the solid in turns. The whole line counts, not only the part ahead of the ray: a ray that has just left through one of
//! two overlapping faces would leave through the other once more, and one that has just entered could not be told from one that passes by.

mod crossing;

use glanz_geometry::{Hit, HitBorder, RaySurface, SurfacePoint};
use glanz_math::{DVec2, DVec3, Ray};

use self::crossing::{BoundaryCrossing, accepted_crossings};
use crate::object::SceneObject;
use crate::scene::{Primitive, SceneGroup};

/// Distance of a line's start from the bounds of its group, relative to their diagonal.
const LINE_MARGIN: f64 = 0.01;

/// Distance of a surface behind a ray's origin up to which the ray starts from it, relative to the size of the coordinates: ten times the rounding of
/// a point on a freeform surface. With more, a ray that starts next to an edge would start from both faces.
const START_DISTANCE: f64 = 1e-12;

impl SceneObject {
    /// The crossing at a hit of the line that is `local` in the frame of the surface, at `t`, with the cosine of the angle between line and
    /// normal. `number`: that of the object.
    fn boundary_crossing(&self, number: u32, local: &Ray, hit: &Hit, t: f64) -> (BoundaryCrossing, f64) {
        let surface = self.surface();
        let (normal, width) = match surface.trim_region().filter(|_| hit.border != HitBorder::Away) {
            Some(region) => {
                let SurfacePoint { normal, dpdu, dpdv, .. } = surface.point(local, hit);
                // Metres per unit of the coordinates in which the region has its widths.
                let scale = DVec2::new(dpdu.length(), dpdv.length()) / region.scale();
                (normal, region.max_width() * scale.max_element() / local.direction.length())
            }
            None => (surface.location(local, hit).normal, 0.0),
        };
        let along = normal.dot(local.direction);
        // The side does not depend on the frame.
        let entering = (along < 0.0) != self.attributes(hit.face).reversed;
        let cos = along.abs() / (normal.length() * local.direction.length());
        (BoundaryCrossing { t, entering, border: hit.border, width, object: number, hit: *hit }, cos)
    }
}

impl SceneGroup {
    /// The first hit of a ray with an object of the group that counts.
    pub(crate) fn object_hit(&self, object: u32, ray: &Ray, t_max: f64) -> Option<Hit> {
        let hit = self.objects[object as usize].intersect(ray, t_max)?;
        self.accepted_hit(object, ray, t_max, hit)
    }

    /// The first hit with an object that counts, of which `hit` is the first.
    #[inline]
    pub(crate) fn accepted_hit(&self, object: u32, ray: &Ray, t_max: f64, hit: Hit) -> Option<Hit> {
        if hit.border == HitBorder::Away {
            return Some(hit);
        }
        match self.objects[object as usize].solid {
            Some(solid) => self.first_accepted_hit(object, solid, ray, t_max),
            None => Some(hit),
        }
    }

    #[cold]
    fn first_accepted_hit(&self, object: u32, solid: u32, ray: &Ray, t_max: f64) -> Option<Hit> {
        let crossings = self.boundary_crossings(solid, ray);
        let mut accepted = accepted_crossings(&crossings);
        self.drop_chords_outside(solid, ray, &crossings, &mut accepted);
        let mut counting = crossings.iter().zip(accepted).filter(|(_, counts)| *counts);
        let is_found =
            |crossing: &BoundaryCrossing| crossing.object == object && crossing.t > 0.0 && crossing.t < t_max;
        counting.find(|(crossing, _)| is_found(crossing)).map(|(crossing, _)| crossing.hit)
    }

    /// Drops chords from border to border whose middle lies outside: such lines run just above a face, from one face beyond its edge to
    /// another. Their own turns cannot tell them from lines through two slits.
    fn drop_chords_outside(
        &self,
        solid: u32,
        ray: &Ray,
        crossings: &[BoundaryCrossing],
        accepted: &mut [bool],
    ) {
        let mut before: Option<usize> = None;
        for (index, crossing) in crossings.iter().enumerate() {
            if !accepted.get(index).is_some_and(|accepted| *accepted) {
                continue;
            }
            let start = before.replace(index).and_then(|before| Some((before, crossings.get(before)?)));
            let Some((start_index, start)) = start else { continue };
            if start.entering
                && ![start.border, crossing.border].contains(&HitBorder::Away)
                && !self.is_inside(solid, ray.at(0.5 * (start.t + crossing.t)), ray.direction)
            {
                for dropped in [start_index, index] {
                    accepted.iter_mut().skip(dropped).take(1).for_each(|accepted| *accepted = false);
                }
            }
        }
    }

    /// Whether a point is inside of a solid, by a line in another direction than `direction`.
    fn is_inside(&self, solid: u32, point: DVec3, direction: DVec3) -> bool {
        let (x, y) = direction.normalize_or(DVec3::Z).any_orthonormal_pair();
        // Oblique, since faces are often parallel or perpendicular to each other.
        let crossings = self.boundary_crossings(solid, &Ray::new(point, 0.8 * x + 0.53 * y));
        let accepted = accepted_crossings(&crossings);
        let mut behind =
            crossings.iter().zip(accepted).filter(|(crossing, counts)| *counts && crossing.t <= 0.0);
        behind.next_back().is_some_and(|(crossing, _)| crossing.entering)
    }

    /// All crossings of the line of a ray with the objects that bound a solid, in ascending order; those behind its origin have t <= 0.
    ///
    /// A crossing right behind the origin, along its normal, is one that the ray starts from. It counts, whatever its border: it did when the ray that led
    /// there met it.
    fn boundary_crossings(&self, solid: u32, ray: &Ray) -> Vec<BoundaryCrossing> {
        let diagonal = self.bvh.bounds().diagonal().length();
        let (start, per_length) = (self.line_start(ray, diagonal), 1.0 / ray.direction.length());
        let near = START_DISTANCE * per_length * (diagonal + ray.origin.length());
        let line = if start < 0.0 { Ray::new(ray.at(start), ray.direction) } else { *ray };
        let (mut crossings, mut behind, mut ahead) = (Vec::new(), Vec::new(), Vec::new());
        let mut origin: Option<(f64, f64, u32)> = None;
        let mut visit = |primitive: Primitive| {
            let Primitive::Object(object) = primitive else { return };
            let surface = &self.objects[object as usize];
            if surface.solid != Some(solid) {
                return;
            }
            let local = surface.local(ray);
            ahead.clear();
            behind.clear();
            surface.surface().all_hits(&local, f64::INFINITY, &mut ahead);
            if start < 0.0 {
                // Those of the line that the ray does not have.
                let local = surface.local(&line);
                surface.surface().all_hits(&local, f64::INFINITY, &mut behind);
                behind.truncate(behind.len().saturating_sub(ahead.len()));
                for hit in &behind {
                    let t = (start + hit.t).min(0.0);
                    let (crossing, cos) = surface.boundary_crossing(object, &local, hit, t);
                    // Rays start as far above their surface as rounding may move it, and nearer to others by chance only.
                    let height = -t * cos;
                    if height <= near && origin.is_none_or(|(highest, ..)| height > highest) {
                        origin = Some((height, t, object));
                    }
                    crossings.push(crossing);
                }
            }
            crossings.extend(ahead.iter().map(|hit| surface.boundary_crossing(object, &local, hit, hit.t).0));
        };
        self.unbounded.iter().for_each(|&primitive| visit(primitive));
        self.bvh.closest(&line, f64::INFINITY, |leaf, _| {
            self.bvh.leaf(leaf).iter().for_each(|&index| visit(self.bounded[index as usize]));
            f64::INFINITY
        });
        if let Some((_, t, object)) = origin {
            let started =
                crossings.iter_mut().filter(|crossing| crossing.t == t && crossing.object == object);
            started.for_each(|crossing| crossing.border = HitBorder::Away);
        }
        crossings.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.object.cmp(&b.object)));
        crossings
    }

    /// The parameter at which the line of a ray is before the bounds of the group, of this diagonal; 0 if its origin is.
    fn line_start(&self, ray: &Ray, diagonal: f64) -> f64 {
        let bounds = self.bvh.bounds();
        let sides = [bounds.min, bounds.max].map(|corner| (corner - ray.origin) / ray.direction);
        // In directions along which the line does not run, it has no end.
        let entries = sides[0].min(sides[1]).to_array().into_iter().filter(|t| t.is_finite());
        let start =
            entries.fold(f64::NEG_INFINITY, f64::max) - LINE_MARGIN * diagonal / ray.direction.length();
        if start.is_finite() { start.min(0.0) } else { 0.0 }
    }

    /// Whether an object of the group stops a ray.
    pub(crate) fn is_stopped_by_object(&self, object: u32, ray: &Ray, t_max: f64) -> bool {
        let surface = &self.objects[object as usize];
        if surface.has_optional_hits() {
            // Any hit away from the border decides, but only the first is known with its border.
            !surface.passable && self.object_hit(object, ray, t_max).is_some()
        } else {
            surface.occluded(ray, t_max)
        }
    }
}
