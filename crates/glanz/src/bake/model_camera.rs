//! Conversion of the camera of a scene to that of a model.

use glanz_formats::glb::{GlbCamera, Projection};
use glanz_math::{Bounds3, DMat3, DVec2, DVec3, glam::DQuat};
use glanz_scene::camera::Screen;
use glanz_scene::description::{CameraDescription, CameraKind, FilmDescription};

use crate::axes::Axes;

/// Near plane, relative to the diagonal of the scene: close enough for almost all views, and far enough for precise depth buffers.
const NEAR: f64 = 0.002;

/// Sine of an angle, and share of a length, below which they count as 0.
const SLACK: f64 = 1e-6;

/// The camera in the axes of the model; `None` if its picture is off-centre, sheared or mirrored, or not that of a perspective or orthographic
/// camera, which models cannot represent.
///
/// The aperture is ignored.
pub(super) fn camera(
    camera: &CameraDescription,
    film: &FilmDescription,
    axes: Axes,
    bounds: &Bounds3,
) -> Option<GlbCamera> {
    let [width, height] = film.resolution.map(f64::from);
    let window = camera.screen_window;
    let [x0, x1, y0, y1] =
        window.unwrap_or_else(|| Screen::default_window(camera.aspect.unwrap_or(width / height)));
    let half = 0.5 * DVec2::new(x1 - x0, y1 - y0);
    let middle = 0.5 * DVec2::new(x0 + x1, y0 + y1);
    if !(half.min_element() > 0.0 && middle.abs().cmple(SLACK * half).all()) {
        return None;
    }

    let matrix = axes.of(DMat3::from_mat4(camera.to_world));
    let lengths = DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length());
    // Cameras of models look along -z.
    let turned =
        DMat3::from_cols(matrix.x_axis / lengths.x, matrix.y_axis / lengths.y, -matrix.z_axis / lengths.z);
    let off = turned.transpose() * turned - DMat3::IDENTITY;
    let is_rotation = off.to_cols_array().iter().all(|x| x.abs() < SLACK) && turned.determinant() > 0.0;
    if !is_rotation {
        return None;
    }
    let origin = camera.to_world.w_axis.truncate();
    let forward = camera.to_world.z_axis.truncate() / lengths.z;
    let depths = bounds.corners().map(|corner| (corner - origin).dot(forward));
    let [nearest, farthest] =
        depths.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], &d| [low.min(d), high.max(d)]);
    let smallest = NEAR * bounds.diagonal().length();
    let range = [(0.5 * nearest).max(smallest), 2.0 * farthest + smallest];
    let projection = match &camera.kind {
        &CameraKind::Perspective { field_of_view } => {
            let size = half * (0.5 * field_of_view).tan() * lengths.truncate() / lengths.z;
            Projection::Perspective {
                field_of_view: (2.0 * size.y.atan()) as f32,
                aspect: (size.x / size.y) as f32,
            }
        }
        CameraKind::Orthographic => {
            Projection::Orthographic((half * lengths.truncate()).as_vec2().to_array())
        }
        CameraKind::Spherical(_) | CameraKind::Fisheye { .. } | CameraKind::Realistic(_) => return None,
    };
    Some(GlbCamera {
        name: "camera".to_owned(),
        projection,
        range: range.map(|x| x as f32),
        position: axes.of_point(origin).as_vec3().to_array(),
        rotation: DQuat::from_mat3(&turned).normalize().as_quat().to_array(),
    })
}

#[cfg(test)]
mod tests {
    use glanz_math::{DMat4, Ray};
    use glanz_scene::description::SphericalMapping;

    use super::*;

    fn bounds() -> Bounds3 {
        Bounds3::new(DVec3::splat(-1.0), DVec3::splat(1.0))
    }

    fn film() -> FilmDescription {
        FilmDescription { resolution: [400, 300], ..FilmDescription::default() }
    }

    fn described(to_world: DMat4, kind: CameraKind) -> CameraDescription {
        CameraDescription { to_world, kind, ..CameraDescription::default() }
    }

    /// Right, up and towards the camera, by the rules of the format.
    fn directions(camera: &GlbCamera) -> [DVec3; 3] {
        let [x, y, z, w] = camera.rotation.map(f64::from);
        let turn = DQuat::from_xyzw(x, y, z, w);
        [turn * DVec3::X, turn * DVec3::Y, turn * DVec3::Z]
    }

    /// Where the ray that the format gives a point of the picture goes, of the scene's camera and of the model's: origin and direction
    /// in the axes of the model. `at`: x and y in [-1, 1], y up.
    fn rays(described: &CameraDescription, axes: Axes, at: DVec2) -> [[DVec3; 2]; 2] {
        let film = film();
        let own = glanz_scene::Camera::try_new(described, &film).unwrap();
        let [width, height] = film.resolution.map(f64::from);
        let on_film = DVec2::new(0.5 * width * (1.0 + at.x), 0.5 * height * (1.0 - at.y));
        let Ray { origin, direction, .. } = own.ray(on_film, DVec2::ZERO).unwrap().ray;
        let camera = camera(described, &film, axes, &bounds()).unwrap();
        let [right, up, back] = directions(&camera);
        let position = glanz_math::glam::Vec3::from_array(camera.position).as_dvec3();
        let found = match camera.projection {
            Projection::Perspective { field_of_view, aspect } => {
                let y = (0.5 * f64::from(field_of_view)).tan();
                [position, (at.x * y * f64::from(aspect) * right + at.y * y * up - back).normalize()]
            }
            Projection::Orthographic([x, y]) => {
                [position + at.x * f64::from(x) * right + at.y * f64::from(y) * up, -back]
            }
        };
        [[axes.of_point(origin), axes.of_point(direction).normalize()], found]
    }

    #[test]
    fn rays_of_the_camera_of_the_model_are_those_of_the_scene() {
        let eye = DVec3::new(1.0, -4.0, 2.0);
        let (z, x) = ((DVec3::Z * 0.5 - eye).normalize(), DVec3::new(4.0, 1.0, 0.0).normalize());
        let y = x.cross(z).normalize();
        let columns = |x: DVec3, y: DVec3, z: DVec3| {
            DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), eye.extend(1.0))
        };
        let x = z.cross(y);
        // Of a right-handed world, of a left-handed one, and of one in centimetres and stretched.
        let places = [columns(x, y, z), columns(-x, y, z), columns(0.01 * x, 0.02 * y, 0.01 * z)];
        let kinds = [CameraKind::Perspective { field_of_view: 0.9 }, CameraKind::Orthographic];
        for (place, kind) in places.into_iter().flat_map(|place| kinds.clone().map(|kind| (place, kind))) {
            let described = described(place, kind.clone());
            let axes = Axes::of_camera(&place);
            for at in [DVec2::ZERO, DVec2::new(1.0, 0.3), DVec2::new(-0.7, -1.0)] {
                let [expected, found] = rays(&described, axes, at);
                for (expected, found) in expected.into_iter().zip(found) {
                    assert!(expected.distance(found) < 1e-5, "{kind:?} {expected} {found}");
                }
            }
        }
    }

    #[test]
    fn all_of_the_scene_is_in_range() {
        let away = DMat4::from_translation(DVec3::Z * -101.0);
        let described = described(away, CameraKind::Orthographic);
        let camera = camera(&described, &film(), Axes::of_camera(&away), &bounds()).unwrap();
        let [near, far] = camera.range;
        assert!(near > 10.0 && near < 100.0 && far > 102.0, "{near} {far}");
    }

    #[test]
    fn cameras_that_models_do_not_have_are_left_out() {
        let kind = CameraKind::Perspective { field_of_view: 1.0 };
        let none = |described: &CameraDescription| {
            camera(described, &film(), Axes::of_camera(&described.to_world), &bounds()).is_none()
        };
        let all = CameraKind::Spherical(SphericalMapping::EqualArea);
        assert!(none(&described(DMat4::IDENTITY, all)));
        let mut shifted = described(DMat4::IDENTITY, kind.clone());
        assert!(!none(&shifted));
        shifted.screen_window = Some([-1.0, 0.9, -1.0, 1.0]);
        assert!(none(&shifted));
        shifted.screen_window = Some([1.0, -1.0, -1.0, 1.0]);
        assert!(none(&shifted));
        let slant =
            DMat4::from_cols_array(&[1., 0., 0., 0., 0.2, 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
        assert!(none(&described(slant, kind)));
    }
}
