//! `LightSource` and `AreaLightSource`.

use std::f64::consts::PI;
use std::rc::Rc;

use glanz_job::Resource;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{
    EmissionDescription, EmissionPower, LightDescription, LightKind, SpotFalloff,
};

use super::spectrum::EmissionParameters;
use super::{EntityState, Lowering};
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
        let free = self.free_position(&mut list, kind)?;
        let mut luminaire = None;
        let (kind, emission) = match kind {
            "sky" => {
                self.sky(&mut list, context)?;
                list.finish(&mut self.reporter);
                return Ok(());
            }
            "point" => self.point(&mut list, context)?,
            "spot" => self.spot(&mut list, context)?,
            "photometric" => self.photometric(&mut list, context, &mut luminaire)?,
            "distant" => self.distant(&mut list, context)?,
            "infinite" | "exinfinite" => self.infinite(&mut list, context)?,
            "projection" => self.projection(&mut list, context)?,
            "goniometric" | "goniophotometric" => self.goniometric(&mut list, context)?,
            other => {
                let message = format!("light {:?} is unknown and left out", shortened(other));
                self.stand_in(&list.place, "stand-in-light", message);
                return Ok(());
            }
        };
        list.ignore(&["nsamples", "samples", "shadowquality"]);
        let to_world = match (&kind, self.dialect) {
            // Version 3 projects pictures upside down.
            (LightKind::Projection { .. }, Dialect::V3) => {
                context.ctm * DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0))
            }
            _ => context.ctm,
        };
        self.spend_light(&list.place)?;
        self.description.design.variables.extend(free);
        self.description.lights.push(LightDescription {
            kind,
            scale: emission.scale(),
            emission: emission.spectrum,
            to_world,
            luminaire,
            location: Some(list.place.location),
        });
        list.finish(&mut self.reporter);
        Ok(())
    }

    /// Takes a light off the budget.
    pub(super) fn spend_light(&mut self, place: &Span) -> ParseResult<()> {
        self.reporter.spend(place, Resource::Objects, 1)?;
        self.spend_entry::<LightDescription>("", place)
    }

    fn ends(&mut self, list: &mut ParameterList) -> ParseResult<(DVec3, DVec3)> {
        let r = &mut self.reporter;
        let from = list.vec3("from", r)?.unwrap_or(DVec3::ZERO);
        let to = list.vec3("to", r)?.unwrap_or(DVec3::Z);
        Ok((from, to))
    }

    pub(super) fn point(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<LightParts> {
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

    /// Scales a light to the `illuminance` of version 4, lx, on a surface that faces it; `irradiance`: that of a light of radiance 1.
    pub(super) fn illuminance(
        &mut self,
        list: &mut ParameterList,
        light: &mut EmissionParameters,
        irradiance: f64,
    ) -> ParseResult<()> {
        self.target(list, "illuminance", light, LUMINOUS_EFFICACY * irradiance)
    }

    pub(super) fn target(
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
    pub(super) fn scale_to(
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
        let image = self.light_picture(&mut list, "\"L\" alone stands in")?;
        let power = self.emission_power(&mut list, &mut light)?;
        list.ignore(&["nsamples", "samples"]);
        list.finish(&mut self.reporter);
        let scale = light.scale();
        Ok(Rc::new(EmissionDescription { radiance: light.spectrum, scale, image, power, two_sided }))
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
