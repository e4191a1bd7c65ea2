//! Disks and rings.

use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use super::azimuth::AzimuthRange;
use super::revolution::point_on_ray;
use crate::error::{SurfaceError, finite, positive};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::rational::Profile;
use crate::surface::RaySurface;

/// A disk at constant z about the z axis, with an optional hole.
///
/// `u` is the azimuth as a fraction of its range, `v` runs from the outer border (0) to the inner one (1). The normal is
/// +z. Rays in its plane do not hit it. Sampled uniformly by area.
///
/// # Source
/// @pharr2023 section 6.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    height: f64,
    radius: f64,
    inner_radius: f64,
    azimuth: AzimuthRange,
}

impl Disk {
    /// The disk at z = `height` (m) from `inner_radius` (m, may be 0) to `radius` (m) with azimuth up to `phi_max`
    /// (radians, limited to 2 pi).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for `radius` or `phi_max`, [`SurfaceError::OutOfRange`] if
    /// `inner_radius` is not in [0, radius).
    pub fn try_new(height: f64, radius: f64, inner_radius: f64, phi_max: f64) -> Result<Self, SurfaceError> {
        let (height, radius) = (finite("height", height)?, positive("radius", radius)?);
        let inner_radius = finite("inner_radius", inner_radius)?;
        if !(inner_radius >= 0.0 && inner_radius < radius) {
            let (parameter, value) = ("inner_radius", inner_radius);
            return Err(SurfaceError::OutOfRange { parameter, value, min: 0.0, max: radius });
        }
        Ok(Self { height, radius, inner_radius, azimuth: AzimuthRange::try_new(phi_max)? })
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.azimuth.phi_max() * self.width() * (self.radius + self.inner_radius)
    }

    /// Outer radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Its z, m.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Whether it is a full disk, without a hole and with the full azimuth.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.inner_radius == 0.0 && self.azimuth.phi_max() == std::f64::consts::TAU
    }

    pub(crate) fn phi_max(&self) -> f64 {
        self.azimuth.phi_max()
    }

    /// The profile curve.
    pub(crate) fn profile(&self) -> Profile {
        let at = |radius: f64| DVec3::new(radius, 0.0, self.height);
        Profile::line(at(self.radius), at(self.inner_radius))
    }

    fn width(&self) -> f64 {
        self.radius - self.inner_radius
    }

    pub(crate) fn at(&self, uv: DVec2) -> SurfacePoint {
        let rho = self.radius - uv.y * self.width();
        let position = (self.azimuth.direction(uv.x) * rho).extend(self.height);
        SurfacePoint {
            position,
            error: position.abs() * gamma(2),
            normal: DVec3::Z,
            shading_normal: DVec3::Z,
            uv,
            dpdu: self.azimuth.derivative(position),
            dpdv: (self.azimuth.direction_at(position, || uv.x) * -self.width()).extend(0.0),
        }
    }
}

impl RaySurface for Disk {
    fn bounds(&self) -> Bounds3 {
        self.azimuth.bounds([self.inner_radius, self.radius], [self.height; 2])
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let t = (self.height - ray.origin.z) / ray.direction.z;
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let p = point_on_ray(ray.origin, ray.direction, t).truncate();
        let rho = p.length();
        if !(rho <= self.radius && rho >= self.inner_radius) {
            return None;
        }
        let u = self.azimuth.parameter(p.x, p.y)?;
        Some(Hit::new(t, u, (self.radius - rho) / self.width(), 0))
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        hits.extend(self.intersect(ray, t_max));
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.at(DVec2::new(hit.u, hit.v))
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        // Area grows with the square of the radius.
        let (outer, inner) = (self.radius * self.radius, self.inner_radius * self.inner_radius);
        let rho = (outer + xi.y * (inner - outer)).max(inner).sqrt();
        let v = ((self.radius - rho) / self.width()).clamp(0.0, 1.0);
        let hit = Hit::new(0.0, xi.x, v, 0);
        let point = self.at(DVec2::new(xi.x, v));
        Some(SurfaceSample { hit, point, pdf: AreaPdf(1.0 / self.area()) })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(AreaPdf(1.0 / self.area()))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    #[test]
    fn ring_is_hit_between_its_borders_only() {
        let ring = Disk::try_new(2.0, 3.0, 1.0, TAU).unwrap();
        let t =
            |x: f64| ring.intersect(&Ray::new(DVec3::new(x, 0.0, 5.0), -DVec3::Z), 100.0).map(|h| (h.t, h.v));
        assert_eq!(t(0.5), None);
        assert_eq!(t(1.0), Some((3.0, 1.0)));
        assert_eq!(t(2.0), Some((3.0, 0.5)));
        assert_eq!(t(3.0), Some((3.0, 0.0)));
        assert_eq!(t(3.1), None);
    }

    #[test]
    fn ray_within_the_plane_misses() {
        let disk = Disk::try_new(0.0, 1.0, 0.0, TAU).unwrap();
        assert_eq!(disk.intersect(&Ray::new(DVec3::new(-2.0, 0.0, 0.0), DVec3::X), 100.0), None);
    }

    #[test]
    fn middle_of_a_disk_has_a_frame() {
        let disk = Disk::try_new(0.0, 2.0, 0.0, TAU).unwrap();
        let ray = Ray::new(DVec3::Z, -DVec3::Z);
        let point = disk.point(&ray, &disk.intersect(&ray, 9.0).unwrap());
        assert_eq!((point.dpdu.length(), point.dpdv), (0.0, DVec3::new(-2.0, 0.0, 0.0)));
    }

    #[test]
    fn area_of_a_half_ring() {
        assert_eq!(Disk::try_new(0.0, 3.0, 1.0, PI).unwrap().area(), 0.5 * PI * 8.0);
        assert!(Disk::try_new(0.0, 1.0, 1.0, PI).is_err());
        assert!(Disk::try_new(0.0, 1.0, -0.1, PI).is_err());
    }
}
