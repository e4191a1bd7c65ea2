//! `Film` and `PixelFilter`.

use glanz_scene::description::{
    FilmDescription, FilterDescription, FilterKind, SampleLimit, SensorDescription,
};

use super::Lowering;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

/// Parameters of films without effect on the values of a picture.
const OF_NO_INFLUENCE: &[&str] = &[
    "savefp16",
    "coordinatesystem",
    "buckets",
    "nbuckets",
    "lambdamin",
    "lambdamax",
    "premultiplyalpha",
    "writefrequency",
    "display",
];

fn default_resolution(dialect: Dialect) -> [u32; 2] {
    match dialect {
        Dialect::V3 => [640, 480],
        Dialect::V4 => [1280, 720],
    }
}

fn default_filter(dialect: Dialect) -> FilterDescription {
    match dialect {
        Dialect::V3 => FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] },
        Dialect::V4 => FilterDescription { kind: FilterKind::Gaussian { sigma: 0.5 }, radius: [1.5, 1.5] },
    }
}

/// Sets unspecified parameters to the defaults of the dialect, and the exposure to that of film and shutter.
pub(crate) fn finish_film(lowering: &mut Lowering) {
    if !lowering.has_film {
        lowering.description.film.resolution = default_resolution(lowering.dialect);
    }
    let sensor = &mut lowering.description.film.sensor;
    sensor.exposure *= lowering.exposure_time.unwrap_or(lowering.shutter_time);
    // Version 3 limits samples before it scales the picture.
    if let SampleLimit::Luminance(limit) = &mut sensor.limit {
        *limit *= sensor.exposure;
    }
    if !lowering.has_filter {
        lowering.description.filter = default_filter(lowering.dialect);
    }
}

impl Lowering {
    /// Lowers the size and the crop window of the picture.
    pub(crate) fn film(&mut self, kind: &str, mut list: ParameterList) -> ParseResult<()> {
        let place = list.place;
        let r = &mut self.reporter;
        if !matches!(kind, "image" | "rgb" | "gbuffer" | "spectral") {
            let message = format!("film {:?} is unknown; \"image\" stands in", shortened(kind));
            r.stand_in(&place, "stand-in-film", message);
        }
        let [width, height] = default_resolution(self.dialect);
        let resolution = [
            list.integer_from("xresolution", 1, r)?.unwrap_or(width),
            list.integer_from("yresolution", 1, r)?.unwrap_or(height),
        ];
        let file_name = list.text("filename", r)?;
        let crop = self.crop(&mut list, resolution)?;
        let sensor = self.sensor(&mut list)?;
        let diagonal = self.positive(&mut list, "diagonal")?.unwrap_or(35.0) * 1e-3;
        list.ignore(OF_NO_INFLUENCE);
        list.finish(&mut self.reporter);
        let location = Some(place.location);
        self.description.film = FilmDescription { resolution, crop, diagonal, sensor, file_name, location };
        self.has_film = true;
        Ok(())
    }

    /// The sensor, without the time of the exposure, its limit of luminance before the exposure.
    fn sensor(&mut self, list: &mut ParameterList) -> ParseResult<SensorDescription> {
        let scale = self.positive(list, "scale")?.unwrap_or(1.0);
        let iso = self.positive(list, "iso")?.unwrap_or(100.0);
        self.exposure_time = self.positive(list, "exposuretime")?;
        if let Some((p, name)) = list.text_parameter("sensor", &mut self.reporter)?
            && name != "cie1931"
        {
            let message =
                format!("film: the sensor {:?} is not available; \"cie1931\" stands in", shortened(&name));
            self.stand_in(&p.value_place, "stand-in-film", message);
        }
        let place = list.value_place("whitebalance");
        // 0 is no adaptation.
        let white_balance = list.float("whitebalance", &mut self.reporter)?.filter(|&kelvin| kelvin != 0.0);
        if let Some(kelvin) = white_balance.filter(|kelvin| !(1000.0..=25_000.0).contains(kelvin)) {
            let message =
                format!("film: \"whitebalance\" is {kelvin} K; it must be between 1000 and 25000 K, or 0");
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        let component = self.positive(list, "maxcomponentvalue")?.map(SampleLimit::Component);
        let luminance = self.positive(list, "maxsampleluminance")?.map(SampleLimit::Luminance);
        let limit = component.or(luminance).unwrap_or(SampleLimit::None);
        Ok(SensorDescription { exposure: scale * iso / 100.0, white_balance, limit })
    }

    /// A positive number.
    fn positive(&mut self, list: &mut ParameterList, name: &'static str) -> ParseResult<Option<f64>> {
        let place = list.value_place(name);
        let value = list.float(name, &mut self.reporter)?;
        if let Some(value) = value.filter(|&value| value <= 0.0) {
            let message = format!("film: {name:?} is {value}; it must be positive");
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        Ok(value)
    }

    /// The part of the picture to render, as fractions: `cropwindow`, or `pixelbounds` if there are both.
    fn crop(&mut self, list: &mut ParameterList, resolution: [u32; 2]) -> ParseResult<[f64; 4]> {
        let r = &mut self.reporter;
        let mut crop = [0.0, 1.0, 0.0, 1.0];
        let crop_place = list.value_place("cropwindow");
        if let Some(window) = list.float_array::<4>("cropwindow", r)? {
            // pbrt accepts the bounds of an axis in either order.
            crop = [
                window[0].min(window[1]).clamp(0.0, 1.0),
                window[0].max(window[1]).clamp(0.0, 1.0),
                window[2].min(window[3]).clamp(0.0, 1.0),
                window[2].max(window[3]).clamp(0.0, 1.0),
            ];
        }
        let bounds_place = list.value_place("pixelbounds");
        let mut cut_place = crop_place;
        if let Some((p, bounds)) = list.integers("pixelbounds", r)? {
            let [x0, x1, y0, y1] = bounds[..] else {
                let message =
                    format!("film: parameter {:?} has {} values; 4 are needed", p.name, bounds.len());
                return Err(r.error(&bounds_place, "parameter-count", message));
            };
            let [w, h] = resolution.map(f64::from);
            let share = |x: i32, of: f64| (f64::from(x) / of).clamp(0.0, 1.0);
            crop = [share(x0, w), share(x1, w), share(y0, h), share(y1, h)];
            cut_place = bounds_place;
        }
        if crop[0] >= crop[1] || crop[2] >= crop[3] {
            let message = "film: the part of the picture to render is empty";
            return Err(r.error(&cut_place, "parameter-range", message));
        }
        Ok(crop)
    }

    /// Lowers the pixel filter.
    pub(crate) fn filter(&mut self, kind: &str, mut list: ParameterList) -> ParseResult<()> {
        let place = list.place;
        let v4 = self.dialect == Dialect::V4;
        let r = &mut self.reporter;
        let (radius, kind) = match kind {
            "box" => (0.5, FilterKind::Box),
            "triangle" => (2.0, FilterKind::Triangle),
            "gaussian" => {
                // Version 3 has exp(-alpha d^2) with alpha 2, which is also the default of version 4.
                let alpha = list.float("alpha", r)?;
                let of_alpha = alpha.map(|a| 1.0 / (2.0 * a).sqrt());
                let sigma = list.float("sigma", r)?.or(of_alpha).unwrap_or(0.5);
                if !(sigma.is_finite() && sigma > 0.0) {
                    let message = "filter \"gaussian\": the standard deviation must be positive";
                    return Err(r.error(&place, "parameter-range", message));
                }
                (if v4 { 1.5 } else { 2.0 }, FilterKind::Gaussian { sigma })
            }
            "mitchell" => {
                let (b, c) = (list.float("B", r)?, list.float("C", r)?);
                let third = 1.0 / 3.0;
                (2.0, FilterKind::Mitchell { b: b.unwrap_or(third), c: c.unwrap_or(third) })
            }
            "cylinder" => (0.5, FilterKind::Cylinder),
            "pyramid" => (1.0, FilterKind::Pyramid),
            "cone" => (1.0, FilterKind::Cone),
            "sinc" => {
                let tau = list.float_or("tau", 3.0, r)?;
                if tau <= 0.0 {
                    let message = format!("filter \"sinc\": \"tau\" is {tau}; it must be positive");
                    return Err(r.error(&place, "parameter-range", message));
                }
                (4.0, FilterKind::Sinc { tau })
            }
            other => {
                let message =
                    format!("filter {:?} is unknown; \"mitchell\" of radius 2 stands in", shortened(other));
                r.stand_in(&place, "stand-in-filter", message);
                list.ignore(&["tau", "xwidth", "ywidth", "xradius", "yradius"]);
                (2.0, FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 })
            }
        };
        let radius = self.radii(&mut list, radius)?;
        list.finish(&mut self.reporter);
        self.description.filter = FilterDescription { kind, radius };
        self.has_filter = true;
        Ok(())
    }

    /// Half the width of the support of a filter along x and y, pixels.
    fn radii(&mut self, list: &mut ParameterList, default: f64) -> ParseResult<[f64; 2]> {
        let r = &mut self.reporter;
        let mut radii = [default; 2];
        for (i, names) in [["xradius", "xwidth"], ["yradius", "ywidth"]].into_iter().enumerate() {
            for name in names {
                let value_place = list.value_place(name);
                if let Some(x) = list.float(name, r)? {
                    if x <= 0.0 {
                        let message = format!("filter: {name:?} is {x}; it must be positive");
                        return Err(r.error(&value_place, "parameter-range", message));
                    }
                    radii[i] = x;
                }
            }
        }
        Ok(radii)
    }
}
