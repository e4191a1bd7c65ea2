//! Surfaces of lenses.

use glanz_math::{DVec3, Ray};

use super::LensRangeError;
use super::stop::LensStop;
use crate::description::LensDescription;

/// Most surfaces and stops of a lens; lenses have some twenty, and the bounds of the exit pupil cost time in proportion.
const MOST_INTERFACES: usize = 256;

/// A spherical surface between two media, or a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LensInterface {
    /// Radius of its curvature, metres, positive if its middle is on the side of the film; `None` for a stop.
    pub(super) curvature_radius: Option<f64>,
    /// Distance of its vertex from the film, metres.
    pub(super) z: f64,
    /// Refractive index on the side of the film.
    pub(super) eta_film: f64,
    /// Refractive index on the side of the scene.
    pub(super) eta_scene: f64,
    /// Radius of its opening, metres.
    pub(super) aperture_radius: f64,
}

/// The interfaces from the scene to the film, with the last one on the film.
pub(super) fn interfaces(lens: &LensDescription) -> Result<Vec<LensInterface>, LensRangeError> {
    let count = lens.interfaces.len();
    if count > MOST_INTERFACES {
        return Err(("number of surfaces of a lens", count as f64, "at most 256"));
    }
    let mut interfaces = Vec::with_capacity(count);
    let (mut z, mut eta_scene) = (0.0, 1.0);
    for interface in &lens.interfaces {
        let (radius, thickness) = (interface.curvature_radius, interface.thickness);
        if !radius.is_finite() {
            return Err(("curvature radius of a lens", radius, "finite"));
        }
        if !thickness.is_finite() {
            return Err(("thickness of a lens", thickness, "finite"));
        }
        let eta_film = if interface.eta == 0.0 { 1.0 } else { interface.eta };
        if !(eta_film > 0.0 && eta_film.is_finite()) {
            return Err(("refractive index of a lens", eta_film, "0 or positive"));
        }
        let is_stop = radius == 0.0;
        let diameter =
            if is_stop { interface.diameter.min(lens.aperture_diameter) } else { interface.diameter };
        if !(diameter > 0.0 && diameter.is_finite()) {
            return Err(("diameter of a lens or stop", diameter, "positive"));
        }
        interfaces.push(LensInterface {
            curvature_radius: (!is_stop).then_some(radius),
            z,
            // A stop is no border between media.
            eta_film: if is_stop { eta_scene } else { eta_film },
            eta_scene,
            aperture_radius: 0.5 * diameter,
        });
        eta_scene = if is_stop { eta_scene } else { eta_film };
        z -= thickness;
    }
    let last = interfaces.last().map_or(0.0, |interface| interface.z);
    Ok(moved(interfaces, -last))
}

/// The interfaces, further from the film by `distance`, metres.
pub(super) fn moved(mut interfaces: Vec<LensInterface>, distance: f64) -> Vec<LensInterface> {
    interfaces.iter_mut().for_each(|interface| interface.z += distance);
    interfaces
}

/// Traces a ray from the film to the scene; returns it with the transmittance of the stops on its way. `None` if it is stopped.
pub(super) fn trace(interfaces: &[LensInterface], stop: &LensStop, ray: Ray) -> Option<(Ray, f64)> {
    let (mut ray, mut transmittance) = (ray, 1.0);
    for interface in interfaces.iter().rev() {
        let t = interface.distance(&ray)?;
        let mut point = ray.at(t);
        let limit = interface.aperture_radius;
        let Some(radius) = interface.curvature_radius else {
            transmittance *= stop.transmittance(point.truncate() / limit);
            if transmittance <= 0.0 {
                return None;
            }
            point.z = interface.z;
            ray.origin = point;
            continue;
        };
        if point.truncate().length_squared() > limit * limit {
            return None;
        }
        let outwards = (point - DVec3::new(0.0, 0.0, interface.z - radius)) / radius;
        // Against the ray: `outwards` is towards the scene, as the ray is, for both signs of the radius.
        let direction = refracted(ray.direction, -outwards, interface.eta_film / interface.eta_scene)?;
        ray = Ray::new(point, direction);
    }
    Some((ray, transmittance))
}

impl LensInterface {
    /// Distance along a ray from the film; `None` if the ray misses the sphere.
    fn distance(&self, ray: &Ray) -> Option<f64> {
        let offset = ray.origin - DVec3::new(0.0, 0.0, self.z);
        let Some(radius) = self.curvature_radius else {
            let t = -offset.z / ray.direction.z;
            return (t >= 0.0).then_some(t);
        };
        // Relative to the vertex, so that nothing cancels where the radius is large: t^2 + 2 b t + c = 0.
        let b = offset.dot(ray.direction) + radius * ray.direction.z;
        let c = offset.length_squared() + 2.0 * radius * offset.z;
        let discriminant = b * b - c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        // The half of the sphere at the vertex: the far one of a surface that bulges to the scene.
        let t = match radius > 0.0 {
            true if b > 0.0 => -c / (b + root),
            true => root - b,
            false if b < 0.0 => c / (root - b),
            false => -b - root,
        };
        (t >= 0.0).then_some(t)
    }
}

/// The direction behind an interface; `None` if it reflects all. `normal`: against the ray; `eta`: refractive index before it over that behind it.
fn refracted(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cos = -direction.dot(normal);
    let cos2_behind = 1.0 - eta * eta * (1.0 - cos * cos);
    if cos <= 0.0 || cos2_behind.is_nan() || cos2_behind <= 0.0 {
        return None;
    }
    Some((eta * direction + (eta * cos - cos2_behind.sqrt()) * normal).normalize())
}
