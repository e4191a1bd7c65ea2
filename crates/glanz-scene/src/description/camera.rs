//! The camera.

use glanz_math::DMat4;

use super::Location;

/// Projection and place of the camera, which looks along +z with +x to the right of its picture and +y up.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// The projection.
    pub kind: CameraKind,
    /// From camera to world space.
    pub to_world: DMat4,
    /// Smallest and largest x, then y, of the screen; by default the shorter side spans [-1, 1].
    pub screen_window: Option<[f64; 4]>,
    /// Width over height of the screen, if not that of the film.
    pub aspect: Option<f64>,
    /// Radius of the aperture, metres; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus, metres.
    pub focal_distance: f64,
    /// Where it was said.
    pub location: Option<Location>,
}

impl Default for CameraDescription {
    fn default() -> Self {
        Self {
            kind: CameraKind::Perspective { field_of_view: std::f64::consts::FRAC_PI_2 },
            to_world: DMat4::IDENTITY,
            screen_window: None,
            aspect: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            location: None,
        }
    }
}

/// The projections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraKind {
    /// Central projection.
    Perspective {
        /// Full angle over the shorter side of the screen, radians, in (0, pi).
        field_of_view: f64,
    },
    /// Parallel projection.
    Orthographic,
}
