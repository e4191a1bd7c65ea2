//! Axis-aligned boxes.

use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::convex::{ConvexInterval, FacetCrossing};
use crate::error::{SurfaceError, finite};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;

/// An axis-aligned box with outward normals.
///
/// Facet 2 a is the side with the smallest, facet 2 a + 1 that with the largest coordinate a (0 = x, 1 = y, 2 = z). On each, `u`
/// and `v` run from 0 to 1 along two of the axes in positive direction, in the order that makes their cross product the
/// outward normal: (y, z) on +x, (z, x) on +y, (x, y) on +z, swapped on the opposite sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    bounds: Bounds3,
}

impl Cuboid {
    /// The box between two opposite corners, metres, in any order.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], or [`SurfaceError::NotPositive`] if an edge has no length.
    pub fn try_new(a: DVec3, b: DVec3) -> Result<Self, SurfaceError> {
        for x in a.to_array().into_iter().chain(b.to_array()) {
            finite("corner coordinate", x)?;
        }
        let bounds = Bounds3::new(a, b);
        for edge in bounds.diagonal().to_array() {
            crate::error::positive("edge length", edge)?;
        }
        Ok(Self { bounds })
    }

    /// Area of the six sides, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.bounds.surface_area()
    }

    /// The interval of the ray's line inside the box.
    ///
    /// Rounding does not change the sign of the differences or quotients: a ray that starts outside one of the planes, however
    /// close, and moves away from it, misses the box.
    fn interval(&self, ray: &Ray) -> Option<ConvexInterval> {
        if !ray.origin.is_finite() || ray.direction.is_nan() || ray.direction == DVec3::ZERO {
            return None;
        }
        let mut interval = ConvexInterval::LINE;
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let (min, max) = (self.bounds.min.to_array(), self.bounds.max.to_array());
        for (axis, facet) in [(0, 0), (1, 2), (2, 4)] {
            if d[axis] == 0.0 {
                if o[axis] < min[axis] || o[axis] > max[axis] {
                    return None;
                }
                continue;
            }
            let (low, high) = ((min[axis] - o[axis]) / d[axis], (max[axis] - o[axis]) / d[axis]);
            let (low, high) = (FacetCrossing { t: low, facet }, FacetCrossing { t: high, facet: facet + 1 });
            let (near, far) = if d[axis] > 0.0 { (low, high) } else { (high, low) };
            interval.clip_start(near);
            interval.clip_end(far);
        }
        (!interval.is_empty()).then_some(interval)
    }

    fn hit(&self, ray: &Ray, FacetCrossing { t, facet }: FacetCrossing) -> Hit {
        let relative =
            ((ray.at(t) - self.bounds.min) / self.bounds.diagonal()).clamp(DVec3::ZERO, DVec3::ONE);
        let (a, b) = tangent_axes(facet);
        Hit::new(t, relative[a], relative[b], facet)
    }

    pub(crate) fn point_at(&self, facet: u32, u: f64, v: f64) -> SurfacePoint {
        let (axis, upper) = ((facet as usize / 2) % 3, facet % 2 == 1);
        let (a, b) = tangent_axes(facet);
        let size = self.bounds.diagonal();
        let mut position = if upper { self.bounds.max } else { self.bounds.min };
        // Interpolation from both ends overshoots neither.
        position[a] = (self.bounds.min[a] * (1.0 - u) + self.bounds.max[a] * u)
            .clamp(self.bounds.min[a], self.bounds.max[a]);
        position[b] = (self.bounds.min[b] * (1.0 - v) + self.bounds.max[b] * v)
            .clamp(self.bounds.min[b], self.bounds.max[b]);
        let normal = DVec3::AXES[axis] * if upper { 1.0 } else { -1.0 };
        SurfacePoint {
            position,
            // The coordinate along the normal is exact; one unit covers the offset to the edge of the error box.
            error: self.bounds.min.abs().max(self.bounds.max.abs()) * gamma(3),
            normal,
            shading_normal: normal,
            uv: DVec2::new(u, v),
            dpdu: DVec3::AXES[a] * size[a],
            dpdv: DVec3::AXES[b] * size[b],
        }
    }

    /// Area of one side at right angles to each axis, m^2.
    fn side_areas(&self) -> DVec3 {
        let d = self.bounds.diagonal();
        DVec3::new(d.y * d.z, d.z * d.x, d.x * d.y)
    }
}

/// The ray parameters, of any sign, at which the line of the ray enters and leaves the box; `None` if it misses the box.
pub(crate) fn clip_to_box(bounds: &Bounds3, ray: &Ray) -> Option<(f64, f64)> {
    Cuboid { bounds: *bounds }.interval(ray).map(|interval| (interval.enter.t, interval.leave.t))
}

/// The axes of u and v on a facet.
fn tangent_axes(facet: u32) -> (usize, usize) {
    let axis = (facet as usize / 2) % 3;
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    if facet % 2 == 1 { (a, b) } else { (b, a) }
}

impl RaySurface for Cuboid {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        Some(self.hit(ray, self.interval(ray)?.first(t_max)?))
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.interval(ray).is_some_and(|interval| interval.first(t_max).is_some())
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let crossings = self.interval(ray).into_iter().flat_map(|interval| interval.all(t_max));
        hits.extend(crossings.map(|crossing| self.hit(ray, crossing)));
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.face, hit.u, hit.v)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let areas = self.side_areas();
        let mut rest = xi.x * 2.0 * areas.element_sum();
        let mut chosen = (5, 0.0);
        for facet in 0..6_u32 {
            let area = areas[facet as usize / 2];
            chosen = (facet, (rest / area).min(1.0_f64.next_down()));
            if rest < area {
                break;
            }
            rest -= area;
        }
        let (facet, u) = chosen;
        Some(SurfaceSample {
            hit: Hit::new(0.0, u, xi.y, facet),
            point: self.point_at(facet, u, xi.y),
            pdf: AreaPdf(1.0 / self.area()),
        })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(AreaPdf(1.0 / self.area()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::rounding::offset_origin;

    fn brick() -> Cuboid {
        Cuboid::try_new(DVec3::new(1.0, -2.0, 0.0), DVec3::new(2.0, 1.0, 5.0)).unwrap()
    }

    #[test]
    fn ray_through_two_sides_meets_both() {
        let ray = Ray::new(DVec3::new(-1.0, -0.5, 1.0), DVec3::new(2.0, 0.0, 0.0));
        let mut hits = Vec::new();
        brick().all_hits(&ray, f64::INFINITY, &mut hits);
        // -x at t = 1 with (u, v) along (z, y), +x at t = 1.5 with (y, z).
        assert_eq!(hits[0], Hit::new(1.0, 0.2, 0.5, 0));
        assert_eq!(hits[1], Hit::new(1.5, 0.5, 0.2, 1));
        assert_eq!(brick().intersect(&ray, f64::INFINITY), Some(hits[0]));
        assert_eq!(brick().intersect(&ray, 1.0), None);
        let inside = Ray::new(ray.at(1.25), ray.direction);
        assert_eq!(brick().intersect(&inside, f64::INFINITY).unwrap().face, 1);
    }

    #[test]
    fn parameters_span_each_side_with_the_normal_outward() {
        for facet in 0..6 {
            let p = brick().point_at(facet, 0.25, 0.75);
            assert_eq!(p.dpdu.cross(p.dpdv).normalize(), p.normal);
            let h = 0.125;
            assert_eq!(brick().point_at(facet, 0.25 + h, 0.75).position - p.position, p.dpdu * h);
            assert_eq!(brick().point_at(facet, 0.25, 0.75 + h).position - p.position, p.dpdv * h);
            let outward = (p.position - brick().bounds().center()).dot(p.normal);
            assert!(outward > 0.0);
        }
    }

    #[test]
    fn ray_in_the_plane_of_a_side_meets_the_neighbours() {
        let ray = Ray::new(DVec3::new(1.0, -4.0, 1.0), DVec3::Y);
        let hit = brick().intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.face), (2.0, 2));
        let beside = Ray::new(DVec3::new(1.0_f64.next_down(), -4.0, 1.0), DVec3::Y);
        assert_eq!(brick().intersect(&beside, f64::INFINITY), None);
    }

    #[test]
    fn leaving_ray_misses_even_along_the_side() {
        let p = brick().point_at(1, 0.3, 0.6);
        for direction in [DVec3::X, DVec3::new(1e-300, 1.0, 0.0), DVec3::new(1e-9, -1.0, 1.0)] {
            let origin = offset_origin(p.position, p.error, p.normal, direction);
            assert_eq!(brick().intersect(&Ray::new(origin, direction), f64::INFINITY), None);
            let back = offset_origin(p.position, p.error, p.normal, -DVec3::X);
            assert_eq!(brick().intersect(&Ray::new(back, -DVec3::X), f64::INFINITY).unwrap().face, 0);
        }
    }

    #[test]
    fn flat_and_infinite_boxes_are_refused() {
        let flat = Cuboid::try_new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(flat, Err(SurfaceError::NotPositive { parameter: "edge length", value: 0.0 }));
        assert!(matches!(Cuboid::try_new(DVec3::ZERO, DVec3::INFINITY), Err(SurfaceError::NotFinite { .. })));
    }
}
