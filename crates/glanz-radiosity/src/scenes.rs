//! Scenes for the tests.

use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec3};
use glanz_scene::Scene;
use glanz_scene::description::*;

fn grey(value: f32) -> SpectrumInput {
    SpectrumInput::Value(SpectralDistribution::Constant(value))
}

/// Shapes with their reflectance and the radiance that their front gives off.
pub(crate) fn scene(shapes: Vec<(GeometryDescription, f32, f32)>) -> Scene {
    scene_with(shapes, Vec::new())
}

/// The same with lights that are no surfaces, of emission 1.
pub(crate) fn scene_with(shapes: Vec<(GeometryDescription, f32, f32)>, lights: Vec<LightKind>) -> Scene {
    let mut description = Description::default();
    for (number, (geometry, reflectance, radiance)) in shapes.into_iter().enumerate() {
        description.materials.push(MaterialDescription {
            name: String::new(),
            kind: MaterialKind::diffuse(grey(reflectance)),
            location: None,
        });
        let emission = (radiance > 0.0).then_some(EmissionDescription {
            radiance: SpectralDistribution::Constant(radiance),
            scale: 1.0,
            power: None,
            two_sided: false,
        });
        description.world.shapes.push(ShapeDescription {
            geometry,
            to_parent: DMat4::IDENTITY,
            reverse_orientation: false,
            material: number,
            emission,
            trim: None,
            receiver: None,
            location: None,
        });
    }
    description.lights.extend(lights.into_iter().map(|kind| LightDescription {
        kind,
        emission: SpectralDistribution::Constant(1.0),
        scale: 1.0,
        to_world: DMat4::IDENTITY,
        location: None,
    }));
    Scene::resolve(description).unwrap().0
}

/// A parallelogram from `corner` along `u` and `v`; its front is where u x v points.
pub(crate) fn parallelogram(corner: DVec3, u: DVec3, v: DVec3) -> GeometryDescription {
    GeometryDescription::Bilinear {
        positions: vec![corner, corner + u, corner + v, corner + u + v],
        indices: vec![[0, 1, 2, 3]],
    }
}

/// Six walls of the box from 0 to `size`, fronts inside: -x, +x, -y, +y, -z, +z.
pub(crate) fn walls(size: DVec3) -> Vec<GeometryDescription> {
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    vec![
        parallelogram(DVec3::ZERO, y, z),
        parallelogram(x, z, y),
        parallelogram(DVec3::ZERO, z, x),
        parallelogram(y, x, z),
        parallelogram(DVec3::ZERO, x, y),
        parallelogram(z, y, x),
    ]
}
