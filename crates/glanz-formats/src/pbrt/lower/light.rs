//! `LightSource` and `AreaLightSource`.

use std::f64::consts::PI;
use std::rc::Rc;

use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_light::{Pixels, SpectralDistribution};
use glanz_math::DVec3;
use glanz_scene::description::{
    EmissionDescription, EmissionPower, LightDescription, LightKind, SpotFalloff,
};

use super::spectrum::{EmissionParameters, within_gamut};
use super::{EntityState, FileError, Lowering};
use crate::image::{self, Encoding};
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{ParseResult, Span};

impl Lowering {
    /// Adds a light.
    pub(crate) fn light(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<()> {
        let (kind, emission) = match kind {
            "point" => self.point(&mut list, context)?,
            "spot" => self.spot(&mut list, context)?,
            "photometric" => self.photometric(&mut list, context)?,
            "distant" => self.distant(&mut list, context)?,
            "infinite" | "exinfinite" => self.infinite(&mut list, context)?,
            "goniometric" | "projection" => {
                let message = format!("light {kind:?} is not available yet; a point light stands in");
                self.stand_in(&list.place, "stand-in-light", message);
                list.ignore(&["filename", "mapname", "fov"]);
                self.point(&mut list, context)?
            }
            other => {
                let message = format!("light {:?} is unknown and left out", shortened(other));
                self.stand_in(&list.place, "stand-in-light", message);
                return Ok(());
            }
        };
        list.ignore(&["nsamples", "samples", "shadowquality"]);
        self.description.lights.push(LightDescription {
            kind,
            scale: emission.scale(),
            emission: emission.spectrum,
            to_world: context.ctm,
            location: Some(list.place.location),
        });
        list.finish(&mut self.reporter);
        Ok(())
    }

    fn ends(&mut self, list: &mut ParameterList) -> ParseResult<(DVec3, DVec3)> {
        let r = &mut self.reporter;
        let from = list.vec3("from", r)?.unwrap_or(DVec3::ZERO);
        let to = list.vec3("to", r)?.unwrap_or(DVec3::Z);
        Ok((from, to))
    }

    fn point(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<LightParts> {
        let from = list.vec3("from", &mut self.reporter)?.unwrap_or(DVec3::ZERO);
        let range = list.float("range", &mut self.reporter)?;
        let mut light = self.emission(list, "I", context.color_space)?;
        self.power(list, &mut light, 4.0 * PI)?;
        Ok((LightKind::Point { from, range }, light))
    }

    fn spot(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<LightParts> {
        let (from, to) = self.ends(list)?;
        let cone = list.float_or("coneangle", 30.0, &mut self.reporter)?;
        let delta = list.float_or("conedeltaangle", 5.0, &mut self.reporter)?;
        let inner = (cone - delta).max(0.0);
        let mut light = self.emission(list, "I", context.color_space)?;
        let (falloff, falling) = match self.dialect {
            // The mean over the falloff: 1/5 for the fourth power, 1/2 for the cubic step.
            Dialect::V3 => (SpotFalloff::Quartic, 0.2),
            Dialect::V4 => (SpotFalloff::Smoothstep, 0.5),
        };
        let (cos_end, cos_start) = (cone.to_radians().cos(), inner.to_radians().cos());
        let solid_angle = 2.0 * PI * ((1.0 - cos_start) + falling * (cos_start - cos_end));
        self.power(list, &mut light, solid_angle)?;
        let (cone_angle, inner_angle) = (cone.to_radians(), inner.to_radians());
        Ok((LightKind::Spot { from, to, cone_angle, inner_angle, falloff }, light))
    }

    fn distant(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<LightParts> {
        let (from, to) = self.ends(list)?;
        let mut light = self.emission(list, "L", context.color_space)?;
        self.illuminance(list, &mut light, 1.0)?;
        let angle = list.float_or("angle", 0.0, &mut self.reporter)?;
        if angle == 0.0 {
            return Ok((LightKind::Distant { from, to }, light));
        }
        Ok((LightKind::Sun { from, to, angular_radius: 0.5 * angle.to_radians() }, light))
    }

    fn infinite(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<LightParts> {
        let mut light = self.emission(list, "L", context.color_space)?;
        let mut file = None;
        for name in ["filename", "mapname"] {
            if let Some(found) = list.text_parameter(name, &mut self.reporter)? {
                file = Some(found);
            }
        }
        if let Some((p, name)) = file.filter(|(_, name)| !name.is_empty()) {
            match self.mean_radiance(&name) {
                Ok(mean) => {
                    let message = format!(
                        "light \"infinite\" with the picture {name:?} is not available yet; its mean of \
                         ({:.3}, {:.3}, {:.3}) in all directions stands in",
                        mean[0], mean[1], mean[2]
                    );
                    self.stand_in(&p.value_place, "stand-in-light", message);
                    let [r, g, b] = within_gamut(&light.spectrum);
                    light.spectrum = SpectralDistribution::Rgb([mean[0] * r, mean[1] * g, mean[2] * b]);
                }
                Err(problem) => {
                    let message =
                        format!("light \"infinite\": {problem}; the same light in all directions stands in");
                    self.without_file(&p.value_place, &problem, message)?;
                }
            }
        }
        self.illuminance(list, &mut light, PI)?;
        let portal = list.value_place("portal");
        if list.take("portal").is_some() {
            self.stand_in(&portal, "stand-in-light", "light \"infinite\": the portal is not used");
        }
        Ok((LightKind::Infinite, light))
    }

    /// Scales a light to the `power` of version 4, to its `lumens`, or to `candela` along its axis; `solid_angle` is
    /// the integral of its intensity divided by the intensity along the axis.
    fn power(
        &mut self,
        list: &mut ParameterList,
        light: &mut EmissionParameters,
        solid_angle: f64,
    ) -> ParseResult<()> {
        self.only_one(list, &["power", "lumens", "candela"])?;
        self.target(list, "power", light, solid_angle)?;
        self.photometric_target(list, "lumens", light, LUMINOUS_EFFICACY * solid_angle)?;
        self.photometric_target(list, "candela", light, LUMINOUS_EFFICACY)
    }

    /// Refuses a second parameter that sets the brightness of a light.
    fn only_one(&mut self, list: &ParameterList, names: &[&str]) -> ParseResult<()> {
        let mut given = names.iter().filter(|name| list.has(name));
        let (Some(first), Some(second)) = (given.next(), given.next()) else { return Ok(()) };
        let message = format!("{}: {first:?} and {second:?} both set the brightness", list.subject);
        let (place, help) = (list.value_place(second), Some("give one of them".to_owned()));
        Err(self.reporter.error_with_help(&place, "parameter-conflict", message, help))
    }

    /// As [`Lowering::target`], for a number that must not be negative and may be 0.
    fn photometric_target(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        light: &mut EmissionParameters,
        per_unit: f64,
    ) -> ParseResult<()> {
        let place = list.value_place(name);
        match self.not_negative(list, name)? {
            Some(target) => self.scale_to(list, &place, name, light, target / per_unit),
            None => Ok(()),
        }
    }

    /// A number that is not negative.
    pub(super) fn not_negative(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
    ) -> ParseResult<Option<f64>> {
        let place = list.value_place(name);
        match list.float(name, &mut self.reporter)? {
            Some(value) if value < 0.0 => {
                let message = format!("{}: {name:?} is {value}; it must not be negative", list.subject);
                Err(self.reporter.error(&place, "parameter-range", message))
            }
            value => Ok(value),
        }
    }

    /// Scales a light to the `illuminance` of version 4 on a surface that faces it; `per_radiance` is the illuminance of a light
    /// of radiance 1.
    fn illuminance(
        &mut self,
        list: &mut ParameterList,
        light: &mut EmissionParameters,
        per_radiance: f64,
    ) -> ParseResult<()> {
        self.target(list, "illuminance", light, per_radiance)
    }

    fn target(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        light: &mut EmissionParameters,
        per_unit: f64,
    ) -> ParseResult<()> {
        let place = list.value_place(name);
        let Some(target) = list.float(name, &mut self.reporter)? else { return Ok(()) };
        if target <= 0.0 {
            // pbrt treats this as not given.
            return Ok(());
        }
        self.scale_to(list, &place, name, light, target / per_unit)
    }

    /// Scales a light to the luminance `target` of the parameter `name`, before its `scale`.
    fn scale_to(
        &mut self,
        list: &ParameterList,
        place: &Span,
        name: &str,
        light: &mut EmissionParameters,
        target: f64,
    ) -> ParseResult<()> {
        let luminance = f64::from(light.spectrum.luminance());
        if luminance <= 0.0 || !target.is_finite() {
            let message = format!("{}: a black light cannot have {name:?}", list.subject);
            return Err(self.reporter.error(place, "parameter-range", message));
        }
        // The spectrum's own magnitude is removed; `scale` remains as a factor.
        light.normalisation = (target / luminance) as f32;
        Ok(())
    }

    /// The mean of a picture over the sphere of directions: a square picture is version 4's equal-area map, others are in
    /// longitude and latitude.
    fn mean_radiance(&mut self, name: &str) -> Result<[f32; 3], FileError> {
        let (path, bytes) = self.read_file(name)?;
        let picture = image::read(&bytes, Some(&path), Encoding::Srgb)
            .map_err(|error| format!("picture {name:?}: {error}"))?;
        mean_over_sphere(&picture.pixels).ok_or_else(|| {
            format!("picture {name:?} has neither the channels R, G, B nor the channel Y").into()
        })
    }

    /// Sets the emission of the following shapes.
    pub(crate) fn area_light(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<Rc<EmissionDescription>> {
        if !matches!(kind, "diffuse" | "area") {
            let message = format!("area light {:?} is unknown; \"diffuse\" stands in", shortened(kind));
            self.stand_in(&list.place, "stand-in-light", message);
        }
        let mut light = self.emission(&mut list, "L", context.color_space)?;
        let two_sided = list.boolean("twosided", &mut self.reporter)?.unwrap_or(false);
        let place = list.value_place("filename");
        if list.text("filename", &mut self.reporter)?.is_some_and(|f| !f.is_empty()) {
            let message = "area light: light with a picture is not available yet; \"L\" stands in";
            self.stand_in(&place, "stand-in-light", message);
        }
        let power = self.emission_power(&mut list, &mut light)?;
        list.ignore(&["nsamples", "samples"]);
        list.finish(&mut self.reporter);
        let scale = light.scale();
        Ok(Rc::new(EmissionDescription { radiance: light.spectrum, scale, power, two_sided }))
    }
}

impl Lowering {
    /// `power`, `lumens` or `candela`, with the factor `scale` as in pbrt; `nits` become the radiance of `light`.
    fn emission_power(
        &mut self,
        list: &mut ParameterList,
        light: &mut EmissionParameters,
    ) -> ParseResult<Option<EmissionPower>> {
        self.only_one(list, &["power", "lumens", "candela", "nits"])?;
        self.photometric_target(list, "nits", light, LUMINOUS_EFFICACY)?;
        let factor = f64::from(light.factor);
        // pbrt treats a power that is not positive as not given.
        let watts = list.float("power", &mut self.reporter)?.filter(|p| *p > 0.0);
        let watts = watts.map(|p| EmissionPower::Watts(p as f32 * light.factor));
        let lumens = self.not_negative(list, "lumens")?.map(|l| EmissionPower::Lumens(l * factor));
        let candela = self.not_negative(list, "candela")?.map(|c| EmissionPower::Candela(c * factor));
        Ok(watts.or(lumens).or(candela))
    }
}

pub(super) type LightParts = (LightKind, EmissionParameters);

/// Mean over the sphere; pixels that are not finite count as black. `None` without colour channels.
fn mean_over_sphere(pixels: &Pixels) -> Option<[f32; 3]> {
    let rgb = pixels.to_rgb()?;
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let mut sum = [0.0f64; 3];
    let mut weights = 0.0;
    for (y, row) in rgb.chunks_exact(width).enumerate() {
        // The width of rows in longitude and latitude is proportional to the sine of their angle from the pole.
        let weight = if width == height { 1.0 } else { (PI * (y as f64 + 0.5) / height as f64).sin() };
        for pixel in row.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            for (s, x) in sum.iter_mut().zip(pixel) {
                *s += weight * f64::from(x.max(0.0));
            }
        }
        weights += weight * width as f64;
    }
    Some(sum.map(|s| (s / weights) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_a_sky_over_black_ground_is_half_the_sky() {
        // Ten rows, the upper five white: by symmetry half of the sphere.
        let rgb: Vec<[f32; 3]> = (0..200).map(|i| if i < 100 { [2.0, 4.0, 6.0] } else { [0.0; 3] }).collect();
        let mean = mean_over_sphere(&Pixels::try_from_rgb(20, 10, &rgb).unwrap()).unwrap();
        for (found, expected) in mean.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn pole_has_less_weight_than_the_equator_except_in_equal_area_maps() {
        let of = |width: u32, height: u32| {
            let count = (width * height) as usize;
            let rgb: Vec<[f32; 3]> =
                (0..count).map(|i| [f32::from(u8::from(i < width as usize)); 3]).collect();
            f64::from(mean_over_sphere(&Pixels::try_from_rgb(width, height, &rgb).unwrap()).unwrap()[0])
        };
        // Three rows at 30, 90 and 150 degrees: 1/2, 1, 1/2.
        assert!((of(6, 3) - 0.25).abs() < 1e-7);
        assert!((of(3, 3) - 1.0 / 3.0).abs() < 1e-7);
    }
}
