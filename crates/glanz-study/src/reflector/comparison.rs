//! Comparison of illuminance by particles and by integration.

use std::time::Duration;

use glanz_illumination::integrate::{CellMean, Reflections, Tolerance};
use glanz_math::DVec2;
use rayon::prelude::*;

use super::lux;
use crate::clock::{Stopwatch, TimeScope};
use crate::report::Report;
use crate::study::{Settings, StudyError};
use glanz_report::Table;
use glanz_report::number::{grouped, plural, significant};
use glanz_report::{Axis, Plot, Series};

/// Tolerance of the integration, relative to a cell's illuminance and to the mean of the room: well below the error of the particles.
const TOLERANCE: f64 = 5e-3;

/// Number of cells along a side of a wall, and largest number of points in a cell.
pub(super) const CELLS: u32 = 16;
pub(super) const POINTS: usize = 300;

/// Cells between two checks of the cancel flag.
const PORTION: usize = 64;

/// Differences counted by the table, in combined standard errors.
const LEVELS: [f64; 3] = [2.0, 3.0, 4.0];

/// Share of numbers of Student's distribution with 15 degrees of freedom, that of errors from 16 replicates, beyond these differences, per cent.
const STUDENT: [f64; 3] = [6.395, 0.8973, 0.1159];

/// Density of this distribution at 0.
const STUDENT_PEAK: f64 = 0.392_35;

/// Width of the bins of the plot, standard errors.
const BIN: f64 = 0.25;

/// Differences between particles and integration in all cells.
pub(super) struct IntegrationComparison {
    /// Per wall: its name, and the difference of every cell, combined standard errors.
    walls: Vec<(String, Vec<f64>)>,
    /// Total over all walls, lm: by particles, by integration.
    flux: [f64; 2],
    /// Largest estimated error of the integration, as a share of the cell's illuminance.
    worst_error: f64,
    /// Processor time of the integration, all threads.
    time: Duration,
}

/// Traces `particles` to walls of `cells` x `cells` cells and integrates over each cell with at most `points` points;
/// `on_progress` receives the completed share, [0, 1].
///
/// # Errors
/// [`StudyError::Interrupted`]; [`StudyError::Threads`].
pub(super) fn measure(
    (cells, points): (u32, usize),
    particles: u64,
    settings: &Settings,
    on_progress: &mut dyn FnMut(f64),
) -> Result<IntegrationComparison, StudyError> {
    let (scene, receivers) = lux::room(cells)?;
    let traced = lux::measure(&scene, &receivers, particles, settings, &mut |done| on_progress(0.1 * done))?;
    let maps = &traced.maps;
    let stopwatch = Stopwatch::start(TimeScope::Process);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads.unwrap_or(1)).build()?;
    let reflections = Reflections::new(&scene)?;
    let placed = scene.placed_surfaces();
    let area: f64 = maps.iter().flat_map(|map| &map.areas).sum();
    let by_particles: f64 = maps.iter().map(|map| map.summary().flux).sum();
    let tolerance = Tolerance { relative: TOLERANCE, absolute: TOLERANCE * by_particles / area };
    let mut walls = Vec::new();
    let (mut by_integration, mut worst_error) = (0.0, 0.0_f64);
    for (number, (receiver, map)) in receivers.as_slice().iter().zip(maps).enumerate() {
        let Some(surface) = placed.get(receiver.surface() as usize) else { continue };
        let mean = |cell: usize| {
            let patch = |at: DVec2| {
                let point = receiver.place(surface, cell, at)?;
                Some((point.position, point.normal, point.area_element))
            };
            reflections.cell_mean(patch, tolerance, points)
        };
        let mut found: Vec<CellMean> = Vec::with_capacity(receiver.len());
        while found.len() < receiver.len() {
            settings.cancel.check()?;
            let done = (number as f64 + found.len() as f64 / receiver.len() as f64) / maps.len() as f64;
            on_progress(0.1 + 0.9 * done);
            let portion = found.len()..(found.len() + PORTION).min(receiver.len());
            found.extend(pool.install(|| portion.into_par_iter().map(mean).collect::<Vec<_>>()));
        }
        by_integration += found.iter().map(|cell| cell.mean * cell.area).sum::<f64>();
        let errors = found.iter().filter(|cell| cell.mean > 0.0).map(|cell| cell.error / cell.mean);
        worst_error = errors.fold(worst_error, f64::max);
        let differences = found.iter().zip(&map.lux).zip(&map.errors).map(|((cell, lux), error)| {
            let combined = error.hypot(cell.error);
            if combined > 0.0 { (lux - cell.mean) / combined } else { 0.0 }
        });
        walls.push((map.name.clone(), differences.collect()));
    }
    Ok(IntegrationComparison {
        walls,
        flux: [by_particles, by_integration],
        worst_error,
        time: stopwatch.elapsed(),
    })
}

/// Number of differences, number beyond each level, largest, and root mean square, in standard errors.
fn counted(differences: &[f64]) -> (u64, [u64; 3], f64, f64) {
    let beyond = LEVELS.map(|level| differences.iter().filter(|d| d.abs() > level).count() as u64);
    let largest = differences.iter().map(|d| d.abs()).fold(0.0, f64::max);
    let squares: f64 = differences.iter().map(|d| d * d).sum();
    (differences.len() as u64, beyond, largest, (squares / differences.len().max(1) as f64).sqrt())
}

impl IntegrationComparison {
    fn all(&self) -> Vec<f64> {
        self.walls.iter().flat_map(|(_, differences)| differences.iter().copied()).collect()
    }

    /// Adds the section to the report.
    pub(super) fn add_to(&self, report: &mut Report) {
        report.heading("Particles and integration");
        let columns = [
            ("wall", "wall"),
            ("cells", "cells"),
            ("rms_errors", "difference, rms, standard errors"),
            ("above_2_percent", "above 2, %"),
            ("above_3_percent", "above 3, %"),
            ("above_4_percent", "above 4, %"),
            ("above_4", "above 4, cells"),
            ("largest_errors", "largest"),
        ];
        let caption = "Differences of the cells, particles minus integration, in combined standard errors; the last row is \
         the expectation for errors from 16 replicates.";
        let mut table = Table::new("against", caption, &columns);
        let all = self.all();
        let named = self.walls.iter().map(|(name, differences)| (name.as_str(), differences.as_slice()));
        for (name, differences) in named.chain([("all", all.as_slice())]) {
            let (cells, beyond, largest, rms) = counted(differences);
            let [two, three, four] = beyond.map(|n| 100.0 * n as f64 / cells.max(1) as f64);
            table.push([
                name.into(),
                cells.into(),
                rms.into(),
                two.into(),
                three.into(),
                four.into(),
                beyond[2].into(),
                largest.into(),
            ]);
        }
        let [two, three, four] = STUDENT;
        table.push([
            "Student's distribution".into(),
            None::<u64>.into(),
            1.0.into(),
            two.into(),
            three.into(),
            four.into(),
        ]);
        report.table(table);
        report.plot("against", self.plot(&all), "All cells of all walls.");
        let (cells, beyond, largest, _) = counted(&all);
        let [particles, integral] = self.flux;
        report.paragraph(format!(
            "Of {} cells {} by more than 4 combined standard errors; the largest difference is {}. The walls receive {} lm \
             by particles and {} lm by integration, which took {} s of processor time and has an estimated error of at most \
             {} % of a cell's illuminance.",
            grouped(cells),
            if beyond[2] == 0 { "none differs".to_owned() } else { plural(beyond[2], "differs", "differ") },
            significant(largest),
            significant(particles),
            significant(integral),
            significant(self.time.as_secs_f64()),
            significant(100.0 * self.worst_error)
        ));
    }

    fn plot(&self, all: &[f64]) -> Plot {
        let bins = (all.iter().map(|d| d.abs()).fold(4.0, f64::max) / BIN).ceil() as i32;
        let middle = |bin: i32| (f64::from(bin) + 0.5) * BIN;
        let measured = (-bins..bins).map(|bin| {
            let [low, high] = [bin, bin + 1].map(|b| f64::from(b) * BIN);
            [middle(bin), all.iter().filter(|d| (low..high).contains(*d)).count() as f64]
        });
        let scale = all.len() as f64 * BIN * STUDENT_PEAK;
        let expected =
            (-bins..bins).map(|bin| [middle(bin), scale * (1.0 + middle(bin).powi(2) / 15.0).powi(-8)]);
        Plot {
            title: "Particles minus integration".to_owned(),
            x: Axis::linear("difference of a cell, combined standard errors"),
            y: Axis::linear(format!("cells per {BIN} standard errors")),
            series: vec![
                Series { name: "measured".to_owned(), points: measured.collect() },
                Series { name: "Student's distribution".to_owned(), points: expected.collect() },
            ],
            reference_lines: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_beyond_their_levels() {
        let (cells, beyond, largest, rms) = counted(&[0.0, -2.5, 3.5, 4.5, -5.0]);
        assert_eq!((cells, beyond, largest), (5, [4, 3, 2], 5.0));
        // (6.25 + 12.25 + 20.25 + 25) / 5 = 12.75.
        assert!((rms - 12.75_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn particles_and_integration_agree_in_the_room() {
        // 24 independent differences, none above 4 but in one run of 650.
        let settings = Settings::default();
        let comparison = measure((2, 65), 100_000, &settings, &mut |_| {}).unwrap();
        let (cells, beyond, largest, _) = counted(&comparison.all());
        assert_eq!((cells, beyond[2]), (24, 0), "{largest}");
        let [particles, integral] = comparison.flux;
        assert!((particles / integral - 1.0).abs() < 0.02, "{particles} {integral}");
    }
}
