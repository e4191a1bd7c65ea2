//! The channels of a picture.

use crate::aov::{Aov, AovSet};
use crate::pixel::{FirstHit, PixelValue};

/// Channels of a picture with `aovs`, in their order.
#[must_use]
pub fn channel_names(aovs: AovSet) -> Vec<&'static str> {
    let mut names = vec!["R", "G", "B"];
    for aov in Aov::ALL.into_iter().filter(|&a| aovs.contains(a)) {
        names.extend_from_slice(match aov {
            Aov::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
            Aov::Position => &["P.X", "P.Y", "P.Z"],
            Aov::Normal => &["N.X", "N.Y", "N.Z"],
            Aov::ShadingNormal => &["Ns.X", "Ns.Y", "Ns.Z"],
            Aov::Uv => &["u", "v"],
            Aov::Distance => &["Z"],
            Aov::Id => &["id"],
            Aov::Variance => &["Variance.R", "Variance.G", "Variance.B"],
        });
    }
    names
}

/// Their values in a pixel.
pub(crate) fn channel_values(aovs: AovSet, radiance: &[PixelValue; 3], hit: Option<&FirstHit>) -> Vec<f32> {
    let mut values: Vec<f32> = radiance.iter().map(|v| v.mean as f32).collect();
    let vector =
        |get: fn(&FirstHit) -> glanz_math::DVec3| hit.map_or([0.0; 3], |h| get(h).as_vec3().to_array());
    for aov in Aov::ALL.into_iter().filter(|&a| aovs.contains(a)) {
        match aov {
            Aov::Albedo => values.extend(hit.map_or([0.0; 3], |h| h.albedo)),
            Aov::Position => values.extend(vector(|h| h.position)),
            Aov::Normal => values.extend(vector(|h| h.normal)),
            Aov::ShadingNormal => values.extend(vector(|h| h.shading_normal)),
            Aov::Uv => values.extend(hit.map_or([0.0; 2], |h| h.uv.as_vec2().to_array())),
            Aov::Distance => values.push(hit.map_or(0.0, |h| h.distance as f32)),
            Aov::Id => values.push(hit.map_or(-1.0, |h| h.object as f32)),
            Aov::Variance => values.extend(radiance.iter().map(|v| v.variance as f32)),
        }
    }
    values
}
