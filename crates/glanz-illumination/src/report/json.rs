//! A report as JSON.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::{LitQuantity, LuxReport};
use crate::planning::InstalledPower;
use crate::{LuxMap, LuxSummary};

/// The entry of one receiver.
#[derive(Serialize)]
struct ReceiverSummary<'a> {
    name: &'a str,
    cells: [u32; 2],
    size_m: [f64; 2],
    #[serde(flatten)]
    summary: LuxSummary,
}

impl<'a> ReceiverSummary<'a> {
    fn of(map: &'a LuxMap) -> Self {
        Self { name: &map.name, cells: map.cells, size_m: map.size, summary: map.summary() }
    }
}

/// The figures of the pages for a client.
#[derive(Serialize)]
struct ShownFigures {
    #[serde(flatten)]
    quantity: LitQuantity,
    /// For each receiver mean, least and largest value in the unit of the quantity; null where nothing of it receives light.
    receivers: Vec<ShownSummary>,
}

#[derive(Serialize)]
struct ShownSummary {
    name: String,
    mean: f64,
    minimum: f64,
    maximum: f64,
    u0: f64,
}

impl ShownFigures {
    fn of(report: &LuxReport) -> Self {
        let quantity = LitQuantity::of(report);
        let summary = |map: &LuxMap| {
            let LuxSummary { mean, minimum, maximum, u0, area, .. } = quantity.summary(map);
            let [mean, minimum, maximum, u0] =
                [mean, minimum, maximum, u0].map(|value| if area > 0.0 { value } else { f64::NAN });
            ShownSummary { name: map.name.clone(), mean, minimum, maximum, u0 }
        };
        Self { quantity, receivers: report.maps.iter().map(summary).collect() }
    }
}

/// The entry of the power.
#[derive(Serialize)]
struct PowerEntry {
    power_w: f64,
    area_m2: f64,
    w_m2: Option<f64>,
    reference: Option<String>,
    w_m2_100lx: Option<f64>,
}

impl PowerEntry {
    fn of(power: InstalledPower) -> Self {
        let (w_m2, w_m2_100lx) = (power.density(), power.density_per_100_lux());
        let reference = power.reference.map(|(name, _)| name);
        Self { power_w: power.watts, area_m2: power.area, w_m2, reference, w_m2_100lx }
    }
}

impl Serialize for LuxReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_map(None)?;
        fields.serialize_entry("title", &self.title)?;
        fields
            .serialize_entry("receivers", &self.maps.iter().map(ReceiverSummary::of).collect::<Vec<_>>())?;
        fields.serialize_entry("flux_balance", &self.balance)?;
        fields.serialize_entry("far_field", &self.far_field)?;
        if !self.daylight.is_empty() {
            fields.serialize_entry("daylight_factors", &self.daylight)?;
        }
        if let Some(plan) = &self.plan {
            fields.serialize_entry("plan", plan)?;
        }
        if let Some(layout) = &self.layout {
            fields.serialize_entry("room", layout)?;
            fields.serialize_entry("luminaires", &layout.luminaires)?;
            fields.serialize_entry("other_lights", &layout.other_lights)?;
        }
        fields.serialize_entry("shown", &ShownFigures::of(self))?;
        if let Some(power) = self.installed_power() {
            fields.serialize_entry("power", &PowerEntry::of(power))?;
        }
        fields.serialize_entry("facts", &self.facts)?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::PlanningSettings;
    use crate::{FarFieldSummary, FluxBalance};
    use glanz_math::DVec3;
    use glanz_report::{FactList, FactValue};

    #[test]
    fn keys_end_with_their_units() {
        let map = LuxMap {
            name: "a \"desk\"".into(),
            cells: [2, 1],
            size: [2.0, 0.5],
            positions: vec![DVec3::ZERO; 2],
            areas: vec![0.5; 2],
            lux: vec![100.0, 300.0],
            errors: vec![1.0, 2.0],
            statistics: None,
        };
        let mut facts = FactList::default();
        facts.push("method", "method", "trace");
        facts.push("time", "seconds", FactValue::Seconds(1.5));
        let report = LuxReport {
            title: "office".into(),
            maps: vec![map],
            balance: Some(FluxBalance { emitted: 400.0, escaped: 400.0, ..FluxBalance::default() }),
            far_field: Some(FarFieldSummary {
                flux: 400.0,
                peak: 900.0,
                peak_error: 9.0,
                peak_shortfall: 7.0,
                peak_direction: [30.0, 10.0],
                middle: [31.0, 11.0],
                beam_angles: [20.0, 21.0],
                field_angles: [40.0, 42.0],
                largest_relative_error: 0.05,
                planes: 24,
                gammas: 37,
                steps: [5.0, 3.0],
            }),
            daylight: Vec::new(),
            plan: None,
            planning: PlanningSettings::default(),
            layout: None,
            facts,
            polars: Vec::new(),
        };
        let expected = serde_json::json!({
            "title": "office",
            "receivers": [{
                "name": "a \"desk\"", "cells": [2, 1], "size_m": [2.0, 0.5],
                "minimum_lux": 100.0, "minimum_interval_lux": [99.0, 101.0],
                "mean_lux": 200.0, "mean_interval_lux": [198.5, 201.5],
                "maximum_lux": 300.0, "maximum_interval_lux": [298.0, 302.0],
                "u0": 0.5, "u0_interval": [99.0 / 201.5, 101.0 / 198.5],
                "u1": 100.0 / 300.0, "u1_interval": [99.0 / 302.0, 101.0 / 298.0],
                "area_m2": 1.0, "flux_lm": 200.0,
            }],
            "flux_balance": {
                "emitted_lm": 400.0, "absorbed_by_receivers_lm": 0.0, "absorbed_elsewhere_lm": 0.0,
                "escaped_lm": 400.0, "given_up_lm": 0.0, "closes_to": 0.0,
            },
            "far_field": {
                "flux_lm": 400.0, "peak_cd": 900.0, "peak_error_cd": 9.0, "peak_shortfall_cd": 7.0, "peak_direction_degrees": [30.0, 10.0],
                "middle_degrees": [31.0, 11.0], "beam_angles_degrees": [20.0, 21.0], "field_angles_degrees": [40.0, 42.0],
                "largest_relative_error": 0.05, "planes": 24, "gammas": 37, "steps_degrees": [5.0, 3.0],
            },
            "shown": {
                "quantity": "illuminance", "unit": "lx", "per_calculated_lux": 1.0,
                "receivers": [{ "name": "a \"desk\"", "mean": 200.0, "minimum": 100.0, "maximum": 300.0, "u0": 0.5 }],
            },
            "facts": { "method": "trace", "seconds": 1.5 },
        });
        assert_eq!(serde_json::to_value(&report).unwrap(), expected);
        let empty = serde_json::to_value(LuxReport::default()).unwrap();
        assert!(empty["flux_balance"].is_null() && empty["far_field"].is_null());
    }
}
