//! Small pictures of numbers over the cells of a rectangle, and the scale that they share.

use crate::cell_field::CellField;
use crate::colour_scale::ColourScale;
use crate::heat_map::{COLOURS, draw_cells, step};
use crate::map_frame::MapFrame;
use crate::palette::hexadecimal;
use crate::svg::Svg;

/// Largest number of cells along a side of a small picture.
const CELLS: usize = 64;

/// The cells of a field in their colours alone, as large as `largest` pixels allow, as an SVG file; `alternative` describes it for screen readers.
#[must_use]
pub fn thumbnail(field: &CellField, scale: &ColourScale, largest: [f64; 2], alternative: &str) -> String {
    let field = field.blocks([CELLS; 2]);
    let frame = MapFrame::new(field.size(), largest);
    let mut svg = Svg::new([frame.width.round() + 2.0, frame.height.round() + 2.0], alternative);
    draw_cells(&mut svg, &frame, [1.0, 1.0], &field, scale);
    svg.frame([1.0, 1.0, frame.width, frame.height]);
    svg.finish()
}

/// A scale of colours from left to right with its numbers and the name of their `quantity`, as an SVG file of this width, pixels.
#[must_use]
pub fn colour_bar(scale: &ColourScale, quantity: &str, width: f64) -> String {
    let (left, bar) = (40.0, width - 80.0);
    let mut svg = Svg::new([width, 64.0], quantity);
    svg.text([left, 16.0], "start", "", quantity);
    svg.element(format_args!("<g shape-rendering=\"crispEdges\">"));
    let each = bar / f64::from(COLOURS);
    for number in 0..COLOURS {
        svg.element(format_args!(
            "<rect x=\"{:.2}\" y=\"24\" width=\"{each:.2}\" height=\"14\" fill=\"{}\"/>",
            left + each * f64::from(number),
            hexadecimal(step(scale, number))
        ));
    }
    svg.element(format_args!("</g>"));
    svg.frame([left, 24.0, bar, 14.0]);
    for (place, label) in scale.ticks(bar / 70.0) {
        let x = left + bar * place;
        svg.line(&[[x, 38.0], [x, 43.0]], "black", "class=\"line\" stroke-width=\"1\"");
        svg.text([x, 57.0], "middle", "", &label);
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::misplaced_texts;

    #[test]
    fn thumbnails_are_small_whatever_the_number_of_cells() {
        let numbers: Vec<f64> = (0..512 * 256).map(|i| f64::from(i * 7919 % 1009)).collect();
        let field = CellField::new([512, 256], [4.0, 2.0], &vec![1.0; numbers.len()], &numbers);
        let scale = ColourScale::of(field.shown());
        let svg = thumbnail(&field, &scale, [200.0, 150.0], "a < b");
        assert!(
            svg.len() < 100_000 && svg.contains("width=\"202\" height=\"102\"") && svg.contains("a &lt; b")
        );
    }

    #[test]
    fn bars_have_their_numbers_within() {
        for high in [0.5, 730.0, 1e7] {
            let svg = colour_bar(&ColourScale::of([(0.0, 1.0), (high, 1.0)]), "illuminance, lx", 400.0);
            assert!(svg.contains("illuminance, lx") && svg.matches("<text").count() >= 3);
            assert_eq!(misplaced_texts(&svg), Vec::<String>::new());
        }
    }
}
