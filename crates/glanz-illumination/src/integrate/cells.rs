//! Illuminance of all cells of receivers by integration.

use std::time::Instant;

use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink, WorkCount};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};
use rayon::prelude::*;

use super::{CellMean, Reflections, Tolerance, direct};
use crate::lux_map::LuxMap;
use crate::lux_parts::IntegratedLux;
use crate::receiver::{Receiver, Receivers};

/// Number of cells per thread between two reports of progress.
const PORTION: usize = 64;

/// Number of cells that estimate the mean illuminance of a receiver.
const PROBES: usize = 64;

/// Points of a cell at which shadows of lights without extent show between the nodes of the rules, and the steps of their additive sequence.
const SHADOW_PROBES: u32 = 64;
const SHADOW_STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// Accuracy of the illuminance of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellTolerance {
    /// Tolerance, relative to the cell.
    pub relative: f64,
    /// Share of the mean of the receiver below which the tolerance is relative to that share: where it is dark, small errors are tolerated.
    pub dark: f64,
    /// Largest number of points in a square of a cell, about, see [`Reflections::cell_mean`]; at an edge of the image of a lamp, errors beyond the tolerance are
    /// reported.
    pub points: usize,
    /// Time from which on no cell is begun: those that are left are as if they did not converge.
    pub until: Option<Instant>,
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
        let is_over = || cancel.is_cancelled() || accuracy.until.is_some_and(|until| Instant::now() >= until);
        let mean = |Cell { receiver, surface, cell, .. }: &Cell<'_>, tolerance| {
            if receiver.areas()[*cell] <= 0.0 || !receiver.has_places(*cell) || is_over() {
                return CellMean::default();
            }
            self.cell_mean(patch(receiver, surface, *cell), tolerance, accuracy.points)
        };
        let coarse = Tolerance { relative: 0.05, absolute: f64::MAX };
        let brightness = |number: usize| {
            let own = cells.get(receivers.cells_of(number)).unwrap_or_default();
            let probes: Vec<_> = own.iter().step_by(own.len().div_ceil(PROBES).max(1)).collect();
            probes.par_iter().map(|cell| mean(cell, coarse).mean).sum::<f64>() / probes.len().max(1) as f64
        };
        let bright: Vec<f64> = (0..receivers.as_slice().len()).map(brightness).collect();
        let CellTolerance { relative, dark, .. } = accuracy;
        let integrated = |cell: &Cell<'_>| {
            let tolerance = Tolerance { relative, absolute: relative * dark * bright[cell.number] };
            let found = uncovered(cell, mean(cell, tolerance), tolerance);
            let is_smooth = self.integrates_shadows || self.is_evenly_lit(cell);
            IntegratedLux { converged: found.converged && is_smooth, ..found }
        };
        let mut found: Vec<IntegratedLux> = Vec::with_capacity(cells.len());
        for portion in cells.chunks(PORTION * rayon::current_num_threads()) {
            found.par_extend(portion.par_iter().map(integrated));
            let (done, all) = (found.len() as u64, cells.len() as u64);
            let count = WorkCount { done, wanted: Some(all), unit: ["cell", "cells"] };
            let progress = JobProgress::by_work("integration", done as f64 / all as f64, start.elapsed());
            sink.on_progress(&progress.with_count(count));
            cancel.check()?;
        }
        Ok(found)
    }
}

impl Reflections<'_> {
    /// Whether each light without extent reaches all points of a cell that face it, or none: shadows between the nodes of the rules would be missed.
    fn is_evenly_lit(&self, Cell { receiver, surface, cell, .. }: &Cell<'_>) -> bool {
        let places = (0..SHADOW_PROBES).map(|k| (f64::from(k) * SHADOW_STEP).fract());
        let points: Vec<_> = places.filter_map(|at| receiver.place(surface, *cell, at)).collect();
        self.points.iter().all(|(_, light)| {
            let mut reached = points.iter().filter_map(|point| {
                let arriving = light.incident(point.position)?;
                let faces = point.normal.dot(arriving.towards) > 0.0 && !arriving.irradiance.is_black();
                let (receiver, origin) = self.receiving(point.position, point.normal);
                faces.then(|| direct::of_point(self.scene, receiver, origin, light, &self.wavelengths) > 0.0)
            });
            let first = reached.next();
            reached.all(|reaches| Some(reaches) == first)
        })
    }
}

/// Position, normal and area element by the parameters of a cell.
pub(super) fn patch<'a>(
    receiver: &'a Receiver,
    surface: &'a PlacedSurface<'_>,
    cell: usize,
) -> impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)> + 'a {
    move |at| {
        let point = receiver.place(surface, cell, at)?;
        Some((point.position, point.normal, point.area_element))
    }
}

/// A cell of a receiver.
struct Cell<'a> {
    /// Number of the receiver.
    number: usize,
    receiver: &'a Receiver,
    surface: PlacedSurface<'a>,
    /// Its number in the receiver.
    cell: usize,
}

fn cells<'a>(scene: &'a Scene, receivers: &'a Receivers) -> Vec<Cell<'a>> {
    let placed = scene.placed_surfaces();
    let mut cells = Vec::with_capacity(receivers.cell_count());
    for (number, receiver) in receivers.as_slice().iter().enumerate() {
        if let Some(surface) = placed.get(receiver.surface() as usize) {
            let numbers = 0..receiver.len();
            cells.extend(numbers.map(|cell| Cell { number, receiver, surface: surface.clone(), cell }));
        }
    }
    cells
}

/// The mean over the part of a cell that nothing covers: covered parts are dark.
fn uncovered(cell: &Cell<'_>, mean: CellMean, tolerance: Tolerance) -> IntegratedLux {
    let covered = cell.receiver.covered().get(cell.cell).copied().unwrap_or_default();
    let per_open_share = if covered < 1.0 { 1.0 / (1.0 - covered) } else { 0.0 };
    let [lux, error] = [mean.mean, mean.error].map(|mean| mean * per_open_share);
    // A cell none of whose points is on the surface is not known.
    let converged = mean.area > 0.0 && error <= tolerance.absolute.max(tolerance.relative * lux);
    IntegratedLux { lux, error, converged }
}

/// Lux maps of integrated light alone, from [`Reflections::cells`].
#[must_use]
pub fn integrated_maps(receivers: &Receivers, cells: &[IntegratedLux]) -> Vec<LuxMap> {
    let map = |(number, receiver): (usize, &Receiver)| {
        let own = cells.get(receivers.cells_of(number)).unwrap_or_default();
        LuxMap::of(receiver, own.iter().map(|cell| (cell.lux, cell.error)))
    };
    receivers.as_slice().iter().enumerate().map(map).collect()
}
