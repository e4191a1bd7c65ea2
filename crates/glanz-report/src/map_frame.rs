//! The rectangle of a drawing of a floor or a wall, with axes in metres.

use crate::number::ticks;
use crate::svg::Svg;

/// Least length of a side, pixels.
const SHORT: f64 = 24.0;

/// Room at the left for the axis, and on top for the title, pixels.
pub(crate) const LEFT: f64 = 66.0;
pub(crate) const TOP: f64 = 52.0;

/// Room below the rectangle for the axis, pixels.
pub(crate) const BELOW: f64 = 50.0;

/// Upper bounds of the mean width and the height of a letter of labels of 12 pixels, and of the mean width of a letter of sentences of 13 pixels; pixels.
pub(crate) const LETTER: [f64; 2] = [7.2, 12.0];
pub(crate) const SENTENCE_LETTER: f64 = 7.8;

/// An axis of a drawing in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapAxis {
    /// Its name with its unit.
    pub title: &'static str,
    /// The coordinate at its start, metres.
    pub start: f64,
}

impl MapAxis {
    /// The directions of a rectangle, from its corner.
    pub const DIRECTIONS: [Self; 2] =
        [Self { title: "first direction, m", start: 0.0 }, Self { title: "second direction, m", start: 0.0 }];

    /// The axes of a wall whose lower edge is at this height, metres.
    #[must_use]
    pub fn of_wall(lower_edge: f64) -> [Self; 2] {
        [Self { title: "along the wall, m", start: 0.0 }, Self { title: "height, m", start: lower_edge }]
    }

    /// The axes of a room from above, for a rectangle with this lower corner, metres.
    #[must_use]
    pub fn of_room([x, y]: [f64; 2]) -> [Self; 2] {
        [Self { title: "x, m", start: x }, Self { title: "y, m", start: y }]
    }
}

/// Size of a rectangle in a drawing, pixels.
pub(crate) struct MapFrame {
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl MapFrame {
    /// A rectangle of `size` metres, as large as `largest` pixels allow, but no side shorter than [`SHORT`].
    pub(crate) fn new(size: [f64; 2], largest: [f64; 2]) -> Self {
        let scale = (largest[0] / size[0]).min(largest[1] / size[1]);
        let [width, height] = size.map(|side| (side * scale).max(SHORT));
        Self { width, height }
    }

    /// Pixels of a point in fractions of the sides.
    pub(crate) fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [LEFT + self.width * x, TOP + self.height * (1.0 - y)]
    }

    /// Draws the border and the axes of a rectangle of `size` metres.
    pub(crate) fn draw_axes(&self, svg: &mut Svg, size: [f64; 2], axes: [MapAxis; 2]) {
        let (right, bottom) = (LEFT + self.width, TOP + self.height);
        let [across, up] = axes;
        for (metres, label) in ticks(across.start, across.start + size[0], self.width / 60.0) {
            let x = LEFT + self.width * (metres - across.start) / size[0];
            svg.line(&[[x, bottom], [x, bottom + 5.0]], "black", "class=\"line\" stroke-width=\"1\"");
            svg.text([x, bottom + 19.0], "middle", "", &label);
        }
        for (metres, label) in ticks(up.start, up.start + size[1], (self.height / 40.0).min(10.0)) {
            let y = bottom - self.height * (metres - up.start) / size[1];
            svg.line(&[[LEFT - 5.0, y], [LEFT, y]], "black", "class=\"line\" stroke-width=\"1\"");
            svg.text([LEFT - 8.0, y + 4.5], "end", "", &label);
        }
        svg.frame([LEFT, TOP, self.width, self.height]);
        svg.text([(0.5 * (LEFT + right)).max(86.0), bottom + 37.0], "middle", "", across.title);
        let middle = (0.5 * (TOP + bottom)).max(TOP + 75.0);
        let turned = format!("transform=\"rotate(-90 16 {middle:.1})\"");
        svg.text([16.0, middle], "middle", &turned, up.title);
    }

    /// Draws closed outlines, whose points are fractions of the sides.
    pub(crate) fn draw_outlines(&self, svg: &mut Svg, outlines: &[Vec<[f64; 2]>]) {
        for outline in outlines {
            let points: Vec<[f64; 2]> =
                outline.iter().chain(outline.first()).map(|p| self.pixel(*p)).collect();
            svg.line(&points, "white", "stroke-width=\"2.6\" stroke-opacity=\"0.7\"");
            svg.line(&points, "#333333", "stroke-width=\"0.9\"");
        }
    }
}
