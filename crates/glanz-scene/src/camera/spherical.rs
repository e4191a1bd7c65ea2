//! Pictures of all directions.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::warp::{equal_area_sphere, equal_area_sphere_inverse};

use crate::description::SphericalMapping;

/// All directions from the origin, on the screen [0, 1]^2 with y up.
///
/// # Source
/// @pharr2023 section 5.3, with its orientation: at half the height of an equirectangular picture, its left border shows +x, then come +z, -x
/// and -z; the middle of an equal-area picture shows +y.
#[derive(Clone, Copy, Debug)]
pub struct Spherical {
    mapping: SphericalMapping,
}

impl Spherical {
    /// The projection with this mapping.
    #[must_use]
    pub fn new(mapping: SphericalMapping) -> Self {
        Self { mapping }
    }

    /// The ray through a point of the screen, which may lie beyond its borders; its direction is of unit length.
    #[must_use]
    pub fn ray(&self, screen: DVec2) -> Ray {
        let place = DVec2::new(screen.x, 1.0 - screen.y);
        let direction = match self.mapping {
            SphericalMapping::Equirectangular => {
                // Beyond a pole the sine is negative, which continues on the other side.
                let ((sin, cos), (sin_phi, cos_phi)) = ((PI * place.y).sin_cos(), (TAU * place.x).sin_cos());
                DVec3::new(sin * cos_phi, cos, sin * sin_phi)
            }
            SphericalMapping::EqualArea => {
                let DVec3 { x, y, z } = equal_area_sphere(wrapped(place));
                DVec3::new(x, z, y)
            }
        };
        Ray::new(DVec3::ZERO, direction)
    }

    /// The point of the screen in the direction of `point`; `None` at the origin.
    #[must_use]
    pub fn screen(&self, point: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = point.try_normalize()?;
        let place = match self.mapping {
            SphericalMapping::Equirectangular => {
                let turn = z.atan2(x) / TAU;
                DVec2::new(if turn < 0.0 { turn + 1.0 } else { turn }, x.hypot(z).atan2(y) / PI)
            }
            SphericalMapping::EqualArea => equal_area_sphere_inverse(DVec3::new(x, z, y)),
        };
        Some(DVec2::new(place.x, 1.0 - place.y))
    }

    /// Area on the screen over the solid angle that it shows in the direction of `point`.
    #[must_use]
    pub fn per_solid_angle(&self, point: DVec3) -> f64 {
        match self.mapping {
            SphericalMapping::Equirectangular => point.length() / (TAU * PI * point.x.hypot(point.z)),
            SphericalMapping::EqualArea => 1.0 / (2.0 * TAU),
        }
    }

    /// Points beyond the borders of the screen with the same ray as `screen`, those within half a picture of it included.
    #[must_use]
    pub fn copies(&self, screen: DVec2) -> [DVec2; 8] {
        let DVec2 { x, y } = screen;
        match self.mapping {
            SphericalMapping::Equirectangular => [
                [x - 1.0, y],
                [x + 1.0, y],
                [x - 2.0, y],
                [x + 2.0, y],
                [x - 0.5, -y],
                [x + 0.5, -y],
                [x - 0.5, 2.0 - y],
                [x + 0.5, 2.0 - y],
            ],
            SphericalMapping::EqualArea => [
                [-x, 1.0 - y],
                [2.0 - x, 1.0 - y],
                [1.0 - x, -y],
                [1.0 - x, 2.0 - y],
                [x - 1.0, y - 1.0],
                [x + 1.0, y - 1.0],
                [x - 1.0, y + 1.0],
                [x + 1.0, y + 1.0],
            ],
        }
        .map(DVec2::from_array)
    }
}

/// The point of the unit square that continues an equal-area picture at `place`, beyond its borders.
fn wrapped(place: DVec2) -> DVec2 {
    // Two pictures further along a side it is the same, one further half a turn about the middle of the side between.
    let (mut x, mut y) = (place.x.rem_euclid(2.0), place.y);
    if x > 1.0 {
        (x, y) = (2.0 - x, 1.0 - y);
    }
    y = y.rem_euclid(2.0);
    if y > 1.0 {
        (x, y) = (1.0 - x, 2.0 - y);
    }
    DVec2::new(x, y)
}
