//! Surfaces in world space, to be evaluated by their parameters.

use glanz_geometry::{FaceDomain, Hit, RaySurface, ShadingPoint, Surface, SurfacePoint};
use glanz_math::{Bounds3, DVec2, DVec3, Ray, Transform};
use glanz_shading::TexturePoint;

use crate::alpha::RayKind;
use crate::interaction::Interaction;
use crate::light::LightId;
use crate::object::SceneObject;
use crate::parameterization::LocalPoint;
use crate::scene::{Scene, SceneGroup};

/// A surface in world space.
///
/// Its faces are those of [`Surface::at`]; joined meshes are one surface, each face of which belongs to its own shape.
#[derive(Clone, Debug)]
pub struct PlacedSurface<'a> {
    object: &'a SceneObject,
    /// Transformations from the group of the object to the world, innermost first.
    maps: Vec<Transform>,
}

/// A point of the surfaces of [`Scene::placed_surfaces`] by its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParametricPoint {
    /// Index of the surface; `u32::MAX` for all from that one on, which no list holds.
    pub surface: u32,
    /// Face of the surface.
    pub face: u32,
    /// Whether it is on the side that the normal points away from.
    pub back: bool,
    /// Parameters of the face.
    pub uv: DVec2,
}

/// A point on one side of a placed surface.
#[derive(Clone, Copy, Debug)]
pub struct PlacedPoint {
    /// The hit of a ray that arrives along the normal of that side.
    pub at: Interaction,
    /// Area per unit of the parameters, m^2.
    pub area_element: f64,
    /// The opacity: the fraction of rays that the surface stops.
    pub opacity: f32,
}

impl Scene {
    /// All surfaces of the world; those of a group once for each instance.
    #[must_use]
    pub fn placed_surfaces(&self) -> Vec<PlacedSurface<'_>> {
        let mut placed = Vec::new();
        self.place(self.world(), &[], &mut placed);
        placed
    }

    fn place<'a>(&'a self, group: &'a SceneGroup, maps: &[Transform], placed: &mut Vec<PlacedSurface<'a>>) {
        placed.extend(group.objects.iter().map(|object| PlacedSurface { object, maps: maps.to_vec() }));
        for instance in &group.instances {
            if let Some(inner) = self.groups.get(instance.group) {
                let maps = [&[instance.to_parent], maps].concat();
                self.place(inner, &maps, placed);
            }
        }
    }
}

impl PlacedSurface<'_> {
    /// The surface in its own frame.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        self.object.surface()
    }

    /// Number of faces; 0 if the surface has no parameters.
    #[must_use]
    pub fn faces(&self) -> u32 {
        self.surface().faces()
    }

    /// The parameters of a face.
    #[must_use]
    pub fn face_domain(&self, face: u32) -> FaceDomain {
        self.surface().face_domain(face)
    }

    /// Number of the shape of a face in the order of the scene file.
    #[must_use]
    pub fn shape(&self, face: u32) -> u32 {
        self.object.attributes(face).id
    }

    /// Number of the material of a face.
    #[must_use]
    pub fn material(&self, face: u32) -> u32 {
        self.object.attributes(face).material
    }

    /// Whether the normal of a face is reversed.
    #[must_use]
    pub fn is_reversed(&self, face: u32) -> bool {
        self.object.attributes(face).reversed
    }

    /// The light that it is, if it emits.
    #[must_use]
    pub fn light(&self) -> Option<LightId> {
        self.object.light
    }

    /// Whether it is an interface, which light passes.
    #[must_use]
    pub fn is_passable(&self) -> bool {
        self.object.passable
    }

    /// Whether trimming cuts a part of it away.
    #[must_use]
    pub fn is_trimmed(&self) -> bool {
        self.surface().trim_region().is_some()
    }

    /// Its bounding box in the world.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        self.maps.iter().fold(self.object.bounds(), |bounds, map| map.bounds(&bounds))
    }

    /// Transformation from the frame of the surface to the world.
    #[must_use]
    pub fn to_world(&self) -> Transform {
        let own = self.object.to_parent().copied().unwrap_or_default();
        self.maps.iter().fold(own, |inner, map| map.after(&inner))
    }

    /// The hit of `ray` with parameter `t` at `place` in the world, with its derivatives, and the derivatives `[dn/du, dn/dv]` of its
    /// shading normal by the texture coordinates. The sign of the normal does not depend on the side that is hit.
    #[must_use]
    pub fn differential(&self, ray: &Ray, t: f64, place: &ParametricPoint) -> (SurfacePoint, [DVec3; 2]) {
        let to_world = self.to_world();
        let hit = Hit::new(t, place.uv.x, place.uv.y, place.face);
        let point = self.surface().point(&to_world.inverse().ray(ray), &hit);
        let derivatives = self.surface().normal_derivatives(&hit, &point);
        let derivatives = point.transformed_normal_derivatives(derivatives, &to_world);
        let point = point.transformed(&to_world);
        if self.object.attributes(place.face).reversed {
            (point.reversed(), derivatives.map(|derivative| -derivative))
        } else {
            (point, derivatives)
        }
    }

    /// The point with these parameters on the side of the normal, or on the other (`back`). `None` where there is no surface.
    #[must_use]
    pub fn at(&self, face: u32, uv: DVec2, back: bool) -> Option<PlacedPoint> {
        let local = self.surface().at(face, uv)?;
        let attributes = self.object.attributes(face);
        let own_normal = if back != attributes.reversed { -local.point.normal } else { local.point.normal };
        let own = LocalPoint { position: local.point.position, normal_to_viewer: own_normal };
        let (mut point, mut area_element) = (ShadingPoint::from(local.point), local.area_element);
        let opacity = self.object.alpha.as_ref().map_or(1.0, |alpha| {
            let point = self.object.to_parent().map_or(local.point, |map| local.point.transformed(map));
            let at = TexturePoint::new(point.uv, point.position).with_normal(point.normal);
            alpha.opacity(&at, RayKind::Closest)
        });
        for map in self.object.to_parent().into_iter().chain(&self.maps) {
            area_element *= map.area_scale(point.normal);
            point = point.transformed(map);
        }
        if attributes.reversed {
            point = point.reversed();
        }
        let at = Interaction {
            point,
            t: 0.0,
            wo: if back { -point.normal } else { point.normal },
            id: attributes.id,
            differential: None,
            own: Some(own),
            area_pdf: None,
            material: attributes.material,
            media: attributes.media,
            light: self.object.light,
        };
        Some(PlacedPoint { at, area_element, opacity: opacity as f32 })
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DMat4;

    use super::*;
    use crate::SceneBuilder;
    use crate::description::*;

    /// A stretched box with reversed normals, and twice a ring and a mesh, once mirrored.
    fn scene() -> Scene {
        let grey = || MaterialKind::diffuse(0.5);
        let cuboid = ShapeDescription::cuboid([0.0; 3], [1.0; 3]).scaled([1.0, 2.0, 3.0]);
        let tent = ShapeDescription::mesh(
            vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::new(0.0, 2.0, 1.0)],
            vec![[0, 1, 2], [0, 2, 3]],
        );
        let ring = GeometryDescription::Disk { height: -1.0, radius: 1.0, inner_radius: 0.5, phi_max: 3.0 };
        let right = |x: f64| DMat4::from_translation(DVec3::X * x);
        SceneBuilder::new()
            .shape(cuboid.rotated(DVec3::Z, 0.3).translated([-5.0, 0.0, 0.0]).reversed(), grey())
            .group("tent", |group| group.shapes([tent, ring.into()], grey()))
            .group("nothing", |group| group)
            .instance("nothing", right(1.0))
            .instance("tent", right(3.0))
            .instance("nothing", right(2.0))
            .instance("tent", right(9.0) * DMat4::from_scale(DVec3::new(-2.0, 2.0, 2.0)))
            .resolve()
            .unwrap()
            .0
    }

    #[test]
    fn rays_hit_parametric_points_where_they_are_evaluated() {
        let scene = scene();
        let placed = scene.placed_surfaces();
        assert_eq!(placed.len(), 5);
        let parameterizations = scene.parameterizations();
        let mut count = 0;
        for (number, surface) in (0..).zip(&placed) {
            for (face, i) in (0..surface.faces()).flat_map(|face| (0..25).map(move |i| (face, i))) {
                // Within triangles too.
                let uv = DVec2::new(f64::from(i % 5) + 0.5, f64::from(i / 5) + 0.5) / 10.0;
                for back in [false, true] {
                    let PlacedPoint { at, .. } = surface.at(face, uv, back).unwrap();
                    let ray = Ray::new(at.point.position + 0.01 * at.wo, -at.wo);
                    let (hit, found) = scene.intersect_parametric(&ray, 0.02).unwrap();
                    assert_eq!((found.surface, found.face, found.back), (number, face, back));
                    assert!(found.uv.distance(uv) < 1e-9);
                    assert_eq!((hit.id, hit.material, hit.light), (at.id, at.material, at.light));
                    assert_eq!(surface.shape(face), hit.id);
                    assert!(hit.point.position.distance(at.point.position) < 1e-12);
                    assert!(hit.point.uv.distance(at.point.uv) < 1e-9);
                    assert!(hit.point.normal.dot(at.point.normal) > 1.0 - 1e-12);
                    let parameterization = parameterizations[hit.id as usize].unwrap();
                    let ((sheet, place), (expected, expected_place)) =
                        (parameterization.locate(&at), parameterization.locate(&hit));
                    assert!(sheet == expected && place.distance(expected_place) < 1e-9);
                    count += 1;
                }
            }
        }
        assert_eq!(count, (6 + 2 * 3) * 50);
    }

    #[test]
    fn stretch_is_the_area_in_the_world() {
        let scene = scene();
        let area = |surface: &PlacedSurface<'_>, face| {
            surface.at(face, DVec2::splat(0.25), false).unwrap().area_element
        };
        let placed = scene.placed_surfaces();
        let cuboid = placed.iter().find(|placed| placed.faces() == 6).unwrap();
        let areas: Vec<f64> = (0..6).map(|face| area(cuboid, face)).collect();
        for (area, expected) in areas.iter().zip([6.0, 6.0, 3.0, 3.0, 2.0, 2.0]) {
            assert!((area - expected).abs() < 1e-12, "{areas:?}");
        }
        let corner = |surface: &PlacedSurface<'_>| {
            let local = surface.surface().at(0, DVec2::ZERO).unwrap().point.position;
            let world = surface.at(0, DVec2::ZERO, false).unwrap().at.point.position;
            surface.to_world().point(local).distance(world)
        };
        assert!(placed.iter().all(|surface| corner(surface) < 1e-12));
        // Twice as large in every direction.
        let tents: Vec<f64> = placed.iter().filter(|p| p.faces() == 2).map(|p| area(p, 0)).collect();
        assert!((tents[1] / tents[0] - 4.0).abs() < 1e-12, "{tents:?}");
    }
}
