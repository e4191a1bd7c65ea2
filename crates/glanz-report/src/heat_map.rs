//! Numbers over the cells of a rectangle as SVG: colours, contours, axes, scale.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::cell_field::CellField;
use crate::colour_scale::ColourScale;
use crate::contour::{Contour, ContourGrid};
use crate::label_boxes::{LabelBoxes, half_size};
use crate::map_frame::{BELOW, LEFT, LETTER, MapAxis, MapFrame, SENTENCE_LETTER, TOP};
use crate::number::concise;
use crate::palette::{contrasting, hexadecimal};
use crate::svg::{Svg, shortened, wrapped};

/// Room at the right for the scale, and its least height; pixels.
const RIGHT: f64 = 118.0;
const BAR_HEIGHT: f64 = 180.0;

/// Number of colours that the scale is divided into.
pub(crate) const COLOURS: u32 = 64;

/// Largest numbers of rectangles of one colour and of segments of contours: each takes some 12 bytes, and a drawing stays
/// well below a megabyte.
const MOST_RUNS: usize = 30_000;
const MOST_SEGMENTS: usize = 30_000;

/// Segments per level, over cells along both sides, from which on contours follow noise: a circle across the whole
/// rectangle has 2.
const RAGGED: usize = 5;

/// Cells along a side below which they are not joined, and above which they always are.
const COARSE: usize = 16;
const FINE: usize = 1024;

/// A drawing of numbers over the cells of a rectangle.
///
/// The first direction of the rectangle goes to the right, the second one up. Contours are linear between the centres
/// of the cells; beyond the outermost centres they use the value of the nearest cell. If noise would break contours up,
/// or a rectangle has more cells than a drawing can show, two by two cells (and so on) are joined to one with their
/// mean; the caption says so for contours.
#[derive(Clone, Debug)]
pub struct HeatMap<'a> {
    /// Headline.
    pub title: &'a str,
    /// Unit of the numbers, above the scale of colours.
    pub unit: &'a str,
    /// Name of the quantity with its unit, along the scale of colours if there is room; may be empty.
    pub quantity: &'a str,
    /// Axes of the rectangle.
    pub axes: [MapAxis; 2],
    /// Largest width and height of the rectangle, pixels.
    pub largest: [f64; 2],
    /// The numbers.
    pub field: CellField,
    /// Their colours.
    pub scale: ColourScale,
    /// Levels of contours with their labels.
    pub levels: Vec<(f64, String)>,
    /// Closed outlines over the map, in fractions of the sides.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Sentences below the drawing.
    pub caption: Vec<String>,
}

impl<'a> HeatMap<'a> {
    /// A drawing of at most 560 pixels without contours and caption.
    #[must_use]
    pub fn new(title: &'a str, unit: &'a str, field: CellField, scale: ColourScale) -> Self {
        let (axes, largest) = (MapAxis::DIRECTIONS, [560.0; 2]);
        let (levels, outlines, caption) = Default::default();
        Self { title, unit, quantity: "", axes, largest, field, scale, levels, outlines, caption }
    }

    /// The text of an SVG file; the same drawing gives the same text.
    #[must_use]
    pub fn svg(&self) -> String {
        let size = self.field.size();
        let frame = MapFrame::new(size, self.largest);
        // Height of the rectangle and the scale of colours.
        let body = frame.height.max(BAR_HEIGHT);
        let width = (LEFT + frame.width + RIGHT).max(460.0);
        let letters = ((width - 24.0) / SENTENCE_LETTER) as usize;
        let (lines, factor) = self.contours();
        let mut caption = self.caption.clone();
        if factor > 1 {
            let joined = f64::from(factor);
            let [across, up] = [(size[0], self.field.columns()), (size[1], self.field.rows())]
                .map(|(length, count)| concise(length.min(joined * length / count.max(1) as f64)));
            caption.push(format!("Contours of means over {across} m x {up} m."));
        }
        let caption: Vec<&str> = caption.iter().flat_map(|words| wrapped(words, letters)).collect();
        let height = TOP + body + BELOW + 17.0 * caption.len() as f64 + 6.0;
        let mut svg = Svg::new([width.round(), height.round()], self.title);
        svg.text([12.0, 26.0], "start", "font-size=\"16\"", &shortened(self.title, letters * 4 / 5));
        draw_cells(&mut svg, &frame, [LEFT, TOP], &self.field, &self.scale);
        // Below the contours, whose labels are to be read.
        frame.draw_outlines(&mut svg, &self.outlines);
        self.draw_contours(&mut svg, &frame, &lines);
        frame.draw_axes(&mut svg, size, self.axes);
        self.draw_scale(&mut svg, LEFT + frame.width, body);
        for (row, words) in caption.iter().enumerate() {
            svg.text([12.0, TOP + body + BELOW + 8.0 + 17.0 * row as f64], "start", "", words);
        }
        svg.finish()
    }

    /// The contours of each level in fractions of the sides, and the number of cells along a side that are joined for them.
    fn contours(&self) -> (Vec<Vec<Contour>>, u32) {
        let (mut field, mut factor) = (self.field.clone(), 1);
        loop {
            let longer = field.columns().max(field.rows());
            if longer > FINE {
                (field, factor) = (field.halved(), 2 * factor);
                continue;
            }
            let (xs, ys, values) = (field.centres(0), field.centres(1), field.to_borders());
            let grid = ContourGrid { xs: &xs, ys: &ys, values: &values };
            let segments: usize = self.levels.iter().map(|(level, _)| grid.segment_count(*level)).sum();
            let smooth = RAGGED * self.levels.len() * (field.columns() + field.rows());
            if segments <= MOST_SEGMENTS.min(smooth) || longer < COARSE {
                return (self.levels.iter().map(|(level, _)| grid.contours(*level)).collect(), factor);
            }
            (field, factor) = (field.halved(), 2 * factor);
        }
    }

    /// Draws contours and their labels.
    fn draw_contours(&self, svg: &mut Svg, frame: &MapFrame, contours: &[Vec<Contour>]) {
        let (mut labels, mut taken): (Vec<ContourLabel>, _) = (Vec::new(), LabelBoxes::default());
        for ((level, label), contours) in self.levels.iter().zip(contours) {
            let ground = self.scale.colour(*level);
            let ink = contrasting(ground);
            svg.element(format_args!("<g fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.1\">"));
            for contour in contours {
                let mut places: Vec<String> = Vec::with_capacity(contour.points.len());
                for point in &contour.points {
                    let [x, y] = frame.pixel(*point);
                    let place = format!("{x:.1},{y:.1}");
                    if places.last() != Some(&place) {
                        places.push(place);
                    }
                }
                svg.element(format_args!("<polyline points=\"{}\"/>", places.join(" ")));
                labels.extend(ContourLabel::placed(contour, frame, label, ground, &mut taken));
            }
            svg.element(format_args!("</g>"));
        }
        for ContourLabel { centre: [x, y], words, ground, .. } in labels {
            let (halo, ink) = (hexadecimal(ground), contrasting(ground));
            let place = [x, y + 0.35 * LETTER[1]];
            let around = format!("font-size=\"12\" fill=\"none\" stroke=\"{halo}\" stroke-width=\"4\"");
            svg.text(place, "middle", &around, words);
            svg.text(place, "middle", &format!("font-size=\"12\" fill=\"{ink}\""), words);
        }
    }

    /// Draws the scale of colours beside a rectangle that ends at `right`, with its unit above.
    fn draw_scale(&self, svg: &mut Svg, right: f64, body: f64) {
        let left = right + 22.0;
        let each = body / f64::from(COLOURS);
        svg.element(format_args!("<g shape-rendering=\"crispEdges\">"));
        for number in 0..COLOURS {
            svg.element(format_args!(
                "<rect x=\"{left:.1}\" y=\"{:.2}\" width=\"18\" height=\"{:.2}\" fill=\"{}\"/>",
                TOP + body - each * f64::from(number + 1),
                each,
                hexadecimal(step(&self.scale, number))
            ));
        }
        svg.element(format_args!("</g>"));
        svg.frame([left, TOP, 18.0, body]);
        for (place, label) in self.scale.ticks(body / 45.0) {
            let y = TOP + body * (1.0 - place);
            svg.line(&[[left + 18.0, y], [left + 23.0, y]], "black", "class=\"line\" stroke-width=\"1\"");
            svg.text([left + 27.0, y + 4.5], "start", "", &label);
        }
        svg.text([left, TOP - 8.0], "start", "", self.unit);
        if !self.quantity.is_empty() && LETTER[0] * self.quantity.chars().count() as f64 <= body {
            let (x, y) = (right + RIGHT - 6.0, TOP + 0.5 * body);
            let turned = format!("transform=\"rotate(-90 {x:.1} {y:.1})\"");
            svg.text([x, y], "middle", &turned, self.quantity);
        }
    }
}

/// Draws the cells, whose rectangle has this left upper corner, as one path for each colour.
pub(crate) fn draw_cells(
    svg: &mut Svg,
    frame: &MapFrame,
    [left, top]: [f64; 2],
    field: &CellField,
    scale: &ColourScale,
) {
    let mut field = field.clone();
    let runs = loop {
        let runs = runs(&field, scale);
        if runs.len() <= MOST_RUNS {
            break runs;
        }
        field = field.halved();
    };
    let mut paths: BTreeMap<u32, String> = BTreeMap::new();
    let (across, up) = (field.edges(0), field.edges(1));
    let edge = |edges: &[u32], i: usize| edges.get(i).copied().unwrap_or(0);
    for ColourRun { row, from, to, colour } in runs {
        let (left, bottom) = (edge(across, from), edge(up, row));
        let (wide, high) = (edge(across, to) - left, edge(up, row + 1) - bottom);
        let path = paths.entry(colour).or_default();
        let _ = write!(path, "M{left} {bottom}h{wide}v{high}h-{wide}z");
    }
    let last = |edges: &[u32]| f64::from(edges.last().copied().unwrap_or(0).max(1));
    svg.element(format_args!(
        "<g transform=\"translate({left} {:.3}) scale({:.6} {:.6})\" shape-rendering=\"crispEdges\">",
        top + frame.height,
        frame.width / last(across),
        -frame.height / last(up)
    ));
    for (number, path) in paths {
        let colour = hexadecimal(step(scale, number));
        // Without a thin stroke, the background is seen between adjacent cells.
        svg.element(format_args!("<path fill=\"{colour}\" d=\"{path}\" stroke=\"{colour}\" stroke-width=\"0.5\" vector-effect=\"non-scaling-stroke\"/>"));
    }
    svg.element(format_args!("</g>"));
}

/// The colour of one of the steps of a scale.
pub(crate) fn step(scale: &ColourScale, number: u32) -> [u8; 3] {
    scale.colour_at((f64::from(number) + 0.5) / f64::from(COLOURS))
}

/// Adjacent cells of a row with one colour.
struct ColourRun {
    row: usize,
    from: usize,
    to: usize,
    colour: u32,
}

fn runs(field: &CellField, scale: &ColourScale) -> Vec<ColourRun> {
    let step = |lux: f64| ((scale.position(lux) * f64::from(COLOURS)) as u32).min(COLOURS - 1);
    let mut runs: Vec<ColourRun> = Vec::new();
    for row in 0..field.rows() {
        for column in 0..field.columns() {
            let Some(colour) = field.at(column, row).map(step) else { continue };
            match runs.last_mut() {
                Some(run) if run.row == row && run.to == column && run.colour == colour => {
                    run.to = column + 1
                }
                _ => runs.push(ColourRun { row, from: column, to: column + 1, colour }),
            }
        }
    }
    runs
}

/// A label on a contour.
struct ContourLabel<'a> {
    /// Its centre, pixels.
    centre: [f64; 2],
    words: &'a str,
    ground: [u8; 3],
}

impl<'a> ContourLabel<'a> {
    /// A label on a contour that is long enough for it, inside the map and clear of those before it.
    fn placed(
        contour: &Contour,
        frame: &MapFrame,
        words: &'a str,
        ground: [u8; 3],
        taken: &mut LabelBoxes,
    ) -> Option<Self> {
        let half = half_size(words, 2.0);
        let places: Vec<[f64; 2]> = contour.points.iter().map(|p| frame.pixel(*p)).collect();
        let length: f64 = places.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
        if length < 8.0 * half[0] {
            return None;
        }
        let mut is_free = |place: &[f64; 2]| {
            let [x, y] = *place;
            let inside = x - half[0] > LEFT
                && x + half[0] < LEFT + frame.width
                && y - half[1] > TOP
                && y + half[1] < TOP + frame.height;
            inside && taken.add(*place, half)
        };
        // Points along the whole contour, those near its middle first.
        const TRIES: usize = 24;
        let tries = (0..TRIES).map(|i| {
            let off = i.div_ceil(2) * places.len() / TRIES;
            let middle = places.len() / 2;
            if i % 2 == 0 { middle.saturating_sub(off) } else { middle + off }
        });
        let centre = tries.filter_map(|i| places.get(i).copied()).find(|place| is_free(place))?;
        Some(Self { centre, words, ground })
    }
}
