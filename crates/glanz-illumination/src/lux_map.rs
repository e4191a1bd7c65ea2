//! Illuminance over a receiver.

use glanz_math::DVec3;

use crate::receiver::Receiver;
use crate::replicates::ReplicateEstimate;

/// Illuminance in the cells of a receiver, row by row: cell (i, j) has number `j * cells[0] + i`.
///
/// All lists have one value per cell. A cell without area, where trimming leaves nothing of it or other things cover it, has area 0, and its
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
    /// Areas, m^2, without what other things cover.
    pub areas: Vec<f64>,
    /// Mean illuminances, lx.
    pub lux: Vec<f64>,
    /// Standard errors of `lux`, lx, which include the bounds of what is integrated; for integrated illuminance alone, these bounds.
    pub errors: Vec<f64>,
    /// Extremes and mean from replicates; `None` for integrated illuminance alone.
    pub statistics: Option<LuxStatistics>,
}

/// Estimates over the cells of a receiver, from replicates of its particles, lx.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuxStatistics {
    /// Least illuminance of a cell.
    pub minimum: ReplicateEstimate,
    /// Mean over the area.
    pub mean: ReplicateEstimate,
    /// Largest illuminance of a cell.
    pub maximum: ReplicateEstimate,
}

/// Summary of a receiver. Minimum and maximum are those of means over cells; by particles, they and the uniformities are estimates without a bias by
/// noise. Intervals hold the expected value with a probability of 95 % by particles, and are estimated bounds by integration. In JSON, the names of the fields
/// end with their units: `mean_lux`, `area_m2`, `flux_lm`.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct LuxSummary {
    /// Least illuminance, lx.
    #[serde(rename = "minimum_lux")]
    pub minimum: f64,
    /// Its interval, lx.
    #[serde(rename = "minimum_interval_lux")]
    pub minimum_interval: [f64; 2],
    /// Mean over the area, lx.
    #[serde(rename = "mean_lux")]
    pub mean: f64,
    /// Its interval, lx.
    #[serde(rename = "mean_interval_lux")]
    pub mean_interval: [f64; 2],
    /// Largest illuminance, lx.
    #[serde(rename = "maximum_lux")]
    pub maximum: f64,
    /// Its interval, lx.
    #[serde(rename = "maximum_interval_lux")]
    pub maximum_interval: [f64; 2],
    /// Uniformity U0: least over mean.
    pub u0: f64,
    /// Its interval.
    pub u0_interval: [f64; 2],
    /// Uniformity U1: least over largest.
    pub u1: f64,
    /// Its interval.
    pub u1_interval: [f64; 2],
    /// Area, m^2.
    #[serde(rename = "area_m2")]
    pub area: f64,
    /// Incident flux, lm.
    #[serde(rename = "flux_lm")]
    pub flux: f64,
}

impl LuxSummary {
    /// The summary of a map with all illuminances times `factor`.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        let ends = |interval: [f64; 2]| interval.map(|lux| factor * lux);
        Self {
            minimum: factor * self.minimum,
            minimum_interval: ends(self.minimum_interval),
            mean: factor * self.mean,
            mean_interval: ends(self.mean_interval),
            maximum: factor * self.maximum,
            maximum_interval: ends(self.maximum_interval),
            flux: factor * self.flux,
            ..self
        }
    }
}

impl LuxMap {
    /// The map of a receiver from illuminance and error of its cells, lx, without statistics.
    pub(crate) fn of(receiver: &Receiver, cells: impl Iterator<Item = (f64, f64)>) -> Self {
        let (lux, errors) = cells.unzip();
        Self {
            name: receiver.name().to_owned(),
            cells: receiver.cells(),
            size: receiver.size().to_array(),
            positions: receiver.positions().to_vec(),
            areas: receiver.areas().to_vec(),
            lux,
            errors,
            statistics: None,
        }
    }

    /// Summary of the map; all 0 for a receiver without area. The uniformities of a dark receiver are 0.
    #[must_use]
    pub fn summary(&self) -> LuxSummary {
        let area = self.areas.iter().sum();
        if area <= 0.0 {
            return LuxSummary::default();
        }
        let LuxStatistics { minimum, mean, maximum } = self.statistics.unwrap_or_else(|| self.bounds(area));
        let over = |whole: ReplicateEstimate| {
            uniformity((minimum.value, minimum.interval), (whole.value, whole.interval))
        };
        let ((u0, u0_interval), (u1, u1_interval)) = (over(mean), over(maximum));
        LuxSummary {
            minimum: minimum.value,
            minimum_interval: minimum.interval.map(|lux| lux.max(0.0)),
            mean: mean.value,
            mean_interval: mean.interval.map(|lux| lux.max(0.0)),
            maximum: maximum.value,
            maximum_interval: maximum.interval.map(|lux| lux.max(0.0)),
            u0,
            u0_interval,
            u1,
            u1_interval,
            area,
            flux: area * mean.value,
        }
    }

    /// Extremes and mean with the bounds that follow from those of the cells.
    fn bounds(&self, area: f64) -> LuxStatistics {
        let cells = || {
            let rows = self.areas.iter().zip(&self.lux).zip(&self.errors);
            rows.filter(|((area, _), _)| **area > 0.0).map(|((&area, &lux), &error)| (area, lux, error))
        };
        let mean = |value: fn(f64, f64) -> f64| {
            cells().map(|(area, lux, error)| area * value(lux, error)).sum::<f64>() / area
        };
        let least = |value: fn(f64, f64) -> f64| {
            cells().map(|(_, lux, error)| value(lux, error)).fold(f64::INFINITY, f64::min)
        };
        let largest =
            |value: fn(f64, f64) -> f64| cells().map(|(_, lux, error)| value(lux, error)).fold(0.0, f64::max);
        let estimate = |over: &dyn Fn(fn(f64, f64) -> f64) -> f64| {
            let interval = [over(|lux, error| lux - error), over(|lux, error| lux + error)];
            let value = over(|lux, _| lux);
            ReplicateEstimate { value, error: 0.5 * (interval[1] - interval[0]), interval }
        };
        LuxStatistics { minimum: estimate(&least), mean: estimate(&mean), maximum: estimate(&largest) }
    }
}

/// Least over mean or largest illuminance with its interval, from these with theirs, lx; 0 in the dark.
pub(crate) fn uniformity(
    (least, [low, high]): (f64, [f64; 2]),
    (whole, [lower, upper]): (f64, [f64; 2]),
) -> (f64, [f64; 2]) {
    let over = |least: f64, whole: f64| if whole > 0.0 { (least.max(0.0) / whole).min(1.0) } else { 0.0 };
    // Both at their worst at the same time.
    let most = if high > 0.0 && lower <= 0.0 { 1.0 } else { over(high, lower) };
    (over(least, whole), [over(low, upper), most])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(areas: [f64; 4], lux: [f64; 4], errors: [f64; 4]) -> LuxMap {
        LuxMap {
            name: "desk".into(),
            cells: [2, 2],
            size: [2.0, 2.0],
            positions: vec![DVec3::ZERO; 4],
            areas: areas.to_vec(),
            lux: lux.to_vec(),
            errors: errors.to_vec(),
            statistics: None,
        }
    }

    #[test]
    fn means_are_over_the_area_and_bounds_follow_from_those_of_cells() {
        let map = map([1.0, 3.0, 0.0, 1.0], [100.0, 300.0, 1e9, 50.0], [1.0, 2.0, 3.0, 4.0]);
        let summary = map.summary();
        // (100 + 900 + 50) / 5; the cell without area does not count.
        assert_eq!((summary.mean, summary.area, summary.flux), (210.0, 5.0, 1050.0));
        assert_eq!((summary.minimum, summary.maximum), (50.0, 300.0));
        assert_eq!((summary.minimum_interval, summary.maximum_interval), ([46.0, 54.0], [298.0, 302.0]));
        // (1 + 6 + 4) / 5 = 2.2.
        assert!((summary.mean_interval[0] - 207.8).abs() < 1e-12);
        assert_eq!((summary.u0, summary.u1), (50.0 / 210.0, 50.0 / 300.0));
        assert_eq!(summary.u1_interval, [46.0 / 302.0, 54.0 / 298.0]);
    }

    #[test]
    fn estimates_by_replicates_replace_extremes_of_noisy_cells() {
        let estimate =
            |value: f64| ReplicateEstimate { value, error: 1.0, interval: [value - 2.0, value + 2.0] };
        let statistics =
            LuxStatistics { minimum: estimate(60.0), mean: estimate(100.0), maximum: estimate(1.0) };
        let noisy =
            LuxMap { statistics: Some(statistics), ..map([1.0; 4], [40.0, 100.0, 120.0, 140.0], [1.0; 4]) };
        let summary = noisy.summary();
        assert_eq!(
            (summary.minimum, summary.u0, summary.u0_interval),
            (60.0, 0.6, [58.0 / 102.0, 62.0 / 98.0])
        );
        // A uniformity is never above 1, even where the largest is as good as unknown.
        assert_eq!((summary.u1, summary.u1_interval), (1.0, [1.0, 1.0]));
    }

    #[test]
    fn uniformities_of_a_dark_receiver_are_zero() {
        let dark = map([2.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]);
        assert_eq!(dark.summary(), LuxSummary { area: 2.0, ..LuxSummary::default() });
        assert_eq!(map([0.0; 4], [1.0; 4], [0.0; 4]).summary(), LuxSummary::default());
    }
}
