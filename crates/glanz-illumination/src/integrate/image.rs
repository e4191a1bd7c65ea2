//! The image of a lamp in the mirrors.

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{DVec2, DVec3};
use glanz_scene::Scene;

use super::contour::Receiver;
use super::direct::LAMP_SHELL;
use super::lamp::Lamp;
use super::mirror::{Face, Mirrors};
use super::region::Region;

/// All lamps in all mirrors, seen from a place. The parts of the region are pairs of them.
pub(super) struct Images<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mirrors: &'a Mirrors<'a>,
    pub(super) lamps: &'a [Lamp],
    pub(super) wavelengths: Wavelengths,
    pub(super) receiver: Receiver,
    /// The same place, off the surface: where rays end.
    pub(super) origin: DVec3,
    /// By part: numbers of lamp and face.
    pub(super) pairs: Vec<[u32; 2]>,
}

/// Branch of the border function that is no side of a lamp.
const HORIZON: u32 = u32::MAX;

/// A place of a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    at: DVec2,
    border: f64,
    branch: u32,
    /// Unit direction from the receiver.
    direction: DVec3,
    /// Where it goes on from the mirror.
    mirrored: DVec3,
    position: DVec3,
    cos: f64,
}

impl Images<'_> {
    fn pair(&self, part: u32) -> Option<(&Lamp, &Face)> {
        let &[lamp, face] = self.pairs.get(part as usize)?;
        Some((self.lamps.get(lamp as usize)?, self.mirrors.faces().get(face as usize)?))
    }

    fn look(&self, part: u32, at: DVec2) -> Option<Seen> {
        let (lamp, face) = self.pair(part)?;
        let (position, normal) = self.mirrors.place(face, at)?;
        let direction = (position - self.receiver.point).try_normalize()?;
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        let cos = direction.dot(self.receiver.normal);
        let (rim, side) = lamp.border(position, mirrored);
        let (border, branch) = if cos < rim { (cos, HORIZON) } else { (rim, side) };
        Some(Seen { at, border, branch, direction, mirrored, position, cos })
    }
}

impl Region for Images<'_> {
    type Seen = Seen;

    fn see(&self, part: u32, at: DVec2) -> Seen {
        self.look(part, at).unwrap_or(Seen {
            at,
            border: f64::NEG_INFINITY,
            branch: HORIZON,
            direction: DVec3::ZERO,
            mirrored: DVec3::ZERO,
            position: DVec3::ZERO,
            cos: 0.0,
        })
    }

    fn border(seen: &Seen) -> f64 {
        seen.border
    }

    fn branch(seen: &Seen) -> u32 {
        seen.branch
    }

    /// Lux per unit of the parameters.
    fn value(&self, part: u32, seen: &Seen) -> Option<f64> {
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
        Some(luminance * seen.cos * cos_at_mirror * point.stretch / squared)
    }
}
