//! Direct light of emitters.

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::DVec3;
use glanz_math::{DVec2, Ray};
use glanz_scene::{Light, Scene};

use super::contour::ReceivingPoint;
use super::emitter_shape::{EmitterForm, EmitterShape};
use super::region::{IntegrationRect, Region, RegionIntegral, Tolerance, integrate};

/// Shadow rays along each side of a part of an emitter.
const RAYS_PER_SIDE: u32 = 8;
/// Shadow rays to a part of an emitter.
pub(super) const RAYS: usize = (RAYS_PER_SIDE * RAYS_PER_SIDE) as usize;
/// Fraction of the distance to an emitter, at its end, in which shadow rays ignore surfaces, so that rounding does not make the emitter shadow itself.
pub(super) const EMITTER_SHELL: f64 = 1e-9;
/// Largest number of rectangles where something hides a part of an emitter.
pub(super) const BUDGET: usize = 4096;

/// Visible part of an emitter as a flat shape.
enum VisibleShape<'a> {
    Disk { center: DVec3, normal: DVec3, radius: f64 },
    Polygon { corners: &'a [DVec3], normal: DVec3 },
}

impl<'a> VisibleShape<'a> {
    /// `None` if no emitting side is visible.
    fn of(emitter: &'a EmitterShape, from: DVec3) -> Option<Self> {
        if emitter.is_dark_in(from, 0.0) {
            return None;
        }
        match &emitter.form {
            EmitterForm::Sphere { center, radius } => {
                // The disk that fills the same cone; the cone touches the sphere at its rim.
                let to = *center - from;
                let share = radius * radius / to.length_squared();
                let normal = to.try_normalize().filter(|_| share < 1.0)?;
                Some(Self::Disk {
                    center: *center - to * share,
                    normal: -normal,
                    radius: radius * (1.0 - share).sqrt(),
                })
            }
            EmitterForm::Disk { center, normal, radius } => {
                Some(Self::Disk { center: *center, normal: *normal, radius: *radius })
            }
            EmitterForm::Polygon { polygon, normal } => {
                Some(Self::Polygon { corners: polygon.corners(), normal: *normal })
            }
        }
    }

    fn parts(&self) -> u32 {
        match self {
            Self::Disk { .. } => 1,
            Self::Polygon { corners, .. } => corners.len().saturating_sub(2) as u32,
        }
    }

    /// A point of a part by its parameters in the unit square, with the area per unit of the square and the normal.
    fn at(&self, part: u32, at: DVec2) -> (DVec3, f64, DVec3) {
        match self {
            Self::Disk { center, normal, radius } => {
                let (x, y) = normal.any_orthonormal_pair();
                let (sin, cos) = (std::f64::consts::TAU * at.y).sin_cos();
                let area_element = std::f64::consts::TAU * radius * radius * at.x;
                (*center + radius * at.x * (cos * x + sin * y), area_element, *normal)
            }
            Self::Polygon { corners, normal } => {
                let part = part as usize;
                let (Some(&a), Some(&b), Some(&c)) =
                    (corners.first(), corners.get(part + 1), corners.get(part + 2))
                else {
                    return (DVec3::ZERO, 0.0, *normal);
                };
                let area_element = at.x * (b - a).cross(c - a).length();
                (a + at.x * ((b - a).lerp(c - a, at.y)), area_element, *normal)
            }
        }
    }
}

/// An emitter as seen from a point.
struct EmitterRegion<'a> {
    scene: &'a Scene,
    receiver: ReceivingPoint,
    /// Start of the rays, offset from the surface.
    origin: DVec3,
    emitter: &'a EmitterShape,
    figure: VisibleShape<'a>,
}

#[derive(Clone, Copy)]
struct EmitterSample {
    offset: DVec3,
    cos: f64,
    weight: f64,
}

impl Region for EmitterRegion<'_> {
    type Sample = EmitterSample;

    fn sample(&self, part: u32, at: DVec2) -> EmitterSample {
        let (point, area_element, normal) = self.figure.at(part, at);
        let offset = point - self.receiver.point;
        let squared = offset.length_squared();
        let cos = offset.dot(self.receiver.normal) / squared.sqrt();
        let weight = area_element * (offset.dot(normal) / squared.sqrt()).abs() * cos / squared;
        EmitterSample { offset, cos, weight }
    }

    fn border(sample: &EmitterSample) -> f64 {
        sample.cos
    }

    fn value(&self, _part: u32, sample: &EmitterSample) -> Option<f64> {
        let direction = sample.offset.try_normalize()?;
        let way = self.emitter.distance(self.receiver.point, direction);
        let target = self.receiver.point + direction * way;
        let ray = Ray::new(self.origin, target - self.origin);
        (!self.scene.occluded(&ray, 1.0 - EMITTER_SHELL)).then_some(sample.weight)
    }
}

/// Projected solid angle of the visible part of an emitter, sr.
///
/// In closed form if all or none of the rays of a grid reach it; occluders smaller than an eighth of the emitter may be missed. Otherwise it is divided into
/// about `budget` rectangles at most.
///
/// # Errors
/// The projected solid angle of the whole emitter if something hides a part of it and `budget` is 0.
pub(super) fn of_emitter(
    scene: &Scene,
    receiver: ReceivingPoint,
    origin: DVec3,
    emitter: &EmitterShape,
    tolerance: Tolerance,
    budget: usize,
) -> Result<RegionIntegral, f64> {
    let Some(figure) = VisibleShape::of(emitter, receiver.point) else {
        return Ok(RegionIntegral::default());
    };
    let whole = match &figure {
        VisibleShape::Disk { center, normal, radius } => receiver.of_disk(*center, *normal, *radius),
        VisibleShape::Polygon { corners, .. } => receiver.of_polygon(corners),
    };
    if whole <= 0.0 {
        return Ok(RegionIntegral::default());
    }
    let region = EmitterRegion { scene, receiver, origin, emitter, figure };
    let (mut open, mut hidden) = (false, false);
    for part in 0..region.figure.parts() {
        for (i, j) in (0..RAYS_PER_SIDE).flat_map(|i| (0..RAYS_PER_SIDE).map(move |j| (i, j))) {
            if open && hidden {
                break;
            }
            let at = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(RAYS_PER_SIDE);
            let sample = region.sample(part, at);
            if sample.cos > 0.0 {
                let is_open = region.value(part, &sample).is_some();
                open |= is_open;
                hidden |= !is_open;
            }
        }
    }
    match (open, hidden) {
        // A sliver above the horizon may lie between the rays.
        (false, false) => Ok(RegionIntegral { value: whole, error: whole }),
        (true, false) => Ok(RegionIntegral { value: whole, error: 1e-9 * whole }),
        (false, true) => Ok(RegionIntegral::default()),
        (true, true) if budget == 0 => Err(whole),
        (true, true) => {
            let halves = IntegrationRect::UNIT.quarters();
            let cells = (0..region.figure.parts()).flat_map(|part| halves.map(|rect| (part, rect)));
            Ok(integrate(&region, cells, RegionIntegral::default(), tolerance, budget))
        }
    }
}

/// A sample of the projected solid angle of an emitter, sr, whose mean over `at` in the unit square is that of the whole emitter, and whether nothing hides its
/// place; `None` without light from there.
pub(super) fn sampled(
    scene: &Scene,
    receiver: ReceivingPoint,
    origin: DVec3,
    emitter: &EmitterShape,
    at: DVec2,
) -> Option<(f64, bool)> {
    let figure = VisibleShape::of(emitter, receiver.point)?;
    let region = EmitterRegion { scene, receiver, origin, emitter, figure };
    let parts = f64::from(region.figure.parts());
    let place = parts * at.x;
    // Uniform by area: parameters of a part are polar.
    let radius = place.fract().sqrt().max(f64::MIN_POSITIVE);
    let part = place as u32;
    let sample = region.sample(part, DVec2::new(radius, at.y));
    let is_lit = sample.cos > 0.0 && sample.weight > 0.0;
    is_lit.then(|| (0.5 * parts * sample.weight / radius, region.value(part, &sample).is_some()))
}

/// Illuminance by a light without extent, lx.
pub(super) fn of_point(
    scene: &Scene,
    receiver: ReceivingPoint,
    origin: DVec3,
    light: &Light,
    wavelengths: &Wavelengths,
) -> f64 {
    let arriving = from_point(scene, receiver, origin, light, wavelengths);
    arriving.map_or(0.0, |(lux, is_seen)| if is_seen { lux } else { 0.0 })
}

/// Illuminance by a light without extent as if nothing hid it, lx, and whether nothing does; `None` without light from there.
pub(super) fn from_point(
    scene: &Scene,
    receiver: ReceivingPoint,
    origin: DVec3,
    light: &Light,
    wavelengths: &Wavelengths,
) -> Option<(f64, bool)> {
    let arriving = light.incident(receiver.point)?;
    let cos = receiver.normal.dot(arriving.towards);
    if cos <= 0.0 || arriving.irradiance.is_black() {
        return None;
    }
    let (ray, end) = if arriving.distance.is_finite() {
        let target = receiver.point + arriving.towards * arriving.distance;
        (Ray::new(origin, target - origin), 1.0)
    } else {
        (Ray::new(origin, arriving.towards), f64::INFINITY)
    };
    Some((cos * photometric(arriving.irradiance, wavelengths), !scene.occluded(&ray, end)))
}
