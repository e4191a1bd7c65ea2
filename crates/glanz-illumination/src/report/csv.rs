//! Lux maps as text for programs.

use std::fmt::Write;

use glanz_report::number::exact;

use crate::LuxMap;

/// Range of numbers that are written without a power of ten.
const PLAIN: std::ops::Range<f64> = 1e-5..1e16;

/// A lux map as comma-separated values (@rfc4180): a line of names, then one line per cell in the order of the map.
///
/// | column | meaning |
/// |---|---|
/// | `i`, `j` | number of the cell along the first and the second direction, from 0 |
/// | `x_m`, `y_m`, `z_m` | its middle in the world, metres |
/// | `area_m2` | its area |
/// | `illuminance_lx` | mean illuminance; empty for a cell without area |
/// | `standard_error_lx` | its standard error; empty for a cell without area |
///
/// Numbers have the fewest digits that read back as the same number. Missing values are empty.
#[must_use]
pub fn csv(map: &LuxMap) -> String {
    let mut text = "i,j,x_m,y_m,z_m,area_m2,illuminance_lx,standard_error_lx\r\n".to_owned();
    let columns = map.cells[0].max(1) as usize;
    for (n, position) in map.positions.iter().enumerate() {
        let area = map.areas.get(n).copied();
        let of_cell = |list: &[f64]| list.get(n).copied().filter(|_| area.is_some_and(|area| area > 0.0));
        let numbers = [area, of_cell(&map.lux), of_cell(&map.errors)];
        let _ = write!(text, "{},{}", n % columns, n / columns);
        for number in position.to_array().map(Some).into_iter().chain(numbers) {
            text.push(',');
            text += &number.map_or_else(String::new, |number| exact(number, PLAIN));
        }
        text.push_str("\r\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::DVec3;

    #[test]
    fn cells_come_in_order_with_names_and_units_above() {
        let map = LuxMap {
            name: "desk".into(),
            cells: [2, 1],
            size: [1.0, 1.0],
            positions: vec![DVec3::new(0.25, -0.5, 0.75), DVec3::new(0.1, 1e-9, 0.0)],
            areas: vec![0.5, 0.0],
            lux: vec![500.0, 7.0],
            errors: vec![0.125, 7.0],
            statistics: None,
        };
        assert_eq!(
            csv(&map),
            "i,j,x_m,y_m,z_m,area_m2,illuminance_lx,standard_error_lx\r\n\
             0,0,0.25,-0.5,0.75,0.5,500,0.125\r\n1,0,0.1,1e-9,0,0,,\r\n"
        );
    }
}
