//! The queries that every surface answers, and the closed set of surfaces.

use std::sync::Arc;

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::algebraic::AlgebraicSurface;
use crate::batch::BoundedRay;
use crate::bilinear::BilinearPatch;
use crate::cuboid::Cuboid;
use crate::curve::FacingCurve;
use crate::freeform::Freeform;
use crate::hit::{AreaSample, Hit, ShadingPoint, SurfaceLocation, SurfacePoint, SurfaceSample};
use crate::mesh::Mesh;
use crate::polyhedron::Polyhedron;
use crate::quadric::{Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid};
use crate::torus::Torus;
use crate::triangle::Triangle;
use crate::trimmed::Trimmed;

/// The contract of a surface in its local frame. `tests/it/contract.rs` runs over all of them.
///
/// A hit lies on the surface and on the ray; every root with `0 < t < t_max` counts, from both sides; a ray that
/// starts on the surface by [`glanz_math::rounding::offset_origin`] does not meet its own point again.
pub trait RaySurface {
    /// A box that contains the surface; infinite where the surface is.
    fn bounds(&self) -> Bounds3;

    /// The first hit with `0 < t < t_max`.
    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit>;

    /// Whether there is any hit with `0 < t < t_max`.
    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.intersect(ray, t_max).is_some()
    }

    /// The first hit of each ray before its end, as by [`RaySurface::intersect`]: the same bits for any size and order of the
    /// batch. `hits` is replaced.
    fn closest_batch(&self, rays: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.extend(rays.iter().map(|BoundedRay { ray, t_max }| self.intersect(ray, *t_max)));
    }

    /// Whether each ray has a hit before its end, as by [`RaySurface::occluded`]. `occluded` is replaced.
    fn occluded_batch(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        occluded.clear();
        occluded.extend(rays.iter().map(|BoundedRay { ray, t_max }| self.occluded(ray, *t_max)));
    }

    /// Every hit with `0 < t < t_max`, appended to `hits` in ascending order of `t`; a tangential one once.
    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>);

    /// The surface at a hit of this surface with this ray.
    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint;

    /// The surface at the hits of rays of this surface, as by [`RaySurface::point`]: the same bits for any size and order of the batch.
    /// `hits` has an entry per ray; `points` is replaced.
    fn point_batch(&self, rays: &[Ray], hits: &[Hit], points: &mut Vec<SurfacePoint>) {
        points.clear();
        points.extend(rays.iter().zip(hits).map(|(ray, hit)| self.point(ray, hit)));
    }

    /// The surface at a hit as far as shading needs it: the bits of [`RaySurface::point`], save that `dpdu` of a mesh
    /// is zero.
    fn shading_point(&self, ray: &Ray, hit: &Hit) -> ShadingPoint {
        self.point(ray, hit).into()
    }

    /// Position, normal and texture coordinates at a hit: the bits of [`RaySurface::point`], save for the length of the normal.
    fn location(&self, ray: &Ray, hit: &Hit) -> SurfaceLocation {
        let ShadingPoint { position, normal, uv, .. } = self.shading_point(ray, hit);
        SurfaceLocation { position, normal, uv }
    }

    /// The derivatives `[dn/du, dn/dv]` of the shading normal by the texture coordinates at `point`, the surface at a hit.
    ///
    /// They are no part of [`SurfacePoint`], since only curvature needs them.
    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        let _ = (hit, point);
        [DVec3::ZERO; 2]
    }

    /// The derivatives of the texture coordinates at a hit by the parameters of `dpdu` and `dpdv`: 1 unless these are parameters of their own.
    fn uv_rates(&self, _hit: &Hit) -> [DVec2; 2] {
        [DVec2::X, DVec2::Y]
    }

    /// The surface at the first hit: position, normal, parameters and derivatives.
    fn first_point(&self, ray: &Ray) -> Option<SurfacePoint> {
        self.intersect(ray, f64::INFINITY).map(|hit| self.point(ray, &hit))
    }

    /// Samples a point of the surface by two numbers uniform in [0, 1).
    ///
    /// `None` if the surface has no finite area or no parameters to sample by.
    fn sample(&self, xi: DVec2) -> Option<SurfaceSample>;

    /// The point of [`RaySurface::sample`] without its parameters: the same bits.
    fn sample_area(&self, xi: DVec2) -> Option<AreaSample> {
        self.sample(xi).map(AreaSample::from)
    }

    /// The density with which [`RaySurface::sample`] samples the point of `hit`; `None` for surfaces that cannot be sampled.
    fn area_pdf(&self, hit: &Hit, point: &SurfacePoint) -> Option<AreaPdf>;
}

// One line per surface; the macro generates the delegation for all of them.
macro_rules! surfaces {
    ($($(#[$doc:meta])* $kind:literal $name:ident($type:ty),)*) => {
        /// The closed set of surfaces.
        #[derive(Clone, Debug)]
        #[non_exhaustive]
        pub enum Surface {
            $($(#[$doc])* $name($type),)*
        }

        impl Surface {
            /// The name in scene files.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $kind,)*
                }
            }
        }

        impl RaySurface for Surface {
            fn bounds(&self) -> Bounds3 {
                match self {
                    $(Self::$name(s) => s.bounds(),)*
                }
            }

            fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
                match self {
                    $(Self::$name(s) => s.intersect(ray, t_max),)*
                }
            }

            fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
                match self {
                    $(Self::$name(s) => s.occluded(ray, t_max),)*
                }
            }

            fn closest_batch(&self, rays: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
                match self {
                    $(Self::$name(s) => s.closest_batch(rays, hits),)*
                }
            }

            fn occluded_batch(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
                match self {
                    $(Self::$name(s) => s.occluded_batch(rays, occluded),)*
                }
            }

            fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
                match self {
                    $(Self::$name(s) => s.all_hits(ray, t_max, hits),)*
                }
            }

            fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
                match self {
                    $(Self::$name(s) => s.point(ray, hit),)*
                }
            }

            fn point_batch(&self, rays: &[Ray], hits: &[Hit], points: &mut Vec<SurfacePoint>) {
                match self {
                    $(Self::$name(s) => s.point_batch(rays, hits, points),)*
                }
            }

            fn shading_point(&self, ray: &Ray, hit: &Hit) -> ShadingPoint {
                match self {
                    $(Self::$name(s) => s.shading_point(ray, hit),)*
                }
            }

            fn location(&self, ray: &Ray, hit: &Hit) -> SurfaceLocation {
                match self {
                    $(Self::$name(s) => s.location(ray, hit),)*
                }
            }

            fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
                match self {
                    $(Self::$name(s) => s.normal_derivatives(hit, point),)*
                }
            }

            fn uv_rates(&self, hit: &Hit) -> [DVec2; 2] {
                match self {
                    $(Self::$name(s) => s.uv_rates(hit),)*
                }
            }

            fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
                match self {
                    $(Self::$name(s) => s.sample(xi),)*
                }
            }

            fn sample_area(&self, xi: DVec2) -> Option<AreaSample> {
                match self {
                    $(Self::$name(s) => s.sample_area(xi),)*
                }
            }

            fn area_pdf(&self, hit: &Hit, point: &SurfacePoint) -> Option<AreaPdf> {
                match self {
                    $(Self::$name(s) => s.area_pdf(hit, point),)*
                }
            }
        }

        $(impl From<$type> for Surface {
            fn from(surface: $type) -> Self {
                Self::$name(surface)
            }
        })*
    };
}

surfaces! {
    /// Sphere or a zone of it.
    "sphere" Sphere(Sphere),
    /// Open cylinder.
    "cylinder" Cylinder(Cylinder),
    /// Open cone.
    "cone" Cone(Cone),
    /// Paraboloid of revolution.
    "paraboloid" Paraboloid(Paraboloid),
    /// One-sheeted hyperboloid of revolution.
    "hyperboloid" Hyperboloid(Hyperboloid),
    /// Two-sheeted hyperboloid of revolution.
    "twosheetedhyperboloid" TwoSheetedHyperboloid(TwoSheetedHyperboloid),
    /// Disk or ring.
    "disk" Disk(Disk),
    /// Plane or a rectangle of it.
    "plane" Plane(Plane),
    /// Zero set of a polynomial in a box.
    "algebraic" Algebraic(Box<AlgebraicSurface>),
    /// Torus.
    "torus" Torus(Torus),
    /// Convex polyhedron.
    "polyhedron" Polyhedron(Polyhedron),
    /// Box.
    "box" Cuboid(Cuboid),
    /// Bilinear patch.
    "bilinearmesh" Bilinear(BilinearPatch),
    /// Single triangle.
    "triangle" Triangle(Triangle),
    /// Many triangles with a hierarchy of their own, shared between copies.
    "trianglemesh" Mesh(Arc<Mesh>),
    /// Bézier patches with a hierarchy of their own, shared between copies.
    "freeform" Freeform(Arc<Freeform>),
    /// Curves with a width that face every ray, shared between copies.
    "curve" Curve(Arc<FacingCurve>),
    /// Part of another surface inside trimming loops.
    "trimmed" Trimmed(Trimmed),
}

impl From<AlgebraicSurface> for Surface {
    fn from(surface: AlgebraicSurface) -> Self {
        Self::Algebraic(Box::new(surface))
    }
}

impl From<Mesh> for Surface {
    fn from(mesh: Mesh) -> Self {
        Self::Mesh(Arc::new(mesh))
    }
}

impl From<FacingCurve> for Surface {
    fn from(curve: FacingCurve) -> Self {
        Self::Curve(Arc::new(curve))
    }
}

impl From<Freeform> for Surface {
    fn from(surface: Freeform) -> Self {
        Self::Freeform(Arc::new(surface))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_delegates_to_its_variant() {
        let sphere = Sphere::try_full(2.0).unwrap();
        let surface = Surface::from(sphere);
        assert_eq!(surface.kind(), "sphere");
        assert_eq!(surface.bounds(), sphere.bounds());
        let ray = Ray::new(DVec3::new(-5.0, 0.5, 0.25), DVec3::X);
        let hit = surface.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!(Some(hit), sphere.intersect(&ray, f64::INFINITY));
        let point = surface.point(&ray, &hit);
        assert_eq!(point, sphere.point(&ray, &hit));
        assert_eq!(surface.area_pdf(&hit, &point), sphere.area_pdf(&hit, &point));
        assert_eq!(surface.sample(DVec2::splat(0.3)), sphere.sample(DVec2::splat(0.3)));
        assert!(surface.occluded(&ray, f64::INFINITY) && !surface.occluded(&ray, hit.t));
        let mut hits = Vec::new();
        surface.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), 2);
    }

    #[test]
    fn a_surface_fits_in_four_cache_lines() {
        // Objects store their surface inline: one large variant would enlarge all of them.
        assert!(size_of::<Surface>() <= 256, "{}", size_of::<Surface>());
    }
}
