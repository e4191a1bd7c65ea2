//! The initial camera of the page.

use glanz_math::{Bounds3, DMat4, DVec2, DVec3, Ray};
use glanz_scene::camera::Screen;
use glanz_scene::description::{CameraDescription, CameraKind, FilmDescription};
use glanz_scene::{Description, Scene};

use super::head::ModelCamera;

/// Field of view where the scene has none, radians.
const FIELD_OF_VIEW: f64 = 0.6;

/// Field of view that stands in for all directions or a fish-eye, radians.
const WIDE_FIELD_OF_VIEW: f64 = 1.6;

/// Number of rays across a lens, along each axis.
const LENS_GRID: u32 = 16;

/// The scene's camera; where the file has none, one that sees everything from the front, the right and above.
pub(super) fn camera(description: &Description, scene: &Scene) -> ModelCamera {
    let bounds = scene.bounds();
    if !has_camera(description) && !bounds.is_empty() {
        return overview(bounds);
    }
    let of_scene = of_scene(&description.camera, &description.film, scene);
    let ray = Ray::new(of_scene.position.into(), of_scene.forward.into());
    let distance = scene.intersect(&ray, f64::INFINITY).map(|at| at.t).or_else(|| {
        let to_middle = (bounds.center() - ray.origin).dot(ray.direction);
        (!bounds.is_empty() && to_middle > 0.0).then_some(to_middle)
    });
    let distance = distance.filter(|distance| *distance > 0.0 && distance.is_finite()).unwrap_or(1.0);
    ModelCamera { distance, ..of_scene }
}

/// Whether the scene has a camera: from its file, or placed by code.
fn has_camera(description: &Description) -> bool {
    description.camera.location.is_some() || description.camera.to_world != DMat4::IDENTITY
}

/// Aspect ratio of the scene's picture; 1 for an overview, which is fitted to the shorter side of the page.
pub(super) fn aspect(description: &Description) -> f64 {
    if !has_camera(description) {
        return 1.0;
    }
    let [x0, x1, y0, y1] = window(&description.camera, &description.film);
    (x1 - x0).abs() / (y1 - y0).abs()
}

/// Sides of the screen.
fn window(camera: &CameraDescription, film: &FilmDescription) -> [f64; 4] {
    let [width, height] = film.resolution.map(f64::from);
    let aspect = camera.aspect.unwrap_or(width / height);
    camera.screen_window.unwrap_or_else(|| Screen::default_window(aspect))
}

fn of_scene(camera: &CameraDescription, film: &FilmDescription, scene: &Scene) -> ModelCamera {
    let [x0, x1, y0, y1] = window(camera, film);
    let (across, along) = ((x1 - x0).abs(), (y1 - y0).abs());
    let axis = |axis: DVec3| camera.to_world.transform_vector3(axis);
    let forward = axis(DVec3::Z).normalize_or(DVec3::Z);
    let up = axis(DVec3::Y).reject_from_normalized(forward).normalize_or(forward.any_orthonormal_vector());
    // Its orientation stays that of the camera, so that mirrored worlds look as the file describes them.
    let side = forward.cross(up);
    let right = if side.dot(axis(DVec3::X)) < 0.0 { -side } else { side };
    let half = 0.5 * across.min(along);
    let (kind, field_of_view) = match &camera.kind {
        &CameraKind::Perspective { field_of_view } => {
            ("perspective", 2.0 * (half * (0.5 * field_of_view).tan()).atan())
        }
        CameraKind::Orthographic => ("orthographic", FIELD_OF_VIEW),
        CameraKind::Spherical(_) | CameraKind::Fisheye { .. } => ("perspective", WIDE_FIELD_OF_VIEW),
        CameraKind::Realistic(_) => ("perspective", angle_of_lens(film, scene).unwrap_or(FIELD_OF_VIEW)),
    };
    let unit = if across < along { axis(DVec3::X).length() } else { axis(DVec3::Y).length() };
    ModelCamera {
        kind,
        position: camera.to_world.transform_point3(DVec3::ZERO).to_array(),
        right: right.to_array(),
        up: up.to_array(),
        forward: forward.to_array(),
        field_of_view,
        height: 2.0 * half * unit,
        distance: 1.0,
    }
}

/// The angle over the shorter side of the picture, by the middle of all rays from the middle of its border; `None` if the lens stops all.
fn angle_of_lens(film: &FilmDescription, scene: &Scene) -> Option<f64> {
    let [width, height] = film.resolution.map(f64::from);
    let border = if width < height { DVec2::new(0.0, 0.5 * height) } else { DVec2::new(0.5 * width, 0.0) };
    let camera = scene.camera();
    let towards = |film: DVec2| {
        let grid = (0..LENS_GRID * LENS_GRID)
            .map(|i| DVec2::new(f64::from(i % LENS_GRID) + 0.5, f64::from(i / LENS_GRID) + 0.5));
        let rays = grid.filter_map(|point| camera.ray(film, point / f64::from(LENS_GRID)));
        rays.map(|camera| camera.weight * camera.ray.direction).sum::<DVec3>().try_normalize()
    };
    Some(2.0 * towards(border)?.angle_between(towards(0.5 * DVec2::new(width, height))?))
}

/// A note for the page on a camera that it does not have.
pub(super) fn note(camera: &CameraDescription) -> Option<String> {
    let kind = match camera.kind {
        CameraKind::Perspective { .. } | CameraKind::Orthographic => return None,
        CameraKind::Spherical(_) => "spherical",
        CameraKind::Fisheye { .. } => "fish-eye",
        CameraKind::Realistic(_) => "realistic",
    };
    Some(format!("a perspective camera stands in for the {kind} camera of the scene"))
}

fn overview(bounds: Bounds3) -> ModelCamera {
    let forward = DVec3::new(-1.0, 2.0, -1.0).normalize();
    let up = DVec3::Z.reject_from_normalized(forward).normalize();
    let radius = (0.5 * bounds.diagonal().length()).max(f64::MIN_POSITIVE);
    let distance = radius / (0.5 * FIELD_OF_VIEW).sin();
    ModelCamera {
        kind: "perspective",
        position: (bounds.center() - forward * distance).to_array(),
        right: forward.cross(up).to_array(),
        up: up.to_array(),
        forward: forward.to_array(),
        field_of_view: FIELD_OF_VIEW,
        height: 2.0 * radius,
        distance,
    }
}

/// The axis, with its sign, nearest to the camera's up.
pub(super) fn up(camera: &ModelCamera) -> [f64; 3] {
    let up = DVec3::from(camera.up);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    // Reversed, so that z wins among equals: x and y are rarer.
    let nearest =
        axes.rev().fold(DVec3::Z, |best, axis| if axis.dot(up) > best.dot(up) { axis } else { best });
    nearest.to_array()
}
