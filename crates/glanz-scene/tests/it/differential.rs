//! Footprints of rays against geometrical optics.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_3, PI};

use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{RayDifferential, Scene, SceneBuilder, SurfaceDifferential};

fn scene(shape: impl Into<ShapeDescription>) -> Scene {
    SceneBuilder::new().shape(shape, MaterialKind::diffuse(0.5)).resolve().unwrap().0
}

/// Rays of a pinhole along -z, whose directions are `angle` apart.
fn diverging(angle: f64) -> RayDifferential {
    RayDifferential { origin: [DVec3::ZERO; 2], direction: [angle * DVec3::X, angle * DVec3::Y] }
}

/// Parallel rays, one unit apart along two directions.
fn parallel(sides: [DVec3; 2]) -> RayDifferential {
    RayDifferential { origin: sides, direction: [DVec3::ZERO; 2] }
}

fn hit(scene: &Scene, ray: &Ray, differential: &RayDifferential) -> (f64, SurfaceDifferential) {
    let (at, _) = scene.intersect_differential(ray, Some(differential)).unwrap();
    (at.t, at.differential.unwrap())
}

/// Lengths of the sides across a ray at the parameter `t`.
fn widths(differential: &RayDifferential, direction: DVec3, t: f64) -> [f64; 2] {
    [0, 1].map(|i| {
        let side = differential.origin[i] + t * differential.direction[i];
        (side - direction * direction.dot(side)).length()
    })
}

fn assert_widths(found: [f64; 2], expected: [f64; 2]) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

#[test]
fn on_a_plane_the_footprint_is_angle_times_distance_and_longer_along_the_slope() {
    let (distance, angle) = (7.0, 0.01);
    for tilt in [0.0, 0.4, -1.2] {
        // 4 x 2 m, turned about x: uv are 1/4 and 1/2 per metre.
        let plane = ShapeDescription::rectangle([-2.0, 2.0], [-1.0, 1.0]).rotated(DVec3::X, tilt);
        for shape in [plane.clone(), plane.reversed()] {
            let ray = Ray::new(DVec3::Z * distance, -DVec3::Z);
            let (t, at) = hit(&scene(shape), &ray, &diverging(angle));
            assert!((t - distance).abs() < 1e-12);
            let (across, along) = (distance * angle, distance * angle / tilt.cos());
            let [x, y] = at.footprint.position;
            assert!((x - across * DVec3::X).length() < 1e-12);
            assert!((y - along * DVec3::new(0.0, tilt.cos(), tilt.sin())).length() < 1e-12, "{y}");
            assert!((at.footprint.uv[0] - DVec2::new(across / 4.0, 0.0)).length() < 1e-12);
            assert!((at.footprint.uv[1] - DVec2::new(0.0, along / 2.0)).length() < 1e-12);
            assert_eq!(at.normal, [DVec3::ZERO; 2]);
        }
    }
}

#[test]
fn footprints_on_triangles_are_in_their_texture_coordinates() {
    let footprint = |uvs: [DVec2; 3]| {
        let positions = vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let (indices, uvs) = (vec![[0, 1, 2]], Some(uvs.to_vec()));
        let mesh = GeometryDescription::Triangles { positions, indices, normals: None, uvs };
        let moved = ShapeDescription::from(mesh).transformed(DMat4::from_scale(DVec3::splat(10.0)));
        let (_, at) = hit(&scene(moved), &Ray::new(DVec3::new(5.0, 5.0, 3.0), -DVec3::Z), &diverging(0.1));
        at.footprint.uv
    };
    let half = DVec2::new(0.5, 0.0);
    // 0.3 m in the world are 0.03 m of the mesh.
    for (uvs, expected) in [
        // u = (x + y) / 2, v = 5 y / 2.
        ([DVec2::ZERO, DVec2::X, DVec2::new(1.0, 5.0)], [DVec2::new(0.015, 0.0), DVec2::new(0.015, 0.075)]),
        // On a line: u = x / 2 + y / 4; at one point.
        ([DVec2::ZERO, DVec2::X, half], [DVec2::new(0.015, 0.0), DVec2::new(0.0075, 0.0)]),
        ([half; 3], [DVec2::ZERO; 2]),
    ] {
        for (found, expected) in footprint(uvs).into_iter().zip(expected) {
            assert!((found - expected).length() < 1e-12, "{uvs:?}: {found}");
        }
    }
}

#[test]
fn behind_a_plane_mirror_the_footprint_is_that_of_the_unfolded_way() {
    let mirror = ShapeDescription::rectangle([-9.0, 9.0], [-9.0, 9.0]);
    let direction = DVec3::new(0.6, 0.0, -0.8);
    let sides = [DVec3::new(0.8, 0.0, 0.6), DVec3::Y].map(|side| 0.01 * side);
    let pinhole = RayDifferential { origin: [DVec3::ZERO; 2], direction: sides };
    let (t, at) = hit(&scene(mirror), &Ray::new(DVec3::Z * 4.0, direction), &pinhole);
    let mirrored = DVec3::new(0.6, 0.0, 0.8);
    let next = at.scattered(direction, mirrored, DVec3::Z, 1.0).unwrap();
    for beyond in [0.0, 3.0] {
        assert_widths(widths(&next, mirrored, beyond), [0.01 * (t + beyond); 2]);
    }
}

/// The focal lengths of a spherical mirror of radius R at the angle of incidence a are R cos(a) / 2 in the plane of incidence, and R / (2 cos(a)) across it
/// (Coddington).
#[test]
fn a_concave_mirror_focuses_parallel_rays_at_half_its_radius() {
    let radius = 3.0;
    for reversed in [false, true] {
        let mirror = ShapeDescription::sphere(radius).rotated(DVec3::X, 1.0);
        let mirror = scene(if reversed { mirror.reversed() } else { mirror });
        for angle in [0.0, 0.3, FRAC_PI_3] {
            // From inside, to (0, 0, -R); the plane of incidence is that of x and z.
            let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
            let sides = [DVec3::new(angle.cos(), 0.0, angle.sin()), DVec3::Y];
            let ray = Ray::new(DVec3::Z * -radius - direction, direction);
            let (at, _) = mirror.intersect_differential(&ray, Some(&parallel(sides))).unwrap();
            let mirrored = DVec3::new(angle.sin(), 0.0, angle.cos());
            let differential = at.differential.unwrap();
            let next = differential.scattered(direction, mirrored, at.point.shading_normal, 1.0).unwrap();
            let [tangential, sagittal] = [0.5 * radius * angle.cos(), 0.5 * radius / angle.cos()];
            assert!(widths(&next, mirrored, tangential)[0] < 1e-12);
            assert!(widths(&next, mirrored, sagittal)[1] < 1e-12);
            // Behind the focus as before it.
            assert_widths(widths(&next, mirrored, 0.0), [1.0; 2]);
            assert!((widths(&next, mirrored, 2.0 * tangential)[0] - 1.0).abs() < 1e-12);
        }
    }
}

/// A convex mirror spreads parallel rays as if they came from R / 2 behind it.
#[test]
fn a_convex_mirror_spreads_parallel_rays() {
    let mirror = scene(ShapeDescription::sphere(2.0).rotated(DVec3::X, 1.0).translated([0.0, 0.0, -2.0]));
    let ray = Ray::new(DVec3::Z * 5.0, -DVec3::Z);
    let (_, at) = hit(&mirror, &ray, &parallel([DVec3::X, DVec3::Y]));
    let next = at.scattered(-DVec3::Z, DVec3::Z, DVec3::Z, 1.0).unwrap();
    assert_widths(widths(&next, DVec3::Z, 3.0), [1.0 + 3.0; 2]);
}

/// Within a pane light diverges by sin(a') = sin(a) / n: the pane counts by its thickness over n along the normal, and is no lens.
#[test]
fn a_pane_brings_things_closer_by_its_thickness_over_its_index() {
    let (thickness, index, angle) = (0.5, 1.6, 0.02);
    let pane = scene(ShapeDescription::cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, thickness]));
    let down = -DVec3::Z;
    let (_, top) = hit(&pane, &Ray::new(DVec3::new(0.1, 0.2, 2.5), down), &diverging(angle));
    let inside = top.scattered(down, down, DVec3::Z, 1.0 / index).unwrap();
    let (_, bottom) = hit(&pane, &Ray::new(DVec3::new(0.1, 0.2, thickness - 1e-9), down), &inside);
    let below = bottom.scattered(down, down, -DVec3::Z, index).unwrap();
    assert_widths(widths(&below, down, 1.0), [angle * (2.0 + thickness / index + 1.0); 2]);
}

/// By the differential of Snell's law, cos(a) da = n cos(a') da'; across the plane of incidence directions shrink by n.
#[test]
fn refraction_at_a_plane_changes_directions_by_the_differential_of_snells_law() {
    let glass = scene(ShapeDescription::rectangle([-9.0, 9.0], [-9.0, 9.0]));
    let (angle, index) = (1.1_f64, 1.5);
    let refracted = (angle.sin() / index).asin();
    let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
    let sides = [DVec3::new(angle.cos(), 0.0, angle.sin()), DVec3::Y];
    let pinhole = RayDifferential { origin: [DVec3::ZERO; 2], direction: sides };
    let (_, at) = hit(&glass, &Ray::new(DVec3::Z, direction), &pinhole);
    let inside = DVec3::new(refracted.sin(), 0.0, -refracted.cos());
    let next = at.scattered(direction, inside, DVec3::Z, 1.0 / index).unwrap();
    let lengths = next.direction.map(DVec3::length);
    assert_widths(lengths, [angle.cos() / (index * refracted.cos()), 1.0 / index]);
    // Leaving again at the same angle, it is undone; at the critical angle it has no bound.
    let (_, at) =
        hit(&glass, &Ray::new(-inside, inside), &RayDifferential { origin: [DVec3::ZERO; 2], ..next });
    let outside = at.scattered(inside, direction, DVec3::Z, index).unwrap();
    assert_widths(outside.direction.map(DVec3::length), [1.0; 2]);
    assert_eq!(at.scattered(inside, DVec3::X, DVec3::Z, index), None);
}

/// The focal length of a ball of radius R and index n is n R / (2 (n - 1)), from its middle.
#[test]
fn a_ball_lens_focuses_parallel_rays() {
    let (radius, index) = (0.8, 1.5);
    let ball = scene(ShapeDescription::sphere(radius).rotated(DVec3::X, 1.0));
    let down = -DVec3::Z;
    let (_, top) = hit(&ball, &Ray::new(DVec3::Z * 2.0, down), &parallel([DVec3::X, DVec3::Y]));
    let inside = top.scattered(down, down, DVec3::Z, 1.0 / index).unwrap();
    let (_, bottom) = hit(&ball, &Ray::new(DVec3::Z * (radius - 1e-9), down), &inside);
    let outside = bottom.scattered(down, down, -DVec3::Z, index).unwrap();
    let focus = index * radius / (2.0 * (index - 1.0)) - radius;
    assert!(widths(&outside, down, focus).into_iter().all(|width| width < 1e-8));
    // At the back, beams are as wide as their way to the focus is a part of the focal length.
    let back = focus / (focus + radius);
    assert_widths(widths(&outside, down, 0.0), [back; 2]);
}

#[test]
fn grazing_rays_and_poles_of_parameters_have_no_footprint_or_a_finite_one() {
    let sphere = scene(ShapeDescription::sphere(1.0));
    for x in [0.0, 1e-12, FRAC_1_SQRT_2, 1.0 - 1e-16, 1.0] {
        let ray = Ray::new(DVec3::new(x, 0.0, 3.0), -DVec3::Z);
        let found = sphere.intersect_differential(&ray, Some(&diverging(0.01)));
        if let Some(at) = found.and_then(|(at, _)| at.differential) {
            let sides = at.footprint.position.into_iter().chain(at.direction);
            assert!(sides.into_iter().all(DVec3::is_finite), "{x}: {at:?}");
            assert!(at.footprint.uv.into_iter().all(DVec2::is_finite), "{x}: {at:?}");
            // Whatever the normal there, the next ray has a finite one or none.
            let next = at.scattered(ray.direction, DVec3::Z, DVec3::Z, 1.0);
            assert!(next.is_none_or(|next| next.direction.into_iter().all(DVec3::is_finite)));
        }
    }
}

/// The differential of a mirror in a stretched and turned frame is that of the rays beside it.
#[test]
fn differentials_are_limits_of_differences() {
    let to_world = DMat4::from_rotation_y(0.7) * DMat4::from_scale(DVec3::new(1.0, 2.0, 0.5));
    let shape = ShapeDescription::torus(1.0, 0.4).transformed(to_world);
    let mirror = SceneBuilder::new()
        .group("ring", |group| group.shapes([shape], MaterialKind::diffuse(0.5)))
        .instance(
            "ring",
            DMat4::from_translation(DVec3::new(0.1, 0.2, 0.3)) * DMat4::from_rotation_x(PI / 7.0),
        )
        .resolve()
        .unwrap()
        .0;
    let ray = |x: f64, y: f64| {
        let direction = DVec3::new(0.05 + 0.3 * x, 0.25 + 0.2 * y, -1.0).normalize();
        Ray::new(DVec3::new(0.2 + 0.1 * x, 0.4, 5.0 + 0.1 * y), direction)
    };
    let mirrored = |ray: &Ray| {
        let (at, _) = mirror.intersect_parametric(ray, f64::INFINITY).unwrap();
        let n = at.point.normal;
        let d = ray.direction - 2.0 * n.dot(ray.direction) * n;
        (at.point.position, at.point.uv, d, n)
    };
    let step = 1e-5;
    let difference = |get: &dyn Fn(&Ray) -> DVec3| {
        let along =
            |x: f64, y: f64| (get(&ray(step * x, step * y)) - get(&ray(-step * x, -step * y))) / (2.0 * step);
        [along(1.0, 0.0), along(0.0, 1.0)]
    };
    let start = RayDifferential {
        origin: difference(&|ray| ray.origin),
        direction: difference(&|ray| ray.direction),
    };
    let middle = ray(0.0, 0.0);
    let (_, at) = hit(&mirror, &middle, &start);
    let (_, _, leaving, normal) = mirrored(&middle);
    let next = at.scattered(middle.direction, leaving, normal, 1.0).unwrap();
    let close = |found: [DVec3; 2], expected: [DVec3; 2]| {
        assert!(found.iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-6), "{found:?} {expected:?}");
    };
    close(at.footprint.position, difference(&|ray| mirrored(ray).0));
    close(at.footprint.uv.map(|uv| uv.extend(0.0)), difference(&|ray| mirrored(ray).1.extend(0.0)));
    close(at.normal, difference(&|ray| mirrored(ray).3));
    close(next.direction, difference(&|ray| mirrored(ray).2));
}
