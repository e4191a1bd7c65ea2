//! Light from a clear sky.

use std::f64::consts::FRAC_1_PI;

use glanz_light::{ClearSky, Wavelengths};

use super::{ImageInfiniteLight, LightInput, SphereImage, range_error};
use crate::description::{SkyDescription, SphereMapping};
use crate::error::SceneErrorKind;

/// Pixels along each side of the picture: 0.4 degrees each, which resolves the brightness around the sun.
const RESOLUTION: usize = 512;

/// The sky as a picture of equal areas, over the ground that it lights.
pub(super) fn resolve(
    input: &LightInput<'_>,
    sky: &SkyDescription,
) -> Result<ImageInfiniteLight, SceneErrorKind> {
    let towards = sky.towards_sun;
    let towards_sun = towards.try_normalize().ok_or_else(|| range_error("sky: sun", towards, "not 0"))?;
    let model = ClearSky::try_new(towards_sun, sky.turbidity, sky.albedo)?;
    let sun = if sky.is_ground_sunlit {
        let facing = model.sun_irradiance().radiance(&Wavelengths::Rgb);
        facing.to_rgb(&Wavelengths::Rgb).map(|irradiance| irradiance.max(0.0) * towards_sun.z as f32)
    } else {
        [0.0; 3]
    };
    let picture = |ground: [f32; 3]| {
        SphereImage::of(SphereMapping::EqualArea, RESOLUTION, |direction| {
            if direction.z < 0.0 { ground } else { model.radiance(direction) }
        })
    };
    let above = picture([0.0; 3]).irradiance();
    let ground = std::array::from_fn(|i| sky.albedo[i] * (above[i] as f32 + sun[i]) * FRAC_1_PI as f32);
    ImageInfiniteLight::try_new(input, picture(ground))
}
