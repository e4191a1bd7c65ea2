//! Lights with pictures.

use std::f64::consts::PI;

use glanz_job::ScratchFileError;
use glanz_light::SpectralDistribution;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{LightKind, SphereMapping};
use glanz_scene::light::{ProjectionLight, SphereImage};
use glanz_shading::texture::MipMap;

use super::light::LightParts;
use super::spectrum::{EmissionParameters, within_gamut};
use super::{EntityState, Lowering};
use crate::image::Encoding;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::ParameterList;
use crate::source::{ParseResult, Span};

/// Angle of the shorter side of a projected picture, degrees.
const DEFAULT_FIELD_OF_VIEW: f64 = 90.0;

impl Lowering {
    pub(super) fn infinite(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<LightParts> {
        let mut light = self.emission(list, "L", context.color_space)?;
        let picture = self.light_picture(list, "the same light in all directions stands in")?;
        let image = picture.map(|image| (image, self.mapping_of(image)));
        match image {
            Some((image, mapping)) => self.illuminance_of_picture(list, &mut light, image, mapping)?,
            None => self.illuminance(list, &mut light, PI)?,
        }
        let portal = self.portal(list)?;
        let kind = match (portal, image) {
            (Some(portal), image) => LightKind::PortalInfinite { image, portal },
            (None, Some((image, mapping))) => LightKind::ImageInfinite { image, mapping },
            (None, None) => LightKind::Infinite,
        };
        Ok((kind, light))
    }

    /// The corners of the rectangle through which light arrives.
    fn portal(&mut self, list: &mut ParameterList) -> ParseResult<Option<[DVec3; 4]>> {
        let place = list.value_place("portal");
        let Some((_, points)) = list.vec3s("portal", &mut self.reporter)? else { return Ok(None) };
        match <[DVec3; 4]>::try_from(points) {
            Ok(corners) => Ok(Some(corners)),
            Err(points) => {
                let message =
                    format!("{}: \"portal\" has {} points; 4 are needed", list.subject, points.len());
                Err(self.reporter.error(&place, "parameter-count", message))
            }
        }
    }

    /// The picture of a light; `None` without one, and after a report if it cannot be read.
    pub(super) fn light_picture(
        &mut self,
        list: &mut ParameterList,
        stand_in: &str,
    ) -> ParseResult<Option<usize>> {
        let mut file: Option<(Span, String)> = None;
        for name in ["filename", "mapname"] {
            if let Some((p, name)) = list.text_parameter(name, &mut self.reporter)? {
                file = Some((p.value_place, name));
            }
        }
        let Some((place, name)) = file.filter(|(_, name)| !name.is_empty()) else { return Ok(None) };
        match self.picture(&name, Encoding::Srgb) {
            Ok(index) => Ok(Some(index)),
            Err(problem) => {
                let message = format!("{}: {problem}; {stand_in}", list.subject);
                self.without_file(&place, &problem, message)?;
                Ok(None)
            }
        }
    }

    /// The mapping of a picture over all directions: in version 4, square pictures have equal areas.
    fn mapping_of(&self, image: usize) -> SphereMapping {
        let size = self.description.images.get(image).map(|image| image.picture.size());
        let is_square = size.is_some_and(|[width, height]| width == height);
        match self.dialect {
            Dialect::V4 if is_square => SphereMapping::EqualArea,
            _ => SphereMapping::LatitudeLongitude,
        }
    }

    /// Scales a picture's light to the `illuminance` of version 4, lx, on a surface that faces its z axis.
    fn illuminance_of_picture(
        &mut self,
        list: &mut ParameterList,
        light: &mut EmissionParameters,
        image: usize,
        mapping: SphereMapping,
    ) -> ParseResult<()> {
        self.picture_target(list, "illuminance", light, image, |picture| {
            let irradiance = SphereImage::try_new(picture, mapping)?.irradiance();
            Ok(irradiance.map(|x| LUMINOUS_EFFICACY * x))
        })
    }

    /// Scales a picture's light to the luminance of version 4 of the parameter `name`; `integral`: of the picture.
    fn picture_target(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        light: &mut EmissionParameters,
        image: usize,
        integral: impl FnOnce(&MipMap) -> Result<[f64; 3], ScratchFileError>,
    ) -> ParseResult<()> {
        let picture = self.description.images.get(image).map(|image| image.picture.clone());
        let Some(picture) = picture.filter(|_| list.has(name)) else { return Ok(()) };
        let budget = self.finder.budget.clone();
        let [width, height] = picture.size();
        // Its colours, and as many numbers of a picture of the sphere.
        let reserved = budget.reserve(24 * (width as u64) * (height as u64));
        let integral = reserved.and_then(|_reservation| {
            integral(&picture).map_err(|fault| {
                budget.fail_with(fault.clone().into());
                fault.into()
            })
        });
        let integral = integral.map_err(|end| self.reporter.end(&list.place, end))?;
        let color = within_gamut(&light.spectrum);
        let lit = std::array::from_fn(|i| color[i] * integral[i] as f32);
        // The target is relative to the luminance of the light's own spectrum.
        let luminance = f64::from(SpectralDistribution::Rgb(lit).luminance());
        let per_unit = luminance / f64::from(light.spectrum.luminance());
        self.target(list, name, light, per_unit)
    }

    /// A projector; without its picture, a point light.
    pub(super) fn projection(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<LightParts> {
        let has_file = list.has("filename") || list.has("mapname");
        let picture = self.light_picture(list, "a point light stands in")?;
        let place = list.value_place("fov");
        let degrees = list.float_or("fov", DEFAULT_FIELD_OF_VIEW, &mut self.reporter)?;
        let Some(image) = picture else {
            if !has_file {
                let message = format!("{} has no picture; a point light stands in", list.subject);
                self.stand_in(&list.place, "stand-in-light", message);
            }
            return self.point(list, context);
        };
        if !(degrees > 0.0 && degrees < 180.0) {
            let message = format!("{}: \"fov\" is {degrees}; it must be between 0 and 180", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        let field_of_view = degrees.to_radians();
        let mut light = self.emission(list, "I", context.color_space)?;
        self.picture_target(list, "power", &mut light, image, |picture| {
            projected_power(picture, field_of_view)
        })?;
        Ok((LightKind::Projection { image, field_of_view }, light))
    }

    /// A point with a picture of its intensity; without it, a point light as in pbrt.
    pub(super) fn goniometric(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<LightParts> {
        let Some(image) = self.light_picture(list, "a point light stands in")? else {
            return self.point(list, context);
        };
        let mapping = self.mapping_of(image);
        let mut light = self.emission(list, "I", context.color_space)?;
        self.picture_target(list, "power", &mut light, image, |picture| {
            let mean = SphereImage::try_new(picture, mapping)?.mean();
            Ok(mean.map(|x| 4.0 * PI * f64::from(x)))
        })?;
        Ok((LightKind::Goniometric { image, mapping }, light))
    }
}

/// Integral over solid angle of a picture that is projected.
fn projected_power(picture: &MipMap, field_of_view: f64) -> Result<[f64; 3], ScratchFileError> {
    let [width, height] = picture.size();
    let (size, count) = ([width as u32, height as u32], (width * height) as f64);
    let texels = picture.to_rgb()?.into_iter().enumerate();
    Ok(integral(texels.map(|(i, rgb)| {
        let place = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let place = place / DVec2::new(f64::from(size[0]), f64::from(size[1]));
        (ProjectionLight::solid_angle_of_unit(size, field_of_view, place) / count, rgb)
    })))
}

/// Sum of colours, each with its weight; values that are negative or not finite count as black.
fn integral(values: impl Iterator<Item = (f64, [f32; 3])>) -> [f64; 3] {
    values.fold([0.0; 3], |sum, (weight, rgb)| {
        let positive = |x: f32| if x > 0.0 && x.is_finite() { f64::from(x) } else { 0.0 };
        std::array::from_fn(|i| sum[i] + weight * positive(rgb[i]))
    })
}

#[cfg(test)]
mod tests {
    use glanz_light::Pixels;

    use super::*;

    #[test]
    fn even_square_projected_under_a_right_angle_fills_a_sixth_of_the_sphere() {
        // The side of a cube, seen from its middle.
        let pixels = Pixels::try_from_rgb(64, 64, &[[1.0, 3.0, -1.0]; 4096]).unwrap();
        let sixth = 4.0 * PI / 6.0;
        let found = projected_power(&MipMap::try_new(&pixels).unwrap(), 0.5 * PI).unwrap();
        for (found, expected) in found.into_iter().zip([sixth, 3.0 * sixth, 0.0]) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
    }
}
