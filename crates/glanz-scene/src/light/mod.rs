//! Lights, one file each with all that a kind does, and the table of them.

mod area;
mod distant;
mod emission;
mod extent;
mod flat_image;
mod goniometric;
mod image_infinite;
mod incident;
mod infinite;
mod light_triangles;
mod opening;
mod photometric;
mod point;
mod portal;
mod projection;
mod rays;
mod select;
mod sky;
mod sphere_emission;
mod sphere_image;
mod spot;
mod sun;
mod tree;
mod world_sphere;

use glanz_job::BudgetError;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{AreaPdf, DMat3, DVec2, DVec3, Ray, SolidAnglePdf, Transform};
use glanz_shading::texture::MipMap;

use crate::description::{ImageDescription, LightDescription, LightKind, SphereMapping};
use crate::error::SceneErrorKind;
use crate::interaction::{Interaction, LightSampleContext};
use crate::object::SceneObject;
use crate::scene::Scene;

pub use area::AreaLight;
pub use distant::DistantLight;
pub use emission::{LightRange, LightRay};
use extent::DirectionCone;
pub(crate) use extent::LightExtent;
pub(crate) use flat_image::FlatImage;
pub use goniometric::GoniometricLight;
pub use image_infinite::ImageInfiniteLight;
pub use incident::IncidentLight;
pub use infinite::InfiniteLight;
pub use photometric::PhotometricLight;
pub use point::PointLight;
pub(crate) use portal::LEAST_SIDE as LEAST_PORTAL_SIDE;
pub use portal::PortalInfiniteLight;
pub use projection::ProjectionLight;
pub use rays::RayLight;
pub(crate) use select::LightSelector;
pub use sphere_image::{SphereImage, SphereTexel};
pub use spot::SpotLight;
pub use sun::SunLight;
pub(crate) use tree::LightTree;
pub use tree::{MAX_LIGHT_GROUPS, SelectedLight};

/// Number of a light of a [`Scene`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// A kind of light. The defaults are those of a point that no ray can hit.
trait LightModel {
    /// See [`Light::kind`].
    const KIND: &'static str;

    /// See [`Light::is_delta`].
    fn is_delta(&self) -> bool {
        true
    }

    /// See [`Light::can_be_hit`].
    fn can_be_hit(&self) -> bool {
        false
    }

    /// See [`Light::can_be_sampled`].
    fn can_be_sampled(&self) -> bool {
        true
    }

    /// See [`Light::importance`].
    fn importance(&self, radius: f64) -> f64;

    /// See [`Light::extent`].
    fn extent(&self, _world: &[SceneObject]) -> LightExtent {
        LightExtent::Distant(DirectionCone::ALL)
    }

    /// See [`Light::sample`].
    fn sample(&self, scene: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample>;

    /// See [`Scene::sample_light_compensated`].
    fn sample_compensated(&self, scene: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
        self.sample(scene, from, xi)
    }

    /// See [`Scene::emit`].
    fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay>;

    /// See [`Scene::emission_pdf`].
    fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, area_pdf: Option<AreaPdf>) -> f64;

    /// See [`Scene::light_pdf_of_ray`].
    fn pdf_of_ray(&self, _from: &LightSampleContext, _ray: &LightRay) -> SolidAnglePdf {
        SolidAnglePdf(1.0)
    }

    /// See [`Light::incident`].
    fn incident(&self, _point: DVec3) -> Option<IncidentLight> {
        None
    }

    /// See [`Light::warning`].
    fn warning(&self) -> Option<&'static str> {
        None
    }
}

// One line per kind; the macro generates the delegation for all of them.
macro_rules! lights {
    ($($(#[$doc:meta])* $variant:ident($light:ident),)*) => {
        /// A light.
        #[derive(Clone, Debug)]
        #[non_exhaustive]
        pub enum Light {
            $($(#[$doc])* $variant($light),)*
        }

        impl Light {
            /// Its kind, as scene files name it.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $light::KIND,)*
                }
            }

            /// Whether all samples from one place are the same; then no ray can hit it by chance either.
            #[must_use]
            pub fn is_delta(&self) -> bool {
                match self {
                    $(Self::$variant(light) => light.is_delta(),)*
                }
            }

            /// Whether a ray can hit it by chance.
            #[must_use]
            pub fn can_be_hit(&self) -> bool {
                match self {
                    $(Self::$variant(light) => light.can_be_hit(),)*
                }
            }

            /// Whether [`Light::sample`] finds directions towards it; if not, only paths that start there or hit it see its light.
            #[must_use]
            pub fn can_be_sampled(&self) -> bool {
                match self {
                    $(Self::$variant(light) => LightModel::can_be_sampled(light),)*
                }
            }

            /// Its mean power over the bands, W, as a weight for its selection to start paths at; 0 if none can start there. `radius`: that of the
            /// scene, metres.
            pub(crate) fn importance(&self, radius: f64) -> f64 {
                match self {
                    $(Self::$variant(light) => light.importance(radius),)*
                }
            }

            /// Its place and directions. `world`: the objects of the world.
            pub(crate) fn extent(&self, world: &[SceneObject]) -> LightExtent {
                match self {
                    $(Self::$variant(light) => light.extent(world),)*
                }
            }

            /// Samples a direction from `from` towards the light by two numbers uniform in [0, 1).
            ///
            /// `None` if nothing can arrive. Occlusion is left to the shadow ray.
            #[must_use]
            pub fn sample(&self, scene: &Scene, from: &Interaction, xi: DVec2) -> Option<LightSample> {
                match self {
                    $(Self::$variant(light) => LightModel::sample(light, scene, from, xi),)*
                }
            }

            /// See [`Scene::sample_light_compensated`].
            pub(crate) fn sample_compensated(
                &self,
                scene: &Scene,
                from: &Interaction,
                xi: DVec2,
            ) -> Option<LightSample> {
                match self {
                    $(Self::$variant(light) => LightModel::sample_compensated(light, scene, from, xi),)*
                }
            }

            /// The unoccluded light that arrives at `point` from a light that is seen from there in one direction.
            ///
            /// `None` for lights with an extent, and at the position of the light.
            #[must_use]
            pub fn incident(&self, point: DVec3) -> Option<IncidentLight> {
                match self {
                    $(Self::$variant(light) => light.incident(point),)*
                }
            }

            /// A warning about light that may differ from what the scene suggests.
            pub(crate) fn warning(&self) -> Option<&'static str> {
                match self {
                    $(Self::$variant(light) => light.warning(),)*
                }
            }

            #[inline]
            fn emit(&self, scene: &Scene, place: DVec2, direction: DVec2) -> Option<LightRay> {
                match self {
                    $(Self::$variant(light) => light.emit(scene, place, direction),)*
                }
            }

            fn emission_pdf(&self, scene: &Scene, at: DVec3, wi: DVec3, area_pdf: Option<AreaPdf>) -> f64 {
                match self {
                    $(Self::$variant(light) => light.emission_pdf(scene, at, wi, area_pdf),)*
                }
            }

            fn pdf_of_ray(&self, from: &LightSampleContext, ray: &LightRay) -> SolidAnglePdf {
                match self {
                    $(Self::$variant(light) => light.pdf_of_ray(from, ray),)*
                }
            }
        }
    };
}

lights! {
    /// A point that emits alike in all directions.
    Point(PointLight),
    /// A point that emits into a cone.
    Spot(SpotLight),
    /// A point that emits a picture into a pyramid.
    Projection(ProjectionLight),
    /// A point with a picture of its intensity.
    Goniometric(GoniometricLight),
    /// A measured luminaire.
    Photometric(PhotometricLight),
    /// Measured rays.
    Rays(RayLight),
    /// One direction, from infinitely far.
    Distant(DistantLight),
    /// A disk on the sky.
    Sun(SunLight),
    /// A surface.
    Area(AreaLight),
    /// All directions, from infinitely far.
    Infinite(InfiniteLight),
    /// All directions, from infinitely far, by a picture.
    ImageInfinite(ImageInfiniteLight),
    /// All directions, from infinitely far, through a rectangle.
    PortalInfinite(PortalInfiniteLight),
}

/// The parts of a light's description that all kinds have, resolved.
pub(crate) struct LightInput<'a> {
    pub(crate) description: &'a LightDescription,
    /// Pictures of the scene.
    pub(crate) images: &'a [ImageDescription],
    pub(crate) to_world: Transform,
    /// Intensity, radiance or irradiance, see [`LightKind`].
    pub(crate) emission: Spectrum,
    /// The spectrum of one candela, W/sr, which is also that of one lumen, W, times the scale of the light.
    pub(crate) per_candela: Result<Spectrum, SceneErrorKind>,
}

impl LightInput<'_> {
    /// The picture with this index, over all directions.
    fn sphere_image(&self, index: usize, mapping: SphereMapping) -> Result<SphereImage, SceneErrorKind> {
        SphereImage::try_new(self.picture(index)?, mapping).map_err(|error| BudgetError::from(error).into())
    }

    /// Its axes in the world; orthonormal, perhaps mirrored. `what`: name of the transformation in errors.
    fn axes(&self, what: &'static str) -> Result<DMat3, SceneErrorKind> {
        let axes = photometric::luminaire_axes(&self.to_world).map(|(axes, _)| axes);
        axes.ok_or_else(|| photometric::uneven(what))
    }

    fn picture(&self, index: usize) -> Result<&MipMap, SceneErrorKind> {
        picture_of(self.images, index)
    }
}

/// The picture with this index.
pub(crate) fn picture_of(images: &[ImageDescription], index: usize) -> Result<&MipMap, SceneErrorKind> {
    let reference = SceneErrorKind::Reference { what: "picture", index, count: images.len() };
    images.get(index).map(|image| &image.picture).ok_or(reference)
}

impl Light {
    /// Whether rays that leave the scene see it.
    pub(crate) fn is_infinite(&self) -> bool {
        matches!(self, Self::Infinite(_) | Self::ImageInfinite(_) | Self::PortalInfinite(_) | Self::Sun(_))
    }

    /// The light of a description.
    ///
    /// # Errors
    /// [`SceneErrorKind::Range`] for the first parameter out of range.
    pub(crate) fn try_new(input: LightInput<'_>) -> Result<Self, SceneErrorKind> {
        Ok(match &input.description.kind {
            LightKind::Point { from, range } => Self::Point(PointLight::resolve(&input, *from, *range)?),
            LightKind::Spot { from, to, cone_angle, inner_angle, falloff } => {
                Self::Spot(SpotLight::resolve(&input, [*from, *to], [*cone_angle, *inner_angle], *falloff)?)
            }
            LightKind::Projection { image, field_of_view } => {
                Self::Projection(ProjectionLight::resolve(&input, *image, *field_of_view)?)
            }
            LightKind::Goniometric { image, mapping } => {
                Self::Goniometric(GoniometricLight::resolve(&input, *image, *mapping)?)
            }
            LightKind::Photometric { distribution, opening, from } => {
                Self::Photometric(PhotometricLight::resolve(input, distribution, *opening, *from)?)
            }
            LightKind::Rays { rays, from } => Self::Rays(RayLight::resolve(input, rays, *from)?),
            LightKind::Distant { from, to } => Self::Distant(DistantLight::resolve(&input, *from, *to)?),
            LightKind::Sun { from, to, angular_radius } => {
                Self::Sun(SunLight::resolve(&input, [*from, *to], *angular_radius)?)
            }
            LightKind::Infinite => Self::Infinite(InfiniteLight::new(input.emission)),
            LightKind::ImageInfinite { image, mapping } => {
                Self::ImageInfinite(ImageInfiniteLight::resolve(&input, *image, *mapping)?)
            }
            LightKind::Sky(sky) => Self::ImageInfinite(sky::resolve(&input, sky)?),
            LightKind::OvercastSky { albedo } => Self::ImageInfinite(sky::resolve_overcast(&input, *albedo)?),
            LightKind::PortalInfinite { image, portal } => {
                Self::PortalInfinite(PortalInfiniteLight::resolve(&input, *image, *portal)?)
            }
        })
    }
}

fn range_error(what: &'static str, value: impl ToString, range: &'static str) -> SceneErrorKind {
    SceneErrorKind::Range { what, value: value.to_string(), range }
}

/// Mean over the bands, not below 0.
fn brightness(light: Spectrum) -> f64 {
    f64::from(light.mean(&Wavelengths::default()).max(0.0))
}

/// A direction sampled towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: DVec3,
    /// Unoccluded radiance, on average over the rays that its opacity stops; for a light without extent the irradiance on a surface that faces it.
    pub radiance: Spectrum,
    /// Density with which `wi` was sampled; 1 for a light without extent.
    pub pdf: SolidAnglePdf,
    /// Whether no other strategy can find this direction.
    pub is_delta: bool,
    /// The ray whose part with `0 < t < t_max` must be free.
    pub shadow: Ray,
    /// End of `shadow`.
    pub t_max: f64,
    /// Density with which [`Scene::emit`] samples the point that `wi` leads to; `None` if that is not on a surface.
    pub area_pdf: Option<AreaPdf>,
}

impl LightSample {
    /// Distance of the light, metres; infinite for a distant light.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.t_max * self.shadow.direction.length()
    }
}
