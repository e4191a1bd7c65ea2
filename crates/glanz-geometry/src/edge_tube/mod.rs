//! Tubes in space around the trimming curves of a surface.
//!
//! Two faces of a solid meet in an edge from which their trimming curves stray by some distance. Where the faces meet smoothly, a ray at a
//! small angle passes between them, however far they overlap; and no face extends beyond the end of its surface. But every ray between
//! the two curves passes within that distance of either. CAD systems enclose edges in such tubes, too; their radius is the tolerance of the edge.

mod builder;
mod patch_index;
#[cfg(test)]
mod tests;
mod tube;

use glanz_math::{Bounds3, DVec2, DVec3, Ray};

use self::builder::TubeBuilder;
use self::tube::{EdgeTube, TubeApproach};
use crate::bvh::{BuildOptions, Bvh};
use crate::freeform::Freeform;
use crate::hit::{Hit, HitBorder, SurfacePoint};
use crate::surface::{RaySurface, Surface};

/// Largest number of doublings of the distance from a contact in the search for one in the other direction.
const MOST_DOUBLINGS: i32 = 24;

/// Tubes around the curves that trim a surface.
#[derive(Clone, Debug)]
pub struct EdgeTubes {
    tubes: Vec<EdgeTube>,
    bvh: Bvh,
    /// Width in space, metres, above which all curves have tubes.
    widest_without: f64,
    largest_radius: f64,
}

/// A point at which a line passes through a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeContact {
    /// The point of the surface on the trimming curve, at the parameter at which the line is nearest to it.
    pub hit: Hit,
    /// Radius of the tube, metres.
    pub radius: f64,
}

/// Contacts of a line with tubes that follow one another along a curve.
struct ContactRun {
    /// Numbers of the first and the last tube.
    tubes: [u32; 2],
    /// The contact nearest to the curve, and its distance.
    contact: TubeContact,
    distance: f64,
    /// Parameters of the line outside of which it is in none of them.
    range: [f64; 2],
}

impl ContactRun {
    fn new(index: u32, tube: &EdgeTube, line: &Ray, nearest: &TubeApproach) -> Self {
        let &TubeApproach { t, s, distance } = nearest;
        let DVec2 { x: u, y: v } = tube.parameters[0].lerp(tube.parameters[1], s);
        let hit = Hit { t, u, v, face: tube.face, border: HitBorder::Outer };
        let contact = TubeContact { hit, radius: tube.radius };
        Self { tubes: [index; 2], contact, distance, range: tube.range(line, nearest) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.range[0] <= other.range[1] && other.range[0] <= self.range[1]
    }

    /// Extends it by `next`, whose first tube starts where its last one ends.
    fn append(&mut self, next: Self) {
        self.tubes[1] = next.tubes[1];
        self.range = [self.range[0].min(next.range[0]), self.range[1].max(next.range[1])];
        if next.distance < self.distance {
            (self.contact, self.distance) = (next.contact, next.distance);
        }
    }
}

impl Surface {
    /// The tubes around the trimming curves whose width is more than rounding; `None` if there are none, or the surface has no parameters.
    ///
    /// The radius of a tube is the largest width of its curve in space at five points along the tube, and twice the largest distance from its axis of
    /// the three between its ends. Where the surface curves more between the points, points of the border may be outside of the tube.
    #[must_use]
    pub fn edge_tubes(&self) -> Option<EdgeTubes> {
        let region = self.trim_region()?;
        let extent = self.bounds().diagonal().length();
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let mut builder = TubeBuilder::new(self, region, extent);
        region.monotone_pieces().for_each(|piece| builder.add(&piece));
        let TubeBuilder { mut tubes, widest_without, .. } = builder;
        tubes.shrink_to_fit();
        let boxes: Vec<Bounds3> = tubes.iter().map(EdgeTube::bounds).collect();
        let bvh = Bvh::build(&boxes, &BuildOptions::default());
        let largest_radius = tubes.iter().map(|tube| tube.radius).fold(0.0, f64::max);
        (!tubes.is_empty()).then_some(EdgeTubes { tubes, bvh, widest_without, largest_radius })
    }

    /// The freeform surface that is or is trimmed to this one, if it is of that kind.
    fn freeform(&self) -> Option<&Freeform> {
        match self {
            Self::Freeform(freeform) => Some(freeform),
            Self::Trimmed(trimmed) => trimmed.surface().freeform(),
            _ => None,
        }
    }

    /// A hit near a contact of a line with a tube of the surface, at which the line passes through the surface in the other direction than at the
    /// contact, with the parameter of the contact.
    ///
    /// Next to the contact, along the line, the surface may run within the diameter of the tube beside the line for long enough that it turns
    /// to the other side: of two faces that meet smoothly, the line then may pass between them in either direction.
    #[must_use]
    pub fn turned_contact(&self, line: &Ray, contact: &TubeContact) -> Option<Hit> {
        let TubeContact { hit, radius } = *contact;
        let parameters = DVec2::new(hit.u, hit.v);
        let SurfacePoint { position, dpdu, dpdv, normal, .. } = self.untrimmed_at(hit.face, parameters)?;
        let size = match self.freeform() {
            Some(freeform) => freeform.patch_rectangle(hit.face).map(|[low, high]| high - low)?,
            None => DVec2::ONE,
        };
        let direction = line.direction.normalize();
        let side = normal.dot(direction);
        // The step in the parameters of the face that leads one metre along the line.
        let (a, b) = (dpdu * size.x, dpdv * size.y);
        let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
        let (x, y) = (a.dot(direction), b.dot(direction));
        let step = DVec2::new(g * x - f * y, e * y - f * x) / (e * g - f * f);
        let at = |way: f64| {
            let to = parameters + way * step;
            if !(to.cmpge(DVec2::ZERO).all() && to.cmple(DVec2::ONE).all()) {
                return None;
            }
            let point = self.untrimmed_at(hit.face, to)?;
            let offset = point.position - line.origin;
            let is_near = (offset - offset.dot(direction) * direction).length() <= 2.0 * radius;
            let is_kept = self.trim_region().is_none_or(|region| region.contains(point.uv));
            let is_turned = point.normal.dot(direction) * side < 0.0;
            (is_near && is_kept && position.is_finite()).then_some((is_turned, to))
        };
        [-1.0, 1.0].into_iter().find_map(|sign| {
            let mut ways =
                (1..=MOST_DOUBLINGS).map_while(|doublings| at(sign * radius * 2.0_f64.powi(doublings)));
            let (_, DVec2 { x: u, y: v }) = ways.find(|(is_turned, _)| *is_turned)?;
            Some(Hit { u, v, ..hit })
        })
    }
}

impl EdgeTubes {
    /// A box around the tubes.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        self.bvh.bounds()
    }

    /// Number of tubes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.tubes.len()
    }

    /// Whether every curve with a border of this width in space, metres, has tubes.
    #[must_use]
    pub fn cover(&self, width: f64) -> bool {
        width > self.widest_without
    }

    /// Whether a point lies in a tube.
    #[must_use]
    pub fn contain(&self, point: DVec3) -> bool {
        let contains = |&index: &u32| self.tubes.get(index as usize).is_some_and(|tube| tube.contains(point));
        // The beginning of any ray.
        self.bvh.any(&Ray::new(point, DVec3::X), 0.0, |leaf| self.bvh.leaf(leaf).iter().any(contains))
    }

    /// Whether a ray passes through a tube before `t_max`; tubes around its origin do not count.
    #[must_use]
    pub fn meets(&self, ray: &Ray, t_max: f64) -> bool {
        let length = ray.direction.length();
        let is_met = |&index: &u32| {
            let Some(tube) = self.tubes.get(index as usize) else { return false };
            tube.approach(ray).is_some_and(|at| at.t * length > tube.radius && at.t < t_max)
        };
        self.bvh.any(ray, t_max, |leaf| self.bvh.leaf(leaf).iter().any(is_met))
    }

    /// The largest radius, metres.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    /// Where a line passes through tubes, by ascending parameters: once for tubes that follow one another along a curve, as far as the line is in
    /// them without a break.
    #[must_use]
    pub fn contacts(&self, line: &Ray) -> Vec<TubeContact> {
        let mut found: Vec<ContactRun> = Vec::new();
        self.bvh.closest(line, f64::INFINITY, |leaf, end| {
            let tubes = self
                .bvh
                .leaf(leaf)
                .iter()
                .filter_map(|&index| Some((index, self.tubes.get(index as usize)?)));
            found.extend(
                tubes.filter_map(|(index, tube)| {
                    Some(ContactRun::new(index, tube, line, &tube.approach(line)?))
                }),
            );
            end
        });
        found.sort_by_key(|run| run.tubes[0]);
        let mut runs: Vec<ContactRun> = Vec::new();
        for run in found {
            match runs.last_mut().filter(|before| self.follows(before, &run)) {
                Some(before) => before.append(run),
                None => runs.push(run),
            }
        }
        // The last tube of a loop ends where its first starts.
        for index in (0..runs.len()).rev() {
            let first = runs.iter().take(index).position(|first| self.follows(&runs[index], first));
            if let Some(first) = first {
                let run = runs.remove(index);
                let next = std::mem::replace(&mut runs[first], run);
                runs[first].append(next);
            }
        }
        let mut contacts: Vec<TubeContact> = runs.into_iter().map(|run| run.contact).collect();
        contacts.sort_by(|TubeContact { hit: a, .. }, TubeContact { hit: b, .. }| {
            a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)).then(a.u.total_cmp(&b.u))
        });
        contacts
    }

    /// Whether `next` starts where `run` ends, on the curve and, up to an overlap, on the line.
    fn follows(&self, run: &ContactRun, next: &ContactRun) -> bool {
        let ends = [self.tubes.get(run.tubes[1] as usize), self.tubes.get(next.tubes[0] as usize)];
        let [Some(last), Some(first)] = ends else { return false };
        // Both are the same point of the curve, up to the rounding of one of them.
        last.end().distance(first.start) <= 1e-3 * last.radius && run.overlaps(next)
    }
}
