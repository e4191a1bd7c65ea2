//! Differentials of rays: how rays and their hits move with the point of the film. They give the footprints that textures are filtered by.
//!
//! A ray of the camera has the derivatives of its origin and direction by the film. At a surface they become those of the hit and its normal,
//! by the first and second derivatives of the surface, and behind a mirror or clear glass those of the next ray. They are exact
//! to the first order, save that the curvature of bumps and of maps of normals is left out.
//!
//! After a rough surface a path has none: its directions are spread over much more than a pixel, and their own mean is that of the
//! texture. (@pharr2023 section 10.1 approximates it by that of a camera which sees the point directly. That saves memory where textures are read from files
//! by parts, and is biased.) Light paths and shadow rays have none either.
//!
//! # Source
//! @igehy1999; @pharr2023 section 10.1.

use glanz_geometry::{Hit, RaySurface, SurfacePoint};
use glanz_math::{DVec2, DVec3, Ray, Transform};
use glanz_shading::texture::TextureFootprint;

use crate::object::SceneObject;

/// Derivatives of a ray by the point of the film, along x and along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayDifferential {
    /// Derivatives of the origin, metres.
    pub origin: [DVec3; 2],
    /// Derivatives of the unit direction.
    pub direction: [DVec3; 2],
}

impl RayDifferential {
    /// The derivatives by film points in units of `spacing`.
    #[must_use]
    pub fn scaled(&self, spacing: f64) -> Self {
        let scaled = |sides: [DVec3; 2]| sides.map(|side| spacing * side);
        Self { origin: scaled(self.origin), direction: scaled(self.direction) }
    }
}

/// Derivatives at the hit of a ray by the point of the film, along x and along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDifferential {
    /// Derivatives of the point, in the tangent plane.
    pub footprint: TextureFootprint,
    /// Derivatives of the unit normal for shading without bumps; not finite at the poles of a curved surface.
    pub normal: [DVec3; 2],
    /// Derivatives of the unit direction of the ray.
    pub direction: [DVec3; 2],
}

impl SurfaceDifferential {
    /// The derivatives at `point`, where a ray of unit direction arrives with parameter `t`. `normal`: `[dn/du, dn/dv]` of the shading normal; `uv_rates`: as of
    /// [`RaySurface::uv_rates`]. `None` where the point's is not finite, as on a surface that the ray grazes.
    pub(crate) fn try_new(
        ray: &Ray,
        differential: &RayDifferential,
        t: f64,
        point: &SurfacePoint,
        normal: [DVec3; 2],
        uv_rates: [DVec2; 2],
    ) -> Option<Self> {
        let cosine = point.normal.dot(ray.direction);
        let position = [0, 1].map(|i| {
            let across = differential.origin[i] + t * differential.direction[i];
            across - ray.direction * (point.normal.dot(across) / cosine)
        });
        let uv = position.map(|side| parameters(side, point));
        let is_flat = normal == [DVec3::ZERO; 2];
        let normal = uv.map(|uv| if is_flat { DVec3::ZERO } else { uv.x * normal[0] + uv.y * normal[1] });
        let by_rates = |uv: DVec2| uv.x * uv_rates[0] + uv.y * uv_rates[1];
        let uv = uv.map(|uv| if uv.is_finite() { by_rates(uv) } else { DVec2::ZERO });
        let footprint = TextureFootprint { uv, position };
        let finite = position.iter().all(|side| side.is_finite());
        finite.then_some(Self { footprint, normal, direction: differential.direction })
    }

    /// The derivatives of the ray that passes the surface.
    #[must_use]
    pub fn passed(&self) -> RayDifferential {
        RayDifferential { origin: self.footprint.position, direction: self.direction }
    }

    /// The derivatives of the ray that is mirrored or refracted, all directions of unit length. `arriving`, `leaving`: the directions of the rays; `normal`:
    /// that for shading; `eta`: the refractive index of the side of `arriving` over that of `leaving`.
    ///
    /// With the cosines c and c' of both rays to the normal n, the direction is `d' = eta d + (c' - eta c) n`, and `c'^2 = 1 - eta^2 (1 - c^2)` also for a
    /// mirror, where eta is 1. `None` where they are not finite, as at the critical angle and at poles.
    #[must_use]
    pub fn scattered(
        &self,
        arriving: DVec3,
        leaving: DVec3,
        normal: DVec3,
        eta: f64,
    ) -> Option<RayDifferential> {
        let [c, c_leaving] = [arriving, leaving].map(|direction| direction.dot(normal));
        let direction = [0, 1].map(|i| {
            let (d, n) = (self.direction[i], self.normal[i]);
            let dc = d.dot(normal) + arriving.dot(n);
            let dc_leaving = eta * eta * c / c_leaving * dc;
            eta * d + (c_leaving - eta * c) * n + (dc_leaving - eta * dc) * normal
        });
        let finite = direction.iter().all(|side| side.is_finite());
        finite.then_some(RayDifferential { origin: self.footprint.position, direction })
    }
}

/// The change of the texture coordinates with the change `side` of the point in the tangent plane; not finite where the parameters degenerate.
fn parameters(side: DVec3, point: &SurfacePoint) -> DVec2 {
    let SurfacePoint { dpdu, dpdv, .. } = *point;
    let across = dpdu.cross(dpdv);
    DVec2::new(side.cross(dpdv).dot(across), dpdu.cross(side).dot(across)) / across.length_squared()
}

impl SceneObject {
    /// The point at a hit in the world, and the derivatives `[dn/du, dn/dv]` of its shading normal. `local`: the ray in the frame of the surface. `maps`: the
    /// transformations from the world, outermost first, to the group of the object.
    pub(crate) fn differential_point(
        &self,
        local: &Ray,
        hit: &Hit,
        maps: &[&Transform],
    ) -> (SurfacePoint, [DVec3; 2]) {
        let mut point = self.surface().point(local, hit);
        let mut derivatives = self.surface().normal_derivatives(hit, &point);
        for map in self.to_parent().into_iter().chain(maps.iter().rev().copied()) {
            derivatives = point.transformed_normal_derivatives(derivatives, map);
            point = point.transformed(map);
        }
        if self.attributes(hit.face).reversed {
            (point, derivatives) = (point.reversed(), derivatives.map(|derivative| -derivative));
        }
        (point, derivatives)
    }
}
