//! Participating media.

use std::fmt::Write;

use glanz_light::SpectralDistribution;
use glanz_scene::description::{MediumDescription, SpectrumParameter, SurfaceMedia};

use super::material::spectrum;
use super::parameters::{ParameterWriter, quoted};
use super::{PbrtWriteError, write_transform};

/// The name of a medium by its number; of empty space none.
fn name(number: Option<usize>) -> String {
    number.map_or_else(String::new, |number| format!("medium {}", number + 1))
}

/// Writes the media on both sides of the shapes to come.
pub(super) fn write_interface(text: &mut String, media: SurfaceMedia) {
    let [inside, outside] = [media.inside, media.outside].map(|number| quoted(&name(number)));
    // Writing to a text cannot fail.
    let _ = writeln!(text, "MediumInterface {inside} {outside}");
}

/// Writes the definition of a medium, before the world.
pub(super) fn write(
    text: &mut String,
    number: usize,
    medium: &MediumDescription,
) -> Result<(), PbrtWriteError> {
    let infinite = |_| PbrtWriteError::Unsupported("a medium with numbers that are not finite");
    let emits = medium.emission != SpectralDistribution::Constant(0.0);
    if let Some(density) = &medium.density {
        write_transform(text, density.to_world).map_err(infinite)?;
    }
    let _ = write!(text, "MakeNamedMedium {}", quoted(&name(Some(number))));
    let mut list = ParameterWriter::new(text);
    list.text("type", if medium.density.is_some() { "uniformgrid" } else { "homogeneous" });
    for (name, coefficient) in [("sigma_a", &medium.absorption), ("sigma_s", &medium.scattering)] {
        spectrum(&mut list, name, &SpectrumParameter::Value(coefficient.clone()))?;
    }
    list.singles("float", "scale", [medium.scale]);
    list.float("g", medium.g);
    if emits {
        if medium.density.is_some() {
            return Err(PbrtWriteError::Unsupported("a medium on a grid that emits light"));
        }
        // Version 4 scales spectra to luminance 1.
        if matches!(medium.emission, SpectralDistribution::Sampled(_)) {
            return Err(PbrtWriteError::Unsupported("a medium that emits a spectrum by wavelength"));
        }
        spectrum(&mut list, "Le", &SpectrumParameter::Value(medium.emission.clone()))?;
    }
    if medium.emission_scale != 1.0 && medium.density.is_none() {
        list.singles("float", "Lescale", [medium.emission_scale]);
    }
    if let Some(density) = &medium.density {
        for (name, count) in ["nx", "ny", "nz"].into_iter().zip(density.resolution) {
            list.integers(name, [i64::from(count)]);
        }
        list.points("p0", [density.corners[0]]);
        list.points("p1", [density.corners[1]]);
        list.singles("float", "density", density.values.iter().copied());
    }
    list.finish().map_err(infinite)?;
    if medium.density.is_some() {
        text.push_str("Identity\n");
    }
    Ok(())
}
