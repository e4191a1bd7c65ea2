//! Lux maps as pictures.

use glanz_light::rgb::srgb_decode;
use glanz_light::{Pixels, PixelsError};

use super::field::Field;
use super::lettering::{ADVANCE, HEIGHT, dots};
use super::scale::Scale;
use super::table::significant;
use crate::LuxMap;

/// Pixels along the longer side of a receiver, and at least along the shorter one.
const LONG: f64 = 800.0;
const SHORT: f64 = 24.0;

/// Pixels between things.
const GAP: u32 = 16;

/// Pixels per dot of the letters.
const DOT: u32 = 2;

/// Height of a line of letters with the gap below.
const LINE: u32 = DOT * HEIGHT + 8;

/// Width of the scale of colours, its height at least, and the room for its numbers.
const BAR: u32 = 24;
const BAR_HEIGHT: u32 = 200;
const NUMBERS: u32 = 9 * ADVANCE * DOT;

/// sRGB bytes of the background, of cells without area, of letters.
const PAPER: [u8; 3] = [255; 3];
const NOTHING: [u8; 3] = [200; 3];
const INK: [u8; 3] = [20; 3];

/// A lux map in the colours of `scale`, with the scale, its numbers, and what is said of the map as a whole.
///
/// The first direction of the receiver goes to the right, the second one up; the sides have the proportions of
/// [`LuxMap::size`], up to some 30 to 1, and the longer one has about 800 pixels, or one per cell if there are more
/// cells. Every pixel shows the cell that it lies in. Cells without area are grey. Channels R, G and B in linear light,
/// which become the bytes of the colours when they are written as sRGB.
///
/// # Errors
/// [`PixelsError::Size`] if the map has more cells than a picture pixels.
pub fn false_colour(map: &LuxMap, scale: &Scale) -> Result<Pixels, PixelsError> {
    let field = Field::of(map);
    let [wide, high] = sides(&field);
    let caption = caption(map, scale);
    let words = caption.iter().map(|line| line.chars().count() as u32).max().unwrap_or(0) * ADVANCE * DOT;
    let body = high.max(BAR_HEIGHT);
    let width = (wide + GAP + BAR + NUMBERS).max(words) + 2 * GAP;
    let height = 3 * GAP + LINE + body + LINE * (caption.len() as u32 + 1);
    // Checks the size before anything is allocated for it.
    let _ = Pixels::try_new(width, height)?;
    let mut canvas = Canvas { width, height, bytes: vec![PAPER; width as usize * height as usize] };
    let fitting = ((width - 2 * GAP) / (ADVANCE * DOT)) as usize;
    canvas.write([GAP, GAP - 6], &map.name.chars().take(fitting).collect::<String>());
    let top = 2 * GAP + LINE;
    for y in 0..high {
        let row = cell(high - 1 - y, high, field.rows());
        for x in 0..wide {
            let lux = field.at(cell(x, wide, field.columns()), row);
            let colour = lux.map_or(NOTHING, |lux| scale.colour(lux));
            canvas.fill([GAP + x, top + y], [1, 1], colour);
        }
    }
    canvas.bar([GAP + wide + GAP, top], body, scale);
    for (line, words) in (0_u32..).zip(&caption) {
        canvas.write([GAP, top + body + LINE * (line + 1)], words);
    }
    let light: Vec<f32> = (0..=255).map(|byte| srgb_decode(f32::from(byte as u8) / 255.0)).collect();
    let decode = |byte: u8| light.get(usize::from(byte)).copied().unwrap_or(0.0);
    let rgb: Vec<[f32; 3]> = canvas.bytes.iter().map(|colour| colour.map(decode)).collect();
    Pixels::try_from_rgb(width, height, &rgb)
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
fn sides(field: &Field) -> [u32; 2] {
    let size = field.size();
    let cells = [field.columns(), field.rows()];
    let long = LONG / size[0].max(size[1]);
    // Casting keeps to the range of u32.
    [0, 1].map(|axis| ((size[axis] * long).round().max(SHORT) as u32).max(cells[axis] as u32))
}

/// The cell of so many that a pixel of so many lies in.
fn cell(pixel: u32, pixels: u32, cells: usize) -> usize {
    ((2 * u64::from(pixel) + 1) * cells as u64 / (2 * u64::from(pixels.max(1)))) as usize
}

/// Lines below a map.
fn caption(map: &LuxMap, scale: &Scale) -> Vec<String> {
    let told = map.summary();
    let [width, height] = map.size.map(significant);
    let mut lines = vec![
        format!(
            "min {}  mean {}  max {} lx",
            significant(told.minimum),
            significant(told.mean),
            significant(told.maximum)
        ),
        format!("U0 {}  U1 {}", significant(told.u0), significant(told.u1)),
        format!("{width} m x {height} m, {} x {} cells", map.cells[0], map.cells[1]),
    ];
    lines.extend(scale.floor().map(|lux| format!("equal factors from {} lx", significant(lux))));
    lines
}

struct Canvas {
    width: u32,
    height: u32,
    bytes: Vec<[u8; 3]>,
}

impl Canvas {
    /// A rectangle; what lies outside is left out.
    fn fill(&mut self, [left, top]: [u32; 2], [wide, high]: [u32; 2], colour: [u8; 3]) {
        for y in top..(top + high).min(self.height) {
            for x in left..(left + wide).min(self.width) {
                if let Some(pixel) = self.bytes.get_mut(y as usize * self.width as usize + x as usize) {
                    *pixel = colour;
                }
            }
        }
    }

    fn write(&mut self, [left, top]: [u32; 2], words: &str) {
        for [x, y] in dots(words) {
            self.fill([left + DOT * x, top + DOT * y], [DOT, DOT], INK);
        }
    }

    /// The scale of colours, its upper end above, with numbers at the right and the unit on top.
    fn bar(&mut self, [left, top]: [u32; 2], height: u32, scale: &Scale) {
        self.write([left, top - LINE], "lx");
        for y in 0..height {
            let place = 1.0 - (f64::from(y) + 0.5) / f64::from(height);
            self.fill([left, top + y], [BAR, 1], scale.colour_at(place));
        }
        for (place, label) in scale.ticks(f64::from(height) / 60.0) {
            let y = top + (f64::from(height - 1) * (1.0 - place)).round() as u32;
            self.fill([left + BAR, y], [5, 1], INK);
            self.write([left + BAR + 9, y.saturating_sub(DOT * HEIGHT / 2)], &label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_light::Tone;
    use glanz_math::DVec3;

    fn map(cells: [u32; 2], size: [f64; 2], lux: Vec<f64>) -> LuxMap {
        let count = lux.len();
        let (positions, areas) = (vec![DVec3::ZERO; count], vec![1.0; count]);
        LuxMap { name: "desk".into(), cells, size, positions, areas, errors: vec![0.5; count], lux }
    }

    #[test]
    fn cells_have_their_colours_with_the_second_direction_up() {
        let map = map([2, 2], [2.0, 1.0], vec![0.0, 100.0, 50.0, 25.0]);
        let scale = Scale::of(&[&map]);
        let picture = false_colour(&map, &scale).unwrap();
        let bytes = Tone::default().picture_to_srgb8(&picture).unwrap();
        let at = |x: u32, y: u32| {
            let i = 3 * ((GAP * 2 + LINE + y) * picture.width() + GAP + x) as usize;
            [bytes[i], bytes[i + 1], bytes[i + 2]]
        };
        // 800 x 400 pixels: the first row of cells is the lower half.
        assert_eq!((at(0, 399), at(399, 200)), ([68, 1, 84], [68, 1, 84]));
        assert_eq!((at(400, 399), at(799, 200)), ([253, 231, 37], [253, 231, 37]));
        assert_eq!(at(10, 199), [33, 145, 140]);
        assert_eq!((at(799, 0), at(800, 0)), (scale.colour(25.0), PAPER));
    }

    #[test]
    fn every_cell_is_seen_however_many_and_however_narrow_the_receiver() {
        let mut lux = vec![0.0; 1500];
        lux[1234] = 1e6;
        let row = map([1500, 1], [10.0, 0.01], lux);
        assert_eq!(sides(&Field::of(&row)), [1500, 24]);
        let picture = false_colour(&row, &Scale::of(&[&row])).unwrap();
        let bytes = Tone::default().picture_to_srgb8(&picture).unwrap();
        let i = 3 * ((2 * GAP + LINE) * picture.width() + GAP + 1234) as usize;
        assert_eq!(bytes[i..i + 3], [253, 231, 37]);
        assert_eq!(
            false_colour(&map([0, 0], [1.0, 1.0], Vec::new()), &Scale::of(&[])).unwrap().height(),
            958
        );
    }

    #[test]
    fn pixels_of_numbers_are_the_cells() {
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
