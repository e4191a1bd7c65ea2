//! The colour scale of lux maps.

use glanz_report::number::significant;
use glanz_report::{CellField, ColourScale};

use crate::LuxMap;

/// The scale for the illuminances of all of `maps`, weighted by the areas of the cells: see [`ColourScale::of`].
#[must_use]
pub fn lux_scale(maps: &[&LuxMap]) -> ColourScale {
    let fields: Vec<CellField> = maps.iter().map(|map| lux_field(map)).collect();
    field_scale(&fields)
}

/// The scale for the numbers of all of `fields`.
pub(super) fn field_scale(fields: &[CellField]) -> ColourScale {
    ColourScale::of(fields.iter().flat_map(CellField::shown))
}

/// A sentence on a scale of equal factors, for numbers in `unit`.
pub(super) fn logarithmic_note(scale: &ColourScale, unit: &str) -> Option<String> {
    let floor = significant(scale.floor()?);
    Some(format!("Colours by equal factors; what is below {floor} {unit} has the lowest."))
}

/// The illuminances of a map.
pub(super) fn lux_field(map: &LuxMap) -> CellField {
    CellField::new(map.cells, map.size, &map.areas, &map.lux)
}
