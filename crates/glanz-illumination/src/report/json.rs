//! A report as JSON.

use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use super::LuxReport;
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

impl Serialize for LuxReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct(
            "Report",
            5 + usize::from(self.plan.is_some()) + usize::from(!self.daylight.is_empty()),
        )?;
        fields.serialize_field("title", &self.title)?;
        fields
            .serialize_field("receivers", &self.maps.iter().map(ReceiverSummary::of).collect::<Vec<_>>())?;
        fields.serialize_field("flux_balance", &self.balance)?;
        fields.serialize_field("far_field", &self.far_field)?;
        if !self.daylight.is_empty() {
            fields.serialize_field("daylight_factors", &self.daylight)?;
        }
        if let Some(plan) = &self.plan {
            fields.serialize_field("plan", plan)?;
        }
        fields.serialize_field("facts", &self.facts)?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            "facts": { "method": "trace", "seconds": 1.5 },
        });
        assert_eq!(serde_json::to_value(&report).unwrap(), expected);
        let empty = serde_json::to_value(LuxReport::default()).unwrap();
        assert!(empty["flux_balance"].is_null() && empty["far_field"].is_null());
    }
}
