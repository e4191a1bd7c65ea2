//! Lux maps as pictures.

use glanz_light::{Pixels, PixelsError};
use glanz_report::number::significant;
use glanz_report::{CellField, ColourScale, LETTER_HEIGHT, Raster, fitting, text_width};

use super::scale::lux_field;
use crate::LuxMap;

/// Pixels along the longer side of a receiver, and the smallest number along the shorter one.
const LONG: f64 = 800.0;
const SHORT: f64 = 24.0;

/// Pixels between the parts of the picture.
const GAP: u32 = 16;

/// Pixels per dot of the letters.
const DOT: u32 = 2;

/// Height of a line of letters with the gap below.
const LINE: u32 = DOT * LETTER_HEIGHT + 8;

/// Width of the colour scale, its smallest height, and the number of letters of its longest label.
const BAR: u32 = 24;
const BAR_HEIGHT: u32 = 200;
const NUMBER_LETTERS: usize = 9;

/// sRGB bytes of the background, of cells without area, of letters.
const PAPER: [u8; 3] = [255; 3];
const NOTHING: [u8; 3] = [200; 3];
const INK: [u8; 3] = [20; 3];

/// A lux map in the colours of `scale`, with the scale, its numbers, and figures of the map as a whole, in sRGB bytes.
///
/// The first direction of the receiver goes to the right, the second one up; the sides have the proportions of
/// [`LuxMap::size`], up to some 30 to 1, and the longer one has about 800 pixels, or one per cell if there are more
/// cells. Every pixel shows the cell that it lies in. Cells without area are grey.
///
/// # Errors
/// [`PixelsError::Size`] if the map has more cells than a picture pixels.
pub fn false_colour(map: &LuxMap, scale: &ColourScale) -> Result<Raster<[u8; 3]>, PixelsError> {
    let field = lux_field(map);
    let [wide, high] = sides(&field);
    let caption = caption(map, scale);
    let letters = caption.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let body = high.max(BAR_HEIGHT);
    let width = (wide + GAP + BAR + text_width(NUMBER_LETTERS, DOT)).max(text_width(letters, DOT)) + 2 * GAP;
    let height = 3 * GAP + LINE + body + LINE * (caption.len() as u32 + 1);
    // Checks the size before anything is allocated for it.
    let _ = Pixels::try_new(width, height)?;
    let mut raster = Raster::new([width, height], PAPER);
    raster.write([GAP, GAP - 6], &fitting(&map.name, width - 2 * GAP, DOT), DOT, INK);
    let top = 2 * GAP + LINE;
    let columns = spans(wide, field.columns());
    for (row, from, to) in spans(high, field.rows()) {
        for &(column, left, right) in &columns {
            let colour = field.at(column, row).map_or(NOTHING, |lux| scale.colour(lux));
            raster.fill([GAP + left, top + high - to], [right - left, to - from], colour);
        }
    }
    draw_scale(&mut raster, [GAP + wide + GAP, top], body, scale);
    for (line, words) in (0_u32..).zip(&caption) {
        raster.write([GAP, top + body + LINE * (line + 1)], words, DOT, INK);
    }
    Ok(raster)
}

/// A pixel for each cell, for pictures with floating-point numbers: the channels `lux` and `error`, in lx, and `area`,
/// in m^2. The first direction goes to the right, the second one up. Cells without area have 0 in all channels.
///
/// # Errors
/// [`PixelsError::Size`] without cells, [`PixelsError::Length`] if a list of the map has another length.
pub fn lux_pixels(map: &LuxMap) -> Result<Pixels, PixelsError> {
    let mut pixels = Pixels::try_new(map.cells[0], map.cells[1])?;
    for (name, numbers) in [("lux", &map.lux), ("error", &map.errors), ("area", &map.areas)] {
        let known = numbers.iter().zip(&map.areas);
        let values: Vec<f32> = known.map(|(v, area)| if *area > 0.0 { *v as f32 } else { 0.0 }).collect();
        // The first row of a picture is the upper one.
        let upwards = values.chunks(map.cells[0] as usize).rev().flatten().copied().collect();
        pixels.add_channel(name, upwards)?;
    }
    Ok(pixels)
}

/// Pixels of a map along both directions.
fn sides(field: &CellField) -> [u32; 2] {
    let size = field.size();
    let cells = [field.columns(), field.rows()];
    let long = LONG / size[0].max(size[1]);
    // The cast saturates at the range of u32.
    [0, 1].map(|axis| ((size[axis] * long).round().max(SHORT) as u32).max(cells[axis] as u32))
}

/// The cell in which `pixel` lies, where `pixels` pixels show `cells` cells.
fn cell(pixel: u32, pixels: u32, cells: usize) -> usize {
    ((2 * u64::from(pixel) + 1) * cells as u64 / (2 * u64::from(pixels.max(1)))) as usize
}

/// The cells that `pixels` pixels show of `cells` cells, each with its first pixel and the one after its last.
fn spans(pixels: u32, cells: usize) -> Vec<(usize, u32, u32)> {
    let mut spans: Vec<(usize, u32, u32)> = Vec::new();
    for pixel in 0..pixels {
        let shown = cell(pixel, pixels, cells);
        match spans.last_mut() {
            Some((last, _, end)) if *last == shown => *end = pixel + 1,
            _ => spans.push((shown, pixel, pixel + 1)),
        }
    }
    spans
}

/// Lines below a map.
fn caption(map: &LuxMap, scale: &ColourScale) -> Vec<String> {
    let summary = map.summary();
    let [width, height] = map.size.map(significant);
    let mut lines = vec![
        format!(
            "min {}  mean {}  max {} lx",
            significant(summary.minimum),
            significant(summary.mean),
            significant(summary.maximum)
        ),
        format!("U0 {}  U1 {}", significant(summary.u0), significant(summary.u1)),
        format!("{width} m x {height} m, {} x {} cells", map.cells[0], map.cells[1]),
    ];
    lines.extend(scale.floor().map(|lux| format!("equal factors from {} lx", significant(lux))));
    lines
}

/// Draws the scale of colours, its upper end above, with numbers at the right and the unit on top.
fn draw_scale(raster: &mut Raster<[u8; 3]>, [left, top]: [u32; 2], height: u32, scale: &ColourScale) {
    raster.write([left, top - LINE], "lx", DOT, INK);
    for y in 0..height {
        let position = 1.0 - (f64::from(y) + 0.5) / f64::from(height);
        raster.fill([left, top + y], [BAR, 1], scale.colour_at(position));
    }
    for (position, label) in scale.ticks(f64::from(height) / 60.0) {
        let y = top + (f64::from(height - 1) * (1.0 - position)).round() as u32;
        raster.fill([left + BAR, y], [5, 1], INK);
        raster.write([left + BAR + 9, y.saturating_sub(DOT * LETTER_HEIGHT / 2)], &label, DOT, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::lux_scale;
    use glanz_math::DVec3;

    fn map(cells: [u32; 2], size: [f64; 2], lux: Vec<f64>) -> LuxMap {
        let count = lux.len();
        let (positions, areas) = (vec![DVec3::ZERO; count], vec![1.0; count]);
        let errors = vec![0.5; count];
        LuxMap { name: "desk".into(), cells, size, positions, areas, lux, errors, statistics: None }
    }

    #[test]
    fn cells_have_their_colours_with_the_second_direction_up() {
        let map = map([2, 2], [2.0, 1.0], vec![0.0, 100.0, 50.0, 25.0]);
        let scale = lux_scale(&[&map]);
        let picture = false_colour(&map, &scale).unwrap();
        let at =
            |x: u32, y: u32| picture.pixels()[((GAP * 2 + LINE + y) * picture.width() + GAP + x) as usize];
        // 800 x 400 pixels: the first row of cells is the lower half.
        assert_eq!((at(0, 399), at(399, 200)), ([68, 1, 84], [68, 1, 84]));
        assert_eq!((at(400, 399), at(799, 200)), ([253, 231, 37], [253, 231, 37]));
        assert_eq!(at(10, 199), [33, 145, 140]);
        assert_eq!((at(799, 0), at(800, 0)), (scale.colour(25.0), PAPER));
    }

    #[test]
    fn pictures_show_every_cell_of_large_and_of_narrow_receivers() {
        let mut lux = vec![0.0; 1500];
        lux[1234] = 1e6;
        let row = map([1500, 1], [10.0, 0.01], lux);
        assert_eq!(sides(&lux_field(&row)), [1500, 24]);
        let picture = false_colour(&row, &lux_scale(&[&row])).unwrap();
        let i = ((2 * GAP + LINE) * picture.width() + GAP + 1234) as usize;
        assert_eq!(picture.pixels()[i], [253, 231, 37]);
        assert_eq!(
            false_colour(&map([0, 0], [1.0, 1.0], Vec::new()), &lux_scale(&[])).unwrap().height(),
            958
        );
    }

    #[test]
    fn lux_pixels_hold_one_pixel_per_cell() {
        let mut map = map([2, 2], [2.0, 1.0], vec![1.0, 2.0, 3.0, 4.0]);
        map.areas[3] = 0.0;
        let pixels = lux_pixels(&map).unwrap();
        assert_eq!(pixels.channel("lux").unwrap(), [3.0, 0.0, 1.0, 2.0]);
        assert_eq!(pixels.channel("error").unwrap(), [0.5, 0.0, 0.5, 0.5]);
        assert_eq!(pixels.channel("area").unwrap(), [1.0, 0.0, 1.0, 1.0]);
        map.errors.pop();
        assert!(matches!(lux_pixels(&map), Err(PixelsError::Length { .. })));
    }
}
