//! A luminaire measured by a goniophotometer.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::intensity::{IntensityDistribution, LuminousOpening, OpeningShape};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{AreaPdf, Bounds3, DMat3, DVec2, DVec3, Ray, Transform};
use glanz_sampling::discrete::PiecewiseConstant1;

use super::extent::{DirectionCone, EmissionBounds};
use super::point::sample_point;
use super::{
    IncidentLight, LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, opening,
    range_error,
};
use crate::error::SceneErrorKind;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::scene::Scene;

/// Relative difference that is allowed between the scales along different directions: matrices printed with four digits pass.
const SIMILARITY: f64 = 1e-3;

/// Name of the transformation in errors.
pub(super) const TRANSFORMATION: &str = "photometric light: transformation";

/// A luminaire that emits candela by direction, from a point or evenly from its luminous opening.
///
/// A goniophotometer measures from so far away that the luminaire has no size, and the file does not say how the opening shares the light.
/// Every point of the opening is taken to emit the same distribution: with intensity I and area A the radiance I / (A cos) grows without
/// bound along a flat opening, so that the opening is sampled by its points and cannot be hit by a ray.
#[derive(Clone, Debug)]
pub struct PhotometricLight {
    position: DVec3,
    /// The axes of the luminaire in the world; orthonormal, perhaps mirrored.
    axes: DMat3,
    distribution: Arc<IntensityDistribution>,
    /// Opening with sizes in the world; `None` for a point.
    opening: Option<LuminousOpening>,
    /// W/sr for one candela of the distribution.
    per_candela: Spectrum,
    /// Lumens of the distribution.
    flux: f64,
    /// Cells of the distribution by flux; `None` if it is dark.
    cells: Option<Arc<PiecewiseConstant1>>,
}

/// Orthonormal axes, mirrored if the map is, and the factor on lengths of a luminaire in the world; `None` if the map is not a similarity.
pub(super) fn luminaire_axes(to_world: &Transform) -> Option<(DMat3, f64)> {
    let scale = to_world.uniform_scale(SIMILARITY)?;
    let z = to_world.vector(DVec3::Z).try_normalize()?;
    let x = to_world.vector(DVec3::X).reject_from_normalized(z).try_normalize()?;
    let y = z.cross(x) * to_world.forward().matrix3.determinant().signum();
    Some((DMat3::from_cols(x, y, z), scale))
}

/// The error of a light whose transformation, `what`, is not a similarity.
pub(super) fn uneven(what: &'static str) -> SceneErrorKind {
    range_error(what, "anisotropic", "composed of translations, rotations, reflections and uniform scales")
}

impl PhotometricLight {
    /// `from`: the photometric centre in the luminaire's frame. `opening`: `None` for a point.
    pub(super) fn resolve(
        input: LightInput<'_>,
        distribution: &Arc<IntensityDistribution>,
        opening: Option<LuminousOpening>,
        from: DVec3,
    ) -> Result<Self, SceneErrorKind> {
        let per_candela = input.per_candela?;
        Self::try_new(Arc::clone(distribution), opening, from, &input.to_world, per_candela)
            .ok_or_else(|| uneven(TRANSFORMATION))
    }

    /// `from`: the photometric centre in the luminaire's frame, which `to_world` places. `opening`: `None` for a point. `per_candela`: W/sr for one
    /// candela of the distribution. `None` if `to_world` is not a similarity.
    fn try_new(
        distribution: Arc<IntensityDistribution>,
        opening: Option<LuminousOpening>,
        from: DVec3,
        to_world: &Transform,
        per_candela: Spectrum,
    ) -> Option<Self> {
        let (axes, scale) = luminaire_axes(to_world)?;
        let fluxes = distribution.cell_fluxes();
        let opening = opening.filter(|o| o.shape != OpeningShape::Point && o.size != [0.0; 3]);
        Some(Self {
            position: to_world.point(from),
            axes,
            opening: opening.map(|o| LuminousOpening { size: o.size.map(|s| s * scale), ..o }),
            per_candela,
            flux: fluxes.iter().sum(),
            cells: PiecewiseConstant1::try_new(&fluxes).ok().map(Arc::new),
            distribution,
        })
    }

    /// Total power, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.per_candela * self.flux as f32
    }

    /// Intensity in a direction of the world, W/sr.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> Spectrum {
        self.per_candela * self.distribution.intensity(self.axes.transpose() * direction) as f32
    }

    /// Direction of the luminaire's axis in the world: downwards, as most hang.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        -self.axes.z_axis
    }

    /// Whether it has no size.
    #[must_use]
    pub fn is_point(&self) -> bool {
        self.opening.is_none()
    }

    /// Its centre, metres.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.position
    }

    /// A cone that holds the directions of its light, about the axis of the measurement.
    fn directions(&self) -> DirectionCone {
        let polars = self.distribution.polars();
        let [mut least, mut most] = [polars.len(), 0];
        for plane in (0..self.distribution.azimuths().len()).map(|azimuth| self.distribution.plane(azimuth)) {
            let is_lit = |&candela: &f64| candela > 0.0;
            // Between the angles the intensity is linear.
            least = least
                .min(plane.iter().position(is_lit).map_or(polars.len(), |first| first.saturating_sub(1)));
            most = most.max(plane.iter().rposition(is_lit).map_or(0, |last| last + 1));
        }
        let most = polars.get(most).or(polars.last()).map_or(PI, |polar| polar.to_radians());
        let least = polars.get(least).map_or(0.0, |polar| polar.to_radians());
        let pole = self.axes * self.distribution.direction(0.0, 0.0);
        if PI - least < most {
            DirectionCone { axis: -pole, half_angle: PI - least }
        } else {
            DirectionCone { axis: pole, half_angle: most }
        }
    }

    /// A point of its opening, metres, by two numbers uniform in [0, 1).
    fn place(&self, xi: DVec2) -> DVec3 {
        let from_center = self.opening.as_ref().map_or(DVec3::ZERO, |o| opening::point(o, xi));
        self.position + self.axes * from_center
    }

    /// A unit direction in proportion to the intensity, by two numbers uniform in [0, 1).
    fn direction(&self, xi: DVec2) -> Option<DVec3> {
        let cell = self.cells.as_ref()?.choose(xi.x);
        let [azimuth, polar] = self.distribution.sample_cell(cell.index, DVec2::new(cell.xi, xi.y))?;
        (self.axes * self.distribution.direction(azimuth, polar)).try_normalize()
    }
}

impl LightModel for PhotometricLight {
    const KIND: &'static str = "photometric";

    fn is_delta(&self) -> bool {
        self.is_point()
    }

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power())
    }

    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        let directions = self.directions();
        let middle = DirectionCone { half_angle: 0.0, ..directions };
        let half = self.opening.as_ref().map_or(DVec3::ZERO, |o| 0.5 * DVec3::from_array(o.size));
        let corners = Bounds3::new(-half, half).corners().map(|corner| self.position + self.axes * corner);
        LightExtent::Bounded(EmissionBounds {
            bounds: Bounds3::from_points(corners),
            ..EmissionBounds::beam(self.position, middle, directions.half_angle)
        })
    }

    fn sample(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        sample_point(from, self.place(xi), |direction, _| self.intensity(direction))
    }

    /// Directions in proportion to the intensity: all rays carry the same power.
    fn emit(&self, _: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let ray = Ray::new(self.place(place), self.direction(direction)?);
        Some(LightRay::new(ray, self.power()))
    }

    /// The density if all of the opening were at its centre: a weight for paths has to be the same from both ends, not exact.
    fn emission_pdf(&self, _: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        let wavelengths = Wavelengths::default();
        let mean = |light: Spectrum| f64::from(light.mean(&wavelengths));
        let fraction = mean(self.intensity(-wi)) / mean(self.power());
        let pdf = fraction / (at - self.position).length_squared();
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    fn incident(&self, point: DVec3) -> Option<IncidentLight> {
        if !self.is_point() {
            return None;
        }
        IncidentLight::from_position(self.position, point, |direction, _| self.intensity(direction))
    }
}
