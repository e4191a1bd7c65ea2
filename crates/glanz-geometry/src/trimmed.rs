//! Surfaces trimmed by loops of curves.

use std::sync::Arc;

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::{RaySurface, Surface};
use crate::trim::TrimRegion;

/// The part of a surface whose parameters, [`SurfacePoint::uv`], lie in a region; see [`Surface::trimmed`].
///
/// It cannot be sampled: the area of the kept part has no closed form.
#[derive(Clone, Debug)]
pub struct Trimmed {
    surface: Box<Surface>,
    region: Arc<TrimRegion>,
}

impl Surface {
    /// The part of the surface whose parameters [`SurfacePoint::uv`] lie in `region`.
    #[must_use]
    pub fn trimmed(self, region: impl Into<Arc<TrimRegion>>) -> Self {
        let region = region.into();
        match self {
            // Freeform surfaces trim leaf by leaf, which is faster.
            Self::Freeform(freeform) if !freeform.is_trimmed() => freeform.trimmed(region).into(),
            surface => Trimmed { surface: Box::new(surface), region }.into(),
        }
    }
}

impl Surface {
    /// The region that trims the surface, if one does.
    #[must_use]
    pub fn trim_region(&self) -> Option<&Arc<TrimRegion>> {
        match self {
            Self::Trimmed(trimmed) => Some(&trimmed.region),
            Self::Freeform(freeform) => freeform.region(),
            _ => None,
        }
    }
}

impl Trimmed {
    /// The surface without trimming.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The region of the parameters that is kept.
    #[must_use]
    pub fn region(&self) -> &Arc<TrimRegion> {
        &self.region
    }

    /// The hit with its border; `None` if the region cuts it away.
    fn kept(&self, ray: &Ray, hit: Hit) -> Option<Hit> {
        let border = self.region.locate(self.surface.point(ray, &hit).uv).border()?;
        Some(Hit { border, ..hit })
    }

    fn kept_hits(&self, ray: &Ray, t_max: f64) -> impl Iterator<Item = Hit> {
        let mut hits = Vec::new();
        self.surface.all_hits(ray, t_max, &mut hits);
        hits.into_iter().filter_map(|hit| self.kept(ray, hit))
    }
}

impl RaySurface for Trimmed {
    fn bounds(&self) -> Bounds3 {
        self.surface.bounds()
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        // Most often the first hit is kept or there is none at all.
        let first = self.surface.intersect(ray, t_max)?;
        self.kept(ray, first).or_else(|| self.kept_hits(ray, t_max).next())
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        hits.extend(self.kept_hits(ray, t_max));
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.surface.point(ray, hit)
    }

    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        self.surface.normal_derivatives(hit, point)
    }

    fn uv_rates(&self, hit: &Hit) -> [DVec2; 2] {
        self.surface.uv_rates(hit)
    }

    fn sample(&self, _xi: DVec2) -> Option<SurfaceSample> {
        None
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HitBorder;
    use crate::quadric::Sphere;
    use crate::trim::{TrimCurve, TrimLoop};

    #[test]
    fn ray_passes_a_hole_and_meets_the_far_side() {
        let sphere = Surface::from(Sphere::try_full(1.0).unwrap());
        let ray = Ray::new(DVec3::new(5.0, 0.3, 0.2), DVec3::NEG_X);
        let mut whole = Vec::new();
        sphere.all_hits(&ray, f64::INFINITY, &mut whole);
        let first = sphere.point(&ray, &whole[0]).uv;
        let sphere_point = {
            let sphere = sphere.clone();
            move |uv: DVec2| sphere.at(0, uv).unwrap().point.position
        };
        let hole = TrimCurve::try_circle(first, 0.05).unwrap().reversed();
        let domain = [first - DVec2::splat(0.1), first + DVec2::splat(0.1)];
        let region = TrimRegion::try_new(vec![TrimLoop::try_closed(hole, 1e-9).unwrap()], domain).unwrap();
        let trimmed = sphere.trimmed(Arc::new(region));
        assert_eq!(trimmed.intersect(&ray, f64::INFINITY), Some(whole[1]));
        assert_eq!(trimmed.intersect(&ray, whole[1].t), None);
        assert!(trimmed.occluded(&ray, f64::INFINITY) && !trimmed.occluded(&ray, whole[1].t));
        // In a border that reaches into the hole, and in one on its kept side.
        let wide = |surface: &Surface, width: f64| {
            let Surface::Trimmed(trimmed) = surface else { panic!("{surface:?}") };
            let region = TrimRegion::clone(trimmed.region()).with_widened_border(width).unwrap();
            trimmed.surface().clone().trimmed(region)
        };
        let border = |surface: &Surface, ray: &Ray| surface.intersect(ray, f64::INFINITY).unwrap().border;
        let aimed = |by: f64| Ray::new(ray.origin, sphere_point(first + DVec2::X * by) - ray.origin);
        for (by, width, expected) in [
            (0.04, 0.0, None),
            (0.04, 0.02, Some(HitBorder::Outer)),
            (0.06, 0.02, Some(HitBorder::Inner)),
            (0.06, 0.005, Some(HitBorder::Away)),
        ] {
            let wide = wide(&trimmed, width);
            match expected {
                Some(expected) => assert_eq!(border(&wide, &aimed(by)), expected, "{by} {width}"),
                None => assert!(wide.intersect(&aimed(by), f64::INFINITY).unwrap().t > 1.1),
            }
        }
        // Beside the hole both sides are hit.
        let beside = Ray::new(DVec3::new(5.0, -0.8, 0.2), DVec3::NEG_X);
        let mut hits = Vec::new();
        trimmed.all_hits(&beside, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), 2);
    }
}
