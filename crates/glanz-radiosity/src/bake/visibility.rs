//! How much light passes between places.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec3, Ray};
use glanz_scene::{Interaction, Scene};
use glanz_shading::{Bsdf, BsdfSample, Material, TransportMode};

use super::BakeMethod;

/// Surfaces at most that a ray may pass; more are met by a ray that does not advance.
pub(super) const MOST_PASSED: u32 = 1000;

/// What stands in the way of light, and what lets it pass.
///
/// Clear glass lets light pass straight on: it is weakened at each of its faces by the fraction that the face reflects, and not
/// refracted. That is exact for thin sheets. Between the faces of a thick pane light that goes to and fro is left out, 0.2 % of what meets
/// glass of index 1.5 head-on. Lenses do not focus. Opaque glass blocks light, as all other surfaces do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visibility<'a> {
    scene: &'a Scene,
    /// Whether there is clear glass.
    is_clear: bool,
}

impl<'a> Visibility<'a> {
    /// The final gather takes all glass for opaque: nothing transmits light but surfaces without a material.
    pub(super) fn of(method: BakeMethod, scene: &'a Scene) -> Self {
        let transmits =
            |material: &Material| material.lobes().iter().any(|lobe| lobe.transmission && lobe.is_delta());
        Self { scene, is_clear: method != BakeMethod::Gather && scene.materials().iter().any(transmits) }
    }

    /// Fraction of light that arrives over `ray` from `t_max`.
    pub(super) fn along(&self, ray: &Ray, t_max: f64) -> Spectrum {
        let is_occluded = self.scene.occluded(ray, t_max);
        if !is_occluded {
            return Spectrum::ONE;
        }
        let (mut ray, mut left, mut share) = (*ray, t_max, Spectrum::ONE);
        for _ in 0..if self.is_clear { MOST_PASSED } else { 0 } {
            let Some(hit) = self.scene.intersect(&ray, left) else { return share };
            share *= self.passed(&hit);
            if share.is_black() {
                break;
            }
            left -= hit.t;
            ray = hit.spawn(ray.direction);
        }
        Spectrum::BLACK
    }

    /// Fraction of light that passes the surface at `hit` straight on.
    pub(super) fn passed(&self, hit: &Interaction) -> Spectrum {
        match hit.bsdf(self.scene, &Wavelengths::default()) {
            None => Spectrum::ONE,
            Some(bsdf) if self.is_clear => transmitted(&bsdf, hit.frame().to_local(hit.wo)),
            Some(_) => Spectrum::BLACK,
        }
    }

    /// Fraction of the light from `hit.wo` that the surface reflects, in whatever way; without what passes straight on.
    pub(super) fn reflected(&self, hit: &Interaction) -> Spectrum {
        let Some(bsdf) = hit.bsdf(self.scene, &Wavelengths::default()) else { return Spectrum::BLACK };
        let wo = hit.frame().to_local(hit.wo);
        let albedo = bsdf.albedo(wo);
        if self.is_clear { albedo - transmitted(&bsdf, wo) } else { albedo }
    }
}

/// Fraction of light that glass transmits as a delta lobe. `wo`: from either side; the angle is the one outside, also where light leaves glass.
fn transmitted(bsdf: &Bsdf, wo: DVec3) -> Spectrum {
    let outside = DVec3::new(wo.x, wo.y, wo.z.abs());
    let branches = bsdf.delta_branches(outside, TransportMode::Importance);
    let through = |sample: &&BsdfSample| sample.lobe.transmission;
    branches.iter().flatten().filter(through).map(|sample| sample.weight).sum()
}
