//! Values in free format, which continue over records.

use super::records::IgesRecord;

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum IgesValue {
    /// Nothing between two delimiters: the default.
    Missing,
    Number(f64),
    /// A text, by its index.
    Text(u32),
    /// Something else.
    Invalid,
}

/// What ends a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueEnd {
    /// Another value follows.
    Parameter,
    /// It was the last of its record.
    Record,
    /// The text ends.
    Missing,
}

/// A value as the file writes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FreeValue {
    Missing,
    Number(f64),
    Text(String),
    Invalid(&'static str),
}

/// Characters of a text that are kept.
const MAX_TEXT: usize = 200;

/// Characters of a number.
const MAX_NUMBER: usize = 64;

/// A position in records whose first `width` columns have text.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeText<'a, 'b> {
    records: &'b [IgesRecord<'a>],
    width: usize,
    column: usize,
    /// Parameter and record delimiter.
    pub(super) delimiters: [u8; 2],
    /// Characters passed.
    pub(super) passed: usize,
    /// The number of a record that is missing; the text ends in front of it, since what follows does not belong to what is before.
    pub(super) lost: Option<u32>,
}

impl<'a, 'b> FreeText<'a, 'b> {
    pub(super) fn new(records: &'b [IgesRecord<'a>], width: usize, delimiters: [u8; 2]) -> Self {
        Self { records, width, column: 0, delimiters, passed: 0, lost: None }
    }

    /// Line and column from 1.
    pub(super) fn position(&self) -> Option<[u32; 2]> {
        let record = self.records.first()?;
        Some([record.line, self.column as u32 + 1])
    }

    /// The next character; missing ones at the end of a record are blanks.
    pub(super) fn next_byte(&mut self) -> Option<u8> {
        let record = self.records.first()?;
        let byte = record.text.get(self.column).copied().unwrap_or(b' ');
        self.column += 1;
        self.passed += 1;
        if self.column >= self.width {
            self.column = 0;
            let next = record.number.saturating_add(1);
            self.records = self.records.get(1..).unwrap_or_default();
            if self.records.first().is_some_and(|following| following.number > next) {
                self.records = &[];
                self.lost = Some(next);
            }
        }
        Some(byte)
    }

    /// The next value.
    pub(super) fn value(&mut self) -> (FreeValue, ValueEnd) {
        let mut token: Vec<u8> = Vec::new();
        loop {
            let Some(byte) = self.next_byte() else { return (number(&token), ValueEnd::Missing) };
            if let Some(end) = self.end(byte) {
                return (number(&token), end);
            }
            match byte {
                b' ' | b'\t' | b'\r' => {}
                b'H' | b'h' if !token.is_empty() && token.iter().all(u8::is_ascii_digit) => {
                    return self.text(&token);
                }
                _ if token.len() < MAX_NUMBER => token.push(byte),
                _ => {}
            }
        }
    }

    fn end(&self, byte: u8) -> Option<ValueEnd> {
        let [parameter, record] = self.delimiters;
        if byte == parameter {
            Some(ValueEnd::Parameter)
        } else if byte == record {
            Some(ValueEnd::Record)
        } else {
            None
        }
    }

    /// A text of a given number of characters, after its letter H.
    fn text(&mut self, count: &[u8]) -> (FreeValue, ValueEnd) {
        let count = std::str::from_utf8(count).ok().and_then(|digits| digits.parse::<usize>().ok());
        let mut text = Vec::new();
        for i in 0..count.unwrap_or(usize::MAX) {
            match self.next_byte() {
                Some(byte) if i < MAX_TEXT => text.push(byte),
                Some(_) => {}
                None => return (FreeValue::Invalid("the text is longer than its record"), ValueEnd::Missing),
            }
        }
        let mut value = FreeValue::Text(String::from_utf8_lossy(&text).trim().to_owned());
        loop {
            let Some(byte) = self.next_byte() else { return (value, ValueEnd::Missing) };
            if let Some(end) = self.end(byte) {
                return (value, end);
            }
            if byte != b' ' && byte != b'\r' {
                value = FreeValue::Invalid("the text is longer than its count of characters");
            }
        }
    }
}

/// A number in the notation of Fortran.
fn number(token: &[u8]) -> FreeValue {
    if token.is_empty() {
        return FreeValue::Missing;
    }
    let text: String =
        token.iter().map(|b| if matches!(b, b'D' | b'd' | b'e') { 'E' } else { char::from(*b) }).collect();
    let is_number = text.bytes().all(|b| b.is_ascii_digit() || b"+-.E".contains(&b));
    match text.parse::<f64>() {
        Ok(value) if is_number && value.is_finite() => FreeValue::Number(value),
        _ => FreeValue::Invalid("this is neither a number nor a text"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(lines: &[&str], width: usize) -> Vec<FreeValue> {
        let records: Vec<IgesRecord<'_>> = lines
            .iter()
            .enumerate()
            .map(|(i, line)| IgesRecord { text: line.as_bytes(), line: i as u32 + 1, number: i as u32 + 1 })
            .collect();
        let mut text = FreeText::new(&records, width, *b",;");
        let mut values = Vec::new();
        loop {
            let (value, end) = text.value();
            values.push(value);
            if end != ValueEnd::Parameter {
                return values;
            }
        }
    }

    #[test]
    fn numbers_texts_and_defaults_are_told_apart() {
        use FreeValue::{Invalid, Missing, Number, Text};
        let read = values(&["110, 1.D1,-.5,,3Ha,b , 2.5E-1;9"], 72);
        let expected =
            [Number(110.0), Number(10.0), Number(-0.5), Missing, Text("a,b".to_owned()), Number(0.25)];
        assert_eq!(read, expected);
        assert!(matches!(values(&["inf;"], 72)[..], [Invalid(_)]));
        assert!(matches!(values(&["9Habc"], 8)[..], [Invalid(_)]));
    }

    #[test]
    fn texts_and_blanks_continue_in_the_next_record() {
        let read = values(&["4HWI", "NG,1.", "5;"], 4);
        // The fifth column of a record is no text.
        assert_eq!(read, [FreeValue::Text("WING".to_owned()), FreeValue::Number(15.0)]);
    }
}
