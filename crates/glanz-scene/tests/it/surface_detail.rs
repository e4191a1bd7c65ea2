//! Bumps and maps of normals against derived normals.

use glanz_light::Pixels;
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Interaction, Scene, SceneBuilder};

/// A height of `slope` times the first coordinate of the mapping, plus `base`.
fn ramp(mapping: MappingDescription, base: f32, slope: f32) -> TextureKind {
    let [low, high] = [base, base + slope].map(SpectrumParameter::from);
    TextureKind::Bilerp { corners: [low.clone(), low, high.clone(), high], mapping }
}

fn uv() -> MappingDescription {
    MappingDescription::Uv { scale: DVec2::ONE, offset: DVec2::ZERO }
}

fn builder(detail: Option<SurfaceDetailDescription>, height: TextureKind) -> SceneBuilder {
    SceneBuilder::new().edit(|description| {
        let (name, kind) = ("detail".to_owned(), MaterialKind::diffuse(0.5));
        let material = MaterialDescription { name: name.clone(), surface_detail: detail, ..kind.into() };
        description.materials.push(material);
        description.textures.push(TextureDescription { name, kind: height, location: None });
    })
}

const BUMP: Option<SurfaceDetailDescription> =
    Some(SurfaceDetailDescription::Bump(FloatParameter::Texture(0)));

/// The first hit of a ray with a shape of a height.
fn bumped(shape: impl Into<ShapeDescription>, height: TextureKind, ray: &Ray) -> Interaction {
    let (scene, _) = builder(BUMP, height).shape(shape, "detail").resolve().unwrap();
    scene.intersect(ray, f64::INFINITY).unwrap()
}

fn assert_close(found: DVec3, expected: DVec3) {
    // Heights are f32: a difference over the step 0.0005 has an error of about 1e-4 of the height.
    assert!(found.distance(expected.normalize()) < 3e-4, "{found} {}", expected.normalize());
    assert!((found.length() - 1.0).abs() < 1e-12);
}

fn down(x: f64, y: f64) -> Ray {
    Ray::new(DVec3::new(x, y, 5.0), -DVec3::Z)
}

#[test]
fn a_ramp_tilts_the_normal_of_a_plane_by_the_angle_of_its_slope() {
    // u grows by 1 over 2 m.
    let plane = || ShapeDescription::rectangle([0.0, 2.0], [0.0, 1.0]);
    for slope in [0.0, 0.1, 1.0, -3.0] {
        let hit = bumped(plane(), ramp(uv(), 0.2, slope), &down(0.7, 0.4));
        assert_eq!(hit.point.normal, DVec3::Z);
        let tilt = (0.5 * f64::from(slope)).atan();
        assert_close(hit.point.shading_normal, DVec3::new(-tilt.sin(), 0.0, tilt.cos()));
    }
    // Heights count along the normal: on the reversed side hills are valleys.
    let hit = bumped(plane().reversed(), ramp(uv(), 0.0, 1.0), &down(0.7, 0.4));
    assert_close(hit.point.shading_normal, DVec3::new(-0.5, 0.0, -1.0));
}

#[test]
fn heights_in_the_world_do_not_depend_on_the_frame_of_the_shape() {
    let across = DVec3::new(0.6, 0.8, 0.0);
    let mapping = MappingDescription::Planar {
        v1: across,
        v2: DVec3::Z,
        offset: DVec2::ZERO,
        to_texture: DMat4::IDENTITY,
    };
    let square = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let turned = DMat4::from_rotation_z(1.1) * DMat4::from_scale(DVec3::new(3.0, 2.0, 1.0));
    let mirrored = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * turned;
    let check = |scene: Scene| {
        let point = scene.intersect(&down(0.3, -0.2), f64::INFINITY).unwrap().point;
        // Heights count along the normal, wherever it points to.
        assert_close(point.shading_normal, point.normal - 0.4 * across);
    };
    for to_world in [DMat4::IDENTITY, turned, mirrored] {
        for shape in [square(), square().reversed()] {
            let builder = || builder(BUMP, ramp(mapping, 0.1, 0.4));
            check(builder().shape(shape.clone().transformed(to_world), "detail").resolve().unwrap().0);
            let group = builder().group("square", |group| group.shape(shape, "detail"));
            check(group.instance("square", to_world).resolve().unwrap().0);
        }
    }
}

#[test]
fn a_constant_height_leaves_normals_of_curved_surfaces() {
    let height = || TextureKind::Constant(0.3.into());
    let ray = Ray::new(DVec3::new(3.0, 2.0, 1.0), DVec3::new(-3.0, -1.9, -0.8));
    let vertices = [DVec3::X, DVec3::Y, DVec3::Z].to_vec();
    let mesh = GeometryDescription::Triangles {
        positions: vertices.clone(),
        indices: vec![[0, 1, 2]],
        normals: Some(vertices),
        uvs: None,
    };
    for shape in [ShapeDescription::sphere(1.5), ShapeDescription::torus(1.2, 0.6), mesh.into()] {
        let hit = bumped(shape.clone(), height(), &ray);
        let (scene, _) = builder(None, height()).shape(shape, "detail").resolve().unwrap();
        let smooth = scene.intersect(&ray, f64::INFINITY).unwrap();
        assert!(hit.point.shading_normal.distance(smooth.point.shading_normal) < 1e-9);
        assert_eq!(hit.point.normal, smooth.point.normal);
    }
}

#[test]
fn a_cylinder_with_a_ramp_along_its_axis_is_a_cone() {
    // v grows by 1 over 4 m, the radius by 0.8 m.
    let height =
        TextureKind::Bilerp { corners: [0.1, 0.9, 0.1, 0.9].map(SpectrumParameter::from), mapping: uv() };
    let ray = Ray::new(DVec3::new(5.0, 5.0, 1.0), DVec3::new(-1.0, -1.0, 0.0));
    let hit = bumped(ShapeDescription::cylinder(1.0, [-2.0, 2.0]), height, &ray);
    assert_close(hit.point.shading_normal, DVec3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), -0.2));
}

/// A square mesh with texture coordinates turned by a quarter and twice as dense; `x` grows with -v, `y` with u.
fn turned_mesh() -> GeometryDescription {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(DVec2::from);
    GeometryDescription::Triangles {
        positions: corners.map(|p| p.extend(0.0)).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uvs: Some(corners.map(|p| 2.0 * DVec2::new(p.y, -p.x)).to_vec()),
    }
}

/// The shading normal of a shape with a picture of one normal.
fn mapped(shape: impl Into<ShapeDescription>, rgb: [f32; 3], ray: &Ray) -> (DVec3, DVec3) {
    let detail = Some(SurfaceDetailDescription::NormalMap(0));
    let scene = builder(detail, TextureKind::Constant(0.0.into())).edit(|description| {
        let pixels = Pixels::try_from_rgb(1, 1, &[rgb]).unwrap();
        description.images.push(ImageDescription::try_new("normals", &pixels).unwrap());
    });
    let (scene, _) = scene.shape(shape, "detail").resolve().unwrap();
    let point = scene.intersect(ray, f64::INFINITY).unwrap().point;
    (point.shading_normal, point.normal)
}

fn close(a: DVec3, b: DVec3) -> bool {
    a.distance(b) < 1e-6
}

#[test]
fn normal_maps_tilt_in_the_frame_of_the_texture() {
    let color = |normal: DVec3| (0.5 * normal + 0.5).as_vec3().to_array();
    let plane = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let (sin, cos) = 0.4_f64.sin_cos();
    let ray = down(0.3, 0.2);
    let (along_u, along_v) = (color(DVec3::new(sin, 0.0, cos)), color(DVec3::new(0.0, sin, cos)));
    assert!(close(mapped(plane(), along_u, &ray).0, DVec3::new(sin, 0.0, cos)));
    assert!(close(mapped(plane(), along_v, &ray).0, DVec3::new(0.0, sin, cos)));
    // The scale of the texture coordinates does not count, their direction does.
    assert!(close(mapped(turned_mesh(), along_u, &ray).0, DVec3::new(0.0, sin, cos)));
    assert!(close(mapped(turned_mesh(), along_v, &ray).0, DVec3::new(-sin, 0.0, cos)));
    let stretched = plane().scaled([4.0, 0.5, 1.0]).rotated(DVec3::Z, 0.7);
    let u = DVec3::new(0.7_f64.cos(), 0.7_f64.sin(), 0.0);
    assert!(close(mapped(stretched, along_u, &ray).0, sin * u + cos * DVec3::Z));
}

#[test]
fn normal_maps_lean_towards_growing_v_on_mirrored_surfaces_too() {
    let color = |normal: DVec3| (0.5 * normal + 0.5).as_vec3().to_array();
    let (sin, cos) = 0.4_f64.sin_cos();
    let (along_u, along_v) = (color(DVec3::new(sin, 0.0, cos)), color(DVec3::new(0.0, sin, cos)));
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(DVec2::from);
    let mirrored = || GeometryDescription::Triangles {
        positions: corners.map(|p| p.extend(0.0)).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uvs: Some(corners.map(|p| DVec2::new(-p.x, p.y)).to_vec()),
    };
    let ray = down(0.3, 0.2);
    assert!(close(mapped(mirrored(), along_u, &ray).0, DVec3::new(-sin, 0.0, cos)));
    assert!(close(mapped(mirrored(), along_v, &ray).0, DVec3::new(0.0, sin, cos)));
    let plane = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let node = || plane().scaled([-1.0, 1.0, 1.0]);
    assert!(close(mapped(node(), along_u, &ray).0, DVec3::new(-sin, 0.0, cos)));
    assert!(close(mapped(node(), along_v, &ray).0, DVec3::new(0.0, sin, cos)));
    assert!(close(mapped(plane().reversed(), along_v, &ray).0, DVec3::new(0.0, sin, -cos)));
}

#[test]
fn the_blue_of_an_even_surface_changes_no_normal_and_normals_below_the_surface_do_not_count() {
    let ray = Ray::new(DVec3::new(3.0, 2.0, 1.0), DVec3::new(-3.0, -1.9, -0.8));
    for rgb in [[0.5, 0.5, 1.0], [0.5, 0.5, 0.0], [1.0, 0.5, 0.4], [0.5; 3]] {
        let (shading, normal) = mapped(ShapeDescription::sphere(1.5), rgb, &ray);
        assert!(shading.distance(normal) < 1e-15, "{rgb:?}");
    }
}
