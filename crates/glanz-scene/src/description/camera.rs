//! The camera.

use glanz_math::{DMat4, DVec3};

use super::Location;

/// A camera, which looks along +z with +x to the right of its picture and +y up.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// The projection.
    pub kind: CameraKind,
    /// Transformation from camera to world space.
    pub to_world: DMat4,
    /// Smallest and largest x, then y, of the screen; by default the shorter side spans [-1, 1].
    pub screen_window: Option<[f64; 4]>,
    /// Width over height of the screen, if not that of the film.
    pub aspect: Option<f64>,
    /// Radius of the aperture, metres; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus, metres.
    pub focal_distance: f64,
    /// Its place in the input.
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

impl CameraDescription {
    /// A pinhole with a field of view of 90 degrees at `eye` that looks at `target`, with `up` upwards in its picture.
    ///
    /// A view without direction, where `eye` is `target` or `up` is parallel to the view, is an error when the scene is resolved.
    #[must_use]
    pub fn look_at(eye: impl Into<DVec3>, target: impl Into<DVec3>, up: impl Into<DVec3>) -> Self {
        let to_world = look_at(eye.into(), target.into(), up.into()).unwrap_or(DMat4::NAN);
        Self { to_world, ..Self::default() }
    }

    /// The camera as a perspective one with this full angle over the shorter side of its screen, radians, in (0, pi).
    #[must_use]
    pub fn with_field_of_view(self, field_of_view: f64) -> Self {
        Self { kind: CameraKind::Perspective { field_of_view }, ..self }
    }
}

/// Transformation from the frame of a camera at `eye` that looks at `target` to the world: x to the right of the picture, y (towards `up`) up, z forward.
///
/// Like pbrt's, the frame is left-handed in a right-handed world. `None` if `eye` is `target` or `up` is parallel to the view.
#[must_use]
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DMat4> {
    let forward = (target - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    Some(DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_puts_the_target_on_the_axis_and_up_upward() {
        // Looking along -z with y up, pbrt's frame (x = up cross forward) has -x to the right.
        let to_world = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y).unwrap();
        assert_eq!(to_world.transform_point3(DVec3::new(0.0, 0.0, 5.0)), DVec3::ZERO);
        assert_eq!(to_world.transform_vector3(DVec3::Y), DVec3::Y);
        assert_eq!(to_world.transform_vector3(DVec3::X), DVec3::NEG_X);
    }

    #[test]
    fn look_at_refuses_views_without_direction() {
        assert!(look_at(DVec3::ONE, DVec3::ONE, DVec3::Y).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::ZERO).is_none());
        assert!(!CameraDescription::look_at(DVec3::ONE, DVec3::ONE, DVec3::Y).to_world.is_finite());
    }
}
