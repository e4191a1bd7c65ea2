//! Statements: logical lines of words.

use super::error::{ObjError, ObjErrorKind};
use crate::source::line_and_column;

/// Statements that files begin with.
const FIRST: [&str; 22] = [
    "v", "vt", "vn", "vp", "f", "p", "l", "o", "g", "s", "mg", "usemtl", "mtllib", "cstype", "deg", "bmat",
    "step", "curv2", "curv", "surf", "lod", "maplib",
];

/// Whether the first statement of the bytes is one of OBJ.
pub(crate) fn is_obj(bytes: &[u8]) -> bool {
    let mut statements = Statements::new(bytes);
    statements.advance()
        && statements.words.len() > 1
        && FIRST.iter().any(|name| statements.keyword() == *name)
}

/// A word with its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjWord<'a> {
    pub(super) text: &'a str,
    at: usize,
}

/// Reader of the statements of a file, one at a time.
#[derive(Debug)]
pub(super) struct Statements<'a> {
    bytes: &'a [u8],
    at: usize,
    words: Vec<ObjWord<'a>>,
}

impl<'a> Statements<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, words: Vec::new() }
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
        let code =
            line.iter().position(|&b| b == b'#').map_or(line, |end| line.get(..end).unwrap_or_default());
        let code = code.trim_ascii_end();
        let continues = code.last() == Some(&b'\\') && self.at + length < self.bytes.len();
        let code = if continues { code.get(..code.len() - 1).unwrap_or_default() } else { code };
        let mut start = 0;
        while let Some(skip) =
            code.get(start..).and_then(|rest| rest.iter().position(|b| !b.is_ascii_whitespace()))
        {
            start += skip;
            let word = code.get(start..).unwrap_or_default();
            let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
            // What is not UTF-8 is no statement and no number.
            let text = std::str::from_utf8(word.get(..end).unwrap_or_default()).unwrap_or("\u{fffd}");
            self.words.push(ObjWord { text, at: self.at + start });
            start += end;
        }
        self.at += length + 1;
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
        let words: Vec<&str> = self.values().iter().map(|word| word.text).collect();
        words.join(" ")
    }

    /// Line and column of the statement.
    pub(super) fn place(&self) -> (u32, u32) {
        line_and_column(self.bytes, self.words.first().map_or(0, |word| word.at))
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

/// At most the first 40 characters.
pub(super) fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
