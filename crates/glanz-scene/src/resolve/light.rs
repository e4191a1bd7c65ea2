//! Lights that are not surfaces.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::{SpectralDistribution, Spectrum, Wavelengths, units};

use super::{Notes, range_error, transform};
use crate::description::{LightDescription, LightKind, Location};
use crate::error::SceneError;
use crate::light::{DistantLight, InfiniteLight, Light, PhotometricLight, PointLight, RayLight, SpotLight};

pub(super) fn light(
    description: &LightDescription,
    wavelengths: &Wavelengths,
    notes: &mut Notes,
) -> Result<Light, SceneError> {
    let location = description.location;
    let to_world = transform(description.to_world, "light", location)?;
    let emission =
        emitted(&description.emission, description.scale, wavelengths, "light: emission", location)?;
    let uneven = || {
        let (what, range) =
            ("photometric light: transformation", "moves, turns and scales alike in all directions");
        range_error(location, what, "uneven", range)
    };
    Ok(match &description.kind {
        LightKind::Point { from, range } => {
            if let Some(range) = *range
                && (range.is_nan() || range <= 0.0)
            {
                return Err(range_error(location, "point light: range", range, "positive"));
            }
            Light::Point(PointLight::new(to_world.point(*from), emission, *range))
        }
        LightKind::Spot { from, to, cone_angle, inner_angle, falloff } => {
            let axis = to_world
                .vector(*to - *from)
                .try_normalize()
                .ok_or_else(|| range_error(location, "spot light: to", to, "different from its position"))?;
            if !(*cone_angle > 0.0 && *cone_angle <= PI) {
                let degrees = cone_angle.to_degrees();
                return Err(range_error(
                    location,
                    "spot light: cone angle",
                    degrees,
                    "above 0 and at most 180",
                ));
            }
            let angles = [*cone_angle, inner_angle.clamp(0.0, *cone_angle)];
            Light::Spot(SpotLight::new(to_world.point(*from), axis, angles, *falloff, emission))
        }
        LightKind::Photometric { distribution, opening, from } => {
            let per_candela = per_candela(description, wavelengths)?;
            let (distribution, opening) = (Arc::clone(distribution), *opening);
            let light = PhotometricLight::try_new(distribution, opening, *from, &to_world, per_candela);
            Light::Photometric(light.ok_or_else(uneven)?)
        }
        LightKind::Rays { rays, from } => {
            let per_lumen = per_candela(description, wavelengths)?;
            let light =
                RayLight::try_new(Arc::clone(rays), *from, &to_world, per_lumen).ok_or_else(uneven)?;
            let message = "the rays of a file cannot be looked for from surfaces: this light is seen by what begins at the lights only, \
                           such as glanz illuminate";
            notes.warn(location, message);
            Light::Rays(light)
        }
        LightKind::Distant { from, to } => {
            let towards = to_world
                .vector(*from - *to)
                .try_normalize()
                .ok_or_else(|| range_error(location, "distant light: from", from, "different from to"))?;
            Light::Distant(DistantLight::new(towards, emission))
        }
        LightKind::Infinite => Light::Infinite(InfiniteLight::new(emission)),
    })
}

/// The spectrum of one candela of the light's colour times its scale, W/sr; also that of one lumen, W.
fn per_candela(description: &LightDescription, wavelengths: &Wavelengths) -> Result<Spectrum, SceneError> {
    let location = description.location;
    let color = emitted(&description.emission, 1.0, wavelengths, "photometric light: colour", location)?;
    let factor = units::scale_to_photometric(color, wavelengths, 1.0).ok_or_else(|| {
        range_error(location, "photometric light: colour", format!("{color:?}"), "brighter than black")
    })?;
    Ok(color * factor as f32 * description.scale)
}

/// The light of a distribution times `scale`: finite, in no band negative.
///
/// Some spectra have colours outside Rec. 709, such as black bodies below some 1900 K, and with them negative lanes.
/// These become 0, for no band may take light away. What is negative in the scene itself is an error.
pub(super) fn emitted(
    distribution: &SpectralDistribution,
    scale: f32,
    wavelengths: &Wavelengths,
    what: &'static str,
    location: Option<Location>,
) -> Result<Spectrum, SceneError> {
    let radiance = distribution.radiance(wavelengths);
    let emission = if is_light(distribution) { clipped(radiance) } else { radiance } * scale;
    if !emission.is_finite() || !emission.map(|x| x.min(0.0)).is_black() {
        return Err(range_error(location, what, format!("{emission:?}"), "finite and not negative"));
    }
    Ok(emission)
}

/// Whether this is a spectrum without a negative value, so that only its colour can have negative components.
fn is_light(distribution: &SpectralDistribution) -> bool {
    match distribution {
        SpectralDistribution::Blackbody { scale, .. } => *scale >= 0.0,
        SpectralDistribution::Sampled(samples) => samples.range().0 >= 0.0,
        _ => false,
    }
}

/// With 0 for what is negative; what is not a number stays.
fn clipped(radiance: Spectrum) -> Spectrum {
    radiance.map(|x| if x < 0.0 { 0.0 } else { x })
}
