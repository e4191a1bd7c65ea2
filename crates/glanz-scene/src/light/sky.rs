//! Light from the sky.

use std::f64::consts::{FRAC_1_PI, PI};

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

/// Pixels along each side of the picture of an overcast sky, whose brightness changes little from pixel to pixel.
const OVERCAST_RESOLUTION: usize = 128;

/// The overcast sky of ISO 15469:2004 and CIE S 011: luminance in proportion to 1 + 2 sin(elevation) (@moon1942), such that its irradiance on the open ground
/// is 1 times the emission.
pub(super) fn resolve_overcast(
    input: &LightInput<'_>,
    albedo: [f32; 3],
) -> Result<ImageInfiniteLight, SceneErrorKind> {
    if let Some(&outside) = albedo.iter().find(|x| !(0.0..=1.0).contains(*x)) {
        return Err(range_error("overcast sky: albedo", outside, "from 0 to 1"));
    }
    let picture = |zenith: f64, ground: [f32; 3]| {
        SphereImage::of(SphereMapping::EqualArea, OVERCAST_RESOLUTION, |direction| {
            let sky = [(zenith * (1.0 + 2.0 * direction.z) / 3.0) as f32; 3];
            // The middles of pixels lie on the horizon, too.
            match direction.z {
                z if z.abs() < 1e-9 => std::array::from_fn(|i| 0.5 * (sky[i] + ground[i])),
                z if z > 0.0 => sky,
                _ => ground,
            }
        })
    };
    // 7 pi / 9 of the zenith's radiance, but for the interpolation between pixels at the horizon.
    let zenith = 9.0 / (7.0 * PI);
    let [counted, ..] = picture(zenith, [0.0; 3]).irradiance();
    let ground = albedo.map(|albedo| albedo * FRAC_1_PI as f32);
    ImageInfiniteLight::try_new(input, picture(zenith / counted, ground))
}
