//! Statements: logical lines of words.

use std::borrow::Cow;

use glanz_job::ResourceBudget;

use super::error::{ObjError, ObjErrorKind};
use crate::growing_memory::GrowingReservation;
use crate::source::{line_and_column, shortened};

/// Statements that files begin with.
const FIRST: [&str; 22] = [
    "v", "vt", "vn", "vp", "f", "p", "l", "o", "g", "s", "mg", "usemtl", "mtllib", "cstype", "deg", "bmat",
    "step", "curv2", "curv", "surf", "lod", "maplib",
];

/// Whether the first statement of the bytes is one of OBJ.
pub(crate) fn is_obj(bytes: &[u8]) -> bool {
    let mut statements = Statements { most_words: 2, ..Statements::new(bytes) };
    statements.advance()
        && statements.words.len() > 1
        && FIRST.iter().any(|name| statements.keyword() == *name)
}

/// The memory of words is reserved for so many at once.
const WORDS_AT_ONCE: usize = 1024;

/// Bytes of a word in a list that grows, and of the corner of a polygon that it may be.
const BYTES_PER_WORD: u64 = 250;

/// Beginnings of statements with a name, in which `#` begins no comment: exporters number materials that way.
const NAMING: [&str; 4] = ["usemtl", "mtllib", "newmtl", "map_"];

/// A word with its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjWord<'a> {
    pub(super) text: &'a str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ObjWord<'a> {
    /// The word as a part of a name: in UTF-8, else in Latin 1, so that different names stay different.
    pub(super) fn name(&self) -> Cow<'a, str> {
        let latin = |_| Cow::Owned(self.bytes.iter().copied().map(char::from).collect());
        std::str::from_utf8(self.bytes).map_or_else(latin, Cow::Borrowed)
    }
}

/// Reader of the statements of a file, one at a time.
#[derive(Debug)]
pub(super) struct Statements<'a> {
    bytes: &'a [u8],
    at: usize,
    words: Vec<ObjWord<'a>>,
    /// Lines before `at`.
    lines: u32,
    /// Line and column of the first word.
    place: (u32, u32),
    budget: Option<&'a ResourceBudget>,
    /// Memory of the words.
    memory: Option<GrowingReservation>,
    /// Number of words after which nothing is read.
    most_words: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        // A byte order mark is no part of the first word.
        let at = if bytes.starts_with("\u{feff}".as_bytes()) { '\u{feff}'.len_utf8() } else { 0 };
        let (words, most_words) = (Vec::new(), usize::MAX);
        Self { bytes, at, words, lines: 0, place: (1, 1), budget: None, memory: None, most_words }
    }

    /// The same, which ends when the budget does.
    pub(super) fn within(self, budget: &'a ResourceBudget) -> Self {
        Self { budget: Some(budget), memory: Some(GrowingReservation::new(budget)), ..self }
    }

    /// Goes on to the next statement, if there is one.
    pub(super) fn advance(&mut self) -> bool {
        self.words.clear();
        while self.at < self.bytes.len() && self.words.is_empty() {
            while self.line() {}
        }
        !self.words.is_empty()
    }

    /// Adds the words of a line; whether the statement continues on the next one.
    fn line(&mut self) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let line = rest.get(..length).unwrap_or_default();
        let statement = self.words.first().map_or(line.trim_ascii_start(), |word| word.bytes);
        let is_naming = NAMING.iter().any(|name| statement.starts_with(name.as_bytes()));
        let comment = line.iter().position(|&b| b == b'#').filter(|_| !is_naming);
        let code = line.get(..comment.unwrap_or(length)).unwrap_or_default().trim_ascii_end();
        let continues = code.last() == Some(&b'\\') && self.at + length < self.bytes.len();
        let code = if continues { code.get(..code.len() - 1).unwrap_or_default() } else { code };
        let mut start = 0;
        while let Some(skip) =
            code.get(start..).and_then(|rest| rest.iter().position(|b| !b.is_ascii_whitespace()))
        {
            start += skip;
            let is_over = self.budget.is_some_and(|budget| budget.check().is_err());
            if is_over || self.words.len() >= self.most_words {
                self.at = self.bytes.len();
                return false;
            }
            let word = code.get(start..).unwrap_or_default();
            let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
            // What is not UTF-8 is no statement and no number.
            let bytes = word.get(..end).unwrap_or_default();
            let text = std::str::from_utf8(bytes).unwrap_or("\u{fffd}");
            if self.words.is_empty() {
                let from_one = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).saturating_add(1);
                self.place = (self.lines.saturating_add(1), from_one(start));
            }
            self.words.push(ObjWord { text, bytes, at: self.at + start });
            if self.words.len().is_multiple_of(WORDS_AT_ONCE)
                && let Some(memory) = &mut self.memory
                && memory.reach(BYTES_PER_WORD * self.words.len() as u64).is_err()
            {
                self.at = self.bytes.len();
                return false;
            }
            start += end;
        }
        self.at += length + 1;
        self.lines = self.lines.saturating_add(1);
        continues
    }

    /// The first word.
    pub(super) fn keyword(&self) -> &'a str {
        self.words.first().map_or("", |word| word.text)
    }

    /// The other words.
    pub(super) fn values(&self) -> &[ObjWord<'a>] {
        self.words.get(1..).unwrap_or_default()
    }

    /// The other words as one text.
    pub(super) fn rest(&self) -> String {
        let words: Vec<_> = self.values().iter().map(ObjWord::name).collect();
        words.join(" ")
    }

    /// Line and column of the statement.
    pub(super) fn place(&self) -> (u32, u32) {
        self.place
    }

    /// An error at a word, or at the statement.
    pub(super) fn error(&self, word: Option<&ObjWord<'_>>, kind: ObjErrorKind) -> ObjError {
        let (line, column) = word.map_or_else(|| self.place(), |word| line_and_column(self.bytes, word.at));
        ObjError { line, column, kind }
    }

    /// The values, if there are as many as needed.
    pub(super) fn at_least(&self, needed: usize) -> Result<&[ObjWord<'a>], ObjError> {
        let values = self.values();
        if values.len() >= needed {
            return Ok(values);
        }
        let kind = ObjErrorKind::Count { statement: shortened(self.keyword()), found: values.len(), needed };
        Err(self.error(None, kind))
    }

    /// A finite number.
    pub(super) fn number(&self, word: &ObjWord<'_>) -> Result<f64, ObjError> {
        let number = word.text.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.error(Some(word), ObjErrorKind::Number(shortened(word.text))))
    }

    /// `N` numbers from the value `first` on; those after the last one are `default`.
    pub(super) fn numbers<const N: usize>(&self, needed: usize, default: f64) -> Result<[f64; N], ObjError> {
        let mut numbers = [default; N];
        for (number, word) in numbers.iter_mut().zip(self.at_least(needed)?) {
            *number = self.number(word)?;
        }
        Ok(numbers)
    }

    /// The position in a list of `count` elements that a number from 1, or from -1 backwards, stands for.
    pub(super) fn index(
        &self,
        word: &ObjWord<'_>,
        text: &str,
        what: &'static str,
        count: usize,
    ) -> Result<usize, ObjError> {
        let index: i64 =
            text.parse().map_err(|_| self.error(Some(word), ObjErrorKind::Corner(shortened(word.text))))?;
        let position = match index {
            1.. => usize::try_from(index - 1).ok(),
            0 => None,
            _ => usize::try_from(index.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
        };
        position
            .filter(|&position| position < count)
            .ok_or_else(|| self.error(Some(word), ObjErrorKind::Index { what, index, count }))
    }
}
