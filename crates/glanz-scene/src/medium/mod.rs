//! Participating media: what absorbs, scatters and emits light between surfaces.

mod grid;
mod segments;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec3, Ray};
use glanz_shading::HenyeyGreenstein;

use crate::interaction::Interaction;
use crate::scene::Scene;

pub(crate) use grid::DensityGrid;
pub use grid::MAX_DENSITIES;
pub use segments::{MediumSegment, MediumSegments};

/// Largest number of media.
pub const MAX_MEDIA: usize = u16::MAX as usize;

/// Number of a medium of a [`Scene`], or empty space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MediumId(u16);

impl MediumId {
    /// Empty space.
    pub const VACUUM: Self = Self(u16::MAX);

    /// The medium of this index, below [`MAX_MEDIA`].
    pub(crate) fn new(index: usize) -> Self {
        Self(u16::try_from(index).unwrap_or(u16::MAX))
    }
}

/// The media on both sides of a surface; if they are the same, it has no part in where media end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MediumInterface {
    /// Opposite to the normal.
    pub(crate) inside: MediumId,
    /// On the side of the normal.
    pub(crate) outside: MediumId,
}

impl MediumInterface {
    /// Of a surface at which no medium ends.
    pub(crate) const NONE: Self = Self { inside: MediumId::VACUUM, outside: MediumId::VACUUM };

    /// Whether a medium ends at the surface.
    #[inline]
    pub(crate) fn is_boundary(self) -> bool {
        self.inside != self.outside
    }
}

/// Coefficients of a medium at density 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumCoefficients {
    /// Absorption and scattering together, 1/m.
    pub extinction: Spectrum,
    /// Scattering over extinction; 0 where that is 0.
    pub albedo: Spectrum,
    /// Emitted radiance times absorption over extinction, W/(m^2 sr); of homogeneous media only.
    pub source: Spectrum,
}

impl MediumCoefficients {
    /// The radiance that a homogeneous medium emits towards the start of a `distance`, metres: the integral of the transmittance times absorption times
    /// emission, which has a closed form.
    #[must_use]
    pub fn emitted(&self, distance: f64) -> Spectrum {
        // Not 1 minus the transmittance, of which little is left in thin media.
        let distance = distance.min(f64::from(f32::MAX)) as f32;
        self.source * self.extinction.map(|sigma| -(-sigma * distance).exp_m1())
    }

    /// Coefficients in linear Rec. 709 at `wavelengths`.
    fn upsampled(&self, wavelengths: &Wavelengths) -> Self {
        // Rounding may leave a little less than nothing where a colour has no light.
        let at = |rgb: Spectrum| rgb.upsampled(wavelengths).map(|x| x.max(0.0));
        // Scattering becomes a spectrum, not its ratio to extinction, so that no more is scattered than is taken out.
        let (extinction, scattering) = (at(self.extinction), at(self.extinction * self.albedo));
        let albedo =
            scattering.zip(extinction, |part, all| if all > 0.0 { (part / all).min(1.0) } else { 0.0 });
        // What absorbs emits: the colour of the emission is that of the light divided by what is not scattered.
        let absorbed = |albedo: Spectrum| Spectrum::ONE - albedo;
        let emission = self
            .source
            .zip(absorbed(self.albedo), |source, part| if part > 0.0 { source / part } else { 0.0 });
        let emission = emission.upsampled_light(wavelengths).map(|x| x.max(0.0));
        Self { extinction, albedo, source: emission * absorbed(albedo) }
    }
}

/// A participating medium.
#[derive(Clone, Debug)]
pub struct Medium {
    /// In linear Rec. 709.
    pub(crate) coefficients: MediumCoefficients,
    pub(crate) phase: HenyeyGreenstein,
    /// `None`: 1 everywhere.
    pub(crate) density: Option<DensityGrid>,
}

impl Medium {
    /// The coefficients at `wavelengths`.
    #[inline]
    #[must_use]
    pub fn coefficients(&self, wavelengths: &Wavelengths) -> MediumCoefficients {
        match wavelengths {
            Wavelengths::Rgb => self.coefficients,
            _ => self.coefficients.upsampled(wavelengths),
        }
    }

    /// The angular distribution of scattered light.
    #[must_use]
    pub fn phase(&self) -> HenyeyGreenstein {
        self.phase
    }

    /// Whether it is the same everywhere.
    #[must_use]
    pub fn is_homogeneous(&self) -> bool {
        self.density.is_none()
    }

    /// The density at a point: the factor on the coefficients.
    #[must_use]
    pub fn density(&self, at: DVec3) -> f64 {
        self.density.as_ref().map_or(1.0, |grid| grid.density(at))
    }

    /// The parts of a ray with `0 < t < t_max` in which there is something of the medium, with bounds on its density.
    #[must_use]
    pub fn segments(&self, ray: &Ray, t_max: f64) -> MediumSegments<'_> {
        match &self.density {
            None => MediumSegments::homogeneous(t_max),
            Some(grid) => grid.segments(ray, t_max),
        }
    }
}

/// The fraction of light left after a `distance`, metres, with an `extinction`, 1/m (Beer's law).
#[must_use]
pub fn transmittance(extinction: Spectrum, distance: f64) -> Spectrum {
    // An infinite distance times no extinction would be no number.
    let distance = distance.min(f64::from(f32::MAX)) as f32;
    extinction.map(|sigma| (-sigma * distance).exp())
}

impl Scene {
    /// The medium `id`; `None` for empty space.
    #[inline]
    #[must_use]
    pub fn medium(&self, id: MediumId) -> Option<&Medium> {
        self.media.media.get(id.0 as usize)
    }

    /// The medium around the camera.
    #[must_use]
    pub fn camera_medium(&self) -> MediumId {
        self.media.camera
    }

    /// Whether there are participating media.
    #[must_use]
    pub fn has_media(&self) -> bool {
        !self.media.media.is_empty()
    }

    /// Whether a medium emits light.
    #[must_use]
    pub fn has_emissive_media(&self) -> bool {
        self.media.media.iter().any(|medium| !medium.coefficients.source.is_black())
    }

    /// Whether media end at surfaces that shadow rays pass, so that a ray that nothing stops may lie in several of them.
    #[must_use]
    pub fn has_open_media(&self) -> bool {
        self.media.are_open
    }
}

/// The media of a scene.
#[derive(Clone, Debug)]
pub(crate) struct SceneMedia {
    pub(crate) media: Vec<Medium>,
    pub(crate) camera: MediumId,
    /// See [`Scene::has_open_media`].
    pub(crate) are_open: bool,
}

/// Stands for the number of the shape of a point in a medium.
const NO_SHAPE: u32 = u32::MAX;

impl Interaction {
    /// A point in a medium where light may be scattered: it has no error, and its normal is the unit direction `wo` back along the ray. `t`: its
    /// parameter.
    #[must_use]
    pub fn in_medium(position: DVec3, t: f64, wo: DVec3) -> Self {
        Self { t, id: NO_SHAPE, ..Self::on_surface(position, DVec3::ZERO, wo) }
    }

    /// Whether it is a point of [`Interaction::in_medium`].
    #[inline]
    #[must_use]
    pub fn is_in_medium(&self) -> bool {
        self.id == NO_SHAPE
    }

    /// Whether it is on an interface, which light passes.
    #[must_use]
    pub fn is_interface(&self, scene: &Scene) -> bool {
        scene.material(self.material).is_interface()
    }

    /// The medium on the side of `direction`; `current`: the medium of the ray that hit the surface.
    #[inline]
    #[must_use]
    pub fn medium_towards(&self, direction: DVec3, current: MediumId) -> MediumId {
        if !self.media.is_boundary() {
            current
        } else if self.point.normal.dot(direction) > 0.0 {
            self.media.outside
        } else {
            self.media.inside
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::SampledWavelengths;
    use glanz_math::DMat4;

    use super::*;
    use crate::SceneBuilder;
    use crate::description::*;

    #[test]
    fn surfaces_have_their_media_also_in_joined_meshes_and_mirrored_copies() {
        let triangle = |z: f64| {
            ShapeDescription::mesh(
                vec![DVec3::new(-9.0, -9.0, z), DVec3::new(9.0, -9.0, z), DVec3::new(0.0, 9.0, z)],
                vec![[0, 1, 2]],
            )
        };
        let media = [
            MediumDescription::new(1.0, 0.0),
            MediumDescription::new(0.0, 0.0),
            MediumDescription::new(0.0, 1.0),
        ];
        let (scene, _) = SceneBuilder::new()
            .edit(|description| description.media.extend(media))
            .shape(triangle(0.0).enclosing(0, Some(2)), MaterialKind::diffuse(0.5))
            .shape(triangle(1.0).enclosing(2, None), MaterialKind::Interface)
            // Empty space on both sides, by a medium that does nothing.
            .shape(triangle(2.0).enclosing(1, None), MaterialKind::diffuse(0.5))
            .group("turned", |group| {
                group.shape(triangle(-3.0).enclosing(0, None), MaterialKind::diffuse(0.5))
            })
            .instance("turned", DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)))
            .resolve()
            .unwrap();
        let (a, b, none) = (MediumId(0), MediumId(1), MediumId::VACUUM);
        assert!(scene.has_media() && scene.has_open_media());
        let current = MediumId(77);
        let mut z = 9.0;
        // From above; the copy is at z = 3 with its normal downwards.
        for (expected, below, above) in [(3.0, none, a), (2.0, current, current), (1.0, b, none), (0.0, a, b)]
        {
            let ray = Ray::new(DVec3::new(0.1, 0.2, z), -DVec3::Z);
            let hit = scene.intersect(&ray, f64::INFINITY).unwrap();
            assert_eq!(hit.point.position.z, expected);
            assert_eq!(hit.medium_towards(-DVec3::Z, current), below, "{expected}");
            assert_eq!(hit.medium_towards(DVec3::Z, current), above, "{expected}");
            assert_eq!(hit.is_interface(&scene), expected == 1.0);
            z = expected - 0.5;
        }
    }

    #[test]
    fn grey_media_are_the_same_at_all_wavelengths_and_shine_as_daylight() {
        let grey = |x: f32| Spectrum::from_rgb([x; 3]);
        let coefficients =
            MediumCoefficients { extinction: grey(3.0), albedo: grey(0.25), source: grey(1.5) };
        let sampled = Wavelengths::Sampled(SampledWavelengths::sample(0.37));
        let found = coefficients.upsampled(&sampled);
        assert_eq!((found.extinction, found.albedo), (Spectrum::splat(3.0), Spectrum::splat(0.25)));
        let off = found.source - grey(1.5).upsampled_light(&sampled);
        assert!(off.map(f32::abs).max_component() < 1e-5, "{found:?}");
    }

    #[test]
    fn emission_of_media_with_densities_is_refused() {
        let density = DensityDescription {
            resolution: [1, 1, 2],
            values: [1.0, 2.0].into(),
            corners: [DVec3::ZERO, DVec3::ONE],
            to_world: DMat4::IDENTITY,
        };
        let dense = MediumDescription { density: Some(density), ..MediumDescription::new(1.0, 0.5) };
        let resolved = |medium: MediumDescription| {
            SceneBuilder::new().edit(|description| description.media.push(medium)).resolve()
        };
        assert!(resolved(dense.clone()).is_ok());
        let error = resolved(MediumDescription { emission: 0.5.into(), ..dense }).unwrap_err().to_string();
        assert!(error.contains("medium: emission") && error.contains("densities"), "{error}");
    }

    #[test]
    fn media_that_do_not_exist_are_an_error() {
        let shape = ShapeDescription::sphere(1.0).enclosing(3, None);
        let error = SceneBuilder::new().shape(shape, MaterialKind::Interface).resolve().unwrap_err();
        assert_eq!(error.to_string(), "medium number 3 does not exist; there are 0");
        let lost = SceneBuilder::new().edit(|description| description.camera_medium = Some(0));
        assert!(lost.resolve().is_err());
    }
}
