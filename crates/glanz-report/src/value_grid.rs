//! Numbers over the cells of a rectangle, written at their places.

use crate::cell_field::CellField;
use crate::map_frame::{BELOW, LEFT, LETTER, MapAxis, MapFrame, SENTENCE_LETTER, TOP};
use crate::number::{brief, metres};
use crate::svg::{Svg, shortened, wrapped};

/// Largest numbers of values along the longer and the shorter side.
const MOST: [usize; 2] = [16, 12];

/// Room around a number, letters.
const BESIDE: f64 = 1.0;

/// Height of a row of numbers, pixels.
const ROW: f64 = 18.0;

/// Room at the right, pixels.
const RIGHT: f64 = 18.0;

/// A drawing of the numbers over the cells of a rectangle: means over blocks of cells, few enough to be read. Blocks that show nothing have a dash.
#[derive(Clone, Debug)]
pub struct ValueGrid<'a> {
    /// Headline, with the unit.
    pub title: &'a str,
    /// The numbers, not negative.
    pub field: CellField,
    /// Axes of the rectangle.
    pub axes: [MapAxis; 2],
    /// Largest width and height of the rectangle, pixels.
    pub largest: [f64; 2],
}

impl ValueGrid<'_> {
    /// The text of an SVG file; the same drawing gives the same text.
    #[must_use]
    pub fn svg(&self) -> String {
        let size = self.field.size();
        let frame = MapFrame::new(size, self.largest);
        let blocks = self.blocks(&frame);
        let width = (LEFT + frame.width + RIGHT).max(460.0);
        let letters = ((width - 24.0) / SENTENCE_LETTER) as usize;
        let means = format!(
            "Means over {} x {} areas of about {} m x {} m.",
            blocks.columns(),
            blocks.rows(),
            metres(size[0] / blocks.columns().max(1) as f64),
            metres(size[1] / blocks.rows().max(1) as f64)
        );
        let sentences = wrapped(&means, letters);
        let height = TOP + frame.height + BELOW + 17.0 * sentences.len() as f64 + 6.0;
        let mut svg = Svg::new([width.round(), height.round()], self.title);
        svg.text([12.0, 26.0], "start", "font-size=\"16\"", &shortened(self.title, letters * 4 / 5));
        draw_borders(&mut svg, &frame, &blocks);
        let (across, up) = (blocks.centres(0), blocks.centres(1));
        // The first and the last centre are the borders.
        for (row, y) in up.iter().skip(1).take(blocks.rows()).enumerate() {
            for (column, x) in across.iter().skip(1).take(blocks.columns()).enumerate() {
                let [x, y] = frame.pixel([*x, *y]);
                let words = blocks.at(column, row).map_or_else(|| "-".to_owned(), brief);
                svg.text([x, y + 0.35 * LETTER[1]], "middle", "font-size=\"12\"", &words);
            }
        }
        frame.draw_axes(&mut svg, size, self.axes);
        for (line, words) in sentences.iter().enumerate() {
            svg.text([12.0, TOP + frame.height + BELOW + 8.0 + 17.0 * line as f64], "start", "", words);
        }
        svg.finish()
    }
}

impl ValueGrid<'_> {
    /// As many blocks as their numbers can be read in.
    fn blocks(&self, frame: &MapFrame) -> CellField {
        let [width, height] = self.field.size();
        let most = if width >= height { MOST } else { [MOST[1], MOST[0]] };
        let rows = most[1].min((frame.height / ROW) as usize);
        let fits = |blocks: &CellField| {
            let letters = blocks.shown().map(|(number, _)| brief(number).len()).max().unwrap_or(1);
            LETTER[0] * (letters as f64 + BESIDE) * blocks.columns() as f64 <= frame.width
        };
        let fewer = (1..=most[0]).rev().map(|columns| self.field.blocks([columns, rows]));
        fewer.into_iter().find(fits).unwrap_or_else(|| self.field.blocks([1, rows]))
    }
}

/// Thin lines between the blocks.
fn draw_borders(svg: &mut Svg, frame: &MapFrame, blocks: &CellField) {
    for axis in 0..2 {
        let edges = blocks.edges(axis);
        let all = f64::from(edges.last().copied().unwrap_or(0).max(1));
        let inner = edges.iter().skip(1).take(edges.len().saturating_sub(2));
        for edge in inner {
            let share = f64::from(*edge) / all;
            let ends = if axis == 0 { [[share, 0.0], [share, 1.0]] } else { [[0.0, share], [1.0, share]] };
            svg.line(&ends.map(|end| frame.pixel(end)), "#b8b8b8", "stroke-width=\"0.6\"");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::misplaced_texts;

    fn drawn(cells: [u32; 2], size: [f64; 2], value: impl Fn(u32, u32) -> f64) -> String {
        let numbers: Vec<f64> = (0..cells[1])
            .flat_map(|y| (0..cells[0]).map(move |x| (x, y)))
            .map(|(x, y)| value(x, y))
            .collect();
        let field = CellField::new(cells, size, &vec![1.0; numbers.len()], &numbers);
        let axes = MapAxis::of_room([1.0, 2.0]);
        ValueGrid { title: "a < b, lx", field, axes, largest: [490.0, 370.0] }.svg()
    }

    /// The numbers at their places.
    fn values(svg: &str) -> Vec<&str> {
        let numbers = svg.lines().filter(|line| line.contains("text-anchor=\"middle\" font-size=\"12\""));
        numbers.filter_map(|line| line.split('>').nth(1)?.split('<').next()).collect()
    }

    #[test]
    fn few_cells_are_all_written_from_the_lower_left() {
        let svg = drawn([3, 2], [6.0, 4.0], |x, y| f64::from(100 * y + 10 * x));
        assert_eq!(values(&svg), ["0", "10", "20", "100", "110", "120"]);
        assert!(svg.contains("Means over 3 x 2 areas of about 2.00 m x 2.00 m.") && svg.contains(">x, m<"));
        // The axis starts at the corner of the room's own coordinates.
        assert!(svg.contains(">7</text>") && svg.contains(">6</text>"));
    }

    #[test]
    fn many_cells_become_means_that_fit() {
        let svg = drawn([64, 48], [6.0, 4.0], |x, _| f64::from(x));
        // 490 pixels hold 17 numbers of 3 letters with blanks: 16 of 4 cells each.
        let found = values(&svg);
        assert_eq!((found.len() % 16, found.first(), found.get(15)), (0, Some(&"1.5"), Some(&"62")));
        for (cells, size) in
            [([400, 4], [40.0, 0.4]), ([4, 400], [0.2, 20.0]), ([1, 1], [1.0, 1.0]), ([0, 0], [1.0; 2])]
        {
            let svg = drawn(cells, size, |x, y| 1e5 + f64::from(x + y));
            assert_eq!(misplaced_texts(&svg), Vec::<String>::new(), "{cells:?}");
        }
    }

    #[test]
    fn blocks_that_show_nothing_have_a_dash() {
        let field = CellField::new([2, 1], [2.0, 1.0], &[1.0, 0.0], &[5.0, 7.0]);
        let (axes, largest) = (MapAxis::DIRECTIONS, [490.0, 370.0]);
        let svg = ValueGrid { title: "", field, axes, largest }.svg();
        assert_eq!(values(&svg), ["5.0", "-"]);
    }
}
