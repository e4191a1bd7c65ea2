//! The plane z = 0.

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use super::revolution::point_on_ray;
use crate::error::SurfaceError;
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;

/// The plane z = 0, clipped to an axis-parallel rectangle whose sides may be infinitely far.
///
/// Along an axis with two finite sides the parameter runs from 0 to 1 between them; otherwise it is the coordinate
/// itself in metres. The normal is +z. Rays in the plane do not hit it. Sampled uniformly by area; an infinite
/// plane cannot be sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    min: DVec2,
    max: DVec2,
}

impl Plane {
    /// The part of the plane with x and y in the given ranges (m, lower end first, infinite ends allowed).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`] if an end is not a number, [`SurfaceError::EmptyRange`].
    pub fn try_new(x: [f64; 2], y: [f64; 2]) -> Result<Self, SurfaceError> {
        for (parameter, [min, max]) in [("x", x), ("y", y)] {
            for value in [min, max] {
                if value.is_nan() {
                    return Err(SurfaceError::NotFinite { parameter, value });
                }
            }
            if !(min < max) || min == f64::INFINITY || max == f64::NEG_INFINITY {
                return Err(SurfaceError::EmptyRange { parameter, min, max });
            }
        }
        Ok(Self { min: DVec2::new(x[0], y[0]), max: DVec2::new(x[1], y[1]) })
    }

    /// The whole plane.
    #[must_use]
    pub fn infinite() -> Self {
        Self { min: DVec2::NEG_INFINITY, max: DVec2::INFINITY }
    }

    /// Area, m^2; may be infinite.
    #[must_use]
    pub fn area(&self) -> f64 {
        let size = self.max - self.min;
        size.x * size.y
    }

    /// Lower end and length of the parameter ranges, metres, per axis.
    fn scale(&self) -> (DVec2, DVec2) {
        let axis = |min: f64, max: f64| {
            let length = max - min;
            if length.is_finite() { (min, length) } else { (0.0, 1.0) }
        };
        let (x, y) = (axis(self.min.x, self.max.x), axis(self.min.y, self.max.y));
        (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1))
    }

    fn at(&self, p: DVec2, uv: DVec2) -> SurfacePoint {
        let (_, length) = self.scale();
        SurfacePoint {
            position: p.extend(0.0),
            // z = 0 is exact, and a ray from there has t = 0, which is not a hit.
            error: DVec3::ZERO,
            normal: DVec3::Z,
            shading_normal: DVec3::Z,
            uv,
            dpdu: DVec3::X * length.x,
            dpdv: DVec3::Y * length.y,
        }
    }
}

impl RaySurface for Plane {
    fn bounds(&self) -> Bounds3 {
        Bounds3 { min: self.min.extend(0.0), max: self.max.extend(0.0) }
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let t = -ray.origin.z / ray.direction.z;
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let p = point_on_ray(ray.origin, ray.direction, t).truncate();
        if !(p.cmpge(self.min).all() && p.cmple(self.max).all() && p.is_finite()) {
            return None;
        }
        let (start, length) = self.scale();
        let uv = (p - start) / length;
        Some(Hit::new(t, uv.x, uv.y, 0))
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        hits.extend(self.intersect(ray, t_max));
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let p = point_on_ray(ray.origin, ray.direction, hit.t).truncate();
        self.at(p.clamp(self.min, self.max), DVec2::new(hit.u, hit.v))
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let pdf = self.area_pdf_anywhere()?;
        let hit = Hit::new(0.0, xi.x, xi.y, 0);
        Some(SurfaceSample { hit, point: self.at_parameters(xi)?, pdf })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        self.area_pdf_anywhere()
    }
}

impl Plane {
    /// The point with the given parameters, also of an infinite plane; those outside the plane are moved to its border.
    #[must_use]
    pub fn point_at(&self, uv: DVec2) -> SurfacePoint {
        let (start, length) = self.scale();
        self.at((start + uv * length).max(self.min).min(self.max), uv)
    }

    /// Ranges of the parameters.
    #[must_use]
    pub fn domain(&self) -> [[f64; 2]; 2] {
        let axis = |min: f64, max: f64| if (max - min).is_finite() { [0.0, 1.0] } else { [min, max] };
        [axis(self.min.x, self.max.x), axis(self.min.y, self.max.y)]
    }

    /// The point with the given parameters; `None` if the plane is infinite.
    pub(crate) fn at_parameters(&self, uv: DVec2) -> Option<SurfacePoint> {
        let p = (self.min + uv * (self.max - self.min)).min(self.max);
        p.is_finite().then(|| self.at(p, uv))
    }

    fn area_pdf_anywhere(&self) -> Option<AreaPdf> {
        let area = self.area();
        area.is_finite().then(|| AreaPdf(1.0 / area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_plane_is_hit_far_out_and_cannot_be_sampled() {
        let plane = Plane::infinite();
        let ray = Ray::new(DVec3::new(1e9, 2.0, 3.0), DVec3::new(0.0, 0.0, -0.5));
        let hit = plane.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.t, hit.u, hit.v), (6.0, 1e9, 2.0));
        assert!(plane.sample(DVec2::splat(0.5)).is_none());
        assert!(plane.area_pdf(&hit, &plane.point(&ray, &hit)).is_none());
        assert!(!plane.bounds().is_finite());
    }

    #[test]
    fn half_infinite_strip_mixes_both_parameters() {
        let strip = Plane::try_new([0.0, 4.0], [f64::NEG_INFINITY, 1.0]).unwrap();
        let ray = Ray::new(DVec3::new(1.0, -7.0, 1.0), -DVec3::Z);
        let hit = strip.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!((hit.u, hit.v), (0.25, -7.0));
        let beside = Ray::new(DVec3::new(1.0, 1.5, 1.0), -DVec3::Z);
        assert_eq!(strip.intersect(&beside, f64::INFINITY), None);
    }

    #[test]
    fn ray_from_the_plane_does_not_meet_it() {
        let plane = Plane::infinite();
        for z in [-1.0, 0.0, 1.0] {
            let ray = Ray::new(DVec3::new(0.3, 0.4, 0.0), DVec3::new(1.0, 0.0, z));
            assert_eq!(plane.intersect(&ray, f64::INFINITY), None);
        }
    }

    #[test]
    fn empty_ranges_are_refused() {
        assert!(Plane::try_new([1.0, 1.0], [0.0, 1.0]).is_err());
        assert!(Plane::try_new([f64::NAN, 1.0], [0.0, 1.0]).is_err());
        assert!(Plane::try_new([f64::INFINITY, f64::INFINITY], [0.0, 1.0]).is_err());
    }
}
