//! The little of SVG that plots are drawn with, and round numbers along their axes.
//!
//! Text and lines that are to be seen on any background have the classes `ink` and `line`, the background has `paper`,
//! so that a page that shows the drawing can colour them anew.

use std::fmt::Write;

/// `words` for text and attributes of XML and HTML; characters that neither may hold become U+FFFD.
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

/// Begins a drawing of so many pixels on white paper; `alternative` says what it shows to whoever cannot see it.
#[must_use]
pub fn opened([width, height]: [f64; 2], alternative: &str) -> String {
    let label = if alternative.is_empty() {
        String::new()
    } else {
        format!(" aria-label=\"{}\"", escaped(alternative))
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"13\" role=\"img\"{label}>\n\
         <rect class=\"paper\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    )
}

/// Words at a place in pixels; `anchor` is `start`, `middle` or `end`.
pub fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, attributes: &str, words: &str) {
    let class = if attributes.contains("fill=") { "" } else { "class=\"ink\" " };
    let _ = writeln!(
        svg,
        "<text {class}x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {attributes}>{}</text>",
        escaped(words)
    );
}

/// A line through points in pixels, 1.8 pixels wide unless the attributes say otherwise.
pub fn line(svg: &mut String, points: &[[f64; 2]], colour: &str, attributes: &str) {
    let places: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let stroke = if attributes.contains("stroke-width") { "" } else { "stroke-width=\"1.8\" " };
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" {stroke}{attributes}/>",
        places.join(" ")
    );
}

/// The frame around a plot, of left, top, width and height.
pub fn frame(svg: &mut String, [left, top, width, height]: [f64; 4]) {
    let _ = writeln!(
        svg,
        "<rect class=\"line\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" \
         stroke=\"black\"/>"
    );
}

/// Multiples of 1, 2 or 5 times a power of ten within [`low`, `high`] with their labels, `about` so many intervals or
/// somewhat fewer; none unless `low` lies below `high` and both are finite.
#[must_use]
pub fn steps(low: f64, high: f64, about: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / about;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let power = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| (i as f64 * step, tick(i as f64 * step, step))).collect()
}

/// The label of a multiple of `step`, above 0: as many digits as it takes to tell it from the next.
#[must_use]
pub fn tick(value: f64, step: f64) -> String {
    let place = step.log10().floor() as i32;
    let count = |digits: i32| usize::try_from(digits).unwrap_or(0);
    if value.abs() >= 1e6 || (value != 0.0 && step < 1e-4) {
        format!("{value:.*e}", count(value.abs().log10().floor() as i32 - place))
    } else if value == 0.0 && step < 1e-4 {
        "0".to_owned()
    } else {
        format!("{value:.*}", count(-place))
    }
}

/// Words cut at blanks into lines of at most `width` letters; a longer word stands alone.
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

/// At most `width` letters of `words`, with an ellipsis where some are missing.
#[must_use]
pub fn shortened(words: &str, width: usize) -> String {
    if words.chars().count() <= width {
        return words.to_owned();
    }
    words.chars().take(width.saturating_sub(1)).chain(['\u{2026}']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        steps(low, high, 7.0).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn steps_are_round_numbers_within_the_range() {
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(-130.0, 480.0), ["-100", "0", "100", "200", "300", "400"]);
        assert_eq!(labels(1e6, 1.26e6), ["1.00e6", "1.05e6", "1.10e6", "1.15e6", "1.20e6", "1.25e6"]);
        assert_eq!(labels(0.0, 5e-6), ["0", "1e-6", "2e-6", "3e-6", "4e-6", "5e-6"]);
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert_eq!(steps(low, high, 7.0), []);
        }
    }

    #[test]
    fn markup_in_words_is_only_words() {
        assert_eq!(
            escaped("<a href='x'>\"&\"\u{1b}\n"),
            "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;\u{fffd}\u{fffd}"
        );
        let mut svg = String::new();
        text(&mut svg, [1.0, 2.0], "end", "", "</text><script>");
        assert_eq!(
            svg,
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
