//! Central projection.

use std::f64::consts::PI;

use glanz_math::{DVec2, DVec3, Ray};

/// A pinhole at the origin looking along +z.
#[derive(Clone, Copy, Debug)]
pub struct Perspective {
    tan_half: f64,
}

impl Perspective {
    /// `field_of_view`: full angle, radians, that [-1, 1] of the screen spans; `None` outside (0, pi).
    #[must_use]
    pub fn try_new(field_of_view: f64) -> Option<Self> {
        (field_of_view > 0.0 && field_of_view < PI).then(|| Self { tan_half: (0.5 * field_of_view).tan() })
    }

    /// The ray through a point of the screen; its direction has z = 1.
    #[must_use]
    pub fn ray(&self, screen: DVec2) -> Ray {
        let on_plane = screen * self.tan_half;
        Ray::new(DVec3::ZERO, DVec3::new(on_plane.x, on_plane.y, 1.0))
    }
    /// The point of the screen whose ray passes through `seen` at depth `z` > 0.
    #[must_use]
    pub fn screen(&self, seen: DVec2, z: f64) -> DVec2 {
        seen / (z * self.tan_half)
    }

    /// Area on the screen over the area that it shows in the plane of depth `z`.
    #[must_use]
    pub fn screen_density(&self, z: f64) -> f64 {
        let scale = z * self.tan_half;
        1.0 / (scale * scale)
    }
}
