//! The colour scale of lux maps.

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

/// The illuminances of a map.
pub(super) fn lux_field(map: &LuxMap) -> CellField {
    CellField::new(map.cells, map.size, &map.areas, &map.lux)
}
