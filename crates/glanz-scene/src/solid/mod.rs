//! Solids, bounded by several objects of a group.
//!
//! Trimming curves of two faces agree with the common edge only up to their widths, so that both faces extend beyond it: next to an edge a
//! ray may hit one face, both, or beyond the edge a face that it should pass. Hits in the border of a trimming curve are therefore optional
//! if their object bounds a solid: of all crossings of the ray's line with the boundary, [`LineCrossings`] accepts those by which the line
//! enters and leaves the solid in turns. The whole line counts, not only the part ahead of the ray: a ray that has just left through one of
//! two overlapping faces would leave through the other once more, and one that has just entered could not be told from one that passes by.
//!
//! A ray at a small angle to two faces that meet smoothly passes between them however far they overlap, and no face extends beyond the end of its
//! surface. Such a ray passes through the tube of the edge ([`EdgeTubes`]), where a crossing is accepted if the turns lack one. It may pass there in
//! either direction if a face runs along it and turns from one side to the other within the tube.

mod crossing;
mod parity;

use glanz_geometry::{EdgeTubes, Hit, HitBorder, RaySurface, TubeContact};
use glanz_math::{DVec3, Ray};

use self::crossing::{BoundaryCrossing, CrossingKind, find_crossings_beside_tubes};
use self::parity::LineCrossings;
use crate::alpha::RayKind;
use crate::object::SceneObject;
use crate::scene::{Primitive, SceneGroup};

/// Distance of a line's start from the bounds of its group, relative to their diagonal.
const LINE_MARGIN: f64 = 0.01;

/// Distance of a surface behind a ray's origin up to which the ray starts from it, relative to the size of the coordinates: ten times the rounding of
/// a point on a freeform surface. With more, a ray that starts next to an edge would start from both faces.
const START_DISTANCE: f64 = 1e-12;

/// Largest distance by which rounding moves a hit along a line, even at a small angle, relative to the size of the group.
const MISPLACED: f64 = 1e-6;

/// Directions in the plane across a line, by two perpendicular ones.
const OBLIQUE: [(f64, f64); 3] = [(0.8, 0.53), (-0.37, 0.89), (-0.66, -0.31)];

impl SceneObject {
    /// Whether a ray may pass between the object and a neighbour before `t_max`; if it has a hit, before this one, or so close behind that the surface
    /// at the hit runs through the tube.
    #[inline]
    fn meets_tube(&self, ray: &Ray, t_max: f64, hit: Option<&Hit>) -> bool {
        let Some(tubes) = self.tubes() else { return false };
        let local = self.local(ray);
        match hit {
            None => tubes.meets(&local, t_max),
            // Few rays that hit a surface meet any of its tubes, and the end of the ray must not decide about the hit.
            Some(hit) => {
                tubes.meets(&local, f64::INFINITY) && tubes.meets(&local, self.end_beside(tubes, &local, hit))
            }
        }
    }

    /// The parameter behind a hit up to which a tube may be beside it, see [`find_crossings_beside_tubes`].
    #[cold]
    fn end_beside(&self, tubes: &EdgeTubes, local: &Ray, hit: &Hit) -> f64 {
        let normal = self.surface().location(local, hit).normal;
        let sine = normal.dot(local.direction).abs() / normal.length();
        hit.t + 2.0 * tubes.largest_radius() / sine
    }

    /// The crossing at a hit of the line that is `local` in the frame of the surface, at `t`; `None` if it is beyond the object.
    fn boundary_crossing(&self, number: u32, local: &Ray, hit: &Hit, t: f64) -> Option<BoundaryCrossing> {
        let surface = self.surface();
        let (kind, normal, width) = match surface.trim_region().filter(|_| hit.border != HitBorder::Away) {
            Some(region) => {
                let point = surface.point(local, hit);
                let width = region.border_width(point.uv, [point.dpdu, point.dpdv]);
                (self.border_kind(hit.border, point.position, width)?, point.normal, width)
            }
            None => (CrossingKind::Certain, surface.location(local, hit).normal, 0.0),
        };
        let (along, length) = (normal.dot(local.direction), local.direction.length());
        // The side does not depend on the frame.
        let entering = (along < 0.0) != self.attributes(hit.face).reversed;
        let cos = along.abs() / (normal.length() * length);
        Some(BoundaryCrossing { t, entering, kind, width: width / length, cos, object: number, hit: *hit })
    }

    /// The kind of a crossing in a border of this width at a point. Where parameters are dense, as near a pole, a border in parameters reaches far
    /// beyond the tubes in space, which then decide.
    fn border_kind(&self, border: HitBorder, position: DVec3, width: f64) -> Option<CrossingKind> {
        let is_beyond = self.tubes().is_some_and(|tubes| tubes.cover(width) && !tubes.contain(position));
        match border {
            HitBorder::Away => Some(CrossingKind::Certain),
            HitBorder::Inner => Some(if is_beyond { CrossingKind::Certain } else { CrossingKind::Inner }),
            HitBorder::Outer => (!is_beyond).then_some(CrossingKind::Outer),
        }
    }

    /// Crossings beside the object, in its tubes. `start`: the parameter, along the ray, of the origin of `line`, which is `local` in the
    /// frame of the surface.
    fn crossings_in_tubes(&self, number: u32, local: &Ray, start: f64) -> Vec<BoundaryCrossing> {
        let contacts = self.tubes().map(|tubes| tubes.contacts(local)).unwrap_or_default();
        let length = local.direction.length();
        let crossing = |hit: Hit, radius: f64| {
            let normal = self.surface().location(local, &hit).normal;
            let along = normal.dot(local.direction);
            let entering = (along < 0.0) != self.attributes(hit.face).reversed;
            let cos = along.abs() / (normal.length() * length);
            let (t, width) = (start + hit.t, radius / length);
            // A ray that starts in a tube starts behind it.
            let t = if t <= width { t.min(0.0) } else { t };
            let (kind, hit) = (CrossingKind::InTube, Hit { t, ..hit });
            BoundaryCrossing { t, entering, kind, width, cos, object: number, hit }
        };
        let both = |contact: TubeContact| {
            let turned = self.surface().turned_contact(local, &contact);
            std::iter::once(contact.hit).chain(turned).map(move |hit| crossing(hit, contact.radius))
        };
        contacts.into_iter().flat_map(both).collect()
    }
}

impl SceneGroup {
    /// The first hit of a ray with an object of the group that counts.
    pub(crate) fn object_hit(&self, object: u32, ray: &Ray, t_max: f64, kind: RayKind) -> Option<Hit> {
        self.accepted_hit(object, ray, t_max, self.objects[object as usize].intersect(ray, t_max), kind)
    }

    /// The first hit with an object that counts; `hit` is the first of all.
    #[inline]
    pub(crate) fn accepted_hit(
        &self,
        object: u32,
        ray: &Ray,
        t_max: f64,
        hit: Option<Hit>,
        kind: RayKind,
    ) -> Option<Hit> {
        let surface = &self.objects[object as usize];
        let is_certain = hit.is_none_or(|hit| hit.border == HitBorder::Away);
        let hit = match surface.solid {
            Some(solid) if !is_certain || surface.meets_tube(ray, t_max, hit.as_ref()) => {
                self.first_accepted_hit(object, solid, ray, t_max)
            }
            _ => hit,
        };
        match &surface.alpha {
            Some(_) => self.opaque_hit(object, ray, t_max, hit?, kind),
            None => hit,
        }
    }

    #[cold]
    fn first_accepted_hit(&self, object: u32, solid: u32, ray: &Ray, t_max: f64) -> Option<Hit> {
        let mut hits = Vec::new();
        self.counting_hits(object, solid, ray, t_max, &mut hits);
        hits.first().copied()
    }

    /// Adds all hits of a ray with an object of a solid that count, in ascending order.
    pub(crate) fn counting_hits(&self, object: u32, solid: u32, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let (crossings, accepted) = self.settled_crossings(solid, ray);
        let counting = crossings.iter().zip(accepted).filter(|(crossing, counts)| {
            *counts && crossing.object == object && crossing.t > 0.0 && crossing.t < t_max
        });
        hits.extend(counting.map(|(crossing, _)| crossing.hit));
    }

    /// The crossings of the line of a ray with a solid, and which of them count. Where their turns leave doubt on which side of the boundary a part of the
    /// line is, a line through its middle in another direction tells.
    fn settled_crossings(&self, solid: u32, ray: &Ray) -> (Vec<BoundaryCrossing>, Vec<bool>) {
        let crossings = self.boundary_crossings(solid, ray);
        let mut sides: Vec<Option<bool>> = Vec::new();
        loop {
            let line = LineCrossings { crossings: &crossings, sides: &sides };
            let accepted = line.accepted();
            let doubtful = line.doubtful_gaps(&accepted);
            if doubtful.is_empty() {
                return (crossings, accepted);
            }
            // Every round settles at least one more of them.
            sides.resize(crossings.len(), None);
            for gap in doubtful {
                let Some([before, after]) = crossings.get(gap..gap + 2) else { continue };
                let middle = ray.at(0.5 * (before.t + after.t));
                sides[gap] = Some(self.is_inside(solid, middle, ray.direction));
            }
        }
    }

    /// Whether a point is inside of a solid, by a line in another direction than `direction`: the first of some that is away from edges, or else the
    /// first of all.
    fn is_inside(&self, solid: u32, point: DVec3, direction: DVec3) -> bool {
        let (x, y) = direction.normalize_or(DVec3::Z).any_orthonormal_pair();
        let mut of_first = None;
        // Oblique, since faces are often parallel or perpendicular to each other.
        for (along_x, along_y) in OBLIQUE {
            let line = Ray::new(point, along_x * x + along_y * y);
            let crossings = self.boundary_crossings(solid, &line);
            let is_inside = holds_origin(&crossings);
            if crossings.iter().all(|crossing| crossing.kind == CrossingKind::Certain) {
                return is_inside;
            }
            of_first.get_or_insert(is_inside);
        }
        of_first.unwrap_or_default()
    }

    /// Whether the origin of a ray is inside of a solid, by the line of the ray.
    pub(crate) fn solid_holds_origin(&self, solid: u32, ray: &Ray) -> bool {
        holds_origin(&self.boundary_crossings(solid, ray))
    }

    /// All crossings of the line of a ray with the objects that bound a solid, in ascending order; those behind its origin have t <= 0.
    ///
    /// A crossing right behind the origin, along its normal, is one that the ray starts from. It counts, whatever its border: it did when the ray that led
    /// there met it.
    fn boundary_crossings(&self, solid: u32, ray: &Ray) -> Vec<BoundaryCrossing> {
        let diagonal = self.bvh.bounds().diagonal().length();
        // Of nothing but infinite objects there is no box.
        let diagonal = if diagonal.is_finite() { diagonal } else { 0.0 };
        let (start, per_length) = (self.line_start(ray, diagonal), 1.0 / ray.direction.length());
        // Rounding is that of the frame of the world, in which rays are made.
        let near = START_DISTANCE * per_length * (diagonal + ray.origin.length() + self.placement_distance);
        let line = if start < 0.0 { Ray::new(ray.at(start), ray.direction) } else { *ray };
        let (mut crossings, mut behind, mut ahead) = (Vec::new(), Vec::new(), Vec::new());
        let mut origin: Option<(f64, f64, u32)> = None;
        let mut visit = |primitive: Primitive, is_bounded: bool| {
            let Primitive::Object(object) = primitive else { return };
            let surface = &self.objects[object as usize];
            if surface.solid != Some(solid) {
                return;
            }
            let local = surface.local(ray);
            ahead.clear();
            behind.clear();
            surface.surface().all_hits(&local, f64::INFINITY, &mut ahead);
            let (from, offset) = if is_bounded { (surface.local(&line), start) } else { (local, 0.0) };
            if !is_bounded {
                // No start of the line is before all of an infinite object.
                let back = Ray::new(local.origin, -local.direction);
                surface.surface().all_hits(&back, f64::INFINITY, &mut behind);
                behind.iter_mut().for_each(|hit| hit.t = -hit.t);
            } else if start < 0.0 {
                // Those of the line that the ray does not have.
                surface.surface().all_hits(&from, f64::INFINITY, &mut behind);
                let misplaced = MISPLACED * per_length * diagonal;
                behind.truncate(count_behind(&behind, &ahead, -start, misplaced));
            }
            for hit in &behind {
                let t = (offset + hit.t).min(0.0);
                let Some(crossing) = surface.boundary_crossing(object, &from, hit, t) else { continue };
                // Rays start as far above their surface as rounding may move it, and nearer to others by chance only.
                let height = -t * crossing.cos;
                if height <= near && origin.is_none_or(|(highest, ..)| height > highest) {
                    origin = Some((height, t, object));
                }
                crossings.push(crossing);
            }
            let ahead = ahead.iter().filter_map(|hit| surface.boundary_crossing(object, &local, hit, hit.t));
            crossings.extend(ahead);
            crossings.extend(surface.crossings_in_tubes(object, &surface.local(&line), start));
        };
        self.unbounded.iter().for_each(|&primitive| visit(primitive, false));
        self.bvh.closest(&line, f64::INFINITY, |leaf, _| {
            self.bvh.leaf(leaf).iter().for_each(|&index| visit(self.bounded[index as usize], true));
            f64::INFINITY
        });
        crossings.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.object.cmp(&b.object)));
        find_crossings_beside_tubes(&mut crossings);
        if let Some((_, t, object)) = origin {
            let started =
                |c: &&mut BoundaryCrossing| c.t == t && c.object == object && c.kind != CrossingKind::InTube;
            crossings.iter_mut().filter(started).for_each(|c| c.kind = CrossingKind::Certain);
        }
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
            !surface.passable && self.object_hit(object, ray, t_max, RayKind::Shadow).is_some()
        } else {
            surface.occluded(ray, t_max)
        }
    }
}

/// Whether the origin of a line lies between two of its crossings, in ascending order, that enter and leave.
fn holds_origin(crossings: &[BoundaryCrossing]) -> bool {
    let accepted = LineCrossings { crossings, sides: &[] }.accepted();
    let mut behind = crossings.iter().zip(accepted).filter(|(crossing, counts)| *counts && crossing.t <= 0.0);
    behind.next_back().is_some_and(|(crossing, _)| crossing.entering)
}

/// Number of the hits of a line that lie behind `origin`, a parameter of it; `ahead`: the hits of the ray that starts there.
///
/// They are those that the ray does not have: a hit at the origin itself is on one side of it only. If that contradicts their parameters by more than
/// `misplaced`, one of the two searches lacks a hit, as at a silhouette, and the parameters decide.
fn count_behind(line: &[Hit], ahead: &[Hit], origin: f64, misplaced: f64) -> usize {
    let count = line.len().saturating_sub(ahead.len());
    let (behind, rest) = line.split_at(count);
    let agree = behind.last().is_none_or(|hit| hit.t <= origin + misplaced)
        && rest.first().is_none_or(|hit| hit.t >= origin - misplaced);
    if agree { count } else { line.partition_point(|hit| hit.t <= origin) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_behind_the_origin_are_those_that_the_ray_lacks() {
        for (line, ahead, expected) in [
            (&[1.0, 2.0, 4.0][..], &[1.0][..], 2),
            (&[], &[], 0),
            // At the origin, on either side of it.
            (&[1.0, 3.0 + 1e-9, 4.0], &[1.0], 2),
            (&[1.0, 3.0 - 1e-9, 4.0], &[1e-12, 1.0], 1),
            // The ray lacks one that touches the surface, or the line does.
            (&[1.0, 3.5, 4.0], &[1.0], 1),
            (&[1.0, 4.0], &[0.5, 1.0], 1),
            (&[4.0], &[0.5, 1.0], 0),
        ] {
            let [line, ahead] =
                [line, ahead].map(|t| -> Vec<Hit> { t.iter().map(|&t| Hit::new(t, 0.0, 0.0, 0)).collect() });
            assert_eq!(count_behind(&line, &ahead, 3.0, 1e-6), expected, "{line:?} {ahead:?}");
        }
    }
}
