//! Illuminance at a point in space: on a plane, of a cylinder, of half a cylinder.
//!
//! Each is an integral of the luminance L over the directions with a response: E = int L f d omega, and I f / r^2 from a point source of the intensity I at the distance r.
//!
//! | receiver | response f to a unit direction w |
//! |---|---|
//! | plane of normal n | max(w n, 0) |
//! | small upright cylinder | sin a / pi, with the angle a of w from the vertical |
//! | its half that faces the horizontal direction n | (sin a + w n) / pi |
//!
//! so that even light of luminance L from all sides gives pi L on each. Cylindrical illuminance is the mean of the illuminances on vertical planes of all
//! azimuths; the semi-cylindrical one is the usual (1 + cos b) sin a / pi with the azimuth b from n.
//!
//! # Source
//! Definitions: @en12665. Cylindrical illuminance at 1.2 m (seated) and 1.6 m (standing) above the floor, and the ratio of cylindrical to
//! horizontal illuminance as the indicator of modelling: EN 12464-1 (@en12464), by open summaries.

use std::f64::consts::PI;

use glanz_job::{CancelFlag, Interrupted};
use glanz_light::units::photometric;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Frame, Ray};
use glanz_sampling::{PixelSampler, SamplerKind, warp};
use glanz_scene::description::IntegratorDescription;
use glanz_scene::{CameraRay, Light, LightId, PlacedSurface, Scene};
use glanz_transport::integrator::{
    Context, ContextOptions, Integrator, IntegratorError, IntegratorSettings, Path,
};

use super::glare::GlareObserver;
use crate::replicates::{REPLICATES, ReplicateEstimate, of_replicates};

/// Values of [`PointReceiver::Cylinder`] over [`PointReceiver::Plane`] upwards that EN 12464-1 names as an indicator of good modelling under even lighting.
pub const GOOD_MODELLING: [f64; 2] = [0.3, 0.6];

/// Paths that are traced together at most.
const BATCH: usize = 1 << 10;

/// Largest number of scattering events of a path.
const MAX_DEPTH: u32 = 100;

/// A small receiver at a point in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointReceiver {
    /// A plane with this unit normal.
    Plane(DVec3),
    /// An upright cylinder.
    Cylinder,
    /// The half of an upright cylinder that faces this horizontal unit direction.
    HalfCylinder(DVec3),
}

impl PointReceiver {
    /// Response to light from a unit direction, see the module's documentation.
    #[must_use]
    pub fn response(self, towards: DVec3) -> f64 {
        let sine = towards.x.hypot(towards.y);
        match self {
            Self::Plane(normal) => towards.dot(normal).max(0.0),
            Self::Cylinder => sine / PI,
            Self::HalfCylinder(normal) => ((sine + towards.dot(normal)) / PI).max(0.0),
        }
    }
}

impl PointReceiver {
    /// A unit direction by two numbers uniform in [0, 1), and the response over its density, sr.
    fn sample(self, xi: DVec2) -> (DVec3, f64) {
        match self {
            Self::Plane(normal) => (Frame::from_z(normal).to_world(warp::cosine_hemisphere(xi)), PI),
            Self::Cylinder | Self::HalfCylinder(_) => {
                let towards = warp::uniform_sphere(xi);
                (towards, 4.0 * PI * self.response(towards))
            }
        }
    }
}

/// Illuminance at a point in space by the origin of the light, lx.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointIlluminance {
    /// Straight from lights that are points, photometric ones included: as if all their light left their centres.
    pub direct: f64,
    /// Straight from surfaces that emit.
    pub emitted: ReplicateEstimate,
    /// From all other surfaces and from beyond the scene.
    pub reflected: ReplicateEstimate,
}

impl PointIlluminance {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> ReplicateEstimate {
        let (a, b) = (self.emitted, self.reflected);
        // Both are of the same paths: intervals add up.
        let interval = [0, 1].map(|end| a.interval[end] + b.interval[end]);
        ReplicateEstimate { value: a.value + b.value, error: a.error + b.error, interval }.plus(self.direct)
    }
}

/// A sphere around a luminous surface.
struct Emitter {
    light: LightId,
    center: DVec3,
    radius: f64,
}

impl Emitter {
    /// Those of a scene; unbounded surfaces are none.
    fn of_scene(scene: &Scene) -> Vec<Self> {
        if !scene.lights().iter().any(|light| matches!(light, Light::Area(_))) {
            return Vec::new();
        }
        let emitter = |surface: &PlacedSurface<'_>| {
            let (light, bounds) = (surface.light()?, surface.bounds());
            let (center, radius) = (0.5 * (bounds.min + bounds.max), 0.5 * bounds.min.distance(bounds.max));
            radius.is_finite().then_some(Self { light, center, radius })
        };
        scene.placed_surfaces().iter().filter_map(emitter).collect()
    }
}

/// Illuminance at points of a scene: direct light of points in closed form, all other light by paths in random directions.
pub struct PointGather<'a> {
    scene: &'a Scene,
    emitters: Vec<Emitter>,
    paths: Path,
    /// Number of directions in each of the replicates.
    directions: u32,
    seed: u64,
}

impl<'a> PointGather<'a> {
    /// `directions`: number of directions from each point, at least 16; their error falls with its square root.
    ///
    /// # Errors
    /// None today; those of the settings of the path tracer.
    pub fn try_new(scene: &'a Scene, directions: u32, seed: u64) -> Result<Self, IntegratorError> {
        let description = IntegratorDescription {
            name: "path".to_owned(),
            max_depth: Some(MAX_DEPTH),
            ..IntegratorDescription::default()
        };
        let paths = Path::new(&IntegratorSettings::resolve(&description)?);
        let emitters = Emitter::of_scene(scene);
        Ok(Self { scene, emitters, paths, directions: directions.div_ceil(REPLICATES as u32).max(1), seed })
    }

    /// The illuminance of a receiver at `point`, which differs in `number` from other points of the same seed.
    ///
    /// # Errors
    /// [`Interrupted`] if `cancel` is raised.
    pub fn illuminance(
        &self,
        point: DVec3,
        receiver: PointReceiver,
        number: u32,
        cancel: &CancelFlag,
    ) -> Result<PointIlluminance, Interrupted> {
        let (mut emitted, mut reflected) = ([0.0; REPLICATES], [0.0; REPLICATES]);
        for replicate in 0..REPLICATES {
            cancel.check()?;
            let sums = self.replicate(point, receiver, [number, replicate as u32]);
            [emitted[replicate], reflected[replicate]] = sums.map(|sum| sum / f64::from(self.directions));
        }
        Ok(PointIlluminance {
            direct: self.direct(point, receiver),
            emitted: of_replicates(&emitted),
            reflected: of_replicates(&reflected),
        })
    }

    /// Sum of L^2 omega / p^2 over the parts of luminous surfaces that an observer sees and whose position index counts, cd^2 / m^4 sr; 0 for scenes without them.
    ///
    /// It is the integral of L^2 / p^2 over directions, by rays into the cone around each surface, as many as directions of illuminances.
    ///
    /// # Errors
    /// [`Interrupted`] if `cancel` is raised.
    pub fn emitted_glare(
        &self,
        observer: &GlareObserver,
        number: u32,
        cancel: &CancelFlag,
    ) -> Result<ReplicateEstimate, Interrupted> {
        let mut means = [0.0; REPLICATES];
        for (replicate, mean) in (0..).zip(&mut means) {
            cancel.check()?;
            for emitter in &self.emitters {
                *mean += self.glare_of_emitter(emitter, observer, [number, replicate]);
            }
        }
        Ok(if self.emitters.is_empty() { ReplicateEstimate::default() } else { of_replicates(&means) })
    }

    /// The part of a luminous surface, by one replicate.
    fn glare_of_emitter(&self, emitter: &Emitter, observer: &GlareObserver, pixel: [u32; 2]) -> f64 {
        let offset = emitter.center - observer.eye();
        let sine = emitter.radius / offset.length();
        // Around an eye within the sphere it may be anywhere; what is behind the observer does not count.
        let one_minus_cos = if sine < 1.0 { warp::one_minus_cos(sine * sine) } else { 1.0 };
        let frame = Frame::from_z(if sine < 1.0 { offset.normalize() } else { observer.view() });
        let mut sum = 0.0;
        for index in 0..self.directions {
            let sampler = PixelSampler::new(SamplerKind::Sobol, self.directions, self.seed, pixel, index);
            let towards = frame.to_world(warp::uniform_cone(sampler.pixel_2d(), one_minus_cos));
            let Some(position_index) = observer.position_index(towards) else { continue };
            let hit = self.scene.intersect(&Ray::new(observer.eye(), towards), f64::INFINITY);
            let Some(hit) = hit.filter(|hit| hit.light() == Some(emitter.light)) else { continue };
            sum += (lumens(self.scene.emitted(&hit, hit.wo)) / position_index).powi(2);
        }
        2.0 * PI * one_minus_cos * sum / f64::from(self.directions)
    }

    /// Whether nothing is between `point` and the point at a distance in a unit direction.
    #[must_use]
    pub fn is_free(&self, point: DVec3, towards: DVec3, distance: f64) -> bool {
        // A luminaire that is flush with a ceiling is not behind it.
        !self.scene.occluded(&Ray::new(point, towards), distance * (1.0 - 1e-6))
    }

    /// Direct light of points, lx.
    #[must_use]
    pub fn direct(&self, point: DVec3, receiver: PointReceiver) -> f64 {
        let light_of = |light: &Light| {
            let (towards, lux, distance) = match light {
                Light::Photometric(luminaire) => {
                    let offset = luminaire.center() - point;
                    let distance = offset.length();
                    let towards = offset / distance;
                    (towards, lumens(luminaire.intensity(-towards)) / (distance * distance), distance)
                }
                _ => {
                    let incident = light.incident(point)?;
                    (incident.towards, lumens(incident.irradiance), incident.distance)
                }
            };
            let lux = lux * receiver.response(towards);
            (lux > 0.0 && self.is_free(point, towards, distance)).then_some(lux)
        };
        self.scene.lights().iter().filter_map(light_of).sum()
    }

    /// Sums of emitted and of reflected light over the directions of a replicate.
    fn replicate(&self, point: DVec3, receiver: PointReceiver, pixel: [u32; 2]) -> [f64; 2] {
        let (mut emitted, mut reflected) = (0.0, 0.0);
        let mut weights = Vec::new();
        let mut contexts: Vec<Context<'_>> = Vec::new();
        let mut radiance = Vec::new();
        for index in 0..self.directions {
            let kind = SamplerKind::Sobol;
            let sampler = PixelSampler::new(kind, self.directions, self.seed, pixel, index);
            let (towards, weight) = receiver.sample(sampler.pixel_2d());
            if weight > 0.0 {
                let ray = Ray::new(point, towards);
                let camera = CameraRay { ray, weight: 1.0, differential: None };
                let mut context = Context::new(self.scene, Some(camera), sampler, ContextOptions::new(false));
                match emission(&mut context, &ray) {
                    Some(light) => emitted += weight * lumens(light),
                    None => {
                        weights.push(weight);
                        contexts.push(context);
                    }
                }
            }
            if contexts.len() == BATCH || index + 1 == self.directions {
                self.paths.radiance_batch(&mut contexts, &mut radiance);
                reflected += weights.iter().zip(&radiance).map(|(w, light)| w * lumens(*light)).sum::<f64>();
                weights.clear();
                contexts.clear();
            }
        }
        [emitted, reflected]
    }
}

/// Light that the first surface on the ray emits; `None` if it emits none.
fn emission(context: &mut Context<'_>, ray: &Ray) -> Option<Spectrum> {
    let (hit, _) = context.intersect_parametric(ray, None)?;
    let light = context.scene.emitted(&hit, hit.wo);
    (lumens(light) > 0.0).then_some(light)
}

/// Photometric value of light in RGB.
fn lumens(light: Spectrum) -> f64 {
    photometric(light, &Wavelengths::Rgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_light::units::LUMINOUS_EFFICACY;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};

    const CANDELA: f32 = (1.0 / LUMINOUS_EFFICACY) as f32;

    fn gathered(scene: &Scene, directions: u32, receiver: PointReceiver) -> PointIlluminance {
        let gather = PointGather::try_new(scene, directions, 1).unwrap();
        gather.illuminance(DVec3::new(0.0, 0.0, 1.2), receiver, 0, &CancelFlag::default()).unwrap()
    }

    #[test]
    fn point_source_has_its_closed_forms() {
        // 900 cd, 1.5 m to the side and 2 m above the point: r = 2.5 m, I / r^2 = 144 lx, sin a = 0.6.
        let at = DVec3::new(1.5, 0.0, 3.2);
        let light = LightDescription { scale: 900.0, ..LightDescription::point(at, CANDELA) };
        let (scene, _) = SceneBuilder::new().light(light).resolve().unwrap();
        for (receiver, lux) in [
            (PointReceiver::Plane(DVec3::Z), 144.0 * 0.8),
            (PointReceiver::Plane(DVec3::X), 144.0 * 0.6),
            (PointReceiver::Plane(DVec3::NEG_X), 0.0),
            (PointReceiver::Cylinder, 144.0 * 0.6 / PI),
            (PointReceiver::HalfCylinder(DVec3::X), 144.0 * 2.0 * 0.6 / PI),
            (PointReceiver::HalfCylinder(DVec3::Y), 144.0 * 0.6 / PI),
            (PointReceiver::HalfCylinder(DVec3::NEG_X), 0.0),
        ] {
            let found = gathered(&scene, 16, receiver);
            assert!((found.direct - lux).abs() < 1e-4, "{receiver:?}: {found:?}");
            assert_eq!((found.emitted.value, found.reflected.value), (0.0, 0.0));
        }
    }

    #[test]
    fn even_light_from_all_sides_is_pi_times_its_luminance_on_every_receiver() {
        let sky = LightDescription { scale: 100.0, ..LightDescription::infinite(CANDELA) };
        let (scene, _) = SceneBuilder::new().light(sky).resolve().unwrap();
        let receivers =
            [PointReceiver::Plane(DVec3::X), PointReceiver::Cylinder, PointReceiver::HalfCylinder(DVec3::Y)];
        for receiver in receivers {
            let found = gathered(&scene, 1 << 14, receiver).total();
            let off = (found.value - 100.0 * PI).abs();
            // On a plane no direction counts more than another: only rounding is left.
            assert!(off < 4.0 * found.error + 1e-3 && found.error < 0.5, "{receiver:?}: {found:?}");
        }
    }

    #[test]
    fn reflected_light_in_a_furnace_is_the_closed_form_and_excludes_what_shines() {
        // A sphere of radius 3 m with reflectance 0.5 around a point of 1000 cd in its middle: E = 4 pi I / (4 pi R^2) / (1 - rho), L = rho E / pi.
        let light = LightDescription { scale: 1000.0, ..LightDescription::point(DVec3::ZERO, CANDELA) };
        let wall = ShapeDescription::sphere(3.0).reversed();
        let builder = SceneBuilder::new().light(light).shape(wall, MaterialKind::diffuse(0.5));
        let (scene, _) = builder.resolve().unwrap();
        let expected = 0.5 * (1000.0 / 9.0) / (1.0 - 0.5);
        for receiver in [PointReceiver::Plane(DVec3::Z), PointReceiver::Cylinder] {
            let found = gathered(&scene, 1 << 12, receiver);
            let off = (found.reflected.value - expected).abs();
            assert!(off < 4.0 * found.reflected.error, "{receiver:?}: {found:?}");
            assert!(found.reflected.error < 0.02 * expected, "{receiver:?}: {found:?}");
            assert_eq!(found.emitted.value, 0.0);
        }
        // The lamp is straight below the eye: all of its light comes to the cylinder's end.
        assert_eq!(gathered(&scene, 16, PointReceiver::Cylinder).direct, 0.0);
    }

    #[test]
    fn light_of_a_luminous_ceiling_is_emitted_and_not_reflected() {
        // A disk of radius R at the height h above the point: E = pi L R^2 / (R^2 + h^2).
        let ceiling = ShapeDescription::disk(2.0).reversed().translated([0.0, 0.0, 3.2]);
        let luminous = ceiling.emitting(50.0 * CANDELA);
        let (scene, _) = SceneBuilder::new().shape(luminous, MaterialKind::diffuse(0.0)).resolve().unwrap();
        let found = gathered(&scene, 1 << 13, PointReceiver::Plane(DVec3::Z));
        let expected = PI * 50.0 * 4.0 / 8.0;
        assert!((found.emitted.value - expected).abs() < 4.0 * found.emitted.error, "{found:?}");
        assert!(found.emitted.error < 0.02 * expected && found.reflected.value == 0.0, "{found:?}");
    }

    #[test]
    fn glare_of_a_luminous_surface_is_that_of_a_luminaire_of_its_luminance() {
        // A square of 0.6 m, 2 m above the eye and 4 m ahead, of 1000 cd/m^2: as in the calculation by hand of a single luminaire.
        let panel =
            ShapeDescription::rectangle([-0.3, 0.3], [-0.3, 0.3]).reversed().translated([4.0, 0.0, 3.2]);
        let panel = panel.emitting(1000.0 * CANDELA);
        let (scene, _) = SceneBuilder::new().shape(panel, MaterialKind::diffuse(0.0)).resolve().unwrap();
        let gather = PointGather::try_new(&scene, 1 << 11, 5).unwrap();
        let observer = GlareObserver::try_new(DVec3::new(0.0, 0.0, 1.2), DVec3::X).unwrap();
        let found = gather.emitted_glare(&observer, 0, &CancelFlag::default()).unwrap();
        let expected = 1e6 * 0.008_049_8 / 2.860_2_f64.powi(2);
        // The luminaire is small, but no point: its position index varies by 10 % over it.
        assert!(
            (found.value - expected).abs() < 4.0 * found.error + 0.01 * expected,
            "{found:?}, {expected}"
        );
        assert!(found.error < 0.03 * expected, "{found:?}");
        // A ceiling over the eye, within the sphere around it: the sum over small squares.
        let ceiling =
            ShapeDescription::rectangle([-3.0, 3.0], [-3.0, 3.0]).reversed().translated([0.0, 0.0, 3.2]);
        let ceiling = ceiling.emitting(100.0 * CANDELA);
        let (wide, _) = SceneBuilder::new().shape(ceiling, MaterialKind::diffuse(0.0)).resolve().unwrap();
        let gather = PointGather::try_new(&wide, 1 << 15, 5).unwrap();
        let found = gather.emitted_glare(&observer, 0, &CancelFlag::default()).unwrap();
        let (mut sum, side) = (0.0, 0.01);
        for (i, j) in (-300..300).flat_map(|i| (-300..300).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) * side);
            let offset = DVec3::new(x, y, 2.0);
            let Some(p) = observer.position_index(offset) else { continue };
            sum += 100.0 * 100.0 / (p * p) * 2.0 / offset.length().powi(3) * side * side;
        }
        assert!(
            (found.value - sum).abs() < 4.0 * found.error && found.error < 0.02 * sum,
            "{found:?}, {sum}"
        );
        let gather = PointGather::try_new(&scene, 1 << 11, 5).unwrap();
        // Turned away it is dark.
        let behind = GlareObserver::try_new(DVec3::new(0.0, 0.0, 1.2), DVec3::NEG_X).unwrap();
        assert_eq!(gather.emitted_glare(&behind, 0, &CancelFlag::default()).unwrap().value, 0.0);
    }

    #[test]
    fn raised_flag_interrupts() {
        let (scene, _) = SceneBuilder::new().light(LightDescription::infinite(1.0)).resolve().unwrap();
        let gather = PointGather::try_new(&scene, 16, 0).unwrap();
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert!(gather.illuminance(DVec3::ZERO, PointReceiver::Cylinder, 0, &cancel).is_err());
    }
}
