//! Points where rays hit the scene.

use glanz_geometry::ShadingPoint;
use glanz_light::Wavelengths;
use glanz_math::rounding::offset_origin;
use glanz_math::{AreaPdf, DVec2, DVec3, Frame, Ray};
use glanz_sampling::hash::{combine, unit_f64};
use glanz_shading::{Bsdf, Material, TexturePoint};

use crate::differential::SurfaceDifferential;
use crate::light::LightId;
use crate::medium::MediumInterface;
use crate::parameterization::LocalPoint;
use crate::scene::Scene;

/// The point that lights are sampled from, as far as densities depend on it.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Position, metres.
    pub position: DVec3,
    /// Unit normal for shading, see [`Interaction::normal_for`]; `None` in a medium.
    pub shading_normal: Option<DVec3>,
    /// Unit direction to the viewer.
    pub wo: DVec3,
    /// Unit normal of the side from which light is scattered to the viewer; `None` if that may be both.
    pub normal: Option<DVec3>,
}

/// The point where a ray hit the scene, in world space.
#[derive(Clone, Copy, Debug)]
pub struct Interaction {
    /// The surface at the point.
    pub point: ShadingPoint,
    /// Ray parameter of the hit: the distance, for rays of unit direction.
    pub t: f64,
    /// Unit direction back along the ray.
    pub wo: DVec3,
    /// Number of the shape in the order of the scene file; `u32::MAX` in a medium.
    pub id: u32,
    /// How the point moves with that of the film, if the ray has a differential.
    pub differential: Option<SurfaceDifferential>,
    /// The point in the frame of its shape; `None` if that is the world's.
    pub(crate) own: Option<LocalPoint>,
    /// Density of area sampling at the point, on lights that can be sampled.
    pub(crate) area_pdf: Option<AreaPdf>,
    pub(crate) material: u32,
    pub(crate) media: MediumInterface,
    pub(crate) light: Option<LightId>,
}

impl Interaction {
    /// A point that is known to lie on a surface, seen along its unit `normal`. `error`: absolute bound per axis on the distance from `position` to the
    /// surface, metres. It has no material or light of its own.
    #[must_use]
    pub fn on_surface(position: DVec3, error: DVec3, normal: DVec3) -> Self {
        let (uv, dpdu) = (DVec2::ZERO, DVec3::ZERO);
        Self {
            point: ShadingPoint { position, error, normal, shading_normal: normal, uv, dpdu },
            t: 0.0,
            wo: normal,
            id: 0,
            differential: None,
            own: None,
            area_pdf: None,
            material: 0,
            media: MediumInterface::NONE,
            light: None,
        }
    }

    /// The point as the origin of light samples, which may come from both sides.
    #[inline]
    #[must_use]
    pub fn light_sample_context(&self) -> LightSampleContext {
        LightSampleContext {
            position: self.point.position,
            shading_normal: (!self.is_in_medium()).then(|| self.normal_for(self.wo)),
            wo: self.wo,
            normal: None,
        }
    }

    /// The normal by which light is scattered to `viewer`, a unit direction: where that is on the wrong side of the shading normal, the normal of the
    /// surface, because it would be black otherwise.
    #[must_use]
    pub fn normal_for(&self, viewer: DVec3) -> DVec3 {
        let ShadingPoint { normal, shading_normal, .. } = self.point;
        if normal.dot(viewer) * shading_normal.dot(viewer) <= 0.0 { normal } else { shading_normal }
    }

    /// A frame for isotropic BSDFs: z is the shading normal, the tangents are any.
    #[must_use]
    pub fn frame(&self) -> Frame {
        Frame::from_z(self.point.shading_normal)
    }

    /// The frame for `bsdf`: z is the unit vector `normal`, and of an anisotropic BSDF the tangents follow the parameters of the surface.
    #[must_use]
    pub fn frame_of(&self, bsdf: &Bsdf<'_>, normal: DVec3) -> Frame {
        if bsdf.is_anisotropic() {
            Frame::from_z_and_tangent(normal, self.point.dpdu)
        } else {
            Frame::from_z(normal)
        }
    }

    /// The BSDF at the point; `None` for an interface, which all rays pass.
    #[must_use]
    pub fn bsdf<'a>(&self, scene: &'a Scene, wavelengths: &Wavelengths) -> Option<Bsdf<'a>> {
        let footprint = self.differential.as_ref().map(|differential| differential.footprint);
        let at = TexturePoint::new(self.point.uv, self.point.position).with_normal(self.point.normal);
        let at = at.with_footprint(footprint);
        let mut material = scene.material(self.material);
        if matches!(material, Material::Mix(_)) {
            // As in pbrt, the same for every ray that comes along the same line: pictures do not depend on threads.
            let numbers = self.point.position.to_array().into_iter().chain(self.wo.to_array());
            let hash = numbers.fold(u64::from(self.id), |key, x| combine(key, x.to_bits()));
            material = scene.material_at(self.material as usize, &at, wavelengths, unit_f64(hash))?;
        }
        material.bsdf(scene.textures(), &at, wavelengths)
    }

    /// The point in the frame of its shape.
    pub(crate) fn local_point(&self) -> LocalPoint {
        self.own.unwrap_or_else(|| LocalPoint::new(self.point.position, self.point.normal, -self.wo))
    }

    /// Density with which [`Scene::emit`] samples this point, if it is on a light that can be sampled.
    #[must_use]
    pub fn area_pdf(&self) -> Option<AreaPdf> {
        self.area_pdf
    }

    /// The light that this surface is, if it emits.
    #[must_use]
    pub fn light(&self) -> Option<LightId> {
        self.light
    }

    /// A ray from the point along `direction` that does not hit this surface again at its own origin.
    #[must_use]
    pub fn spawn(&self, direction: DVec3) -> Ray {
        Ray::new(self.leave(direction), direction)
    }

    /// A ray from this point to `point`, which it reaches at t = 1, apart from the error box of `point` on a surface.
    ///
    /// `surface`: error box and unit normal of `point`, if it lies on a surface: the ray ends on the near side of it.
    #[must_use]
    pub fn spawn_to(&self, point: DVec3, surface: Option<(DVec3, DVec3)>) -> Ray {
        let target = match surface {
            Some((error, normal)) => offset_origin(point, error, normal, self.point.position - point),
            None => point,
        };
        let origin = self.leave(target - self.point.position);
        Ray::new(origin, target - origin)
    }

    fn leave(&self, direction: DVec3) -> DVec3 {
        offset_origin(self.point.position, self.point.error, self.point.normal, direction)
    }
}
