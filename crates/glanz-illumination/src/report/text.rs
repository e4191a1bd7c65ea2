//! Reports as tables, for terminals and pages.

use glanz_math::DVec3;
use glanz_report::number::significant;
pub(crate) use glanz_report::printable;
use glanz_report::{FactList, Table, TableCell};

use super::{LuxComparison, LuxReport};
use crate::{DaylightFactors, FarFieldSummary, FluxBalance, LuxMap, LuxSummary};

/// The first `most` of some things in a sentence, and the number of those left out.
pub(super) fn listed(things: &[String], most: usize) -> String {
    let left_out = things.len().saturating_sub(most);
    let shown = things.iter().take(most).map(String::as_str).collect::<Vec<_>>().join(", ");
    if left_out == 0 { shown } else { format!("{shown} and {left_out} more") }
}

/// Coordinates with this number of decimals.
pub(crate) fn shown_vector(vector: DVec3, decimals: usize) -> String {
    vector.to_array().map(|part| format!("{:.decimals$}", part + 0.0)).join(", ")
}

impl LuxReport {
    /// The summary for a terminal: the title, a line for each receiver, their intervals, the balance of the flux, the light that
    /// left the scene, and the facts.
    #[must_use]
    pub fn text(&self) -> String {
        let [receivers, intervals] =
            [receivers(&self.maps), intervals(&self.maps)].map(|table| table.plain());
        let mut text = format!("{}\n\n", printable(&self.title));
        if let Some(plan) = &self.plan {
            if !plan.verdicts.is_empty() {
                text += &format!("{}\n", plan.verdict_table().plain());
            }
            text += &format!("{}\n", plan.fact_table().plain());
        }
        if !self.daylight.is_empty() {
            text += &format!("{}\n", DaylightFactors::table(&self.daylight).plain());
        }
        text += &format!("{receivers}\n{intervals}");
        if let Some(balance) = &self.balance {
            text += &format!("\n{}{}\n", flux(balance).plain(), closing(balance));
        }
        if let Some(far) = &self.far_field {
            text += &format!("\n{}", far_field(far).plain());
        }
        if !self.facts.is_empty() {
            text += &format!("\n{}", calculation(&self.facts).plain());
        }
        text
    }
}

impl LuxComparison<'_> {
    /// The comparison for a terminal: for each receiver the figures of both designs and the change in per cent.
    #[must_use]
    pub fn text(&self) -> String {
        let titles = format!("A: {}\nB: {}\n", printable(&self.a.title), printable(&self.b.title));
        format!("{titles}\n{}", self.table().plain())
    }
}

/// A line for each receiver.
pub(super) fn receivers(maps: &[LuxMap]) -> Table {
    let columns = [
        ("receiver", "receiver"),
        ("minimum_lux", "min, lx"),
        ("mean_lux", "mean, lx"),
        ("maximum_lux", "max, lx"),
        ("u0", "U0"),
        ("u1", "U1"),
        ("area_m2", "area, m2"),
        ("flux_lm", "flux, lm"),
    ];
    let mut table = Table::new("receivers", "Illuminance on the receivers", &columns);
    for map in maps {
        let LuxSummary { minimum, mean, maximum, u0, u1, area, flux, .. } = map.summary();
        let numbers = [minimum, mean, maximum, u0, u1, area, flux].map(TableCell::Number);
        table.push(std::iter::once(TableCell::Text(printable(&map.name))).chain(numbers));
    }
    table
}

/// The intervals of these figures.
pub(super) fn intervals(maps: &[LuxMap]) -> Table {
    let columns = [
        ("receiver", "within"),
        ("minimum_lux", "min, lx"),
        ("mean_lux", "mean, lx"),
        ("maximum_lux", "max, lx"),
        ("u0", "U0"),
        ("u1", "U1"),
    ];
    let caption = "Intervals: 95 % by paths and particles, estimated bounds by integration";
    let mut table = Table::new("intervals", caption, &columns);
    for map in maps {
        let summary = map.summary();
        let intervals = [
            summary.minimum_interval,
            summary.mean_interval,
            summary.maximum_interval,
            summary.u0_interval,
            summary.u1_interval,
        ];
        let text =
            |[low, high]: [f64; 2]| TableCell::Text(format!("{} to {}", significant(low), significant(high)));
        table.push(std::iter::once(TableCell::Text(printable(&map.name))).chain(intervals.map(text)));
    }
    table
}

/// Table of the balance of the flux.
pub(super) fn flux(balance: &FluxBalance) -> Table {
    let columns = [("light", "light"), ("flux_lm", "flux, lm"), ("share", "share")];
    let mut table = Table::new("flux", "Where the light went", &columns);
    let share = |lumens: f64| match balance.emitted {
        emitted if emitted > 0.0 => TableCell::Text(format!("{:.2} %", 100.0 * lumens / emitted)),
        _ => TableCell::Missing,
    };
    let rows = std::iter::once(("emitted", balance.emitted)).chain(balance.ends());
    for (name, lumens) in rows {
        table.push([name.into(), lumens.into(), share(lumens)]);
    }
    table
}

/// A sentence with the error of the balance.
pub(super) fn closing(balance: &FluxBalance) -> String {
    format!("The balance closes to {} of what was emitted.", significant(balance.closes_to()))
}

/// Table of the light that left the scene.
pub(super) fn far_field(far: &FarFieldSummary) -> Table {
    let columns = [("quantity", "light that leaves the scene"), ("value", "")];
    let mut table = Table::new("far_field", "Light that leaves the scene", &columns);
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let direction = |[c, gamma]: [f64; 2]| format!("C {}, gamma {}", significant(c), significant(gamma));
    let angles = |[along, across]: [f64; 2]| {
        format!("{} in the plane of the middle, {} across it", significant(along), significant(across))
    };
    for (quantity, value) in [
        ("flux, lm", significant(far.flux)),
        ("peak, cd", significant(far.peak)),
        ("standard error of the peak", percent(far.peak_error / far.peak)),
        ("peak may be larger by", percent(far.peak_shortfall / far.peak)),
        ("largest standard error from a tenth of the peak", percent(far.largest_relative_error)),
        ("direction of the peak, degrees", direction(far.peak_direction)),
        ("middle of the beam, degrees", direction(far.middle)),
        ("beam angle (half of the peak), degrees", angles(far.beam_angles)),
        ("field angle (a tenth), degrees", angles(far.field_angles)),
        ("angles", format!("{} planes with {} gamma angles each", far.planes, far.gammas)),
    ] {
        table.push([quantity.into(), TableCell::Text(value)]);
    }
    table
}

/// Table of the facts of the calculation.
pub(super) fn calculation(facts: &FactList) -> Table {
    facts.table("calculation", "How it was calculated", "calculation", |_| true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_report::FactValue;

    #[test]
    fn long_lists_end_with_the_number_of_the_others() {
        let names: Vec<String> = ["a", "b", "c"].map(str::to_owned).to_vec();
        assert_eq!(
            [1, 2, 3].map(|most| listed(&names, most)),
            ["a and 2 more", "a, b and 1 more", "a, b, c"]
        );
    }

    #[test]
    fn columns_are_aligned_and_names_cannot_control_the_terminal() {
        let map = |name: &str, lux: [f64; 2]| LuxMap {
            name: name.into(),
            cells: [2, 1],
            size: [1.0, 1.0],
            positions: vec![DVec3::ZERO; 2],
            areas: vec![2.0; 2],
            lux: lux.to_vec(),
            errors: vec![0.5; 2],
            statistics: None,
        };
        let balance = FluxBalance {
            emitted: 1000.0,
            absorbed_by_receivers: 800.0,
            escaped: 199.0,
            ..FluxBalance::default()
        };
        let mut facts = FactList::default();
        facts.push("method", "method", "\u{1b}trace");
        facts.push("seed", "seed", FactValue::Whole(7));
        facts.push("particles", "particles", 2_000_000_u64);
        let report = LuxReport {
            title: "office".into(),
            maps: vec![map("desk", [100.0, 300.0]), map("the \u{1b}[2Jwall", [0.0, 0.0])],
            balance: Some(balance),
            far_field: None,
            daylight: Vec::new(),
            plan: None,
            planning: crate::planning::PlanningSettings::default(),
            layout: None,
            facts,
            polars: Vec::new(),
        };
        // 1 of 1000 lm is missing.
        let expected = "office\n\n\
            receiver      min, lx  mean, lx  max, lx      U0      U1  area, m2  flux, lm\n\
            desk            100.0     200.0    300.0  0.5000  0.3333     4.000     800.0\n\
            the \u{fffd}[2Jwall        0         0        0       0       0     4.000         0\n\
            \n\
            within        min, lx         mean, lx        max, lx         U0                U1\n\
            desk          99.50 to 100.5  199.5 to 200.5  299.5 to 300.5  0.4963 to 0.5038  0.3311 to 0.3356\n\
            the \u{fffd}[2Jwall  0 to 0.5000     0 to 0.5000     0 to 0.5000     0 to 1.000        0 to 1.000\n\
            \n\
            light                  flux, lm  share\n\
            emitted                    1000  100.00 %\n\
            absorbed by receivers     800.0  80.00 %\n\
            absorbed elsewhere            0  0.00 %\n\
            escaped                   199.0  19.90 %\n\
            given up                      0  0.00 %\n\
            The balance closes to 0.001000 of what was emitted.\n\
            \n\
            calculation\n\
            method       \u{fffd}trace\n\
            seed         7\n\
            particles    2 000 000\n";
        assert_eq!(report.text(), expected);
    }
}
