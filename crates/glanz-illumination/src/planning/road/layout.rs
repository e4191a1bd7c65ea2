//! Luminaires along a road.

use std::sync::Arc;

use glanz_math::{DMat3, DVec3};

use crate::planning::luminaire::PlacedLuminaire;
use crate::planning::room::LuminaireKind;

/// Arrangement of the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowArrangement {
    /// One row, on the right.
    SingleSided,
    /// Two rows face to face.
    Opposite,
    /// Two rows, the left one moved by half a spacing.
    Staggered,
}

/// An endless row of luminaires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuminaireRow {
    /// Position across the road, metres.
    pub y: f64,
    /// A luminaire is at this place along the road, metres.
    pub start: f64,
    /// Turn about the vertical from x towards y, radians: 0 if the road is to the left of the row, pi if it is to the right.
    pub turn: f64,
}

/// A straight road with luminaires of one kind.
#[derive(Clone, Debug)]
pub struct RoadLayout {
    /// The luminaires.
    pub luminaire: LuminaireKind,
    /// Rows.
    pub rows: Vec<LuminaireRow>,
    /// Spacing along a row, metres.
    pub spacing: f64,
    /// Height of the photometric centres, metres.
    pub height: f64,
    /// Turn of the luminaires about their own axis from C0 towards C90, radians; 0 if the side of the road is C90 in the file.
    pub turn: f64,
    /// Tilt that raises the side of the road, radians.
    pub tilt: f64,
    /// Number of lanes.
    pub lanes: u32,
    /// Width of each, metres.
    pub lane_width: f64,
}

/// A length of a road out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value}; it must be from {least} to {most}")]
pub struct RoadError {
    /// The quantity, with its unit.
    pub what: &'static str,
    /// Its value.
    pub value: f64,
    /// The least allowed value.
    pub least: f64,
    /// The largest one.
    pub most: f64,
}

impl LuminaireRow {
    /// The rows of an arrangement on a carriageway of this width. `overhang`: distance of the photometric centres from the edge towards its middle, metres; negative beside it.
    #[must_use]
    pub fn of_arrangement(arrangement: RowArrangement, width: f64, spacing: f64, overhang: f64) -> Vec<Self> {
        let right = Self { y: overhang, start: 0.0, turn: 0.0 };
        let left = Self { y: width - overhang, start: 0.0, turn: std::f64::consts::PI };
        match arrangement {
            RowArrangement::SingleSided => vec![right],
            RowArrangement::Opposite => vec![right, left],
            RowArrangement::Staggered => vec![right, Self { start: 0.5 * spacing, ..left }],
        }
    }
}

impl RoadLayout {
    /// Checks all lengths and numbers.
    ///
    /// # Errors
    /// [`RoadError`] for the first that is out of range.
    pub fn check(&self) -> Result<(), RoadError> {
        let lengths = [
            ("the spacing of the luminaires, m,", self.spacing, 1.0, 500.0),
            // Below the eye there is no street lighting.
            ("the height of the luminaires, m,", self.height, 2.0, 100.0),
            ("the tilt of the luminaires, degrees,", self.tilt.to_degrees(), -90.0, 90.0),
            ("the turn of the luminaires, degrees,", self.turn.to_degrees(), -360.0, 360.0),
            ("the number of lanes", f64::from(self.lanes), 1.0, 20.0),
            ("the width of a lane, m,", self.lane_width, 0.5, 20.0),
            ("the number of rows", self.rows.len() as f64, 1.0, 100.0),
        ];
        let places = self.rows.iter().flat_map(|row| {
            [("the place of a row across the road, m,", row.y), ("its place along the road, m,", row.start)]
        });
        let places = places.map(|(what, value)| (what, value, -1000.0, 1000.0));
        for (what, value, least, most) in lengths.into_iter().chain(places) {
            if !(least..=most).contains(&value) {
                return Err(RoadError { what, value, least, most });
            }
        }
        Ok(())
    }

    /// Width of the carriageway, metres.
    #[must_use]
    pub fn width(&self) -> f64 {
        f64::from(self.lanes) * self.lane_width
    }

    /// All luminaires from `from` to `to` along the road, metres.
    #[must_use]
    pub fn luminaires(&self, from: f64, to: f64) -> Vec<PlacedLuminaire> {
        let mut placed = Vec::new();
        for row in &self.rows {
            let first = ((from - row.start) / self.spacing).ceil() as i64;
            let last = ((to - row.start) / self.spacing).floor() as i64;
            let own = DMat3::from_rotation_z(self.turn);
            let axes = DMat3::from_rotation_z(row.turn) * DMat3::from_rotation_x(self.tilt) * own;
            placed.extend((first..=last).map(|number| PlacedLuminaire {
                name: self.luminaire.description.label().to_owned(),
                description: Some(Arc::clone(&self.luminaire.description)),
                distribution: Arc::clone(&self.luminaire.distribution),
                factor: 1.0,
                opening: self.luminaire.description.opening,
                position: DVec3::new(row.start + number as f64 * self.spacing, row.y, self.height),
                axes,
            }));
        }
        placed
    }

    /// Places of the points along the field, metres.
    #[must_use]
    pub fn stations(&self) -> Vec<f64> {
        // A spacing of a whole multiple of 3 m, but for rounding, needs no further point.
        let count = if self.spacing <= 30.0 { 10 } else { (self.spacing / 3.0 - 1e-9).ceil() as u32 };
        middles(0.0, self.spacing, count)
    }
}

/// Middles of equal parts of a length from `start` on.
pub(super) fn middles(start: f64, length: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| start + (f64::from(i) + 0.5) * length / f64::from(count)).collect()
}

/// Middles of at least 3 parts that are 1.5 m long at most.
pub(super) fn illuminance_lines(start: f64, width: f64) -> Vec<f64> {
    middles(start, width, ((width / 1.5 - 1e-9).ceil() as u32).max(3))
}
