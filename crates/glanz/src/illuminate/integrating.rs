//! Illuminance by integration over mirrors.

use std::time::Instant;

use glanz_illumination::integrate::{CellTolerance, Reflections, integrated_maps};
use glanz_illumination::{IntegratedLux, LuxMap};

use super::design::Design;
use super::facts::CalculationFacts;
use crate::error::Error;
use crate::event::Warning;
use crate::running_job::{JobSink, RunningJob};

/// Largest number of points in a square of a cell, see [`CellTolerance::points`].
const POINTS: usize = 300;

/// The cells of all receivers.
pub(super) fn cells(
    design: &Design,
    reflections: &Reflections<'_>,
    accuracy: CellTolerance,
    job: &mut RunningJob<'_>,
) -> Result<Vec<IntegratedLux>, Error> {
    let cancel = job.options.cancel.clone();
    let mut sink = JobSink::new(job, None, |_: &std::path::Path, (): &()| Ok(()));
    Ok(reflections.cells(&design.receivers, accuracy, &mut sink, &cancel)?)
}

/// Maps of all receivers.
pub(super) fn integrated(
    design: &Design,
    job: &mut RunningJob<'_>,
    facts: &mut CalculationFacts,
) -> Result<Vec<LuxMap>, Error> {
    let scene = &design.scene;
    let is_left_out =
        |material: &&glanz_shading::Material| !material.is_specular() && !material.is_interface();
    let scattering = scene.materials().iter().filter(is_left_out).count() as u64;
    let start = Instant::now();
    let reflections = Reflections::new(scene)?;
    let unreflected = reflections.unreflected().count() as u64;
    if unreflected > 0 {
        job.warn(Warning::Unreflected { lights: unreflected });
    }
    let relative = design.options.tolerance;
    let accuracy = CellTolerance { relative, dark: 1.0, points: POINTS, until: None };
    let cells = cells(design, &reflections, accuracy, job)?;
    let light = "direct light and light after one mirror; errors are estimated bounds";
    facts.result.push("integrated light", "integrated_light", light);
    facts.result.push("integrated cells", "integrated_cells", cells.len() as u64);
    let name = "materials that scatter, left out by integration unless black";
    facts.result.push(name, "scattering_materials", scattering);
    facts.push_rate("cells per second", "cells_per_second", cells.len() as u64, start.elapsed());
    Ok(integrated_maps(&design.receivers, &cells))
}
