//! Participating media.

use glanz_job::ResourceBudget;
use glanz_light::{SpectralDistribution, Spectrum, Wavelengths};
use glanz_math::{Bounds3, DMat4, DVec3};
use glanz_shading::HenyeyGreenstein;

use super::group::reference;
use super::light::emitted_spectrum;
use super::{range_error, spend, transform};
use crate::description::{DensityDescription, Description, Location, MediumDescription, SurfaceMedia};
use crate::error::SceneError;
use crate::medium::{
    DensityGrid, MAX_DENSITIES, MAX_MEDIA, Medium, MediumCoefficients, MediumId, MediumInterface, SceneMedia,
};

/// The media of a description, of which those without effect became empty space.
pub(super) struct ResolvedMedia {
    pub(super) media: Vec<Medium>,
    /// By index in the description.
    ids: Vec<MediumId>,
}

/// Whether media end at surfaces of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MediaEnds {
    pub(super) anywhere: bool,
    /// At surfaces that light passes.
    pub(super) at_interfaces: bool,
}

impl ResolvedMedia {
    pub(super) fn new(
        description: &Description,
        wavelengths: &Wavelengths,
        budget: &ResourceBudget,
    ) -> Result<Self, SceneError> {
        let count = description.media.len();
        if count > MAX_MEDIA {
            return Err(range_error(None, "number of media", count, "at most 65535"));
        }
        let (mut media, mut ids) = (Vec::new(), Vec::with_capacity(count));
        for described in &description.media {
            let bounds = described.density.as_ref().map_or(0, |_| DensityGrid::BOUND_BYTES);
            spend(budget, 0, (size_of::<Medium>() + bounds) as u64, described.location)?;
            ids.push(match medium(described, wavelengths)? {
                Some(medium) => {
                    media.push(medium);
                    MediumId::new(media.len() - 1)
                }
                None => MediumId::VACUUM,
            });
        }
        Ok(Self { media, ids })
    }

    pub(super) fn id(
        &self,
        index: Option<usize>,
        location: Option<Location>,
    ) -> Result<MediumId, SceneError> {
        let Some(index) = index else { return Ok(MediumId::VACUUM) };
        reference("medium", index, self.ids.len(), location)?;
        Ok(self.ids.get(index).copied().unwrap_or(MediumId::VACUUM))
    }

    pub(super) fn interface(
        &self,
        media: SurfaceMedia,
        location: Option<Location>,
    ) -> Result<MediumInterface, SceneError> {
        let SurfaceMedia { inside, outside } = media;
        Ok(MediumInterface { inside: self.id(inside, location)?, outside: self.id(outside, location)? })
    }

    /// The media, none if no ray can be in one: neither around the camera nor behind a surface.
    pub(super) fn finish(self, camera: Option<usize>, ends: MediaEnds) -> Result<SceneMedia, SceneError> {
        let camera = self.id(camera, None)?;
        let is_used = ends.anywhere || camera != MediumId::VACUUM;
        let media = if is_used { self.media } else { Vec::new() };
        Ok(SceneMedia { media, camera, are_open: ends.at_interfaces })
    }
}

/// `None` for a medium that does nothing.
fn medium(description: &MediumDescription, wavelengths: &Wavelengths) -> Result<Option<Medium>, SceneError> {
    let MediumDescription { absorption, scattering, scale, g, density, location, .. } = description;
    let location = *location;
    let coefficient = |distribution: &SpectralDistribution, what| {
        let value = distribution.unbounded(wavelengths) * *scale;
        if value.is_finite() && value.map(|x| x.min(0.0)).is_black() {
            return Ok(value);
        }
        Err(range_error(location, what, format!("{value:?}"), "finite and not negative"))
    };
    let absorption = coefficient(absorption, "medium: absorption")?;
    let scattering = coefficient(scattering, "medium: scattering")?;
    let phase = HenyeyGreenstein::try_new(*g)
        .ok_or_else(|| range_error(location, "medium: g", g, "between -1 and 1, both excluded"))?;
    let (emission, factor) = (&description.emission, description.emission_scale);
    let emission = emitted_spectrum(emission, factor, wavelengths, "medium: emission", location)?;
    let extinction = absorption + scattering;
    let share = |part: Spectrum| part.zip(extinction, |part, all| if all > 0.0 { part / all } else { 0.0 });
    let density = density.as_ref().map(|grid| density_grid(grid, location)).transpose()?;
    let largest = |grid: &DensityDescription| grid.values.iter().copied().fold(0.0, f32::max);
    let densest = extinction * description.density.as_ref().map_or(1.0, largest);
    if !densest.is_finite() {
        let range = "finite where the density is largest, with absorption and scattering added";
        return Err(range_error(location, "medium: extinction", format!("{densest:?}"), range));
    }
    if density.is_some() && !emission.is_black() {
        let range = "0 in a medium with densities";
        return Err(range_error(location, "medium: emission", format!("{emission:?}"), range));
    }
    let source = emission * share(absorption);
    let albedo = share(scattering);
    let coefficients = MediumCoefficients { extinction, albedo, source };
    Ok((!extinction.is_black()).then_some(Medium { coefficients, phase, density }))
}

fn density_grid(
    description: &DensityDescription,
    location: Option<Location>,
) -> Result<DensityGrid, SceneError> {
    let DensityDescription { resolution, values, corners: [a, b], to_world } = description;
    let resolution = resolution.map(|n| n as usize);
    let count = resolution.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    if count != Some(values.len()) || values.is_empty() || values.len() > MAX_DENSITIES {
        let what = "medium: number of densities";
        let range = "the product of nx, ny and nz, at least 1 and at most 2^28";
        return Err(range_error(location, what, values.len(), range));
    }
    if let Some(wrong) = values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
        return Err(range_error(location, "medium: density", wrong, "finite and not negative"));
    }
    let bounds = Bounds3::new(*a, *b);
    let size = bounds.diagonal();
    if !(bounds.is_finite() && size.cmpgt(DVec3::ZERO).all()) {
        let range = "finite and larger than 0 along each axis";
        return Err(range_error(location, "medium: size of the box from p0 to p1", size, range));
    }
    let of_box = DMat4::from_translation(bounds.min) * DMat4::from_scale(size);
    let to_world = transform(*to_world * of_box, "medium", location)?;
    Ok(DensityGrid::from_checked(resolution, values.clone(), to_world.inverse()))
}
