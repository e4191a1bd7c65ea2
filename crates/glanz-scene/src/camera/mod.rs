//! Cameras, which map a point of the film to a ray.

mod aperture;
mod fisheye;
mod orthographic;
mod perspective;
mod realistic;
mod screen;
mod spherical;

use glanz_math::{DVec2, DVec3, Ray, Transform};

use crate::RayDifferential;
use crate::description::{CameraDescription, CameraKind, FilmDescription};
use crate::error::{SceneError, SceneErrorKind};
use crate::resolve::range_error;

pub use aperture::Aperture;
pub use fisheye::Fisheye;
pub use orthographic::Orthographic;
pub use perspective::Perspective;
pub use realistic::RealisticLens;
pub use screen::Screen;
pub use spherical::Spherical;

/// Distance on the film, pixels, of the rays whose difference is a derivative: a power of 2, so far above the rounding of directions and so far below a pixel
/// that either error is small against that of the footprint itself.
const DIFFERENTIAL_STEP: f64 = 1.0 / 1024.0;

/// A camera in the world; its rays have unit directions.
#[derive(Clone, Debug)]
pub struct Camera {
    projection: CameraProjection,
    screen: Screen,
    /// Of a perspective or orthographic camera.
    aperture: Aperture,
    focal_distance: f64,
    to_world: Transform,
    /// Volume in the camera's frame over that in the world.
    inverse_volume: f64,
}

/// A ray from a point of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// The ray, in world space, with unit direction.
    pub ray: Ray,
    /// Factor for the light along it; 1 but for realistic lenses.
    pub weight: f64,
    /// The derivatives of the ray by the film, if they were asked for.
    pub differential: Option<RayDifferential>,
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
#[derive(Clone, Debug)]
enum CameraProjection {
    Perspective(Perspective),
    Orthographic(Orthographic),
    Spherical(Spherical),
    Fisheye(Fisheye),
    Realistic(RealisticLens),
}

impl CameraProjection {
    fn try_new(camera: &CameraDescription, film: &FilmDescription) -> Result<Self, SceneError> {
        let range = |what, value: f64, range| range_error(camera.location, what, value, range);
        Ok(match &camera.kind {
            &CameraKind::Perspective { field_of_view } => {
                Self::Perspective(Perspective::try_new(field_of_view).ok_or_else(|| {
                    range("field of view", field_of_view.to_degrees(), "between 0 and 180 degrees")
                })?)
            }
            CameraKind::Orthographic => Self::Orthographic(Orthographic),
            &CameraKind::Spherical(mapping) => Self::Spherical(Spherical::new(mapping)),
            &CameraKind::Fisheye { field_of_view, projection } => {
                Self::Fisheye(Fisheye::try_new(projection, field_of_view).ok_or_else(|| {
                    let allowed = "above 0 and at most 360 degrees, below that if it is stereographic";
                    range("field of view", field_of_view.to_degrees(), allowed)
                })?)
            }
            CameraKind::Realistic(lens) => {
                let lens = RealisticLens::try_new(lens, film.diagonal);
                Self::Realistic(lens.map_err(|(what, value, allowed)| range(what, value, allowed))?)
            }
        })
    }

    /// Smallest and largest x, then y, of its screen by default; `aspect`: of the screen.
    fn window(&self, camera: &CameraDescription, film: &FilmDescription, aspect: f64) -> [f64; 4] {
        let [width, height] = film.resolution.map(f64::from);
        match self {
            Self::Spherical(_) => [0.0, 1.0, 0.0, 1.0],
            Self::Realistic(_) => {
                let pixel = 0.5 * film.diagonal / width.hypot(height);
                [-pixel * width, pixel * width, -pixel * height, pixel * height]
            }
            _ => camera.screen_window.unwrap_or_else(|| Screen::default_window(aspect)),
        }
    }
}

impl Camera {
    /// Checks a description against the film it exposes.
    ///
    /// # Errors
    /// [`SceneError`] if the matrix is singular, an angle, a distance or a lens out of range, the screen empty.
    pub fn try_new(camera: &CameraDescription, film: &FilmDescription) -> Result<Self, SceneError> {
        let location = camera.location;
        let range = |what, value: f64, range| range_error(location, what, value, range);
        let to_world = Transform::try_from_matrix(camera.to_world).map_err(|source| SceneError {
            location,
            kind: SceneErrorKind::Transform { what: "camera", source },
        })?;
        let [width, height] = film.resolution.map(f64::from);
        if !(width >= 1.0 && height >= 1.0) {
            return Err(range("picture size", width.min(height), "at least 1 x 1"));
        }
        let aspect = camera.aspect.unwrap_or(width / height);
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(range("aspect ratio", aspect, "positive"));
        }
        let projection = CameraProjection::try_new(camera, film)?;
        let window = projection.window(camera, film, aspect);
        let screen = Screen::try_new(window, [width, height])
            .ok_or_else(|| range("screen window", window[1] - window[0], "finite and not empty"))?;
        let aperture = match projection {
            CameraProjection::Perspective(_) | CameraProjection::Orthographic(_) => aperture(camera)?,
            _ => Aperture::PINHOLE,
        };
        Ok(Self {
            projection,
            screen,
            aperture,
            focal_distance: camera.focal_distance,
            to_world,
            inverse_volume: to_world.inverse().forward().matrix3.determinant().abs(),
        })
    }

    /// The ray through `film` (pixels from the top left of the full picture, y down); `None` if no light reaches that point of the film.
    ///
    /// `lens`: two numbers uniform in [0, 1) that select the point of the aperture; without meaning for a pinhole.
    #[must_use]
    pub fn ray(&self, film: DVec2, lens: DVec2) -> Option<CameraRay> {
        self.ray_by_pupil_of(film, film, lens)
    }

    /// As [`Camera::ray`], through the point of a realistic camera's pupil that `lens` selects for the film point `pupil_of`.
    fn ray_by_pupil_of(&self, film: DVec2, pupil_of: DVec2, lens: DVec2) -> Option<CameraRay> {
        let on_screen = self.screen.from_film(film);
        let (mut ray, weight) = match &self.projection {
            CameraProjection::Perspective(p) => (p.ray(on_screen), 1.0),
            CameraProjection::Orthographic(o) => (o.ray(on_screen), 1.0),
            CameraProjection::Spherical(s) => (s.ray(on_screen), 1.0),
            CameraProjection::Fisheye(f) => (f.ray(on_screen)?, 1.0),
            CameraProjection::Realistic(r) => r.ray(on_screen, self.screen.from_film(pupil_of), lens)?,
        };
        if self.aperture.is_open() {
            // All rays of one film point meet in the plane of focus.
            let focus = ray.at(self.focal_distance / ray.direction.z);
            ray.origin += self.aperture.point(lens).extend(0.0);
            ray.direction = focus - ray.origin;
        }
        let world = self.to_world.ray(&ray);
        Some(CameraRay {
            ray: Ray::new(world.origin, world.direction.normalize()),
            weight,
            differential: None,
        })
    }

    /// As [`Camera::ray`], with the derivatives by film points in units of `spacing` pixels. Beside the rays of a picture's border, where there may be no rays, they are
    /// those inwards, or none.
    #[must_use]
    pub fn ray_with_differential(&self, film: DVec2, lens: DVec2, spacing: f64) -> Option<CameraRay> {
        let camera = self.ray(film, lens)?;
        let along = |axis: DVec2| {
            [DIFFERENTIAL_STEP, -DIFFERENTIAL_STEP].into_iter().find_map(|step| {
                let beside = self.ray_by_pupil_of(film + step * axis, film, lens)?.ray;
                let Ray { origin, direction } = camera.ray;
                Some([(beside.origin - origin) / step, (beside.direction - direction) / step])
            })
        };
        let differential = along(DVec2::X)
            .zip(along(DVec2::Y))
            .map(|(x, y)| RayDifferential { origin: [x[0], y[0]], direction: [x[1], y[1]] }.scaled(spacing));
        Some(CameraRay { differential, ..camera })
    }

    /// Whether rays depend on the point of the lens.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.aperture.is_open() || matches!(self.projection, CameraProjection::Realistic(_))
    }

    /// Whether [`Camera::project`] projects points; there is no such map through the lenses of a realistic camera.
    #[must_use]
    pub fn can_project(&self) -> bool {
        !matches!(self.projection, CameraProjection::Realistic(_))
    }

    /// Whether the picture of a straight line is straight.
    #[must_use]
    pub fn keeps_lines(&self) -> bool {
        matches!(self.projection, CameraProjection::Perspective(_) | CameraProjection::Orthographic(_))
    }

    /// The origin of its frame, metres: the middle of the aperture, of a realistic camera that of the film.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.to_world.point(DVec3::ZERO)
    }

    /// The points of the film with the same rays as `film`, itself included: of a spherical picture, those beyond its borders, too, where the
    /// filters of pixels reach.
    pub fn film_points(&self, film: DVec2) -> impl Iterator<Item = DVec2> + '_ {
        let copies = match &self.projection {
            CameraProjection::Spherical(s) => Some(s.copies(self.screen.from_film(film))),
            _ => None,
        };
        let copies = copies.into_iter().flatten().map(|screen| self.screen.to_film(screen));
        std::iter::once(film).chain(copies)
    }

    /// The ray of [`Camera::ray`] with the same `lens` that meets `point` (world space, metres).
    ///
    /// `None` for points outside its field of view, such as those behind the camera, and for all if [it cannot project](Camera::can_project).
    #[must_use]
    pub fn project(&self, point: DVec3, lens: DVec2) -> Option<FilmProjection> {
        let local = self.to_world.inverse().point(point);
        let (screen, start) = match &self.projection {
            CameraProjection::Perspective(p) => {
                let (on_lens, seen) = self.through_lens(local, lens)?;
                (p.screen(seen, local.z), on_lens)
            }
            CameraProjection::Orthographic(_) => {
                let (on_lens, seen) = self.through_lens(local, lens)?;
                (seen, seen + on_lens)
            }
            CameraProjection::Spherical(s) => (s.screen(local)?, DVec2::ZERO),
            CameraProjection::Fisheye(f) => (f.screen(local)?, DVec2::ZERO),
            CameraProjection::Realistic(_) => return None,
        };
        let film = self.screen.to_film(screen);
        let origin = self.to_world.point(start.extend(0.0));
        let density = self.density(point, (point - origin).try_normalize()?);
        (film.is_finite() && density > 0.0).then_some(FilmProjection { film, origin, density })
    }

    /// The point of the lens, and the point at the depth of `local` (in the camera's frame) on the ray of the same film point without a lens.
    /// `None` behind the camera.
    fn through_lens(&self, local: DVec3, lens: DVec2) -> Option<(DVec2, DVec2)> {
        if local.z.is_nan() || local.z <= 0.0 {
            return None;
        }
        if !self.aperture.is_open() {
            return Some((DVec2::ZERO, local.truncate()));
        }
        // Both rays meet in the plane of focus, and are `on_lens` apart at depth 0.
        let on_lens = self.aperture.point(lens);
        Some((on_lens, local.truncate() - on_lens * (1.0 - local.z / self.focal_distance)))
    }

    /// Density of the rays of the film at `point` (world space, metres): pixels per square metre of a surface that faces the ray along the
    /// unit `direction`, for one point of the lens; 0 where it is not a number, and if [the camera cannot project](Camera::can_project).
    ///
    /// A pixel is the mean of the radiance over film and lens. As an integral over surfaces it has this density times the cosine as a
    /// factor; for a pinhole, density times squared distance is the importance per solid angle of @veach1997.
    #[must_use]
    pub fn density(&self, point: DVec3, direction: DVec3) -> f64 {
        let to_local = self.to_world.inverse();
        let (local, along) = (to_local.point(point), to_local.vector(direction));
        // From world to camera, areas across a ray scale as volumes divided by lengths along the ray. In the camera's frame an area across the ray is
        // 1 / cos of the area in the plane of depth z; the cosine is the depth of that length.
        let (per_area, length) = match &self.projection {
            CameraProjection::Perspective(p) => (p.screen_density(local.z), along.z),
            CameraProjection::Orthographic(_) => (1.0, along.z),
            CameraProjection::Spherical(s) => {
                (s.per_solid_angle(local) / local.length_squared(), along.length())
            }
            CameraProjection::Fisheye(f) => {
                (f.per_solid_angle(local) / local.length_squared(), along.length())
            }
            CameraProjection::Realistic(_) => return 0.0,
        };
        let density = per_area * self.inverse_volume / (length * self.screen.pixel_area());
        if density > 0.0 && density.is_finite() { density } else { 0.0 }
    }
}

/// The aperture of a thin lens.
fn aperture(camera: &CameraDescription) -> Result<Aperture, SceneError> {
    let range = |what, value: f64, range| range_error(camera.location, what, value, range);
    let (radius, distance) = (camera.lens_radius, camera.focal_distance);
    if !(radius >= 0.0 && radius.is_finite()) {
        return Err(range("lens radius", radius, "0 or positive"));
    }
    if radius > 0.0 && !(distance > 0.0 && distance.is_finite()) {
        return Err(range("focal distance", distance, "positive"));
    }
    if !camera.iris.rotation.is_finite() {
        return Err(range("rotation of the blades", camera.iris.rotation, "finite"));
    }
    Ok(Aperture::new(radius, camera.iris))
}

#[cfg(test)]
mod tests;
