//! Plan of a render: the scene's settings, overridden by the options.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use glanz_sampling::SamplerKind;
use glanz_sampling::exact::MAX_TERMS;
use glanz_scene::Scene;
use glanz_scene::description::FilmDescription;
use glanz_transport::{
    Aov, AovSet, EdgeStyle, FilmError, FilmFormat, FilmSensor, Filter, Integrator, IntegratorSettings,
    NoiseLevel, PictureIdentity, PixelRect, RenderSettings, SamplePlan, StoredLight,
};

use super::RenderOptions;
use super::guide_file::{self, FixedGuide};
#[cfg(feature = "radiosity")]
use crate::bake::LightFile;
use crate::error::{Error, FileFault};
use crate::job_options::JobOptions;
use crate::loaded_scene::LoadedScene;
use crate::running_job::RunningJob;

/// Samples per pixel after which a render ends that has not reached its noise level.
const MAX_SAMPLES: u32 = 1 << 16;

/// Plan of a render, complete before the first ray.
#[derive(Clone, Debug)]
pub struct RenderPlan {
    /// The identity of the picture.
    pub identity: PictureIdentity,
    /// Number of threads.
    pub threads: usize,
    /// Limit on the wall time of the render loop.
    pub time_limit: Option<Duration>,
    /// Samples to render of each pixel.
    pub samples: Range<u32>,
    /// The samples of which these are a part.
    pub(super) part_of: Option<SamplePlan>,
    /// Memory that the film may take, bytes.
    pub(super) film_memory: u64,
    /// Lines over the picture.
    pub(super) edges: Option<EdgeStyle>,
    filter: Filter,
    sensor: FilmSensor,
    /// A frozen guide.
    guide: Option<FixedGuide>,
    /// Stored light, which need not be baked.
    #[cfg(feature = "radiosity")]
    light: Option<LightFile>,
}

impl RenderPlan {
    /// Overrides the settings of the scene by the options.
    pub(super) fn new(
        options: &RenderOptions,
        scene: &mut LoadedScene,
        job: &JobOptions<'_>,
    ) -> Result<Self, Error> {
        options.apply(scene);
        scene.furnish();
        let description = &scene.description;
        let film = &description.film;
        let at_film = |error: &dyn std::fmt::Display| scene.fault(film.location, format!("film: {error}"));
        let crop = PixelRect::from_fractions(film.resolution, film.crop).map_err(|error| at_film(&error))?;
        let integrator = options.integrator(scene)?;
        let guide = options.fixed_guide(&integrator)?;
        #[cfg(feature = "radiosity")]
        let light = options.stored_light_file(&integrator, scene)?;
        let given = guide.as_ref().map(|guide| guide.hash);
        #[cfg(feature = "radiosity")]
        let given = given.or(light.as_ref().map(|light| light.hash));
        let filter = Filter::try_new(&description.filter)
            .map_err(|error| scene.fault(None, format!("pixel filter: {error}")))?;
        let sensor = FilmSensor::try_new(&film.sensor).map_err(|error| at_film(&error))?;
        let sampler = options.sampler(scene)?;
        let identity = PictureIdentity {
            scene: scene.content_hash(),
            film: FilmFormat {
                resolution: film.resolution,
                crop,
                aovs: options.channels(),
                signed: filter.is_signed(),
                passes: integrator.is_guided() && guide.is_none(),
                splats: integrator.build().splats(),
                noise: options.noise_level(&integrator, guide.is_some())?,
            },
            filter: description.filter,
            integrator,
            sampler,
            seed: options.seed.unwrap_or(description.sampler.seed),
            samples_per_pixel: options.samples.unwrap_or(description.sampler.samples_per_pixel),
            guide: given,
            version: glanz_job::current_version(),
        };
        let film_memory = options.film_memory.unwrap_or_else(|| {
            // Only a film that may be in a file can make room for the scene.
            let share = if options.needs_memory(&identity.film) { 1 } else { 2 };
            scene.memory_left() / share
        });
        options.check_memory(&identity.film, film_memory).map_err(|error| {
            // The memory is no fault of the scene.
            let is_of_scene = options.size.is_none() && !matches!(error, FilmError::Limit { .. });
            if is_of_scene { at_film(&error) } else { Error::Film(error) }
        })?;
        let samples = options.sample_numbers(&identity, job.resume)?;
        let (samples, part_of) = options.part_of(samples, &identity)?;
        let threads = match job.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let time_limit = options.time_limit;
        let edges = options.edges.map(|lines| lines.style(identity.film.resolution));
        Ok(Self {
            identity,
            threads,
            time_limit,
            samples,
            part_of,
            film_memory,
            edges,
            filter,
            sensor,
            guide,
            #[cfg(feature = "radiosity")]
            light,
        })
    }

    /// The same for the render loop.
    pub(super) fn settings(&self) -> RenderSettings {
        RenderSettings {
            filter: self.filter.clone(),
            sensor: self.sensor,
            sampler: self.identity.sampler,
            seed: self.identity.seed,
            samples_per_pixel: self.identity.samples_per_pixel,
            samples: self.samples.clone(),
            threads: self.threads,
            spectral: self.identity.integrator.spectral,
            time_limit: self.time_limit,
        }
    }

    /// The integrator, with its guide or its light maps, read from a file or baked.
    pub(super) fn integrator(
        &self,
        scene: &Scene,
        job: &mut RunningJob<'_>,
    ) -> Result<Box<dyn Integrator>, Error> {
        let integrator = &self.identity.integrator;
        if integrator.shows_stored_light() {
            return Ok(integrator.build_with_light(self.stored_light(scene, job)?));
        }
        Ok(match &self.guide {
            Some(FixedGuide { guide, .. }) => integrator.build_with_guide(guide.clone()),
            None => integrator.build(),
        })
    }

    #[cfg(feature = "radiosity")]
    fn stored_light(&self, scene: &Scene, job: &mut RunningJob<'_>) -> Result<Arc<dyn StoredLight>, Error> {
        super::stored::stored_light(scene, self.light.as_ref(), job)
    }

    #[cfg(not(feature = "radiosity"))]
    fn stored_light(&self, _: &Scene, _: &mut RunningJob<'_>) -> Result<Arc<dyn StoredLight>, Error> {
        Err(Error::LightRequired { integrator: self.identity.integrator.name() })
    }
}

impl RenderOptions {
    /// The channels to render beside the colour.
    fn channels(&self) -> AovSet {
        let mut channels = self.aovs;
        if self.noise.is_some() {
            channels = channels.with(Aov::Variance);
        }
        #[cfg(feature = "denoise")]
        if self.denoise {
            channels = channels.union(super::denoised::CHANNELS);
        }
        channels
    }

    /// Checks the size of the film, and that it is in memory or may be in a file.
    fn check_memory(&self, film: &FilmFormat, limit: u64) -> Result<(), FilmError> {
        let needed = film.words()?.saturating_mul(8);
        match self.needs_memory(film) && needed > limit {
            true => Err(FilmError::Limit { needed, limit }),
            false => Ok(()),
        }
    }

    /// Whether the film cannot be in a file.
    fn needs_memory(&self, film: &FilmFormat) -> bool {
        #[cfg(feature = "denoise")]
        let is_denoised = self.denoise && self.part.is_none();
        #[cfg(not(feature = "denoise"))]
        let is_denoised = false;
        is_denoised || !film.fits_in_file()
    }

    /// The noise at which tiles take no more samples.
    fn noise_level(
        &self,
        integrator: &IntegratorSettings,
        has_guide: bool,
    ) -> Result<Option<NoiseLevel>, Error> {
        let Some(error) = self.noise else { return Ok(None) };
        let level = NoiseLevel::try_new(error).ok_or(Error::NoiseLevel { error })?;
        if integrator.is_guided() && !has_guide || integrator.build().splats() {
            return Err(Error::NoiseOf { integrator: integrator.name() });
        }
        Ok(Some(level))
    }

    /// Replaces settings of the description.
    fn apply(&self, scene: &mut LoadedScene) {
        let FilmDescription { resolution, .. } = &mut scene.description.film;
        *resolution = self.size.unwrap_or(*resolution);
        let integrator = &mut scene.description.integrator;
        if let Some(name) = &self.integrator {
            integrator.select(name);
        }
        integrator.branching = self.branching.or(integrator.branching);
        integrator.guide = self.guide.unwrap_or(integrator.guide);
        integrator.spectral |= self.spectral;
        integrator.light_sampling = self.light_sampling.unwrap_or(integrator.light_sampling);
    }

    fn integrator(&self, scene: &LoadedScene) -> Result<IntegratorSettings, Error> {
        let description = &scene.description.integrator;
        // A setting from the options is no fault of the line of the scene.
        let is_from_file = self.integrator.is_none() && self.branching.is_none();
        let location = description.location.filter(|_| is_from_file);
        let integrator = IntegratorSettings::resolve(description)
            .map_err(|error| scene.fault(location, format!("integrator: {error}")))?;
        if self.light_sampling.is_some_and(|wanted| wanted != integrator.light_sampling) {
            return Err(Error::LightSampling { integrator: integrator.name() });
        }
        if self.branching.is_some_and(|wanted| wanted != integrator.branching) {
            return Err(Error::Branching { integrator: integrator.name() });
        }
        Ok(integrator)
    }

    fn sampler(&self, scene: &LoadedScene) -> Result<SamplerKind, Error> {
        let name = &scene.description.sampler.name;
        let named = || {
            SamplerKind::from_name(name)
                .ok_or_else(|| scene.fault(None, format!("there is no sampler \"{name}\"")))
        };
        self.sampler.map_or_else(named, Ok)
    }

    /// The guide of the file; an error if the integrator uses none.
    fn fixed_guide(&self, integrator: &IntegratorSettings) -> Result<Option<FixedGuide>, Error> {
        if (self.guide.is_some() || self.guide_input.is_some() || self.guide_output.is_some())
            && !integrator.is_guided()
        {
            return Err(Error::NoGuide { integrator: integrator.name() });
        }
        let Some(path) = self.guide_input.as_deref() else { return Ok(None) };
        let fixed = guide_file::read(path)?;
        let (found, wanted) = (fixed.guide.settings(), integrator.guide);
        if found != wanted {
            return Err(FileFault::GuideSettings { found, wanted }.of(path));
        }
        Ok(Some(fixed))
    }

    /// The light of the file; an error if the integrator uses none.
    #[cfg(feature = "radiosity")]
    fn stored_light_file(
        &self,
        integrator: &IntegratorSettings,
        scene: &LoadedScene,
    ) -> Result<Option<LightFile>, Error> {
        if self.light_input.is_some() && !integrator.shows_stored_light() {
            return Err(Error::NoStoredLight { integrator: integrator.name() });
        }
        let Some(path) = self.light_input.as_deref() else { return Ok(None) };
        let light = LightFile::read(path)?;
        light.check(scene.content_hash())?;
        Ok(Some(light))
    }

    /// The samples to render: the requested range, all that fit into the time, or the planned number.
    fn sample_numbers(&self, identity: &PictureIdentity, resume: bool) -> Result<Range<u32>, Error> {
        let planned = identity.samples_per_pixel;
        match &self.sample_range {
            Some(range) if identity.plan_matters() && range.end > planned => {
                let (range, sampler) = (range.clone(), identity.sampler.name());
                Err(Error::SampleRange { range, planned, sampler })
            }
            // Resumed, they may come in turn: the render loop knows.
            Some(range) if identity.film.is_ordered() && range.start > 0 && !resume => {
                Err(Error::SampleOrder { start: range.start, next: 0 })
            }
            Some(range) => Ok(range.clone()),
            None if self.time_limit.is_some() => Ok(0..MAX_TERMS),
            None if self.noise.is_some() && self.samples.is_none() => Ok(0..MAX_SAMPLES),
            None => Ok(0..planned),
        }
    }

    /// The share of `samples` that the requested part has, and the plan that it is a part of.
    fn part_of(
        &self,
        samples: Range<u32>,
        identity: &PictureIdentity,
    ) -> Result<(Range<u32>, Option<SamplePlan>), Error> {
        let Some(part) = self.part else { return Ok((samples, None)) };
        if self.time_limit.is_some() {
            return Err(Error::PartGoal);
        }
        // With a noise level, even the only part would not take all samples.
        if self.noise.is_some() || identity.film.is_ordered() && part.count() > 1 {
            return Err(Error::OrderedParts);
        }
        match SamplePlan::try_new(samples.clone(), part.count()) {
            Some(plan) => Ok((plan.share(part), Some(plan))),
            None => Err(Error::Parts { part, samples }),
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, ResourceLimits};
    use glanz_scene::SceneBuilder;

    use super::*;

    fn plan(options: &RenderOptions) -> Result<RenderPlan, Error> {
        let scene = SceneBuilder::new().resolution(2, 2).describe().unwrap();
        RenderPlan::new(options, &mut LoadedScene::from_description("empty", scene), &JobOptions::default())
    }

    fn by_noise(noise: f64) -> RenderOptions {
        RenderOptions { noise: Some(noise), ..RenderOptions::default() }
    }

    #[test]
    fn films_that_must_be_in_memory_may_take_all_that_the_scene_leaves() {
        let within = |memory, options: &RenderOptions| {
            let scene = SceneBuilder::new().resolution(2, 2).describe().unwrap();
            let limits = ResourceLimits { memory, ..ResourceLimits::default() };
            let scene = LoadedScene::from_description("empty", scene);
            RenderPlan::new(options, &mut scene.limits(limits, CancelFlag::default()), &JobOptions::default())
        };
        let learning = RenderOptions { integrator: Some("guided".to_owned()), ..RenderOptions::default() };
        let whole = within(1 << 30, &learning).unwrap();
        assert_eq!(whole.film_memory, 1 << 30);
        assert_eq!(within(1 << 30, &RenderOptions::default()).unwrap().film_memory, 1 << 29);
        let needed = 8 * whole.identity.film.words().unwrap();
        assert!(within(needed, &learning).is_ok());
        let refused = within(needed - 1, &learning);
        assert!(matches!(refused, Err(Error::Film(FilmError::Limit { limit, .. })) if limit == needed - 1));
    }

    #[test]
    fn samples_out_of_order_are_refused_by_the_plan() {
        let learning = RenderOptions { integrator: Some("guided".to_owned()), ..RenderOptions::default() };
        for options in [by_noise(0.1), learning] {
            let late = RenderOptions { sample_range: Some(5..9), ..options.clone() };
            assert!(matches!(plan(&late), Err(Error::SampleOrder { start: 5, next: 0 })));
            let early = RenderOptions { sample_range: Some(0..9), ..options };
            assert_eq!(plan(&early).unwrap().samples, 0..9);
        }
    }

    #[test]
    fn parts_divide_the_planned_samples_or_the_range() {
        let part = |text: &str, options: RenderOptions| {
            plan(&RenderOptions { part: Some(text.parse().unwrap()), ..options })
        };
        let by_count = || RenderOptions { samples: Some(7), ..RenderOptions::default() };
        let by_range = || RenderOptions { sample_range: Some(10..15), ..by_count() };
        for (text, of_count, of_range) in
            [("1/1", 0..7, 10..15), ("1/3", 0..2, 10..11), ("3/3", 4..7, 13..15)]
        {
            assert_eq!(part(text, by_count()).unwrap().samples, of_count);
            assert_eq!(part(text, by_range()).unwrap().samples, of_range);
        }
        let too_many = part("2/8", by_count()).unwrap_err();
        assert_eq!(too_many.to_string(), "the samples 0..7 of each pixel make at most 7 parts");
        assert!(part("2/7", by_count()).is_ok());
        assert!(matches!(part("2/6", by_range()), Err(Error::Parts { .. })));
        let learning = || RenderOptions { integrator: Some("guided".to_owned()), ..by_count() };
        for options in [learning(), RenderOptions { noise: Some(0.1), ..by_count() }] {
            assert!(matches!(part("1/2", options), Err(Error::OrderedParts)));
        }
        assert_eq!(part("1/1", learning()).unwrap().samples, 0..7);
        assert!(matches!(part("1/1", by_noise(0.1)), Err(Error::OrderedParts)));
        let timed = RenderOptions { time_limit: Some(Duration::from_secs(1)), ..by_count() };
        assert!(matches!(part("1/2", timed), Err(Error::PartGoal)));
    }

    #[test]
    fn noise_levels_have_limits_of_samples_and_add_the_variance() {
        let limited = |samples, time_limit| RenderOptions { samples, time_limit, ..by_noise(0.1) };
        for (samples, time, expected) in [
            (None, None, 0..65_536),
            (Some(40), None, 0..40),
            (None, Some(Duration::from_secs(1)), 0..MAX_TERMS),
        ] {
            let plan = plan(&limited(samples, time)).unwrap();
            assert_eq!(plan.samples, expected);
            assert!(plan.identity.film.aovs.contains(Aov::Variance));
        }
    }

    #[test]
    fn noise_levels_are_refused_out_of_range_and_where_samples_depend_on_others() {
        for noise in [0.0, 2.0, f64::NAN] {
            assert!(matches!(plan(&by_noise(noise)), Err(Error::NoiseLevel { .. })), "{noise}");
        }
        for name in ["light", "guided"] {
            let options = RenderOptions { integrator: Some(name.to_owned()), ..by_noise(0.1) };
            assert!(matches!(plan(&options), Err(Error::NoiseOf { integrator }) if integrator == name));
        }
    }
}
