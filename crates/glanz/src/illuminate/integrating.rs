//! Illuminance by integration over mirrors.

use std::time::Instant;

use glanz_illumination::integrate::{CellMean, Reflections, Tolerance};
use glanz_illumination::{LuxMap, Receiver};
use glanz_job::{JobProgress, WorkCount};
use glanz_math::DVec2;
use glanz_scene::PlacedSurface;
use glanz_shading::Material;
use rayon::prelude::*;

use super::Design;
use super::facts::CalculationFacts;
use crate::error::Error;
use crate::event::Warning;
use crate::running_job::RunningJob;
use crate::smoothness::is_smooth;

/// Number of cells per thread between two reports of progress.
const PORTION: usize = 16;

/// Number of cells that estimate the mean illuminance of the scene.
const PROBES: usize = 64;

/// Largest number of points in a cell: at an edge of the image of a lamp, errors beyond the tolerance are reported.
const POINTS: usize = 300;

/// Whether a material scatters light in other directions than those of mirrors and clear glass.
fn scatters(material: &Material) -> bool {
    match material {
        Material::Mirror(_) | Material::Interface => false,
        Material::Conductor(metal) => !is_smooth(&metal.roughness),
        Material::Dielectric(glass) => !glass.thin && !is_smooth(&glass.roughness),
        _ => true,
    }
}

/// Means over the parts of the cells that nothing covers: covered ones are dark.
fn uncovered(receiver: &Receiver, means: &[CellMean], value: impl Fn(&CellMean) -> f64) -> Vec<f64> {
    let open = |covered: &f64| if *covered < 1.0 { 1.0 / (1.0 - covered) } else { 0.0 };
    means.iter().zip(receiver.covered()).map(|(mean, covered)| value(mean) * open(covered)).collect()
}

/// Maps of all receivers.
pub(super) fn integrated(
    design: &Design,
    job: &mut RunningJob<'_>,
    facts: &mut CalculationFacts,
) -> Result<Vec<LuxMap>, Error> {
    let Design { scene, receivers, options, .. } = design;
    let scattering = scene.materials().iter().filter(|material| scatters(material)).count() as u64;
    let start = Instant::now();
    let reflections = Reflections::new(scene)?;
    let unreflected = reflections.unreflected().count() as u64;
    if unreflected > 0 {
        job.warn(Warning::Unreflected { lights: unreflected });
    }
    let placed = scene.placed_surfaces();
    let mut cells: Vec<(&Receiver, &PlacedSurface<'_>, usize)> = Vec::new();
    for receiver in receivers.as_slice() {
        if let Some(surface) = placed.get(receiver.surface() as usize) {
            cells.extend((0..receiver.len()).map(|cell| (receiver, surface, cell)));
        }
    }
    let mean = |&(receiver, surface, cell): &(&Receiver, &PlacedSurface<'_>, usize), tolerance| {
        if receiver.areas()[cell] <= 0.0 {
            return CellMean::default();
        }
        let patch = |at: DVec2| {
            let point = receiver.place(surface, cell, at)?;
            Some((point.position, point.normal, point.area_element))
        };
        reflections.cell_mean(patch, tolerance, POINTS)
    };
    // Where it is dark, errors that are small against the mean of all cells are tolerated.
    let probes: Vec<_> = cells.iter().step_by(cells.len().div_ceil(PROBES).max(1)).collect();
    let coarse = Tolerance { relative: 0.05, absolute: f64::MAX };
    let bright: f64 =
        probes.par_iter().map(|cell| mean(cell, coarse).mean).sum::<f64>() / probes.len().max(1) as f64;
    let relative = options.tolerance;
    let tolerance = Tolerance { relative, absolute: relative * bright };
    let mut found: Vec<CellMean> = Vec::with_capacity(cells.len());
    for portion in cells.chunks(PORTION * rayon::current_num_threads()) {
        job.options.cancel.check()?;
        found.par_extend(portion.par_iter().map(|cell| mean(cell, tolerance)));
        if let Some(sink) = &mut job.options.sink {
            let (done, all) = (found.len() as u64, cells.len() as u64);
            let count = WorkCount { done, wanted: Some(all), unit: ["cell", "cells"] };
            let progress = JobProgress::by_work("integration", done as f64 / all as f64, start.elapsed());
            sink.on_progress(&progress.with_count(count));
        }
    }
    let mut rest = found.as_slice();
    let mut maps = Vec::new();
    for receiver in receivers.as_slice() {
        let (own, tail) = rest.split_at(receiver.len().min(rest.len()));
        rest = tail;
        maps.push(LuxMap {
            name: receiver.name().to_owned(),
            cells: receiver.cells(),
            size: receiver.size().to_array(),
            positions: receiver.positions().to_vec(),
            areas: receiver.areas().to_vec(),
            lux: uncovered(receiver, own, |mean| mean.mean),
            errors: uncovered(receiver, own, |mean| mean.error),
            statistics: None,
        });
    }
    let light = "direct light and light after one mirror; errors are estimated bounds";
    facts.result.push("integrated light", "integrated_light", light);
    facts.result.push("integrated cells", "integrated_cells", cells.len() as u64);
    let name = "materials that scatter, left out by integration unless black";
    facts.result.push(name, "scattering_materials", scattering);
    facts.push_rate("cells per second", "cells_per_second", cells.len() as u64, start.elapsed());
    Ok(maps)
}
