//! Deterministic illuminance: direct light of emitters, and their light after one reflection in a mirror.
//!
//! The illuminance of a point Q with normal N by an emitter after reflection in a mirror is
//!
//! ```text
//! E = integral over (u, v) of  rho L cos(N, QP) cos(n, QP) / |QP|^2 |P_u x P_v|  du dv,
//! ```
//!
//! where P(u, v) is the mirror, n its unit normal, and rho(P, angle) its reflectance; the integrand counts where the ray from Q to P, mirrored at n,
//! hits the emitter on an emitting side, with radiance L, and nothing occludes either segment of the path. The integral extends over the image of the emitter in the
//! mirror, in the parameters of the mirror: rays are intersected with the mirror for shadows only. `MirrorTree` finds the parts of the
//! mirrors that may contain the image; `region` integrates over it with the zeros of a border function as its borders (`EmitterShape::border`: for a
//! sphere 1 - b^2 / R^2, with the least distance b of the mirrored ray from the centre).
//!
//! # Source
//! @pumberger2010 section 4.4, which sketches this integral over the patch, with the following differences. (4.19) there takes the light at a point Q of the mirror from
//! one ray to the spherical emitter with centre M: (4.14) to (4.18) solve the triangle of M, Q and the point where the ray hits the sphere. Our border function
//! uses the same triangle: b = |M - Q| sin(alpha).
//! - A ray misses the sphere if sin(alpha) > R / |M - Q|, not tan(alpha): tangents touch it where sin(alpha) = R / |M - Q|.
//! - (4.15) and (4.16) have a wrong sign: sin(alpha + epsilon) = |M - Q| sin(alpha) / R.
//! - (4.19) lacks the two cosines (foreshortening at mirror and receiver), the area element |P_u x P_v|, and the reflectance. It divides by
//!   the squared distance from the mirror to the emitter; but radiance is constant along a ray, and the distance from the mirror to the receiver
//!   is the relevant one.
//! - The angles kappa and lambda of the direction need the quadrant (acos and atan2), relative to M. Emitters of uniform radiance need no angles.
//!
//! Where parameters degenerate, as at the pole of a sphere, the search may give up on parts of tiny images for lack of bounds; the error then includes their largest
//! possible contribution. Light through glass is not included: glass casts shadows, and its reflections count. Point lights have no image
//! ([`Reflections::unreflected`]).

mod contour;
mod crossing;
mod direct;
mod emitter_shape;
mod error;
mod extent;
mod image;
mod mean;
mod mirror;
mod net;
mod polygon;
mod queue;
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
use self::emitter_shape::EmitterShape;
use self::image::Images;
use self::mirror::Mirrors;
use self::region::{RegionIntegral, integrate};
use self::tree::MirrorTree;

/// Largest number of rectangles of mirrors for one point.
const BUDGET: usize = 8192;
/// Rounding errors in the coordinates of a point that was computed on a surface.
const ROUNDINGS: u32 = 256;

/// The emitters and mirrors of a scene.
#[derive(Debug)]
pub struct Reflections<'a> {
    scene: &'a Scene,
    wavelengths: Wavelengths,
    emitters: Vec<EmitterShape>,
    /// Lights without extent.
    points: Vec<(LightId, Light)>,
    mirrors: Mirrors<'a>,
    tree: MirrorTree,
}

/// Illuminance at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IlluminanceEstimate {
    /// Direct illuminance, lx.
    pub direct: f64,
    /// Illuminance after one reflection in a mirror, lx.
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
    /// Collects the emitters and the mirrors, with a hierarchy over the mirrors.
    ///
    /// # Errors
    /// [`IntegrateError`] if the scene has no light, or a light that is not black has no form that can be integrated.
    pub fn new(scene: &'a Scene) -> Result<Self, IntegrateError> {
        let placed = scene.placed_surfaces();
        let (mut emitters, mut points) = (Vec::new(), Vec::new());
        for (id, light) in (0..).map(LightId).zip(scene.lights()) {
            match light {
                Light::Area(area) if area.radiance().is_black() => {}
                Light::Area(area) if !area.is_opaque() => {
                    return Err(IntegrateError::Kind { light: id, kind: "diffuse with alpha" });
                }
                Light::Area(area) if area.has_picture() => {
                    return Err(IntegrateError::Kind { light: id, kind: "diffuse with a picture" });
                }
                Light::Area(area) => {
                    if let Some(placed) = placed.iter().find(|placed| placed.light() == Some(id)) {
                        emitters.push(EmitterShape::try_new(id, area, placed)?);
                    }
                }
                Light::Point(_)
                | Light::Spot(_)
                | Light::Projection(_)
                | Light::Goniometric(_)
                | Light::Distant(_) => points.push((id, light.clone())),
                Light::Photometric(luminaire) if luminaire.is_point() => points.push((id, light.clone())),
                other => return Err(IntegrateError::Kind { light: id, kind: other.kind() }),
            }
        }
        if emitters.is_empty() && points.is_empty() {
            return Err(IntegrateError::NoLight);
        }
        let mirrors = Mirrors::of(scene);
        let tree = MirrorTree::over(&mirrors);
        Ok(Self { scene, wavelengths: Wavelengths::default(), emitters, points, mirrors, tree })
    }

    /// Lights without extent, whose reflections in mirrors are left out; empty if there is no mirror.
    pub fn unreflected(&self) -> impl Iterator<Item = LightId> + '_ {
        let has_mirror = !self.mirrors.faces().is_empty();
        self.points.iter().map(|(id, _)| *id).filter(move |_| has_mirror)
    }

    /// Illuminance at `point` (metres, on a surface or free) of a surface with the unit normal `normal`, to a `tolerance` of the sum of both parts.
    ///
    /// The error is estimated: every rule is compared with a coarser one. Occluders smaller than an eighth of an emitter
    /// as seen from the point, or a third of a rectangle of the integration, may be missed.
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
        for emitter in &self.emitters {
            let luminance = photometric(emitter.radiance, &self.wavelengths);
            let share = Tolerance {
                relative: 0.5 * tolerance.relative,
                absolute: 0.5 * tolerance.absolute / (luminance * self.emitters.len() as f64),
            };
            let seen = direct::of_emitter(self.scene, receiver, origin, emitter, share);
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
        for (number, emitter) in (0_u32..).zip(&self.emitters) {
            let found = self.tree.showing(&self.mirrors, &receiver, emitter);
            undecided += found.undecided * photometric(emitter.radiance, &self.wavelengths);
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
            emitters: &self.emitters,
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
