//! A projector.

use std::sync::Arc;

use glanz_job::BudgetError;
use glanz_light::Spectrum;
use glanz_math::{AreaPdf, DMat3, DVec2, DVec3, Ray};
use glanz_sampling::discrete::PiecewiseConstant2;

use super::extent::{DirectionCone, EmissionBounds};
use super::flat_image::FlatImage;
use super::point::sample_point;
use super::{
    IncidentLight, LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, range_error,
};
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// A point that emits a picture into a pyramid.
///
/// # Source
/// @pharr2023 section 12.2.2. Departure: interpolation between pixels.
#[derive(Clone, Debug)]
pub struct ProjectionLight {
    position: DVec3,
    /// x to the right of the picture, y up and z to its middle; orthonormal, perhaps mirrored.
    axes: DMat3,
    /// Half of the picture's sides at the distance 1.
    half: DVec2,
    /// W/sr.
    intensity: Arc<FlatImage>,
    /// Places in the picture by power; `None` if it is black.
    density: Option<Arc<PiecewiseConstant2>>,
    power: Spectrum,
}

impl ProjectionLight {
    /// `field_of_view`: of the shorter side, radians, between 0 and pi.
    pub(super) fn resolve(
        input: &LightInput<'_>,
        image: usize,
        field_of_view: f64,
    ) -> Result<Self, SceneErrorKind> {
        if !(field_of_view > 0.0 && field_of_view < std::f64::consts::PI) {
            return Err(range_error("projection light: field of view", field_of_view, "between 0 and pi"));
        }
        let axes = input.axes("projection light: transformation")?;
        let intensity =
            FlatImage::of_picture(input.picture(image)?, input.emission).map_err(BudgetError::from)?;
        let [width, height] = intensity.size();
        let half = half_sides([width as f64, height as f64], field_of_view);
        let solid_angle = |place: DVec2| solid_angle_of_unit(half, place);
        let weight = |(place, mean)| (brightness(mean) * solid_angle(place)) as f32;
        let weights = intensity.cells().map(weight).collect();
        let density = PiecewiseConstant2::try_new(width, height, weights, |_| 1.0).ok();
        let power = intensity.mean(solid_angle);
        let position = input.to_world.point(DVec3::ZERO);
        let density = density.map(Arc::new);
        Ok(Self { position, axes, half, intensity: Arc::new(intensity), density, power })
    }

    /// Total power, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// Its position, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Unit direction to the middle of the picture.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.axes.z_axis
    }

    /// Cosine of the angle between its axis and a corner of the picture.
    #[must_use]
    pub fn cos_corner(&self) -> f64 {
        1.0 / (1.0 + self.half.length_squared()).sqrt()
    }

    /// Intensity in a unit direction, W/sr.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Spectrum {
        self.place(direction).map_or(Spectrum::BLACK, |place| self.intensity.lookup(place))
    }

    /// The place in the picture of a direction of the world, from its upper left corner.
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let local = self.axes.transpose() * direction;
        let at = local.truncate() / (local.z * self.half);
        (local.z > 0.0 && at.abs().max_element() <= 1.0).then(|| 0.5 + 0.5 * DVec2::new(at.x, -at.y))
    }

    /// Solid angle, sr, of a projected picture of `size` pixels per unit of its area, at a place in [0, 1]^2 from its upper left corner.
    /// `field_of_view`: of the shorter side, radians, between 0 and pi.
    #[must_use]
    pub fn solid_angle_of_unit(size: [u32; 2], field_of_view: f64, place: DVec2) -> f64 {
        solid_angle_of_unit(half_sides(size.map(f64::from), field_of_view), place)
    }

    /// Density per solid angle of a direction in which it emits.
    fn pdf(&self, direction: DVec3) -> f64 {
        let found = self.place(direction).zip(self.density.as_ref());
        found.map_or(0.0, |(place, density)| density.pdf(place) / solid_angle_of_unit(self.half, place))
    }
}

/// Half of the sides of a picture at the distance 1.
fn half_sides([width, height]: [f64; 2], field_of_view: f64) -> DVec2 {
    DVec2::new(width, height) / width.min(height) * (0.5 * field_of_view).tan()
}

/// The point of the picture at the distance 1.
fn point_of(half: DVec2, place: DVec2) -> DVec3 {
    let at = 2.0 * place - 1.0;
    (half * DVec2::new(at.x, -at.y)).extend(1.0)
}

/// Solid angle, sr, per unit of area of the picture: its area at the distance 1 times the third power of the cosine.
fn solid_angle_of_unit(half: DVec2, place: DVec2) -> f64 {
    4.0 * half.x * half.y * point_of(half, place).length().powi(-3)
}

impl LightModel for ProjectionLight {
    const KIND: &'static str = "projection";

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power)
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        // The corners are the farthest from the axis.
        let cone = DirectionCone { axis: self.axes.z_axis, half_angle: self.half.length().atan() };
        LightExtent::Bounded(EmissionBounds::beam(self.position, cone, cone.half_angle))
    }

    fn sample(&self, _: &Scene, from: &Interaction, _: DVec2) -> Option<LightSample> {
        sample_point(from, self.position, |direction, _| self.intensity(direction))
    }

    /// Directions in proportion to the intensity.
    fn emit(&self, _: &Scene, _: DVec2, direction: DVec2) -> Option<LightRay> {
        let sample = self.density.as_ref()?.sample(direction);
        let way = self.axes * point_of(self.half, sample.point).normalize();
        let weight = solid_angle_of_unit(self.half, sample.point) / sample.pdf;
        Some(LightRay::new(Ray::new(self.position, way), self.intensity.lookup(sample.point) * weight as f32))
    }

    fn emission_pdf(&self, _: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        self.pdf(-wi) / (at - self.position).length_squared()
    }

    fn incident(&self, point: DVec3) -> Option<IncidentLight> {
        IncidentLight::from_position(self.position, point, |direction, _| self.intensity(direction))
    }
}
