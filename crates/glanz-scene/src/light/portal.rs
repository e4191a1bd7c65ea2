//! Light from far away through an opening.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{AreaPdf, Bounds3, DMat3, DVec2, DVec3, Ray, SolidAnglePdf};
use glanz_sampling::discrete::{GridWindow, PiecewiseConstant2, WindowedPiecewiseConstant2};

use super::extent::{DirectionCone, EmissionBounds};
use super::flat_image::FlatImage;
use super::{LightExtent, LightInput, LightModel, LightRay, LightSample, brightness, range_error};
use crate::description::SphereMapping;
use crate::error::SceneErrorKind;
use crate::interaction::{Interaction, LightSampleContext};
use crate::object::SceneObject;
use crate::scene::Scene;

/// Error of the corners of a rectangle, relative to its sides: matrices printed with four digits pass.
const RECTANGLE: f64 = 1e-3;

/// Least number of pixels along the sides of the resampled picture.
pub(crate) const LEAST_SIDE: usize = 128;

/// Radiance by direction from infinitely far that arrives through a rectangle only.
///
/// The picture is resampled to the angles under which the sides of the rectangle appear, in which the rectangle is one from everywhere:
/// a sum over a rectangle gives the light that a point gets through it.
///
/// # Source
/// @bitterli2015; @pharr2023 section 12.5.3. Departure: paths from the light start on the rectangle.
#[derive(Clone, Debug)]
pub struct PortalInfiniteLight {
    /// Corner of the rectangle, metres, and its sides along the x and y of the frame.
    corner: DVec3,
    size: DVec2,
    /// x and y along the sides, z to the light.
    frame: DMat3,
    radiance: Arc<PortalImage>,
    /// The power that passes through the rectangle, W.
    power: Spectrum,
}

/// The picture by the angles from z in the planes of x and y: [0, 1] is the range from -pi / 2 to pi / 2.
#[derive(Debug)]
struct PortalImage {
    image: FlatImage,
    /// Density in proportion to radiance, within windows; `None` if the light is black.
    windowed: Option<WindowedPiecewiseConstant2>,
    /// Density in proportion to radiance times the cosine to z.
    through: Option<PiecewiseConstant2>,
}

impl PortalInfiniteLight {
    /// `portal`: corners in order, metres in world space; counterclockwise seen from where the light goes. `image`: `None` for
    /// the same radiance from all directions.
    pub(super) fn resolve(
        input: &LightInput<'_>,
        image: Option<(usize, SphereMapping)>,
        portal: [DVec3; 4],
    ) -> Result<Self, SceneErrorKind> {
        let image = image.map(|(index, mapping)| input.sphere_image(index, mapping)).transpose()?;
        let axes = input.axes("infinite light: transformation")?;
        let (corner, size, frame) = rectangle(portal).ok_or_else(|| {
            let value = format!("{portal:?}");
            range_error("infinite light: portal", value, "the four corners of a rectangle in order")
        })?;
        let to_picture = axes.transpose() * frame;
        let emission = input.emission;
        // As many pixels across z as the picture has around it; by their number, as the picture may be a strip.
        let count = image.as_ref().map_or(0, |image| match image.mapping() {
            SphereMapping::LatitudeLongitude => image.width() * image.height() / 2,
            SphereMapping::EqualArea => image.width() * image.height(),
        });
        let side = count.isqrt();
        let radiance = |local: DVec3| match &image {
            Some(image) => emission * Spectrum::from_rgb(image.lookup(to_picture * local)),
            None => emission,
        };
        let radiance = PortalImage::new(side.max(LEAST_SIDE), radiance);
        let power = radiance.irradiance() * (size.x * size.y) as f32;
        Ok(Self { corner, size, frame, radiance: Arc::new(radiance), power })
    }

    /// Power that arrives at the rectangle, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// W/(m^2 sr) at `from` from the direction `wi`, of any length.
    #[must_use]
    pub fn radiance(&self, from: DVec3, wi: DVec3) -> Spectrum {
        match self.place_in_window(from, wi.normalize()) {
            Some((place, _, _)) => self.radiance.image.lookup(place),
            None => Spectrum::BLACK,
        }
    }

    /// Density with which a sample from `from` has the unit direction `wi`.
    #[must_use]
    pub fn pdf(&self, from: DVec3, wi: DVec3) -> SolidAnglePdf {
        let found = self.place_in_window(from, wi).zip(self.radiance.windowed.as_ref());
        SolidAnglePdf(found.map_or(0.0, |((place, window, local), windowed)| {
            windowed.pdf(place, window) / solid_angle_of_unit(local)
        }))
    }

    /// The range of the picture that `from` sees through the rectangle; `None` from its other side.
    fn window(&self, from: DVec3) -> Option<GridWindow> {
        let low = self.frame.transpose() * (self.corner - from);
        if low.z.is_nan() || low.z <= 0.0 {
            return None;
        }
        let place = |x: f64, y: f64| DVec2::new(place_of(x, low.z), place_of(y, low.z));
        Some([place(low.x, low.y), place(low.x + self.size.x, low.y + self.size.y)])
    }

    /// The place of a direction in the picture, the window and the direction in the frame, if it leads through the rectangle.
    fn place_in_window(&self, from: DVec3, wi: DVec3) -> Option<(DVec2, GridWindow, DVec3)> {
        let local = self.frame.transpose() * wi;
        if local.z.is_nan() || local.z <= 0.0 {
            return None;
        }
        let window @ [low, high] = self.window(from)?;
        let place = DVec2::new(place_of(local.x, local.z), place_of(local.y, local.z));
        (place.cmpge(low).all() && place.cmple(high).all()).then_some((place, window, local))
    }
}

impl PortalImage {
    /// The picture of `radiance`, W/(m^2 sr), by unit direction.
    fn new(side: usize, radiance: impl Fn(DVec3) -> Spectrum) -> Self {
        let image = FlatImage::new([side; 2], |place| radiance(direction_of(place)));
        let weight = |(place, mean)| {
            let local = direction_of(place);
            (local, brightness(mean) * solid_angle_of_unit(local))
        };
        let weights = image.cells().map(|cell| weight(cell).1).collect();
        let windowed = WindowedPiecewiseConstant2::try_new(side, side, weights).ok();
        let through = |cell| {
            let (local, weight) = weight(cell);
            (weight * local.z) as f32
        };
        let weights = image.cells().map(through).collect();
        let through = PiecewiseConstant2::try_new(side, side, weights, |_| 1.0).ok();
        Self { image, windowed, through }
    }

    /// The irradiance on a surface that faces z.
    fn irradiance(&self) -> Spectrum {
        self.image.mean(|place| {
            let local = direction_of(place);
            solid_angle_of_unit(local) * local.z
        })
    }
}

/// The angle of a direction from z in a plane, as a place in [0, 1].
fn place_of(across: f64, along: f64) -> f64 {
    (across.atan2(along) + FRAC_PI_2) / PI
}

/// The unit direction of a place.
fn direction_of(place: DVec2) -> DVec3 {
    let angle = PI * place - FRAC_PI_2;
    DVec3::new(angle.x.tan(), angle.y.tan(), 1.0).normalize()
}

/// Solid angle, sr, per unit of area of the picture around a unit direction.
///
/// # Source
/// @pharr2023 equation 12.9.
fn solid_angle_of_unit(local: DVec3) -> f64 {
    PI * PI * (1.0 - local.x * local.x) * (1.0 - local.y * local.y) / local.z
}

/// The first corner of a rectangle, its sides, and its frame: x from the first corner to the last, y from the first to the second.
fn rectangle([a, b, c, d]: [DVec3; 4]) -> Option<(DVec3, DVec2, DMat3)> {
    let (x, y) = ((d - a).try_normalize()?, (b - a).try_normalize()?);
    let size = DVec2::new((d - a).length(), (b - a).length());
    let is_closed = (b + d - a).distance(c) <= RECTANGLE * size.max_element();
    let is_square = x.dot(y).abs() <= RECTANGLE;
    if !(is_closed && is_square) {
        return None;
    }
    let y = y.reject_from_normalized(x).try_normalize()?;
    Some((a, size, DMat3::from_cols(x, y, x.cross(y))))
}

impl LightModel for PortalInfiniteLight {
    const KIND: &'static str = "infinite";

    fn is_delta(&self) -> bool {
        false
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn importance(&self, _: f64) -> f64 {
        brightness(self.power)
    }

    /// Its light arrives as that of its rectangle.
    fn extent(&self, _: &[SceneObject]) -> LightExtent {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let corners = corners.map(|corner| self.corner + self.frame * (self.size * corner).extend(0.0));
        let normal = DirectionCone { axis: -self.frame.z_axis, half_angle: 0.0 };
        let bounds = Bounds3::from_points(corners);
        LightExtent::Bounded(EmissionBounds {
            bounds,
            ..EmissionBounds::beam(self.corner, normal, FRAC_PI_2)
        })
    }

    fn sample(&self, _: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        let window = self.window(from.point.position)?;
        let (place, pdf) = self.radiance.windowed.as_ref()?.sample(xi, window)?;
        let local = direction_of(place);
        let wi = self.frame * local;
        Some(LightSample {
            wi,
            radiance: self.radiance.image.lookup(place),
            pdf: SolidAnglePdf(pdf / solid_angle_of_unit(local)),
            is_delta: false,
            shadow: from.spawn(wi),
            t_max: f64::INFINITY,
            area_pdf: None,
        })
    }

    /// A place on the rectangle, and a direction in proportion to radiance times cosine; `None` where something lies between the
    /// rectangle and the light.
    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
        let sample = self.radiance.through.as_ref()?.sample(direction);
        let local = direction_of(sample.point);
        let towards = self.frame * local;
        let origin = self.corner + self.frame * (place * self.size).extend(0.0);
        if scene.occluded(&Ray::new(origin, towards), f64::INFINITY) {
            return None;
        }
        let weight = solid_angle_of_unit(local) / sample.pdf * local.z * self.size.x * self.size.y;
        Some(LightRay::new(
            Ray::new(origin, -towards),
            self.radiance.image.lookup(sample.point) * weight as f32,
        ))
    }

    fn emission_pdf(&self, _: &Scene, at: DVec3, wi: DVec3, _: Option<AreaPdf>) -> f64 {
        let found = self.place_in_window(at, wi).zip(self.radiance.through.as_ref());
        found.map_or(0.0, |((place, _, local), through)| {
            let area = self.size.x * self.size.y * local.z;
            through.pdf(place) / (solid_angle_of_unit(local) * area)
        })
    }

    fn pdf_of_ray(&self, from: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
        self.pdf(from.position, -ray.ray.direction)
    }
}
