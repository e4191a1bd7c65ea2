//! A scene with its receivers, and its light by all methods.

use std::path::Path;
use std::time::Instant;

use glanz_illumination::planning::{PlacedLuminaire, PlanningRequest, RoomLayout};
use glanz_illumination::report::LuxReport;
use glanz_illumination::{
    DaylightFactors, FluxBalance, LuxMap, ReceiverRequest, Receivers, TraceSettings, add_walls,
    under_overcast_sky,
};
use glanz_job::{ContentHash, JobEnd};
use glanz_scene::Scene;
use glanz_scene::description::ObserverDescription;
use glanz_scene::light::Light;

use super::facts::CalculationFacts;
use super::outcome::compare_methods;
use super::{IlluminateMethod, IlluminateOptions, IlluminateOutcome, combining, integrating, tracing};
use crate::error::Error;
use crate::event::Warning;
use crate::loaded_scene::LoadedScene;
use crate::running_job::RunningJob;

/// Largest number of cells of all receivers: the sums of each take 256 bytes, and 16 per thread.
const CELLS_LIMIT: usize = 1 << 24;

/// Share of the flux of lamps that leaves a room through its seams unnoticed.
const MOST_ESCAPED: f64 = 0.01;

/// A scene with receivers.
#[derive(Debug)]
pub(super) struct Design {
    pub(super) name: String,
    /// Title of the reports, if it is not that of the scene.
    pub(super) title: Option<String>,
    pub(super) scene: Scene,
    pub(super) receivers: Receivers,
    /// Observers that the scene declares, and its photometric lights.
    pub(super) observers: Vec<ObserverDescription>,
    pub(super) luminaires: Vec<PlacedLuminaire>,
    /// The room from above.
    pub(super) layout: Option<RoomLayout>,
    /// Content hash of the files of the scene.
    pub(super) content_hash: u128,
    /// Content hashes of the scene with its room, and of the receivers.
    pub(super) hashes: [u128; 2],
    pub(super) options: IlluminateOptions,
}

impl Design {
    /// Resolves the scene and its receivers.
    pub(super) fn new(
        mut scene: LoadedScene,
        options: IlluminateOptions,
        needs_receivers: bool,
        job: &mut RunningJob<'_>,
    ) -> Result<Self, Error> {
        let (name, content_hash) = (scene.name().to_owned(), scene.content_hash());
        if let Some(size) = options.room {
            add_walls(&mut scene.description, size);
        }
        if options.daylight {
            under_overcast_sky(&mut scene.description);
        }
        let observers = scene.description.observers.clone();
        let luminaires = PlacedLuminaire::of_scene(&scene.description);
        let (scene, warnings) = scene.resolve_for(&job.options.cancel)?;
        warnings.into_iter().for_each(|warning| job.warn(warning));
        if scene.has_media() {
            job.warn(Warning::MediaLeftOut { what: "the calculation of illuminance".to_owned() });
        }
        let requests = ReceiverRequest::of_scene(&scene, options.resolution);
        if requests.is_empty() && needs_receivers {
            return Err(Error::NoReceiver { scene: name });
        }
        let receivers = Receivers::try_new(&scene, &requests)
            .map_err(|error| Error::Receiver { scene: name.clone(), error })?;
        warn_of_covered_cells(&receivers, job);
        if receivers.cell_count() > CELLS_LIMIT {
            return Err(Error::Cells { scene: name, cells: receivers.cell_count(), limit: CELLS_LIMIT });
        }
        if scene.lights().is_empty() {
            return Err(Error::NoLight { scene: name });
        }
        let names: Vec<(&str, [u32; 2])> =
            receivers.as_slice().iter().map(|receiver| (receiver.name(), receiver.cells())).collect();
        let hashes =
            [format!("{content_hash:032x} {:?} {}", options.room, options.daylight), format!("{names:?}")]
                .map(|text| {
                    let mut hash = ContentHash::default();
                    hash.add_file(text.as_bytes());
                    hash.value()
                });
        let layout = RoomLayout::of(&scene, &receivers, &luminaires);
        let title = None;
        Ok(Self {
            name,
            title,
            scene,
            receivers,
            observers,
            luminaires,
            layout,
            content_hash,
            hashes,
            options,
        })
    }

    /// The zones and observers that the scene declares.
    pub(super) fn declared_plan(&self) -> PlanningRequest {
        let luminaires = self.luminaires.clone();
        let declared = PlanningRequest::of_scene(&self.scene, &self.receivers, &self.observers, luminaires);
        let Some(layout) = &self.layout else { return declared };
        PlanningRequest { watts: layout.watts().unwrap_or(0.0), area: layout.floor_area(), ..declared }
    }

    /// Computes the light.
    pub(super) fn illuminate(&self, job: &mut RunningJob<'_>) -> Result<IlluminateOutcome, Error> {
        let start = Instant::now();
        let mut facts = CalculationFacts::of_settings(&self.name, self.content_hash, &self.options);
        let stem = Path::new(&self.name).file_stem();
        let title = self.title.clone().or_else(|| Some(stem?.to_string_lossy().into_owned()));
        let title = title.unwrap_or_default();
        let mut outcome = IlluminateOutcome {
            report: LuxReport { title, layout: self.layout.clone(), ..LuxReport::default() },
            ..IlluminateOutcome::default()
        };
        let method = self.options.method;
        if matches!(method, IlluminateMethod::Integrate | IlluminateMethod::Both) {
            outcome.integrated = job.in_pool(|job| integrating::integrated(self, job, &mut facts))?;
        }
        match method {
            IlluminateMethod::Auto => self.combine(&mut outcome, job, &mut facts)?,
            IlluminateMethod::Integrate => outcome.report.maps = std::mem::take(&mut outcome.integrated),
            IlluminateMethod::Trace | IlluminateMethod::Both => {
                self.count_particles(&mut outcome, job, &mut facts)?;
            }
        }
        if self.options.daylight {
            outcome.report.daylight = outcome.report.maps.iter().map(DaylightFactors::of).collect();
        }
        if self.scene.has_media() {
            facts.result.push("fog and other media", "media", "left out");
        }
        facts.result.push("complete", "complete", outcome.end == JobEnd::Complete);
        if outcome.end == JobEnd::Interrupted {
            facts.result.push("interrupted", "interrupted", true);
        }
        outcome.report.facts = facts.finish(start.elapsed(), job.threads());
        self.scene.check_textures()?;
        Ok(outcome)
    }

    /// Settings of particles and paths.
    pub(super) fn trace_settings(&self, job: &RunningJob<'_>) -> TraceSettings {
        let IlluminateOptions { seed, max_depth, goal, part, .. } = self.options;
        TraceSettings { seed, max_events: max_depth, threads: job.options.threads, goal, part }
    }

    /// Adds the light by all methods to `outcome`.
    fn combine(
        &self,
        outcome: &mut IlluminateOutcome,
        job: &mut RunningJob<'_>,
        facts: &mut CalculationFacts,
    ) -> Result<(), Error> {
        let (light, end) = combining::combined(self, job, facts)?;
        outcome.report.maps = light.lux_maps(&self.receivers);
        outcome.report.balance = Some(light.balance());
        outcome.end = end;
        self.warn_of_dark_sides(&outcome.report.maps, |receiver| light.on_other_side(receiver), job);
        Ok(())
    }

    /// Adds the light of particles to `outcome`.
    fn count_particles(
        &self,
        outcome: &mut IlluminateOutcome,
        job: &mut RunningJob<'_>,
        facts: &mut CalculationFacts,
    ) -> Result<(), Error> {
        let (tally, end) = tracing::traced(self, job, facts)?;
        let report = &mut outcome.report;
        report.maps = tally.lux_maps(&self.receivers);
        report.balance = Some(tally.balance());
        self.warn_of_dark_sides(&report.maps, |receiver| tally.on_other_side(receiver), job);
        if !outcome.integrated.is_empty() {
            compare_methods(&report.maps, &outcome.integrated, &mut facts.result);
        }
        outcome.end = end;
        outcome.set_far_field(tally.far_field(), job);
        outcome.tally = Some(tally);
        Ok(())
    }

    /// Warns of light of lamps that leaves the scene. Of the sky's and the sun's, most passes by.
    pub(super) fn warn_of_escaped_flux(&self, balance: &FluxBalance, job: &mut RunningJob<'_>) {
        let FluxBalance { emitted, escaped: flux, .. } = *balance;
        let is_distant = |light: &Light| matches!(light, Light::Distant(_));
        let is_lit_from_outside =
            !self.scene.infinite_lights().is_empty() || self.scene.lights().iter().any(is_distant);
        if !is_lit_from_outside && flux > MOST_ESCAPED * emitted {
            job.warn(Warning::EscapedFlux { flux, share: flux / emitted });
        }
    }

    /// Warns of receivers without light, which may face the wrong way. `other_side`: flux on the side that is not counted, lm.
    fn warn_of_dark_sides(
        &self,
        maps: &[LuxMap],
        other_side: impl Fn(usize) -> f64,
        job: &mut RunningJob<'_>,
    ) {
        for (number, map) in maps.iter().enumerate() {
            let other_side = other_side(number);
            if map.lux.iter().all(|&lux| lux == 0.0) && other_side > 0.0 {
                job.warn(Warning::DarkSide { receiver: map.name.clone(), other_side });
            }
        }
    }
}

/// Warns of cells that do not count, or do only in part.
fn warn_of_covered_cells(receivers: &Receivers, job: &mut RunningJob<'_>) {
    for receiver in receivers.as_slice() {
        let count =
            |test: fn(f64) -> bool| receiver.covered().iter().filter(|share| test(**share)).count() as u64;
        // Things that touch the receiver in a point cover a little of a cell.
        let covered = [count(|share| share == 1.0), count(|share| (0.05..1.0).contains(&share))];
        if covered != [0, 0] {
            let (receiver, cells) = (receiver.name().to_owned(), receiver.len() as u64);
            job.warn(Warning::CoveredCells { receiver, covered, cells });
        }
    }
}
