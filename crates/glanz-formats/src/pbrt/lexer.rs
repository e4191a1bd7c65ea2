//! Lexer of pbrt files: words, texts, brackets and numbers.

use std::sync::Arc;

use glanz_job::{Resource, ResourceBudget};
use glanz_scene::Location;
use glanz_scene::description::FileId;

use crate::growing_memory::GrowingReservation;
use crate::source::Span;

/// A token of the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    /// A directive, a number, `true` or `false`: anything without quotes.
    Word(String),
    /// Quoted text, escapes resolved.
    Text(String),
    /// `[`
    Open,
    /// `]`
    Close,
}

/// Error of the lexer, with its span.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LexError {
    pub(crate) place: Span,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

/// The budget is asked once for so many tokens.
const TOKENS_AT_ONCE: u64 = 256;
/// Largest number of bytes of a word in messages.
const QUOTED: usize = 40;
/// Largest number of bytes of a quoted text; a longer one lacks its closing quote.
const MAX_TEXT: usize = 1 << 16;

/// Bytes of a list that are too few to be reserved.
const SHORT_LIST: u64 = 1 << 16;

/// Memory of a list that grows while its values are read.
#[derive(Debug, Default)]
pub(crate) struct ListMemory(Option<GrowingReservation>);

/// Lexer of the bytes of a file, which stores no tokens.
#[derive(Clone, Debug)]
pub(crate) struct Lexer {
    bytes: Arc<[u8]>,
    file: FileId,
    offset: usize,
    line: u32,
    line_start: usize,
    /// Offset and column of the last position computed on this line, so that the characters of a very long line are counted once.
    counted: (usize, u32),
    budget: ResourceBudget,
    /// Tokens that are not taken off the budget yet.
    unspent: u64,
}

impl Lexer {
    /// A lexer at the beginning of the file, after a byte order mark.
    pub(crate) fn new(bytes: Arc<[u8]>, file: FileId, budget: &ResourceBudget) -> Self {
        let offset = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
        let budget = budget.clone();
        Self { bytes, file, offset, line: 1, line_start: offset, counted: (offset, 1), budget, unspent: 0 }
    }

    /// A lexer at an earlier position.
    pub(crate) fn resume(bytes: Arc<[u8]>, place: &Span) -> Self {
        let Location { file, line, column } = place.location;
        let before = bytes.get(..place.offset).unwrap_or_default();
        let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let (counted, budget) = ((place.offset, column), ResourceBudget::default());
        Self { bytes, file, offset: place.offset, line, line_start, counted, budget, unspent: 0 }
    }

    /// The span of the word `count` words ahead; brackets and quoted texts count as words.
    pub(crate) fn word_after(&mut self, count: usize) -> Span {
        for _ in 0..count {
            if self.peek().is_none() {
                break;
            }
            self.skip_word();
        }
        self.peek();
        let length = self.word_length().max(1);
        self.place(length)
    }

    /// Counts a token. The budget is asked once for many of them.
    fn count(&mut self) -> Result<(), LexError> {
        self.unspent += 1;
        if self.unspent < TOKENS_AT_ONCE { Ok(()) } else { self.spend() }
    }

    /// Takes the tokens so far off the budget.
    pub(crate) fn spend(&mut self) -> Result<(), LexError> {
        let tokens = std::mem::take(&mut self.unspent);
        let spent = self.budget.check().and_then(|()| self.budget.spend(Resource::Tokens, tokens));
        spent.map_err(|end| LexError { place: self.place(1), message: end.to_string(), help: None })
    }

    /// Reserves memory for a list of `count` values: all are in the old list, and the new one has room for twice as many.
    pub(crate) fn reserve_list<T>(&mut self, memory: &mut ListMemory, count: usize) -> Result<(), LexError> {
        let bytes = (3 * size_of::<T>() as u64).saturating_mul(count as u64);
        if bytes < SHORT_LIST {
            return Ok(());
        }
        let reserved = memory.0.get_or_insert_with(|| GrowingReservation::new(&self.budget)).reach(bytes);
        reserved.map_err(|end| LexError { place: self.place(1), message: end.to_string(), help: None })
    }

    /// The file being read.
    pub(crate) fn file(&self) -> FileId {
        self.file
    }

    /// The next byte that is neither blank nor comment; `None` at the end.
    pub(crate) fn peek(&mut self) -> Option<u8> {
        while let Some(&b) = self.bytes.get(self.offset) {
            match b {
                b'\n' => {
                    self.offset += 1;
                    self.line = self.line.saturating_add(1);
                    self.line_start = self.offset;
                    self.counted = (self.offset, 1);
                }
                b' ' | b'\t' | b'\r' | 0x0B | 0x0C => self.offset += 1,
                b'#' => {
                    let rest = self.bytes.get(self.offset..).unwrap_or_default();
                    self.offset += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                }
                _ => return Some(b),
            }
        }
        None
    }

    /// The span of the next `length` bytes.
    pub(crate) fn place(&mut self, length: usize) -> Span {
        self.place_at(self.offset, length)
    }

    fn place_at(&mut self, offset: usize, length: usize) -> Span {
        let (from, column) = if offset >= self.counted.0 { self.counted } else { (self.line_start, 1) };
        let between = self.bytes.get(from..offset).unwrap_or_default();
        let count = between.iter().filter(|&&b| b & 0xC0 != 0x80).count();
        let column = column.saturating_add(u32::try_from(count).unwrap_or(u32::MAX));
        self.counted = (offset, column);
        let location = Location { file: self.file, line: self.line, column };
        Span { location, offset, length }
    }

    /// The next token and its span; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<(Token, Span)>, LexError> {
        let Some(first) = self.peek() else { return Ok(None) };
        // A text counts itself.
        if first != b'"' {
            self.count()?;
        }
        match first {
            b'[' | b']' => {
                let place = self.place(1);
                self.offset += 1;
                Ok(Some((if first == b'[' { Token::Open } else { Token::Close }, place)))
            }
            b'"' => self.text().map(|(text, place)| Some((Token::Text(text), place))),
            _ => {
                let length = self.word_length();
                let place = self.place(length);
                let word = self.bytes.get(self.offset..self.offset + length).unwrap_or_default();
                let word = String::from_utf8_lossy(word.get(..length.min(MAX_TEXT)).unwrap_or_default());
                let word = word.into_owned();
                self.offset += length;
                Ok(Some((Token::Word(word), place)))
            }
        }
    }

    /// Bytes up to the next blank, bracket, quote or comment.
    fn word_length(&self) -> usize {
        let rest = self.bytes.get(self.offset..).unwrap_or_default();
        rest.iter().position(|&b| ends_word(b)).unwrap_or(rest.len())
    }

    /// Skips a bracket or an unquoted word.
    pub(crate) fn skip_word(&mut self) {
        self.offset = self.bytes.len().min(self.offset + self.word_length().max(1));
    }

    /// Skips the closing bracket that is next.
    pub(crate) fn close(&mut self) -> Result<(), LexError> {
        self.count()?;
        self.skip_word();
        Ok(())
    }

    /// The quoted text that starts here; its span includes the quotes.
    pub(crate) fn text(&mut self) -> Result<(String, Span), LexError> {
        self.count()?;
        let start = self.offset;
        let bytes = Arc::clone(&self.bytes);
        let rest = bytes.get(start + 1..).unwrap_or_default();
        let mut out = Vec::new();
        let mut i = 0;
        loop {
            match rest.get(i) {
                Some(b'"') => break,
                Some(b'\\') => {
                    match rest.get(i + 1) {
                        Some(b'n') => out.push(b'\n'),
                        Some(b't') => out.push(b'\t'),
                        Some(b'r') => out.push(b'\r'),
                        Some(b'b') => out.push(0x08),
                        Some(b'f') => out.push(0x0C),
                        Some(&c @ (b'\\' | b'"' | b'\'')) => out.push(c),
                        // Not an escape: a Windows path keeps its backslash.
                        Some(&c) if c != b'\n' => out.extend([b'\\', c]),
                        _ => return Err(self.unterminated(start)),
                    }
                    i += 2;
                }
                Some(&b) if b != b'\n' && i < MAX_TEXT => {
                    out.push(b);
                    i += 1;
                }
                _ => return Err(self.unterminated(start)),
            }
        }
        let place = self.place_at(start, i + 2);
        self.offset = start + i + 2;
        Ok((String::from_utf8_lossy(&out).into_owned(), place))
    }

    /// Reports a text without end and continues with the next line.
    fn unterminated(&mut self, start: usize) -> LexError {
        let place = self.place_at(start, 1);
        let rest = self.bytes.get(start..).unwrap_or_default();
        self.offset = start + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        LexError {
            place,
            message: "text without a closing quote".to_owned(),
            help: Some("a text must end on the line on which it begins".to_owned()),
        }
    }

    /// The number that starts here.
    pub(crate) fn float(&mut self) -> Result<f64, LexError> {
        self.count()?;
        let length = self.word_length();
        let word = self.bytes.get(self.offset..self.offset + length).unwrap_or_default();
        match parse_float(word) {
            Some(value) if value.is_finite() => {
                self.offset += length;
                Ok(value)
            }
            Some(_) => Err(self.not_a_value(length, "is too large for a number")),
            None => Err(self.not_a_value(length, "is not a number")),
        }
    }

    /// The integer that starts here; `3.0` is also accepted.
    pub(crate) fn integer(&mut self) -> Result<i32, LexError> {
        self.count()?;
        let length = self.word_length();
        let word = self.bytes.get(self.offset..self.offset + length).unwrap_or_default();
        if let Some(value) = parse_integer(word) {
            self.offset += length;
            return Ok(value);
        }
        let problem = match parse_float(word) {
            Some(value) if value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX) => {
                self.offset += length;
                return Ok(value as i32);
            }
            Some(value) if value.fract() == 0.0 || !value.is_finite() => "is too large for an integer",
            Some(_) => "is not an integer",
            None => "is not a number",
        };
        Err(self.not_a_value(length, problem))
    }

    /// Error for the word that starts here; skips it.
    fn not_a_value(&mut self, length: usize, problem: &str) -> LexError {
        let place = self.place(length.max(1));
        let word = self.bytes.get(self.offset..self.offset + length).unwrap_or_default();
        let shown = String::from_utf8_lossy(word.get(..length.min(QUOTED)).unwrap_or_default());
        let dots = if length > QUOTED { "..." } else { "" };
        let message = match self.bytes.get(self.offset) {
            None => "a number is missing at the end of the file".to_owned(),
            Some(b'"') => "a number is expected, not text".to_owned(),
            Some(b'[') => "a number is expected, not another bracket".to_owned(),
            Some(b']') => "a number is expected before the bracket closes".to_owned(),
            Some(_) => format!("{:?} {problem}", format!("{shown}{dots}")),
        };
        self.offset += length;
        LexError { place, message, help: None }
    }

    /// Skips everything up to the next unquoted word that starts with a letter and is not a Boolean value; such
    /// a word begins a directive.
    pub(crate) fn skip_to_directive(&mut self) {
        while let Some(b) = self.peek() {
            if self.budget.check().is_err() {
                return;
            }
            match b {
                // A text without end was skipped up to the end of its line.
                b'"' => drop(self.text()),
                b'[' | b']' => self.offset += 1,
                _ => {
                    let length = self.word_length();
                    let word = self.bytes.get(self.offset..self.offset + length).unwrap_or_default();
                    if b.is_ascii_uppercase() && word.iter().all(u8::is_ascii_alphabetic) {
                        return;
                    }
                    self.offset += length;
                }
            }
        }
    }
}

fn ends_word(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\n' | b'\r' | 0x0B | 0x0C | b'[' | b']' | b'"' | b'#')
}

/// Parses decimal notation only: `inf`, `nan` and similar words are not numbers here.
fn parse_float(word: &[u8]) -> Option<f64> {
    if !word.iter().all(|b| matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-' | b'e' | b'E')) {
        return None;
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Parses digits with an optional sign, within the range of `i32`.
fn parse_integer(word: &[u8]) -> Option<i32> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for &d in digits {
        if !d.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(d - b'0');
    }
    i32::try_from(if negative { -value } else { value }).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lexer(text: &[u8]) -> Lexer {
        Lexer::new(Arc::from(text), FileId(0), &ResourceBudget::default())
    }

    fn position(place: &Span) -> (u32, u32) {
        (place.location.line, place.location.column)
    }

    #[test]
    fn tokens_come_with_line_and_column_in_characters() {
        let mut l = lexer("# note\n Shape \"sph\u{e4}re\" [1 -.5e1]".as_bytes());
        let mut found = Vec::new();
        while let Some((token, place)) = l.next().unwrap() {
            found.push((token, position(&place), place.length));
        }
        assert_eq!(
            found,
            [
                (Token::Word("Shape".into()), (2, 2), 5),
                (Token::Text("sph\u{e4}re".into()), (2, 8), 9),
                (Token::Open, (2, 17), 1),
                (Token::Word("1".into()), (2, 18), 1),
                (Token::Word("-.5e1".into()), (2, 20), 5),
                (Token::Close, (2, 25), 1),
            ]
        );
    }

    #[test]
    fn escapes_are_resolved_and_other_backslashes_stay() {
        let mut l = lexer(br#""a\"b\\c\n" "d\s""#);
        assert_eq!(l.peek(), Some(b'"'));
        assert_eq!(l.text().unwrap().0, "a\"b\\c\n");
        assert_eq!(l.peek(), Some(b'"'));
        assert_eq!(l.text().unwrap().0, "d\\s");
    }

    #[test]
    fn text_without_end_is_reported_once_and_reading_continues_on_the_next_line() {
        let mut l = lexer(b"  \"abc\nWorldBegin");
        let error = l.next().unwrap_err();
        assert_eq!(
            (position(&error.place), error.message.as_str()),
            ((1, 3), "text without a closing quote")
        );
        assert_eq!(l.next().unwrap().unwrap().0, Token::Word("WorldBegin".into()));
    }

    #[test]
    fn numbers_are_decimal_and_finite() {
        for (text, value) in
            [("1", 1.0), ("-.5", -0.5), ("+2.5e-3", 0.0025), ("1.", 1.0), ("1.74846e-007", 1.74846e-7)]
        {
            assert_eq!(lexer(text.as_bytes()).float().unwrap(), value, "{text}");
        }
        for (text, message) in [
            ("inf", "\"inf\" is not a number"),
            ("-nan", "\"-nan\" is not a number"),
            ("infinity", "\"infinity\" is not a number"),
            ("0x10", "\"0x10\" is not a number"),
            ("1e999", "\"1e999\" is too large for a number"),
            ("", "a number is missing at the end of the file"),
            ("\"a\"", "a number is expected, not text"),
            ("]", "a number is expected before the bracket closes"),
        ] {
            assert_eq!(lexer(text.as_bytes()).float().unwrap_err().message, message);
        }
    }

    #[test]
    fn integers_may_have_a_point_but_no_fraction() {
        assert_eq!(lexer(b"-2147483648").integer().unwrap(), i32::MIN);
        assert_eq!(lexer(b"3.0").integer().unwrap(), 3);
        assert_eq!(lexer(b"3.5").integer().unwrap_err().message, "\"3.5\" is not an integer");
        assert_eq!(
            lexer(b"2147483648").integer().unwrap_err().message,
            "\"2147483648\" is too large for an integer"
        );
        assert_eq!(
            lexer(&[b'9'; 60]).integer().unwrap_err().message.len(),
            45 + "is too large for an integer".len() + 1
        );
    }

    #[test]
    fn columns_on_a_very_long_line_cost_linear_time() {
        let mut l = lexer(&b"1 ".repeat(1 << 20));
        let mut last = 0;
        while l.peek().is_some() {
            last = l.place(1).location.column;
            l.float().unwrap();
        }
        assert_eq!(last, (1 << 21) - 1);
    }

    #[test]
    fn value_is_found_again_from_the_first_of_its_list() {
        let bytes: Arc<[u8]> = Arc::from("\u{e4} [ 0 1 # two\n  2.5 ]".as_bytes());
        let mut l = Lexer::new(Arc::clone(&bytes), FileId(0), &ResourceBudget::default());
        l.peek();
        l.skip_word();
        l.next().unwrap();
        l.peek();
        let first = l.place(1);
        let found = |count| {
            let place = Lexer::resume(Arc::clone(&bytes), &first).word_after(count);
            (position(&place), place.length)
        };
        assert_eq!(found(0), ((1, 5), 1));
        assert_eq!(found(1), ((1, 7), 1));
        assert_eq!(found(2), ((2, 3), 3));
    }

    #[test]
    fn texts_and_brackets_are_one_token_each() {
        let budget = ResourceBudget::default();
        let mut l = Lexer::new(Arc::from(&b"Shape \"a\" \"b\" [ 1 ]"[..]), FileId(0), &budget);
        l.next().unwrap();
        l.next().unwrap();
        l.peek();
        l.text().unwrap();
        l.next().unwrap();
        l.peek();
        l.float().unwrap();
        l.peek();
        l.close().unwrap();
        l.spend().unwrap();
        assert_eq!((l.peek(), budget.used(Resource::Tokens)), (None, 6));
    }

    #[test]
    fn recovery_ends_at_the_next_directive() {
        let mut l = lexer(b"1 ] \"Shape\" [ true] 3x -- \"open\nfoo Material \"matte\"");
        l.skip_to_directive();
        assert_eq!(l.next().unwrap().unwrap().0, Token::Word("Material".into()));
        l.skip_to_directive();
        assert_eq!(l.next().unwrap(), None);
    }
}
