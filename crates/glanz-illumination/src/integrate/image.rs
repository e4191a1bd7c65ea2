//! The image of a lamp in the mirrors.

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;

use super::contour::ReceivingPoint;
use super::direct::LAMP_SHELL;
use super::lamp::EmitterShape;
use super::mirror::{MirrorFace, Mirrors};
use super::region::Region;

/// Images of all lamps in all mirrors, seen from a point. The parts of the region are pairs of them.
pub(super) struct Images<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mirrors: &'a Mirrors<'a>,
    pub(super) lamps: &'a [EmitterShape],
    pub(super) wavelengths: Wavelengths,
    pub(super) receiver: ReceivingPoint,
    /// The same point, offset from the surface: end of the shadow rays.
    pub(super) origin: DVec3,
    /// By part: numbers of lamp and face.
    pub(super) pairs: Vec<[u32; 2]>,
}

/// Branch of the border function that is no side of a lamp.
const HORIZON: u32 = u32::MAX;

/// A place of a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageSample {
    at: DVec2,
    border: f64,
    branch: u32,
    /// Unit direction from the receiver.
    direction: DVec3,
    /// Direction after the mirror.
    mirrored: DVec3,
    position: DVec3,
    cos: f64,
}

impl Images<'_> {
    fn pair(&self, part: u32) -> Option<(&EmitterShape, &MirrorFace)> {
        let &[lamp, face] = self.pairs.get(part as usize)?;
        Some((self.lamps.get(lamp as usize)?, self.mirrors.faces().get(face as usize)?))
    }

    fn look(&self, part: u32, at: DVec2) -> Option<ImageSample> {
        let (lamp, face) = self.pair(part)?;
        let (position, normal) = self.mirrors.place(face, at)?;
        let direction = (position - self.receiver.point).try_normalize()?;
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        let cos = direction.dot(self.receiver.normal);
        let (rim, side) = lamp.border(position, mirrored);
        let (border, branch) = if cos < rim { (cos, HORIZON) } else { (rim, side) };
        Some(ImageSample { at, border, branch, direction, mirrored, position, cos })
    }
}

impl Region for Images<'_> {
    type Sample = ImageSample;

    fn see(&self, part: u32, at: DVec2) -> ImageSample {
        self.look(part, at).unwrap_or(ImageSample {
            at,
            border: f64::NEG_INFINITY,
            branch: HORIZON,
            direction: DVec3::ZERO,
            mirrored: DVec3::ZERO,
            position: DVec3::ZERO,
            cos: 0.0,
        })
    }

    fn border(seen: &ImageSample) -> f64 {
        seen.border
    }

    fn branch(seen: &ImageSample) -> u32 {
        seen.branch
    }

    /// Lux per unit of the parameters.
    fn value(&self, part: u32, seen: &ImageSample) -> Option<f64> {
        let (lamp, face) = self.pair(part)?;
        let point = self.mirrors.point(face, seen.at)?;
        let back = point.at.spawn_to(self.origin, None);
        let on = point.at.spawn(seen.mirrored);
        let way = lamp.distance(seen.position, seen.mirrored);
        if self.scene.occluded(&back, 1.0) || self.scene.occluded(&on, way * (1.0 - LAMP_SHELL)) {
            return None;
        }
        let Some(reflectance) = self.mirrors.reflectance(&point, -seen.direction) else { return Some(0.0) };
        let luminance = photometric(lamp.radiance * reflectance, &self.wavelengths);
        let cos_at_mirror = seen.direction.dot(point.at.point.normal).abs();
        let squared = seen.position.distance_squared(self.receiver.point);
        Some(luminance * seen.cos * cos_at_mirror * point.area_element / squared)
    }
}
