//! Light by integration over mirrors, with progress.

use std::time::Instant;

use glanz_illumination::integrate::{CellMean, Reflections, Tolerance};
use glanz_illumination::{LuxMap, Receiver};
use glanz_job::{CancelFlag, JobProgress, WorkCount};
use glanz_math::DVec2;
use glanz_scene::PlacedSurface;
use rayon::prelude::*;

use super::{Design, pace};
use crate::arguments::IlluminateArguments;
use crate::messages::{Failure, Messages};
use crate::progress::Progress;
use crate::report::plural;

/// Cells between two looks at the clock, for every thread.
const PORTION: usize = 16;

/// Cells whose middles tell how bright a scene is.
const PROBES: usize = 64;

/// Places of a cell at most: where the image of a lamp has an edge, errors beyond the tolerance are told.
const POINTS: usize = 300;

/// What was integrated.
pub(super) struct Integrated {
    pub(super) maps: Vec<LuxMap>,
    pub(super) how: Vec<(String, String)>,
}

/// Maps of all receivers; `None` if the user wanted an end.
///
/// # Errors
/// Why there are none.
pub(super) fn integrated(
    design: &mut Design,
    arguments: &IlluminateArguments,
    messages: Messages,
    cancel: &CancelFlag,
) -> Result<Option<Integrated>, Failure> {
    let scattering = design.scene.materials().iter().filter(|material| material.is_rough()).count() as u64;
    let Design { file, scene, receivers, .. } = design;
    let start = Instant::now();
    let reflections = Reflections::new(scene)
        .map_err(|error| Failure::new(error.to_string()).with_help("\"--method trace\" takes every lamp"))?;
    let unreflected = reflections.unreflected().count() as u64;
    if unreflected > 0 {
        let lights = plural(unreflected, "light has", "lights have");
        file.warn(&format!("{lights} no extent: what mirrors make of them is not integrated"), messages);
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
            Some((point.position, point.normal, point.stretch))
        };
        reflections.cell_mean(patch, tolerance, POINTS)
    };
    // Where it is dark, what matters is small against the mean of all.
    let probes: Vec<_> = cells.iter().step_by(cells.len().div_ceil(PROBES).max(1)).collect();
    let coarse = Tolerance { relative: 0.05, absolute: f64::MAX };
    let bright: f64 =
        probes.par_iter().map(|cell| mean(cell, coarse).mean).sum::<f64>() / probes.len().max(1) as f64;
    let tolerance = Tolerance { relative: arguments.tolerance, absolute: arguments.tolerance * bright };
    let mut progress = Progress::start(messages);
    let mut found: Vec<CellMean> = Vec::with_capacity(cells.len());
    for portion in cells.chunks(PORTION * rayon::current_num_threads()) {
        if cancel.is_cancelled() {
            progress.finish();
            return Ok(None);
        }
        found.par_extend(portion.par_iter().map(|cell| mean(cell, tolerance)));
        let share = found.len() as f64 / cells.len() as f64;
        let (done, wanted) = (found.len() as u64, Some(cells.len() as u64));
        let count = WorkCount { done, wanted, unit: ["cell integrated", "cells integrated"] };
        progress.show(&JobProgress::by_work("integration", share, start.elapsed()).with_count(count));
    }
    progress.finish();
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
            lux: own.iter().map(|mean| mean.mean).collect(),
            errors: own.iter().map(|mean| mean.error).collect(),
        });
    }
    let mut how = vec![
        (
            "integration".to_owned(),
            "straight from the lamps and by one mirror; errors are estimated bounds".to_owned(),
        ),
        ("cells".to_owned(), pace(cells.len() as u64, start.elapsed().as_secs_f64(), "cells")),
    ];
    if scattering > 0 {
        let materials =
            plural(scattering, "material scatters, unless it is", "materials scatter, unless they are");
        how.push(("left out by integration".to_owned(), format!("what {materials} black")));
    }
    Ok(Some(Integrated { maps, how }))
}
