//! Lights: what they send to a point, and how to pick a direction towards them.

mod area;
mod arriving;
mod distant;
mod emission;
mod emission_pdf;
mod infinite;
mod opening;
mod photometric;
mod point;
mod rays;
mod select;
mod spot;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{AreaPdf, DVec2, DVec3, Ray, SolidAnglePdf};

use crate::interaction::Interaction;
use crate::scene::Scene;

pub use area::AreaLight;
pub use arriving::ArrivingLight;
pub use distant::DistantLight;
pub use emission::LightRay;
pub use infinite::InfiniteLight;
pub use photometric::PhotometricLight;
pub use point::PointLight;
pub use rays::RayLight;
pub(crate) use select::LightSelector;
pub use select::MAX_LIGHT_GROUPS;
pub use spot::SpotLight;

/// Number of a light of a [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// A light.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Light {
    /// A point that shines alike in all directions.
    Point(PointLight),
    /// A point that shines into a cone.
    Spot(SpotLight),
    /// A luminaire as it was measured.
    Photometric(PhotometricLight),
    /// Measured rays.
    Rays(RayLight),
    /// One direction, from infinitely far.
    Distant(DistantLight),
    /// A surface.
    Area(AreaLight),
    /// All directions, from infinitely far.
    Infinite(InfiniteLight),
}

impl Light {
    /// Its kind, as scene files name it.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(_) => "spot",
            Self::Photometric(_) | Self::Rays(_) => "photometric",
            Self::Distant(_) => "distant",
            Self::Area(_) => "diffuse",
            Self::Infinite(_) => "infinite",
        }
    }

    /// Whether all samples from one place are the same; then no ray can meet it by chance either.
    #[must_use]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) => true,
            Self::Photometric(light) => light.is_point(),
            Self::Rays(_) | Self::Area(_) | Self::Infinite(_) => false,
        }
    }

    /// Whether a ray can meet it by chance.
    #[must_use]
    pub fn can_be_met(&self) -> bool {
        matches!(self, Self::Area(_) | Self::Infinite(_))
    }

    /// Its power as a number for choosing between lights to send rays from, W; `radius` is that of the scene, metres.
    pub(crate) fn importance(&self, radius: f64) -> f64 {
        let wavelengths = Wavelengths::default();
        let bright = |s: Spectrum| f64::from(s.mean(&wavelengths).max(0.0));
        let disk = std::f64::consts::PI * radius * radius;
        match self {
            Self::Point(l) => bright(l.power()),
            Self::Spot(l) => bright(l.power()),
            Self::Photometric(l) => bright(l.power()),
            Self::Rays(l) => bright(l.power()),
            Self::Distant(l) => bright(l.irradiance()) * disk,
            Self::Area(l) if !l.can_be_sampled() => 0.0,
            Self::Area(l) => bright(l.power()),
            Self::Infinite(l) => bright(l.radiance()) * std::f64::consts::PI * 4.0 * disk,
        }
    }

    /// Whether a place can look for it: the rays of a file are met by nothing that does not follow them.
    pub(crate) fn can_be_looked_for(&self) -> bool {
        !matches!(self, Self::Rays(_))
    }

    /// Picks a direction from `from` towards the light by two numbers uniform in [0, 1).
    ///
    /// `None` if nothing can arrive. What stands between is not looked at: the shadow ray asks.
    #[must_use]
    pub fn sample(
        &self,
        scene: &Scene,
        from: &Interaction,
        xi: DVec2,
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        match self {
            Self::Point(l) => l.sample(from),
            Self::Spot(l) => l.sample(from),
            Self::Photometric(l) => l.sample(from, xi),
            Self::Rays(_) => None,
            Self::Distant(l) => Some(l.sample(from)),
            Self::Area(l) => l.sample(scene, from, xi),
            Self::Infinite(l) => l.sample(from, xi, wavelengths),
        }
    }
}

/// A direction picked towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: DVec3,
    /// Radiance that arrives if nothing stands between; for a delta light the irradiance on a surface that faces it.
    pub radiance: Spectrum,
    /// Density with which `wi` was picked; 1 for a delta light.
    pub pdf: SolidAnglePdf,
    /// Whether no other strategy can find this direction.
    pub is_delta: bool,
    /// The ray whose part with `0 < t < t_max` must be free.
    pub shadow: Ray,
    /// End of `shadow`.
    pub t_max: f64,
    /// Density with which [`Scene::emit`] picks the place `wi` leads to; `None` if that is not on a surface.
    pub area_pdf: Option<AreaPdf>,
}
