//! Projections of wide angles to a disk.

use std::f64::consts::TAU;

use glanz_math::{DVec2, DVec3, Ray};

use crate::description::FisheyeProjection;

/// A fish-eye at the origin looking along +z: the unit disk of the screen shows the field of view, and nothing is seen outside.
#[derive(Clone, Copy, Debug)]
pub struct Fisheye {
    projection: FisheyeProjection,
    /// Half the field of view, radians.
    half: f64,
    /// The function of the projection at that angle.
    rim: f64,
}

impl Fisheye {
    /// `field_of_view`: full angle, radians, that the diameter of the disk spans; `None` outside (0, 2 pi], and at 2 pi if it is stereographic.
    #[must_use]
    pub fn try_new(projection: FisheyeProjection, field_of_view: f64) -> Option<Self> {
        let allowed = field_of_view > 0.0
            && (field_of_view < TAU
                || field_of_view == TAU && projection != FisheyeProjection::Stereographic);
        let half = 0.5 * field_of_view;
        allowed.then(|| Self { projection, half, rim: distance(projection, half) })
    }

    /// The ray through a point of the screen, with a direction of unit length; `None` outside of the disk.
    #[must_use]
    pub fn ray(&self, screen: DVec2) -> Option<Ray> {
        let radius = screen.length();
        if radius.is_nan() || radius > 1.0 {
            return None;
        }
        let angle = match self.projection {
            FisheyeProjection::Equidistant => radius * self.half,
            FisheyeProjection::Equisolid => 2.0 * (radius * self.rim).asin(),
            FisheyeProjection::Stereographic => 2.0 * (radius * self.rim).atan(),
        };
        let (sin, cos) = angle.sin_cos();
        let across = screen * if radius > 0.0 { sin / radius } else { 0.0 };
        Some(Ray::new(DVec3::ZERO, across.extend(cos)))
    }

    /// The point of the screen in the direction of `point`; `None` outside the field of view.
    #[must_use]
    pub fn screen(&self, point: DVec3) -> Option<DVec2> {
        let sin = point.truncate().length();
        let angle = sin.atan2(point.z);
        let radius = distance(self.projection, angle) / self.rim;
        let towards = if sin > 0.0 { point.truncate() / sin } else { DVec2::X };
        (point != DVec3::ZERO && angle <= self.half).then(|| radius * towards)
    }

    /// Area on the screen over the solid angle that it shows in the direction of `point`.
    ///
    /// The ring of the screen between two radii shows that between two angles: r dr / (sin(angle) d(angle)).
    #[must_use]
    pub fn per_solid_angle(&self, point: DVec3) -> f64 {
        let (sin, cos) = (point.truncate().length() / point.length(), point.z / point.length());
        let scale = self.rim * self.rim;
        match self.projection {
            FisheyeProjection::Equidistant if sin == 0.0 && cos > 0.0 => 1.0 / scale,
            FisheyeProjection::Equidistant => sin.atan2(cos) / (sin * scale),
            FisheyeProjection::Equisolid => 0.25 / scale,
            // 1 / cos^4 of half the angle, with cos^2 = (1 + cos) / 2.
            FisheyeProjection::Stereographic => 1.0 / (scale * (1.0 + cos) * (1.0 + cos)),
        }
    }
}

/// Distance from the middle of the picture at which the projection shows an angle to the axis, in units of its focal length, for
/// stereographic and equisolid ones halved.
fn distance(projection: FisheyeProjection, angle: f64) -> f64 {
    match projection {
        FisheyeProjection::Equidistant => angle,
        FisheyeProjection::Equisolid => (0.5 * angle).sin(),
        FisheyeProjection::Stereographic => (0.5 * angle).tan(),
    }
}
