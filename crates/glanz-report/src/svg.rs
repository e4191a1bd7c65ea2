//! The elements of SVG that drawings here consist of.
//!
//! Text and lines that must be visible on any background have the classes `ink` and `line`, the background has `paper`,
//! so that a page that shows the drawing can change their colours.

use std::fmt::Write;

/// `words` escaped for text and attributes of XML and HTML; characters that neither allows become U+FFFD.
#[must_use]
pub fn escaped(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\'' => text.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => text.push('\u{fffd}'),
            _ if letter.is_control() => text.push('\u{fffd}'),
            _ => text.push(letter),
        }
    }
    text
}

/// The text of an SVG drawing as it grows. Positions and lengths are pixels, y downwards.
#[derive(Clone, Debug, Default)]
pub struct Svg(String);

impl Svg {
    /// A drawing of this width and height on white paper; `alternative` describes it for screen readers.
    #[must_use]
    pub fn new([width, height]: [f64; 2], alternative: &str) -> Self {
        let label = if alternative.is_empty() {
            String::new()
        } else {
            format!(" aria-label=\"{}\"", escaped(alternative))
        };
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"13\" role=\"img\"{label}>\n\
             <rect class=\"paper\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        ))
    }

    /// Elements without a drawing around them, for [`Svg::append`].
    #[must_use]
    pub fn fragment() -> Self {
        Self::default()
    }

    /// Adds words; `anchor` is `start`, `middle` or `end`.
    pub fn text(&mut self, [x, y]: [f64; 2], anchor: &str, attributes: &str, words: &str) {
        let class = if attributes.contains("fill=") { "" } else { "class=\"ink\" " };
        self.element(format_args!(
            "<text {class}x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {attributes}>{}</text>",
            escaped(words)
        ));
    }

    /// Adds a line through points, 1.8 pixels wide unless the attributes contain another width.
    pub fn line(&mut self, points: &[[f64; 2]], colour: &str, attributes: &str) {
        let stroke = if attributes.contains("stroke-width") { "" } else { "stroke-width=\"1.8\" " };
        self.element(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" {stroke}{attributes}/>",
            joined(points)
        ));
    }

    /// Adds a filled polygon.
    pub fn polygon(&mut self, corners: &[[f64; 2]], attributes: &str) {
        self.element(format_args!("<polygon points=\"{}\" {attributes}/>", joined(corners)));
    }

    /// Adds a filled circle.
    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: &str) {
        self.element(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" {attributes}/>"));
    }

    /// Adds the frame around a plot, of left, top, width and height.
    pub fn frame(&mut self, [left, top, width, height]: [f64; 4]) {
        self.element(format_args!(
            "<rect class=\"line\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" \
             stroke=\"black\"/>"
        ));
    }

    /// Adds markup as it is, and a line break.
    pub fn element(&mut self, markup: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{markup}");
    }

    /// Adds the elements of a fragment.
    pub fn append(&mut self, fragment: &Self) {
        self.0.push_str(&fragment.0);
    }

    /// The text of the SVG file.
    #[must_use]
    pub fn finish(self) -> String {
        self.0 + "</svg>\n"
    }
}

/// Points as attributes hold them, to a tenth of a pixel.
fn joined(points: &[[f64; 2]]) -> String {
    let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    points.join(" ")
}

/// The lines of at most `width` letters that `words` is broken into at blanks; a longer word is a line of its own.
#[must_use]
pub fn wrapped(words: &str, width: usize) -> Vec<&str> {
    let mut lines = Vec::new();
    let mut rest = words;
    while rest.chars().count() > width {
        let limit = rest.char_indices().nth(width + 1).map_or(rest.len(), |(i, _)| i);
        let Some(cut) = rest.get(..limit).and_then(|start| start.rfind(' ')) else { break };
        let (line, after) = rest.split_at(cut);
        lines.push(line);
        rest = after.trim_start();
    }
    lines.push(rest);
    lines
}

/// `words`, or the beginning of it and an ellipsis if it has more than `width` letters.
#[must_use]
pub fn shortened(words: &str, width: usize) -> String {
    if words.chars().count() <= width {
        return words.to_owned();
    }
    words.chars().take(width.saturating_sub(1)).chain(['\u{2026}']).collect()
}

/// The texts of a drawing that reach beyond its border, if letters are at most 0.6 times as wide as they are high.
#[cfg(test)]
pub(crate) fn misplaced_texts(svg: &str) -> Vec<String> {
    let number = |tag: &str, name: &str| -> Option<f64> {
        tag.split(&format!(" {name}=\"")).nth(1)?.split('"').next()?.parse().ok()
    };
    let (width, height) = (number(svg, "width").unwrap(), number(svg, "height").unwrap());
    let is_outside = |line: &&str| {
        let (tag, words) = line.split_once('>').unwrap();
        let words = words.trim_end_matches("</text>").replace("&lt;", "<").replace("&amp;", "&");
        let size = number(tag, "font-size").unwrap_or(13.0);
        let length = 0.6 * size * words.chars().count() as f64;
        let share =
            if tag.contains("\"middle\"") { 0.5 } else { f64::from(u8::from(tag.contains("\"end\""))) };
        let (x, y) = (number(tag, "x").unwrap(), number(tag, "y").unwrap());
        let [from, to] = [-share * length, (1.0 - share) * length];
        // Turned by -90 degrees, words run upwards.
        let ends = if tag.contains("rotate(-90") {
            [x - size, x, y - to, y - from]
        } else {
            [x + from, x + to, y - size, y]
        };
        ends[0] < 0.0 || ends[1] > width || ends[2] < 0.0 || ends[3] > height
    };
    svg.lines().filter(|line| line.starts_with("<text")).filter(is_outside).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_words_is_only_words() {
        assert_eq!(
            escaped("<a href='x'>\"&\"\u{1b}\n"),
            "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;\u{fffd}\u{fffd}"
        );
        let mut svg = Svg::fragment();
        svg.text([1.0, 2.0], "end", "", "</text><script>");
        assert_eq!(
            svg.0,
            "<text class=\"ink\" x=\"1.0\" y=\"2.0\" text-anchor=\"end\" >&lt;/text&gt;&lt;script&gt;</text>\n"
        );
    }

    #[test]
    fn long_names_are_wrapped_at_blanks() {
        assert_eq!(wrapped("certified search of all roots", 22), ["certified search of", "all roots"]);
        assert_eq!(wrapped("short", 22), ["short"]);
        assert_eq!(wrapped("onewordwithoutanyblankatall", 22), ["onewordwithoutanyblankatall"]);
        assert_eq!(
            (shortened("längste", 6), shortened("länge", 5)),
            ("längs\u{2026}".into(), "länge".into())
        );
    }
}
