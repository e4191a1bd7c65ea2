//! Lights and the emission of surfaces.

use std::sync::Arc;

use glanz_light::SpectralDistribution;
use glanz_light::intensity::{IntensityDistribution, LuminousOpening};
use glanz_math::{DMat4, DVec3};

use super::{Location, LuminaireDescription};

/// A light that is not a surface.
#[derive(Clone, Debug)]
pub struct LightDescription {
    /// Its kind with its parameters.
    pub kind: LightKind,
    /// Intensity, radiance, irradiance or colour, see [`LightKind`].
    pub emission: SpectralDistribution,
    /// Factor on `emission`.
    pub scale: f32,
    /// Transformation from light to world space.
    pub to_world: DMat4,
    /// The luminaire, if its file describes one.
    pub luminaire: Option<Arc<LuminaireDescription>>,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl LightDescription {
    /// A light in world space.
    #[must_use]
    pub fn new(kind: LightKind, emission: impl Into<SpectralDistribution>) -> Self {
        let (to_world, luminaire, location) = (DMat4::IDENTITY, None, None);
        Self { kind, emission: emission.into(), scale: 1.0, to_world, luminaire, location }
    }

    /// A point that emits `intensity`, W/sr, in all directions.
    #[must_use]
    pub fn point(from: impl Into<DVec3>, intensity: impl Into<SpectralDistribution>) -> Self {
        Self::new(LightKind::Point { from: from.into(), range: None }, intensity)
    }

    /// A point that emits `intensity`, W/sr, along an axis, and less towards the border of a cone; `cone_angle` and `inner_angle` are
    /// half angles, radians.
    #[must_use]
    pub fn spot(
        from: impl Into<DVec3>,
        to: impl Into<DVec3>,
        [cone_angle, inner_angle]: [f64; 2],
        intensity: impl Into<SpectralDistribution>,
    ) -> Self {
        let (from, to, falloff) = (from.into(), to.into(), SpotFalloff::Smoothstep);
        Self::new(LightKind::Spot { from, to, cone_angle, inner_angle, falloff }, intensity)
    }

    /// Parallel light from `from` towards `to` of an `irradiance`, W/m^2, on surfaces that face it.
    #[must_use]
    pub fn distant(
        from: impl Into<DVec3>,
        to: impl Into<DVec3>,
        irradiance: impl Into<SpectralDistribution>,
    ) -> Self {
        Self::new(LightKind::Distant { from: from.into(), to: to.into() }, irradiance)
    }

    /// An overcast sky that gives the open ground this `irradiance`, W/m^2, and ground of an albedo of 0.2.
    #[must_use]
    pub fn overcast_sky(irradiance: impl Into<SpectralDistribution>) -> Self {
        Self::new(LightKind::OvercastSky { albedo: [0.2; 3] }, irradiance)
    }

    /// A sky of the same `radiance`, W/(m^2 sr), in all directions.
    #[must_use]
    pub fn infinite(radiance: impl Into<SpectralDistribution>) -> Self {
        Self::new(LightKind::Infinite, radiance)
    }
}

/// The lights that are not surfaces; points and directions in light space.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Emits W/sr alike in all directions.
    Point {
        /// Its position.
        from: DVec3,
        /// Distance at which it has faded to nothing, metres.
        range: Option<f64>,
    },
    /// Emits W/sr into a cone.
    Spot {
        /// Its position.
        from: DVec3,
        /// A point of its axis.
        to: DVec3,
        /// Half angle of the cone, radians.
        cone_angle: f64,
        /// Half angle inside which the intensity is constant, radians.
        inner_angle: f64,
        /// The falloff between the two.
        falloff: SpotFalloff,
    },
    /// Factor on the intensity, W/sr, of a picture that the origin of light space emits into a pyramid around z; y is up, x to the right.
    Projection {
        /// Index into [`Description::images`](super::Description::images).
        image: usize,
        /// Angle of the shorter side, radians, between 0 and pi.
        field_of_view: f64,
    },
    /// Factor on the intensity, W/sr, of a picture over all directions that the origin of light space emits.
    Goniometric {
        /// Index into [`Description::images`](super::Description::images).
        image: usize,
        /// Directions in light space, of which y and z are exchanged: y is up.
        mapping: SphereMapping,
    },
    /// Emits the measured candela of a luminaire; of the emission only the colour counts, not the magnitude.
    Photometric {
        /// Candela by direction in light space, which is the [luminaire's frame](glanz_light::intensity).
        distribution: Arc<IntensityDistribution>,
        /// The luminous opening, which emits evenly; `None`: a point.
        opening: Option<LuminousOpening>,
        /// Position of the photometric centre.
        from: DVec3,
    },
    /// Emits rays in proportion to their flux; of the emission only the colour counts, not the magnitude.
    Rays {
        /// The rays in light space.
        rays: Arc<[SourceRay]>,
        /// Position of their origin.
        from: DVec3,
    },
    /// W/m^2 on a surface that faces it, from one direction.
    Distant {
        /// A point from which the light comes ...
        from: DVec3,
        /// ... and one to which it goes.
        to: DVec3,
    },
    /// W/m^2 on a surface that faces its middle, from all directions of a cone.
    Sun {
        /// A point from which the light of the middle comes ...
        from: DVec3,
        /// ... and one to which it goes.
        to: DVec3,
        /// Half angle of the cone, radians, in (0, pi / 2].
        angular_radius: f64,
    },
    /// W/(m^2 sr) from every direction.
    Infinite,
    /// Factor on the radiance, W/(m^2 sr), of a picture over all directions.
    ImageInfinite {
        /// Index into [`Description::images`](super::Description::images).
        image: usize,
        /// Directions in light space.
        mapping: SphereMapping,
    },
    /// A clear sky with z up, times the emission; its sun is a separate light.
    Sky(SkyDescription),
    /// W/m^2 on the open ground, from an overcast sky with z up: that of the CIE, three times as bright in the zenith as at the horizon.
    OvercastSky {
        /// Albedo of the ground, linear Rec. 709, in [0, 1]; directions below the horizon show it.
        albedo: [f32; 3],
    },
    /// As [`LightKind::ImageInfinite`] or [`LightKind::Infinite`], through a rectangle only.
    PortalInfinite {
        /// Index into [`Description::images`](super::Description::images), and directions in light space; `None`: the same from everywhere.
        image: Option<(usize, SphereMapping)>,
        /// Corners of the rectangle in order, in world space; counterclockwise seen from where the light goes.
        portal: [DVec3; 4],
    },
}

/// A clear sky, see [`ClearSky`](glanz_light::ClearSky).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyDescription {
    /// Direction to the sun, of any length, not below the horizon.
    pub towards_sun: DVec3,
    /// From 1 to 10.
    pub turbidity: f64,
    /// Albedo of the ground, linear Rec. 709, in [0, 1]; directions below the horizon show the ground.
    pub albedo: [f32; 3],
    /// Whether the sun lights the ground.
    pub is_ground_sunlit: bool,
}

/// Mapping of a picture to all directions; z is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SphereMapping {
    /// Rows from z to -z by the angle from z, columns by the angle about z from x towards y (pbrt v3).
    LatitudeLongitude,
    /// Pixels of the same solid angle: z in the middle, -z in the corners, x on the right, y at the bottom (@clarberg2008, pbrt v4).
    EqualArea,
}

/// A ray of a light source. Sources have millions, hence single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceRay {
    /// Origin, metres.
    pub origin: [f32; 3],
    /// Unit direction.
    pub direction: [f32; 3],
    /// Its luminous flux.
    pub lumens: f32,
}

/// Falloff of a spot light between inner and outer angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpotFalloff {
    /// Fourth power of the linear fraction of cosines (pbrt v3).
    Quartic,
    /// Smoothstep of the linear fraction of cosines (pbrt v4).
    Smoothstep,
}

/// Emission of a surface, from each point the same in all directions of its front.
#[derive(Clone, Debug)]
pub struct EmissionDescription {
    /// W/(m^2 sr).
    pub radiance: SpectralDistribution,
    /// Factor on `radiance`.
    pub scale: f32,
    /// Picture by texture coordinates that multiplies `radiance`: an index into [`Description::images`](super::Description::images). (0, 0) is its lower left
    /// corner, (1, 1) the upper right one; beyond, it continues as at its border.
    pub image: Option<usize>,
    /// A power that replaces the magnitude of `radiance`.
    pub power: Option<EmissionPower>,
    /// Whether the back emits light, too.
    pub two_sided: bool,
}

impl From<SpectralDistribution> for EmissionDescription {
    /// This radiance, W/(m^2 sr), on the front.
    fn from(radiance: SpectralDistribution) -> Self {
        Self { radiance, scale: 1.0, image: None, power: None, two_sided: false }
    }
}

impl From<f32> for EmissionDescription {
    /// White light of this radiance, W/(m^2 sr), on the front.
    fn from(radiance: f32) -> Self {
        SpectralDistribution::from(radiance).into()
    }
}

impl From<[f32; 3]> for EmissionDescription {
    /// This radiance in linear Rec. 709, W/(m^2 sr), on the front.
    fn from(radiance: [f32; 3]) -> Self {
        SpectralDistribution::from(radiance).into()
    }
}

/// Total emission of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmissionPower {
    /// Radiant flux, of which the luminance counts, W.
    Watts(f32),
    /// Luminous flux, lm.
    Lumens(f64),
    /// Luminous intensity along the normal of a flat surface, or of a whole sphere in any direction from outside, cd.
    Candela(f64),
}
