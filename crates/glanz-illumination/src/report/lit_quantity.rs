//! The quantity that a report for clients shows.

use glanz_report::CellField;

use crate::daylight::OUTDOOR_LUX;
use crate::{LuxMap, LuxSummary};

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
        let maintenance = report.maintenance_factor();
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

    /// The summary of a map in this quantity.
    #[must_use]
    pub fn summary(&self, map: &LuxMap) -> LuxSummary {
        map.summary().scaled(self.factor)
    }

    /// The cells of a map in this quantity.
    pub(super) fn field(&self, map: &LuxMap) -> CellField {
        let values: Vec<f64> = map.lux.iter().map(|lux| self.factor * lux).collect();
        CellField::new(map.cells, map.size, &map.areas, &values)
    }
}
