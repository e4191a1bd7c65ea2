//! Visibility between points, with transmission by clear glass.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec3, Ray};
use glanz_scene::{Interaction, Scene};
use glanz_shading::{Bsdf, BsdfSample, Material, TransportMode};

use super::BakeMethod;

/// Largest number of surfaces that a ray may pass: a ray that hits more does not advance.
pub(super) const MAX_PASSED: u32 = 1000;

/// Occlusion and transmission of light by surfaces.
///
/// Clear glass transmits light straight through, without refraction, less the fraction that each of its faces reflects. This is exact for
/// thin sheets. For thick panes it neglects light reflected between the faces, 0.2 % of the light at normal incidence on glass of
/// index 1.5. Lenses do not focus. Opaque glass blocks light, as do all other surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visibility<'a> {
    scene: &'a Scene,
    /// Whether clear glass transmits light.
    is_clear: bool,
}

impl<'a> Visibility<'a> {
    /// Visibility for a method. In the final gather glass is opaque: only surfaces without a material transmit light.
    pub(super) fn new(method: BakeMethod, scene: &'a Scene) -> Self {
        let transmits =
            |material: &Material| material.lobes().iter().any(|lobe| lobe.transmission && lobe.is_delta());
        Self { scene, is_clear: method != BakeMethod::Gather && scene.materials().iter().any(transmits) }
    }

    /// Transmittance of `ray` from its origin to `t_max`.
    ///
    /// Behind each surface the ray is aimed at its end again: offsets of its origin from the surfaces would otherwise carry it into the
    /// light.
    pub(super) fn transmittance(&self, ray: &Ray, t_max: f64) -> Spectrum {
        if !self.scene.occluded(ray, t_max) {
            return Spectrum::ONE;
        }
        let end = t_max.is_finite().then(|| ray.at(t_max));
        let (mut ray, mut t_max, mut transmittance) = (*ray, t_max, Spectrum::ONE);
        for _ in 0..if self.is_clear { MAX_PASSED } else { 0 } {
            let Some(hit) = self.scene.intersect(&ray, t_max) else { return transmittance };
            transmittance *= self.surface_transmittance(&hit);
            if transmittance.is_black() {
                break;
            }
            match end {
                Some(end) => (ray, t_max) = (hit.spawn_to(end, None), 1.0),
                None => ray = hit.spawn(ray.direction),
            }
        }
        Spectrum::BLACK
    }

    /// Fraction of light that the surface at `hit` transmits straight through.
    pub(super) fn surface_transmittance(&self, hit: &Interaction) -> Spectrum {
        self.bsdf_transmittance(hit, hit.bsdf(self.scene, &Wavelengths::default()).as_ref())
    }

    /// As [`Visibility::surface_transmittance`], with the BSDF at `hit`.
    pub(super) fn bsdf_transmittance(&self, hit: &Interaction, bsdf: Option<&Bsdf<'_>>) -> Spectrum {
        match bsdf {
            None => Spectrum::ONE,
            Some(bsdf) if self.is_clear => {
                transmitted(bsdf, hit.frame_of(bsdf, hit.point.shading_normal).to_local(hit.wo))
            }
            Some(_) => Spectrum::BLACK,
        }
    }

    /// Fraction of the light from `hit.wo` that the surface with this BSDF scatters, without the fraction transmitted straight through.
    pub(super) fn albedo(&self, hit: &Interaction, bsdf: Option<&Bsdf<'_>>) -> Spectrum {
        let Some(bsdf) = bsdf else { return Spectrum::BLACK };
        let wo = hit.frame_of(bsdf, hit.point.shading_normal).to_local(hit.wo);
        let through = if self.is_clear { transmitted(bsdf, wo) } else { Spectrum::BLACK };
        if through.is_black() {
            return bsdf.reflected(wo);
        }
        // Of glass that reflects nothing, rounding may leave less than nothing.
        (bsdf.albedo(outside(wo)) - through).map(|x| x.max(0.0))
    }
}

/// Fraction of light that glass transmits as a delta lobe. `wo`: on either side.
fn transmitted(bsdf: &Bsdf<'_>, wo: DVec3) -> Spectrum {
    let branches = bsdf.delta_branches(outside(wo), TransportMode::Importance);
    let through = |sample: &&BsdfSample| sample.lobe.transmission;
    branches.iter().flatten().filter(through).map(|sample| sample.weight).sum()
}

/// The direction outside of glass for a direction on either side: light that is not refracted has the same angle on both, and no total
/// reflection inside.
fn outside(wo: DVec3) -> DVec3 {
    DVec3::new(wo.x, wo.y, wo.z.abs())
}
