//! Pictures of textures, of differences in false colours, and of divisions.

use glanz_light::rgb::srgb_decode;
use glanz_light::{Pixels, PixelsError};
use glanz_radiosity::reconstruct::{Border, ParameterCells};

use super::measure::{DivisionResult, SceneResult};
use super::method::{SCATTERED, name};
use glanz_report::{SheetPanel, contact_sheet};

/// Differences at which colours saturate, for soft and for hard shadows.
const FULL: [f64; 2] = [0.05, 0.3];

/// sRGB colours for too dark, exact and too bright.
const COLOURS: [[f64; 3]; 3] = [[0.02, 0.19, 0.62], [0.97, 0.97, 0.97], [0.70, 0.05, 0.09]];

/// The difference that has full colour in the pictures of a scene.
pub(super) fn full(outcome: &SceneResult) -> f64 {
    FULL[usize::from(outcome.setup.hard)]
}

/// Texels in grey, v upwards.
fn grey(texels: &[f64], size: [usize; 2]) -> Result<Pixels, PixelsError> {
    coloured(size, |i| [texels.get(i).map_or(0.0, |x| *x as f32); 3])
}

/// Texels less the reference in false colours.
fn difference(texels: &[f64], reference: &[f64], size: [usize; 2], full: f64) -> Result<Pixels, PixelsError> {
    coloured(size, |i| match (texels.get(i), reference.get(i)) {
        (Some(a), Some(b)) => false_colour((a - b) / full),
        _ => [0.0; 3],
    })
}

/// Linear light of a difference, clamped to [-1, 1].
fn false_colour(difference: f64) -> [f32; 3] {
    let share = difference.clamp(-1.0, 1.0);
    let end = if share < 0.0 { COLOURS[0] } else { COLOURS[2] };
    [0, 1, 2].map(|i| srgb_decode((COLOURS[1][i] + share.abs() * (end[i] - COLOURS[1][i])) as f32))
}

/// Borders of cells on white, middles as dots (figure 4.6).
fn division(cells: &ParameterCells, size: [usize; 2]) -> Result<Pixels, PixelsError> {
    let mut ink = vec![0.9_f32; size[0] * size[1]];
    let texel = |x: f64, axis: usize| ((x * size[axis] as f64).round() as usize).min(size[axis] - 1);
    let mut set = |x: usize, y: usize, value: f32| {
        if let Some(texel) = ink.get_mut(y * size[0] + x) {
            *texel = value;
        }
    };
    for cell in cells.as_slice() {
        let [x0, x1] = [cell.min.x, cell.max.x].map(|x| texel(x, 0));
        let [y0, y1] = [cell.min.y, cell.max.y].map(|y| texel(y, 1));
        (x0..=x1).for_each(|x| [y0, y1].iter().for_each(|&y| set(x, y, 0.25)));
        (y0..=y1).for_each(|y| [x0, x1].iter().for_each(|&x| set(x, y, 0.25)));
        // Dots would fill small cells.
        if x1 - x0 > 6 && y1 - y0 > 6 {
            let (x, y) = (x0.midpoint(x1), y0.midpoint(y1));
            (x - 1..=x + 1).for_each(|x| (y - 1..=y + 1).for_each(|y| set(x, y, 0.0)));
        }
    }
    coloured(size, |i| [ink.get(i).copied().unwrap_or_default(); 3])
}

/// Pixels of texels: the first row of texels is the last of the picture.
fn coloured(size: [usize; 2], colour: impl Fn(usize) -> [f32; 3]) -> Result<Pixels, PixelsError> {
    let [width, height] = size;
    let rows = (0..height).rev();
    let rgb: Vec<[f32; 3]> = rows.flat_map(|y| (0..width).map(move |x| y * width + x)).map(colour).collect();
    Pixels::try_from_rgb(width as u32, height as u32, &rgb)
}

/// Reference and textures of a division (figures F.2, F.3 and so on).
pub(super) fn textures(
    outcome: &SceneResult,
    of: &DivisionResult,
    size: [usize; 2],
) -> Result<Pixels, PixelsError> {
    let panel = |lines: [String; 2], pixels| SheetPanel { lines, pixels };
    let mut panels = vec![
        panel(
            [format!("scene {}", outcome.setup.number), "reference".into()],
            grey(&outcome.reference.texels, size)?,
        ),
        panel(
            [of.division.name().into(), format!("{} elements", of.divided.cells.as_slice().len())],
            division(&of.divided.cells, size)?,
        ),
    ];
    for made in shown(of) {
        let [.., l2, _] = made.errors;
        let lines = [made.method.name().to_owned(), format!("L2 {l2:.4}")];
        panels.push(panel(lines, grey(&made.texels, size)?));
    }
    in_rows(panels)
}

/// Differences of the same textures from the reference, under a scale of the colours (figures F.4, F.5 and so on).
pub(super) fn differences(
    outcome: &SceneResult,
    of: &DivisionResult,
    size: [usize; 2],
) -> Result<Pixels, PixelsError> {
    let full = full(outcome);
    let scale = coloured(size, |i| false_colour(2.0 * ((i % size[0]) as f64 + 0.5) / size[0] as f64 - 1.0))?;
    let title = format!("scene {} {}", outcome.setup.number, of.division.name());
    let mut panels =
        vec![SheetPanel { lines: [title, format!("colours: -{full} to {full}")], pixels: scale }];
    for made in shown(of) {
        let lines = [made.method.name().to_owned(), format!("largest {:.3}", made.errors[2])];
        let pixels = difference(&made.texels, &outcome.reference.texels, size, full)?;
        panels.push(SheetPanel { lines, pixels });
    }
    in_rows(panels)
}

/// Each interpolation once, with border samples where these matter.
fn shown(of: &DivisionResult) -> impl Iterator<Item = &super::measure::MethodResult> {
    of.made.iter().filter(|made| !made.method.is_scattered() || made.method.border == Border::Sampled)
}

/// Four in a row.
fn in_rows(mut panels: Vec<SheetPanel>) -> Result<Pixels, PixelsError> {
    let mut rows = Vec::new();
    while panels.len() > 4 {
        let rest = panels.split_off(if panels.len() < 7 { panels.len().div_ceil(2) } else { 4 });
        rows.push(std::mem::replace(&mut panels, rest));
    }
    rows.push(panels);
    contact_sheet(&rows)
}

/// Differences of natural neighbours without and with samples at the border: a column for each scene (figures F.31 and F.32).
pub(super) fn borders(outcomes: &[&SceneResult], size: [usize; 2]) -> Result<Pixels, PixelsError> {
    let natural = SCATTERED[2];
    let mut rows = Vec::new();
    for division in super::method::FloorDivision::ALL {
        for (border, words) in [(Border::Open, "without"), (Border::Sampled, "with")] {
            let mut row = Vec::new();
            for outcome in outcomes {
                let of = outcome.divisions.iter().find(|of| of.division == division);
                let Some(made) = of.and_then(|of| of.of(natural, border)) else { continue };
                let lines = [
                    format!("scene {} {}", outcome.setup.number, division.name()),
                    format!("{words} border samples"),
                ];
                let pixels = difference(&made.texels, &outcome.reference.texels, size, full(outcome))?;
                row.push(SheetPanel { lines, pixels });
            }
            rows.push(row);
        }
    }
    contact_sheet(&rows)
}

/// Names of the pictured methods, for captions.
pub(super) fn listed(of: &DivisionResult) -> String {
    let names: Vec<&str> = shown(of).map(|made| name(made.method.interpolation)).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_white_where_nothing_differs_and_apart_where_it_does() {
        let [dark, none, bright] = [-2.0, 0.0, 1.0].map(false_colour);
        assert!(none[0] == none[1] && none[1] == none[2] && none[0] > 0.9);
        assert!(dark[2] > 4.0 * dark[0] && bright[0] > 4.0 * bright[2]);
        assert_eq!(false_colour(-1.0), dark);
    }

    #[test]
    fn first_row_of_texels_is_at_the_bottom() {
        let pixels = grey(&[0.0, 0.25, 0.5, 1.0], [2, 2]).unwrap();
        let rgb = pixels.to_rgb().unwrap();
        assert_eq!([rgb[0][0], rgb[1][0], rgb[2][0], rgb[3][0]], [0.5, 1.0, 0.0, 0.25]);
    }
}
