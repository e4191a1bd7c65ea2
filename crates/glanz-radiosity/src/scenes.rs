//! Scenes for the tests.

use glanz_math::DVec3;
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// Shapes with their reflectance and the radiance of their front.
pub(crate) fn scene(shapes: Vec<(ShapeDescription, f32, f32)>) -> Scene {
    scene_with(shapes, Vec::new())
}

/// As [`scene`], with lights that are not surfaces, of emission 1.
pub(crate) fn scene_with(shapes: Vec<(ShapeDescription, f32, f32)>, lights: Vec<LightKind>) -> Scene {
    let add_shape = |builder: SceneBuilder, (shape, reflectance, radiance): (ShapeDescription, f32, f32)| {
        let shape = if radiance > 0.0 { shape.emitting(radiance) } else { shape };
        builder.shape(shape, MaterialKind::diffuse(reflectance))
    };
    let builder = shapes.into_iter().fold(SceneBuilder::new(), add_shape);
    let lights = lights.into_iter().map(|kind| LightDescription::new(kind, 1.0));
    lights.fold(builder, SceneBuilder::light).resolve().unwrap().0
}

/// A parallelogram from `corner` along `u` and `v`; its front is where u x v points.
pub(crate) fn parallelogram(corner: DVec3, u: DVec3, v: DVec3) -> ShapeDescription {
    ShapeDescription::parallelogram(corner, u, v)
}

/// Six walls of the box from 0 to `size`, fronts inside: -x, +x, -y, +y, -z, +z.
pub(crate) fn walls(size: DVec3) -> Vec<ShapeDescription> {
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
