//! Lexer of RIB files: requests and their arguments.

use glanz_job::ResourceBudget;

use super::{RibError, RibErrorKind};
use crate::source::line_and_column;

/// Largest number of characters of the input in messages.
pub(super) const QUOTED: usize = 40;

/// A request with the arguments up to the next one.
#[derive(Debug)]
pub(super) struct RibRequest<'a> {
    pub(super) name: &'a str,
    /// Offset in bytes from the start.
    pub(super) at: usize,
    pub(super) arguments: Vec<RibArgument<'a>>,
}

#[derive(Debug)]
pub(super) struct RibArgument<'a> {
    pub(super) at: usize,
    pub(super) value: RibValue<'a>,
}

#[derive(Debug)]
pub(super) enum RibValue<'a> {
    Number(f64),
    Text(&'a [u8]),
    /// The numbers between brackets.
    Numbers(Vec<f64>),
    /// Texts between brackets, which are not used.
    Texts,
}

/// Reader of successive requests.
#[derive(Clone, Debug)]
pub(super) struct RibLexer<'a> {
    bytes: &'a [u8],
    offset: usize,
    budget: &'a ResourceBudget,
}

impl<'a> RibLexer<'a> {
    pub(super) fn new(bytes: &'a [u8], budget: &'a ResourceBudget) -> Self {
        Self { bytes, offset: 0, budget }
    }

    /// The next request; `None` at the end of the file.
    pub(super) fn request(&mut self) -> Result<Option<RibRequest<'a>>, RibError> {
        let Some(first) = self.peek() else { return Ok(None) };
        let at = self.offset;
        if !first.is_ascii_alphabetic() {
            return Err(self.unexpected("a request"));
        }
        self.check()?;
        let name = std::str::from_utf8(self.word()).unwrap_or_default();
        let mut arguments = Vec::new();
        while let Some(byte) = self.peek() {
            let at = self.offset;
            let value = match byte {
                b'"' => RibValue::Text(self.text()?),
                b'[' => self.array()?,
                _ if byte.is_ascii_alphabetic() => break,
                _ => RibValue::Number(self.number("an argument")?),
            };
            arguments.push(RibArgument { at, value });
        }
        Ok(Some(RibRequest { name, at, arguments }))
    }

    /// Offset of the number `index` of the array at `at`.
    pub(super) fn number_in_array(&self, at: usize, index: usize) -> usize {
        let mut lexer = Self { offset: at.saturating_add(1), ..*self };
        for _ in 0..index {
            lexer.peek();
            lexer.word();
        }
        lexer.peek();
        lexer.offset
    }

    pub(super) fn error(&self, at: usize, kind: RibErrorKind) -> RibError {
        let (line, column) = line_and_column(self.bytes, at);
        RibError { line, column, kind }
    }

    /// The next byte that is neither blank nor comment.
    fn peek(&mut self) -> Option<u8> {
        loop {
            let rest = self.bytes.get(self.offset..)?;
            let blank = rest.iter().position(|b| !b.is_ascii_whitespace())?;
            self.offset += blank;
            let rest = rest.get(blank..)?;
            if rest.first() != Some(&b'#') {
                return rest.first().copied();
            }
            self.offset += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        }
    }

    /// Everything up to the next blank, bracket, quote or comment.
    fn word(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.offset..).unwrap_or_default();
        let ends = |b: &u8| b.is_ascii_whitespace() || b"[]\"#".contains(b);
        let word = rest.get(..rest.iter().position(ends).unwrap_or(rest.len())).unwrap_or_default();
        self.offset += word.len();
        word
    }

    fn check(&self) -> Result<(), RibError> {
        self.budget.check().map_err(|end| self.error(self.offset, end.into()))
    }

    fn number(&mut self, wanted: &'static str) -> Result<f64, RibError> {
        self.check()?;
        let start = self.clone();
        let word = self.word();
        // Rust's parser would also accept words such as "nan" and "inf".
        let digits = !word.iter().any(|b| b.is_ascii_alphabetic() && !b"eE".contains(b));
        match std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok()) {
            Some(value) if digits && value.is_finite() => Ok(value),
            Some(_) if digits => {
                let kind = RibErrorKind::NotFinite(String::from_utf8_lossy(word).into_owned());
                Err(self.error(start.offset, kind))
            }
            _ => Err(start.unexpected(wanted)),
        }
    }

    /// The quoted text.
    fn text(&mut self) -> Result<&'a [u8], RibError> {
        let start = self.offset + 1;
        let mut end = start;
        loop {
            match self.bytes.get(end) {
                None => return Err(self.error(self.offset, RibErrorKind::OpenText)),
                Some(b'"') => break,
                Some(b'\\') => end += 2,
                Some(_) => end += 1,
            }
        }
        self.offset = end + 1;
        Ok(self.bytes.get(start..end).unwrap_or_default())
    }

    fn array(&mut self) -> Result<RibValue<'a>, RibError> {
        let open = self.offset;
        self.offset += 1;
        let (mut numbers, mut texts) = (Vec::new(), false);
        loop {
            match self.peek() {
                None => return Err(self.error(open, RibErrorKind::OpenArray)),
                Some(b']') => break,
                Some(b'"') if numbers.is_empty() => {
                    self.text()?;
                    texts = true;
                }
                Some(_) if texts => return Err(self.unexpected("another text")),
                Some(_) => numbers.push(self.number("a number")?),
            }
        }
        self.offset += 1;
        Ok(if texts { RibValue::Texts } else { RibValue::Numbers(numbers) })
    }

    /// Error with the text at the offset and the expected one.
    fn unexpected(&self, wanted: &'static str) -> RibError {
        let byte = self.bytes.get(self.offset).copied().unwrap_or_default();
        if byte >= 0x80 {
            return self.error(self.offset, RibErrorKind::Binary);
        }
        let mut rest = self.clone();
        let word = rest.word();
        let found = if word.is_empty() { std::slice::from_ref(&byte) } else { word };
        let found = String::from_utf8_lossy(found).chars().take(QUOTED).collect();
        self.error(self.offset, RibErrorKind::Unexpected { found, wanted })
    }
}
