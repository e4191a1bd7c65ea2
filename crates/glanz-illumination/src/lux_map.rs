//! Illuminance over a receiver.

use glanz_math::DVec3;

/// Illuminance in the cells of a receiver, row by row: cell (i, j) has number `j * cells[0] + i`.
///
/// All lists have one value per cell. A cell without area, where trimming leaves nothing of it, has area 0, and its
/// illuminance is undefined.
#[derive(Clone, Debug, PartialEq)]
pub struct LuxMap {
    /// Name of the receiver.
    pub name: String,
    /// Number of cells along the first and the second direction of the receiver.
    pub cells: [u32; 2],
    /// Lengths of the receiver along both directions through its middle, metres; the proportions of its picture.
    pub size: [f64; 2],
    /// Middles of the cells in the world, metres.
    pub positions: Vec<DVec3>,
    /// Areas, m^2.
    pub areas: Vec<f64>,
    /// Mean illuminances, lx.
    pub lux: Vec<f64>,
    /// Standard errors of `lux`, lx; for integrated illuminance, estimated bounds of the error.
    pub errors: Vec<f64>,
}

/// Summary of a receiver. Minimum and maximum are those of means over cells. In JSON, the names of the fields
/// end with their units: `mean_lux`, `area_m2`, `flux_lm`.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct LuxSummary {
    /// Least illuminance, lx.
    #[serde(rename = "minimum_lux")]
    pub minimum: f64,
    /// Mean over the area, lx.
    #[serde(rename = "mean_lux")]
    pub mean: f64,
    /// Largest illuminance, lx.
    #[serde(rename = "maximum_lux")]
    pub maximum: f64,
    /// Uniformity U0: least over mean.
    pub u0: f64,
    /// Uniformity U1: least over largest.
    pub u1: f64,
    /// Area, m^2.
    #[serde(rename = "area_m2")]
    pub area: f64,
    /// Incident flux, lm.
    #[serde(rename = "flux_lm")]
    pub flux: f64,
    /// Standard error of `maximum`, lx.
    #[serde(rename = "maximum_error_lux")]
    pub maximum_error: f64,
}

impl LuxMap {
    /// Summary of the map; all 0 for a receiver without area. The uniformities of a dark receiver are 0.
    #[must_use]
    pub fn summary(&self) -> LuxSummary {
        let mut summary = LuxSummary { minimum: f64::INFINITY, ..LuxSummary::default() };
        let rows = self.areas.iter().zip(&self.lux).zip(&self.errors);
        for ((&area, &lux), &error) in rows.filter(|((area, _), _)| **area > 0.0) {
            summary.area += area;
            summary.flux += area * lux;
            summary.minimum = summary.minimum.min(lux);
            if lux >= summary.maximum {
                (summary.maximum, summary.maximum_error) = (lux, error);
            }
        }
        if summary.area == 0.0 {
            return LuxSummary::default();
        }
        summary.mean = summary.flux / summary.area;
        let over = |whole: f64| if whole > 0.0 { summary.minimum / whole } else { 0.0 };
        (summary.u0, summary.u1) = (over(summary.mean), over(summary.maximum));
        summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_the_area() {
        let map = LuxMap {
            name: "desk".into(),
            cells: [2, 2],
            size: [2.0, 2.0],
            positions: vec![DVec3::ZERO; 4],
            areas: vec![1.0, 3.0, 0.0, 1.0],
            lux: vec![100.0, 300.0, 1e9, 50.0],
            errors: vec![1.0, 2.0, 3.0, 4.0],
        };
        let summary = map.summary();
        // (100 + 900 + 50) / 5; the cell without area does not count.
        assert_eq!((summary.mean, summary.area, summary.flux), (210.0, 5.0, 1050.0));
        assert_eq!((summary.minimum, summary.maximum, summary.maximum_error), (50.0, 300.0, 2.0));
        assert_eq!((summary.u0, summary.u1), (50.0 / 210.0, 50.0 / 300.0));
    }

    #[test]
    fn uniformities_of_a_dark_receiver_are_zero() {
        let map = LuxMap {
            name: String::new(),
            cells: [1, 1],
            size: [1.0, 1.0],
            positions: vec![DVec3::ZERO],
            areas: vec![2.0],
            lux: vec![0.0],
            errors: vec![0.0],
        };
        assert_eq!(map.summary(), LuxSummary { area: 2.0, ..LuxSummary::default() });
        assert_eq!(LuxMap { areas: vec![0.0], ..map }.summary(), LuxSummary::default());
    }
}
