//! Surfaces that emit light.

use std::collections::BTreeMap;
use std::sync::Arc;

use glanz_job::{BudgetError, ResourceBudget};
use glanz_light::{Spectrum, Wavelengths, units};

use super::light::{BYTES_PER_TEXEL, emitted_spectrum};
use super::{range_error, spend};
use crate::area::{area, far_field_area};
use crate::description::{EmissionDescription, EmissionPower, ImageDescription, Location};
use crate::error::SceneError;
use crate::light::{AreaLight, FlatImage, picture_of};
use crate::object::SceneObject;

/// The area light of the object with the index `object_index` in the world.
pub(super) fn area_light(
    object_index: u32,
    object: &SceneObject,
    emission: &EmissionDescription,
    location: Option<Location>,
    pictures: &mut EmissionPictures<'_>,
    wavelengths: &Wavelengths,
) -> Result<AreaLight, SceneError> {
    let radiance =
        emitted_spectrum(&emission.radiance, emission.scale, wavelengths, "area light: radiance", location)?;
    let image = emission.image.map(|index| pictures.get(index, location)).transpose()?;
    let light = AreaLight::new(object_index, object, radiance, image, emission.two_sided);
    let Some(power) = emission.power else { return Ok(light) };
    let (what, wanted, present) = match power {
        EmissionPower::Watts(watts) => {
            ("area light: power", f64::from(watts), f64::from(light.power().luminance(wavelengths)))
        }
        EmissionPower::Lumens(lumens) => {
            ("area light: lumens", lumens, units::photometric(light.power(), wavelengths))
        }
        EmissionPower::Candela(candela) => {
            let seen = far_field_area(object, light.is_sphere()).ok_or_else(|| {
                let (what, value) = ("area light: surface with candela", object.surface().kind());
                range_error(location, what, value, "flat or a whole sphere; use lumens for others")
            })?;
            ("area light: candela", candela, units::photometric(light.radiance(), wavelengths) * seen)
        }
    };
    if !(wanted >= 0.0 && wanted.is_finite()) {
        return Err(range_error(location, what, wanted, "finite and not negative"));
    }
    if present.is_nan() || present <= 0.0 {
        let what = "area light: radiance to be scaled";
        return Err(range_error(location, what, present, "positive, on a surface of known area"));
    }
    Ok(light.scaled((wanted / present) as f32))
}

/// The pictures of surfaces that emit light, each made once.
pub(super) struct EmissionPictures<'a> {
    images: &'a [ImageDescription],
    budget: &'a ResourceBudget,
    made: BTreeMap<usize, Arc<FlatImage>>,
}

impl<'a> EmissionPictures<'a> {
    /// `images`: those of the description; `budget`: that of their memory.
    pub(super) fn new(images: &'a [ImageDescription], budget: &'a ResourceBudget) -> Self {
        Self { images, budget, made: BTreeMap::new() }
    }

    fn get(&mut self, index: usize, location: Option<Location>) -> Result<Arc<FlatImage>, SceneError> {
        if let Some(made) = self.made.get(&index) {
            return Ok(Arc::clone(made));
        }
        let error = |kind| SceneError { location, kind };
        let picture = picture_of(self.images, index).map_err(error)?;
        let [width, height] = picture.size();
        spend(self.budget, 0, BYTES_PER_TEXEL.saturating_mul((width * height) as u64), location)?;
        let image = FlatImage::of_picture(picture, Spectrum::ONE);
        let image = Arc::new(image.map_err(|fault| error(BudgetError::from(fault).into()))?);
        self.made.insert(index, Arc::clone(&image));
        Ok(image)
    }
}

/// The emission of each object of one shape: the power of the shape is divided among them by area.
pub(super) fn emission_per_object(
    emission: &EmissionDescription,
    objects: &[SceneObject],
    location: Option<Location>,
) -> Result<Vec<EmissionDescription>, SceneError> {
    let (Some(power), [_, _, ..]) = (emission.power, objects) else {
        return Ok(vec![emission.clone(); objects.len()]);
    };
    let areas: Vec<f64> = objects.iter().map(|object| area(object).unwrap_or(0.0)).collect();
    let whole: f64 = areas.iter().sum();
    let of = |share: f64| match power {
        EmissionPower::Watts(watts) => Ok(EmissionPower::Watts(watts * share as f32)),
        EmissionPower::Lumens(lumens) => Ok(EmissionPower::Lumens(lumens * share)),
        EmissionPower::Candela(_) => {
            let (what, range) = ("area light: number of surfaces with candela", "1; use lumens for more");
            Err(range_error(location, what, objects.len(), range))
        }
    };
    let with = |share| Ok(EmissionDescription { power: Some(of(share)?), ..emission.clone() });
    areas.iter().map(|area| with(area / whole)).collect()
}
