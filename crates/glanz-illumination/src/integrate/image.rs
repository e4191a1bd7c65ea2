//! Images of emitters in mirrors.

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;

use super::contour::ReceivingPoint;
use super::direct::EMITTER_SHELL;
use super::emitter_shape::EmitterShape;
use super::mirror::{MirrorFace, Mirrors};
use super::region::Region;

/// Images of all emitters in all mirrors, seen from a point. Every part of the region is a pair of an emitter and a mirror face.
pub(super) struct Images<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mirrors: &'a Mirrors<'a>,
    pub(super) emitters: &'a [EmitterShape],
    pub(super) wavelengths: Wavelengths,
    pub(super) receiver: ReceivingPoint,
    /// The same point, offset from the surface: end of the shadow rays.
    pub(super) origin: DVec3,
    /// Numbers of emitter and face, by part.
    pub(super) pairs: Vec<[u32; 2]>,
}

/// Branch of the border function for the horizon of the receiver.
const HORIZON: u32 = u32::MAX;

/// A point of a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageSample {
    at: DVec2,
    border: f64,
    branch: u32,
    /// Unit direction from the receiver.
    direction: DVec3,
    /// Direction after the reflection.
    mirrored: DVec3,
    position: DVec3,
    cos: f64,
}

impl Images<'_> {
    fn pair(&self, part: u32) -> Option<(&EmitterShape, &MirrorFace)> {
        let &[emitter, face] = self.pairs.get(part as usize)?;
        Some((self.emitters.get(emitter as usize)?, self.mirrors.faces().get(face as usize)?))
    }

    fn try_sample(&self, part: u32, at: DVec2) -> Option<ImageSample> {
        let (emitter, face) = self.pair(part)?;
        let (position, normal) = self.mirrors.place(face, at)?;
        let direction = (position - self.receiver.point).try_normalize()?;
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        let cos = direction.dot(self.receiver.normal);
        let (rim, side) = emitter.border(position, mirrored);
        let (border, branch) = if cos < rim { (cos, HORIZON) } else { (rim, side) };
        Some(ImageSample { at, border, branch, direction, mirrored, position, cos })
    }
}

impl Region for Images<'_> {
    type Sample = ImageSample;

    fn sample(&self, part: u32, at: DVec2) -> ImageSample {
        self.try_sample(part, at).unwrap_or(ImageSample {
            at,
            border: f64::NEG_INFINITY,
            branch: HORIZON,
            direction: DVec3::ZERO,
            mirrored: DVec3::ZERO,
            position: DVec3::ZERO,
            cos: 0.0,
        })
    }

    fn border(sample: &ImageSample) -> f64 {
        sample.border
    }

    fn branch(sample: &ImageSample) -> u32 {
        sample.branch
    }

    /// Lux per unit of the parameters.
    fn value(&self, part: u32, sample: &ImageSample) -> Option<f64> {
        let (emitter, face) = self.pair(part)?;
        let point = self.mirrors.point(face, sample.at)?;
        let back = point.at.spawn_to(self.origin, None);
        let on = point.at.spawn(sample.mirrored);
        let way = emitter.distance(sample.position, sample.mirrored);
        if self.scene.occluded(&back, 1.0) || self.scene.occluded(&on, way * (1.0 - EMITTER_SHELL)) {
            return None;
        }
        let Some(reflectance) = self.mirrors.reflectance(&point, -sample.direction) else { return Some(0.0) };
        let luminance = photometric(emitter.radiance * (reflectance * point.opacity), &self.wavelengths);
        let cos_at_mirror = sample.direction.dot(point.at.point.normal).abs();
        let squared = sample.position.distance_squared(self.receiver.point);
        Some(luminance * sample.cos * cos_at_mirror * point.area_element / squared)
    }
}
