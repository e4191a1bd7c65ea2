//! Illuminance without chance: lamps seen directly, and once by way of mirrors.
//!
//! A place Q with normal N is lit by a lamp by way of a mirror with
//!
//! ```text
//! E = integral over (u, v) of  rho L cos(N, QP) cos(n, QP) / |QP|^2 |P_u x P_v|  du dv,
//! ```
//!
//! where P(u, v) is the mirror, n its unit normal, and rho(P, angle) its reflectance; the integrand counts where the ray from Q to P, mirrored at n,
//! meets the lamp on a side that shines, with radiance L, and nothing stands in either part of the way. So the image of the lamp in the mirror is integrated
//! over, in the parameters of the mirror: no ray has to be intersected with it but for shadows. `MirrorTree` finds the parts of the
//! mirrors that can hold the image; `region` integrates over it with the zeros of a border function as its borders (`EmitterShape::border`: for a
//! sphere 1 - b^2 / R^2, with the least distance b of the mirrored ray from the centre).
//!
//! # Source
//! @pumberger2010 section 4.4, which sketches this integral over the patch, with these differences. There (4.19) takes the light at a place Q of the mirror from
//! one ray to the spherical lamp with centre M: (4.14) to (4.18) solve the triangle M, Q and the place where the ray meets the sphere. Our border function
//! asks for the same triangle: b = |M - Q| sin(alpha).
//! - A ray passes by the sphere if sin(alpha) > R / |M - Q|, not tan(alpha): tangents touch it where sin(alpha) = R / |M - Q|.
//! - (4.15) and (4.16) have a wrong sign: sin(alpha + epsilon) = |M - Q| sin(alpha) / R.
//! - (4.19) lacks the two cosines (foreshortening at mirror and receiver), the area element |P_u x P_v|, and the reflectance; and it multiplies with
//!   the squared reciprocal of the way from the mirror to the lamp, where radiance stays the same along a ray and the way from the mirror to the receiver
//!   counts.
//! - The angles kappa and lambda of the direction need the quadrant (acos and atan2), relative to M. For lamps of uniform radiance none is needed.
//!
//! Where parameters degenerate, at the pole of a ball, parts of tiny images may be given up for want of bounds: the error then holds all that they could
//! show. What glass lets pass is not looked for; glass casts shadows, and what it reflects counts. Points that shine have no image
//! ([`Reflections::unreflected`]).

mod contour;
mod crossing;
mod direct;
mod error;
mod extent;
mod image;
mod lamp;
mod mean;
mod mirror;
mod net;
mod polygon;
mod region;
mod rule;
mod tree;

#[cfg(test)]
mod tests;

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::DVec3;
use glanz_math::rounding::{gamma, offset_origin};
use glanz_scene::{Light, LightId, Scene};

pub use self::error::IntegrateError;
pub use self::mean::CellMean;
pub use self::region::Tolerance;

use self::contour::ReceivingPoint;
use self::image::Images;
use self::lamp::EmitterShape;
use self::mirror::Mirrors;
use self::region::{RegionIntegral, integrate};
use self::tree::MirrorTree;

/// Rectangles of mirrors that are looked at for one place.
const BUDGET: usize = 8192;
/// Roundings in the coordinates of a place that somebody computed on a surface.
const ROUNDINGS: u32 = 256;

/// The lamps and mirrors of a scene.
#[derive(Debug)]
pub struct Reflections<'a> {
    scene: &'a Scene,
    wavelengths: Wavelengths,
    lamps: Vec<EmitterShape>,
    /// Lights without extent.
    points: Vec<(LightId, Light)>,
    mirrors: Mirrors<'a>,
    tree: MirrorTree,
}

/// Illuminance at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlluminanceEstimate {
    /// From lamps seen directly, lx.
    pub direct: f64,
    /// From lamps seen once in a mirror, lx.
    pub reflected: f64,
    /// Estimated bound on the error of the sum, lx.
    pub error: f64,
}

impl IlluminanceEstimate {
    /// Illuminance, lx.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.direct + self.reflected
    }
}

impl<'a> Reflections<'a> {
    /// Collects the lamps and the mirrors, and what is known of the mirrors for every place.
    ///
    /// # Errors
    /// [`IntegrateError`] if nothing shines, or a light that is not black has no form that can be integrated.
    pub fn new(scene: &'a Scene) -> Result<Self, IntegrateError> {
        let placed = scene.placed_surfaces();
        let (mut lamps, mut points) = (Vec::new(), Vec::new());
        for (id, light) in (0..).map(LightId).zip(scene.lights()) {
            match light {
                Light::Area(area) if area.radiance().is_black() => {}
                Light::Area(area) => {
                    if let Some(placed) = placed.iter().find(|placed| placed.light() == Some(id)) {
                        lamps.push(EmitterShape::try_new(id, area, placed)?);
                    }
                }
                Light::Point(_) | Light::Spot(_) | Light::Distant(_) => points.push((id, light.clone())),
                Light::Photometric(luminaire) if luminaire.is_point() => points.push((id, light.clone())),
                other => return Err(IntegrateError::Kind { light: id, kind: other.kind() }),
            }
        }
        if lamps.is_empty() && points.is_empty() {
            return Err(IntegrateError::NoLamp);
        }
        let mirrors = Mirrors::of(scene);
        let tree = MirrorTree::over(&mirrors);
        Ok(Self { scene, wavelengths: Wavelengths::default(), lamps, points, mirrors, tree })
    }

    /// Lights whose light by way of mirrors is left out, since they have no extent: empty where there is no mirror.
    pub fn unreflected(&self) -> impl Iterator<Item = LightId> + '_ {
        let has_mirror = !self.mirrors.faces().is_empty();
        self.points.iter().map(|(id, _)| *id).filter(move |_| has_mirror)
    }

    /// Illuminance at `point` (metres, on a surface or free) of a surface with the unit normal `normal`, to a `tolerance` of the sum of both parts.
    ///
    /// The error is estimated: every rule is compared with a coarser one. Things in the way that are smaller than an eighth of a lamp
    /// as seen from there, or a third of a rectangle that is integrated over, may be missed.
    #[must_use]
    pub fn illuminance(&self, point: DVec3, normal: DVec3, tolerance: Tolerance) -> IlluminanceEstimate {
        let receiver = ReceivingPoint { point, normal };
        let bounds = self.scene.bounds();
        let size = if bounds.is_finite() { bounds.min.abs().max(bounds.max.abs()) } else { DVec3::ZERO };
        let origin = offset_origin(point, gamma(ROUNDINGS) * point.abs().max(size), normal, normal);
        let direct = self.direct(receiver, origin, tolerance);
        let reflected = self.reflected(receiver, origin, direct, tolerance);
        IlluminanceEstimate {
            direct: direct.value,
            reflected: reflected.value,
            error: direct.error + reflected.error,
        }
    }

    fn direct(&self, receiver: ReceivingPoint, origin: DVec3, tolerance: Tolerance) -> RegionIntegral {
        let mut sum = RegionIntegral::default();
        for lamp in &self.lamps {
            let luminance = photometric(lamp.radiance, &self.wavelengths);
            let share = Tolerance {
                relative: 0.5 * tolerance.relative,
                absolute: 0.5 * tolerance.absolute / (luminance * self.lamps.len() as f64),
            };
            let seen = direct::of_lamp(self.scene, receiver, origin, lamp, share);
            sum.value += luminance * seen.value;
            sum.error += luminance * seen.error;
        }
        for (_, light) in &self.points {
            sum.value += direct::of_point(self.scene, receiver, origin, light, &self.wavelengths);
        }
        sum
    }

    fn reflected(
        &self,
        receiver: ReceivingPoint,
        origin: DVec3,
        direct: RegionIntegral,
        tolerance: Tolerance,
    ) -> RegionIntegral {
        let (mut pairs, mut cells, mut undecided) = (Vec::new(), Vec::new(), 0.0);
        for (number, lamp) in (0_u32..).zip(&self.lamps) {
            let found = self.tree.showing(&self.mirrors, &receiver, lamp);
            undecided += found.undecided * photometric(lamp.radiance, &self.wavelengths);
            for (face, rect) in found.cells {
                let pair = [number, face];
                if pairs.last() != Some(&pair) {
                    pairs.push(pair);
                }
                cells.push((pairs.len() as u32 - 1, rect));
            }
        }
        if cells.is_empty() {
            return RegionIntegral { value: 0.0, error: undecided };
        }
        let images = Images {
            scene: self.scene,
            mirrors: &self.mirrors,
            lamps: &self.lamps,
            wavelengths: self.wavelengths,
            receiver,
            origin,
            pairs,
        };
        let known = RegionIntegral { value: direct.value, error: direct.error + undecided };
        let sum = integrate(&images, cells, known, tolerance, BUDGET);
        RegionIntegral { value: sum.value, error: sum.error + undecided }
    }
}
