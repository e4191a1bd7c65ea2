//! Daylight under an overcast sky.

use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_report::{Table, TableCell};
use glanz_scene::Description;
use glanz_scene::description::LightDescription;

use crate::lux_map::LuxMap;

/// Illuminance of the open ground under the sky of [`under_overcast_sky`], lx.
pub const OUTDOOR_LUX: f64 = 10_000.0;

/// Replaces all light of a scene by the overcast sky of the CIE, with z up, which gives the open ground [`OUTDOOR_LUX`]. The ground reflects a fifth.
pub fn under_overcast_sky(description: &mut Description) {
    let irradiance = (OUTDOOR_LUX / LUMINOUS_EFFICACY) as f32;
    description.lights = vec![LightDescription::overcast_sky(irradiance)];
    let groups = description.groups.iter_mut().chain([&mut description.world]);
    groups.flat_map(|group| &mut group.shapes).for_each(|shape| shape.emission = None);
}

/// Daylight factors of a receiver: shares of the illuminance of the open ground.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DaylightFactors {
    /// Name of the receiver.
    pub name: String,
    /// Mean over its area.
    pub mean: f64,
    /// The daylight factor that half of its area reaches.
    pub median: f64,
    /// Least of a cell.
    pub minimum: f64,
}

impl DaylightFactors {
    /// Those of a map under the sky of [`under_overcast_sky`].
    #[must_use]
    pub fn of(map: &LuxMap) -> Self {
        let summary = map.summary();
        let mut cells: Vec<(f64, f64)> = map.lux.iter().copied().zip(map.areas.iter().copied()).collect();
        cells.retain(|(_, area)| *area > 0.0);
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut area = 0.0;
        let half = cells.iter().find(|(_, own)| {
            area += own;
            area >= 0.5 * summary.area
        });
        let share = |lux: f64| lux / OUTDOOR_LUX;
        Self {
            name: map.name.clone(),
            mean: share(summary.mean),
            median: share(half.map_or(0.0, |(lux, _)| *lux)),
            minimum: share(summary.minimum),
        }
    }

    /// A table of the factors of several receivers, per cent.
    pub(crate) fn table(all: &[Self]) -> Table {
        let columns =
            [("receiver", "receiver"), ("mean", "mean, %"), ("median", "median, %"), ("minimum", "min, %")];
        let mut table = Table::new("daylight", "Daylight factors under an overcast sky", &columns);
        for Self { name, mean, median, minimum } in all {
            let numbers = [mean, median, minimum].map(|share| TableCell::Number(100.0 * share));
            table.push(std::iter::once(TableCell::Text(crate::report::printable(name))).chain(numbers));
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::DVec3;

    #[test]
    fn half_of_the_area_reaches_the_median() {
        let map = LuxMap {
            name: "floor".into(),
            cells: [4, 1],
            size: [4.0, 1.0],
            positions: vec![DVec3::ZERO; 4],
            areas: vec![1.0, 2.0, 0.0, 1.0],
            lux: vec![500.0, 200.0, 9e9, 100.0],
            errors: vec![0.0; 4],
            statistics: None,
        };
        let DaylightFactors { mean, median, minimum, .. } = DaylightFactors::of(&map);
        // 500 + 2 * 200 + 100 of four squares.
        assert_eq!([mean, median, minimum], [0.025, 0.02, 0.01]);
    }
}
