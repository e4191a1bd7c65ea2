//! Cameras, which map a point of the film to a ray.

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

/// A camera in the world; its rays have unit directions.
#[derive(Clone, Debug)]
pub struct Camera {
    projection: CameraProjection,
    screen: Screen,
    lens_radius: f64,
    focal_distance: f64,
    to_world: Transform,
    /// Volume in the camera's frame over that in the world.
    inverse_volume: f64,
}

/// A point of the scene projected on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmProjection {
    /// Position on the film, pixels; it may lie outside the picture.
    pub film: DVec2,
    /// Origin of the ray through the point, world space, metres.
    pub origin: DVec3,
    /// Density of rays at the point: see [`Camera::density`].
    pub density: f64,
}

/// The projections.
#[derive(Clone, Copy, Debug)]
enum CameraProjection {
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
                CameraProjection::Perspective(Perspective::try_new(field_of_view).ok_or_else(|| {
                    range("field of view", field_of_view.to_degrees(), "between 0 and 180 degrees")
                })?)
            }
            CameraKind::Orthographic => CameraProjection::Orthographic(Orthographic),
        };
        Ok(Self {
            projection,
            screen,
            lens_radius: camera.lens_radius,
            focal_distance: camera.focal_distance,
            to_world,
            inverse_volume: to_world.inverse().forward().matrix3.determinant().abs(),
        })
    }

    /// The ray through `film` (pixels from the top left of the full picture, y down), with unit direction.
    ///
    /// `lens`: two numbers uniform in [0, 1) that select the point of the aperture; without meaning for a pinhole.
    #[must_use]
    pub fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
        let on_screen = self.screen.from_film(film);
        let mut ray = match self.projection {
            CameraProjection::Perspective(p) => p.ray(on_screen),
            CameraProjection::Orthographic(o) => o.ray(on_screen),
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

    /// Whether rays depend on the point of the lens.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.lens_radius > 0.0
    }

    /// The ray of [`Camera::ray`] with the same `lens` that meets `point` (world space, metres).
    ///
    /// `None` for points behind the camera and for those outside its field of view.
    #[must_use]
    pub fn project(&self, point: DVec3, lens: DVec2) -> Option<FilmProjection> {
        let local = self.to_world.inverse().point(point);
        if local.z.is_nan() || local.z <= 0.0 {
            return None;
        }
        let (mut on_lens, mut seen) = (DVec2::ZERO, local.truncate());
        if self.lens_radius > 0.0 {
            on_lens = self.lens_radius * warp::concentric_disk(lens);
            // The ray of the same film point without a lens, at this depth: both meet in the plane of focus, and are
            // `on_lens` apart at depth 0.
            seen -= on_lens * (1.0 - local.z / self.focal_distance);
        }
        let (screen, start) = match self.projection {
            CameraProjection::Perspective(p) => (p.screen(seen, local.z), on_lens),
            CameraProjection::Orthographic(_) => (seen, seen + on_lens),
        };
        let film = self.screen.to_film(screen);
        let origin = self.to_world.point(start.extend(0.0));
        let density = self.density(point, (point - origin).try_normalize()?);
        (film.is_finite() && density > 0.0).then_some(FilmProjection { film, origin, density })
    }

    /// Density of the rays of the film at `point` (world space, metres): pixels per square metre of a surface that faces the ray along the
    /// unit `direction`, for one point of the lens; 0 where it is not a number.
    ///
    /// A pixel is the mean of the radiance over film and lens. As an integral over surfaces it has this density times the cosine as a
    /// factor; for a pinhole, density times squared distance is the importance per solid angle of @veach1997.
    #[must_use]
    pub fn density(&self, point: DVec3, direction: DVec3) -> f64 {
        let to_local = self.to_world.inverse();
        let z = to_local.point(point).z;
        let per_plane = match self.projection {
            CameraProjection::Perspective(p) => p.screen_density(z),
            CameraProjection::Orthographic(_) => 1.0,
        };
        // In the camera's frame an area across the ray is 1 / cos of the area in the plane of depth z. From world to camera, areas across a ray
        // scale as volumes divided by lengths along the ray; the cosine is the depth of that length.
        let depth = to_local.vector(direction).z;
        let density = per_plane * self.inverse_volume / (depth * self.screen.pixel_area());
        if density > 0.0 && density.is_finite() { density } else { 0.0 }
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

    /// Pinhole, lens and both as parallel projections, under a matrix that turns, mirrors and stretches.
    fn cameras() -> Vec<Camera> {
        let to_world = DMat4::from_translation(DVec3::new(1.0, -2.0, 0.5))
            * DMat4::from_rotation_y(0.7)
            * DMat4::from_scale(DVec3::new(-1.5, 0.8, 1.2));
        let mut cameras = Vec::new();
        for kind in [CameraKind::Perspective { field_of_view: 0.9 }, CameraKind::Orthographic] {
            for lens_radius in [0.0, 0.3] {
                let description = CameraDescription {
                    kind,
                    lens_radius,
                    focal_distance: 3.0,
                    to_world,
                    ..CameraDescription::default()
                };
                cameras.push(Camera::try_new(&description, &film(40, 30)).unwrap());
            }
        }
        cameras
    }

    #[test]
    fn points_on_a_ray_are_projected_to_its_film_point() {
        for camera in cameras() {
            for (place, lens, t) in [
                (DVec2::new(3.5, 20.0), DVec2::new(0.2, 0.7), 0.4),
                (DVec2::new(39.0, 1.0), DVec2::new(0.9, 0.1), 3.0),
                (DVec2::new(-8.0, 33.0), DVec2::new(0.5, 0.4), 50.0),
            ] {
                let ray = camera.ray(place, lens);
                let seen = camera.project(ray.at(t), lens).unwrap();
                assert!((seen.film - place).length() < 1e-11, "{} {place}", seen.film);
                assert!((seen.origin - ray.origin).length() < 1e-12);
                assert_eq!(camera.project(ray.at(-t), lens), None);
                let along = camera.density(ray.at(t), ray.direction);
                assert!((seen.density / along - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn density_is_the_film_area_of_a_small_surface_across_the_ray() {
        for camera in cameras() {
            let lens = DVec2::new(0.3, 0.8);
            let ray = camera.ray(DVec2::new(9.0, 25.0), lens);
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
    }
}
