//! What the quadrics of revolution have in common: from crossings to hits, points and samples.

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use super::clip::Sweep;
use super::revolution::{Crossing, Revolution, follow};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::rational::Profile;

/// Unit normal and its derivatives by the two parameters.
pub(super) struct Bending {
    pub(super) normal: DVec3,
    pub(super) dndu: DVec3,
    pub(super) dndv: DVec3,
}

/// A part of a [`Revolution`] with parameters.
pub(super) trait Swept {
    /// The whole quadric.
    fn quadric(&self) -> &Revolution;

    /// How far it is swept about the axis.
    fn sweep(&self) -> Sweep;

    /// What is swept, by ascending v.
    fn profiles(&self) -> Vec<Profile>;

    /// A box around the kept part.
    fn extent(&self) -> Bounds3;

    /// Parameters of a point on the quadric; `None` if it is clipped away.
    fn parameters(&self, p: DVec3) -> Option<DVec2>;

    /// Derivatives of the position.
    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2];

    /// +1 if the cross product of the tangents points to the outside of the quadric, -1 if to the inside.
    fn side(&self) -> f64 {
        1.0
    }

    /// Normal and its derivatives.
    fn bending(&self, p: DVec3, _uv: DVec2, [dpdu, dpdv]: [DVec3; 2]) -> Bending {
        let (quadric, side) = (self.quadric(), self.side());
        let normal = quadric.normal(p);
        Bending {
            normal: normal * side,
            dndu: quadric.bend(p, normal, dpdu) * side,
            dndv: quadric.bend(p, normal, dpdv) * side,
        }
    }

    /// The point with the given parameters. Where they stand for more than one, the one next to `near`.
    fn position(&self, uv: DVec2, near: DVec3) -> DVec3;

    /// What [`Swept::position`] is to take for `near` if nothing else is known.
    fn near(&self, _uv: DVec2) -> DVec3 {
        DVec3::ZERO
    }

    /// A point picked from two uniform numbers.
    fn pick(&self, xi: DVec2) -> (DVec3, DVec2);

    /// Density of [`Swept::pick`] at a point, per m^2.
    fn density(&self, point: &SurfacePoint) -> f64;
}

/// The first hit in range.
pub(super) fn first(surface: &impl Swept, ray: &Ray, t_max: f64) -> Option<Hit> {
    surface.quadric().crossings(ray).into_iter().flatten().find_map(|c| kept(surface, &c, t_max))
}

/// All hits in range.
pub(super) fn all(surface: &impl Swept, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
    hits.extend(
        surface.quadric().crossings(ray).into_iter().flatten().filter_map(|c| kept(surface, &c, t_max)),
    );
}

fn kept(surface: &impl Swept, crossing: &Crossing, t_max: f64) -> Option<Hit> {
    if !(crossing.t < t_max) {
        return None;
    }
    let uv = surface.parameters(crossing.p)?;
    Some(Hit { t: crossing.t, u: uv.x, v: uv.y, face: 0 })
}

/// The surface at a hit.
///
/// The position is found by the parameters and not by t, which has lost the digits of a ray's way from afar: so it
/// is within the borders, and as exact for a distant camera as for a close one.
pub(super) fn point_of_hit(surface: &impl Swept, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let uv = DVec2::new(hit.u, hit.v);
    point(surface, surface.position(uv, follow(ray.origin, ray.direction, hit.t)), uv)
}

/// The surface at its parameters.
pub(super) fn at(surface: &impl Swept, uv: DVec2) -> SurfacePoint {
    point(surface, surface.position(uv, surface.near(uv)), uv)
}

fn point(surface: &impl Swept, close: DVec3, uv: DVec2) -> SurfacePoint {
    let position = surface.quadric().refined(close);
    let tangents = surface.tangents(position, uv);
    let Bending { normal, dndu, dndv } = surface.bending(position, uv, tangents);
    SurfacePoint {
        position,
        error: surface.quadric().error(position),
        normal,
        shading_normal: normal,
        uv,
        dpdu: tangents[0],
        dpdv: tangents[1],
        dndu,
        dndv,
    }
}

/// A random point.
pub(super) fn sample(surface: &impl Swept, xi: DVec2) -> SurfaceSample {
    let (position, uv) = surface.pick(xi);
    let point = point(surface, position, uv);
    let hit = Hit { t: 0.0, u: uv.x, v: uv.y, face: 0 };
    SurfaceSample { hit, point, pdf: AreaPdf(surface.density(&point)) }
}

/// Density of points whose parameters are uniform.
pub(super) fn parameter_density(point: &SurfacePoint) -> f64 {
    1.0 / point.dpdu.cross(point.dpdv).length()
}

/// Implements the contract by the functions above.
macro_rules! impl_ray_surface {
    ($surface:ty) => {
        impl $surface {
            /// The surface at its parameters.
            pub(crate) fn at(&self, uv: glanz_math::DVec2) -> crate::hit::SurfacePoint {
                super::swept::at(self, uv)
            }

            pub(crate) fn rational_patches(&self) -> Option<Vec<crate::rational::RationalPatch>> {
                use super::swept::Swept;
                crate::rational::revolved(self.sweep().phi_max(), &self.profiles())
            }
        }

        impl crate::surface::RaySurface for $surface {
            fn bounds(&self) -> glanz_math::Bounds3 {
                super::swept::Swept::extent(self)
            }

            fn intersect(&self, ray: &glanz_math::Ray, t_max: f64) -> Option<crate::hit::Hit> {
                super::swept::first(self, ray, t_max)
            }

            fn all_hits(&self, ray: &glanz_math::Ray, t_max: f64, hits: &mut Vec<crate::hit::Hit>) {
                super::swept::all(self, ray, t_max, hits);
            }

            fn point(&self, ray: &glanz_math::Ray, hit: &crate::hit::Hit) -> crate::hit::SurfacePoint {
                super::swept::point_of_hit(self, ray, hit)
            }

            fn sample(&self, xi: glanz_math::DVec2) -> Option<crate::hit::SurfaceSample> {
                Some(super::swept::sample(self, xi))
            }

            fn area_pdf(
                &self,
                _hit: &crate::hit::Hit,
                point: &crate::hit::SurfacePoint,
            ) -> Option<glanz_math::AreaPdf> {
                Some(glanz_math::AreaPdf(super::swept::Swept::density(self, point)))
            }
        }
    };
}
pub(super) use impl_ray_surface;
