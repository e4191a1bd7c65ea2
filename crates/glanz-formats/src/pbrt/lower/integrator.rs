//! `Sampler` and `Integrator`.

use glanz_scene::description::{GuideSettings, IntegratorDescription, PhotonSettings, SamplerDescription};

use super::Lowering;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{ParseResult, Reporter};

/// Default for the largest number of scattering events of a path.
const DEFAULT_DEPTH: u32 = 5;

/// Parameters of other integrators, and those that affect the noise but not the expected picture.
const IGNORED: &[&str] = &[
    "regularize",
    "lightsampler",
    "lightsamplestrategy",
    "rrthreshold",
    "strategy",
    "samplebsdf",
    "radius",
    "photonsperiteration",
    "imagewritefrequency",
    "seed",
    "visualizestrategies",
    "visualizeweights",
    "bootstrapsamples",
    "chains",
    "mutationsperpixel",
    "largestepprobability",
    "sigma",
    "cossample",
    "maxdistance",
    "nsamples",
    "pixelbounds",
    "stepsize",
];

impl Lowering {
    /// Lowers the sampler. All of pbrt's low-discrepancy sequences become the best available one.
    pub(crate) fn sampler(&mut self, kind: &str, mut list: ParameterList) -> ParseResult<()> {
        let place = list.place;
        let r = &mut self.reporter;
        let seed = list.integer("seed", r)?.unwrap_or(0);
        let pixel_samples = list.integer_from("pixelsamples", 1, r)?;
        let name = match kind {
            "sobol" | "paddedsobol" | "zsobol" | "halton" | "pmj02bn" | "lowdiscrepancy" | "02sequence"
            | "maxmindist" | "bestcandidate" | "adaptive" => "sobol",
            "independent" | "random" => "independent",
            "stratified" => "stratified",
            "regular" => "regular",
            "center" => "center",
            other => {
                let message = format!("sampler {:?} is unknown; \"sobol\" stands in", shortened(other));
                r.stand_in(&place, "stand-in-sampler", message);
                "sobol"
            }
        };
        let grid_place = list.value_place("xsamples");
        let x = list.integer_from("xsamples", 1, r)?;
        let y = list.integer_from("ysamples", 1, r)?;
        let default = match name {
            "stratified" | "regular" => 16,
            "independent" => 4,
            "center" => 1,
            _ => 16,
        };
        let samples_per_pixel = match (x, y) {
            (None, None) => pixel_samples.unwrap_or(default),
            (x, y) => match x.unwrap_or(4).checked_mul(y.unwrap_or(4)) {
                Some(n) => n,
                None => {
                    let message = "sampler: xsamples times ysamples is too large";
                    return Err(r.error(&grid_place, "parameter-range", message));
                }
            },
        };
        list.ignore(&[
            "jitter",
            "dimensions",
            "randomization",
            "samplepixelcenter",
            "minsamples",
            "maxsamples",
            "method",
        ]);
        list.finish(r);
        self.description.sampler = SamplerDescription {
            name: name.to_owned(),
            samples_per_pixel,
            seed: u64::from(seed.unsigned_abs()),
        };
        Ok(())
    }

    /// Lowers the integrator.
    pub(crate) fn integrator(&mut self, kind: &str, mut list: ParameterList) -> ParseResult<()> {
        let place = list.place;
        let r = &mut self.reporter;
        let name = match kind {
            "whitted" | "distributed" | "path" | "light" | "guided" | "sppm" | "radiosity" => kind,
            "simplepath" | "volpath" | "simplevolpath" => "path",
            "lightpath" => "light",
            // The same picture, with light samples alone.
            "directlighting" => "whitted",
            other => {
                let message =
                    format!("integrator {:?} is not available; \"path\" stands in", shortened(other));
                r.stand_in(&place, "stand-in-integrator", message);
                "path"
            }
        };
        let guide = match list.text_parameter("guide", r)? {
            None => GuideSettings::Tree,
            Some((parameter, _)) if name != "guided" => {
                let message = format!("integrator {name:?} has no guide; \"guided\" has one");
                return Err(r.error(&parameter.value_place, "parameter-range", message));
            }
            Some((parameter, text)) => text.parse().map_err(|error| {
                r.error(&parameter.value_place, "parameter-range", format!("\"guide\": {error}"))
            })?,
        };
        let photons = match name {
            "sppm" => photon_settings(&mut list, r)?,
            _ => PhotonSettings::default(),
        };
        let description = IntegratorDescription {
            name: name.to_owned(),
            max_depth: Some(list.integer_from("maxdepth", 0, r)?.unwrap_or(DEFAULT_DEPTH)),
            light_sampling: list.boolean("samplelights", r)?.unwrap_or(true),
            branching: match name {
                "path" | "distributed" => list.integer_from("branching", 1, r)?,
                // Left in the list, so that it is reported as unused.
                _ => None,
            },
            guide,
            photons,
            spectral: list.boolean("spectral", r)?.unwrap_or(false),
            location: Some(place.location),
        };
        list.ignore(IGNORED);
        if name != "sppm" {
            // There the passes are the samples per pixel: they are reported as unused.
            list.ignore(&["iterations", "numiterations"]);
        }
        list.finish(r);
        self.description.integrator = description;
        Ok(())
    }
}

/// The photons of `sppm`.
fn photon_settings(list: &mut ParameterList, reporter: &mut Reporter) -> ParseResult<PhotonSettings> {
    Ok(PhotonSettings {
        radius: list.float("radius", reporter)?,
        // As many as pixels: -1 or 0, as in pbrt.
        count: list
            .integer("photonsperiteration", reporter)?
            .and_then(|n| u32::try_from(n).ok())
            .filter(|&n| n > 0),
    })
}
