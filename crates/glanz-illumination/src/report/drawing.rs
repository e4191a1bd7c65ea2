//! Numbers over a receiver as SVG: colours, contours, axes, scale.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::contour::{Contour, Grid};
use super::field::Field;
use super::palette::{hexadecimal, ink_on};
use super::scale::Scale;
use super::svg::{frame, line, opened, shortened, steps, text, wrapped};

/// Pixels along the longer side of a receiver, and at least along the shorter one.
const LONG: f64 = 560.0;
const SHORT: f64 = 24.0;

/// Room at the left for the axis, on top for the title, at the right for the scale; least height of the scale.
const LEFT: f64 = 66.0;
const TOP: f64 = 52.0;
const RIGHT: f64 = 118.0;
const BAR_HEIGHT: f64 = 180.0;

/// Colours that the scale is divided into.
const COLOURS: u32 = 64;

/// Rectangles of one colour, and straight pieces of contours, that a drawing may have: each takes some 12 bytes, and a
/// drawing is to stay well below a megabyte.
const MOST_RUNS: usize = 30_000;
const MOST_PIECES: usize = 30_000;

/// Straight pieces per level, over cells along both sides, from which on contours follow noise: a circle across the
/// whole map has 2.
const RAGGED: usize = 5;

/// Cells along a side below which they are not joined, and above which they always are.
const COARSE: usize = 16;
const FINE: usize = 1024;

/// Width and height of a letter of labels, pixels; on the safe side for the fonts named.
const LETTER: [f64; 2] = [7.2, 12.0];

/// What is drawn.
pub(crate) struct Drawing<'a> {
    pub(crate) title: &'a str,
    pub(crate) field: Field,
    pub(crate) scale: Scale,
    /// Of contours, with their labels.
    pub(crate) levels: Vec<(f64, String)>,
    /// Sentences below.
    pub(crate) caption: Vec<String>,
}

/// Where the picture of the receiver is, pixels.
struct Plot {
    wide: f64,
    high: f64,
    /// Height of plot and scale.
    body: f64,
}

impl Drawing<'_> {
    /// The text of an SVG file; the same drawing gives the same text.
    pub(crate) fn svg(&self) -> String {
        let size = self.field.size();
        let long = LONG / size[0].max(size[1]);
        let [wide, high] = size.map(|s| (s * long).max(SHORT));
        let plot = Plot { wide, high, body: high.max(BAR_HEIGHT) };
        let width = LEFT + wide + RIGHT;
        let width = width.max(460.0);
        let letters = ((width - 24.0) / LETTER[0]) as usize;
        let (lines, factor) = self.contours();
        let mut caption = self.caption.clone();
        if factor > 1 {
            caption.push(format!("Contours of means over {factor} x {factor} cells."));
        }
        let caption: Vec<&str> = caption.iter().flat_map(|words| wrapped(words, letters)).collect();
        let height = TOP + plot.body + 50.0 + 17.0 * caption.len() as f64 + 6.0;
        let mut svg = opened([width.round(), height.round()], self.title);
        text(&mut svg, [12.0, 26.0], "start", "font-size=\"16\"", &shortened(self.title, letters * 4 / 5));
        self.colours(&mut svg, &plot);
        self.lines(&mut svg, &plot, &lines);
        self.axes(&mut svg, &plot);
        self.bar(&mut svg, &plot);
        for (row, words) in caption.iter().enumerate() {
            text(&mut svg, [12.0, TOP + plot.body + 58.0 + 17.0 * row as f64], "start", "", words);
        }
        svg + "</svg>\n"
    }

    /// The contours of each level, in parts of the sides; and how many cells along a side are taken as one for them.
    fn contours(&self) -> (Vec<Vec<Contour>>, u32) {
        let (mut field, mut factor) = (self.field.clone(), 1);
        loop {
            let longer = field.columns().max(field.rows());
            if longer > FINE {
                (field, factor) = (field.halved(), 2 * factor);
                continue;
            }
            let (xs, ys, values) = (field.middles(0), field.middles(1), field.to_borders());
            let grid = Grid { xs: &xs, ys: &ys, values: &values };
            let pieces: usize = self.levels.iter().map(|(level, _)| grid.pieces(*level)).sum();
            let smooth = RAGGED * self.levels.len() * (field.columns() + field.rows());
            if pieces <= MOST_PIECES.min(smooth) || longer < COARSE {
                return (self.levels.iter().map(|(level, _)| grid.contours(*level)).collect(), factor);
            }
            (field, factor) = (field.halved(), 2 * factor);
        }
    }

    /// The cells as one path for each colour.
    fn colours(&self, svg: &mut String, plot: &Plot) {
        let mut field = self.field.clone();
        let runs = loop {
            let runs = runs(&field, &self.scale);
            if runs.len() <= MOST_RUNS {
                break runs;
            }
            field = field.halved();
        };
        let mut paths: BTreeMap<u32, String> = BTreeMap::new();
        let (across, up) = (field.edges(0), field.edges(1));
        let edge = |edges: &[u32], i: usize| edges.get(i).copied().unwrap_or(0);
        for Run { row, from, to, colour } in runs {
            let (left, bottom) = (edge(across, from), edge(up, row));
            let (wide, high) = (edge(across, to) - left, edge(up, row + 1) - bottom);
            let path = paths.entry(colour).or_default();
            let _ = write!(path, "M{left} {bottom}h{wide}v{high}h-{wide}z");
        }
        let last = |edges: &[u32]| f64::from(edges.last().copied().unwrap_or(0).max(1));
        let _ = writeln!(
            svg,
            "<g transform=\"translate({LEFT} {:.3}) scale({:.6} {:.6})\" shape-rendering=\"crispEdges\">",
            TOP + plot.high,
            plot.wide / last(across),
            -plot.high / last(up)
        );
        for (colour, path) in paths {
            let _ = writeln!(svg, "<path fill=\"{}\" d=\"{path}\"/>", hexadecimal(self.step(colour)));
        }
        svg.push_str("</g>\n");
    }

    /// The colour of one of the steps of the scale.
    fn step(&self, number: u32) -> [u8; 3] {
        self.scale.colour_at((f64::from(number) + 0.5) / f64::from(COLOURS))
    }

    /// Contours and their labels.
    fn lines(&self, svg: &mut String, plot: &Plot, contours: &[Vec<Contour>]) {
        let mut labels: Vec<Label> = Vec::new();
        for ((level, label), contours) in self.levels.iter().zip(contours) {
            let ground = self.scale.colour(*level);
            let ink = ink_on(ground);
            let _ = writeln!(svg, "<g fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.1\">");
            for contour in contours {
                let mut places: Vec<String> = Vec::with_capacity(contour.points.len());
                for point in &contour.points {
                    let [x, y] = plot.at(*point);
                    let place = format!("{x:.1},{y:.1}");
                    if places.last() != Some(&place) {
                        places.push(place);
                    }
                }
                let _ = writeln!(svg, "<polyline points=\"{}\"/>", places.join(" "));
                labels.extend(Label::beside(contour, plot, label, ground, &labels));
            }
            svg.push_str("</g>\n");
        }
        for Label { place: [x, y], words, ground, .. } in labels {
            let (halo, ink) = (hexadecimal(ground), ink_on(ground));
            let place = [x, y + 0.35 * LETTER[1]];
            let around = format!("font-size=\"12\" fill=\"none\" stroke=\"{halo}\" stroke-width=\"4\"");
            text(svg, place, "middle", &around, words);
            text(svg, place, "middle", &format!("font-size=\"12\" fill=\"{ink}\""), words);
        }
    }

    fn axes(&self, svg: &mut String, plot: &Plot) {
        let [size_x, size_y] = self.field.size();
        let (right, bottom) = (LEFT + plot.wide, TOP + plot.high);
        for (metres, label) in steps(0.0, size_x, plot.wide / 60.0) {
            let x = LEFT + plot.wide * metres / size_x;
            line(svg, &[[x, bottom], [x, bottom + 5.0]], "black", "class=\"line\" stroke-width=\"1\"");
            text(svg, [x, bottom + 19.0], "middle", "", &label);
        }
        for (metres, label) in steps(0.0, size_y, (plot.high / 40.0).min(10.0)) {
            let y = bottom - plot.high * metres / size_y;
            line(svg, &[[LEFT - 5.0, y], [LEFT, y]], "black", "class=\"line\" stroke-width=\"1\"");
            text(svg, [LEFT - 8.0, y + 4.5], "end", "", &label);
        }
        frame(svg, [LEFT, TOP, plot.wide, plot.high]);
        text(svg, [(0.5 * (LEFT + right)).max(86.0), bottom + 37.0], "middle", "", "first direction, m");
        let middle = (0.5 * (TOP + bottom)).max(TOP + 75.0);
        let turned = format!("transform=\"rotate(-90 16 {middle:.1})\"");
        text(svg, [16.0, middle], "middle", &turned, "second direction, m");
    }

    /// The scale of colours with its unit on top.
    fn bar(&self, svg: &mut String, plot: &Plot) {
        let left = LEFT + plot.wide + 22.0;
        let each = plot.body / f64::from(COLOURS);
        svg.push_str("<g shape-rendering=\"crispEdges\">\n");
        for number in 0..COLOURS {
            let _ = writeln!(
                svg,
                "<rect x=\"{left:.1}\" y=\"{:.2}\" width=\"18\" height=\"{:.2}\" fill=\"{}\"/>",
                TOP + plot.body - each * f64::from(number + 1),
                each,
                hexadecimal(self.step(number))
            );
        }
        svg.push_str("</g>\n");
        frame(svg, [left, TOP, 18.0, plot.body]);
        for (place, label) in self.scale.ticks(plot.body / 45.0) {
            let y = TOP + plot.body * (1.0 - place);
            line(svg, &[[left + 18.0, y], [left + 23.0, y]], "black", "class=\"line\" stroke-width=\"1\"");
            text(svg, [left + 27.0, y + 4.5], "start", "", &label);
        }
        text(svg, [left, TOP - 8.0], "start", "", "lx");
    }
}

impl Plot {
    /// Pixels of a point in parts of the sides.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [LEFT + self.wide * x, TOP + self.high * (1.0 - y)]
    }
}

/// Cells of one colour in a row.
struct Run {
    row: usize,
    from: usize,
    to: usize,
    colour: u32,
}

fn runs(field: &Field, scale: &Scale) -> Vec<Run> {
    let step = |lux: f64| ((scale.place(lux) * f64::from(COLOURS)) as u32).min(COLOURS - 1);
    let mut runs: Vec<Run> = Vec::new();
    for row in 0..field.rows() {
        for column in 0..field.columns() {
            let Some(colour) = field.at(column, row).map(step) else { continue };
            match runs.last_mut() {
                Some(run) if run.row == row && run.to == column && run.colour == colour => {
                    run.to = column + 1
                }
                _ => runs.push(Run { row, from: column, to: column + 1, colour }),
            }
        }
    }
    runs
}

/// A number on a contour.
struct Label<'a> {
    /// Its middle, pixels.
    place: [f64; 2],
    half: [f64; 2],
    words: &'a str,
    ground: [u8; 3],
}

impl<'a> Label<'a> {
    /// A label on a contour that is long enough for it, at a place where it is within the plot and on no other label.
    fn beside(
        contour: &Contour,
        plot: &Plot,
        words: &'a str,
        ground: [u8; 3],
        others: &[Self],
    ) -> Option<Self> {
        let half = [0.5 * LETTER[0] * words.chars().count() as f64 + 2.0, 0.5 * LETTER[1] + 2.0];
        let places: Vec<[f64; 2]> = contour.points.iter().map(|p| plot.at(*p)).collect();
        let length: f64 = places.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
        if length < 8.0 * half[0] {
            return None;
        }
        let is_free = |place: &[f64; 2]| {
            let [x, y] = *place;
            let inside = x - half[0] > LEFT
                && x + half[0] < LEFT + plot.wide
                && y - half[1] > TOP
                && y + half[1] < TOP + plot.high;
            let clear = |other: &Self| {
                (other.place[0] - x).abs() >= other.half[0] + half[0]
                    || (other.place[1] - y).abs() >= other.half[1] + half[1]
            };
            inside && others.iter().all(clear)
        };
        // Some places all along the contour, those near its middle first.
        const TRIES: usize = 24;
        let tries = (0..TRIES).map(|i| {
            let off = i.div_ceil(2) * places.len() / TRIES;
            let middle = places.len() / 2;
            if i % 2 == 0 { middle.saturating_sub(off) } else { middle + off }
        });
        let place = tries.filter_map(|i| places.get(i).copied()).find(is_free)?;
        Some(Self { place, half, words, ground })
    }
}
