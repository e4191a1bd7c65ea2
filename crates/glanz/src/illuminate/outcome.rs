//! Result of a calculation of illuminance.

use glanz_illumination::report::{LuxReport, PolarPlot};
use glanz_illumination::{FarField, LuxMap, Tally};
use glanz_job::JobEnd;
use glanz_report::{FactList, FactValue};

use crate::event::Warning;

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
    pub(super) far_field: Option<FarField>,
}

impl Default for IlluminateOutcome {
    fn default() -> Self {
        let (report, integrated, tally, warnings, far_field) = Default::default();
        Self { report, integrated, tally, end: JobEnd::Complete, warnings, far_field }
    }
}

impl IlluminateOutcome {
    /// Directions of light that left the scene, if they were counted.
    #[must_use]
    pub fn far_field(&self) -> Option<&FarField> {
        self.far_field.as_ref()
    }

    pub(super) fn set_far_field(&mut self, far_field: Option<FarField>) {
        if let Some(far) = &far_field {
            self.report.polars.push(polar(&self.report.title, far));
        }
        self.far_field = far_field;
    }
}

/// The distribution as a polar plot.
fn polar(title: &str, far: &FarField) -> PolarPlot {
    let (planes, gammas) = (far.grid.planes().len(), far.grid.gammas().len());
    let candela = |c: f64, gamma: f64| {
        let plane = (c / 360.0 * planes as f64).round() as usize;
        let place = gamma / 180.0 * (gammas - 1) as f64;
        let (low, share) = (place.floor() as usize, place.fract());
        far.at(plane, low) * (1.0 - share) + far.at(plane, (low + 1).min(gammas - 1)) * share
    };
    PolarPlot::sample(format!("{title}: light that leaves the scene"), None, candela)
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
