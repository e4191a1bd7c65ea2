//! A single triangle, and the watertight test that meshes use too.

use glanz_math::polynomial::quadratic::difference_of_products;
use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::error::{SurfaceError, finite};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;

/// Share of their products below which the edge functions have lost too many digits for the weights: 2^-16 leaves 37,
/// which is 1e-11 of the triangle.
pub(crate) const GRAZING: f64 = 1.0 / 65_536.0;

/// A ray prepared for [`ShearedRay::intersect`]: the shear that maps its direction to the axis of its largest component.
///
/// # Source
/// @woop2013 section 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearedRay {
    /// Origin of the ray.
    pub origin: DVec3,
    /// Numbers of the axes (0 = x, 1 = y, 2 = z) that become x, y and z after the shear; the direction is longest
    /// along the last one.
    pub axes: [usize; 3],
    /// `d_x / d_z`, `d_y / d_z` and `1 / d_z` of the direction, in the order of `axes`.
    pub shear: DVec3,
}

impl ShearedRay {
    /// Prepares the ray `origin + t direction`.
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let kz = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(kz + 1) % 3, (kz + 2) % 3, kz];
        let d = direction.to_array();
        let scale = 1.0 / d[kz];
        Self { origin, axes, shear: DVec3::new(d[axes[0]] / d[kz], d[axes[1]] / d[kz], scale) }
    }

    /// `point` in the sheared frame: the ray is the half-line x = y = 0, z > 0 there, and z is its parameter.
    ///
    /// The result depends on the ray and on this point alone: triangles that share a vertex compute with the same numbers.
    #[must_use]
    pub fn vertex(&self, point: DVec3) -> DVec3 {
        let p = (point - self.origin).to_array();
        let z = p[self.axes[2]];
        DVec3::new(p[self.axes[0]] - self.shear.x * z, p[self.axes[1]] - self.shear.y * z, self.shear.z * z)
    }

    /// Intersection of the ray with the triangle for `0 < t < t_max`: `(t, b1, b2)`, where `b1` and `b2` are the barycentric
    /// weights of `p1` and `p2`. Edges and vertices belong to the triangle, both sides are hit.
    ///
    /// The test is made in the plane, with vertices that were rounded once: an edge function there has the right sign
    /// or is exactly zero, since rounding is monotone, and a zero is decided by [`difference_of_products`]. Triangles
    /// that share an edge or a fan of them around a vertex therefore tile without a gap: a ray through what they share
    /// hits one of them at least. Triangles seen edge-on and those with two equal vertices are never hit. Nearly
    /// collinear ones may be, to within rounding: drop those without a [`unit_normal`].
    ///
    /// Where the triangle is seen nearly edge-on, the edge functions are computed to the last digit, so that the weights
    /// are those of a point next to the ray at any angle.
    ///
    /// # Source
    /// @woop2013; departure: the fallback is an exact sign instead of a wider type.
    #[must_use]
    pub fn intersect(&self, p0: DVec3, p1: DVec3, p2: DVec3, t_max: f64) -> Option<(f64, f64, f64)> {
        let (a, b, c) = (self.vertex(p0), self.vertex(p1), self.vertex(p2));
        let mut u = c.x * b.y - c.y * b.x;
        let mut v = a.x * c.y - a.y * c.x;
        let mut w = b.x * a.y - b.y * a.x;
        let largest = (c.x * b.y).abs() + (a.x * c.y).abs() + (b.x * a.y).abs();
        if u == 0.0 || v == 0.0 || w == 0.0 || (u + v + w).abs() <= GRAZING * largest {
            u = difference_of_products(c.x, b.y, c.y, b.x);
            v = difference_of_products(a.x, c.y, a.y, c.x);
            w = difference_of_products(b.x, a.y, b.y, a.x);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let t = (u * a.z + v * b.z + w * c.z) / determinant;
        // Written so that NaN is a miss.
        (t > 0.0 && t < t_max).then(|| (t, v / determinant, w / determinant))
    }
}

/// Intersection of the ray `origin + t direction` with the triangle: [`ShearedRay::intersect`] for a single test.
#[must_use]
pub fn intersect_watertight(
    p0: DVec3,
    p1: DVec3,
    p2: DVec3,
    origin: DVec3,
    direction: DVec3,
    t_max: f64,
) -> Option<(f64, f64, f64)> {
    ShearedRay::new(origin, direction).intersect(p0, p1, p2, t_max)
}

/// The cross product, every component to 1.5 units in the last place.
fn accurate_cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}

/// `(p1 - p0) x (p2 - p0)`, twice the area along the normal, or `None` if rounding leaves no digit of it.
fn area_vector(p0: DVec3, p1: DVec3, p2: DVec3) -> Option<DVec3> {
    let (e1, e2) = (p1 - p0, p2 - p0);
    let n = accurate_cross(e1, e2);
    // The edges carry a relative error of u each, the products 1.5 u: a shorter n has no sure digit.
    (n.length() > gamma(8) * e1.length() * e2.length() && n.is_finite()).then_some(n)
}

/// The unit normal `(p1 - p0) x (p2 - p0)`, or `None` if the triangle has no area beyond the rounding of its edges.
#[must_use]
pub fn unit_normal(p0: DVec3, p1: DVec3, p2: DVec3) -> Option<DVec3> {
    area_vector(p0, p1, p2).map(DVec3::normalize)
}

/// [`unit_normal`] and twice the area.
#[inline]
pub(crate) fn normal_and_area(p0: DVec3, p1: DVec3, p2: DVec3) -> Option<(DVec3, f64)> {
    let (e1, e2) = (p1 - p0, p2 - p0);
    let plain = e1.cross(e2);
    // At angles above 1/32 rad between the edges, plain products lose five bits at most; they are cheaper, and every hit needs them.
    let is_open = 1024.0 * plain.length_squared() > e1.length_squared() * e2.length_squared();
    let n = if is_open { plain } else { area_vector(p0, p1, p2)? };
    let length = n.length();
    let inverse = 1.0 / length;
    (inverse > 0.0 && inverse.is_finite()).then(|| (n * inverse, length))
}

/// The absolute error per axis ([`SurfacePoint::error`]) of a point of the triangle that was computed as
/// `p0 + b1 (p1 - p0) + b2 (p2 - p0)`, for rays tested by [`ShearedRay::intersect`].
///
/// Let L be the longest edge and A the area. A ray starts on the triangle, so L bounds the distance to every vertex.
/// A sheared coordinate is off by at most 6 u L: it moves the plane by as much where the ray meets it. An edge
/// function of at most 3 L^2 is off by 6 u L^2 (two products, one difference of twice that size); the three of them,
/// times z <= L, and the sum of three products of at most 3 L^3 add up to less than 54 u L^3; divided by 2 A that is a
/// distance along the normal. The position itself has four roundings per axis.
#[must_use]
pub fn position_error(p0: DVec3, p1: DVec3, p2: DVec3) -> DVec3 {
    position_error_of(p0, p1, p2, (p1 - p0).cross(p2 - p0).length())
}

/// [`position_error`] where twice the area is known.
#[inline]
pub(crate) fn position_error_of(p0: DVec3, p1: DVec3, p2: DVec3, twice_area: f64) -> DVec3 {
    let (e1, e2, e3) = (p1 - p0, p2 - p0, p2 - p1);
    let longest2 = e1.length_squared().max(e2.length_squared()).max(e3.length_squared());
    let longest = longest2.sqrt();
    let plane = gamma(6) * longest + gamma(54) * longest * (longest2 / twice_area);
    // The bound of a nearly collinear triangle is limited to its own size.
    let plane = if plane < longest { plane } else { longest };
    // |p0| plus one edge bounds every coordinate of a vertex.
    DVec3::splat(plane) + (p0.abs() + 2.0 * (e1.abs() + e2.abs())) * gamma(4)
}

/// Maps two numbers uniform in [0, 1) to barycentric weights (of the second and the third vertex) that are uniform over the
/// area of any triangle.
///
/// # Source
/// @heitz2019.
#[must_use]
pub fn sample_barycentric(xi: DVec2) -> DVec2 {
    // Half of the smaller number goes over to the other one; without a branch, which could not be predicted.
    xi - DVec2::splat(0.5 * xi.min_element())
}

/// A flat triangle.
///
/// `u` and `v` are the barycentric weights of the second and the third vertex; the normal is that of
/// `(p1 - p0) x (p2 - p0)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    vertices: [DVec3; 3],
    normal: DVec3,
    area: f64,
    error: DVec3,
}

impl Triangle {
    /// A triangle of three vertices, metres.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], or [`SurfaceError::Degenerate`] if the vertices are collinear within the rounding of
    /// the edges.
    pub fn try_new(p0: DVec3, p1: DVec3, p2: DVec3) -> Result<Self, SurfaceError> {
        for p in [p0, p1, p2] {
            for x in p.to_array() {
                finite("vertex coordinate", x)?;
            }
        }
        let n = area_vector(p0, p1, p2).ok_or(SurfaceError::Degenerate {
            reason: "the vertices lie on a line, area",
            value: 0.5 * (p1 - p0).cross(p2 - p0).length(),
        })?;
        Ok(Self {
            vertices: [p0, p1, p2],
            normal: n.normalize(),
            area: 0.5 * n.length(),
            error: position_error(p0, p1, p2),
        })
    }

    /// The vertices, metres.
    #[must_use]
    pub fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    pub(crate) fn point_at(&self, u: f64, v: f64) -> SurfacePoint {
        let [p0, p1, p2] = self.vertices;
        let (dpdu, dpdv) = (p1 - p0, p2 - p0);
        SurfacePoint {
            // Rounding must not move the point out of the box of the vertices.
            position: (p0 + u * dpdu + v * dpdv).clamp(p0.min(p1).min(p2), p0.max(p1).max(p2)),
            error: self.error,
            normal: self.normal,
            shading_normal: self.normal,
            uv: DVec2::new(u, v),
            dpdu,
            dpdv,
        }
    }
}

impl RaySurface for Triangle {
    fn bounds(&self) -> Bounds3 {
        Bounds3::from_points(self.vertices)
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let [p0, p1, p2] = self.vertices;
        let (t, u, v) = intersect_watertight(p0, p1, p2, ray.origin, ray.direction, t_max)?;
        Some(Hit::new(t, u, v, 0))
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        hits.extend(self.intersect(ray, t_max));
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.u, hit.v)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let b = sample_barycentric(xi);
        Some(SurfaceSample {
            hit: Hit::new(0.0, b.x, b.y, 0),
            point: self.point_at(b.x, b.y),
            pdf: AreaPdf(1.0 / self.area),
        })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(AreaPdf(1.0 / self.area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::rounding::offset_origin;

    /// Weyl sequence: enough variety for rays, no dependency.
    struct Sequence(f64);

    impl Sequence {
        fn next(&mut self) -> f64 {
            self.0 = (self.0 + 0.618_033_988_749_894_9).fract();
            let x = (self.0 * 9_301.0 + 0.492_97).sin() * 43_758.545_3;
            x - x.floor()
        }

        fn vec3(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
        }
    }

    #[test]
    fn ray_through_a_known_point_returns_its_weights() {
        let triangle =
            Triangle::try_new(DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)).unwrap();
        let ray = Ray::new(DVec3::new(0.5, 1.0, -3.0), DVec3::new(0.0, 0.0, 1.5));
        let hit = triangle.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (2.0, 0.25, 0.25));
        assert_eq!(triangle.area(), 4.0);
        assert_eq!(triangle.point(&ray, &hit).normal, DVec3::Z);
        assert!(triangle.intersect(&ray, 2.0).is_none());
        let behind = Ray::new(ray.origin, -ray.direction);
        assert!(triangle.intersect(&behind, f64::INFINITY).is_none());
    }

    #[test]
    fn closed_fan_has_no_gap_at_its_edges_and_its_hub() {
        // A fan of seven around a hub: aim at the hub, at points of the spokes and within an ulp or two of them.
        let mut random = Sequence(0.2);
        let (mut rays, mut missed) = (0, 0);
        for _ in 0..20_000 {
            let hub = random.vec3() * 10.0;
            let tilt = DVec3::new(random.next(), random.next(), 0.0) - 0.5;
            let rim: Vec<DVec3> = (0..7)
                .map(|i| {
                    let angle = std::f64::consts::TAU * (f64::from(i) + 0.5 * random.next()) / 7.0;
                    let (x, y) = (DVec2::from_angle(angle) * (0.3 + random.next())).into();
                    hub + DVec3::new(x, y, x * tilt.x + y * tilt.y)
                })
                .collect();
            let spoke = hub.lerp(rim[(random.next() * 7.0) as usize % 7], 0.5 * random.next());
            for target in [hub, spoke, hub + random.vec3() * 1e-15, spoke + random.vec3() * 1e-15] {
                let origin = hub + DVec3::new(4.0, 4.0, 3.0) * random.vec3() + DVec3::new(0.0, 0.0, 9.0);
                let ray = ShearedRay::new(origin, target - origin);
                let hit =
                    (0..7).any(|i| ray.intersect(hub, rim[i], rim[(i + 1) % 7], f64::INFINITY).is_some());
                rays += 1;
                missed += i32::from(!hit);
            }
        }
        assert_eq!(missed, 0, "of {rays} rays");
    }

    #[test]
    fn swapping_the_ends_of_an_edge_flips_its_sign_exactly() {
        // Two triangles on either side of an edge and a ray anywhere near it: never neither, and both only if the ray
        // meets the edge itself, where the weight of the opposite vertex vanishes.
        let mut random = Sequence(0.7);
        for _ in 0..50_000 {
            let (p, q) = (random.vec3(), random.vec3());
            let middle = p.lerp(q, 0.25 + 0.5 * random.next());
            // Perpendicular to the edge, so that the two triangles do not fold over each other.
            let side = random.vec3().reject_from(q - p);
            if side.length() < 0.3 || p.distance(q) < 0.3 {
                continue;
            }
            let (left, right) = (middle + side, middle - side + random.vec3() * 0.01);
            let origin = middle + 3.0 * side.cross(q - p).normalize() + random.vec3() * 0.1;
            let target = middle + random.vec3() * 1e-16 * (random.next() * 4.0).floor();
            let ray = ShearedRay::new(origin, target - origin);
            let a = ray.intersect(p, q, left, f64::INFINITY);
            let b = ray.intersect(p, q, right, f64::INFINITY);
            assert!(a.is_some() || b.is_some());
            if let (Some(a), Some(b)) = (a, b) {
                assert_eq!((a.2, b.2), (0.0, 0.0));
            }
        }
    }

    #[test]
    fn offset_origin_does_not_meet_its_own_triangle() {
        let mut random = Sequence(0.4);
        for i in 0..40_000 {
            let size = 10.0_f64.powi(i % 7 - 3);
            let center = random.vec3() * 100.0;
            let (p0, p1) = (center + random.vec3() * size, center + random.vec3() * size);
            // From fat triangles to slivers of one in a million.
            let p2 = p0.lerp(p1, random.next()) + random.vec3() * size * 10.0_f64.powi(-(i % 6));
            let Ok(triangle) = Triangle::try_new(p0, p1, p2) else { continue };
            let sample = triangle.sample(DVec2::new(random.next(), random.next())).unwrap();
            let point = sample.point;
            // Half of the directions graze.
            let flat = if i % 2 == 0 { 1.0 } else { 1e-9 };
            let along = (point.dpdu * (random.next() - 0.5) + point.dpdv * (random.next() - 0.5)).normalize();
            for side in [1.0, -1.0] {
                let direction = along + point.normal * (side * flat * random.next());
                if direction.dot(point.normal) * side <= 0.0 {
                    continue;
                }
                let origin = offset_origin(point.position, point.error, point.normal, direction);
                assert_eq!(triangle.intersect(&Ray::new(origin, direction), f64::INFINITY), None, "case {i}");
            }
        }
    }

    #[test]
    fn degenerate_triangles_are_refused_and_never_hit() {
        let (p, q) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.7, -0.4, 1.3));
        for (a, b, c) in [(p, p, q), (p, q, p), (q, p, p), (p, q, p.lerp(q, 0.3)), (p, p, p)] {
            assert!(matches!(Triangle::try_new(a, b, c), Err(SurfaceError::Degenerate { .. })));
        }
        let origin = DVec3::new(3.0, 1.0, -2.0);
        for (a, b, c) in [(p, p, q), (p, q, p), (q, p, p), (p, p, p)] {
            for target in [p, q, p.lerp(q, 0.5)] {
                assert_eq!(intersect_watertight(a, b, c, origin, target - origin, f64::INFINITY), None);
            }
        }
        assert!(matches!(
            Triangle::try_new(p, q, DVec3::new(f64::NAN, 0.0, 0.0)),
            Err(SurfaceError::NotFinite { .. })
        ));
    }

    #[test]
    fn samples_fill_the_triangle_evenly() {
        // The centroid of uniform points is that of the triangle: weights of a third each. 64 x 64 strata leave an
        // error below one stratum.
        let mut mean = DVec2::ZERO;
        for i in 0..64 {
            for j in 0..64 {
                let b = sample_barycentric((DVec2::new(f64::from(i), f64::from(j)) + 0.5) / 64.0);
                assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
                mean += b / 4096.0;
            }
        }
        assert!((mean - DVec2::splat(1.0 / 3.0)).length() < 1.0 / 64.0);
    }
}
