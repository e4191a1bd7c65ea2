//! Light, ground and background of the studio.
//!
//! The light is the same for every background: a grey environment, a soft key light from the upper left of the viewer, a weaker one from
//! behind, and a large one above. All of it is infinitely far, so that it falls on the ground evenly. The ground is infinite, and its reflectance is chosen such that it
//! has the radiance of the background where no shadow falls: it has no visible end.

use std::f32::consts::PI;
use std::f64::consts::FRAC_PI_2;

use glanz_math::{DMat4, DVec3};

use super::view::ViewFrame;
use crate::description::{LightDescription, LightKind, MaterialKind, ShapeDescription};

/// A soft light.
struct SoftLight {
    /// Direction to it around the upward axis, from the viewer to the right, radians.
    azimuth: f64,
    /// Direction to it above the horizon, radians; at least the angular radius, so that all of it lights the ground.
    elevation: f64,
    /// Half angle of the cone, radians.
    angular_radius: f64,
    /// Radiance of a white diffuse surface that faces it.
    strength: f32,
}

/// Radiance of the environment.
const ENVIRONMENT: f32 = 0.2;

/// The key light, the light from behind, and a large one above, in which metals show a horizon.
const SOFT_LIGHTS: [SoftLight; 3] = [
    SoftLight { azimuth: -1.3, elevation: 0.8, angular_radius: 0.35, strength: 0.75 },
    SoftLight { azimuth: 2.4, elevation: 0.7, angular_radius: 0.35, strength: 0.2 },
    SoftLight { azimuth: 0.0, elevation: FRAC_PI_2, angular_radius: 1.2, strength: 0.25 },
];

/// The lights; `above`: the upward unit vector.
pub(super) fn lights(frame: &ViewFrame, above: DVec3) -> Vec<LightDescription> {
    // A camera below the model sees the side that faces down.
    let vertical = if frame.forward.dot(above) > 0.5 { -above } else { above };
    let soft = SOFT_LIGHTS.iter().map(|light| {
        let aside = above.cross(frame.viewer);
        let horizontal = light.azimuth.cos() * frame.viewer + light.azimuth.sin() * aside;
        let from = light.elevation.cos() * horizontal + light.elevation.sin() * vertical;
        let kind = LightKind::Sun { from, to: DVec3::ZERO, angular_radius: light.angular_radius };
        LightDescription::new(kind, light.strength * PI)
    });
    soft.chain([LightDescription::infinite(ENVIRONMENT)]).collect()
}

/// Radiance of a white diffuse surface that faces upwards, under all lights.
fn ground_radiance() -> f32 {
    SOFT_LIGHTS.iter().fold(ENVIRONMENT, |sum, light| sum + light.strength * light.elevation.sin() as f32)
}

/// Material of a ground that looks like the background, linear Rec. 709.
pub(super) fn ground_material(background: [f32; 3]) -> MaterialKind {
    let radiance = ground_radiance();
    MaterialKind::diffuse(background.map(|value| (value / radiance).min(1.0)))
}

/// The ground through `point`.
pub(super) fn ground(point: DVec3, above: DVec3, material: usize) -> ShapeDescription {
    let aside = above.any_orthonormal_vector();
    let columns = [aside, above.cross(aside), above].map(|axis| axis.extend(0.0));
    let to_parent = DMat4::from_cols(columns[0], columns[1], columns[2], point.extend(1.0));
    ShapeDescription { to_parent, material, ..ShapeDescription::plane() }
}
