//! A surface that emits light.
//!
//! Rays hit a surface of opacity a with probability a, so that it emits the a-th part of its radiance; a surface of opacity 0 everywhere is a light that is
//! not seen, as in pbrt (@pbrt4 `DiffuseAreaLight`).

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glanz_geometry::{AreaSample, RaySurface};
use glanz_light::Spectrum;
use glanz_math::rounding::{gamma, offset_origin};
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, Ray, SolidAnglePdf};
use glanz_sampling::warp;

use super::extent::{DirectionCone, EmissionBounds};
use super::flat_image::FlatImage;
use super::light_triangles::LightTriangles;
use super::world_sphere::{SphereCone, WorldSphere};
use super::{LightExtent, LightModel, LightRay, LightSample, brightness};
use crate::alpha::RayKind;
use crate::area::area;
use crate::interaction::{Interaction, LightSampleContext};
use crate::object::SceneObject;
use crate::scene::Scene;

/// Samples along each side of the grid for the mean of a picture over a surface.
const MEAN_SIDE: usize = 128;

/// A surface that emits in every direction of its front the same radiance, which may vary over it by a picture.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// Number of the object in the world group.
    object: u32,
    /// Radiance, or factor on the picture.
    emission: Spectrum,
    /// Factor on `emission` by texture coordinates.
    image: Option<Arc<FlatImage>>,
    /// Mean radiance over the surface.
    radiance: Spectrum,
    two_sided: bool,
    /// m^2; `None` if the surface cannot be sampled.
    area: Option<f64>,
    /// The surface, if it is a whole sphere in the world too.
    sphere: Option<WorldSphere>,
    /// The triangles of a light of few flat faces without picture.
    triangles: Option<Arc<LightTriangles>>,
    /// Whether a sphere emits to its inside.
    inward: bool,
    /// Whether it is transparent in part, so that it emits less.
    is_translucent: bool,
    /// Whether rays pass it. It emits all the same.
    is_invisible: bool,
}

impl AreaLight {
    /// `image`: factor on `emission`, W/(m^2 sr), by texture coordinates.
    pub(crate) fn new(
        object_index: u32,
        object: &SceneObject,
        emission: Spectrum,
        image: Option<Arc<FlatImage>>,
        two_sided: bool,
    ) -> Self {
        let radiance = image.as_ref().map_or(emission, |image| emission * mean_of_image(object, image));
        let is_invisible = object.is_absent();
        let triangles = image.is_none().then(|| LightTriangles::new(object, two_sided)).flatten();
        Self {
            object: object_index,
            emission,
            image,
            triangles: triangles.map(Arc::new),
            radiance,
            two_sided,
            area: area(object),
            sphere: WorldSphere::new(object),
            inward: object.is_reversed(),
            is_translucent: !is_invisible && object.alpha.is_some(),
            is_invisible,
        }
    }

    /// With `factor` times the radiance.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { emission: self.emission * factor, radiance: self.radiance * factor, ..self }
    }

    /// Whether directions towards it can be sampled; if not, only rays that hit it by chance find its light.
    #[must_use]
    pub fn can_be_sampled(&self) -> bool {
        self.area.is_some()
    }

    /// Area, m^2, exact for spheres, disks, cylinders and other closed forms, with a relative error of about 1e-6 for others; `None` if the
    /// surface cannot be sampled.
    #[must_use]
    pub fn area(&self) -> Option<f64> {
        self.area
    }

    /// Total power, W; black if the area is not known.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        self.radiance * (PI * sides * self.area.unwrap_or(0.0)) as f32
    }

    /// Whether rays hit it everywhere.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        !self.is_translucent && !self.is_invisible
    }

    /// Fraction of its radiance that it emits at a point of this opacity.
    #[must_use]
    pub fn emitted_fraction(&self, opacity: f32) -> f32 {
        if self.is_invisible { 1.0 } else { opacity }
    }

    /// Whether it is a whole sphere in the world.
    pub(crate) fn is_sphere(&self) -> bool {
        self.sphere.is_some()
    }

    /// Radiance of its front, W/(m^2 sr); with a picture the mean over the surface.
    #[must_use]
    pub fn radiance(&self) -> Spectrum {
        self.radiance
    }

    /// Whether its radiance varies by a picture.
    #[must_use]
    pub fn has_picture(&self) -> bool {
        self.image.is_some()
    }

    /// Whether the back emits light, too.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// Radiance that leaves the surface towards `direction`, where its normal is `normal` and its texture coordinates are `uv`.
    #[must_use]
    pub fn emitted(&self, normal: DVec3, uv: DVec2, direction: DVec3) -> Spectrum {
        if !self.two_sided && normal.dot(direction) <= 0.0 {
            return Spectrum::BLACK;
        }
        match &self.image {
            None => self.emission,
            Some(image) => self.emission * image.lookup(DVec2::new(uv.x, 1.0 - uv.y)),
        }
    }

    /// Density per solid angle with which a sample from `from` is the point of `hit` on this light.
    #[must_use]
    pub fn pdf(&self, from: &LightSampleContext, hit: &Interaction) -> SolidAnglePdf {
        let (position, normal) = (hit.point.position, hit.point.normal);
        hit.area_pdf.map_or(SolidAnglePdf(0.0), |pdf| self.pdf_at(from, position, normal, pdf))
    }

    /// As [`AreaLight::pdf`], of a point whose density per area is `area_pdf`.
    fn pdf_at(
        &self,
        from: &LightSampleContext,
        position: DVec3,
        normal: DVec3,
        area_pdf: AreaPdf,
    ) -> SolidAnglePdf {
        if let Some(cone) = self.cone(from.position) {
            return cone.pdf();
        }
        if let Some(triangles) = self.near_triangles(from.position) {
            return triangles.pdf(from.position);
        }
        let offset = position - from.position;
        let distance_squared = offset.length_squared();
        area_pdf.to_solid_angle(distance_squared, normal.dot(offset / distance_squared.sqrt()))
    }

    /// The opacity at the point of the surface that a ray hits first.
    fn opacity(&self, scene: &Scene, ray: &Ray) -> f32 {
        if !self.is_translucent {
            return 1.0;
        }
        let found = scene.world_object(self.object).and_then(|object| {
            let local = object.local(ray);
            let hit = object.surface().intersect(&local, f64::INFINITY)?;
            Some(object.opacity(&local, &hit, RayKind::Closest))
        });
        // A point that rounding moves beyond the border counts in full, as of other lights.
        found.unwrap_or(1.0) as f32
    }

    /// The cone that a sphere subtends; `None` if its far side shines through the near one, which alone is sampled by directions.
    fn cone(&self, from: DVec3) -> Option<SphereCone> {
        if !self.is_opaque() && (self.two_sided || self.inward) {
            return None;
        }
        let WorldSphere { center, radius, .. } = self.sphere.filter(|_| self.image.is_none())?;
        SphereCone::new(center, radius, from)
    }

    /// The triangles, if they are sampled by solid angle from a point.
    fn near_triangles(&self, from: DVec3) -> Option<&LightTriangles> {
        self.triangles.as_deref().filter(|triangles| triangles.are_near(from))
    }

    /// A point of the surface: uniform by area on a sphere, else as by [`SceneObject::sample`]; with its texture coordinates, if they matter.
    #[inline]
    fn sample_surface(&self, scene: &Scene, xi: DVec2) -> Option<(AreaSample, DVec2)> {
        let object = || scene.world_object(self.object);
        let sample = match &self.sphere {
            _ if self.image.is_some() => return object()?.sample_with_uv(xi),
            Some(sphere) => sphere.sample(self.inward, xi),
            None => object()?.sample(xi)?,
        };
        Some((sample, DVec2::ZERO))
    }

    /// Directions uniform in the cone that the sphere subtends.
    ///
    /// # Source
    /// @pharr2023 section 6.2.4.
    fn sample_cone(
        &self,
        scene: &Scene,
        cone: &SphereCone,
        from: &Interaction,
        xi: DVec2,
    ) -> Option<LightSample> {
        if self.inward && !self.two_sided {
            return None;
        }
        let local = warp::uniform_cone(xi, cone.one_minus_cos);
        let wi = Frame::from_z(cone.axis).to_world(local);
        let sin_squared = local.x * local.x + local.y * local.y;
        let half_chord =
            (cone.radius * cone.radius - cone.distance * cone.distance * sin_squared).max(0.0).sqrt();
        let t = cone.distance * local.z - half_chord;
        let normal = (from.point.position + wi * t - cone.center).try_normalize()?;
        let position = cone.center + normal * cone.radius;
        // The formulas above chain fewer than 32 roundings of numbers no larger than these.
        let error = gamma(32) * (from.point.position.abs() + cone.center.abs() + cone.distance + cone.radius);
        let shadow = from.spawn_to(position, Some((error, normal)));
        Some(LightSample {
            wi,
            radiance: self.emission * self.opacity(scene, &Ray::new(shadow.at(1.0), wi)),
            pdf: cone.pdf(),
            is_delta: self.is_invisible,
            shadow,
            t_max: 1.0,
            area_pdf: Some(AreaPdf(0.25 * FRAC_1_PI / (cone.radius * cone.radius))),
        })
    }
}

impl LightModel for AreaLight {
    const KIND: &'static str = "diffuse";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_hit(&self) -> bool {
        !self.is_invisible
    }

    fn can_be_sampled(&self) -> bool {
        self.area.is_some()
    }

    fn importance(&self, _: f64) -> f64 {
        if self.area.is_some() { brightness(self.power()) } else { 0.0 }
    }

    fn extent(&self, world: &[SceneObject]) -> LightExtent {
        let object = world.get(self.object as usize);
        let extent = object.map(|object| EmissionBounds::surface(object, self.two_sided));
        let finite = extent.filter(|extent| extent.bounds.is_finite());
        finite.map_or(LightExtent::Distant(DirectionCone::ALL), LightExtent::Bounded)
    }

    fn sample(&self, scene: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        if let Some(cone) = self.cone(from.point.position) {
            return self.sample_cone(scene, &cone, from, xi);
        }
        let origin = from.point.position;
        let near = match self.near_triangles(origin) {
            Some(triangles) => Some(triangles.sample(scene.world_object(self.object)?, origin, xi)?),
            None => None,
        };
        let (AreaSample { position, error, normal, pdf: area_pdf, .. }, uv) = match &near {
            Some(point) => (point.at, DVec2::ZERO),
            None => self.sample_surface(scene, xi)?,
        };
        let offset = position - origin;
        let wi = offset.try_normalize()?;
        let radiance = self.emitted(normal, uv, -wi);
        let pdf = near.map_or_else(
            || area_pdf.to_solid_angle(offset.length_squared(), normal.dot(wi)),
            |point| point.pdf,
        );
        if radiance.is_black() || !(pdf.0 > 0.0 && pdf.0.is_finite()) {
            return None;
        }
        let shadow = from.spawn_to(position, Some((error, normal)));
        let (radiance, is_delta) =
            (radiance * self.opacity(scene, &Ray::new(shadow.at(1.0), wi)), self.is_invisible);
        Some(LightSample { wi, radiance, pdf, is_delta, shadow, t_max: 1.0, area_pdf: Some(area_pdf) })
    }

    /// Directions by the cosine; of a two-sided light on either side.
    fn emit(&self, scene: &Scene, place: DVec2, mut direction: DVec2) -> Option<LightRay> {
        let (point, uv) = self.sample_surface(scene, place)?;
        let (mut side, mut sides) = (1.0, 1.0);
        if self.two_sided {
            sides = 2.0;
            let is_back = direction.x >= 0.5;
            side = if is_back { -1.0 } else { 1.0 };
            direction.x = 2.0 * direction.x - f64::from(u8::from(is_back));
        }
        let way = Frame::from_z(side * point.normal).to_world(warp::cosine_hemisphere(direction));
        let power = self.emitted(point.normal, uv, way) * (PI * sides / point.pdf.0) as f32;
        let ray = Ray::new(offset_origin(point.position, point.error, point.normal, way), way);
        let power = power * self.opacity(scene, &Ray::new(ray.origin, -way));
        Some(LightRay { from: Some(point), ..LightRay::new(ray, power) })
    }

    /// The cosine of the direction's density turns an area of the light into one across the ray.
    fn emission_pdf(&self, _: &Scene, _: DVec3, _: DVec3, area_pdf: Option<AreaPdf>) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        area_pdf.map_or(0.0, |pdf| pdf.0 * FRAC_1_PI / sides)
    }

    fn pdf_of_ray(&self, from: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        ray.from.map_or(SolidAnglePdf(0.0), |at| self.pdf_at(from, at.position, at.normal, at.pdf))
    }
}

/// The mean of a picture over a surface, by a grid of samples; over the picture where the surface cannot be sampled.
fn mean_of_image(object: &SceneObject, image: &FlatImage) -> Spectrum {
    // No pixel is lost between the samples.
    let image = image.reduced(MEAN_SIDE);
    let (mut sum, mut area) = (Spectrum::BLACK, 0.0);
    for (i, j) in (0..MEAN_SIDE).flat_map(|i| (0..MEAN_SIDE).map(move |j| (i, j))) {
        let xi = (DVec2::new(i as f64, j as f64) + 0.5) / MEAN_SIDE as f64;
        if let Some((sample, uv)) = object.sample_with_uv(xi) {
            sum += image.lookup(DVec2::new(uv.x, 1.0 - uv.y)) * (1.0 / sample.pdf.0) as f32;
            area += 1.0 / sample.pdf.0;
        }
    }
    if area > 0.0 { sum * (1.0 / area) as f32 } else { image.mean(|_| 1.0) }
}
