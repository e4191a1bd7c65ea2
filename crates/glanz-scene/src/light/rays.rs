//! A light source as many rays.

use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{DMat3, DVec3, Ray, Transform};
use glanz_sampling::discrete::PiecewiseConstant1;

use super::photometric::luminaire_axes;
use crate::description::SourceRay;

/// A light that sends measured rays, each as often as its share of the flux says.
///
/// It cannot be looked for from a surface: only paths that begin at lights see it.
#[derive(Clone, Debug)]
pub struct RayLight {
    rays: Arc<[SourceRay]>,
    /// Rays by flux; `None` if all are dark.
    choice: Option<Arc<PiecewiseConstant1>>,
    position: DVec3,
    /// Axes of the source in the world; orthonormal, perhaps mirrored.
    axes: DMat3,
    /// How much larger lengths are in the world.
    scale: f64,
    power: Spectrum,
}

impl RayLight {
    /// `from`: where the origin of the rays is in the frame that `to_world` places; `per_lumen`: W for one lumen. `None` if `to_world` is
    /// no similarity.
    pub(crate) fn try_new(
        rays: Arc<[SourceRay]>,
        from: DVec3,
        to_world: &Transform,
        per_lumen: Spectrum,
    ) -> Option<Self> {
        let (axes, scale) = luminaire_axes(to_world)?;
        let lumens: Vec<f64> = rays.iter().map(|ray| f64::from(ray.lumens)).collect();
        let choice = PiecewiseConstant1::try_new(&lumens).ok().map(Arc::new);
        let flux: f64 = lumens.iter().sum();
        Some(Self {
            rays,
            choice,
            position: to_world.point(from),
            axes,
            scale,
            power: per_lumen * flux as f32,
        })
    }

    /// Total power, W.
    #[must_use]
    pub fn power(&self) -> Spectrum {
        self.power
    }

    /// Where its origin is, metres.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// One of the rays by its flux, by a number uniform in [0, 1).
    pub(super) fn pick(&self, xi: f64) -> Option<Ray> {
        let SourceRay { origin, direction, .. } = self.rays.get(self.choice.as_ref()?.choose(xi).index)?;
        let place = |v: &[f32; 3]| self.axes * DVec3::from_array(v.map(f64::from));
        let direction = place(direction).try_normalize()?;
        Some(Ray::new(self.position + self.scale * place(origin), direction))
    }
}
