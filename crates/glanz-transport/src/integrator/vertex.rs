//! A point where light is scattered.

use glanz_geometry::BoundedRay;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3, Frame, Ray};
use glanz_scene::{Interaction, LightId, LightSample, LightSampleContext, RayDifferential, Scene};
use glanz_shading::{Bsdf, BsdfSample, TransportMode};

use super::Context;
use super::path_tracer::INTERFACE_LIMIT;

/// An interaction with its BSDF, or with the phase function of a medium; directions are in world space, unit length, away from the surface.
///
/// With shading normals, a direction may be on different sides of the shading and the geometric surface, and light would leak through.
/// Such directions carry no light (@veach1997 section 5.3.2). Where the viewer itself is on the wrong side of the shading
/// normal, the surface is shaded by its geometric normal, because it would be black otherwise.
pub(crate) struct Vertex<'a> {
    pub(crate) at: &'a Interaction,
    pub(super) bsdf: Bsdf<'a>,
    frame: Frame,
    wo: DVec3,
    /// Cosine between viewer and surface normal.
    viewer_side: f64,
}

/// A sampled direction in which a path continues.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScatteredRay {
    /// The unit direction.
    pub(crate) direction: DVec3,
    /// Factor on the throughput.
    pub(crate) weight: Spectrum,
    /// The factor for sampling by the BSDF alone.
    pub(super) bsdf_weight: Spectrum,
    /// Density per solid angle of the direction by the BSDF; infinite for a delta lobe.
    pub(super) bsdf_pdf: f64,
    /// Density per solid angle with which the direction was sampled.
    pub(super) pdf: f64,
    pub(crate) is_delta: bool,
    pub(super) eta_scale: f32,
}

impl ScatteredRay {
    /// The direction, sampled from the BSDF as a part of a mixture with the density `pdf`.
    pub(super) fn with_pdf(self, pdf: f64) -> Self {
        Self { weight: self.weight * (self.bsdf_pdf / pdf) as f32, pdf, ..self }
    }
}

impl<'a> Vertex<'a> {
    pub(crate) fn new(at: &'a Interaction, bsdf: Bsdf<'a>) -> Self {
        Self::from_viewer(at, bsdf, at.wo)
    }

    fn from_viewer(at: &'a Interaction, bsdf: Bsdf<'a>, viewer: DVec3) -> Self {
        let frame = at.frame_of(&bsdf, at.normal_for(viewer));
        Self { at, bsdf, frame, wo: frame.to_local(viewer), viewer_side: at.point.normal.dot(viewer) }
    }

    /// The same vertex for a viewer in the unit direction `viewer`.
    pub(super) fn seen_from(&self, viewer: DVec3) -> Self {
        Self::from_viewer(self.at, self.bsdf.clone(), viewer)
    }

    /// Whether a viewer in the unit direction `viewer` has the same shading normal.
    pub(crate) fn is_seen_alike(&self, viewer: DVec3) -> bool {
        self.at.normal_for(viewer) == self.at.normal_for(self.at.wo)
    }

    /// The shading normal on the viewer's side.
    pub(super) fn normal_to_viewer(&self) -> DVec3 {
        if self.wo.z < 0.0 { -self.frame.z } else { self.frame.z }
    }

    /// The point as the origin of light samples for a viewer in the unit direction `viewer`, for which the vertex was made.
    pub(super) fn light_sample_context(&self, viewer: DVec3) -> LightSampleContext {
        let normal = (!self.bsdf.transmits()).then(|| self.normal_to_viewer());
        let shading_normal = (!self.is_in_medium()).then_some(self.frame.z);
        LightSampleContext { position: self.at.point.position, shading_normal, wo: viewer, normal }
    }

    /// The cosine between `direction` and the shading normal.
    pub(super) fn cosine(&self, direction: DVec3) -> f64 {
        self.frame.z.dot(direction)
    }

    /// Whether all lobes are delta lobes.
    pub(crate) fn is_delta(&self) -> bool {
        self.bsdf.is_delta()
    }

    /// Whether a surface finish scatters light closely around the mirrored direction.
    pub(super) fn has_finish(&self) -> bool {
        self.bsdf.has_finish()
    }

    /// Whether it is a point in a medium.
    pub(super) fn is_in_medium(&self) -> bool {
        self.at.is_in_medium()
    }

    /// The probability with which the BSDF samples Lambert's lobe.
    pub(super) fn diffuse_probability(&self) -> f64 {
        self.bsdf.diffuse_probability(self.wo)
    }

    pub(super) fn albedo(&self) -> Spectrum {
        self.bsdf.albedo(self.wo)
    }

    /// The albedo in linear Rec. 709, under daylight. `wavelengths`: those of the BSDF.
    pub(super) fn rgb_albedo(&self, scene: &Scene, wavelengths: &Wavelengths) -> [f32; 3] {
        let rgb = Wavelengths::Rgb;
        match wavelengths {
            Wavelengths::Rgb => self.albedo(),
            _ => self.at.bsdf(scene, &rgb).map_or(Spectrum::BLACK, |bsdf| bsdf.albedo(self.wo)),
        }
        .to_rgb(&rgb)
    }

    /// Ends the light of other wavelengths than the hero of a path with this `throughput`, at its first dispersive surface.
    /// `is_dispersed`: whether there was one before, and from now on.
    #[inline]
    pub(super) fn disperse(&self, throughput: &mut Spectrum, is_dispersed: &mut bool) {
        if self.bsdf.is_dispersive() && !*is_dispersed {
            *is_dispersed = true;
            *throughput = throughput.hero_alone();
        }
    }

    /// The fraction of light that is reflected by other lobes than delta lobes.
    pub(super) fn rough_albedo(&self) -> Spectrum {
        let branches = self.bsdf.delta_branches(self.wo, TransportMode::Importance);
        let mirrored = branches.iter().flatten().filter(|branch| !branch.lobe.transmission);
        (self.bsdf.reflected(self.wo) - mirrored.map(|branch| branch.weight).sum()).map(|x| x.max(0.0))
    }

    /// Whether everything is absorbed.
    pub(super) fn is_black(&self) -> bool {
        self.bsdf == Bsdf::Black
    }

    /// Whether `direction` is on the same side of the shading and the geometric normal.
    fn is_consistent(&self, direction: DVec3, local: DVec3) -> bool {
        let reflects = self.at.point.normal.dot(direction) * self.viewer_side > 0.0;
        reflects == (local.z * self.wo.z > 0.0)
    }

    /// `f |cos|` and its density, without delta lobes.
    pub(super) fn eval(&self, direction: DVec3) -> (Spectrum, f64) {
        let local = self.frame.to_local(direction);
        if !self.is_consistent(direction, local) {
            return (Spectrum::BLACK, 0.0);
        }
        let value = self.bsdf.eval(self.wo, local);
        (value, if value.is_black() { 0.0 } else { self.bsdf.pdf(self.wo, local).0 })
    }

    /// A direction that was not sampled from the BSDF, from a mixture that samples it with the density `pdf(bsdf_pdf)`; `None` where nothing is
    /// scattered.
    pub(super) fn drawn(&self, direction: DVec3, pdf: impl FnOnce(f64) -> f64) -> Option<ScatteredRay> {
        let (value, bsdf_pdf) = self.eval(direction);
        if value.is_black() {
            return None;
        }
        let pdf = pdf(bsdf_pdf);
        Some(ScatteredRay {
            direction,
            weight: value / pdf as f32,
            bsdf_weight: value / bsdf_pdf as f32,
            bsdf_pdf,
            pdf,
            is_delta: false,
            eta_scale: self.bsdf.eta_scale(self.wo, self.frame.to_local(direction)),
        })
    }

    /// Samples a direction.
    pub(super) fn sample(&self, xi: DVec2, xi_lobe: f64) -> Option<ScatteredRay> {
        self.consistent(self.bsdf.sample(self.wo, xi, xi_lobe, TransportMode::Radiance)?)
    }

    /// Samples a direction in which flux from the viewer's direction continues, as needed for light paths.
    ///
    /// The weight is that of the adjoint BSDF, which differs because of shading normals (@veach1997 section 5.3.2).
    pub(crate) fn sample_flux(&self, xi: DVec2, xi_lobe: f64) -> Option<ScatteredRay> {
        let drawn = self.consistent(self.bsdf.sample(self.wo, xi, xi_lobe, TransportMode::Importance)?)?;
        let surface = |direction: DVec3| self.at.point.normal.dot(direction);
        let from_light = self.wo.z / self.viewer_side;
        let onwards = surface(drawn.direction) / self.cosine(drawn.direction);
        let adjoint = (from_light * onwards).abs() as f32;
        adjoint.is_finite().then(|| ScatteredRay { weight: drawn.weight * adjoint, ..drawn })
    }

    /// Directions of all delta lobes, each weighted with its full reflectance or transmittance.
    pub(super) fn delta_branches(&self) -> impl Iterator<Item = ScatteredRay> {
        let branches = self.bsdf.delta_branches(self.wo, TransportMode::Radiance);
        branches.into_iter().flatten().filter_map(|branch| self.consistent(branch))
    }

    /// The differential of a ray that continues in a sampled direction; `None` behind rough lobes.
    #[inline]
    pub(super) fn differential(&self, scattered: &ScatteredRay) -> Option<RayDifferential> {
        let at = self.at.differential.as_ref().filter(|_| scattered.is_delta)?;
        // Radiance changes by the squared ratio of the refractive indices.
        let eta = 1.0 / f64::from(scattered.eta_scale).sqrt();
        at.scattered(-self.at.wo, scattered.direction, self.frame.z, eta)
    }

    fn consistent(&self, sample: BsdfSample) -> Option<ScatteredRay> {
        let direction = self.frame.to_world(sample.wi);
        if sample.weight.is_black() || !self.is_consistent(direction, sample.wi) {
            return None;
        }
        Some(ScatteredRay {
            direction,
            weight: sample.weight,
            bsdf_weight: sample.weight,
            bsdf_pdf: sample.pdf.0,
            pdf: sample.pdf.0,
            is_delta: sample.lobe.is_delta(),
            eta_scale: sample.eta_scale,
        })
    }

    /// Light of `id` that is scattered to the viewer, estimated with one direction towards the light.
    ///
    /// `weight`: weight by the direction, its density (per solid angle, without the selection of the light) and that of
    /// the BSDF for the same direction; not called for delta lights, which have weight 1.
    pub(super) fn light(
        &self,
        context: &mut Context<'_>,
        id: LightId,
        xi: DVec2,
        weight: impl FnOnce(DVec3, f64, f64) -> f64,
    ) -> Spectrum {
        let sample = context.scene.sample_light(id, self.at, xi);
        match self.sampled_light(context, id, sample, weight) {
            Some((light, shadow)) if context.is_free(&shadow.ray, shadow.t_max) => light,
            _ => Spectrum::BLACK,
        }
    }

    /// As [`Vertex::light`], of a sample of the light `id` from this point, with the ray that must be free for the light to arrive. `None` if there is no light.
    pub(super) fn sampled_light(
        &self,
        context: &Context<'_>,
        id: LightId,
        sample: Option<LightSample>,
        weight: impl FnOnce(DVec3, f64, f64) -> f64,
    ) -> Option<(Spectrum, BoundedRay)> {
        let sample = sample?;
        let (value, bsdf_pdf) = self.eval(sample.wi);
        let light = value * context.light_at(id, sample.radiance);
        if light.is_black() {
            return None;
        }
        let weight = if sample.is_delta { 1.0 } else { weight(sample.wi, sample.pdf.0, bsdf_pdf) };
        let arriving = light * (weight / sample.pdf.0) as f32;
        (weight != 0.0).then(|| (arriving, BoundedRay::new(sample.shadow, sample.t_max)))
    }
}

/// The ray that continues through an interface at `at`; `None` after too many of them. `passed`: the number of interfaces since the last
/// scattering event, counted here.
pub(crate) fn pass_interface(at: &Interaction, direction: DVec3, passed: &mut u32) -> Option<Ray> {
    *passed += 1;
    (*passed <= INTERFACE_LIMIT).then(|| at.spawn(direction))
}

/// The vertex before the current ray, with the density of the ray, for the weight of light that it hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreviousVertex {
    /// Position of the vertex.
    pub(super) from: LightSampleContext,
    /// Density per solid angle of its direction.
    pub(super) pdf: f64,
}

impl PreviousVertex {
    /// Density with which light sampling finds this light at this point, without the selection of the light.
    pub(super) fn area_light_pdf(&self, context: &Context<'_>, id: LightId, hit: &Interaction) -> f64 {
        context.scene.light_pdf(id, &self.from, hit).0
    }

    /// As [`PreviousVertex::area_light_pdf`], for an infinite light along `direction`.
    pub(super) fn infinite_light_pdf(&self, context: &Context<'_>, id: LightId, direction: DVec3) -> f64 {
        context.scene.infinite_pdf(id, &self.from, direction).0
    }

    /// As [`PreviousVertex::infinite_light_pdf`], for samples that are combined with those of BSDFs.
    pub(super) fn compensated_infinite_pdf(
        &self,
        context: &Context<'_>,
        id: LightId,
        direction: DVec3,
    ) -> f64 {
        context.scene.compensated_infinite_pdf(id, &self.from, direction).0
    }
}

/// The lanes of a factor that carry light in a path with this `throughput`; the others, in which no wavelength or no light is left, are zero.
pub(super) fn carried(factor: Spectrum, throughput: Spectrum) -> Spectrum {
    factor.zip(throughput, |lane, used| if used > 0.0 { lane } else { 0.0 })
}

/// Random survival of a path whose throughput is small (document 003 section 3.1.4).
///
/// `throughput`: without the scaling by refraction. Returns the factor for survivors.
pub(crate) fn roulette(throughput: Spectrum, xi: f64) -> Option<f32> {
    let survival = throughput.max_component();
    if survival >= 1.0 {
        return Some(1.0);
    }
    (xi < f64::from(survival)).then(|| 1.0 / survival)
}

#[cfg(test)]
mod tests {
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{MaterialKind, ShapeDescription};

    use super::*;

    /// Directions of the mirrored and the refracted ray with their differentials.
    fn branches(scene: &Scene, ray: &Ray, differential: &RayDifferential) -> Vec<(DVec3, RayDifferential)> {
        let (at, _) = scene.intersect_differential(ray, Some(differential)).unwrap();
        let bsdf = at.bsdf(scene, &Wavelengths::default()).unwrap();
        let vertex = Vertex::new(&at, bsdf);
        let with_differential = |ray: ScatteredRay| (ray.direction, vertex.differential(&ray).unwrap());
        vertex.delta_branches().map(with_differential).collect()
    }

    #[test]
    fn differentials_at_glass_are_limits_of_differences() {
        let glass = MaterialKind::dielectric(1.5, 1.0, 1.0);
        let scene = SceneBuilder::new().shape(ShapeDescription::sphere(1.0), glass).resolve().unwrap().0;
        let parallel = RayDifferential { origin: [DVec3::X, DVec3::Y], direction: [DVec3::ZERO; 2] };
        // From outside and from inside.
        for origin in [DVec3::new(0.3, 0.2, 3.0), DVec3::new(0.3, 0.2, 0.1)] {
            let ray = |offset: DVec3| Ray::new(origin + offset, -DVec3::Z);
            let found = branches(&scene, &ray(DVec3::ZERO), &parallel);
            assert_eq!(found.len(), 2);
            let step = 1e-5;
            for (axis, side) in [DVec3::X, DVec3::Y].into_iter().enumerate() {
                let [ahead, behind] =
                    [step, -step].map(|step| branches(&scene, &ray(step * side), &parallel));
                for ((ahead, behind), (_, differential)) in ahead.iter().zip(&behind).zip(&found) {
                    let difference = (ahead.0 - behind.0) / (2.0 * step);
                    let off = difference - differential.direction[axis];
                    assert!(off.length() < 1e-6, "{origin}, {side}: {difference} {differential:?}");
                }
            }
        }
    }
}
