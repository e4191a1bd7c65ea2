//! Illuminance in the cells of receivers, for picks and scales.

use std::fmt;
use std::sync::Arc;

use glanz_scene::HitLocation;
use serde::Serialize;

use super::Model;

/// Largest number of runs of cells that the scale of a map is made from.
const MOST_RUNS: usize = 4096;

/// A cell of a lux map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LuxCell {
    /// Mean illuminance, lx.
    pub lux: f32,
    /// Its standard error, lx.
    pub error: f32,
    /// Area, m^2; 0 if the cell shows nothing.
    pub area: f32,
}

/// Illuminance at a point of a receiver: that of the cell there.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct LuxReading {
    /// Name of the receiver.
    pub receiver: String,
    /// Number of the cell along the first and the second direction of the receiver, from 0.
    pub cell: [u32; 2],
    /// Mean illuminance of the cell, lx.
    pub lux: f64,
    /// Standard error over the illuminance; `None` in the dark.
    pub relative_error: Option<f64>,
    /// Least illuminance of the receiver, lx.
    pub minimum: f64,
    /// Mean illuminance of the receiver, lx.
    pub mean: f64,
    /// Largest illuminance of the receiver, lx.
    pub maximum: f64,
}

/// Lux maps of a scene.
pub trait LuxLookup: fmt::Debug + Send + Sync {
    /// The illuminance at a point; `None` where no light is counted.
    fn reading(&self, at: &HitLocation) -> Option<LuxReading>;

    /// The cells of the maps on a surface, by its number in [`Scene::placed_surfaces`](glanz_scene::Scene::placed_surfaces).
    fn cells_on(&self, surface: u32) -> Vec<LuxCell>;
}

impl Model {
    /// The model with illuminances for picks, and with those of the surfaces that show a map for its scale.
    #[must_use]
    pub fn with_lux(mut self, lux: Arc<dyn LuxLookup>) -> Self {
        let has_map = |parts: &[(u32, u32)]| parts.iter().any(|&(_, object)| self.map_of(object).is_some());
        let shown = (0..).zip(&self.objects).filter(|(_, parts)| has_map(parts));
        let cells = shown.flat_map(|(surface, _)| lux.cells_on(surface)).collect();
        self.blocks.lux_cells = joined(cells);
        self.lux = Some(lux);
        self
    }

    /// The illuminance at a point; `None` where no light is counted.
    #[must_use]
    pub fn lux_at(&self, at: &HitLocation) -> Option<LuxReading> {
        self.lux.as_ref()?.reading(at)
    }

    /// Whether an object shows illuminances.
    #[must_use]
    pub fn has_lux(&self, object: u32) -> bool {
        self.lux.is_some() && self.map_of(object).is_some()
    }

    fn map_of(&self, object: u32) -> Option<usize> {
        self.head.objects.get(object as usize)?.map
    }
}

/// Illuminances and areas of cells by ascending illuminance, those without a number left out.
///
/// Of many cells, neighbours are joined to at most [`MOST_RUNS`] runs of about equal area with the largest illuminance of each: the share of the area that has
/// at most the illuminance of a run is exact. So are the least illuminance, the least one above 0 and the largest one.
fn joined(mut cells: Vec<LuxCell>) -> Vec<[f32; 2]> {
    cells.retain(|cell| cell.area > 0.0 && cell.area.is_finite() && cell.lux.is_finite());
    cells.sort_by(|a, b| a.lux.total_cmp(&b.lux));
    let ends = [0, cells.partition_point(|cell| cell.lux <= 0.0)];
    let area = |cells: &[LuxCell]| cells.iter().map(|cell| f64::from(cell.area)).sum::<f64>();
    // Runs are closed by their area, at both ends of the range and after the darkness.
    let least = if cells.len() <= MOST_RUNS { 0.0 } else { area(&cells) / (MOST_RUNS - 5) as f64 };
    let mut runs = Vec::new();
    let mut sum = 0.0;
    for (number, cell) in cells.iter().enumerate() {
        sum += f64::from(cell.area);
        let next = number + 1;
        if sum >= least || ends.contains(&number) || ends.contains(&next) || next + 1 >= cells.len() {
            runs.push([cell.lux, sum as f32]);
            sum = 0.0;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Illuminances i^2 on areas of 1 to 3 m^2, not in order; the first tenth is dark.
    fn cells(count: u32) -> Vec<LuxCell> {
        let cell = |i: u32| {
            let lux = if i < count / 10 { 0.0 } else { (i as f32).powi(2) };
            LuxCell { lux, error: 0.0, area: 1.0 + (i % 3) as f32 }
        };
        (0..count).map(|i| cell((i * 7919) % count)).collect()
    }

    #[test]
    fn runs_keep_the_ends_and_the_shares_of_the_area() {
        let count = 100_000;
        let runs = joined(cells(count));
        assert!(runs.len() <= MOST_RUNS && runs.len() > MOST_RUNS / 2, "{}", runs.len());
        let first_lit = (count / 10) as f32;
        assert_eq!(runs.first().unwrap()[0], 0.0);
        assert_eq!(runs.iter().find(|run| run[0] > 0.0).unwrap()[0], first_lit.powi(2));
        assert_eq!(runs.last().unwrap()[0], ((count - 1) as f32).powi(2));
        let mut sum = 0.0;
        for run in &runs {
            sum += f64::from(run[1]);
            // The cells i up to this one have 1, 2, 3, 1, ... m^2.
            let last = if run[0] > 0.0 { run[0].sqrt().round() as u32 } else { continue };
            let area = 6 * ((last + 1) / 3) + [0, 1, 3][(last as usize + 1) % 3];
            assert!((sum - f64::from(area)).abs() < 1e-6 * sum, "{run:?}: {sum} {area}");
        }
    }

    #[test]
    fn few_cells_are_kept_and_what_is_no_number_is_left_out() {
        let cell = |lux, area| LuxCell { lux, error: 0.0, area };
        let found = joined(vec![
            cell(80.0, 1.0),
            cell(f32::INFINITY, 1.0),
            cell(f32::NAN, 1.0),
            cell(20.0, 2.0),
            cell(5.0, 0.0),
            cell(0.0, 3.0),
        ]);
        assert_eq!(found, [[0.0, 3.0], [20.0, 2.0], [80.0, 1.0]]);
    }
}
