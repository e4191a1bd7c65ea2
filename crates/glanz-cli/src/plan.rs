//! What is to be rendered: the scene's own settings, overridden by the command line.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use glanz_sampling::SamplerKind;
use glanz_sampling::exact::MAX_TERMS;
use glanz_transport::{
    Aov, AovSet, FilmFormat, Filter, Integrator, IntegratorSettings, PictureIdentity, PixelRect,
    RenderSettings, StoredLight,
};

use crate::arguments::{ALL_AOVS, RenderOptions};
use crate::guide_file::{self, FixedGuide};
use crate::light_file::{self, LightFile};
use crate::messages::Failure;
use crate::report::grouped;
use crate::scene_file::SceneFile;

/// Everything that is known before the first ray.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) identity: PictureIdentity,
    pub(crate) threads: usize,
    pub(crate) time_limit: Option<Duration>,
    /// A guide that does not learn.
    guide: Option<FixedGuide>,
    /// Light that need not be made.
    light: Option<LightFile>,
    filter: Filter,
    samples: Range<u32>,
}

impl Plan {
    /// Puts the settings of the command line over those of the scene.
    ///
    /// # Errors
    /// A setting of the scene or the command line that is impossible.
    pub(crate) fn new(options: &RenderOptions, file: &mut SceneFile) -> Result<Self, Failure> {
        if let Some(size) = options.size {
            file.description.film.resolution = size;
        }
        if let Some(name) = &options.integrator {
            file.description.integrator.name.clone_from(name);
        }
        if let Some(guide) = options.guide {
            file.description.integrator.guide = guide;
        }
        if let Some(light_sampling) = options.samplelights {
            file.description.integrator.light_sampling = light_sampling;
        }
        let description = &file.description;
        let film = &description.film;
        let crop = PixelRect::from_fractions(film.resolution, film.crop)
            .map_err(|error| file.failure(film.location, &format!("film: {error}")))?;
        let integrator = IntegratorSettings::resolve(&description.integrator).map_err(|error| {
            file.failure(description.integrator.location, &format!("integrator: {error}"))
        })?;
        if options.samplelights.is_some_and(|wanted| wanted != integrator.light_sampling) {
            let name = integrator.name();
            return Err(Failure::usage(format!(
                "--samplelights off: the integrator \"{name}\" samples all lights"
            )));
        }
        let guide = guide(options, &integrator)?;
        let light = light(options, &integrator, file.content_hash)?;
        let learns = integrator.is_guided() && guide.is_none();
        let filter = Filter::try_new(&description.filter)
            .map_err(|error| file.failure(None, &format!("pixel filter: {error}")))?;
        let name = options.sampler.as_ref().unwrap_or(&description.sampler.name);
        let sampler = SamplerKind::from_name(name)
            .ok_or_else(|| file.failure(None, &format!("there is no sampler \"{name}\"")))?;
        let identity = PictureIdentity {
            scene: file.content_hash,
            film: FilmFormat {
                resolution: description.film.resolution,
                crop,
                aovs: aovs(&options.aov),
                signed: filter.is_signed(),
                passes: learns,
                splats: integrator.build().splats(),
            },
            filter: description.filter,
            integrator,
            sampler,
            seed: options.seed.unwrap_or(description.sampler.seed),
            samples_per_pixel: options.spp.unwrap_or(description.sampler.samples_per_pixel),
            guide: guide.as_ref().map(|guide| guide.hash).or(light.as_ref().map(|light| light.hash)),
            version: glanz_job::current_version(),
        };
        identity.film.words().map_err(|error| match options.size {
            Some([width, height]) => Failure::new(format!("--size {width}x{height}: {error}")),
            None => file.failure(film.location, &format!("film: {error}")),
        })?;
        let samples = samples(options, &identity)?;
        let threads = match options.threads {
            Some(threads) => usize::from(threads),
            None => std::thread::available_parallelism().map_or(1, usize::from),
        };
        Ok(Self { identity, threads, time_limit: options.time, guide, light, filter, samples })
    }

    /// The integrator, with its guide or the `light` that it shows.
    pub(crate) fn integrator(&self, light: Option<Arc<dyn StoredLight>>) -> Box<dyn Integrator> {
        match (&self.guide, light) {
            (Some(FixedGuide { guide, .. }), _) => self.identity.integrator.build_with_guide(guide.clone()),
            (None, Some(light)) => self.identity.integrator.build_with_light(light),
            (None, None) => self.identity.integrator.build(),
        }
    }

    /// The light that the command line names, with its file.
    pub(crate) fn light<'a>(&'a self, options: &'a RenderOptions) -> Option<(&'a Path, &'a LightFile)> {
        options.light_in.as_deref().zip(self.light.as_ref())
    }

    /// The same for the render loop.
    pub(crate) fn settings(&self) -> RenderSettings {
        RenderSettings {
            filter: self.filter.clone(),
            sampler: self.identity.sampler,
            seed: self.identity.seed,
            samples_per_pixel: self.identity.samples_per_pixel,
            samples: self.samples.clone(),
            threads: self.threads,
            time_limit: self.time_limit,
        }
    }
}

/// The guide that the command line names, if the integrator has any use for it.
fn guide(options: &RenderOptions, integrator: &IntegratorSettings) -> Result<Option<FixedGuide>, Failure> {
    let named = [
        ("--guide", options.guide.is_some()),
        ("--guide-in", options.guide_in.is_some()),
        ("--guide-out", options.guide_out.is_some()),
    ];
    if let Some((name, _)) = named.into_iter().find(|(_, given)| *given)
        && !integrator.is_guided()
    {
        return Err(Failure::usage(format!("{name}: the integrator \"{}\" has no guide", integrator.name()))
            .with_help("add --integrator guided"));
    }
    let Some(path) = options.guide_in.as_deref() else { return Ok(None) };
    let fixed = guide_file::read(path)?;
    let (found, wanted) = (fixed.guide.settings(), integrator.guide);
    if found != wanted {
        return Err(Failure::new(format!("{}: this guide is {found}, not {wanted}", path.display()))
            .with_help(format!("give the guide of its file: --guide {found}")));
    }
    Ok(Some(fixed))
}

/// The light that the command line names, if the integrator shows any.
fn light(
    options: &RenderOptions,
    integrator: &IntegratorSettings,
    scene: u128,
) -> Result<Option<LightFile>, Failure> {
    let Some(path) = options.light_in.as_deref() else { return Ok(None) };
    if !integrator.shows_stored_light() {
        let name = integrator.name();
        return Err(Failure::usage(format!("--light-in: the integrator \"{name}\" shows no stored light"))
            .with_help("add --integrator radiosity"));
    }
    let light = light_file::read(path)?;
    light.check(path, scene)?;
    Ok(Some(light))
}

/// The channels of these names; the definition of the arguments lets no others through.
fn aovs(names: &[String]) -> AovSet {
    if names.iter().any(|name| name.eq_ignore_ascii_case(ALL_AOVS)) {
        return AovSet::ALL;
    }
    names.iter().filter_map(|name| Aov::from_name(name)).collect()
}

/// The samples to take: those asked for, all that fit into the time, or as many as planned.
fn samples(options: &RenderOptions, identity: &PictureIdentity) -> Result<Range<u32>, Failure> {
    let planned = identity.samples_per_pixel;
    match &options.samples {
        Some(range) if identity.plan_matters() && range.end > planned => {
            let (name, end) = (identity.sampler.name(), range.end);
            Err(Failure::usage(format!(
                "--samples {}..{end} goes beyond the {} of each pixel",
                range.start,
                crate::report::plural(u64::from(planned), "sample", "samples")
            ))
            .with_help(format!(
                "the sampler \"{name}\" divides the pixel by their number: give --spp {end} or more"
            )))
        }
        // Resumed, they may come in turn: the render loop knows.
        Some(range) if identity.film.passes && range.start > 0 && !options.resume => {
            let (start, end) = (range.start, range.end);
            Err(Failure::usage(format!(
                "--samples {start}..{end}: the samples of \"guided\" build on those before"
            ))
            .with_help("begin at 0, or give a guide that is not learnt at the same time with --guide-in"))
        }
        Some(range) => Ok(range.clone()),
        None if options.time.is_some() => Ok(0..MAX_TERMS),
        None => Ok(0..planned),
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.identity.film.crop.size;
        write!(f, "{width} x {height} pixels, ")?;
        match self.time_limit {
            Some(limit) => write!(f, "{} s", limit.as_secs_f64())?,
            None if self.samples.start == 0 => {
                write!(f, "{} samples per pixel", grouped(self.samples.end.into()))?
            }
            None => write!(f, "samples {}..{} of each", self.samples.start, self.samples.end)?,
        }
        let threads = if self.threads == 1 { "thread" } else { "threads" };
        let (integrator, sampler) = (self.identity.integrator.name(), self.identity.sampler.name());
        write!(f, ", {integrator}, {sampler}, {} {threads}", self.threads)
    }
}
