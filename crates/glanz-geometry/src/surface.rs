//! What every surface can be asked, and the closed set of surfaces.

use glanz_math::{AreaPdf, Bounds3, DVec2, Ray};

use crate::hit::{Hit, SurfacePoint, SurfaceSample};

/// The contract of a surface in its local frame. `tests/contract.rs` runs over all of them.
///
/// A hit lies on the surface and on the ray; every root with `0 < t < t_max` counts, from both sides; a ray that
/// starts on the surface by [`glanz_math::rounding::offset_origin`] does not meet its own point again.
pub trait RaySurface {
    /// A box that holds the surface; infinite where the surface is.
    fn bounds(&self) -> Bounds3;

    /// The first hit with `0 < t < t_max`.
    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit>;

    /// Whether there is any hit with `0 < t < t_max`.
    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.intersect(ray, t_max).is_some()
    }

    /// Every hit with `0 < t < t_max`, appended to `hits` in ascending order of `t`; a tangential one once.
    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>);

    /// The surface at a hit of this surface with this ray.
    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint;

    /// Picks a point of the surface from two numbers uniform in [0, 1).
    ///
    /// `None` if the surface has no finite area or no parameters to pick from.
    fn sample(&self, xi: DVec2) -> Option<SurfaceSample>;

    /// The density with which [`RaySurface::sample`] picks the point of `hit`; `None` as there.
    fn area_pdf(&self, hit: &Hit, point: &SurfacePoint) -> Option<AreaPdf>;
}
