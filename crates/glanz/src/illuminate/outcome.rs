//! Result of a calculation of illuminance.

use std::sync::Arc;

use glanz_illumination::report::{LuxReport, PolarPlot};
use glanz_illumination::{FarField, FarFieldSummary, LuxMap, Tally};
use glanz_job::JobEnd;
use glanz_report::{FactList, FactValue};

use super::design::Design;
use crate::event::Warning;
use crate::running_job::RunningJob;

/// Combined standard errors beyond which two methods differ; the name of a fact has this number, too.
const APART: f64 = 4.0;

/// Illuminance on the receivers of a scene.
#[derive(Clone, Debug)]
pub struct IlluminateOutcome {
    /// Lux maps of the receivers, the flux balance, and facts about the calculation.
    pub report: LuxReport,
    /// Maps by integration, if both methods were used.
    pub integrated: Vec<LuxMap>,
    /// Sums over all particles, if particles were traced.
    pub tally: Option<Tally>,
    /// Reason for the end of the calculation.
    pub end: JobEnd,
    /// Warnings, in order of occurrence.
    pub warnings: Vec<Warning>,
    /// Number of rays of the ray file, if one was wanted; 0 if none was written, because no light leaves the scene.
    pub rays: Option<u64>,
    pub(super) far_field: Option<FarField>,
    /// The scene of a completed calculation, if it is kept for a ray file.
    pub(super) design: Option<Arc<Design>>,
}

impl Default for IlluminateOutcome {
    fn default() -> Self {
        let (report, integrated, tally, warnings, rays) = Default::default();
        let (end, far_field, design) = (JobEnd::Complete, None, None);
        Self { report, integrated, tally, end, warnings, rays, far_field, design }
    }
}

impl IlluminateOutcome {
    /// Intensities of the light that left the scene by direction, if they were counted.
    #[must_use]
    pub fn far_field(&self) -> Option<&FarField> {
        self.far_field.as_ref()
    }

    /// Adds the far field to the report, with warnings about it.
    pub(super) fn set_far_field(&mut self, far_field: Option<FarField>, job: &mut RunningJob<'_>) {
        if let Some((far, summary)) = far_field.as_ref().and_then(|far| Some((far, far.summary()?))) {
            self.report.polars.extend(polar(&self.report.title, far, &summary));
            if let Some([beam, step]) = summary.coarse() {
                job.warn(Warning::CoarseFarField { beam, step });
            } else if summary.is_noisy() {
                job.warn(Warning::NoisyFarField { error: summary.largest_relative_error });
            }
            self.report.far_field = Some(summary);
        }
        self.far_field = far_field;
    }
}

/// The distribution as a polar plot, in the plane of its beam and across it.
fn polar(title: &str, far: &FarField, summary: &FarFieldSummary) -> Option<PolarPlot> {
    let (distribution, [plane, gamma]) = (far.distribution().ok()?, summary.middle);
    let gammas: Vec<f64> = far.grid.gammas().iter().copied().chain([gamma]).collect();
    let title = format!("{title}: light that leaves the scene");
    Some(PolarPlot::sample(title, plane, &gammas, |c, gamma| distribution.at(c, gamma)))
}

/// Adds the differences between maps of the same cells, in combined standard errors, to the facts.
pub(super) fn compare_methods(traced: &[LuxMap], integrated: &[LuxMap], facts: &mut FactList) {
    let (mut cells, mut apart, mut worst) = (0_u64, 0_u64, 0.0_f64);
    let (mut flux, mut other) = (0.0, 0.0);
    for (a, b) in traced.iter().zip(integrated) {
        for cell in (0..a.areas.len()).filter(|&cell| a.areas[cell] > 0.0) {
            let error = a.errors[cell].hypot(b.errors[cell]);
            let distance = (a.lux[cell] - b.lux[cell]).abs() / error;
            cells += 1;
            apart += u64::from(distance > APART);
            worst = worst.max(distance);
            flux += a.lux[cell] * a.areas[cell];
            other += b.lux[cell] * b.areas[cell];
        }
    }
    facts.push("compared cells", "compared_cells", cells);
    facts.push("cells more than 4 combined standard errors apart", "cells_apart", apart);
    facts.push("largest difference, combined standard errors", "largest_difference_standard_errors", worst);
    let name = "flux by trace, more than by integration";
    facts.push(name, "relative_flux_difference", FactValue::Fraction(flux / other - 1.0));
}
