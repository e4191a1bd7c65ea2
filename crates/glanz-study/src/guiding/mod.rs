//! Speed-up of path tracing in rooms by densities that learn the incident light (document 003 chapter 3).

mod cache;
mod curve;
mod figures;
mod measure;
mod method;
mod outcome;
mod report;
mod room;

use glanz_light::Pixels;
use glanz_transport::RenderError;

use self::cache::{ResultCache, RunResult};
use self::curve::{PictureError, combined};
use self::measure::{MethodRun, ReferencePicture, Work, reference};
use self::method::{MethodEntry, RenderMethod, entries};
use self::outcome::{MethodOutcome, RoomOutcome};
use self::room::GuidingRoom;

use self::report::build_report;
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};
use glanz_report::{SheetPanel, contact_sheet};

/// Rooms after the three scenes of document 003.
const ROOMS: [&str; 3] = ["direct", "uplights", "open"];

/// The extent of the measurements.
#[derive(Clone, Debug)]
struct GuidingPlan {
    rooms: Vec<String>,
    size: [u32; 2],
    /// Samples per pixel at which curves end.
    samples: u32,
    /// Samples per pixel of the references.
    references: u32,
    rounds: u32,
    /// Render time of each picture at equal time, seconds.
    seconds: f64,
    threads: usize,
    seed: u64,
    entries: Vec<MethodEntry>,
}

impl GuidingPlan {
    fn new(settings: &Settings) -> Result<Self, StudyError> {
        let full = settings.full;
        let samples = settings.samples.unwrap_or(if full { 2048 } else { 128 });
        if !samples.is_power_of_two() {
            return Err(StudyError::Setting {
                name: "samples",
                value: samples.to_string(),
                needed: "a power of two, like the passes of guided integrators",
            });
        }
        let names = || ROOMS.map(str::to_owned).into();
        let entries = chosen(entries(samples, full), settings.methods.as_deref())?;
        Ok(Self {
            rooms: settings.rooms.clone().unwrap_or_else(names),
            size: settings.size.unwrap_or([160, 120]),
            samples,
            references: settings.references.unwrap_or(if full { 65_536 } else { 4096 }).max(1),
            rounds: settings.rounds.unwrap_or(1).max(1),
            seconds: settings.seconds.unwrap_or(if full { 30.0 } else { 3.0 }),
            threads: settings.threads.unwrap_or(2).max(1),
            seed: settings.seed,
            entries,
        })
    }

    /// All runs in a room; those of one method and light sampling are consecutive.
    fn cases<'a>(&'a self, room: &'a GuidingRoom<'a>) -> impl Iterator<Item = MethodRun<'a>> {
        let kinds = self.entries.iter().flat_map(|entry| [false, true].map(|lights| (entry, lights)));
        kinds.flat_map(move |(entry, lights)| {
            (0..self.rounds).map(move |round| MethodRun { room, entry, lights, round, seed: self.seed })
        })
    }
}

/// `path` and the entries with these keys; all if `keys` is `None`.
fn chosen(mut entries: Vec<MethodEntry>, keys: Option<&[String]>) -> Result<Vec<MethodEntry>, StudyError> {
    let Some(keys) = keys else { return Ok(entries) };
    match keys.iter().find(|key| entries.iter().all(|entry| entry.method.key != **key)) {
        Some(unknown) => Err(StudyError::Setting {
            name: "methods",
            value: unknown.clone(),
            needed: "tree, or one of the grids of this study, such as haar-8-3: basis, cells and scale",
        }),
        None => {
            entries.retain(|MethodEntry { method, .. }| {
                *method == RenderMethod::path() || keys.contains(&method.key)
            });
            Ok(entries)
        }
    }
}

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or rooms that cannot be read.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    run_plan(&GuidingPlan::new(settings)?, settings, progress)
}

fn run_plan(
    plan: &GuidingPlan,
    settings: &Settings,
    progress: &mut StudyProgress<'_>,
) -> Result<Report, StudyError> {
    let cache = ResultCache::within(settings.cache.as_deref())?;
    let read = |name: &String| GuidingRoom::read(name, plan.size, plan.threads, settings);
    let rooms = plan.rooms.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let mut work = Work::new(progress, work_left(plan, &rooms, &cache)?);
    let mut outcomes = Vec::new();
    for room in &rooms {
        let reference = reference(room, plan.references, plan.seed, &cache, &mut work)?;
        outcomes.push(in_room(room, plan, &reference, &cache, &mut work)?);
    }
    let report = build_report(outcomes, plan);
    progress.report(1.0, "done");
    Ok(report)
}

/// Samples per pixel that are not cached.
fn work_left(plan: &GuidingPlan, rooms: &[GuidingRoom<'_>], cache: &ResultCache) -> Result<f64, StudyError> {
    let mut left = 0.0;
    for room in rooms {
        let there = measure::reference_samples(room, plan.seed, cache)?;
        left += u64::from(plan.references).saturating_sub(there) as f64;
        for case in plan.cases(room) {
            // A cached reference may have more samples than requested.
            let measured = case.measured(there.max(u64::from(plan.references)), cache)?;
            left += if measured.is_none() { case.work() } else { 0.0 };
        }
    }
    Ok(left)
}

fn in_room(
    room: &GuidingRoom<'_>,
    plan: &GuidingPlan,
    reference: &ReferencePicture,
    cache: &ResultCache,
    work: &mut Work<'_, '_>,
) -> Result<RoomOutcome, StudyError> {
    let mut outcomes = Vec::new();
    let cases: Vec<MethodRun<'_>> = plan.cases(room).collect();
    let mut refused = Vec::new();
    for rounds in cases.chunks(plan.rounds as usize) {
        let mut runs = Vec::new();
        for case in rounds {
            match case.result(reference, cache, work) {
                Ok(run) => runs.push(run),
                // A grid that is too large for the room is left out.
                Err(StudyError::Render(RenderError::Guide(error))) => refused.push(error.to_string()),
                Err(error) => return Err(error),
            }
        }
        let (Some(case), Some(RunResult { frozen, .. })) = (rounds.first(), runs.first().cloned()) else {
            continue;
        };
        let curves: Vec<_> = runs.into_iter().map(|run| run.curve).collect();
        let method = case.entry.method.clone();
        outcomes.push(MethodOutcome { method, lights: case.lights, curve: combined(&curves), frozen });
    }
    refused.dedup();
    let (name, reference_samples) = (room.name.clone(), reference.samples);
    let mut outcome = RoomOutcome { name, outcomes, refused, reference_samples, sheet: None };
    outcome.sheet = Some(side_by_side(room, plan, &outcome, reference, cache, work)?);
    Ok(outcome)
}

/// Pictures at equal time: without light sampling above, with it below; the reference at the right.
fn side_by_side(
    room: &GuidingRoom<'_>,
    plan: &GuidingPlan,
    outcome: &RoomOutcome,
    reference: &ReferencePicture,
    cache: &ResultCache,
    work: &mut Work<'_, '_>,
) -> Result<Pixels, StudyError> {
    let mut rows = Vec::new();
    for lights in [false, true] {
        let best = outcome.best_grid(lights).map(|best| best.method.clone());
        let mut row = Vec::new();
        for method in [RenderMethod::path(), RenderMethod::tree()].into_iter().chain(best) {
            let Some(entry) = plan.entries.iter().find(|entry| entry.method == method) else { continue };
            let case = MethodRun { room, entry, lights, round: 0, seed: plan.seed };
            let (pixels, samples) = case.picture(plan.seconds, cache, work)?;
            let error = PictureError::of(&pixels, &reference.pixels)?;
            let below = format!("{samples} spp L2 {:.4}/{:.4}", error.plain, error.shown);
            row.push(SheetPanel { lines: [method.key, below], pixels });
        }
        let lines = ["reference".to_owned(), format!("{} spp", reference.samples)];
        row.push(SheetPanel { lines, pixels: reference.pixels.clone() });
        rows.push(row);
    }
    Ok(contact_sheet(&rows)?)
}

#[cfg(test)]
mod tests;
