//! The implementation shared by all quadrics of revolution: hits, points and samples.

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use super::azimuth::AzimuthRange;
use super::revolution::{QuadricCrossing, QuadricOfRevolution, point_on_ray};
use crate::hit::{AreaSample, Hit, ShadingPoint, SurfacePoint, SurfaceSample};
use crate::rational::Profile;

/// A parameterized part of a [`QuadricOfRevolution`].
pub(super) trait SurfaceOfRevolution {
    /// The whole quadric.
    fn quadric(&self) -> &QuadricOfRevolution;

    /// The range of its azimuth.
    fn azimuth(&self) -> AzimuthRange;

    /// The profile curves, by ascending v.
    fn profiles(&self) -> Vec<Profile>;

    /// A box around the part.
    fn extent(&self) -> Bounds3;

    /// Parameters of a point on the quadric; `None` if the part does not contain it.
    fn parameters(&self, p: DVec3) -> Option<DVec2>;

    /// Derivatives of the position.
    fn tangents(&self, p: DVec3, uv: DVec2) -> [DVec3; 2];

    /// +1 if the cross product of the tangents points to the outside of the quadric, -1 if to the inside.
    fn orientation(&self) -> f64 {
        1.0
    }

    /// The unit normal.
    fn normal(&self, p: DVec3, _uv: impl FnOnce() -> DVec2) -> DVec3 {
        self.quadric().normal(p) * self.orientation()
    }

    /// Its derivatives by both parameters.
    fn normal_derivatives_at(&self, point: &SurfacePoint) -> [DVec3; 2] {
        let (quadric, sign) = (self.quadric(), self.orientation());
        let normal = quadric.normal(point.position);
        [point.dpdu, point.dpdv].map(|dp| quadric.normal_derivative(point.position, normal, dp) * sign)
    }

    /// The point with the given parameters; the one next to `near` if there are several.
    fn position(&self, uv: DVec2, near: DVec3) -> DVec3;

    /// The argument `near` of [`SurfaceOfRevolution::position`] without a ray.
    fn near(&self, _uv: DVec2) -> DVec3 {
        DVec3::ZERO
    }

    /// A random point from two uniform numbers.
    fn sample_point(&self, xi: DVec2) -> (DVec3, DVec2);

    /// The position of [`SurfaceOfRevolution::sample_point`].
    fn sample_position(&self, xi: DVec2) -> DVec3 {
        self.sample_point(xi).0
    }

    /// Density of [`SurfaceOfRevolution::sample_point`] at a point with these tangents, per m^2.
    fn density(&self, tangents: impl FnOnce() -> [DVec3; 2]) -> f64;
}

/// The first hit before `t_max`.
#[inline]
pub(super) fn first(surface: &impl SurfaceOfRevolution, ray: &Ray, t_max: f64) -> Option<Hit> {
    surface.quadric().crossings(ray).into_iter().flatten().find_map(|c| hit_in_range(surface, &c, t_max))
}

/// All hits before `t_max`.
pub(super) fn all(surface: &impl SurfaceOfRevolution, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
    hits.extend(
        surface
            .quadric()
            .crossings(ray)
            .into_iter()
            .flatten()
            .filter_map(|c| hit_in_range(surface, &c, t_max)),
    );
}

fn hit_in_range(surface: &impl SurfaceOfRevolution, crossing: &QuadricCrossing, t_max: f64) -> Option<Hit> {
    if !(crossing.t < t_max) {
        return None;
    }
    let uv = surface.parameters(crossing.p)?;
    Some(Hit::new(crossing.t, uv.x, uv.y, 0))
}

/// The surface at a hit.
///
/// The position is computed from the parameters, not from t, whose digits depend on the distance of the origin: so it is
/// within the borders, and as accurate for a distant camera as for a close one.
pub(super) fn point_of_hit(surface: &impl SurfaceOfRevolution, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let uv = DVec2::new(hit.u, hit.v);
    let close = surface.position(uv, point_on_ray(ray.origin, ray.direction, hit.t));
    point(surface, surface.quadric().refined(close), uv)
}

/// [`point_of_hit`] without derivatives.
pub(super) fn shading_point_of_hit(surface: &impl SurfaceOfRevolution, ray: &Ray, hit: &Hit) -> ShadingPoint {
    let uv = DVec2::new(hit.u, hit.v);
    let close = surface.position(uv, point_on_ray(ray.origin, ray.direction, hit.t));
    let position = surface.quadric().refined(close);
    let normal = surface.normal(position, || uv);
    ShadingPoint {
        position,
        error: surface.quadric().error(position),
        normal,
        shading_normal: normal,
        uv,
        dpdu: surface.azimuth().derivative(position),
    }
}

/// The surface at the given parameters.
pub(super) fn at(surface: &impl SurfaceOfRevolution, uv: DVec2) -> SurfacePoint {
    point(surface, surface.quadric().refined(surface.position(uv, surface.near(uv))), uv)
}

fn point(surface: &impl SurfaceOfRevolution, position: DVec3, uv: DVec2) -> SurfacePoint {
    let tangents = surface.tangents(position, uv);
    let normal = surface.normal(position, || uv);
    SurfacePoint {
        position,
        error: surface.quadric().error(position),
        normal,
        shading_normal: normal,
        uv,
        dpdu: tangents[0],
        dpdv: tangents[1],
    }
}

/// A random point.
pub(super) fn sample(surface: &impl SurfaceOfRevolution, xi: DVec2) -> SurfaceSample {
    let (position, uv) = surface.sample_point(xi);
    let point = point(surface, surface.quadric().corrected(position), uv);
    let hit = Hit::new(0.0, uv.x, uv.y, 0);
    SurfaceSample { hit, point, pdf: AreaPdf(surface.density(|| [point.dpdu, point.dpdv])) }
}

/// The point of [`sample`] without its parameters.
pub(super) fn sample_area(surface: &impl SurfaceOfRevolution, xi: DVec2) -> AreaSample {
    let position = surface.quadric().corrected(surface.sample_position(xi));
    let uv = || surface.sample_point(xi).1;
    AreaSample {
        position,
        error: surface.quadric().error(position),
        normal: surface.normal(position, uv),
        face: 0,
        pdf: AreaPdf(surface.density(|| surface.tangents(position, uv()))),
    }
}

/// Density per m^2 of points with uniform parameters.
pub(super) fn parameter_density([dpdu, dpdv]: [DVec3; 2]) -> f64 {
    1.0 / dpdu.cross(dpdv).length()
}

/// Implements [`crate::RaySurface`] by the functions above.
macro_rules! impl_ray_surface {
    ($surface:ty) => {
        impl $surface {
            /// The surface at the given parameters.
            pub(crate) fn at(&self, uv: glanz_math::DVec2) -> crate::hit::SurfacePoint {
                super::surface_of_revolution::at(self, uv)
            }

            pub(crate) fn rational_patches(&self) -> Option<Vec<crate::rational::RationalPatch>> {
                use super::surface_of_revolution::SurfaceOfRevolution;
                crate::rational::revolved(self.azimuth().phi_max(), &self.profiles())
            }
        }

        impl crate::surface::RaySurface for $surface {
            fn bounds(&self) -> glanz_math::Bounds3 {
                super::surface_of_revolution::SurfaceOfRevolution::extent(self)
            }

            fn intersect(&self, ray: &glanz_math::Ray, t_max: f64) -> Option<crate::hit::Hit> {
                super::surface_of_revolution::first(self, ray, t_max)
            }

            fn all_hits(&self, ray: &glanz_math::Ray, t_max: f64, hits: &mut Vec<crate::hit::Hit>) {
                super::surface_of_revolution::all(self, ray, t_max, hits);
            }

            fn point(&self, ray: &glanz_math::Ray, hit: &crate::hit::Hit) -> crate::hit::SurfacePoint {
                super::surface_of_revolution::point_of_hit(self, ray, hit)
            }

            fn shading_point(
                &self,
                ray: &glanz_math::Ray,
                hit: &crate::hit::Hit,
            ) -> crate::hit::ShadingPoint {
                super::surface_of_revolution::shading_point_of_hit(self, ray, hit)
            }

            fn normal_derivatives(
                &self,
                _hit: &crate::hit::Hit,
                point: &crate::hit::SurfacePoint,
            ) -> [glanz_math::DVec3; 2] {
                super::surface_of_revolution::SurfaceOfRevolution::normal_derivatives_at(self, point)
            }

            fn sample(&self, xi: glanz_math::DVec2) -> Option<crate::hit::SurfaceSample> {
                Some(super::surface_of_revolution::sample(self, xi))
            }

            fn sample_area(&self, xi: glanz_math::DVec2) -> Option<crate::hit::AreaSample> {
                Some(super::surface_of_revolution::sample_area(self, xi))
            }

            fn area_pdf(
                &self,
                _hit: &crate::hit::Hit,
                point: &crate::hit::SurfacePoint,
            ) -> Option<glanz_math::AreaPdf> {
                Some(glanz_math::AreaPdf(super::surface_of_revolution::SurfaceOfRevolution::density(
                    self,
                    || [point.dpdu, point.dpdv],
                )))
            }
        }
    };
}
pub(super) use impl_ray_surface;
