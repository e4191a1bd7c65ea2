//! Receivers: points of surfaces for which a bake computes light.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec3;
use glanz_scene::{Interaction, ParametricPoint, Scene};

use crate::elements::Elements;

/// A point on one side of a surface for which light is computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BakeReceiver {
    pub(super) at: Interaction,
    /// Unit normal of the surface on the side of the receiver.
    pub(super) normal: DVec3,
    /// Unit normal for shading on the side of the receiver.
    pub(super) shading: DVec3,
}

impl BakeReceiver {
    /// The receiver at a point; `None` where trimming has removed the surface.
    pub(crate) fn new(elements: &Elements<'_>, place: &ParametricPoint) -> Option<Self> {
        let surface = elements.surfaces.get(place.surface as usize)?;
        let at = surface.at(place.face, place.uv, place.back)?.at;
        let side = if at.point.normal.dot(at.wo) < 0.0 { -1.0 } else { 1.0 };
        Some(Self { at, normal: side * at.point.normal, shading: side * at.point.shading_normal })
    }

    /// Fraction of light that is reflected, [0, 1], and emitted radiance.
    pub(super) fn albedo_and_emission(&self, scene: &Scene) -> (Spectrum, Spectrum) {
        let bsdf = self.at.bsdf(scene, &Wavelengths::default());
        let albedo = bsdf.map_or(Spectrum::BLACK, |bsdf| {
            bsdf.reflected(self.at.frame_of(&bsdf, self.at.point.shading_normal).to_local(self.at.wo))
        });
        (albedo, scene.emitted(&self.at, self.at.wo))
    }
}
