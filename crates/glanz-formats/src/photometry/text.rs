//! Lines and numbers of photometric files.

use std::ops::RangeInclusive;

use super::error::{PhotometryError, PhotometryErrorKind};
use crate::source::line_and_column;

/// Text of a file: UTF-8 if valid, else Windows-1252, which includes Latin-1 and ASCII.
pub(super) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| windows_1252(b)).collect(),
    }
}

/// The characters of Windows-1252 in place of the control codes of Latin-1.
fn windows_1252(byte: u8) -> char {
    const HIGH: [char; 32] = [
        '\u{20ac}', '\u{81}', '\u{201a}', '\u{192}', '\u{201e}', '\u{2026}', '\u{2020}', '\u{2021}',
        '\u{2c6}', '\u{2030}', '\u{160}', '\u{2039}', '\u{152}', '\u{8d}', '\u{17d}', '\u{8f}', '\u{90}',
        '\u{2018}', '\u{2019}', '\u{201c}', '\u{201d}', '\u{2022}', '\u{2013}', '\u{2014}', '\u{2dc}',
        '\u{2122}', '\u{161}', '\u{203a}', '\u{153}', '\u{9d}', '\u{17e}', '\u{178}',
    ];
    let high = byte.checked_sub(0x80).and_then(|i| HIGH.get(usize::from(i)));
    high.copied().unwrap_or(char::from(byte))
}

/// A finite number; Rust's parser would also accept words such as "inf".
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|v: &f64| v.is_finite())
}

/// An error at a range of bytes.
pub(super) fn fault(bytes: &[u8], at: usize, length: usize, kind: PhotometryErrorKind) -> PhotometryError {
    let (line, column) = line_and_column(bytes, at);
    PhotometryError { line, column, length, kind }
}

/// Refuses text of two bytes per character; returns the number of bytes to skip at the beginning.
pub(super) fn start(bytes: &[u8]) -> Result<usize, PhotometryError> {
    match bytes {
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Err(fault(bytes, 0, 2, PhotometryErrorKind::Utf16)),
        [0xEF, 0xBB, 0xBF, ..] => Ok(3),
        _ => Ok(0),
    }
}

/// Largest intensity, candela: larger ones are errors, and sums of smaller ones are finite.
pub(super) const MAX_CANDELA: f64 = 1e30;

/// Source of the numbers of a photometric file, with the checks of their values.
pub(super) trait NumberReader {
    /// The next number; `what`: its name in messages.
    fn number(&mut self, what: &'static str) -> Result<f64, PhotometryError>;

    /// The place in the file.
    fn cursor(&self) -> &TextCursor<'_>;

    /// An error of the last number.
    fn value_error(&self, what: &'static str, value: f64, allowed: &'static str) -> PhotometryError {
        self.cursor().here(PhotometryErrorKind::Value { what, value, allowed })
    }

    /// The next number, which must be a whole one of `range`; `allowed`: the range in words.
    fn whole(
        &mut self,
        what: &'static str,
        allowed: &'static str,
        range: RangeInclusive<f64>,
    ) -> Result<f64, PhotometryError> {
        let value = self.number(what)?;
        let fits = value.fract() == 0.0 && range.contains(&value);
        if fits { Ok(value) } else { Err(self.value_error(what, value, allowed)) }
    }

    /// The next number, which must be positive.
    fn positive(&mut self, what: &'static str) -> Result<f64, PhotometryError> {
        let value = self.number(what)?;
        if value > 0.0 { Ok(value) } else { Err(self.value_error(what, value, "more than 0")) }
    }

    /// A declared number of values, at least `least`, for which the rest of the file has room.
    fn count(&mut self, what: &'static str, least: f64) -> Result<usize, PhotometryError> {
        // Conversions are exact far beyond 1e12.
        let allowed = if least > 1.0 { "a whole number from 2" } else { "a whole number from 1" };
        let count = self.whole("number of angles", allowed, least..=1e12)? as usize;
        self.check_room(what, count)?;
        Ok(count)
    }

    /// Refuses more values than the rest of the file has room for.
    fn check_room(&self, what: &'static str, count: usize) -> Result<(), PhotometryError> {
        let room = self.cursor().room();
        if count > room {
            let declared = count as f64;
            return Err(self.cursor().here(PhotometryErrorKind::Count { what, declared, room }));
        }
        Ok(())
    }

    /// A fixed number of angles, each larger than the one before.
    fn ascending(&mut self, what: &'static str, count: usize) -> Result<Vec<f64>, PhotometryError> {
        let mut angles: Vec<f64> = Vec::with_capacity(count);
        for _ in 0..count {
            let second = self.number(what)?;
            if let Some(&first) = angles.last()
                && second <= first
            {
                return Err(self.cursor().here(PhotometryErrorKind::Order { what, first, second }));
            }
            angles.push(second);
        }
        Ok(angles)
    }

    /// A fixed number of intensities times `factor`, candela.
    fn intensities(&mut self, count: usize, factor: f64) -> Result<Vec<f64>, PhotometryError> {
        let mut candela = Vec::with_capacity(count);
        for _ in 0..count {
            let value = self.number("intensity")? * factor;
            if value.abs() > MAX_CANDELA || value.is_nan() {
                return Err(self.value_error("intensity", value, "at most 1e30 candela"));
            }
            candela.push(value);
        }
        Ok(candela)
    }
}

/// Reader of successive lines or numbers.
#[derive(Clone, Debug)]
pub(super) struct TextCursor<'a> {
    pub(super) bytes: &'a [u8],
    /// Offset of the search for the next line or number.
    pub(super) at: usize,
    /// Start and length of the last line or number.
    pub(super) last: (usize, usize),
}

impl<'a> TextCursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, PhotometryError> {
        Ok(Self { bytes, at: start(bytes)?, last: (0, 0) })
    }

    /// The next line without blanks around it.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|r| !r.is_empty())?;
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let line = rest.get(..length)?.trim_ascii_end();
        let lead = line.len() - line.trim_ascii_start().len();
        self.last = (self.at + lead, line.len() - lead);
        self.at += length + 1;
        line.get(lead..)
    }

    /// Largest number of numbers in the rest: a digit each and a separator.
    pub(super) fn room(&self) -> usize {
        self.bytes.len().saturating_sub(self.at).div_ceil(2)
    }

    /// Whether another number or word follows.
    pub(super) fn has_more(&self) -> bool {
        self.clone().word().is_some()
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        // 0x1A ended text files under MS-DOS.
        let between = |b: &u8| b.is_ascii_whitespace() || matches!(b, b',' | 0x1A | 0);
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(lead) = rest.iter().position(|b| !between(b)) else {
            self.last = (self.bytes.len(), 0);
            return None;
        };
        let rest = rest.get(lead..)?;
        let length = rest.iter().position(between).unwrap_or(rest.len());
        self.last = (self.at + lead, length);
        self.at += lead + length;
        rest.get(..length)
    }

    /// An error at the last line or number.
    pub(super) fn here(&self, kind: PhotometryErrorKind) -> PhotometryError {
        fault(self.bytes, self.last.0, self.last.1, kind)
    }
}

impl NumberReader for TextCursor<'_> {
    /// The next number; numbers are separated by blanks, line ends or commas.
    fn number(&mut self, what: &'static str) -> Result<f64, PhotometryError> {
        let text = self.word().ok_or_else(|| self.here(PhotometryErrorKind::End(what)))?;
        let shown = || decode(text.get(..text.len().min(40)).unwrap_or_default());
        let value = std::str::from_utf8(text).ok().and_then(number);
        value.ok_or_else(|| self.here(PhotometryErrorKind::Number { what, text: shown() }))
    }

    fn cursor(&self) -> &TextCursor<'_> {
        self
    }
}
