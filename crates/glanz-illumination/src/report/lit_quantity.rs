//! The quantity that a report for clients shows.

use crate::daylight::OUTDOOR_LUX;
use crate::lux_map::LuxStatistics;
use crate::{LuxMap, ReplicateEstimate};

use super::LuxReport;

/// A quantity in proportion to the calculated illuminance.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LitQuantity {
    /// Its name.
    #[serde(rename = "quantity")]
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value at a calculated illuminance of 1 lx.
    #[serde(rename = "per_calculated_lux")]
    pub factor: f64,
}

impl LitQuantity {
    /// The quantity of a report: daylight factors, or maintained illuminance if there is a maintenance factor, or illuminance.
    #[must_use]
    pub fn of(report: &LuxReport) -> Self {
        let maintenance = report.plan.as_ref().map_or(1.0, |plan| plan.maintenance_factor);
        if !report.daylight.is_empty() {
            Self { name: "daylight factor", unit: "%", factor: 100.0 / OUTDOOR_LUX }
        } else if maintenance == 1.0 {
            Self { name: "illuminance", unit: "lx", factor: 1.0 }
        } else {
            Self { name: "maintained illuminance", unit: "lx", factor: maintenance }
        }
    }

    /// Name and unit.
    #[must_use]
    pub fn label(&self) -> String {
        format!("{}, {}", self.name, self.unit)
    }

    /// The map in this quantity.
    #[must_use]
    pub fn map(&self, map: &LuxMap) -> LuxMap {
        let scaled = |list: &[f64]| list.iter().map(|value| self.factor * value).collect();
        let estimate = |estimate: ReplicateEstimate| estimate.scaled(self.factor);
        let statistics = map.statistics.map(|LuxStatistics { minimum, mean, maximum }| LuxStatistics {
            minimum: estimate(minimum),
            mean: estimate(mean),
            maximum: estimate(maximum),
        });
        LuxMap { lux: scaled(&map.lux), errors: scaled(&map.errors), statistics, ..map.clone() }
    }
}
