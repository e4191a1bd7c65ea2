//! The camera of a page.

use glanz_math::{DMat4, DVec3};
use glanz_scene::camera::Screen;
use glanz_scene::description::{CameraDescription, CameraKind};
use serde::{Deserialize, Serialize};

/// Tolerance of the camera's axes against orthonormality: dot products, and squared lengths minus 1. They are computed in double
/// precision by the page; larger deviations are not rounding errors.
const ORTHONORMAL: f64 = 1e-6;

/// The camera of a page: a pinhole, or parallel rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ViewCamera {
    /// The projection.
    pub kind: ViewCameraKind,
    /// World space, metres.
    pub position: [f64; 3],
    /// To the right in the picture; orthonormal with the next two, in either orientation.
    pub right: [f64; 3],
    /// Upwards in the picture.
    pub up: [f64; 3],
    /// Into the picture.
    pub forward: [f64; 3],
    /// Angle over the shorter side, radians in (0, pi); of a perspective camera.
    #[serde(default)]
    pub field_of_view: Option<f64>,
    /// Metres over the shorter side; of an orthographic camera.
    #[serde(default)]
    pub height: Option<f64>,
    /// Distance of the point it looks at, metres; without effect on the picture.
    #[serde(default)]
    pub distance: Option<f64>,
}

/// The projections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ViewCameraKind {
    /// Central projection.
    Perspective,
    /// Parallel projection.
    Orthographic,
}

/// Errors of a page's camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewCameraError {
    /// Axes that are not orthonormal.
    #[error("the axes of the camera must be orthonormal")]
    Axes,
    /// A perspective camera without a field of view in (0, pi).
    #[error("the field of view must be between 0 and pi")]
    FieldOfView,
    /// An orthographic camera without a positive height.
    #[error("the height of the picture must be positive")]
    Height,
}

impl ViewCamera {
    /// The camera as a description for `glanz-scene`, for an image of `size` pixels.
    ///
    /// # Errors
    /// [`ViewCameraError`].
    pub fn describe(&self, size: [u32; 2]) -> Result<CameraDescription, ViewCameraError> {
        let [position, right, up, forward] =
            [self.position, self.right, self.up, self.forward].map(DVec3::from_array);
        let lengths = [right, up, forward].map(|axis| axis.length_squared() - 1.0);
        let angles = [right.dot(up), up.dot(forward), forward.dot(right)];
        // In this form the test also fails for NaN.
        if !lengths.into_iter().chain(angles).all(|off| off.abs() <= ORTHONORMAL) || !position.is_finite() {
            return Err(ViewCameraError::Axes);
        }
        let column = |axis: DVec3| axis.extend(0.0);
        let to_world = DMat4::from_cols(column(right), column(up), column(forward), position.extend(1.0));
        let camera = CameraDescription { to_world, ..CameraDescription::default() };
        match self.kind {
            ViewCameraKind::Perspective => {
                let angle = self.field_of_view.filter(|angle| *angle > 0.0 && *angle < std::f64::consts::PI);
                let field_of_view = angle.ok_or(ViewCameraError::FieldOfView)?;
                Ok(CameraDescription { kind: CameraKind::Perspective { field_of_view }, ..camera })
            }
            ViewCameraKind::Orthographic => {
                let height = self.height.filter(|height| *height > 0.0 && height.is_finite());
                let half = 0.5 * height.ok_or(ViewCameraError::Height)?;
                let [width, height] = size.map(f64::from);
                let window = Screen::default_window(width / height).map(|border| border * half);
                let kind = CameraKind::Orthographic;
                Ok(CameraDescription { kind, screen_window: Some(window), ..camera })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec2;
    use glanz_scene::Camera;
    use glanz_scene::description::FilmDescription;

    use super::*;

    fn camera(kind: ViewCameraKind) -> ViewCamera {
        ViewCamera {
            kind,
            position: [1.0, 2.0, 3.0],
            right: [0.0, 1.0, 0.0],
            up: [0.0, 0.0, 1.0],
            forward: [-1.0, 0.0, 0.0],
            field_of_view: Some(std::f64::consts::FRAC_PI_2),
            height: Some(4.0),
            distance: None,
        }
    }

    fn built(camera: &ViewCamera, size: [u32; 2]) -> Camera {
        let film = FilmDescription { resolution: size, ..FilmDescription::default() };
        Camera::try_new(&camera.describe(size).unwrap(), &film).unwrap()
    }

    #[test]
    fn perspective_angle_spans_the_shorter_side() {
        // 40 x 20 pixels, 90 degrees over 20: the middle of the right side is at tan = 2, that of the upper side at tan = 1.
        let camera = built(&camera(ViewCameraKind::Perspective), [40, 20]);
        for (film, direction) in [
            ([40.0, 10.0], DVec3::new(-1.0, 2.0, 0.0)),
            ([20.0, 0.0], DVec3::new(-1.0, 0.0, 1.0)),
            ([20.0, 10.0], DVec3::NEG_X),
        ] {
            let ray = camera.ray(DVec2::from_array(film), DVec2::ZERO).unwrap().ray;
            assert!((ray.direction - direction.normalize()).length() < 1e-14, "{}", ray.direction);
            assert_eq!(ray.origin, DVec3::new(1.0, 2.0, 3.0));
        }
    }

    #[test]
    fn orthographic_height_spans_the_shorter_side() {
        // 20 x 40 pixels, 4 m over 20: the corner at the upper left is 2 m to the left and 4 m up.
        let camera = built(&camera(ViewCameraKind::Orthographic), [20, 40]);
        let ray = camera.ray(DVec2::ZERO, DVec2::ZERO).unwrap().ray;
        assert_eq!(ray.direction, DVec3::NEG_X);
        assert!((ray.origin - DVec3::new(1.0, 0.0, 7.0)).length() < 1e-14, "{}", ray.origin);
    }

    #[test]
    fn mirrored_worlds_stay_mirrored() {
        let mirrored = ViewCamera { right: [0.0, -1.0, 0.0], ..camera(ViewCameraKind::Perspective) };
        let ray = built(&mirrored, [40, 20]).ray(DVec2::new(40.0, 10.0), DVec2::ZERO).unwrap().ray;
        assert!(ray.direction.y < -0.8);
    }

    #[test]
    fn cameras_that_cannot_be_are_refused() {
        let fine = camera(ViewCameraKind::Perspective);
        let flat = camera(ViewCameraKind::Orthographic);
        for (camera, error) in [
            (ViewCamera { up: [0.0, 0.1, 1.0], ..fine }, ViewCameraError::Axes),
            (ViewCamera { up: [0.0, 0.0, 2.0], ..fine }, ViewCameraError::Axes),
            (ViewCamera { up: [0.0; 3], ..fine }, ViewCameraError::Axes),
            (ViewCamera { position: [f64::INFINITY; 3], ..fine }, ViewCameraError::Axes),
            (ViewCamera { field_of_view: None, ..fine }, ViewCameraError::FieldOfView),
            (ViewCamera { field_of_view: Some(4.0), ..fine }, ViewCameraError::FieldOfView),
            (ViewCamera { height: Some(0.0), ..flat }, ViewCameraError::Height),
            (ViewCamera { height: None, ..flat }, ViewCameraError::Height),
        ] {
            assert_eq!(camera.describe([4, 4]).unwrap_err(), error);
        }
    }
}
