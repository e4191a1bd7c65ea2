//! Daylight: a clear sky and its sun, by direction or by place and time, or an overcast sky.

use std::fmt::Display;

use chrono::DateTime;
use glanz_light::sky::SUN_RADIUS;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_light::{ClearSky, Wavelengths};
use glanz_math::DVec3;
use glanz_scene::description::{LightDescription, LightKind, SkyDescription};
use solar_positioning::{Location, SolarPositions, delta_t};

use super::{EntityState, Lowering};
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::source::{ParseResult, ReportedError, Span};

const DEFAULT_TURBIDITY: f64 = 3.0;
const DEFAULT_ALBEDO: f32 = 0.2;

/// Of the open ground under an overcast sky, lx.
const DEFAULT_ILLUMINANCE: f64 = 10_000.0;

/// Largest number of skies: each is a picture.
const MOST_SKIES: usize = 16;

impl Lowering {
    /// Adds a sky and its sun; in light space x is east, y north and z up.
    pub(super) fn sky(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<()> {
        let place = list.place;
        self.skies += 1;
        if self.skies > MOST_SKIES {
            let message = format!("{}: there are more than {MOST_SKIES} skies", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        let weather_place = list.value_place("weather");
        match list.text("weather", &mut self.reporter)?.as_deref() {
            None | Some("clear") => {}
            Some("overcast") => return self.overcast_sky(list, context),
            Some(other) => {
                let other = shortened(other);
                let message = format!(
                    "{}: \"weather\" is \"{other}\"; it must be \"clear\" or \"overcast\"",
                    list.subject
                );
                return Err(self.reporter.error(&weather_place, "parameter-range", message));
            }
        }
        let towards_sun = self.towards_sun(list)?;
        let turbidity = list.float_or("turbidity", DEFAULT_TURBIDITY, &mut self.reporter)?;
        let albedo = self.ground_albedo(list, context)?;
        let has_sun = list.boolean("sun", &mut self.reporter)?.unwrap_or(true);
        let scale = self.not_negative(list, "scale")?.unwrap_or(1.0) as f32;
        let model = ClearSky::try_new(towards_sun, turbidity, albedo)
            .map_err(|problem| self.refuse_sky(&place, list, &problem))?;
        let sky = SkyDescription { towards_sun, turbidity, albedo, is_ground_sunlit: has_sun };
        let light = |kind, emission| LightDescription {
            kind,
            emission,
            scale,
            to_world: context.ctm,
            luminaire: None,
            location: Some(place.location),
        };
        self.spend_light(&place)?;
        self.description.lights.push(light(LightKind::Sky(sky), 1.0.into()));
        if has_sun {
            let disk = LightKind::Sun { from: towards_sun, to: DVec3::ZERO, angular_radius: SUN_RADIUS };
            self.spend_light(&place)?;
            self.description.lights.push(light(disk, model.sun_irradiance().clone()));
        }
        Ok(())
    }

    /// Adds an overcast sky.
    fn overcast_sky(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<()> {
        let albedo = self.ground_albedo(list, context)?;
        let scale = self.not_negative(list, "scale")?.unwrap_or(1.0) as f32;
        let illuminance = self.not_negative(list, "illuminance")?.unwrap_or(DEFAULT_ILLUMINANCE);
        let irradiance = (illuminance / LUMINOUS_EFFICACY) as f32;
        self.spend_light(&list.place)?;
        self.description.lights.push(LightDescription {
            kind: LightKind::OvercastSky { albedo },
            emission: irradiance.into(),
            scale,
            to_world: context.ctm,
            luminaire: None,
            location: Some(list.place.location),
        });
        Ok(())
    }

    /// The unit direction to the sun: `direction`, or by `latitude`, `longitude` and `time`.
    fn towards_sun(&mut self, list: &mut ParameterList) -> ParseResult<DVec3> {
        let by_time = ["latitude", "longitude", "time"];
        let place = list.value_place("direction");
        let direction = list.vec3("direction", &mut self.reporter)?;
        let given = by_time.iter().filter(|name| list.has(name)).count();
        let time = list.text_parameter("time", &mut self.reporter)?;
        match (direction, given, time) {
            (Some(direction), 0, _) => direction.try_normalize().ok_or_else(|| {
                let message = format!("{}: \"direction\" is {direction}; it must not be 0", list.subject);
                self.reporter.error(&place, "parameter-range", message)
            }),
            (None, 3, Some((p, time))) => self.sun_at_time(list, &p, &time),
            _ => {
                let message = format!(
                    "{}: the position of the sun is missing, incomplete or given twice",
                    list.subject
                );
                let help = "give either \"vector3 direction\", or \"float latitude\", \"float longitude\" and \"string time\"";
                Err(self.reporter.error_with_help(
                    &list.place,
                    "parameter-missing",
                    message,
                    Some(help.to_owned()),
                ))
            }
        }
    }

    fn sun_at_time(
        &mut self,
        list: &mut ParameterList,
        time_parameter: &Parameter,
        text: &str,
    ) -> ParseResult<DVec3> {
        let place = list.place;
        let latitude = list.float_or("latitude", 0.0, &mut self.reporter)?;
        let longitude = list.float_or("longitude", 0.0, &mut self.reporter)?;
        let time = DateTime::parse_from_rfc3339(text).map_err(|problem| {
            let message = format!("{}: \"time\" is {:?}: {problem}", list.subject, shortened(text));
            let help = "write date, time and offset from UTC as \"2026-06-21T12:00:00+02:00\"".to_owned();
            self.reporter.error_with_help(&time_parameter.value_place, "parameter-range", message, Some(help))
        })?;
        let position = delta_t::estimate_from_date_like(&time).and_then(|delta_t| {
            let location = Location { latitude, longitude };
            SolarPositions::new().at(&time, location, 0.0, delta_t, None)
        });
        let position = position.map_err(|problem| self.refuse_sky(&place, list, &problem))?;
        let (sin, cos) = position.azimuth().to_radians().sin_cos();
        let (up, level) = position.elevation_angle().to_radians().sin_cos();
        Ok(DVec3::new(level * sin, level * cos, up))
    }

    /// The albedo of the ground, linear Rec. 709.
    fn ground_albedo(&mut self, list: &mut ParameterList, context: &EntityState) -> ParseResult<[f32; 3]> {
        let Some(p) = list.take("albedo") else { return Ok([DEFAULT_ALBEDO; 3]) };
        let albedo = self.distribution(&list.subject, &p, context.color_space)?;
        Ok(albedo.unbounded(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb))
    }

    fn refuse_sky(&mut self, place: &Span, list: &ParameterList, problem: &dyn Display) -> ReportedError {
        self.reporter.error(place, "parameter-range", format!("{}: {problem}", list.subject))
    }
}
