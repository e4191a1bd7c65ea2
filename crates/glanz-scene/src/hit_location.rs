//! Locations of hits on their surfaces.

use glanz_geometry::{RaySurface, SurfaceLocation};
use glanz_math::{DVec2, DVec3, Ray};
use glanz_shading::Material;

use crate::alpha::RayKind;
use crate::hit::SceneHit;
use crate::interaction::Interaction;
use crate::object::SceneObject;
use crate::placed::ParametricPoint;
use crate::scene::{Instance, Scene};

/// The location where a ray hit the scene, without what scattering needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitLocation {
    /// Position in the world, metres.
    pub position: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Number of the shape in the order of the scene file.
    pub shape: u32,
    /// Surface, face and parameters.
    pub place: ParametricPoint,
}

impl HitLocation {
    /// The location of an interaction with the parameters `place`.
    #[must_use]
    pub fn new(at: &Interaction, place: ParametricPoint) -> Self {
        Self { position: at.point.position, uv: at.point.uv, shape: at.id, place }
    }
}

impl Scene {
    /// The location of a hit: that of [`Scene::interaction`] and [`Scene::parametric_point`] at less cost, up to the side at grazing incidence,
    /// which rounding decides.
    #[must_use]
    pub fn hit_location(&self, ray: &Ray, found: &SceneHit) -> HitLocation {
        let hit = &found.hit;
        let own = u32::try_from(found.surface).ok();
        let Some((surface, object)) = own.and_then(|index| Some((index, self.world_object(index)?))) else {
            let at = self.interaction(ray, found);
            return HitLocation::new(&at, self.parametric_point(found, &at));
        };
        let attributes = object.attributes(hit.face);
        let local = object.local(ray);
        let SurfaceLocation { position, normal, uv } = object.surface().location(&local, hit);
        let position = object.to_parent().map_or(position, |to_parent| to_parent.point(position));
        // The side of a surface does not depend on the frame.
        let along = normal.dot(local.direction);
        let back = if attributes.reversed { along < 0.0 } else { along > 0.0 };
        let place = ParametricPoint { surface, face: hit.face, back, uv: DVec2::new(hit.u, hit.v) };
        HitLocation { position, uv, shape: attributes.id, place }
    }

    /// The object of a hit; `enter` gets the instances around it, from the outermost on.
    fn hit_object(&self, found: &SceneHit, mut enter: impl FnMut(&Instance)) -> &SceneObject {
        let (mut group, mut number) = (self.world(), found.surface);
        while let Some((instance, inner)) = group.instance_of(number) {
            enter(instance);
            (group, number) = (&self.groups[instance.group], inner);
        }
        &group.objects[number as usize]
    }

    /// The material of the surface at a hit.
    #[must_use]
    pub fn hit_material(&self, found: &SceneHit) -> &Material {
        self.material(self.hit_object(found, |_| ()).attributes(found.hit.face).material)
    }

    /// The opacity of the surface at a hit of `ray`: the probability with which it stopped the ray.
    #[must_use]
    pub fn hit_opacity(&self, ray: &Ray, found: &SceneHit) -> f64 {
        let mut moved = *ray;
        let object = self.hit_object(found, |instance| moved = instance.to_parent.inverse().ray(&moved));
        object.opacity(&object.local(&moved), &found.hit, RayKind::Closest)
    }
}

#[cfg(test)]
mod tests {
    use glanz_geometry::BoundedRay;
    use glanz_light::SpectralDistribution;
    use glanz_math::DMat4;
    use glanz_shading::texture::TextureMapping;

    use super::*;
    use crate::SceneBuilder;
    use crate::description::*;

    #[test]
    fn opacities_at_hits_are_those_of_places_in_the_frame_of_the_group() {
        // Opacity x between 0 and 1.
        let mapping = TextureMapping::Planar {
            v1: DVec3::X,
            v2: DVec3::Y,
            offset: DVec2::ZERO,
            to_texture: DMat4::IDENTITY,
        };
        let corners = [0.0, 0.0, 1.0, 1.0].map(SpectrumParameter::from);
        let kind = TextureKind::Bilerp { corners, mapping };
        let texture = TextureDescription { name: "slope".into(), kind, location: None };
        let turned = DMat4::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let to_world = DMat4::from_translation(DVec3::new(0.2, -0.3, 0.1)) * turned;
        // The point of a sphere is that of the ray; a cuboid has it from its parameters.
        let sloped = ShapeDescription::sphere(0.6)
            .scaled([1.0, 1.2, 0.9])
            .rotated(DVec3::Z, 0.3)
            .translated([0.5, 0.0, 0.0])
            .with_alpha(FloatParameter::Texture(0));
        let (scene, _) = SceneBuilder::new()
            .edit(|description| description.textures.push(texture))
            .group("box", |group| group.shape(sloped, MaterialKind::diffuse(0.5)))
            .instance("box", to_world)
            .shape(ShapeDescription::sphere(3.0), MaterialKind::diffuse(0.5))
            .resolve()
            .unwrap();
        let direction = |i: f64| DVec3::new((0.7 * i).sin(), (1.1 * i).cos(), (1.9 * i).sin());
        let (mut partly, mut opaque) = (0, 0);
        let ray = |i: f64| {
            let target = DVec3::new(0.5, 0.0, 0.0) + 0.4 * direction(i + 0.5);
            Ray::new(1.5 * direction(i), to_world.transform_point3(target) - 1.5 * direction(i))
        };
        let rays: Vec<BoundedRay> = (0..500).map(|i| ray(f64::from(i)).into()).collect();
        let mut hits = Vec::new();
        scene.closest_batch(&rays, &mut hits);
        for (BoundedRay { ray, .. }, hit) in rays.iter().zip(&hits) {
            let hit = hit.as_ref().unwrap();
            let (found, at) = (scene.hit_opacity(ray, hit), scene.interaction(ray, hit));
            let expected = if at.id == 1 {
                opaque += 1;
                1.0
            } else {
                partly += 1;
                to_world.inverse().transform_point3(at.point.position).x.clamp(0.0, 1.0)
            };
            assert!((found - expected).abs() < 1e-6, "{ray:?}: {found}, not {expected}");
        }
        assert!(partly > 50 && opaque > 50, "{partly} {opaque}");
    }

    #[test]
    fn locations_and_materials_are_those_of_interactions() {
        let black = || {
            let flat = SpectralDistribution::try_sampled(vec![(400.0, 0.0), (700.0, 0.0)]).unwrap();
            MaterialKind::diffuse(flat)
        };
        let side = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let wall =
            ShapeDescription::parallelogram(side(-3.0, 2.0, -3.0), side(6.0, 0.0, 0.0), side(0.5, 0.5, 6.0));
        let (scene, _) = SceneBuilder::new()
            .shape(wall.clone(), black())
            .shape(wall.translated([0.0, -4.0, 0.0]).rotated(DVec3::X, 0.2).reversed(), black())
            .shape(ShapeDescription::sphere(0.7).scaled([1.0, 1.2, 0.9]), MaterialKind::diffuse(0.5))
            .group("box", |group| group.shape(ShapeDescription::cuboid([0.0; 3], [1.0; 3]), black()))
            .instance("box", DMat4::from_translation(DVec3::X))
            .resolve()
            .unwrap();
        let direction = |i: f64| DVec3::new((0.7 * i).sin(), (1.1 * i).cos(), (1.9 * i).sin());
        // Some towards the sphere in the middle.
        let ray = |i: f64| Ray::new(2.0 * direction(i), direction(i + 0.5) - (i % 3.0) * direction(i));
        let rays: Vec<BoundedRay> = (0..500).map(|i| ray(f64::from(i)).into()).collect();
        let mut hits = Vec::new();
        scene.closest_batch(&rays, &mut hits);
        let mut black_hits = 0;
        for (BoundedRay { ray, .. }, hit) in rays.iter().zip(&hits) {
            let Some(hit) = hit else { continue };
            let at = scene.interaction(ray, hit);
            let location = scene.hit_location(ray, hit);
            assert_eq!(location, HitLocation::new(&at, scene.parametric_point(hit, &at)));
            assert_eq!(scene.hit_material(hit), scene.material(at.material));
            black_hits += usize::from(scene.hit_material(hit).absorbs_all());
        }
        let grey_hits = hits.iter().flatten().count() - black_hits;
        assert!(black_hits > 100 && grey_hits > 30, "{black_hits} {grey_hits}");
    }
}
