//! The camera.

use glanz_math::{DMat4, DVec3};

use super::Location;

/// A camera, which looks along +z with +x to the right of its picture and +y up; spherical ones see all directions.
///
/// Window, aspect, lens and focal distance are those of [`CameraKind::Perspective`] and [`CameraKind::Orthographic`]; [`CameraKind::Fisheye`] has
/// window and aspect.
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
    /// The shape of the aperture.
    pub iris: IrisDescription,
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
            iris: IrisDescription::default(),
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

/// Shape of an aperture: by default a disk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IrisDescription {
    /// Number of corners of a regular polygon in the disk; fewer than 3 for the whole disk.
    pub blades: u32,
    /// Angle by which its first corner is turned from +x towards +y, radians.
    pub rotation: f64,
}

/// The projections.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraKind {
    /// Central projection.
    Perspective {
        /// Full angle over the shorter side of the screen, radians, in (0, pi).
        field_of_view: f64,
    },
    /// Parallel projection.
    Orthographic,
    /// All directions.
    Spherical(SphericalMapping),
    /// A disk with a wide field of view; the picture is black around it.
    Fisheye {
        /// Full angle over the diameter of the disk, and the shorter side of the screen, radians, in (0, 2 pi].
        field_of_view: f64,
        /// Distance from the middle by angle.
        projection: FisheyeProjection,
    },
    /// A system of lenses.
    Realistic(Box<LensDescription>),
}

/// Maps of all directions to a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SphericalMapping {
    /// A square without distortion of areas (@clarberg2008).
    EqualArea,
    /// Azimuth along x, angle from +y along y.
    Equirectangular,
}

/// Distance from the middle of a fish-eye picture by the angle to the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FisheyeProjection {
    /// In proportion to the angle.
    Equidistant,
    /// In proportion to the sine of half the angle: areas of the picture are solid angles.
    Equisolid,
    /// In proportion to the tangent of half the angle: shapes keep their angles.
    Stereographic,
}

/// A system of lenses in front of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct LensDescription {
    /// Its surfaces and stops, from the scene to the film.
    pub interfaces: Vec<LensInterfaceDescription>,
    /// Largest diameter of the stops, metres.
    pub aperture_diameter: f64,
    /// Distance from the film to the plane in focus, metres.
    pub focus_distance: f64,
    /// Shape of the openings of the stops.
    pub stop: StopShape,
    /// Whether a pixel is the irradiance of the film over (d / z)^2, for the exit pupil of diameter d at the distance z from the middle of the
    /// film, as in pbrt's version 3: radiance 1 is pi / 4 there; otherwise it is the irradiance.
    pub relative_weights: bool,
}

/// A spherical surface of a lens, or a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensInterfaceDescription {
    /// Radius of its curvature, metres, positive if its middle is on the side of the film; 0 for a stop, which is plane.
    pub curvature_radius: f64,
    /// Distance to the next interface, metres; that of the last one follows from the focus.
    pub thickness: f64,
    /// Refractive index on the side of the film; 0 counts as 1.
    pub eta: f64,
    /// Diameter of its opening, metres.
    pub diameter: f64,
}

/// Shapes of the opening of a stop. All let as much light pass as the disk: they are the brighter inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopShape {
    /// The disk, or the regular polygon in it.
    Iris(IrisDescription),
    /// A disk whose transmittance falls off as exp(-r^2) - exp(-1).
    Gaussian,
    /// A square with half the width of the disk.
    Square,
    /// A regular pentagon, 0.8 times as large as the disk, with a corner towards -y.
    Pentagon,
    /// A star with five points on the border of the disk.
    Star,
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
