//! Illuminance of all cells of receivers by integration.

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink, WorkCount};
use glanz_math::DVec2;
use glanz_scene::{PlacedSurface, Scene};
use rayon::prelude::*;

use super::{CellMean, Reflections, Tolerance};
use crate::lux_map::LuxMap;
use crate::lux_parts::IntegratedLux;
use crate::receiver::{Receiver, Receivers};

/// Number of cells per thread between two reports of progress.
const PORTION: usize = 16;

/// Number of cells that estimate the mean illuminance of the scene.
const PROBES: usize = 64;

/// Accuracy of the illuminance of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellTolerance {
    /// Tolerance, relative to the cell.
    pub relative: f64,
    /// Share of the mean of all cells below which the tolerance is relative to that share: where it is dark, small errors are tolerated.
    pub dark: f64,
    /// Largest number of points in a cell, about; at an edge of the image of a lamp, errors beyond the tolerance are reported.
    pub points: usize,
}

impl Reflections<'_> {
    /// The mean illuminance of every cell, by the threads of the current pool. Covered parts of cells do not count.
    ///
    /// # Errors
    /// [`Interrupted`] if `cancel` is raised.
    pub fn cells<S: ?Sized>(
        &self,
        receivers: &Receivers,
        accuracy: CellTolerance,
        sink: &mut dyn ProgressSink<S>,
        cancel: &CancelFlag,
    ) -> Result<Vec<IntegratedLux>, Interrupted> {
        let start = Instant::now();
        let cells = cells(self.scene, receivers);
        let mean = |(receiver, surface, cell): &Cell<'_>, tolerance| {
            if receiver.areas()[*cell] <= 0.0 {
                return CellMean::default();
            }
            let patch = |at: DVec2| {
                let point = receiver.place(surface, *cell, at)?;
                Some((point.position, point.normal, point.area_element))
            };
            self.cell_mean(patch, tolerance, accuracy.points)
        };
        let probes: Vec<_> = cells.iter().step_by(cells.len().div_ceil(PROBES).max(1)).collect();
        let coarse = Tolerance { relative: 0.05, absolute: f64::MAX };
        let bright: f64 =
            probes.par_iter().map(|cell| mean(cell, coarse).mean).sum::<f64>() / probes.len().max(1) as f64;
        let CellTolerance { relative, dark, .. } = accuracy;
        let tolerance = Tolerance { relative, absolute: relative * dark * bright };
        let mut found: Vec<IntegratedLux> = Vec::with_capacity(cells.len());
        for portion in cells.chunks(PORTION * rayon::current_num_threads()) {
            cancel.check()?;
            found
                .par_extend(portion.par_iter().map(|cell| uncovered(cell, mean(cell, tolerance), tolerance)));
            let (done, all) = (found.len() as u64, cells.len() as u64);
            let count = WorkCount { done, wanted: Some(all), unit: ["cell", "cells"] };
            let progress = JobProgress::by_work("integration", done as f64 / all as f64, start.elapsed());
            sink.on_progress(&progress.with_count(count));
        }
        Ok(found)
    }
}

/// A cell: its receiver, the surface of that, and its number.
type Cell<'a> = (&'a Receiver, PlacedSurface<'a>, usize);

fn cells<'a>(scene: &'a Scene, receivers: &'a Receivers) -> Vec<Cell<'a>> {
    let placed = scene.placed_surfaces();
    let mut cells = Vec::with_capacity(receivers.cell_count());
    for receiver in receivers.as_slice() {
        if let Some(surface) = placed.get(receiver.surface() as usize) {
            cells.extend((0..receiver.len()).map(|cell| (receiver, surface.clone(), cell)));
        }
    }
    cells
}

/// The mean over the part of a cell that nothing covers: covered parts are dark.
fn uncovered((receiver, _, cell): &Cell<'_>, mean: CellMean, tolerance: Tolerance) -> IntegratedLux {
    let covered = receiver.covered().get(*cell).copied().unwrap_or_default();
    let open = if covered < 1.0 { 1.0 / (1.0 - covered) } else { 0.0 };
    let converged = mean.error <= tolerance.absolute.max(tolerance.relative * mean.mean);
    IntegratedLux { lux: mean.mean * open, error: mean.error * open, converged }
}

/// Lux maps of integrated light alone, from [`Reflections::cells`].
#[must_use]
pub fn integrated_maps(receivers: &Receivers, cells: &[IntegratedLux]) -> Vec<LuxMap> {
    let map = |(number, receiver): (usize, &Receiver)| {
        let own = cells.get(receivers.cells_of(number)).unwrap_or_default();
        LuxMap {
            name: receiver.name().to_owned(),
            cells: receiver.cells(),
            size: receiver.size().to_array(),
            positions: receiver.positions().to_vec(),
            areas: receiver.areas().to_vec(),
            lux: own.iter().map(|cell| cell.lux).collect(),
            errors: own.iter().map(|cell| cell.error).collect(),
            statistics: None,
        }
    };
    receivers.as_slice().iter().enumerate().map(map).collect()
}
