//! Plots as SVG: lines and points over linear or logarithmic axes.

use crate::number::ticks;
use crate::svg::{Svg, wrapped};

/// Size of the picture, and the frame within it: left, top, right, bottom; pixels.
const SIZE: [f64; 2] = [820.0, 520.0];
const FRAME: [f64; 4] = [90.0, 56.0, 600.0, 450.0];

/// Colours that stay apart for colour-blind eyes too, as @okabe2008 chose them; black is left for text.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d1f"];

/// Largest number of points of a series that all have markers, and the number of markers of a longer one.
const DENSE: usize = 60;
const MARKS: usize = 12;

/// Letters in a line of the legend, and intervals between the ticks of a linear axis.
const NAMES: usize = 22;
const INTERVALS: f64 = 7.0;

/// An axis of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit, such as `time, s`.
    pub title: String,
    /// Whether equal distances stand for equal factors.
    pub logarithmic: bool,
}

impl Axis {
    /// An axis on which equal distances stand for equal differences.
    #[must_use]
    pub fn linear(title: impl Into<String>) -> Self {
        Self { title: title.into(), logarithmic: false }
    }

    /// An axis on which equal distances stand for equal factors; values that are not positive are left out.
    #[must_use]
    pub fn logarithmic(title: impl Into<String>) -> Self {
        Self { title: title.into(), logarithmic: true }
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.logarithmic || value > 0.0)
    }

    fn coordinate(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }
}

/// Points, connected by a line in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// x and y.
    pub points: Vec<[f64; 2]>,
}

/// A dashed line across the plot at one value.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceLine {
    /// Name in the legend.
    pub name: String,
    /// Whether `at` is an x; otherwise it is a y.
    pub vertical: bool,
    /// The value.
    pub at: f64,
    /// Index of the series whose colour it has; black if `None`.
    pub series: Option<usize>,
}

/// A plot of series over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Headline.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The series that are drawn, each in its own colour and with its own markers.
    pub series: Vec<Series>,
    /// Values to compare with.
    pub reference_lines: Vec<ReferenceLine>,
}

/// The ends of an axis in its coordinates (logarithms if it is logarithmic), and the ticks between them.
struct AxisRange {
    low: f64,
    high: f64,
    /// Coordinate and label; a minor tick has none.
    ticks: Vec<(f64, Option<String>)>,
}

impl Plot {
    /// The plot as the text of an SVG file; the same plot gives the same text.
    #[must_use]
    pub fn svg(&self) -> String {
        let x = self.range(&self.x, true);
        let y = self.range(&self.y, false);
        let mut svg = Svg::new(SIZE, &self.title);
        svg.text([FRAME[0], 28.0], "start", "font-size=\"16\"", &self.title);
        self.draw_axes(&mut svg, &x, &y);
        let at = |point: [f64; 2]| {
            let [px, py] = [self.x.coordinate(point[0]), self.y.coordinate(point[1])];
            [
                FRAME[0] + (FRAME[2] - FRAME[0]) * (px - x.low) / (x.high - x.low),
                FRAME[3] - (FRAME[3] - FRAME[1]) * (py - y.low) / (y.high - y.low),
            ]
        };
        let mut legend = FRAME[1] + 8.0;
        let mut name = |svg: &mut Svg, draw: &dyn Fn(&mut Svg, f64), name: &str| {
            draw(svg, legend);
            for line in wrapped(name, NAMES) {
                svg.text([FRAME[2] + 52.0, legend + 4.5], "start", "", line);
                legend += 17.0;
            }
            legend += 5.0;
        };
        for (i, series) in self.series.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let shown = |p: &&[f64; 2]| self.x.shows(p[0]) && self.y.shows(p[1]);
            let places: Vec<[f64; 2]> = series.points.iter().filter(shown).map(|p| at(*p)).collect();
            svg.line(&places, colour, "");
            let marked = marked(places.len(), i, self.series.len());
            marked.filter_map(|k| places.get(k)).for_each(|p| draw_marker(&mut svg, *p, i, colour));
            let sample = |svg: &mut Svg, y: f64| {
                svg.line(&[[FRAME[2] + 14.0, y], [FRAME[2] + 44.0, y]], colour, "");
                draw_marker(svg, [FRAME[2] + 29.0, y], i, colour);
            };
            name(&mut svg, &sample, &series.name);
        }
        let dashed = "stroke-dasharray=\"7 4\"";
        for reference in &self.reference_lines {
            let axis = if reference.vertical { &self.x } else { &self.y };
            if !axis.shows(reference.at) {
                continue;
            }
            let (x0, y0) = (axis.coordinate(reference.at), axis.coordinate(reference.at));
            let ends = if reference.vertical {
                let x = FRAME[0] + (FRAME[2] - FRAME[0]) * (x0 - x.low) / (x.high - x.low);
                [[x, FRAME[1]], [x, FRAME[3]]]
            } else {
                let y = FRAME[3] - (FRAME[3] - FRAME[1]) * (y0 - y.low) / (y.high - y.low);
                [[FRAME[0], y], [FRAME[2], y]]
            };
            let colour = reference.series.map_or("#222222", |i| COLOURS[i % COLOURS.len()]);
            svg.line(&ends, colour, dashed);
            let sample = |svg: &mut Svg, y: f64| {
                svg.line(&[[FRAME[2] + 14.0, y], [FRAME[2] + 44.0, y]], colour, dashed);
            };
            name(&mut svg, &sample, &reference.name);
        }
        svg.finish()
    }

    /// The range of the points and reference lines along an axis, with margins and ticks.
    fn range(&self, axis: &Axis, horizontal: bool) -> AxisRange {
        let pick = |p: &[f64; 2]| if horizontal { p[0] } else { p[1] };
        let both = |p: &&[f64; 2]| self.x.shows(p[0]) && self.y.shows(p[1]);
        let points = self.series.iter().flat_map(|s| s.points.iter().filter(both).map(pick));
        let references =
            self.reference_lines.iter().filter(|line| line.vertical == horizontal).map(|line| line.at);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in points.chain(references).filter(|v| axis.shows(*v)) {
            low = low.min(axis.coordinate(value));
            high = high.max(axis.coordinate(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let margin = if high > low { 0.05 * (high - low) } else { 0.5 };
        let starts_at_zero = !axis.logarithmic && low >= 0.0 && low < 0.4 * high;
        let low = if starts_at_zero { 0.0 } else { low - margin };
        let high = high + margin;
        let ticks = if axis.logarithmic { decades(low, high) } else { labelled(low, high) };
        AxisRange { low, high, ticks }
    }

    fn draw_axes(&self, svg: &mut Svg, x: &AxisRange, y: &AxisRange) {
        let [left, top, right, bottom] = FRAME;
        for (place, label) in &x.ticks {
            let px = left + (right - left) * (place - x.low) / (x.high - x.low);
            let colour = if label.is_some() { "#dddddd" } else { "#f0f0f0" };
            svg.line(&[[px, top], [px, bottom]], colour, "stroke-width=\"1\"");
            if let Some(label) = label {
                svg.text([px, bottom + 18.0], "middle", "", label);
            }
        }
        for (place, label) in &y.ticks {
            let py = bottom - (bottom - top) * (place - y.low) / (y.high - y.low);
            let colour = if label.is_some() { "#dddddd" } else { "#f0f0f0" };
            svg.line(&[[left, py], [right, py]], colour, "stroke-width=\"1\"");
            if let Some(label) = label {
                svg.text([left - 7.0, py + 4.5], "end", "", label);
            }
        }
        svg.frame([left, top, right - left, bottom - top]);
        svg.text([0.5 * (left + right), bottom + 44.0], "middle", "", &self.x.title);
        let middle = 0.5 * (top + bottom);
        let turned = format!("transform=\"rotate(-90 22 {middle})\"");
        svg.text([22.0, middle], "middle", &turned, &self.y.title);
    }
}

/// Ticks of a linear axis.
fn labelled(low: f64, high: f64) -> Vec<(f64, Option<String>)> {
    ticks(low, high, INTERVALS).into_iter().map(|(value, label)| (value, Some(label))).collect()
}

/// Ticks of a logarithmic axis between two logarithms: labels at powers of ten, and at 2 and 5 times them where there
/// are few; every so many powers only where there are many, and round numbers where no three of these are on the axis.
fn decades(low: f64, high: f64) -> Vec<(f64, Option<String>)> {
    let span = high - low;
    let stride = (span / 8.0).ceil().max(1.0) as i32;
    let few = high.floor() - low.ceil() < 2.0;
    let mut ticks = Vec::new();
    for power in low.floor() as i32..=high.ceil() as i32 {
        for digit in 1..10 {
            let place = f64::from(power) + f64::from(digit).log10();
            if place < low || place > high || (digit > 1 && stride > 1) {
                continue;
            }
            let labelled = match digit {
                1 => power.rem_euclid(stride) == 0,
                2 | 5 => few || span < 2.2,
                3 | 7 => span < 1.2,
                _ => span < 0.5,
            };
            ticks.push((place, labelled.then(|| power_label(digit, power))));
        }
    }
    if ticks.iter().filter(|(_, label)| label.is_some()).count() >= 3 {
        return ticks;
    }
    labelled(10.0_f64.powf(low), 10.0_f64.powf(high))
        .into_iter()
        .map(|(v, label)| (v.log10(), label))
        .collect()
}

fn power_label(digit: i32, power: i32) -> String {
    match power {
        0..=5 => (i64::from(digit) * 10_i64.pow(power as u32)).to_string(),
        -4..=-1 => format!("{:.*}", power.unsigned_abs() as usize, f64::from(digit) * 10.0_f64.powi(power)),
        _ => format!("{digit}e{power}"),
    }
}

/// The indices of the points with markers: all, or some of a long series, other ones in each series.
fn marked(points: usize, series: usize, of: usize) -> impl Iterator<Item = usize> {
    let step = if points > DENSE { points.div_ceil(MARKS) } else { 1 };
    ((series + 1) * step / (of + 1)..points).step_by(step)
}

/// Draws a marker. Its shape depends on the series, so that series can be distinguished without colour.
fn draw_marker(svg: &mut Svg, [x, y]: [f64; 2], series: usize, colour: &str) {
    let corners: &[[f64; 2]] = match series % 4 {
        0 => {
            return svg.circle([x, y], 4.0, &format!("fill=\"{colour}\""));
        }
        1 => &[[-3.6, -3.6], [3.6, -3.6], [3.6, 3.6], [-3.6, 3.6]],
        2 => &[[0.0, -4.8], [4.6, 3.4], [-4.6, 3.4]],
        _ => &[[0.0, -5.2], [5.2, 0.0], [0.0, 5.2], [-5.2, 0.0]],
    };
    let corners: Vec<[f64; 2]> = corners.iter().map(|[dx, dy]| [x + dx, y + dy]).collect();
    svg.polygon(&corners, &format!("fill=\"{colour}\""));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: Vec<(f64, Option<String>)>) -> Vec<String> {
        ticks.into_iter().filter_map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(labels(labelled(0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(decades(-2.1, 3.2)), ["0.01", "0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels(decades(0.1, 1.5)), ["2", "5", "10", "20"]);
        // More than two decades, of which two powers are within.
        assert_eq!(labels(decades(-2.8, -0.5)), ["0.002", "0.005", "0.01", "0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(labels(decades(-1.01, -0.72)), ["0.10", "0.12", "0.14", "0.16", "0.18"]);
        assert!((decades(-1.01, -0.72)[1].0 - 0.12_f64.log10()).abs() < 1e-12);
        assert_eq!(labels(decades(-16.2, 0.2)), ["1e-15", "1e-12", "1e-9", "1e-6", "0.001", "1"]);
    }

    #[test]
    fn points_lie_where_the_axes_say() {
        let plot = Plot {
            title: "a < b & c".into(),
            x: Axis::linear("x, m"),
            y: Axis::logarithmic("y"),
            series: vec![Series { name: "s".into(), points: vec![[0.0, 1.0], [10.0, 100.0], [5.0, 0.0]] }],
            reference_lines: vec![ReferenceLine {
                name: "r".into(),
                vertical: false,
                at: 10.0,
                series: None,
            }],
        };
        let svg = plot.svg();
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"));
        // x from 0 to 10.5 over 510 pixels, log y from -0.1 to 2.1 over 394; the value 0 has no logarithm.
        assert!(svg.contains("points=\"90.0,432.1 575.7,73.9\""), "{svg}");
        assert!(svg.contains("points=\"90.0,253.0 600.0,253.0\""), "{svg}");
        assert_eq!(svg, plot.svg());
    }

    #[test]
    fn plot_without_points_is_a_frame() {
        let (x, y) = (Axis::linear("x"), Axis::logarithmic("y"));
        let plot = Plot { title: String::new(), x, y, series: Vec::new(), reference_lines: Vec::new() };
        assert!(!plot.svg().contains("NaN") && !plot.svg().contains("inf"));
    }

    #[test]
    fn curves_of_many_points_have_few_markers() {
        assert_eq!(marked(5, 0, 1).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        let [a, b] = [0, 1].map(|series| marked(240, series, 3).collect::<Vec<_>>());
        assert_eq!((a.len(), a[0], a[1]), (12, 5, 25));
        assert!(b.len() == 12 && a.iter().all(|place| !b.contains(place)));
    }
}
