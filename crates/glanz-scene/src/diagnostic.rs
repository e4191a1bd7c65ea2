//! Errors and warnings about a scene, with file, line and column, in the form that people see.

use std::collections::BTreeMap;
use std::fmt;

use glanz_job::{BudgetError, LimitError};

use crate::description::Location;

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The input is refused.
    Error,
    /// A part of the input was repaired, left out or replaced; the rest is used.
    Warning,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Error => "error",
            Self::Warning => "warning",
        })
    }
}

/// The line at fault, cut to a readable length, with the place to point at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// Line number, from 1.
    pub line: u32,
    /// The text; one character per column, without tabs or other control characters.
    pub text: String,
    /// Characters of `text` before the place.
    pub start: usize,
    /// Characters of the place, at least 1.
    pub width: usize,
}

/// Largest number of characters of a line in an excerpt.
const WINDOW: usize = 100;
/// Characters shown before the place when a line is cut.
const LEAD: usize = 40;
/// Replacement for a part that was cut.
const CUT: &str = "...";

impl Excerpt {
    /// Cuts `line_text` around the byte range that starts at `offset` and has `length` bytes.
    ///
    /// Invalid UTF-8 shows as replacement characters. Work and memory do not depend on the length of the line beyond
    /// finding the range in it.
    #[must_use]
    pub fn of_line(line: u32, line_text: &[u8], offset: usize, length: usize) -> Self {
        let offset = offset.min(line_text.len());
        // Four bytes per character at most: enough context on both sides without converting a line of megabytes.
        let from = char_boundary(line_text, offset.saturating_sub(4 * WINDOW));
        let to = line_text.len().min(offset.saturating_add(8 * WINDOW));
        let before = printable(line_text.get(from..offset).unwrap_or_default());
        let after = printable(line_text.get(offset..to).unwrap_or_default());
        let covered =
            line_text.get(offset..line_text.len().min(offset.saturating_add(length))).unwrap_or_default();
        let width = covered.iter().filter(|&&b| !is_continuation(b)).take(WINDOW).count().max(1);

        let whole = from == 0 && to == line_text.len() && before.len() + after.len() <= WINDOW;
        let skipped =
            if whole || (from == 0 && before.len() <= LEAD) { 0 } else { before.len().saturating_sub(LEAD) };
        let cut_front = skipped > 0 || from > 0;
        let mut text = String::new();
        if cut_front {
            text.push_str(CUT);
        }
        text.extend(before.iter().skip(skipped));
        let start = before.len() - skipped + if cut_front { CUT.len() } else { 0 };
        let room = WINDOW.saturating_sub(start);
        text.extend(after.iter().take(room));
        if after.len() > room || to < line_text.len() {
            text.push_str(CUT);
        }
        let text = text.trim_end().to_owned();
        let width = width.min(room.max(1));
        Self { line, text, start, width }
    }
}

fn is_continuation(byte: u8) -> bool {
    byte & 0xC0 == 0x80
}

/// The nearest start of a character at or before `offset`.
fn char_boundary(bytes: &[u8], offset: usize) -> usize {
    let mut at = offset;
    while at > 0 && offset - at < 4 && bytes.get(at).is_some_and(|&b| is_continuation(b)) {
        at -= 1;
    }
    at
}

fn printable(bytes: &[u8]) -> Vec<char> {
    String::from_utf8_lossy(bytes)
        .chars()
        .map(|c| match c {
            '\t' => ' ',
            c if c.is_control() => char::REPLACEMENT_CHARACTER,
            c => c,
        })
        .collect()
}

/// One message about the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Its severity.
    pub severity: Severity,
    /// Kind of the message, for the cap of [`Diagnostics`]; a few words joined by `-`.
    pub kind: &'static str,
    /// Name of the file, as the user would write it; empty for a description built in code.
    pub file: String,
    /// Line and column.
    pub location: Option<Location>,
    /// The fault: one sentence without a full stop.
    pub message: String,
    /// The line at fault.
    pub excerpt: Option<Excerpt>,
    /// The remedy.
    pub help: Option<String>,
}

impl Diagnostic {
    /// File, line, column and message in one line.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { file, message, .. } = self;
        match self.location {
            Some(location) => format!("{file}:{}:{}: {message}", location.line, location.column),
            None if file.is_empty() => message.clone(),
            None => format!("{file}: {message}"),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.severity, self.sentence())?;
        if let Some(excerpt) = &self.excerpt {
            let number = excerpt.line.to_string();
            writeln!(f, "  {number} | {}", excerpt.text)?;
            let (gutter, indent) = (number.len() + 2, excerpt.start);
            writeln!(f, "{:gutter$} | {:indent$}{}", "", "", "^".repeat(excerpt.width))?;
        }
        if let Some(help) = &self.help {
            writeln!(f, "  help: {help}")?;
        }
        Ok(())
    }
}

/// Messages in the order they arose; of one kind at most [`Diagnostics::PER_KIND`] are kept, the rest are counted.
///
/// Printed, this is plain text without colours.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    counts: BTreeMap<(Severity, &'static str), usize>,
    end: Option<BudgetError>,
}

impl Diagnostics {
    /// Largest number of messages of one kind that are kept.
    pub const PER_KIND: usize = 100;

    /// The one message of reading that ended because a budget was used up or its flag raised.
    #[must_use]
    pub fn of_end(diagnostic: Diagnostic, end: BudgetError) -> Self {
        let mut diagnostics = Self { end: Some(end), ..Self::default() };
        diagnostics.push(diagnostic);
        diagnostics
    }

    /// Why reading ended before it was complete, if a budget is the reason.
    #[must_use]
    pub fn end(&self) -> Option<BudgetError> {
        self.end
    }

    /// The limit that was reached, if reading ended for that reason.
    #[must_use]
    pub fn limit(&self) -> Option<LimitError> {
        match self.end {
            Some(BudgetError::Limit(limit)) => Some(limit),
            _ => None,
        }
    }

    /// Adds a message.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if self.admit(diagnostic.severity, diagnostic.kind) {
            self.list.push(diagnostic);
        }
    }

    /// Whether one more message of that kind would be kept.
    #[must_use]
    pub fn keeps(&self, severity: Severity, kind: &'static str) -> bool {
        self.counts.get(&(severity, kind)).is_none_or(|count| *count < Self::PER_KIND)
    }

    /// Counts a message and returns whether it is to be kept, so that one beyond the cap need not be built.
    pub fn admit(&mut self, severity: Severity, kind: &'static str) -> bool {
        let count = self.counts.entry((severity, kind)).or_insert(0);
        *count += 1;
        *count <= Self::PER_KIND
    }

    /// Adds a message that [`Diagnostics::admit`] has counted already.
    pub fn push_admitted(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// The messages kept.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Number of messages of a severity, those not kept included.
    #[must_use]
    pub fn count(&self, severity: Severity) -> usize {
        self.counts.iter().filter(|((s, _), _)| *s == severity).map(|(_, n)| n).sum()
    }

    /// Whether there is an error.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.count(Severity::Error) > 0
    }

    /// Whether there are no messages.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Severity, kind and number of the messages that were counted but not kept.
    pub fn omitted(&self) -> impl Iterator<Item = (Severity, &'static str, usize)> + '_ {
        self.counts
            .iter()
            .filter(|(_, n)| **n > Self::PER_KIND)
            .map(|((severity, kind), n)| (*severity, *kind, n - Self::PER_KIND))
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in &self.list {
            write!(f, "{diagnostic}")?;
        }
        for (severity, kind, count) in self.omitted() {
            writeln!(f, "{severity}: {count} more of the kind \"{kind}\" are not shown")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::FileId;

    fn diagnostic(kind: &'static str) -> Diagnostic {
        let line = br#"Shape "nurbs" "integer uorder" [4] "float uknots" [0 0 0 0 1 0.5 2 2 2 2]"#;
        let column = 61;
        Diagnostic {
            severity: Severity::Error,
            kind,
            file: "room.pbrt".to_owned(),
            location: Some(Location { file: FileId(0), line: 14, column: 3 }),
            message: "shape \"nurbs\": knot vector \"uknots\" must not decrease".to_owned(),
            excerpt: Some(Excerpt::of_line(14, line, column - 1, 3)),
            help: Some("sort the knots, or check a missing value between 1 and 0.5".to_owned()),
        }
    }

    #[test]
    fn errors_have_the_documented_form() {
        let expected = "\
error: room.pbrt:14:3: shape \"nurbs\": knot vector \"uknots\" must not decrease
  14 | Shape \"nurbs\" \"integer uorder\" [4] \"float uknots\" [0 0 0 0 1 0.5 2 2 2 2]
     |                                                             ^^^
  help: sort the knots, or check a missing value between 1 and 0.5
";
        assert_eq!(diagnostic("knots").to_string(), expected);
    }

    #[test]
    fn a_line_of_megabytes_is_cut_around_the_place() {
        let mut line = b"1 ".repeat(1 << 20);
        let at = 1_000_001;
        line[at] = b'x';
        let excerpt = Excerpt::of_line(1, &line, at, 1);
        assert!(excerpt.text.chars().count() <= WINDOW + 2 * CUT.len());
        assert_eq!(excerpt.text.chars().nth(excerpt.start), Some('x'));
        assert!(excerpt.text.starts_with(CUT) && excerpt.text.ends_with(CUT));
        assert_eq!(excerpt.width, 1);
    }

    #[test]
    fn carets_stand_under_the_characters_after_tabs_and_wide_letters() {
        let line = "\t\u{fc}ber \u{1} \"x\"".as_bytes();
        let at = line.iter().position(|&b| b == b'"').unwrap();
        let excerpt = Excerpt::of_line(3, line, at, 3);
        assert_eq!(excerpt.text, " \u{fc}ber \u{fffd} \"x\"");
        assert_eq!((excerpt.start, excerpt.width), (8, 3));
    }

    #[test]
    fn a_place_beyond_the_line_points_behind_its_end() {
        let excerpt = Excerpt::of_line(1, b"abc", 99, 5);
        assert_eq!((excerpt.text.as_str(), excerpt.start, excerpt.width), ("abc", 3, 1));
    }

    #[test]
    fn equal_kinds_beyond_the_cap_are_counted_only() {
        let mut all = Diagnostics::default();
        for _ in 0..Diagnostics::PER_KIND + 7 {
            all.push(diagnostic("a"));
        }
        all.push(diagnostic("b"));
        assert_eq!(all.iter().count(), Diagnostics::PER_KIND + 1);
        assert_eq!(all.count(Severity::Error), Diagnostics::PER_KIND + 8);
        assert!(all.to_string().ends_with("error: 7 more of the kind \"a\" are not shown\n"));
    }
}
