use std::f64::consts::FRAC_PI_2;

use glanz_math::DMat4;

use super::*;
use crate::description::{FisheyeProjection, IrisDescription, SphericalMapping};

fn film(width: u32, height: u32) -> FilmDescription {
    FilmDescription { resolution: [width, height], ..FilmDescription::default() }
}

#[test]
fn field_of_view_spans_the_shorter_side() {
    let camera = CameraDescription {
        kind: CameraKind::Perspective { field_of_view: FRAC_PI_2 },
        ..CameraDescription::default()
    };
    for (w, h) in [(400, 200), (200, 400)] {
        let camera = Camera::try_new(&camera, &film(w, h)).unwrap();
        let short = f64::from(w.min(h));
        let middle = DVec2::new(f64::from(w), f64::from(h)) * 0.5;
        // tan 45 degrees = 1 at the border of the shorter side.
        let edge = if w < h { DVec2::new(short * 0.5, 0.0) } else { DVec2::new(0.0, -short * 0.5) };
        let d = camera.ray(middle + edge, DVec2::ZERO).unwrap().ray.direction;
        let expected = if w < h { DVec3::new(1.0, 0.0, 1.0) } else { DVec3::new(0.0, 1.0, 1.0) };
        assert!((d - expected.normalize()).length() < 1e-15, "{d}");
    }
}

#[test]
fn orthographic_rays_are_parallel_and_cover_the_window() {
    let camera = CameraDescription {
        kind: CameraKind::Orthographic,
        screen_window: Some([-3.0, 3.0, -1.0, 1.0]),
        to_world: DMat4::from_translation(DVec3::new(0.0, 0.0, 7.0)),
        ..CameraDescription::default()
    };
    let camera = Camera::try_new(&camera, &film(300, 100)).unwrap();
    let ray = camera.ray(DVec2::new(300.0, 0.0), DVec2::ZERO).unwrap().ray;
    assert_eq!(ray.direction, DVec3::Z);
    assert!((ray.origin - DVec3::new(3.0, 1.0, 7.0)).length() < 1e-14);
}

#[test]
fn rays_of_one_film_point_meet_in_the_plane_of_focus() {
    let camera = CameraDescription { lens_radius: 0.5, focal_distance: 4.0, ..CameraDescription::default() };
    let camera = Camera::try_new(&camera, &film(64, 64)).unwrap();
    let at_focus = |lens| {
        let ray = camera.ray(DVec2::new(10.0, 20.0), lens).unwrap().ray;
        ray.at((4.0 - ray.origin.z) / ray.direction.z)
    };
    let a = at_focus(DVec2::new(0.1, 0.9));
    let b = at_focus(DVec2::new(0.8, 0.3));
    assert!((a - b).length() < 1e-14);
}

/// The kinds of cameras that project, each with its lenses.
fn kinds() -> Vec<(CameraKind, f64)> {
    let mut kinds = Vec::new();
    for kind in [CameraKind::Perspective { field_of_view: 0.9 }, CameraKind::Orthographic] {
        kinds.extend([(kind.clone(), 0.0), (kind, 0.3)]);
    }
    for mapping in [SphericalMapping::EqualArea, SphericalMapping::Equirectangular] {
        kinds.push((CameraKind::Spherical(mapping), 0.0));
    }
    for projection in
        [FisheyeProjection::Equidistant, FisheyeProjection::Equisolid, FisheyeProjection::Stereographic]
    {
        kinds.push((CameraKind::Fisheye { field_of_view: 3.8, projection }, 0.0));
    }
    kinds
}

/// All kinds under a matrix that turns, mirrors and stretches.
fn cameras() -> Vec<Camera> {
    let to_world = DMat4::from_translation(DVec3::new(1.0, -2.0, 0.5))
        * DMat4::from_rotation_y(0.7)
        * DMat4::from_scale(DVec3::new(-1.5, 0.8, 1.2));
    let iris = IrisDescription { blades: 5, rotation: 0.4 };
    let camera = |(kind, lens_radius)| {
        let focal_distance = 3.0;
        let description = CameraDescription {
            kind,
            lens_radius,
            iris,
            focal_distance,
            to_world,
            ..CameraDescription::default()
        };
        Camera::try_new(&description, &film(40, 30)).unwrap()
    };
    kinds().into_iter().map(camera).collect()
}

#[test]
fn points_on_a_ray_are_projected_to_its_film_point() {
    for camera in cameras() {
        for (place, lens, t) in [
            (DVec2::new(12.5, 20.0), DVec2::new(0.2, 0.7), 0.4),
            (DVec2::new(31.0, 11.0), DVec2::new(0.9, 0.1), 3.0),
            (DVec2::new(20.0, 29.0), DVec2::new(0.5, 0.4), 50.0),
        ] {
            let CameraRay { ray, weight, .. } = camera.ray(place, lens).unwrap();
            assert_eq!(weight, 1.0);
            let seen = camera.project(ray.at(t), lens).unwrap();
            assert!((seen.film - place).length() < 1e-11, "{camera:?} {} {place}", seen.film);
            assert!((seen.origin - ray.origin).length() < 1e-12);
            let behind = camera.project(ray.at(-t), lens);
            assert!(behind.is_none_or(|seen| (seen.film - place).length() > 1.0), "{behind:?}");
            let along = camera.density(ray.at(t), ray.direction);
            assert!((seen.density / along - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn points_outside_the_picture_are_projected_where_rays_go_through_them() {
    for camera in cameras().into_iter().take(4) {
        let (place, lens) = (DVec2::new(-8.0, 33.0), DVec2::new(0.5, 0.4));
        let ray = camera.ray(place, lens).unwrap().ray;
        assert!((camera.project(ray.at(7.0), lens).unwrap().film - place).length() < 1e-11);
        assert_eq!(camera.project(ray.at(-7.0), lens), None);
    }
}

#[test]
fn density_is_the_film_area_of_a_small_surface_across_the_ray() {
    for camera in cameras() {
        let lens = DVec2::new(0.3, 0.8);
        let ray = camera.ray(DVec2::new(14.0, 21.0), lens).unwrap().ray;
        let (point, step) = (ray.at(2.5), 1e-5);
        let [a, b] = {
            let a = ray.direction.any_orthonormal_vector();
            [a, ray.direction.cross(a)]
        };
        // Central differences err by the square of the step.
        let side = |way: DVec3| {
            let place = |sign: f64| camera.project(point + sign * step * way, lens).unwrap().film;
            (place(1.0) - place(-1.0)) / (2.0 * step)
        };
        let area = side(a).perp_dot(side(b)).abs();
        let density = camera.project(point, lens).unwrap().density;
        assert!((density / area - 1.0).abs() < 1e-7, "{density} {area}");
    }
}

#[test]
fn differentials_span_the_area_of_a_pixel() {
    for camera in cameras() {
        let (film, lens) = (DVec2::new(14.0, 21.0), DVec2::new(0.3, 0.8));
        let CameraRay { ray, differential, .. } = camera.ray_with_differential(film, lens, 0.5).unwrap();
        assert_eq!(camera.ray(film, lens).unwrap().ray, ray);
        let RayDifferential { origin, direction } = differential.unwrap();
        let t = 2.5;
        let [x, y] = [0, 1].map(|i| origin[i] + t * direction[i]);
        let area = x.cross(y).dot(ray.direction).abs();
        // A spacing of half a pixel: a quarter of the area.
        let expected = 0.25 / camera.density(ray.at(t), ray.direction);
        assert!((area / expected - 1.0).abs() < 1e-3, "{area} {expected}");
        let beside = camera.ray(film + 0.5 * DVec2::X, lens).unwrap().ray.at(t);
        assert!((ray.at(t) + x - beside).length() < 0.05 * x.length(), "{x}");
    }
}

#[test]
fn importance_of_a_pinhole_grows_with_the_third_power_of_the_cosine() {
    let kind = CameraKind::Perspective { field_of_view: FRAC_PI_2 };
    let camera = CameraDescription { kind, ..CameraDescription::default() };
    let camera = Camera::try_new(&camera, &film(2, 2)).unwrap();
    // Half angle 45 degrees: a pixel is a unit square of the plane z = 1, and its solid angle cos^3 of that.
    for place in [DVec3::Z, DVec3::new(0.5, -0.3, 1.0), DVec3::new(-1.0, 1.0, 1.0)] {
        let (point, cos) = (4.0 * place, 1.0 / place.length());
        let seen = camera.project(point, DVec2::ZERO).unwrap();
        let per_solid_angle = seen.density * point.length_squared();
        assert!((per_solid_angle * cos.powi(3) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn invalid_cameras_are_refused() {
    let flat = CameraDescription {
        kind: CameraKind::Perspective { field_of_view: std::f64::consts::PI },
        ..CameraDescription::default()
    };
    assert!(Camera::try_new(&flat, &film(4, 4)).is_err());
    let singular = CameraDescription { to_world: DMat4::ZERO, ..CameraDescription::default() };
    assert!(Camera::try_new(&singular, &film(4, 4)).is_err());
    let window =
        CameraDescription { screen_window: Some([1.0, 1.0, 0.0, 1.0]), ..CameraDescription::default() };
    assert!(Camera::try_new(&window, &film(4, 4)).is_err());
    for (field_of_view, projection, is_ok) in [
        (std::f64::consts::TAU, FisheyeProjection::Equidistant, true),
        (std::f64::consts::TAU, FisheyeProjection::Stereographic, false),
        (6.3, FisheyeProjection::Equisolid, false),
        (0.0, FisheyeProjection::Equisolid, false),
    ] {
        let kind = CameraKind::Fisheye { field_of_view, projection };
        let fisheye = CameraDescription { kind, ..CameraDescription::default() };
        assert_eq!(Camera::try_new(&fisheye, &film(4, 4)).is_ok(), is_ok, "{fisheye:?}");
    }
}

/// A camera without transformation.
fn plain(kind: CameraKind, size: [u32; 2]) -> Camera {
    Camera::try_new(&CameraDescription { kind, ..CameraDescription::default() }, &film(size[0], size[1]))
        .unwrap()
}

#[test]
fn pixels_of_an_equal_area_picture_and_of_an_equisolid_disk_have_equal_solid_angles() {
    let sphere = plain(CameraKind::Spherical(SphericalMapping::EqualArea), [64, 64]);
    let half = 1.3_f64;
    let projection = FisheyeProjection::Equisolid;
    let disk = plain(CameraKind::Fisheye { field_of_view: 2.0 * half, projection }, [64, 64]);
    // The sphere has 4 pi, the cone 2 pi (1 - cos), which are 64^2 pixels and the disk of radius 32 pixels.
    let cone = std::f64::consts::TAU * (1.0 - half.cos());
    let expected =
        [(&sphere, 4096.0 / (4.0 * std::f64::consts::PI)), (&disk, std::f64::consts::PI * 1024.0 / cone)];
    for (camera, expected) in expected {
        // Off the creases of the equal-area map.
        for place in [[33.5, 36.25], [20.5, 40.0], [31.0, 7.0], [50.0, 21.0]] {
            let ray = camera.ray(DVec2::from_array(place), DVec2::ZERO).unwrap().ray;
            // By differences of the projection, not by the stated density.
            let (x, y) = (ray.direction.any_orthonormal_vector(), 1e-5);
            let side = |way: DVec3| {
                let film =
                    |sign: f64| camera.project(ray.direction + sign * y * way, DVec2::ZERO).unwrap().film;
                (film(1.0) - film(-1.0)) / (2.0 * y)
            };
            let area = side(x).perp_dot(side(ray.direction.cross(x))).abs();
            assert!((area / expected - 1.0).abs() < 1e-6, "{place:?} {area} {expected}");
        }
    }
}

#[test]
fn spherical_pictures_have_the_orientation_of_pbrt() {
    let long = plain(CameraKind::Spherical(SphericalMapping::Equirectangular), [400, 200]);
    let direction = |x: f64, y: f64| long.ray(DVec2::new(x, y), DVec2::ZERO).unwrap().ray.direction;
    // pbrt: (sin theta cos phi, cos theta, sin theta sin phi) with theta = pi y / height, phi = 2 pi x / width.
    for (place, expected) in [
        ([0.0, 100.0], DVec3::X),
        ([100.0, 100.0], DVec3::Z),
        ([200.0, 100.0], DVec3::NEG_X),
        ([300.0, 100.0], DVec3::NEG_Z),
        ([57.0, 0.0], DVec3::Y),
        ([57.0, 200.0], DVec3::NEG_Y),
    ] {
        assert!((direction(place[0], place[1]) - expected).length() < 1e-14, "{place:?}");
    }
    let square = plain(CameraKind::Spherical(SphericalMapping::EqualArea), [100, 100]);
    // The middle is the pole of the map, which pbrt turns to +y; its x stays x, its y becomes z.
    for (place, expected) in [
        ([50.0, 50.0], DVec3::Y),
        ([100.0, 50.0], DVec3::X),
        ([50.0, 100.0], DVec3::Z),
        ([0.0, 0.0], DVec3::NEG_Y),
        ([100.0, 100.0], DVec3::NEG_Y),
    ] {
        let ray = square.ray(DVec2::from_array(place), DVec2::ZERO).unwrap().ray;
        assert!((ray.direction - expected).length() < 1e-7, "{place:?} {}", ray.direction);
    }
}

#[test]
fn spherical_pictures_continue_beyond_their_borders() {
    for mapping in [SphericalMapping::EqualArea, SphericalMapping::Equirectangular] {
        let camera = plain(CameraKind::Spherical(mapping), [80, 40]);
        let direction = |film| camera.ray(film, DVec2::ZERO).unwrap().ray.direction;
        for place in [[79.5, 13.0], [0.25, 30.0], [33.0, 0.5], [50.0, 39.7], [0.3, 0.2], [79.9, 39.8]] {
            let place = DVec2::from_array(place);
            let points: Vec<DVec2> = camera.film_points(place).collect();
            for &point in &points {
                assert!((direction(point) - direction(place)).length() < 1e-9, "{mapping:?} {place} {point}");
            }
            // Two pictures further it is the same: filters may be wider than small pictures.
            for step in [DVec2::new(160.0, 0.0), DVec2::new(0.0, -80.0)] {
                assert!((direction(place + step) - direction(place)).length() < 1e-9, "{mapping:?} {step}");
            }
            // All points near the picture are found: a step across a border has the ray of one of them.
            for step in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y, DVec2::ONE, DVec2::NEG_ONE] {
                let outside = place + step;
                let inside = camera.project(direction(outside), DVec2::ZERO).unwrap().film;
                let mut copies = camera.film_points(inside);
                assert!(
                    copies.any(|film| (film - outside).length() < 1e-6),
                    "{mapping:?} {outside} {inside}"
                );
            }
        }
    }
}

#[test]
fn fisheyes_have_the_angles_of_their_projections() {
    use FisheyeProjection::*;
    let field_of_view = 3.0_f64;
    // Half way to the rim, an angle a of rim b: a = b / 2, sin(a / 2) = sin(b / 2) / 2, tan(a / 2) = tan(b / 2) / 2.
    let half = 0.5 * (0.5 * field_of_view);
    let expected = [
        (Equidistant, half),
        (Equisolid, 2.0 * (0.5 * half.sin()).asin()),
        (Stereographic, 2.0 * (0.5 * half.tan()).atan()),
    ];
    for (projection, angle) in expected {
        let camera = plain(CameraKind::Fisheye { field_of_view, projection }, [300, 200]);
        // Up and to the right in the picture is up and to the right in the camera's frame.
        let at = |x: f64, y: f64| camera.ray(DVec2::new(150.0 + x, 100.0 - y), DVec2::ZERO);
        assert_eq!(at(0.0, 0.0).unwrap().ray.direction, DVec3::Z);
        for (d, way) in [(at(50.0, 0.0), DVec3::X), (at(0.0, 50.0), DVec3::Y)] {
            let expected = angle.sin() * way + angle.cos() * DVec3::Z;
            assert!((d.unwrap().ray.direction - expected).length() < 1e-14, "{projection:?}");
        }
        let rim = at(0.0, -99.999_999).unwrap().ray.direction;
        assert!((rim.z - (0.5 * field_of_view).cos()).abs() < 1e-6);
        assert!(at(0.0, 100.001).is_none() && at(120.0, 0.0).is_none());
        let beyond = DVec3::new(1.6_f64.sin(), 0.0, 1.6_f64.cos());
        assert_eq!(camera.project(beyond, DVec2::ZERO), None);
    }
}

#[test]
fn points_of_an_iris_are_uniform_in_its_polygon() {
    let iris = IrisDescription { blades: 6, rotation: 0.3 };
    let aperture = Aperture::new(0.5, iris);
    let side = 48;
    let (mut counts, mut farthest) = ([0_u64; 6 * 8], 0.0_f64);
    for i in 0..side * side * 40 {
        let xi = glanz_sampling::hash::combine(5, i);
        let xi = DVec2::new(
            glanz_sampling::hash::unit_f64(xi),
            glanz_sampling::hash::unit_f64(glanz_sampling::hash::combine(6, i)),
        );
        let p = aperture.point(xi);
        farthest = farthest.max(p.length());
        // By sector and by rings of equal area: the distance to the side of a sector, relative to that of the middle, squared.
        let angle = (p.to_angle() - 0.3).rem_euclid(std::f64::consts::TAU);
        let sector = ((angle / std::f64::consts::FRAC_PI_3) as usize).min(5);
        let middle = DVec2::from_angle(0.3 + std::f64::consts::FRAC_PI_3 * (sector as f64 + 0.5));
        let share = p.dot(middle) / (0.5 * (std::f64::consts::PI / 6.0).cos());
        assert!(share <= 1.0 + 1e-12, "outside: {p}");
        counts[sector * 8 + ((share * share * 8.0) as usize).min(7)] += 1;
    }
    assert!(farthest > 0.495);
    let expected = vec![(side * side * 40) as f64 / 48.0; 48];
    let test = glanz_sampling::statistics::chi_square(&counts, &expected);
    assert!(test.p_value > 1e-4, "{test:?}");
}
