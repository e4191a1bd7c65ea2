//! Receivers: points of surfaces for which a bake computes light.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec3, Frame};
use glanz_scene::{Interaction, ParametricPoint, Scene};

use crate::elements::Elements;

/// Direction of the first tangents of receivers: along none of the axes, of which walls usually have the normals. Tangents that depend on the
/// normal alone change suddenly somewhere; on surfaces with normals along the axes, rounding would decide between them.
const TANGENT: DVec3 = DVec3::new(0.267, 0.535, 0.802);

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

    /// The frame of the directions over the hemisphere, which varies little between adjacent receivers.
    pub(super) fn frame(&self) -> Frame {
        Frame::from_z_and_tangent(self.shading, TANGENT)
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glanz_scene::description::{GeometryDescription, ShapeDescription};

    use super::*;
    use crate::elements::ElementSettings;
    use crate::scenes::scene;

    #[test]
    fn frames_of_adjacent_receivers_differ_little() {
        // The normals of a cylinder are horizontal but for rounding.
        let cylinder = GeometryDescription::Cylinder { radius: 1.0, z: [0.0, 1.0], phi_max: TAU };
        let scene = scene(vec![(
            ShapeDescription::from(cylinder)
                .rotated(DVec3::new(0.3, 1.0, 0.2), 1.1)
                .rotated(DVec3::new(0.3, 1.0, 0.2), -1.1),
            0.5,
            0.0,
        )]);
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let frame = |i: u32, v: f64| {
            let uv = glanz_math::DVec2::new(f64::from(i) / 1000.0, v);
            BakeReceiver::new(&elements, &ParametricPoint { surface: 0, face: 0, back: false, uv })
                .unwrap()
                .frame()
        };
        for i in 0..1000 {
            for (a, b) in [(frame(i, 0.3), frame(i + 1, 0.3)), (frame(i, 0.3), frame(i, 0.7))] {
                // Neighbours are turned by 2 pi / 1000, their tangents by at most twice as much where the normal is nearest to the tangent.
                assert!(a.x.distance(b.x).max(a.y.distance(b.y)) < 0.02, "{i}: {a:?} {b:?}");
            }
        }
    }
}
