//! Bilinear patches.

use glanz_math::polynomial::quadratic;
use glanz_math::rounding::{UNIT_ROUNDOFF, gamma};
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::error::{SurfaceError, finite};
use crate::hit::{AreaSample, Hit, SurfaceLocation, SurfacePoint, SurfaceSample};
use crate::ray_line::RayLine;
use crate::surface::RaySurface;
use crate::triangle::ShearedRay;

/// The cube root of the roundoff: a patch that is narrower, relative to its size, counts as that wide (see `BilinearPatch::error`).
const LEAST_WIDTH: f64 = 4.806_217_383_937_352e-6;

/// Roundings of the coordinates by which the fourth corner of a parallelogram may be off its plane and position.
const FLAT_ROUNDINGS: u32 = 4;

/// Area over squared size from which on a parallelogram is intersected as a plane.
const LEAST_PARALLELOGRAM_WIDTH: f64 = 1e-3;

/// Least cosine between a ray and the normal of a parallelogram that is intersected as a plane.
const LEAST_COSINE: f64 = 1.0 / 64.0;

/// The surface `p = (1 - u)(1 - v) p00 + u (1 - v) p10 + (1 - u) v p01 + u v p11`, u and v from 0 to 1, with the normal along
/// `dpdu x dpdv`.
///
/// It may be flat or twisted; corners may coincide as long as the area is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BilinearPatch {
    /// p00, p10, p01, p11.
    corners: [DVec3; 4],
    bounds: Bounds3,
    center: DVec3,
    /// Longest distance between corners, metres.
    size: f64,
    /// |dpdu x dpdv| at the corners, in their order.
    weights: [f64; 4],
    /// Its plane, if it is a parallelogram that is not narrow.
    plane: Option<ParallelogramPlane>,
}

/// The plane of a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ParallelogramPlane {
    /// Unit normal along `dpdu x dpdv`.
    normal: DVec3,
    /// Area, m^2.
    area: f64,
}

/// At most two roots (t, u, v).
type BilinearRoots = [Option<(f64, f64, f64)>; 2];

/// Result of intersecting a ray with the plane of a parallelogram.
enum PlaneRoot {
    /// The line of the ray misses the parallelogram.
    Miss,
    /// The line meets it at (t, u, v), inside of its border.
    Inside(f64, f64, f64),
    /// The border is too close, the ray grazing or its origin distant.
    Unclear,
}

impl BilinearPatch {
    /// The patch with these corners, metres.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], and [`SurfaceError::Degenerate`] if all corners lie on a line up to rounding.
    pub fn try_new(p00: DVec3, p10: DVec3, p01: DVec3, p11: DVec3) -> Result<Self, SurfaceError> {
        let corners = [p00, p10, p01, p11];
        for x in corners.iter().flat_map(DVec3::to_array) {
            finite("corner coordinate", x)?;
        }
        let bounds = Bounds3::from_points(corners);
        let size = corners.iter().flat_map(|p| corners.map(|q| p.distance(q))).fold(0.0, f64::max);
        let mut patch =
            Self { corners, bounds, center: bounds.center(), size, weights: [0.0; 4], plane: None };
        patch.weights =
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| patch.area_vector(u, v).length());
        let largest = patch.weights.iter().fold(0.0, |a: f64, w| a.max(*w));
        // The area vector is an affine function of (u, v): if it vanishes at the corners, it vanishes everywhere. The edges
        // have one rounding each, their cross product two more.
        if largest <= gamma(8) * size * size || !largest.is_finite() {
            return Err(SurfaceError::Degenerate {
                reason: "the corners lie on a line, area",
                value: largest,
            });
        }
        patch.plane = patch.parallelogram_plane();
        Ok(patch)
    }

    /// The plane of a parallelogram, up to the roundings of a corner that was computed from the others, whose width is at least
    /// [`LEAST_PARALLELOGRAM_WIDTH`] of its size.
    fn parallelogram_plane(&self) -> Option<ParallelogramPlane> {
        let [p00, p10, p01, p11] = self.corners;
        let twist = (p11 - p01) - (p10 - p00);
        let n = (p10 - p00).cross(p01 - p00);
        let area = n.length();
        // A twist moves u and v by at most its length times the size over cosine and area: a quarter of the margin of `plane_root`.
        let least_effect = 0.5 * LEAST_COSINE * UNIT_ROUNDOFF.sqrt() * area / self.size;
        let is_flat =
            twist.abs().cmple(gamma(FLAT_ROUNDINGS) * self.reach()).all() && twist.length() <= least_effect;
        let is_wide = area >= LEAST_PARALLELOGRAM_WIDTH * self.size * self.size;
        (is_flat && is_wide).then(|| ParallelogramPlane { normal: n / area, area })
    }

    /// The largest absolute coordinate per axis.
    fn reach(&self) -> DVec3 {
        self.bounds.min.abs().max(self.bounds.max.abs())
    }

    /// p00, p10, p01, p11, metres.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 4] {
        self.corners
    }

    /// Whether it is a parallelogram up to roundings, and not narrow.
    #[must_use]
    pub fn is_parallelogram(&self) -> bool {
        self.plane.is_some()
    }

    fn tangents(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let [p00, p10, p01, p11] = self.corners;
        ((p10 - p00).lerp(p11 - p01, v), (p01 - p00).lerp(p11 - p10, u))
    }

    fn area_vector(&self, u: f64, v: f64) -> DVec3 {
        let (du, dv) = self.tangents(u, v);
        du.cross(dv)
    }

    /// The nearest parameters towards the middle where the surface has a normal, and the area vector there: (u, v) itself except
    /// at collapsed corners.
    fn regular(&self, u: f64, v: f64) -> (f64, f64, DVec3) {
        let n = self.area_vector(u, v);
        if n.length() > gamma(8) * self.size * self.size {
            return (u, v, n);
        }
        // The area vector is affine in (u, v): after a step of the root of the roundoff, it has half of the digits.
        let step = UNIT_ROUNDOFF.sqrt();
        for (towards_u, towards_v) in [(0.5, 0.5), (0.25, 0.75)] {
            let (u, v) = (u + (towards_u - u) * step, v + (towards_v - v) * step);
            let n = self.area_vector(u, v);
            if n.length() > 0.0 {
                return (u, v, n);
            }
        }
        (u, v, DVec3::Z)
    }

    /// Intersection of the ray with the plane of a parallelogram, if the ray meets it clearly inside or misses it clearly outside of its
    /// border; all that is close to the border, grazing or distant is left to [`BilinearPatch::sheared_roots`].
    ///
    /// With `q` from p00 to the origin, t, u and v are ratios of the triple products of q, the direction d and the sides. The rounding
    /// error of each is below gamma(12) times the product of the three lengths: with |q| up to 4 sizes L, and the relative error of the
    /// determinant as a fifth, that of u and v is at most gamma(12) 5 L |d| L / (|d| cos area) <= 60 u 64 / 1e-3 = 4.3e-10, less than
    /// half of the root of the roundoff, up to which [`near_unit`] accepts roots beyond the border. A corner off the plane moves them
    /// by less than another half: the answer is clear at twice of that root. For a ray that starts on the patch, the
    /// distance from the plane has an error of at most gamma(12) L^3 / area, half of the bound of [`BilinearPatch::error`].
    ///
    /// # Source
    /// @moller1997.
    #[inline]
    fn plane_root(&self, plane: &ParallelogramPlane, ray: &Ray) -> PlaneRoot {
        let [p00, p10, p01, _] = self.corners;
        let (du, dv, d) = (p10 - p00, p01 - p00, ray.direction);
        let q = ray.origin - p00;
        let pv = d.cross(dv);
        let determinant = du.dot(pv);
        let least = LEAST_COSINE * plane.area;
        let is_steep = determinant * determinant >= least * least * d.length_squared();
        if !(is_steep && q.length_squared() <= 16.0 * self.size * self.size) {
            return PlaneRoot::Unclear;
        }
        let scale = 1.0 / determinant;
        let qu = q.cross(du);
        let (u, v, t) = (q.dot(pv) * scale, d.dot(qu) * scale, dv.dot(qu) * scale);
        let margin = 2.0 * UNIT_ROUNDOFF.sqrt();
        let beyond = |x: f64| x < -margin || x > 1.0 + margin;
        let inside = |x: f64| x > margin && x < 1.0 - margin;
        if beyond(u) || beyond(v) {
            PlaneRoot::Miss
        } else if inside(u) && inside(v) {
            PlaneRoot::Inside(t, u, v)
        } else {
            PlaneRoot::Unclear
        }
    }

    /// Both roots in ascending order of t.
    ///
    /// A shear maps the ray to the z axis, which reduces the problem to the plane: the line of constant u contains the origin
    /// where the cross product of its ends, a quadratic in u, vanishes. Of the two families of lines, the one whose projection
    /// is longer is used. Roots within rounding of the border belong to it.
    ///
    /// # Source
    /// @reshetov2019; departure: the shear of @woop2013, so that patches with a common edge compute the same
    /// numbers there, and the choice of the family.
    fn sheared_roots(&self, ray: &Ray) -> BilinearRoots {
        // A distant origin costs digits; an origin near the surface must not be moved.
        let far = ray.origin.distance_squared(self.center) > 16.0 * self.size * self.size;
        let line = if far { RayLine::nearest_to(ray, self.center) } else { RayLine::new(ray, 0.0) };
        let shear = ShearedRay::new(line.origin, ray.direction);
        let [q00, q10, q01, q11] = self.corners.map(|p| shear.vertex(p));
        let projected = |a: DVec3, b: DVec3| (b - a).truncate().length_squared();
        let by_u = projected(q00, q01) + projected(q10, q11) >= projected(q00, q10) + projected(q01, q11);
        let mut roots = if by_u {
            solve([q00, q10, q01, q11])
        } else {
            solve([q00, q01, q10, q11]).map(|root| root.map(|(t, v, u)| (t, u, v)))
        };
        for (t, _, _) in roots.iter_mut().flatten() {
            *t += line.t(0.0);
        }
        if let [Some(a), Some(b)] = roots {
            if a.0 == b.0 {
                roots[1] = None;
            } else if a.0 > b.0 {
                roots.swap(0, 1);
            }
        }
        roots
    }

    fn position_at(&self, u: f64, v: f64) -> DVec3 {
        let [p00, p10, p01, p11] = self.corners;
        let position = (p00 * (1.0 - u) + p10 * u) * (1.0 - v) + (p01 * (1.0 - u) + p11 * u) * v;
        // The patch lies in the bounding box of its corners.
        position.clamp(self.bounds.min, self.bounds.max)
    }

    pub(crate) fn point_at(&self, u: f64, v: f64) -> SurfacePoint {
        let (dpdu, dpdv) = self.tangents(u, v);
        let (normal, area) = self.normal_and_area(u, v);
        SurfacePoint {
            position: self.position_at(u, v),
            error: self.error(area),
            normal,
            shading_normal: normal,
            uv: DVec2::new(u, v),
            dpdu,
            dpdv,
        }
    }

    /// The unit normal and |dpdu x dpdv|.
    fn normal_and_area(&self, u: f64, v: f64) -> (DVec3, f64) {
        match self.plane {
            Some(plane) => (plane.normal, plane.area),
            None => {
                let (_, _, n) = self.regular(u, v);
                (n.normalize(), n.length())
            }
        }
    }

    /// The absolute error per axis where |dpdu x dpdv| is `area`.
    ///
    /// The next ray starts on the patch, so that its size L bounds all coordinates. After the shear their error is 6 u L. The
    /// error of the quadratic, three sums of products below 3 L^2, is less than 24 u L^2; divided by the length of a line of
    /// the family with the longer projection, it is the distance from the ray at which a point counts as a root. For a ray along
    /// the surface, the lines are at least as long as the patch is wide, `area / L`. A patch narrower than the cube root of the
    /// roundoff counts as that wide. The position has six roundings, and a parallelogram is off its plane by up to [`FLAT_ROUNDINGS`].
    fn error(&self, area: f64) -> DVec3 {
        let width = (area / (self.size * self.size)).max(LEAST_WIDTH);
        let reach = self.reach() * gamma(6 + FLAT_ROUNDINGS);
        DVec3::splat(gamma(6) * self.size + gamma(24) * self.size / width) + reach
    }

    /// Density of [`RaySurface::sample`], per m^2, where [`BilinearPatch::regular`] gives `(u, v, n)`.
    fn pdf(&self, (u, v, n): (f64, f64, DVec3)) -> AreaPdf {
        let [w00, w10, w01, w11] = self.weights;
        let weight = (w00 * (1.0 - u) + w10 * u) * (1.0 - v) + (w01 * (1.0 - u) + w11 * u) * v;
        AreaPdf(4.0 * weight / ((w00 + w10 + w01 + w11) * n.length()))
    }
}

/// The roots (z, u, v) where the lines from `q00 + u (q10 - q00)` to `q01 + u (q11 - q01)` pass through x = y = 0.
fn solve([q00, q10, q01, q11]: [DVec3; 4]) -> BilinearRoots {
    let cross = |a: DVec3, b: DVec3| a.x * b.y - a.y * b.x;
    let (at_0, at_1) = (cross(q00, q01), cross(q10, q11));
    let mixed = cross(q00, q11) + cross(q10, q01);
    let (a, b) = (at_0 - mixed + at_1, mixed - 2.0 * at_0);
    let Some(candidates) = quadratic::roots(a, b, at_0) else { return [None; 2] };
    let size = [q00, q10, q01, q11].iter().fold(0.0_f64, |s, q| s.max(q.truncate().length_squared())).sqrt();
    let noise = gamma(24) * size * size;
    candidates.map(|root_u| {
        let slope = (2.0 * a * root_u + b).abs();
        let u = near_unit(root_u, if slope > 0.0 { noise / slope } else { 0.0 })?;
        let (low, high) = (q00.lerp(q10, u), q01.lerp(q11, u));
        let line = (high - low).truncate();
        let length2 = line.length_squared();
        let root_v = -low.truncate().dot(line) / length2;
        let v = near_unit(root_v, gamma(24) * size / length2.sqrt())?;
        let off = (low.truncate() + line * v).length();
        // A root that was moved to the border must be a root there, up to rounding.
        let moved = u != root_u || v != root_v;
        (!moved || off <= gamma(24) * size).then_some((low.z + (high.z - low.z) * v, u, v))
    })
}

/// `x` clamped to [0, 1], if it is within `error`, but at most the root of the roundoff, of that interval.
fn near_unit(x: f64, error: f64) -> Option<f64> {
    let error = error.min(UNIT_ROUNDOFF.sqrt());
    (x >= -error && x <= 1.0 + error).then(|| x.clamp(0.0, 1.0))
}

/// Samples [0, 1) with a density that is linear between `a` at 0 and `b` at 1.
///
/// # Source
/// @pharr2023 section 2.3.2.
pub(crate) fn sample_linear(xi: f64, a: f64, b: f64) -> f64 {
    // A constant density; the formula below would divide 0 by 0 for a = b = 0.
    if xi == 0.0 || a == b {
        return xi;
    }
    let x = xi * (a + b) / (a + (a * a * (1.0 - xi) + b * b * xi).sqrt());
    x.min(1.0_f64.next_down())
}

impl BilinearPatch {
    /// Random parameters. The density is bilinear between the area elements at the corners: uniform by area if the patch is a
    /// parallelogram, nearly so otherwise.
    fn sample_parameters(&self, xi: DVec2) -> (f64, f64) {
        let [w00, w10, w01, w11] = self.weights;
        let v = sample_linear(xi.y, w00 + w10, w01 + w11);
        (sample_linear(xi.x, w00 * (1.0 - v) + w01 * v, w10 * (1.0 - v) + w11 * v), v)
    }
}

impl RaySurface for BilinearPatch {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        if let Some(plane) = &self.plane {
            match self.plane_root(plane, ray) {
                PlaneRoot::Miss => return None,
                PlaneRoot::Inside(t, u, v) => {
                    return (t > 0.0 && t < t_max).then_some(Hit::new(t, u, v, 0));
                }
                PlaneRoot::Unclear => {}
            }
        }
        let first = self.sheared_roots(ray).into_iter().flatten().find(|(t, _, _)| *t > 0.0 && *t < t_max);
        first.map(|(t, u, v)| Hit::new(t, u, v, 0))
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        if self.plane.is_some() {
            hits.extend(self.intersect(ray, t_max));
            return;
        }
        let found = self.sheared_roots(ray).into_iter().flatten().filter(|(t, _, _)| *t > 0.0 && *t < t_max);
        hits.extend(found.map(|(t, u, v)| Hit::new(t, u, v, 0)));
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.u, hit.v)
    }

    fn location(&self, _ray: &Ray, hit: &Hit) -> SurfaceLocation {
        let Hit { u, v, .. } = *hit;
        let normal = self.plane.map_or_else(|| self.regular(u, v).2, |plane| plane.normal);
        SurfaceLocation { position: self.position_at(u, v), normal, uv: DVec2::new(u, v) }
    }

    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        let [p00, p10, p01, p11] = self.corners;
        let (u, v, n) = self.regular(hit.u, hit.v);
        let (du, dv) = self.tangents(u, v);
        let twist = (p11 - p01) - (p10 - p00);
        let (normal, length) = (point.normal, n.length());
        [du.cross(twist), twist.cross(dv)].map(|dn| (dn - normal * normal.dot(dn)) / length)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let (u, v) = self.sample_parameters(xi);
        Some(SurfaceSample {
            hit: Hit::new(0.0, u, v, 0),
            point: self.point_at(u, v),
            pdf: self.pdf(self.regular(u, v)),
        })
    }

    fn sample_area(&self, xi: DVec2) -> Option<AreaSample> {
        let (u, v) = self.sample_parameters(xi);
        let (normal, area) = self.normal_and_area(u, v);
        Some(AreaSample {
            position: self.position_at(u, v),
            error: self.error(area),
            normal,
            face: 0,
            pdf: self.pdf(self.regular(u, v)),
        })
    }

    fn area_pdf(&self, hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(self.pdf(self.regular(hit.u, hit.v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::rounding::offset_origin;

    /// z = x y over the square [-1, 1]^2.
    fn saddle() -> BilinearPatch {
        let p = |x: f64, y: f64| DVec3::new(x, y, x * y);
        BilinearPatch::try_new(p(-1.0, -1.0), p(1.0, -1.0), p(-1.0, 1.0), p(1.0, 1.0)).unwrap()
    }

    fn all(patch: &BilinearPatch, ray: &Ray) -> Vec<Hit> {
        let mut hits = Vec::new();
        patch.all_hits(ray, f64::INFINITY, &mut hits);
        hits
    }

    #[test]
    fn least_width_is_the_cube_root_of_the_roundoff() {
        assert_eq!(LEAST_WIDTH, UNIT_ROUNDOFF.cbrt());
    }

    #[test]
    fn ray_along_the_diagonal_of_a_saddle_meets_it_twice() {
        // On x = y = s, z = 1/4 the saddle is met at s = -1/2 and 1/2.
        let ray = Ray::new(DVec3::new(-2.0, -2.0, 0.25), DVec3::new(0.5, 0.5, 0.0));
        let hits = all(&saddle(), &ray);
        assert_eq!(hits.len(), 2);
        for (hit, (t, u)) in hits.iter().zip([(3.0, 0.25), (5.0, 0.75)]) {
            assert!((hit.t - t).abs() < 1e-14 && (hit.u - u).abs() < 1e-15 && (hit.v - u).abs() < 1e-15);
        }
        // Where the surface curves away from the line, it is touched once; above, it is not met.
        let touching = Ray::new(DVec3::new(-2.0, -2.0, 0.0), DVec3::new(0.5, 0.5, 0.0));
        assert_eq!(all(&saddle(), &touching).len(), 1);
        let above = Ray::new(DVec3::new(-2.0, 2.0, 0.25), DVec3::new(0.5, -0.5, 0.0));
        assert_eq!(all(&saddle(), &above), []);
    }

    #[test]
    fn parallelogram_and_flat_quadrilateral_are_met_once() {
        let origin = DVec3::new(0.3, 0.2, 7.0);
        for p11 in [DVec3::new(1.5, 1.0, 0.0), DVec3::new(3.0, 4.0, 0.0)] {
            let patch =
                BilinearPatch::try_new(DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1.0, 0.0), p11).unwrap();
            for (u, v) in [(0.1, 0.2), (0.9, 0.9), (0.5, 0.0), (1.0, 0.3), (0.0, 0.0), (1.0, 1.0)] {
                let target = patch.point_at(u, v).position;
                let hits = all(&patch, &Ray::new(origin, target - origin));
                assert_eq!(hits.len(), 1, "{u} {v}");
                let hit = hits[0];
                assert!(
                    (hit.t - 1.0).abs() < 1e-14 && (hit.u - u).abs() < 1e-14 && (hit.v - v).abs() < 1e-14
                );
            }
        }
    }

    #[test]
    fn planes_of_parallelograms_answer_as_the_sheared_quadratic() {
        let patches = [
            [DVec3::new(0.0, 3.0, -2.0), DVec3::new(10.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 4.0)],
            [DVec3::new(-0.3, 0.1, 7.0), DVec3::new(0.1, 0.2, 0.3), DVec3::new(-0.5, 0.1, 0.4)],
        ];
        let (mut clear, mut hits) = (0, 0);
        for [corner, du, dv] in patches {
            let patch = BilinearPatch::try_new(corner, corner + du, corner + dv, corner + du + dv).unwrap();
            let plane = patch.plane.unwrap();
            for i in 0..20_000 {
                let i = f64::from(i);
                let spread = |k: f64| (i * k).fract();
                let (u, v) = (1.6 * spread(0.618_033_988_7) - 0.3, 1.6 * spread(0.754_877_666) - 0.3);
                let target = corner + u * du + v * dv;
                let origin =
                    target + DVec3::new((0.7 * i).sin(), (1.1 * i).cos(), (1.7 * i).sin()) * patch.size;
                // The target is ahead of half of the origins.
                let ray = Ray::new(origin, (target - origin) * if spread(0.569) < 0.5 { 1.0 } else { -0.3 });
                let expected: Vec<_> = patch.sheared_roots(&ray).into_iter().flatten().collect();
                let found = match patch.plane_root(&plane, &ray) {
                    PlaneRoot::Unclear => continue,
                    PlaneRoot::Miss => None,
                    PlaneRoot::Inside(t, u, v) => Some((t, u, v)),
                };
                clear += 1;
                assert_eq!(found.iter().len(), expected.len(), "{ray:?}");
                for ((t, u, v), (et, eu, ev)) in found.into_iter().zip(expected) {
                    assert!((t - et).abs() < 1e-12 * et.abs().max(1.0) && (u - eu).abs() < 1e-11, "{t} {et}");
                    assert!((v - ev).abs() < 1e-11 && (t > 0.0) == (et > 0.0));
                    hits += 1;
                }
            }
        }
        assert!(clear > 30_000 && hits > 10_000, "{clear} {hits}");
        let narrow =
            BilinearPatch::try_new(DVec3::ZERO, DVec3::X, DVec3::Y * 1e-4, DVec3::new(1.0, 1e-4, 0.0));
        assert_eq!((narrow.unwrap().plane, saddle().plane), (None, None));
        // Three kilometres up, two units in the last place twist a millimetre strip by more than rays at a small angle allow.
        let strip = |twist: f64| {
            let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, 3000.0 + z);
            BilinearPatch::try_new(
                p(0.0, 0.0, 0.0),
                p(1.1e-3, 0.0, 0.0),
                p(0.0, 1.0, 0.0),
                p(1.1e-3, 1.0, twist),
            )
        };
        let unit = 3000.0_f64.next_up() - 3000.0;
        assert!(strip(2.0 * unit).unwrap().plane.is_none() && strip(0.0).unwrap().plane.is_some());
    }

    #[test]
    fn patch_collapsed_to_a_triangle_is_that_triangle() {
        let (a, b, c) = (DVec3::ZERO, DVec3::new(2.0, 0.0, 1.0), DVec3::new(0.0, 3.0, -1.0));
        let patch = BilinearPatch::try_new(a, a, b, c).unwrap();
        let n = (c - a).cross(b - a).normalize();
        for (u, v) in [(0.2, 0.6), (0.9, 0.1), (0.0, 1.0)] {
            let p = patch.point_at(u, v);
            assert!((p.normal - n).length() < 1e-14);
            let ray = Ray::new(p.position + 3.0 * n, -n);
            assert!((patch.intersect(&ray, f64::INFINITY).unwrap().t - 3.0).abs() < 1e-13);
        }
        // The apex has the normal of its neighbourhood and a finite density.
        let apex = patch.point_at(0.5, 0.0);
        assert!((apex.normal.dot(n) - 1.0).abs() < 1e-7 && apex.dpdu == DVec3::ZERO);
        assert!(patch.pdf(patch.regular(0.5, 0.0)).0.is_finite());
    }

    #[test]
    fn neighbours_leave_no_gap_at_their_border() {
        let q = |x: f64, y: f64| DVec3::new(x, y, (1.7 * x + 0.3).sin() * (y - 0.2));
        let left = BilinearPatch::try_new(q(0.0, 0.0), q(1.0, 0.1), q(0.0, 1.0), q(1.1, 0.9)).unwrap();
        let right = BilinearPatch::try_new(q(1.0, 0.1), q(2.0, 0.0), q(1.1, 0.9), q(2.0, 1.0)).unwrap();
        for i in 0..20_000 {
            let target = left.point_at(1.0, (f64::from(i) * 0.618_033_988_7).fract()).position;
            let origin = target + DVec3::new(f64::from(i).sin(), f64::from(i).cos(), 1.0 + f64::from(i % 7));
            let ray = Ray::new(origin, target - origin);
            let met = [&left, &right].iter().any(|p| all(p, &ray).iter().any(|h| (h.t - 1.0).abs() < 1e-9));
            assert!(met, "{ray:?}");
        }
    }

    #[test]
    fn derivatives_are_differences() {
        let patch = BilinearPatch::try_new(
            DVec3::new(0.1, 0.0, 0.5),
            DVec3::new(1.3, 0.2, -0.4),
            DVec3::new(-0.2, 0.9, 0.0),
            DVec3::new(1.0, 1.4, 1.0),
        )
        .unwrap();
        let h = 1e-5;
        for (u, v) in [(0.1, 0.2), (0.5, 0.5), (0.9, 0.3)] {
            let p = patch.point_at(u, v);
            let hit = Hit::new(1.0, u, v, 0);
            let [dndu, dndv] = patch.normal_derivatives(&hit, &p);
            let (pu, pv) = (patch.point_at(u + h, v), patch.point_at(u, v + h));
            let (mu, mv) = (patch.point_at(u - h, v), patch.point_at(u, v - h));
            assert!(((pu.position - mu.position) / (2.0 * h) - p.dpdu).length() < 1e-9);
            assert!(((pv.position - mv.position) / (2.0 * h) - p.dpdv).length() < 1e-9);
            assert!(((pu.normal - mu.normal) / (2.0 * h) - dndu).length() < 1e-8);
            assert!(((pv.normal - mv.normal) / (2.0 * h) - dndv).length() < 1e-8);
        }
    }

    #[test]
    fn spawned_rays_do_not_meet_their_own_point() {
        let mut hits = 0;
        for i in 0..40_000 {
            let t = f64::from(i);
            let scale = 10.0_f64.powi(i % 7 - 3);
            let wobble = |k: f64| DVec3::new((t * k).sin(), (t * k * 1.3).cos(), (t * k * 0.7).sin()) * 0.4;
            let at = |x: f64, y: f64, k: f64| {
                (DVec3::new(x, y, 0.0) + wobble(k)) * scale + DVec3::new(50.0, 3.0, -8.0)
            };
            let patch = BilinearPatch::try_new(
                at(0.0, 0.0, 1.1),
                at(1.0, 0.0, 2.3),
                at(0.0, 1.0, 3.7),
                at(1.0, 1.0, 4.9),
            )
            .unwrap();
            let p = patch.point_at((t * 0.618_033_988_7).fract(), (t * 0.754_877_666).fract());
            let along = p.dpdu * (t * 5.1).sin() + p.dpdv * (t * 3.3).cos();
            let direction = along.normalize() + p.normal * (0.01 + (t * 0.9).sin().abs());
            let origin = offset_origin(p.position, p.error, p.normal, direction);
            for hit in all(&patch, &Ray::new(origin, direction)) {
                // The saddle may come back, but not at once: at a slope of 0.01 and more, not within 1e-6.
                assert!(hit.t > 1e-6 * scale, "{hit:?}");
                hits += 1;
            }
        }
        assert!(hits > 100, "{hits}");
    }

    #[test]
    fn corners_on_a_line_are_refused() {
        let on_line = |t: f64| DVec3::new(1.0, 2.0, 3.0) + t * DVec3::new(0.3, -0.7, 0.2);
        let flat = BilinearPatch::try_new(on_line(0.0), on_line(1.0), on_line(2.5), on_line(0.3));
        assert!(matches!(flat, Err(SurfaceError::Degenerate { .. })));
        let infinite = BilinearPatch::try_new(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::INFINITY);
        assert!(matches!(infinite, Err(SurfaceError::NotFinite { .. })));
    }
}
