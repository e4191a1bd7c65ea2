//! Sections and instances.

use std::collections::HashMap;

use glanz_job::ResourceBudget;

use super::keyword::{KEYWORDS, Keyword};
use super::scanner::{ScannedNumber, Scanner};
use super::tape::{EntityInstance, TapeToken};

/// Lists inside one another, at most.
const MAX_NESTING: usize = 64;

/// Types of a complex instance, at most.
const MAX_TYPES: usize = 64;

/// Faults stored with their positions, at most; further ones are counted.
const MAX_FAULTS: usize = 1000;

/// An error in the syntax of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::step) struct SyntaxFault {
    /// Line, from 1.
    pub(in crate::step) line: u32,
    /// Column in bytes, from 1.
    pub(in crate::step) column: u32,
    /// Number of the damaged instance.
    pub(in crate::step) instance: Option<u64>,
    /// What is wrong.
    pub(in crate::step) reason: String,
}

/// Line and column of offsets; fast if each is near the one before.
#[derive(Default)]
struct LineCounter {
    offset: usize,
    line: u32,
    line_start: usize,
}

impl LineCounter {
    fn position(&mut self, bytes: &[u8], offset: usize) -> (u32, u32) {
        let [from, to] = [self.offset.min(offset), self.offset.max(offset)];
        let between = bytes.get(from..to).unwrap_or_default();
        let ends = between.iter().filter(|&&b| b == b'\n').count() as u32;
        if offset >= self.offset {
            self.line += ends;
            if let Some(last) = between.iter().rposition(|&b| b == b'\n') {
                self.line_start = from + last + 1;
            }
        } else if ends > 0 {
            self.line -= ends;
            let before = bytes.get(..offset).unwrap_or_default();
            self.line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |last| last + 1);
        }
        self.offset = offset;
        (self.line + 1, (offset - self.line_start) as u32 + 1)
    }
}

/// Nothing, or the number of the damaged instance with what is wrong.
type EntityResult = Result<(), (Option<u64>, &'static str)>;

pub(super) struct StructureParser<'a> {
    scanner: Scanner<'a>,
    budget: &'a ResourceBudget,
    keywords: HashMap<&'static [u8], Keyword>,
    pub(super) tape: Vec<TapeToken>,
    pub(super) instances: Vec<EntityInstance>,
    pub(super) header: Vec<(Keyword, u32)>,
    pub(super) faults: Vec<SyntaxFault>,
    pub(super) fault_count: usize,
    pub(super) has_data: bool,
    lines: LineCounter,
    /// Bytes that may still be read a second time to find instances behind a damaged one.
    rescans: usize,
}

/// Message of an instance at the end of a file.
const TRUNCATED: &str = "the file ends inside of this instance";

impl<'a> StructureParser<'a> {
    pub(super) fn new(bytes: &'a [u8], budget: &'a ResourceBudget) -> Self {
        Self {
            scanner: Scanner::new(bytes),
            budget,
            keywords: KEYWORDS.iter().map(|(name, keyword)| (name.as_bytes(), *keyword)).collect(),
            tape: Vec::new(),
            instances: Vec::new(),
            header: Vec::new(),
            faults: Vec::new(),
            fault_count: 0,
            has_data: false,
            lines: LineCounter::default(),
            rescans: bytes.len().saturating_mul(4),
        }
    }

    /// Adds a fault at a position of the file.
    pub(super) fn fault(&mut self, offset: usize, instance: Option<u64>, reason: String) {
        self.fault_count += 1;
        if self.faults.len() < MAX_FAULTS {
            let (line, column) = self.lines.position(self.scanner.bytes, offset);
            self.faults.push(SyntaxFault { line, column, instance, reason });
        }
    }

    /// Reads all sections behind the first line.
    pub(super) fn sections(&mut self, start: usize) {
        self.scanner.at = start;
        loop {
            if let Err(reason) = self.scanner.skip_space() {
                self.fault(self.scanner.at, None, reason.to_owned());
                return;
            }
            let start = self.scanner.at;
            match self.scanner.word() {
                b"HEADER" => self.section(true),
                b"DATA" => {
                    self.has_data = true;
                    self.section(false);
                }
                b"ANCHOR" | b"REFERENCE" | b"SIGNATURE" => self.skip_section(),
                b"END-ISO-10303-21" => return,
                b"" if self.scanner.at_end() => {
                    self.fault(
                        start,
                        None,
                        "the file ends without END-ISO-10303-21; it is incomplete".to_owned(),
                    );
                    return;
                }
                _ => {
                    self.fault(start, None, "a section must begin here, such as DATA;".to_owned());
                    self.scanner.at = start + 1;
                    self.skip_section();
                }
            }
        }
    }

    /// Moves behind the next `ENDSEC;`, or to `DATA`, `END-ISO-10303-21` or the end of the file.
    fn skip_section(&mut self) {
        let bytes = self.scanner.bytes;
        let begins = |at: usize, word| bytes.get(at..).is_some_and(|rest| rest.starts_with(word));
        let is_end =
            |at: &usize| begins(*at, b"ENDSEC") || begins(*at, b"END-IS") || self.scanner.is_data(*at);
        self.scanner.at = (self.scanner.at..bytes.len()).find(is_end).unwrap_or(bytes.len());
        if begins(self.scanner.at, b"ENDSEC") {
            self.scanner.at += 6;
            let _ = self.scanner.expect(b';', "");
        }
    }

    /// Reads the header or a data section from behind its keyword to its ENDSEC, or to the next section where that is missing.
    fn section(&mut self, mut is_header: bool) {
        // Edition 3 names data sections in parentheses.
        self.scanner.at = self.scanner.bytes.get(self.scanner.at..).map_or(self.scanner.at, |rest| {
            self.scanner.at + rest.iter().position(|&b| b == b';' || b == b'#').unwrap_or(rest.len())
        });
        self.scanner.take(b';');
        loop {
            if self.budget.check().is_err() {
                self.scanner.at = self.scanner.bytes.len();
                return;
            }
            let space = self.scanner.skip_space();
            let start = self.scanner.at;
            let (tape, instances) = (self.tape.len(), self.instances.len());
            if space.is_ok() {
                if self.scanner.at_end() {
                    return;
                }
                if self.scanner.is_data(start) {
                    self.fault(start, None, "ENDSEC is missing before DATA".to_owned());
                    return;
                }
                if is_header && self.scanner.is_instance(start) {
                    self.fault(start, None, "ENDSEC is missing before the first instance".to_owned());
                    (is_header, self.has_data) = (false, true);
                }
                match self.scanner.word() {
                    b"ENDSEC" => {
                        let _ = self.scanner.expect(b';', "");
                        return;
                    }
                    b"END-ISO-10303-21" => {
                        self.fault(start, None, "ENDSEC is missing before END-ISO-10303-21".to_owned());
                        self.scanner.at = start;
                        return;
                    }
                    _ => self.scanner.at = start,
                }
            }
            let entity = if is_header { Self::header_entity } else { Self::instance };
            let outcome = space.map_err(|reason| (None, reason)).and_then(|()| entity(self));
            if let Err((number, reason)) = outcome {
                self.tape.truncate(tape);
                self.instances.truncate(instances);
                self.recover(start, number, reason);
            }
        }
    }

    /// Reports a damaged instance and moves to the next one.
    fn recover(&mut self, start: usize, number: Option<u64>, reason: &'static str) {
        let failed = self.scanner.at;
        if failed > start && self.scanner.is_instance(failed) {
            // Only the end of the damaged instance is missing.
            self.fault(failed, number, reason.to_owned());
            return;
        }
        // A quote too many makes a string of the instances behind it, so the search begins with the damaged instance, as
        // long as that does not read the file many times.
        let consumed = failed - start;
        let from = if consumed <= self.rescans {
            self.rescans -= consumed;
            start
        } else {
            failed
        };
        self.scanner.at = self.scanner.next_instance(from, &mut self.rescans).max(start + 1);
        if failed >= self.scanner.bytes.len() && self.scanner.at_end() {
            self.fault(start, number, TRUNCATED.to_owned());
        } else {
            self.fault(failed, number, reason.to_owned());
        }
    }

    /// `FILE_NAME(...);`
    fn header_entity(&mut self) -> EntityResult {
        let mut read = || {
            let keyword = self.keyword()?;
            let first = self.position()?;
            self.scanner.expect(b'(', "\"(\" is missing")?;
            self.list(0)?;
            self.scanner.expect(b';', "\";\" is missing")?;
            self.header.push((keyword, first));
            Ok(())
        };
        read().map_err(|reason| (None, reason))
    }

    /// `#5=A(...);` or `#5=(A(...)B(...));`
    fn instance(&mut self) -> EntityResult {
        let offset = self.scanner.at as u32;
        if !self.scanner.take(b'#') {
            return Err((None, "an instance such as #1=PLANE(...); or ENDSEC; must begin here"));
        }
        let number = self.scanner.instance_number().map_err(|reason| (None, reason))?;
        self.body(number, offset).map_err(|reason| (Some(number), reason))
    }

    fn body(&mut self, number: u64, offset: u32) -> Result<(), &'static str> {
        self.scanner.expect(b'=', "\"=\" is missing")?;
        self.scanner.skip_space()?;
        let first = self.position()?;
        let keyword = if self.scanner.take(b'(') {
            self.complex()?;
            Keyword::Complex
        } else {
            let keyword = self.keyword()?;
            self.scanner.expect(b'(', "\"(\" is missing")?;
            self.list(0)?;
            keyword
        };
        self.scanner.expect(b';', "\";\" is missing")?;
        self.instances.push(EntityInstance { number, offset, first, keyword });
        Ok(())
    }

    /// The next position on the tape.
    fn position(&self) -> Result<u32, &'static str> {
        u32::try_from(self.tape.len()).map_err(|_| "the file has too many parameters")
    }

    fn keyword(&mut self) -> Result<Keyword, &'static str> {
        let word = self.scanner.word();
        if word.is_empty() {
            return Err("the name of a type is missing");
        }
        if let Some(keyword) = self.keywords.get(word) {
            return Ok(*keyword);
        }
        let upper = word.to_ascii_uppercase();
        Ok(self.keywords.get(upper.as_slice()).copied().unwrap_or(Keyword::Unknown))
    }

    /// The types of a complex instance, from behind its parenthesis.
    fn complex(&mut self) -> Result<(), &'static str> {
        let head = self.tape.len();
        self.tape.push(TapeToken::List { end: 0 });
        let mut types = 0;
        loop {
            self.scanner.skip_space()?;
            if self.scanner.take(b')') {
                break;
            }
            // Every look at a type of the instance goes through all of them.
            types += 1;
            if types > MAX_TYPES {
                return Err("the instance has more than 64 types");
            }
            let keyword = self.keyword()?;
            self.scanner.expect(b'(', "\"(\" is missing")?;
            self.typed(keyword, 0)?;
        }
        let end = self.position()?;
        self.set(head, TapeToken::List { end });
        Ok(())
    }

    fn set(&mut self, at: usize, token: TapeToken) {
        if let Some(slot) = self.tape.get_mut(at) {
            *slot = token;
        }
    }

    /// Parameters of a type, from behind their parenthesis.
    fn typed(&mut self, keyword: Keyword, depth: usize) -> Result<(), &'static str> {
        let head = self.tape.len();
        self.list(depth)?;
        let end = self.position()?;
        self.set(head, TapeToken::Typed { keyword, end });
        Ok(())
    }

    /// A list, from behind its parenthesis.
    fn list(&mut self, depth: usize) -> Result<(), &'static str> {
        if depth >= MAX_NESTING {
            return Err("lists are nested deeper than 64 levels");
        }
        let head = self.tape.len();
        self.tape.push(TapeToken::List { end: 0 });
        self.scanner.skip_space()?;
        if !self.scanner.take(b')') {
            loop {
                self.parameter(depth)?;
                self.scanner.skip_space()?;
                if self.scanner.take(b')') {
                    break;
                }
                if !self.scanner.take(b',') {
                    return Err("\",\" or \")\" is missing");
                }
                self.scanner.skip_space()?;
            }
        }
        let end = self.position()?;
        self.set(head, TapeToken::List { end });
        Ok(())
    }

    fn parameter(&mut self, depth: usize) -> Result<(), &'static str> {
        let scanner = &mut self.scanner;
        let token = match scanner.peek() {
            b'#' => {
                scanner.at += 1;
                TapeToken::Reference(scanner.instance_number()?)
            }
            b'0'..=b'9' | b'+' | b'-' => Self::number(scanner)?,
            b'.' if scanner.bytes.get(scanner.at + 1).is_some_and(u8::is_ascii_digit) => {
                Self::number(scanner)?
            }
            b'.' => TapeToken::Enumeration(scanner.enumeration()?),
            b'\'' => TapeToken::Text(scanner.string()?),
            b'"' => {
                scanner.binary()?;
                TapeToken::Binary
            }
            b'(' => {
                scanner.at += 1;
                return self.list(depth + 1);
            }
            b'$' => {
                scanner.at += 1;
                TapeToken::Missing
            }
            b'*' => {
                scanner.at += 1;
                TapeToken::Derived
            }
            b'A'..=b'Z' | b'a'..=b'z' | b'!' => {
                let keyword = self.keyword()?;
                self.scanner.expect(b'(', "\"(\" is missing")?;
                return self.typed(keyword, depth + 1);
            }
            _ => return Err("a parameter must begin here"),
        };
        self.tape.push(token);
        Ok(())
    }

    fn number(scanner: &mut Scanner<'_>) -> Result<TapeToken, &'static str> {
        Ok(match scanner.number()? {
            ScannedNumber::Integer(integer) => TapeToken::Integer(integer),
            ScannedNumber::Real(real) => TapeToken::Real(real),
        })
    }
}
