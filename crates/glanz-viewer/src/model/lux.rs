//! Illuminance in the cells of receivers, for picks and scales.

use std::fmt;
use std::sync::Arc;

use glanz_scene::HitLocation;
use serde::Serialize;

use super::Model;

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

    /// The cells of all maps.
    fn cells(&self) -> Vec<LuxCell>;
}

impl Model {
    /// The model with illuminances for picks, and with those of all cells for the scale of the map that was added last.
    #[must_use]
    pub fn with_lux(mut self, lux: Arc<dyn LuxLookup>) -> Self {
        let shown = lux.cells().into_iter().filter(|cell| cell.area > 0.0);
        self.blocks.lux_cells = shown.map(|cell| [cell.lux, cell.area]).collect();
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
        self.lux.is_some()
            && self.head.objects.get(object as usize).is_some_and(|object| object.map.is_some())
    }
}
