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

mod cells;
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
mod shadow;
mod tree;

#[cfg(test)]
mod shadow_tests;
#[cfg(test)]
mod tests;

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::rounding::{gamma, offset_origin};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{Light, LightId, PlacedSurface, Scene};
use rayon::prelude::*;

pub use self::cells::{CellTolerance, integrated_maps};
pub use self::error::IntegrateError;
pub use self::mean::CellMean;
pub use self::region::Tolerance;

use crate::receiver::{Receiver, Receivers};

use self::contour::ReceivingPoint;
use self::emitter_shape::EmitterShape;
use self::image::Images;
use self::mirror::Mirrors;
use self::region::{RegionIntegral, integrate_counting};
use self::tree::MirrorTree;

/// Largest number of rectangles of mirrors for one point.
const BUDGET: usize = 8192;
/// Most work of an integration over cells that takes less time than random methods: shadow rays per point of all cells, rectangles of mirrors per point, and per point of all
/// cells; and the number of points that are tried.
const MOST_RAYS: usize = 3_000_000;
const MIRROR_EFFORT: usize = 64;
const MOST_RECTANGLES: usize = 5_000;
const MIRROR_PROBES: usize = 64;
/// Rounding errors in the coordinates of a point that was computed on a surface.
const ROUNDINGS: u32 = 256;

/// The emitters and mirrors of a scene.
#[derive(Debug)]
pub struct Reflections<'a> {
    scene: &'a Scene,
    wavelengths: Wavelengths,
    emitters: Vec<EmitterShape>,
    /// The lights that they are.
    emitter_lights: Vec<LightId>,
    /// Lights without extent.
    points: Vec<(LightId, Light)>,
    mirrors: Mirrors<'a>,
    tree: MirrorTree,
    /// Whether light is integrated where something hides a part of an emitter; otherwise it is not known there.
    integrates_shadows: bool,
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
        let (reflections, refused) = Self::of_integrable(scene);
        if let Some(error) = refused {
            return Err(error);
        }
        if reflections.emitters.is_empty() && reflections.points.is_empty() {
            return Err(IntegrateError::NoLight);
        }
        Ok(reflections)
    }

    /// As [`Reflections::new`], without the lights that cannot be integrated; the error of the first of these.
    #[must_use]
    pub fn of_integrable(scene: &'a Scene) -> (Self, Option<IntegrateError>) {
        let placed = scene.placed_surfaces();
        let (mut emitters, mut emitter_lights, mut points) = (Vec::new(), Vec::new(), Vec::new());
        let mut refused = None;
        for (id, light) in (0..).map(LightId).zip(scene.lights()) {
            match integrable(id, light, &placed) {
                Ok(Integrable::Nothing) => {}
                Ok(Integrable::Point) => points.push((id, light.clone())),
                Ok(Integrable::Emitter(shape)) => {
                    emitters.push(shape);
                    emitter_lights.push(id);
                }
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        let mirrors = Mirrors::of(scene);
        let tree = MirrorTree::over(&mirrors);
        let wavelengths = Wavelengths::default();
        let integrates_shadows = true;
        let reflections =
            Self { scene, wavelengths, emitters, emitter_lights, points, mirrors, tree, integrates_shadows };
        (reflections, refused)
    }

    /// Whether there are mirrors whose light is included.
    #[must_use]
    pub fn has_mirrors(&self) -> bool {
        !self.mirrors.faces().is_empty()
    }

    /// Whether direct light of the light `id` is included.
    pub(crate) fn integrates(&self, id: LightId) -> bool {
        self.emitter_lights.binary_search(&id).is_ok() || self.points.iter().any(|(point, _)| *point == id)
    }

    /// Whether light of the light `id` after one reflection in a face is included.
    pub(crate) fn integrates_mirrored(&self, id: LightId, surface: u32, face: u32) -> bool {
        self.emitter_lights.binary_search(&id).is_ok() && self.mirrors.contains(surface, face)
    }

    /// Lights without extent, whose reflections in mirrors are left out; empty if there is no mirror.
    pub fn unreflected(&self) -> impl Iterator<Item = LightId> + '_ {
        self.points.iter().map(|(id, _)| *id).filter(|_| self.has_mirrors())
    }

    /// Illuminance at `point` (metres, on a surface or free) of a surface with the unit normal `normal`, to a `tolerance` of the sum of both parts.
    ///
    /// The error is estimated: every rule is compared with a coarser one. Occluders smaller than an eighth of an emitter
    /// as seen from the point, or a third of a rectangle of the integration, may be missed.
    #[must_use]
    pub fn illuminance(&self, point: DVec3, normal: DVec3, tolerance: Tolerance) -> IlluminanceEstimate {
        let budget = if self.integrates_shadows { direct::BUDGET } else { 0 };
        self.with_shadows(point, normal, tolerance, budget, &[]).0
    }

    /// As [`Reflections::illuminance`], without direct light of the sources `left_out`, and with the number of an emitter of which
    /// something hides a part and that takes more than `shadow_budget` rectangles: half of its light counts, with all of it as the error.
    fn with_shadows(
        &self,
        point: DVec3,
        normal: DVec3,
        tolerance: Tolerance,
        shadow_budget: usize,
        left_out: &[usize],
    ) -> (IlluminanceEstimate, Option<usize>) {
        let (receiver, origin) = self.receiving(point, normal);
        let (direct, shadow) = self.direct(receiver, origin, tolerance, shadow_budget, left_out);
        // What is not known in one part is not computed exactly in the other.
        let budget = if shadow.is_some() { 0 } else { BUDGET };
        let (reflected, _) = self.reflected(receiver, origin, direct, tolerance, budget);
        let error = direct.error + reflected.error;
        (IlluminanceEstimate { direct: direct.value, reflected: reflected.value, error }, shadow)
    }

    /// A point, and where shadow rays from there start.
    fn receiving(&self, point: DVec3, normal: DVec3) -> (ReceivingPoint, DVec3) {
        let origin = offset_origin(point, position_error(self.scene, point), normal, normal);
        (ReceivingPoint { point, normal }, origin)
    }

    /// Leaves out lights, or the light of mirrors, whose integration over the cells of `receivers` takes more work than random methods need for errors of 1 %:
    /// emitters where something hides a part of them; curved mirrors; more than three million shadow rays per point of all squares of the cells; 64 rectangles of mirrors per point in the middles of some cells, or 5000 in all
    /// cells. By the threads of the current pool.
    #[must_use]
    pub fn without_costly(mut self, receivers: &Receivers, tolerance: Tolerance) -> Self {
        let all = receivers.as_slice().iter();
        let cells: Vec<_> =
            all.flat_map(|receiver| (0..receiver.len()).map(move |cell| (receiver, cell))).collect();
        let cells: Vec<_> =
            cells.into_iter().filter(|(receiver, cell)| receiver.areas()[*cell] > 0.0).collect();
        let placed = self.scene.placed_surfaces();
        // Half shadows converge slowly, and their borders are rays that touch surfaces, which cost most.
        self.integrates_shadows = false;
        let squares = |reflections: &Self| -> usize {
            let count = |&(receiver, cell): &(&Receiver, usize)| {
                let surface = placed.get(receiver.surface() as usize)?;
                Some(reflections.around_lights(&cells::patch(receiver, surface, cell)).len())
            };
            cells.par_iter().filter_map(count).sum()
        };
        if !self.points.is_empty() && self.points.len() * squares(&self) > MOST_RAYS {
            self.points.clear();
        }
        if direct::RAYS * self.emitters.len() * squares(&self) > MOST_RAYS {
            (self.emitters, self.emitter_lights) = (Vec::new(), Vec::new());
        }
        // The search for images in curved mirrors alone takes as long as particles.
        if !self.mirrors.are_flat() {
            return self.without_mirrors();
        }
        let probes = cells.iter().step_by(cells.len().div_ceil(MIRROR_PROBES).max(1));
        let effort = |&(receiver, cell): &(&Receiver, usize)| {
            let surface = placed.get(receiver.surface() as usize)?;
            let at = receiver.place(surface, cell, DVec2::splat(0.5))?;
            let (receiver, origin) = self.receiving(at.position, at.normal);
            let (direct, shadow) = self.direct(receiver, origin, tolerance, 0, &[]);
            // Points in half shadows are not integrated exactly.
            let budget = if shadow.is_some() { 0 } else { 4 * MIRROR_EFFORT };
            Some(self.reflected(receiver, origin, direct, tolerance, budget).1)
        };
        let efforts: Vec<usize> = probes.collect::<Vec<_>>().into_par_iter().filter_map(effort).collect();
        let effort = efforts.iter().sum::<usize>() / efforts.len().max(1);
        if effort > MIRROR_EFFORT || effort * cells.len() > MOST_RECTANGLES {
            self.without_mirrors()
        } else {
            self
        }
    }

    /// Leaves out the light of mirrors.
    #[must_use]
    pub fn without_mirrors(mut self) -> Self {
        self.mirrors = self.mirrors.none();
        self.tree = MirrorTree::over(&self.mirrors);
        self
    }

    /// Direct light of all sources but those `left_out`, and the number of an emitter of which something hides a part, if there is no `shadow_budget`.
    fn direct(
        &self,
        receiver: ReceivingPoint,
        origin: DVec3,
        tolerance: Tolerance,
        shadow_budget: usize,
        left_out: &[usize],
    ) -> (RegionIntegral, Option<usize>) {
        let mut sum = RegionIntegral::default();
        let mut shadow = None;
        let sources = |first: usize| move |number: &usize| !left_out.contains(&(first + number));
        for (number, emitter) in self.emitters.iter().enumerate().filter(|(number, _)| sources(0)(number)) {
            let luminance = photometric(emitter.radiance, &self.wavelengths);
            let share = Tolerance {
                relative: 0.5 * tolerance.relative,
                absolute: 0.5 * tolerance.absolute / (luminance * self.emitters.len() as f64),
            };
            let seen = direct::of_emitter(self.scene, receiver, origin, emitter, share, shadow_budget);
            let seen = seen.unwrap_or_else(|whole| {
                shadow = Some(number);
                RegionIntegral { value: 0.5 * whole, error: whole }
            });
            sum.value += luminance * seen.value;
            sum.error += luminance * seen.error;
        }
        let first = self.emitters.len();
        for (_, (_, light)) in self.points.iter().enumerate().filter(|(number, _)| sources(first)(number)) {
            sum.value += direct::of_point(self.scene, receiver, origin, light, &self.wavelengths);
        }
        (sum, shadow)
    }

    /// Light of the mirrors, and the number of rectangles of mirrors that it took.
    fn reflected(
        &self,
        receiver: ReceivingPoint,
        origin: DVec3,
        direct: RegionIntegral,
        tolerance: Tolerance,
        budget: usize,
    ) -> (RegionIntegral, usize) {
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
            return (RegionIntegral { value: 0.0, error: undecided }, 0);
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
        let (sum, rectangles) = integrate_counting(&images, cells, known, tolerance, budget);
        (RegionIntegral { value: sum.value, error: sum.error + undecided }, rectangles)
    }
}

/// Bound per axis on the rounding errors of a point that was computed on a surface, metres.
pub(crate) fn position_error(scene: &Scene, point: DVec3) -> DVec3 {
    let bounds = scene.bounds();
    let size = if bounds.is_finite() { bounds.min.abs().max(bounds.max.abs()) } else { DVec3::ZERO };
    // A scene may be flat along an axis; the others have errors in its plane all the same.
    gamma(ROUNDINGS) * DVec3::splat(point.abs().max(size).max_element())
}

/// Position of a light without extent; `None` if it is infinitely far away.
fn light_position(light: &Light) -> Option<DVec3> {
    let incident =
        [DVec3::ZERO, DVec3::ONE].into_iter().find_map(|point| Some((point, light.incident(point)?)));
    let (point, incident) = incident?;
    incident.distance.is_finite().then(|| point + incident.distance * incident.towards)
}

/// How a light is integrated.
enum Integrable {
    /// It is black, or has no surface.
    Nothing,
    /// As a light without extent.
    Point,
    Emitter(EmitterShape),
}

fn integrable(
    id: LightId,
    light: &Light,
    placed: &[PlacedSurface<'_>],
) -> Result<Integrable, IntegrateError> {
    let refused = |kind| Err(IntegrateError::Kind { light: id, kind });
    match light {
        Light::Area(area) if area.radiance().is_black() => Ok(Integrable::Nothing),
        Light::Area(area) if !area.is_opaque() => refused("diffuse with alpha"),
        Light::Area(area) if area.has_picture() => refused("diffuse with a picture"),
        Light::Area(area) => match placed.iter().find(|placed| placed.light() == Some(id)) {
            Some(placed) => EmitterShape::try_new(id, area, placed).map(Integrable::Emitter),
            None => Ok(Integrable::Nothing),
        },
        Light::Point(_)
        | Light::Spot(_)
        | Light::Projection(_)
        | Light::Goniometric(_)
        | Light::Distant(_) => Ok(Integrable::Point),
        Light::Photometric(luminaire) if luminaire.is_point() => Ok(Integrable::Point),
        other => refused(other.kind()),
    }
}
