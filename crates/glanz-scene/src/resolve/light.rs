//! Lights that are not surfaces.

use glanz_light::{SpectralDistribution, Spectrum, Wavelengths, units};

use super::{WarningList, range_error, transform};
use crate::description::{ImageDescription, LightDescription, LightKind, Location};
use crate::error::{SceneError, SceneErrorKind};
use crate::light::{LEAST_PORTAL_SIDE, Light, LightInput};

/// Bytes of each texel of a light's picture: its radiance, its weight, and the sums that select it.
pub(super) const BYTES_PER_TEXEL: u64 = 40;

/// Bytes that a light makes for its portal, however small its picture.
pub(super) fn portal_bytes(light: &LightDescription) -> u64 {
    match light.kind {
        LightKind::PortalInfinite { .. } => BYTES_PER_TEXEL * (LEAST_PORTAL_SIDE * LEAST_PORTAL_SIDE) as u64,
        _ => 0,
    }
}

/// Bytes that a light makes of its picture.
pub(super) fn picture_bytes(light: &LightDescription, images: &[ImageDescription]) -> u64 {
    let image = match &light.kind {
        LightKind::Projection { image, .. }
        | LightKind::Goniometric { image, .. }
        | LightKind::ImageInfinite { image, .. } => Some(*image),
        LightKind::PortalInfinite { image, .. } => image.as_ref().map(|(image, _)| *image),
        _ => None,
    };
    let size = image.and_then(|image| images.get(image)).map_or([0, 0], |image| image.picture.size());
    let texels = size[0] * size[1];
    BYTES_PER_TEXEL.saturating_mul(texels as u64)
}

pub(super) fn light(
    description: &LightDescription,
    images: &[ImageDescription],
    wavelengths: &Wavelengths,
    warnings: &mut WarningList,
) -> Result<Light, SceneError> {
    let location = description.location;
    let to_world = transform(description.to_world, "light", location)?;
    let emission =
        emitted_spectrum(&description.emission, description.scale, wavelengths, "light: emission", location)?;
    let per_candela = per_candela(description, wavelengths).map_err(|error| error.kind);
    let input = LightInput { description, images, to_world, emission, per_candela };
    let light = Light::try_new(input).map_err(|kind: SceneErrorKind| SceneError { location, kind })?;
    if let Some(message) = light.warning() {
        warnings.warn(location, message);
    }
    Ok(light)
}

/// The spectrum of one candela of the light's colour times its scale, W/sr; also that of one lumen, W.
fn per_candela(description: &LightDescription, wavelengths: &Wavelengths) -> Result<Spectrum, SceneError> {
    let location = description.location;
    let color =
        emitted_spectrum(&description.emission, 1.0, wavelengths, "photometric light: colour", location)?;
    let factor = units::scale_to_photometric(color, wavelengths, 1.0).ok_or_else(|| {
        range_error(location, "photometric light: colour", format!("{color:?}"), "brighter than black")
    })?;
    Ok(color * factor as f32 * description.scale)
}

/// The light of a distribution times `scale`: finite, in no band negative.
///
/// Some spectra have colours outside Rec. 709, such as black bodies below some 1900 K, and with them negative lanes.
/// These become 0, since no band may remove light. Negative values in the scene itself are an error.
pub(super) fn emitted_spectrum(
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

/// Whether the spectrum has no negative value, so that only its colour can have negative components.
fn is_light(distribution: &SpectralDistribution) -> bool {
    match distribution {
        SpectralDistribution::Blackbody { scale, .. } => *scale >= 0.0,
        SpectralDistribution::Sampled(samples) => samples.range().0 >= 0.0,
        _ => false,
    }
}

/// Replaces negative lanes by 0; lanes that are not a number stay.
fn clipped(radiance: Spectrum) -> Spectrum {
    radiance.map(|x| if x < 0.0 { 0.0 } else { x })
}
