//! Illuminance on the six walls of the room, by particles.

use std::time::Duration;

use glanz_illumination::report::{false_colour, isolux, lux_scale};
use glanz_illumination::{
    FluxBalance, GridResolution, LuxMap, ReceiverRequest, Receivers, ReplicateEstimate, Tally, TraceGoal,
    TraceSettings, add_walls, trace,
};
use glanz_job::{JobProgress, ProgressSink};
use glanz_light::{Pixels, PixelsError};
use glanz_math::DVec3;
use glanz_scene::Scene;

use super::facets::ExactMirror;
use super::particles::CELLS;
use super::room::{self, SIDE, WALLS};
use crate::clock::{Stopwatch, TimeScope};
use crate::report::Report;
use crate::study::{Settings, StudyError};
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{ColourScale, Table, TableCell};

/// Largest number of scattering events of a particle.
const EVENTS: u32 = 1000;

/// Smallest share of the mirror's light for which a wall is pictured.
const SHOWN: f64 = 0.02;

/// Relative standard error of the peak for which the time is estimated.
const GOAL: f64 = 0.01;

/// Illuminance on the walls, by particles.
pub(super) struct LuxMeasurement {
    pub(super) particles: u64,
    pub(super) maps: Vec<LuxMap>,
    /// Flux on each wall, lm.
    received: Vec<ReplicateEstimate>,
    balance: FluxBalance,
    /// Processor time of all threads.
    time: Duration,
    threads: usize,
}

/// The room with its walls, and receivers of `cells` x `cells` on them.
///
/// # Errors
/// None in practice: the scene is valid.
pub(super) fn room(cells: u32) -> Result<(Scene, Receivers), StudyError> {
    let mut description = room::description()?;
    add_walls(&mut description, DVec3::splat(SIDE));
    let scene = Scene::resolve(description)?.0;
    let requests = ReceiverRequest::of_scene(&scene, GridResolution::Cells([cells; 2]));
    let receivers = Receivers::try_new(&scene, &requests)?;
    Ok((scene, receivers))
}

/// Passes on the share of traced particles.
struct LuxProgress<'a> {
    particles: u64,
    on_progress: &'a mut dyn FnMut(f64),
}

impl ProgressSink<Tally> for LuxProgress<'_> {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        let sent = progress.count.map_or(0, |count| count.done);
        (self.on_progress)(sent as f64 / self.particles as f64);
    }
}

/// Traces `particles`; `on_progress` receives the completed share, [0, 1].
///
/// # Errors
/// [`StudyError::Interrupted`]; [`StudyError::Particles`].
pub(super) fn measure(
    scene: &Scene,
    receivers: &Receivers,
    particles: u64,
    settings: &Settings,
    on_progress: &mut dyn FnMut(f64),
) -> Result<LuxMeasurement, StudyError> {
    let threads = settings.threads.unwrap_or(1);
    let goal = TraceGoal { particles: Some(particles), ..TraceGoal::default() };
    let how = TraceSettings { seed: settings.seed, max_events: EVENTS, threads, goal, part: None };
    let stopwatch = Stopwatch::start(TimeScope::Process);
    let mut sink = LuxProgress { particles, on_progress };
    let outcome = trace(scene, receivers, &how, Tally::new(receivers, None), &mut sink, &settings.cancel)?;
    let time = stopwatch.elapsed();
    outcome.end.check()?;
    let tally = outcome.tally;
    Ok(LuxMeasurement {
        particles: tally.particles().total(),
        maps: tally.lux_maps(receivers),
        received: (0..receivers.as_slice().len()).map(|number| tally.received(receivers, number)).collect(),
        balance: tally.balance(),
        time,
        threads,
    })
}

impl LuxMeasurement {
    /// The summary table: the walls.
    pub(super) fn table(&self) -> Table {
        let columns = [
            ("wall", "wall"),
            ("min_lx", "smallest, lx"),
            ("mean_lx", "mean, lx"),
            ("max_lx", "largest, lx"),
            ("max_error_lx", "its standard error, lx"),
            ("u0", "U0"),
            ("flux_lm", "flux, lm"),
            ("flux_error_lm", "its standard error, lm"),
            ("time_to_goal_s", "time to 1 % of the largest, s"),
        ];
        let cells = self.maps.first().map_or(0, |map| map.cells[0]);
        let caption = format!(
            "Light on the walls of the room of document 000, {cells} x {cells} cells each, by {} particles. Times are those \
             of one thread until the standard error of the brightest cell is {} %.",
            grouped(self.particles),
            100.0 * GOAL
        );
        let mut table = Table::new("summary", caption, &columns);
        for (map, flux) in self.maps.iter().zip(&self.received) {
            let summary = map.summary();
            let maximum_error = map.statistics.map_or(f64::NAN, |statistics| statistics.maximum.error);
            let relative = maximum_error / summary.maximum;
            let time = self.time.as_secs_f64() * (relative / GOAL).powi(2);
            table.push([
                map.name.as_str().into(),
                summary.minimum.into(),
                summary.mean.into(),
                summary.maximum.into(),
                maximum_error.into(),
                summary.u0.into(),
                flux.value.into(),
                flux.error.into(),
                time.into(),
            ]);
        }
        table
    }

    /// Adds the section to the report, with pictures of the walls that receive light from the `mirror`.
    ///
    /// # Errors
    /// None in practice: the maps have few cells.
    pub(super) fn add_to(&self, report: &mut Report, mirror: &ExactMirror) -> Result<(), StudyError> {
        report.heading("Lux on the walls");
        let balance = &self.balance;
        let ends: Vec<String> = balance
            .ends()
            .iter()
            .map(|(end, lumens)| format!("{} lm were {end}", significant(*lumens)))
            .collect();
        report.paragraph(format!(
            "The lamp of the scene, a sphere of radius 0.1 m and uniform brightness, emits {} lm; {}. The balance closes to \
             {} of the emitted flux. {} particles took {} s of processor time ({}), {} ns each.",
            significant(balance.emitted),
            ends.join(", "),
            significant(balance.closes_to()),
            grouped(self.particles),
            significant(self.time.as_secs_f64()),
            plural(self.threads as u64, "thread", "threads"),
            significant(1e9 * self.time.as_secs_f64() / self.particles.max(1) as f64),
        ));
        let columns = [
            ("wall", "wall"),
            ("x_m", "x, m"),
            ("y_m", "y, m"),
            ("z_m", "z, m"),
            ("lux", "illuminance, lx"),
            ("error_lx", "standard error, lx"),
        ];
        let mut cells = Table::new("lux", "All cells:", &columns);
        for map in &self.maps {
            for ((p, lux), error) in map.positions.iter().zip(&map.lux).zip(&map.errors) {
                let place = p.to_array().map(TableCell::Number);
                let values = [TableCell::Number(*lux), TableCell::Number(*error)];
                cells.push(std::iter::once(map.name.as_str().into()).chain(place).chain(values));
            }
        }
        report.data(cells);
        let by_mirror = mirror.lux.chunks((CELLS * CELLS) as usize);
        for ((map, wall), by_mirror) in self.maps.iter().zip(WALLS).zip(by_mirror) {
            let share = by_mirror.iter().sum::<f64>() / mirror.lux.iter().sum::<f64>();
            if share.is_nan() || share < SHOWN {
                continue;
            }
            let key = wall.table.trim_start_matches("fan_");
            let scale = lux_scale(&[map]);
            let caption = format!(
                "The {}, which receives {} % of the light from the mirror, seen from inside the room: all light, by particles.",
                wall.name,
                significant(100.0 * share)
            );
            report.drawing(format!("isolux_{key}"), isolux(map, &scale), format!("Contours. {caption}"));
            report.picture(format!("lux_{key}"), coloured(map, &scale)?, format!("Every cell. {caption}"));
            let alone = LuxMap {
                name: format!("{}, the mirror's light", map.name),
                lux: by_mirror.to_vec(),
                errors: vec![mirror.noise; by_mirror.len()],
                statistics: None,
                ..map.clone()
            };
            let what =
                format!("The light from the mirror alone on the {}, by particles aimed at it.", wall.name);
            report.picture(format!("mirror_{key}"), coloured(&alone, &lux_scale(&[&alone]))?, what);
        }
        Ok(())
    }
}

/// A lux map in false colours.
fn coloured(map: &LuxMap, scale: &ColourScale) -> Result<Pixels, PixelsError> {
    let colours = false_colour(map, scale)?;
    Pixels::try_from_srgb8(colours.width(), colours.height(), colours.pixels())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_light_of_the_lamp_is_accounted_for() {
        let (scene, receivers) = room(4).unwrap();
        let lux = measure(&scene, &receivers, 100_000, &Settings::default(), &mut |_| {}).unwrap();
        // The lamp of 1000 lm that particles are aimed from; the scene file has six digits.
        assert!((lux.balance.emitted / room::LAMP.2 - 1.0).abs() < 1e-5, "{}", lux.balance.emitted);
        assert!(lux.balance.closes_to() < 1e-6 && lux.balance.escaped == 0.0);
        // The mirror keeps 1 - 0.9 of what meets it, which is less than a tenth of all.
        let kept = lux.balance.absorbed_elsewhere;
        assert!(kept > 0.0 && kept < 0.1 * 100.0, "{kept}");
        let on_walls: f64 = lux.received.iter().map(|lumens| lumens.value).sum();
        assert!((on_walls + kept - lux.balance.emitted).abs() < 1e-6 * lux.balance.emitted);
    }
}
