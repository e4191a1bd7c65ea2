//! Cameras: from a place on the film to a ray.

mod orthographic;
mod perspective;
mod screen;

use glanz_math::{DVec2, DVec3, Ray, Transform};
use glanz_sampling::warp;

use crate::description::{CameraDescription, CameraKind, FilmDescription};
use crate::error::{SceneError, SceneErrorKind};

pub use orthographic::Orthographic;
pub use perspective::Perspective;
pub use screen::Screen;

/// A camera with its place in the world; the rays it sends have unit directions.
#[derive(Clone, Debug)]
pub struct Camera {
    projection: Projection,
    screen: Screen,
    lens_radius: f64,
    focal_distance: f64,
    to_world: Transform,
}

/// The projections.
#[derive(Clone, Copy, Debug)]
enum Projection {
    Perspective(Perspective),
    Orthographic(Orthographic),
}

impl Camera {
    /// Checks a description against the film it exposes.
    ///
    /// # Errors
    /// [`SceneError`] if the matrix is singular, an angle or a distance out of range, the screen empty.
    pub fn try_new(camera: &CameraDescription, film: &FilmDescription) -> Result<Self, SceneError> {
        let at = |kind| SceneError { location: camera.location, kind };
        let range =
            |what, value: f64, range| at(SceneErrorKind::Range { what, value: value.to_string(), range });
        let to_world = Transform::try_from_matrix(camera.to_world)
            .map_err(|source| at(SceneErrorKind::Transform { what: "camera", source }))?;
        let [width, height] = film.resolution.map(f64::from);
        if !(width >= 1.0 && height >= 1.0) {
            return Err(range("picture size", width.min(height), "at least 1 x 1"));
        }
        let aspect = camera.aspect.unwrap_or(width / height);
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(range("aspect ratio", aspect, "positive"));
        }
        if !(camera.lens_radius >= 0.0 && camera.lens_radius.is_finite()) {
            return Err(range("lens radius", camera.lens_radius, "0 or positive"));
        }
        if camera.lens_radius > 0.0 && !(camera.focal_distance > 0.0 && camera.focal_distance.is_finite()) {
            return Err(range("focal distance", camera.focal_distance, "positive"));
        }
        let window = camera.screen_window.unwrap_or_else(|| Screen::default_window(aspect));
        let screen = Screen::try_new(window, [width, height])
            .ok_or_else(|| range("screen window", window[1] - window[0], "finite and not empty"))?;
        let projection = match camera.kind {
            CameraKind::Perspective { field_of_view } => {
                Projection::Perspective(Perspective::try_new(field_of_view).ok_or_else(|| {
                    range("field of view", field_of_view.to_degrees(), "between 0 and 180 degrees")
                })?)
            }
            CameraKind::Orthographic => Projection::Orthographic(Orthographic),
        };
        Ok(Self {
            projection,
            screen,
            lens_radius: camera.lens_radius,
            focal_distance: camera.focal_distance,
            to_world,
        })
    }

    /// The ray through `film` (pixels from the top left of the full picture, y down), with unit direction.
    ///
    /// `lens`: two numbers uniform in [0, 1) that choose the place on the aperture; without meaning for a pinhole.
    #[must_use]
    pub fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        let on_screen = self.screen.from_film(film);
        let mut ray = match self.projection {
            Projection::Perspective(p) => p.ray(on_screen),
            Projection::Orthographic(o) => o.ray(on_screen),
        };
        if self.lens_radius > 0.0 {
            // All rays of one film point meet in the plane of focus.
            let focus = ray.at(self.focal_distance / ray.direction.z);
            let shift = self.lens_radius * warp::concentric_disk(lens);
            ray.origin += DVec3::new(shift.x, shift.y, 0.0);
            ray.direction = focus - ray.origin;
        }
        let world = self.to_world.ray(&ray);
        Ray::new(world.origin, world.direction.normalize())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glanz_math::DMat4;

    use super::*;

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
            let d = camera.ray(middle + edge, DVec2::ZERO).direction;
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
        let ray = camera.ray(DVec2::new(300.0, 0.0), DVec2::ZERO);
        assert_eq!(ray.direction, DVec3::Z);
        assert!((ray.origin - DVec3::new(3.0, 1.0, 7.0)).length() < 1e-14);
    }

    #[test]
    fn rays_of_one_film_point_meet_in_the_plane_of_focus() {
        let camera =
            CameraDescription { lens_radius: 0.5, focal_distance: 4.0, ..CameraDescription::default() };
        let camera = Camera::try_new(&camera, &film(64, 64)).unwrap();
        let at_focus = |lens| {
            let ray = camera.ray(DVec2::new(10.0, 20.0), lens);
            ray.at((4.0 - ray.origin.z) / ray.direction.z)
        };
        let a = at_focus(DVec2::new(0.1, 0.9));
        let b = at_focus(DVec2::new(0.8, 0.3));
        assert!((a - b).length() < 1e-14);
    }

    #[test]
    fn impossible_cameras_are_refused() {
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
    }
}
