//! A room from above, to scale.

use crate::label_boxes::{LabelBoxes, half_size};
use crate::map_frame::{LETTER, SENTENCE_LETTER};
use crate::number::{metres, tick_label};
use crate::svg::{Svg, shortened};

/// Scales of plans, metres per metre of paper; those of optics are larger than life.
const SCALES: [f64; 20] = [
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0, 200.0, 250.0, 500.0, 1e3, 2e3, 5e3, 1e4,
    2e4, 5e4,
];

/// Pixels per metre of paper: 96 to an inch, as in CSS.
const PIXELS: f64 = 96.0 / 0.0254;

/// Largest width and height of the room, pixels.
const LARGEST: [f64; 2] = [540.0, 480.0];

/// Room around it for dimensions, and below them for the scale bar; pixels.
const MARGIN: f64 = 66.0;
const FOOT: f64 = 64.0;

/// Least distance between the marks of a chain of dimensions, and the width of a letter between them; pixels.
const LEAST_GAP: f64 = 34.0;
const CHAIN_LETTER: f64 = LETTER[0] * 11.0 / 12.0;

/// Distance of two marks of a chain that are one: a millimetre is no distance in a room. In things smaller than a metre, a thousandth of their size.
const SAME_MARK: f64 = 1e-3;

/// Largest number of marks of a chain.
const MOST_MARKS: usize = 24;

/// Radius of the mark of a thing without size, and smallest size at which an outline is visible as such; pixels.
const DOT: f64 = 5.0;

/// A numbered thing of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanSymbol {
    /// Its number or letter.
    pub label: String,
    /// Its middle, metres.
    pub centre: [f64; 2],
    /// Its corners, metres; none: a mark.
    pub outline: Vec<[f64; 2]>,
}

/// An area of a plan with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanArea {
    /// Its name.
    pub name: String,
    /// Its corners, metres.
    pub corners: Vec<[f64; 2]>,
}

/// A drawing of a room from above, x to the right and y up, to one of the usual scales, with a scale bar and dimensions in metres.
#[derive(Clone, Debug)]
pub struct FloorPlan<'a> {
    /// Headline.
    pub title: &'a str,
    /// Lower left and upper right corner of what is drawn, metres.
    pub corners: [[f64; 2]; 2],
    /// Lower left and upper right corner of the room, whose size is stated, metres.
    pub room: [[f64; 2]; 2],
    /// Closed outlines of walls and floor, metres; those of two points are lines.
    pub walls: Vec<Vec<[f64; 2]>>,
    /// Closed outlines of other things, metres.
    pub furniture: Vec<Vec<[f64; 2]>>,
    /// Areas with names.
    pub areas: Vec<PlanArea>,
    /// Numbered things; the distances between those in the room and from its ends are dimensions, if there is space for them.
    pub symbols: Vec<PlanSymbol>,
}

/// Where metres are in the drawing.
struct PlanFrame {
    /// Metres of the lower left corner.
    low: [f64; 2],
    /// Pixels per metre.
    pixels: f64,
    /// Pixels of the left upper corner, and size, pixels.
    corner: [f64; 2],
    size: [f64; 2],
}

impl FloorPlan<'_> {
    /// Metres per metre of paper if the drawing has its own size: the finest of the usual scales that fits a sheet of A4.
    fn scale(&self) -> f64 {
        let [width, height] = self.size();
        let fits = |scale: &f64| {
            let pixels = PIXELS / scale;
            width * pixels <= LARGEST[0] && height * pixels <= LARGEST[1]
        };
        // A room that no scale fits is drawn in a scale of its own.
        let own = PIXELS * (width / LARGEST[0]).max(height / LARGEST[1]);
        SCALES.into_iter().find(fits).unwrap_or(own)
    }

    /// Size of what is drawn, metres; lengths that are not positive and finite are 1.
    fn size(&self) -> [f64; 2] {
        let [low, high] = self.corners;
        [0, 1].map(|axis| {
            let length = high[axis] - low[axis];
            if length > 0.0 && length.is_finite() { length } else { 1.0 }
        })
    }

    /// The text of an SVG file; the same drawing gives the same text.
    #[must_use]
    pub fn svg(&self) -> String {
        let scale = self.scale();
        let pixels = PIXELS / scale;
        let size = self.size().map(|length| length * pixels);
        let width = (size[0] + 2.0 * MARGIN).max(460.0);
        let corner = [0.5 * (width - size[0]), MARGIN + 24.0];
        let frame = PlanFrame { low: self.corners[0], pixels, corner, size };
        let bottom = corner[1] + size[1];
        let mut svg = Svg::new([width.round(), (bottom + MARGIN + FOOT).round()], self.title);
        let letters = ((width - 24.0) / SENTENCE_LETTER * 0.8) as usize;
        svg.text([12.0, 26.0], "start", "font-size=\"16\"", &shortened(self.title, letters));
        for outline in &self.furniture {
            svg.polygon(
                &frame.closed(outline),
                "fill=\"#808080\" fill-opacity=\"0.18\" stroke=\"#808080\" stroke-width=\"0.8\"",
            );
        }
        for area in &self.areas {
            svg.line(
                &frame.closed(&area.corners),
                "#0072b2",
                "stroke-width=\"1.1\" stroke-dasharray=\"6 3\"",
            );
        }
        for outline in &self.walls {
            svg.line(
                &frame.closed(outline),
                "black",
                "class=\"line\" stroke-width=\"2.4\" stroke-linejoin=\"round\"",
            );
        }
        let mut taken = LabelBoxes::default();
        self.draw_symbols(&mut svg, &frame, &mut taken);
        self.draw_names(&mut svg, &frame, &mut taken);
        self.draw_dimensions(&mut svg, &frame);
        draw_foot(&mut svg, &frame, [12.0, bottom + MARGIN], scale);
        svg.finish()
    }

    fn draw_symbols(&self, svg: &mut Svg, frame: &PlanFrame, taken: &mut LabelBoxes) {
        const LUMINAIRE: &str =
            "fill=\"#ffd54a\" fill-opacity=\"0.85\" stroke=\"#8a5a00\" stroke-width=\"1\"";
        for symbol in &self.symbols {
            let outline: Vec<[f64; 2]> = symbol.outline.iter().map(|point| frame.pixel(*point)).collect();
            let [across, up] = extent(&outline);
            if across.max(up) > 2.0 * DOT {
                svg.polygon(&outline, LUMINAIRE);
            } else {
                svg.circle(frame.pixel(symbol.centre), DOT, LUMINAIRE);
            }
        }
        for symbol in &self.symbols {
            let [x, y] = frame.pixel(symbol.centre);
            let outline: Vec<[f64; 2]> = symbol.outline.iter().map(|point| frame.pixel(*point)).collect();
            let [across, up] = extent(&outline);
            let half = half_size(&symbol.label, 1.0);
            // Inside if there is room, else at the upper right.
            let fits = across > 2.0 * half[0] && up > 2.0 * half[1];
            let off = if fits { [0.0; 2] } else { [0.5 * across.max(2.0 * DOT) + half[0], -half[1]] };
            let middle = [x + off[0], y + off[1]];
            if taken.add(middle, half) {
                // On the yellow of the symbol, letters are always dark.
                let ink = if fits { "font-size=\"12\" fill=\"#000000\"" } else { "font-size=\"12\"" };
                svg.text([middle[0], middle[1] + 0.35 * LETTER[1]], "middle", ink, &symbol.label);
            }
        }
    }

    /// Draws the names of areas in the first of their corners, or below, where there is room.
    fn draw_names(&self, svg: &mut Svg, frame: &PlanFrame, taken: &mut LabelBoxes) {
        for area in &self.areas {
            let points: Vec<[f64; 2]> = area.corners.iter().map(|corner| frame.pixel(*corner)).collect();
            let [across, up] = extent(&points);
            let [left, top] = [0, 1].map(|axis| points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min));
            let name = shortened(&area.name, ((across - 8.0) / LETTER[0]).max(3.0) as usize);
            let half = half_size(&name, 1.0);
            let rows = (up / (2.0 * half[1])) as u32;
            let middle =
                |row: u32| [left + 5.0 + half[0], top + half[1] + 2.0 + 2.0 * half[1] * f64::from(row)];
            if let Some([x, y]) = (0..rows.max(1)).map(middle).find(|middle| taken.add(*middle, half)) {
                let place = [x, y + 0.35 * LETTER[1]];
                let halo =
                    "font-size=\"12\" class=\"halo\" fill=\"none\" stroke=\"white\" stroke-width=\"3\"";
                svg.text(place, "middle", halo, &name);
                svg.text(place, "middle", "font-size=\"12\" fill=\"#0072b2\"", &name);
            }
        }
    }

    /// Draws the width below and the depth at the left; the distances of symbols above and at the right, if they can be read.
    fn draw_dimensions(&self, svg: &mut Svg, frame: &PlanFrame) {
        let room = |axis: usize| [0, 1].map(|end: usize| self.room[end][axis] - frame.low[axis]);
        frame.chain(svg, 0, &room(0), 26.0 + frame.size[1]);
        frame.chain(svg, 1, &room(1), -26.0);
        for (axis, off) in [(0, -20.0), (1, 20.0 + frame.size[0])] {
            let marks = self.marks(axis, room(axis), frame.low[axis]);
            let is_wide = marks.windows(2).all(|pair| {
                let length = pair[1] - pair[0];
                let label = CHAIN_LETTER * metres(length).len() as f64;
                length * frame.pixels >= LEAST_GAP.max(label)
            });
            if is_wide && (3..=MOST_MARKS).contains(&marks.len()) {
                frame.chain(svg, axis, &marks, off);
            }
        }
    }

    /// The ends of the room along an axis, and the symbols strictly between them: metres from `low`, ascending.
    fn marks(&self, axis: usize, [first, last]: [f64; 2], low: f64) -> Vec<f64> {
        let same = SAME_MARK * (last - first).min(1.0);
        let own = self.symbols.iter().map(|symbol| symbol.centre[axis] - low);
        let mut inside: Vec<f64> = own.filter(|mark| *mark > first + same && *mark < last - same).collect();
        inside.sort_by(f64::total_cmp);
        inside.dedup_by(|a, b| *a - *b < same);
        [first].into_iter().chain(inside).chain([last]).collect()
    }
}

impl PlanFrame {
    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top] = self.corner;
        [left + (x - self.low[0]) * self.pixels, top + self.size[1] - (y - self.low[1]) * self.pixels]
    }

    fn closed(&self, outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
        outline.iter().chain(outline.first()).map(|point| self.pixel(*point)).collect()
    }

    /// Draws a chain of dimensions along an axis: `marks`, metres from the corner, ascending; `off`, pixels from the upper or left border.
    fn chain(&self, svg: &mut Svg, axis: usize, marks: &[f64], off: f64) {
        const THIN: &str = "class=\"line\" stroke-width=\"0.8\"";
        let [left, top] = self.corner;
        let place = |metres: f64, beside: f64| {
            let along = metres * self.pixels;
            if axis == 0 {
                [left + along, top + off + beside]
            } else {
                [left + off + beside, top + self.size[1] - along]
            }
        };
        let ends = marks.first().zip(marks.last());
        let Some((first, last)) = ends else { return };
        svg.line(&[place(*first, 0.0), place(*last, 0.0)], "black", THIN);
        for mark in marks {
            svg.line(&[place(*mark, -4.0), place(*mark, 4.0)], "black", THIN);
        }
        for pair in marks.windows(2) {
            let [x, y] = place(0.5 * (pair[0] + pair[1]), -4.0);
            let turned = format!("font-size=\"11\" transform=\"rotate(-90 {x:.1} {y:.1})\"");
            let attributes = if axis == 0 { "font-size=\"11\"" } else { turned.as_str() };
            svg.text([x, y], "middle", attributes, &metres(pair[1] - pair[0]));
        }
    }
}

/// Draws the scale bar, the scale in words, and the axes.
fn draw_foot(svg: &mut Svg, frame: &PlanFrame, [left, top]: [f64; 2], scale: f64) {
    const THIN: &str = "class=\"line\" stroke-width=\"1\"";
    // The longest round length of at most 150 pixels.
    let longest = 150.0 / frame.pixels;
    let power = 10.0_f64.powf(longest.log10().floor());
    let step = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|step| *step <= longest).unwrap_or(power);
    let bar = step * frame.pixels;
    let (x, y) = (left + 50.0, top + 14.0);
    for part in 0..4 {
        let fill = if part % 2 == 0 { "class=\"ink\"" } else { "class=\"paper\" fill=\"white\"" };
        let from = x + 0.25 * bar * f64::from(part);
        svg.element(format_args!(
            "<rect {fill} x=\"{from:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"6\"/>",
            0.25 * bar
        ));
    }
    svg.frame([x, y, bar, 6.0]);
    for (share, words) in [(0.0, "0".to_owned()), (1.0, format!("{} m", tick_label(step, step)))] {
        svg.text([x + share * bar, y - 4.0], "middle", "font-size=\"11\"", &words);
    }
    let ratio = if scale < 1.0 { format!("{:.0} : 1", 1.0 / scale) } else { format!("1 : {scale:.0}") };
    let words = format!("Scale {ratio}, if printed at 100 %. Dimensions in metres.");
    svg.text([left, y + 28.0], "start", "font-size=\"12\"", &words);
    // Axes.
    let (x, y) = (left + 8.0, y + 4.0);
    svg.line(&[[x, y - 18.0], [x, y], [x + 18.0, y]], "black", THIN);
    svg.line(&[[x - 3.0, y - 13.0], [x, y - 18.0], [x + 3.0, y - 13.0]], "black", THIN);
    svg.line(&[[x + 13.0, y - 3.0], [x + 18.0, y], [x + 13.0, y + 3.0]], "black", THIN);
    svg.text([x + 25.0, y + 4.0], "middle", "font-size=\"11\"", "x");
    svg.text([x, y - 21.0], "middle", "font-size=\"11\"", "y");
}

/// Width and height of points, pixels; 0 without points.
fn extent(points: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let along = || points.iter().map(|point| point[axis]);
        let length = along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min);
        length.max(0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::misplaced_texts;

    fn square([x, y]: [f64; 2], side: f64) -> Vec<[f64; 2]> {
        let half = 0.5 * side;
        [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[dx, dy]| [x + dx, y + dy]).to_vec()
    }

    fn plan(size: [f64; 2], symbols: Vec<PlanSymbol>) -> FloorPlan<'static> {
        let [w, d] = size;
        let walls = vec![vec![[0.0, 0.0], [w, 0.0], [w, d], [0.0, d]]];
        let areas =
            vec![PlanArea { name: "<desk>".into(), corners: square([0.5 * w, 0.5 * d], 0.5 * w.min(d)) }];
        let furniture = vec![square([0.2 * w, 0.2 * d], 0.1)];
        let corners = [[0.0; 2], size];
        FloorPlan { title: "Plan", corners, room: corners, walls, furniture, areas, symbols }
    }

    fn luminaire(label: &str, centre: [f64; 2], side: f64) -> PlanSymbol {
        let outline = if side > 0.0 { square(centre, side) } else { Vec::new() };
        PlanSymbol { label: label.into(), centre, outline }
    }

    #[test]
    fn rooms_are_drawn_to_the_finest_scale_that_fits() {
        // 540 pixels are 142.9 mm: 6 m fit at 1 : 50 (120 mm), 10 m at 1 : 100 only; 480 pixels are 127 mm.
        for (size, scale) in [
            ([6.0, 4.0], 50.0),
            ([10.0, 10.0], 100.0),
            ([2.0, 6.0], 50.0),
            ([0.7, 0.6], 5.0),
            ([0.06, 0.04], 0.5),
            ([0.001, 0.001], 0.1),
            ([30.0, 2.0], 250.0),
        ] {
            assert_eq!(plan(size, Vec::new()).scale(), scale, "{size:?}");
        }
        let svg = plan([6.0, 4.0], Vec::new()).svg();
        // 6 m at 1 : 50 are 12 cm, 453.5 pixels; the scale bar of 1 m has 75.6 pixels.
        let wall = svg.lines().find(|line| line.contains("stroke-width=\"2.4\"")).unwrap();
        let xs: Vec<f64> = wall
            .split('"')
            .nth(1)
            .unwrap()
            .split(' ')
            .map(|p| p.split(',').next().unwrap().parse().unwrap())
            .collect();
        assert!((xs[1] - xs[0] - 453.5).abs() < 0.11, "{wall}");
        assert!(svg.contains("Scale 1 : 50") && svg.contains(">1 m</text>") && svg.contains("&lt;desk&gt;"));
        assert!(svg.contains(">6.00</text>") && svg.contains(">4.00</text>"));
    }

    #[test]
    fn luminaires_have_their_true_size_and_dimensions() {
        let symbols = vec![luminaire("1", [1.5, 2.0], 0.6), luminaire("2", [4.5, 2.0], 0.0)];
        let svg = plan([6.0, 4.0], symbols).svg();
        // 0.6 m at 1 : 50 are 45.35 pixels.
        let panel =
            svg.lines().find(|line| line.starts_with("<polygon") && line.contains("#ffd54a")).unwrap();
        let first: Vec<f64> =
            panel.split('"').nth(1).unwrap().split([' ', ',']).map(|p| p.parse().unwrap()).collect();
        assert!((first[2] - first[0] - 45.35).abs() < 0.11, "{panel}");
        assert_eq!(svg.matches("<circle").count(), 1);
        // 1.5 m, 3 m, 1.5 m along x; twice 2 m along y.
        assert_eq!(
            (
                svg.matches(">1.50</text>").count(),
                svg.matches(">3.00</text>").count(),
                svg.matches(">2.00</text>").count()
            ),
            (2, 1, 2)
        );
    }

    #[test]
    fn dimensions_begin_and_end_with_the_room_whatever_lies_beyond() {
        // A plane reaches 0.5 m beyond; a lamp hangs outside, and one 0.5 mm from the left end.
        let at = [[1.5, 2.0], [4.5, 2.0], [6.3, 2.0], [5e-4, 2.0]];
        let symbols = at.map(|centre| luminaire("1", centre, 0.0)).to_vec();
        let wide = FloorPlan { corners: [[-0.5, 0.0], [6.5, 4.0]], ..plan([6.0, 4.0], symbols) };
        assert_eq!(wide.marks(0, [0.5, 6.5], -0.5), [0.5, 2.0, 5.0, 6.5]);
        let svg = wide.svg();
        let count = |label: &str| svg.matches(&format!(">{label}</text>")).count();
        assert_eq!([count("1.50"), count("3.00"), count("6.00"), count("7.00")], [2, 1, 1, 0]);
    }

    #[test]
    fn plans_of_optics_are_larger_than_life() {
        let svg = plan([0.06, 0.04], vec![luminaire("1", [0.02, 0.02], 0.0)]).svg();
        for words in ["Scale 2 : 1,", ">0.06</text>", ">0.04</text>", ">0.02</text>", ">0.01 m</text>"] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
    }

    #[test]
    fn texts_stay_within_whatever_the_room() {
        let many = |size: [f64; 2]| -> Vec<PlanSymbol> {
            let at = |i: u32| [size[0] * f64::from(i % 25) / 25.0, size[1] * f64::from(i / 25) / 25.0];
            (0..600).map(|i| luminaire(&(i + 1).to_string(), at(i), 0.02)).collect()
        };
        for size in [[6.0, 4.0], [40.0, 0.3], [0.3, 40.0], [1e3, 1e3], [1e7, 1.0], [0.0, 1.0], [0.01, 0.02]] {
            let svg = plan(size, many(size)).svg();
            assert_eq!(misplaced_texts(&svg), Vec::<String>::new(), "{size:?}");
            // Only as many numbers as can be read.
            assert!(svg.matches("<text").count() < 450, "{size:?} {}", svg.matches("<text").count());
        }
    }
}
