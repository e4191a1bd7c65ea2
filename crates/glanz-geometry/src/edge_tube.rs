//! Tubes in space around the trimming curves of a surface.
//!
//! Two faces of a solid meet in an edge from which their trimming curves stray by some distance. Where the faces meet smoothly, a ray at a
//! small angle passes between them, however far they overlap; and no face extends beyond the end of its surface. But every ray between
//! the two curves passes within that distance of either. CAD systems enclose edges in such tubes, too; their radius is the tolerance of the edge.

use glanz_math::{Bounds3, DVec2, DVec3, Ray};

use crate::bvh::{BuildOptions, Bvh};
use crate::hit::{Hit, HitBorder, SurfacePoint};
use crate::surface::{RaySurface, Surface};
use crate::trim::MonotonePiece;

/// Widths of curves, relative to the size of the surface, up to which they have no tubes: few rays meet such a gap at a small angle, and tubes as thin as
/// these would take more memory than the surfaces.
const LEAST_WIDTH: f64 = 1e-6;

/// Smallest radius of a tube relative to the size of the surface: thinner ones would need more parts than a surface has leaves.
const LEAST_RADIUS: f64 = 1e-6;

/// Part of its radius by which the axis of a tube may be off the curve before the tube is halved.
const SAG: f64 = 0.45;

/// Largest number of halvings of the tube of a piece of a curve.
const MOST_HALVINGS: u32 = 12;

/// Largest number of tubes of a surface, from which on they get thicker instead of shorter.
const MOST_TUBES: usize = 1 << 17;

/// Tubes around the curves that trim a surface.
#[derive(Clone, Debug)]
pub struct EdgeTubes {
    tubes: Vec<EdgeTube>,
    bvh: Bvh,
    /// Widths in space, metres, above which curves have tubes.
    least_width: f64,
}

/// The points within a radius of a straight segment, which is close to a part of a trimming curve.
#[derive(Clone, Copy, Debug)]
struct EdgeTube {
    start: DVec3,
    along: DVec3,
    radius: f64,
    face: u32,
    /// Parameters of hits at both ends.
    parameters: [DVec2; 2],
}

/// A point at which a line passes through a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeContact {
    /// The point of the surface on the trimming curve, at the parameter at which the line is nearest to it.
    pub hit: Hit,
    /// Radius of the tube, metres.
    pub radius: f64,
}

/// A point of a trimming curve on the surface.
#[derive(Clone, Copy)]
struct TubeEnd {
    t: f64,
    face: u32,
    parameters: DVec2,
    position: DVec3,
    /// Least distance in space of points of the surface that are one unit apart in the coordinates of the region.
    least_scale: f64,
}

impl Surface {
    /// The tubes around the trimming curves whose width is more than rounding; `None` if there are none, or the surface has no parameters.
    ///
    /// The radius of a tube is at least the width of its curve, in space, and so much more that the tube contains the curve, as far as points
    /// in its middle show.
    #[must_use]
    pub fn edge_tubes(&self) -> Option<EdgeTubes> {
        let region = self.trim_region()?;
        let extent = self.bounds().diagonal().length();
        if !(extent > 0.0 && extent.is_finite()) {
            return None;
        }
        let mut builder = TubeBuilder { surface: self, scale: region.scale(), extent, tubes: Vec::new() };
        region.monotone_pieces().for_each(|piece| builder.add(&piece));
        let tubes = builder.tubes;
        let boxes: Vec<Bounds3> = tubes.iter().map(EdgeTube::bounds).collect();
        let bvh = Bvh::build(&boxes, &BuildOptions::default());
        (!tubes.is_empty()).then_some(EdgeTubes { tubes, bvh, least_width: LEAST_WIDTH * extent })
    }

    /// The point at parameters of the region, with the face and the parameters of a hit there.
    fn point_in_region(&self, uv: DVec2) -> Option<(SurfacePoint, u32, DVec2)> {
        let (face, parameters) = match self {
            Self::Freeform(freeform) => freeform.patch_at(uv)?,
            Self::Trimmed(trimmed) => return trimmed.surface().point_in_region(uv),
            _ if self.faces() == 1 => (0, uv.clamp(DVec2::ZERO, DVec2::ONE)),
            _ => return None,
        };
        Some((self.untrimmed_at(face, parameters)?, face, parameters))
    }
}

/// Divides curves into tubes.
struct TubeBuilder<'a> {
    surface: &'a Surface,
    scale: DVec2,
    extent: f64,
    tubes: Vec<EdgeTube>,
}

impl TubeBuilder<'_> {
    fn add(&mut self, piece: &MonotonePiece) {
        let ends = [0.0, 1.0].map(|t| self.point(piece, t));
        if let [Some(start), Some(end)] = ends {
            let largest = start.least_scale.max(end.least_scale) * piece.width;
            if largest > LEAST_WIDTH * self.extent {
                self.divide(piece, [start, end], MOST_HALVINGS);
            }
        }
    }

    /// Adds tubes for a part of a piece.
    fn divide(&mut self, piece: &MonotonePiece, [start, end]: [TubeEnd; 2], halvings: u32) {
        let Some(middle) = self.point(piece, 0.5 * (start.t + end.t)) else { return };
        let scale = start.least_scale.max(end.least_scale).max(middle.least_scale);
        let radius = (piece.width * scale).max(LEAST_RADIUS * self.extent);
        let sag = middle.position.distance(0.5 * (start.position + end.position));
        // The first halves of a curve that swings around its chord could seem straight.
        let is_straight = sag <= SAG * radius && halvings < MOST_HALVINGS;
        if is_straight && start.face == end.face || halvings == 0 || self.tubes.len() >= MOST_TUBES {
            let parameters = if start.face == end.face {
                [start.parameters, end.parameters]
            } else {
                [start.parameters; 2]
            };
            let along = end.position - start.position;
            let radius = radius + 2.0 * sag;
            self.tubes.push(EdgeTube { start: start.position, along, radius, face: start.face, parameters });
            return;
        }
        self.divide(piece, [start, middle], halvings - 1);
        self.divide(piece, [middle, end], halvings - 1);
    }

    fn point(&self, piece: &MonotonePiece, t: f64) -> Option<TubeEnd> {
        let uv = if t == 0.0 {
            piece.start
        } else if t == 1.0 {
            piece.end
        } else {
            piece.point(t)
        };
        let (SurfacePoint { position, dpdu, dpdv, .. }, face, parameters) =
            self.surface.point_in_region(uv)?;
        let (du, dv) = (dpdu / self.scale.x, dpdv / self.scale.y);
        // The smallest singular value of the two columns.
        let (e, f, g) = (du.length_squared(), du.dot(dv), dv.length_squared());
        let square = 0.5 * (e + g) - (0.5 * (e - g)).hypot(f);
        position.is_finite().then(|| TubeEnd {
            t,
            face,
            parameters,
            position,
            least_scale: square.max(0.0).sqrt(),
        })
    }
}

impl EdgeTube {
    fn bounds(&self) -> Bounds3 {
        Bounds3::new(self.start, self.start + self.along).expanded(self.radius)
    }

    fn contains(&self, point: DVec3) -> bool {
        let offset = point - self.start;
        let s = (offset.dot(self.along) / self.along.length_squared()).clamp(0.0, 1.0);
        let axis = if s.is_finite() { s * self.along } else { DVec3::ZERO };
        offset.distance(axis) <= self.radius
    }

    /// The parameter of a line, and that of the axis, where they are nearest to each other, with their distance; `None` if the line does not
    /// pass through the tube.
    fn approach(&self, line: &Ray) -> Option<(f64, f64, f64)> {
        let (d, e, offset) = (line.direction, self.along, self.start - line.origin);
        let (dd, de, ee) = (d.length_squared(), d.dot(e), e.length_squared());
        let between = ((de * d.dot(offset) - dd * e.dot(offset)) / (dd * ee - de * de)).clamp(0.0, 1.0);
        // Of almost parallel lines, where the quotient is inaccurate, an end is near.
        let candidates = [between, 0.0, 1.0].into_iter().filter(|s| s.is_finite()).map(|s| {
            let q = offset + s * e;
            let t = d.dot(q) / dd;
            (t, s, (q - t * d).length())
        });
        candidates.min_by(|a, b| a.2.total_cmp(&b.2)).filter(|nearest| nearest.2 <= self.radius)
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

    /// Whether a curve of this width in space, metres, has tubes.
    #[must_use]
    pub fn cover(&self, width: f64) -> bool {
        width > self.least_width
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
            tube.approach(ray).is_some_and(|(t, ..)| t * length > tube.radius && t < t_max)
        };
        self.bvh.any(ray, t_max, |leaf| self.bvh.leaf(leaf).iter().any(is_met))
    }

    /// Where a ray passes through tubes, by ascending parameters: once for tubes that follow one another.
    #[must_use]
    pub fn contacts(&self, ray: &Ray) -> Vec<TubeContact> {
        let mut found: Vec<(TubeContact, f64, f64)> = Vec::new();
        let length = ray.direction.length();
        self.bvh.closest(ray, f64::INFINITY, |leaf, end| {
            for tube in self.bvh.leaf(leaf).iter().filter_map(|&index| self.tubes.get(index as usize)) {
                let Some((t, s, distance)) = tube.approach(ray) else { continue };
                let DVec2 { x: u, y: v } = tube.parameters[0].lerp(tube.parameters[1], s);
                let hit = Hit { t, u, v, face: tube.face, border: HitBorder::Outer };
                let reach = (tube.along.length() + 2.0 * tube.radius) / length;
                found.push((TubeContact { hit, radius: tube.radius }, distance, reach));
            }
            end
        });
        found.sort_by(|(a, ..), (b, ..)| {
            a.hit.t.total_cmp(&b.hit.t).then(a.hit.face.cmp(&b.hit.face)).then(a.hit.u.total_cmp(&b.hit.u))
        });
        let mut contacts: Vec<TubeContact> = Vec::new();
        let mut last: Option<(f64, f64)> = None;
        for (contact, distance, reach) in found {
            let follows = last.is_some_and(|(end, _)| contact.hit.t <= end);
            let nearest = last.map_or(f64::INFINITY, |(_, nearest)| nearest);
            match contacts.last_mut().filter(|_| follows) {
                Some(kept) if distance < nearest => *kept = contact,
                Some(_) => {}
                None => contacts.push(contact),
            }
            let nearest = if follows { nearest.min(distance) } else { distance };
            last = Some((contact.hit.t + reach, nearest));
        }
        contacts
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glanz_math::DVec4;

    use super::*;
    use crate::bezier::TensorPatch;
    use crate::freeform::{Freeform, SurfacePatch};
    use crate::quadric::Plane;
    use crate::trim::{RegionSettings, TrimCurve, TrimRegion};

    const RADIUS: f64 = 0.3;
    const WIDTH: f64 = 1e-4;

    /// A disk of [`RADIUS`] about the middle of the unit square in the plane z = 0, trimmed by a circle of a width.
    fn disk(surface: Surface, width: f64) -> Surface {
        let circle = TrimCurve::try_circle(DVec2::splat(0.5), RADIUS).unwrap().with_width(width).unwrap();
        let settings = RegionSettings { scale: DVec2::ONE, domain: Some([DVec2::ZERO, DVec2::ONE]) };
        surface.trimmed(TrimRegion::try_with_settings(vec![vec![circle]], settings).unwrap())
    }

    /// The unit square as a plane, and by four patches of one surface.
    fn squares() -> [Surface; 2] {
        let plane = Surface::from(Plane::try_new([0.0, 1.0], [0.0, 1.0]).unwrap());
        let patch = |x: [f64; 2], y: [f64; 2]| {
            let corners = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| DVec4::new(x[i], y[j], 0.0, 1.0));
            SurfacePatch::over_rectangle(TensorPatch::try_new(1, 1, corners.to_vec()).unwrap(), x, y).unwrap()
        };
        let halves = [[0.0, 0.37], [0.37, 1.0]];
        let patches = halves.iter().flat_map(|&x| halves.map(|y| patch(x, y))).collect();
        [plane, Freeform::try_new(patches).unwrap().into()]
    }

    /// The least distance of a line from the circle, by many points of it.
    fn slow_distance(ray: &Ray) -> f64 {
        let distance = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            let p = DVec3::new(0.5 + RADIUS * cos, 0.5 + RADIUS * sin, 0.0) - ray.origin;
            (p - ray.direction * p.dot(ray.direction) / ray.direction.length_squared()).length()
        };
        (0..200_000).map(|i| distance(TAU * f64::from(i) / 200_000.0)).fold(f64::INFINITY, f64::min)
    }

    fn rays() -> impl Iterator<Item = Ray> {
        (0..60).map(|i| {
            let (phi, turn) = (0.7 * f64::from(i), 0.11 * f64::from(i));
            let outwards = DVec3::new(phi.cos(), phi.sin(), 0.0);
            let target = DVec3::new(0.5, 0.5, 0.0) + RADIUS * outwards;
            let across = DVec3::new(turn.cos(), turn.sin(), 0.4 * (0.3 * f64::from(i)).sin()).normalize();
            let away = across.any_orthonormal_vector() * WIDTH * f64::from(i % 7) / 2.0;
            Ray::new(target + away - 2.0 * across, 1.7 * across)
        })
    }

    #[test]
    fn lines_within_the_width_of_a_curve_meet_its_tube() {
        for square in squares() {
            let surface = disk(square, WIDTH);
            let tubes = surface.edge_tubes().unwrap();
            for ray in rays() {
                let distance = slow_distance(&ray);
                let contacts = tubes.contacts(&ray);
                let meets = tubes.meets(&ray, f64::INFINITY);
                assert_eq!(meets, !contacts.is_empty(), "{ray:?}");
                if distance <= 0.99 * WIDTH {
                    assert!(meets, "{ray:?} {distance}");
                    assert!(!tubes.meets(&ray, contacts[0].hit.t - 0.05), "{ray:?}");
                }
                if distance > 2.0 * WIDTH {
                    assert!(!meets, "{ray:?} {distance}");
                }
                for TubeContact { hit, radius } in contacts {
                    let at = surface.untrimmed_at(hit.face, DVec2::new(hit.u, hit.v)).unwrap();
                    let from_middle = at.position.distance(DVec3::new(0.5, 0.5, 0.0));
                    assert!((from_middle - RADIUS).abs() < WIDTH, "{from_middle}");
                    assert!(at.position.distance(ray.at(hit.t)) <= radius + WIDTH, "{ray:?} {hit:?}");
                    assert!((WIDTH..2.0 * WIDTH).contains(&radius), "{radius}");
                }
            }
        }
    }

    #[test]
    fn points_within_the_width_of_a_curve_are_in_its_tube() {
        let tubes = disk(squares()[1].clone(), WIDTH).edge_tubes().unwrap();
        for i in 0..200 {
            let phi = 0.37 * f64::from(i);
            let outwards = DVec3::new(phi.cos(), phi.sin(), 0.0);
            let on_circle = DVec3::new(0.5, 0.5, 0.0) + RADIUS * outwards;
            let away = (0.3 * outwards + DVec3::Z * (f64::from(i % 5) - 2.0)).normalize();
            assert!(tubes.contain(on_circle + 0.99 * WIDTH * away), "{i}");
            assert!(!tubes.contain(on_circle + 2.0 * WIDTH * away), "{i}");
        }
    }

    #[test]
    fn a_line_through_both_sides_of_a_circle_has_two_contacts() {
        let tubes = disk(squares()[0].clone(), WIDTH).edge_tubes().unwrap();
        let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.0), DVec3::X);
        let at: Vec<f64> = tubes.contacts(&ray).iter().map(|contact| contact.hit.t).collect();
        assert_eq!(at.len(), 2, "{at:?}");
        assert!((at[0] - 1.2).abs() < 1e-2 && (at[1] - 1.8).abs() < 1e-2, "{at:?}");
        // From inside a tube, only the other one counts.
        let ray = Ray::new(DVec3::new(0.2 - 0.5 * WIDTH, 0.5, 0.0), DVec3::X);
        assert!(tubes.meets(&ray, 1.0) && !tubes.meets(&ray, 0.5));
        assert!(!tubes.meets(&Ray::new(ray.origin, DVec3::NEG_X), 1.0));
    }

    #[test]
    fn curves_as_wide_as_rounding_have_no_tubes() {
        for square in squares() {
            assert!(square.edge_tubes().is_none());
            assert!(disk(square, 1e-12).edge_tubes().is_none());
        }
    }
}
