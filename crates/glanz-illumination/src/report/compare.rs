//! Comparison of two designs.

use glanz_report::number::significant;
use glanz_report::{CellField, ColourScale, HeatMap, Table, TableCell, levels};

use super::text::printable;
use super::{LuxReport, isolux_at, lux_scale};
use crate::{LuxMap, LuxSummary};

/// A quantity of a summary.
type Quantity = fn(&LuxSummary) -> f64;

/// Two reports with the pairs of their receivers.
#[derive(Clone, Debug)]
pub struct LuxComparison<'a> {
    /// The first design.
    pub a: &'a LuxReport,
    /// The design that it is compared with.
    pub b: &'a LuxReport,
    /// Receivers of the same name, in the order of `a`, then those of `b` alone.
    pub pairs: Vec<ReceiverPair<'a>>,
}

/// A receiver in both designs; one may be missing.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverPair<'a> {
    /// In the first design.
    pub a: Option<&'a LuxMap>,
    /// In the second.
    pub b: Option<&'a LuxMap>,
}

impl<'a> LuxComparison<'a> {
    /// Pairs receivers by name; several of one name are paired in their order.
    #[must_use]
    pub fn between(a: &'a LuxReport, b: &'a LuxReport) -> Self {
        let mut left: Vec<&LuxMap> = b.maps.iter().collect();
        let mut pairs = Vec::with_capacity(a.maps.len());
        for map in &a.maps {
            let found = left.iter().position(|other| other.name == map.name);
            pairs.push(ReceiverPair { a: Some(map), b: found.map(|place| left.remove(place)) });
        }
        pairs.extend(left.into_iter().map(|map| ReceiverPair { a: None, b: Some(map) }));
        Self { a, b, pairs }
    }

    /// The figures of both designs and the change from A to B in per cent of A, for each receiver.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns =
            [("receiver", "receiver"), ("quantity", ""), ("a", "A"), ("b", "B"), ("change", "change")];
        let mut table = Table::new("comparison", "Both designs and the change from A to B", &columns);
        let quantities: [(&str, Quantity); 6] = [
            ("min, lx", |summary| summary.minimum),
            ("mean, lx", |summary| summary.mean),
            ("max, lx", |summary| summary.maximum),
            ("U0", |summary| summary.u0),
            ("U1", |summary| summary.u1),
            ("flux, lm", |summary| summary.flux),
        ];
        for pair in &self.pairs {
            let (a, b) = (pair.a.map(LuxMap::summary), pair.b.map(LuxMap::summary));
            for (row, (quantity, of)) in quantities.into_iter().enumerate() {
                let name = if row == 0 { printable(pair.name()) } else { String::new() };
                let (a, b) = (a.as_ref().map(of), b.as_ref().map(of));
                let change = a.zip(b).and_then(|(a, b)| change(a, b));
                let change = change.map_or(TableCell::Missing, TableCell::Text);
                table.push([TableCell::Text(name), quantity.into(), a.into(), b.into(), change]);
            }
        }
        table
    }
}

impl<'a> ReceiverPair<'a> {
    /// The name of the receiver.
    #[must_use]
    pub fn name(&self) -> &'a str {
        self.a.or(self.b).map_or("", |map| map.name.as_str())
    }

    /// The maps as drawn by [`isolux`](super::isolux), with one scale and the same levels for both.
    #[must_use]
    pub fn isolux(&self) -> [Option<String>; 2] {
        let maps: Vec<&LuxMap> = [self.a, self.b].into_iter().flatten().collect();
        let scale = lux_scale(&maps);
        let summary = || maps.iter().map(|map| map.summary());
        let low = summary().map(|summary| summary.minimum).fold(f64::INFINITY, f64::min);
        let high = summary().map(|summary| summary.maximum).fold(0.0, f64::max);
        let levels = levels(low, high);
        [(self.a, "A"), (self.b, "B")].map(|(map, design)| {
            let named = map.map(|map| LuxMap { name: format!("{design}: {}", map.name), ..map.clone() });
            named.map(|map| isolux_at(&map, &scale, &levels))
        })
    }

    /// The difference B - A, cell by cell, as SVG in diverging colours over a scale symmetric about 0; `None`
    /// unless both designs have the receiver with the same cells.
    #[must_use]
    pub fn difference(&self) -> Option<String> {
        let (a, b) = self.a.zip(self.b).filter(|(a, b)| a.cells == b.cells)?;
        let numbers: Vec<f64> = a.lux.iter().zip(&b.lux).map(|(a, b)| b - a).collect();
        let areas = a.areas.iter().zip(&b.areas);
        let areas = areas.map(|(a, b)| if *a > 0.0 && *b > 0.0 { 0.5 * (a + b) } else { 0.0 });
        let areas: Vec<f64> = areas.collect();
        let field = CellField::new(a.cells, a.size, &areas, &numbers);
        let (low, high) = field.shown().fold((0.0_f64, 0.0_f64), |(l, h), (v, _)| (l.min(v), h.max(v)));
        let caption = vec![format!(
            "From {} lx (less light in B) to {} lx (more light in B).",
            significant(low),
            significant(high)
        )];
        let scale = ColourScale::of_differences(high.max(-low));
        let title = format!("B - A: {}", a.name);
        Some(HeatMap { caption, ..HeatMap::new(&title, "lx", field, scale) }.svg())
    }
}

/// The change from `a` to `b` in per cent of `a`; `None` if `a` is 0.
fn change(a: f64, b: f64) -> Option<String> {
    let percent = 100.0 * (b - a) / a;
    percent.is_finite().then(|| format!("{percent:+.1} %"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::DVec3;

    fn map(name: &str, lux: [f64; 2]) -> LuxMap {
        LuxMap {
            name: name.into(),
            cells: [2, 1],
            size: [2.0, 1.0],
            positions: vec![DVec3::ZERO; 2],
            areas: vec![1.0; 2],
            lux: lux.to_vec(),
            errors: vec![0.0; 2],
            statistics: None,
        }
    }

    fn report(title: &str, maps: Vec<LuxMap>) -> LuxReport {
        LuxReport { title: title.into(), maps, ..LuxReport::default() }
    }

    #[test]
    fn receivers_of_one_name_are_paired_in_their_order() {
        let a = report("old", vec![map("x", [1.0, 1.0]), map("only a", [0.0, 0.0]), map("x", [2.0, 2.0])]);
        let b = report("new", vec![map("only b", [0.0, 0.0]), map("x", [3.0, 3.0]), map("x", [4.0, 4.0])]);
        let compared = LuxComparison::between(&a, &b);
        let lux = |map: Option<&LuxMap>| map.map(|map| map.lux[0]);
        let pairs: Vec<_> = compared.pairs.iter().map(|p| (p.name(), lux(p.a), lux(p.b))).collect();
        assert_eq!(
            pairs,
            [
                ("x", Some(1.0), Some(3.0)),
                ("only a", Some(0.0), None),
                ("x", Some(2.0), Some(4.0)),
                ("only b", None, Some(0.0))
            ]
        );
        assert_eq!(compared.pairs[1].difference(), None);
        assert!(compared.pairs[1].isolux()[1].is_none());
    }

    #[test]
    fn changes_are_in_per_cent_of_the_first() {
        let (a, b) = (
            report("old", vec![map("desk", [0.0, 400.0])]),
            report("new", vec![map("desk", [100.0, 200.0])]),
        );
        let expected = "A: old\nB: new\n\n\
            receiver                A       B  change\n\
            desk      min, lx       0   100.0  -\n\
            \u{20}         mean, lx  200.0   150.0  -25.0 %\n\
            \u{20}         max, lx   400.0   200.0  -50.0 %\n\
            \u{20}         U0            0  0.6667  -\n\
            \u{20}         U1            0  0.5000  -\n\
            \u{20}         flux, lm  400.0   300.0  -25.0 %\n";
        assert_eq!(LuxComparison::between(&a, &b).text(), expected);
    }

    #[test]
    fn scale_of_differences_is_symmetric_about_zero() {
        let (a, b) = (map("desk", [10.0, 400.0]), map("desk", [60.0, 200.0]));
        let pair = ReceiverPair { a: Some(&a), b: Some(&b) };
        let svg = pair.difference().unwrap();
        // -200 lx is the lower end; +50 lx lies at 5/8 of the way, in step 40 of 64 from below.
        assert!(svg.contains("From -200.0 lx (less light in B) to 50.00 lx"));
        let step = |number: f64| {
            glanz_report::hexadecimal(ColourScale::of_differences(200.0).colour_at((number + 0.5) / 64.0))
        };
        assert!(svg.contains(&format!("fill=\"{}\" d=\"M0 0h1v1h-1z\"", step(40.0))), "{svg}");
        assert!(svg.contains(&format!("fill=\"{}\" d=\"M1 0h1v1h-1z\"", step(0.0))));
        let other = LuxMap { cells: [1, 2], ..b.clone() };
        assert_eq!(ReceiverPair { a: Some(&a), b: Some(&other) }.difference(), None);
        // Both maps share the scale of 0 to 400 lx.
        let [first, second] = pair.isolux().map(Option::unwrap);
        let bar = |svg: &str| svg.split("width=\"18\"").nth(1).map(str::to_owned).unwrap();
        assert_eq!(bar(&first), bar(&second));
        assert!(first.contains(">400</text>") && second.contains(">400</text>"));
    }
}
