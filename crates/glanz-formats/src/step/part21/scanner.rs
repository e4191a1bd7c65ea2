//! Tokens of the exchange structure.

use super::tape::TextSpan;

/// A reader of bytes that knows spaces, comments, numbers and strings.
pub(super) struct Scanner<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
    /// From here on there is no end of a comment.
    uncommented: usize,
}

/// A number of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ScannedNumber {
    Integer(i64),
    Real(f64),
}

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, uncommented: usize::MAX }
    }

    /// The next byte; 0 at the end.
    #[inline]
    pub(super) fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    pub(super) fn at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn since(&self, start: usize) -> &'a [u8] {
        self.bytes.get(start..self.at).unwrap_or_default()
    }

    /// Skips spaces, line ends, explicit print controls between tokens and comments.
    #[inline]
    pub(super) fn skip_space(&mut self) -> Result<(), &'static str> {
        loop {
            match self.peek() {
                b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c => self.at += 1,
                b'/' if self.bytes.get(self.at + 1) == Some(&b'*') => self.skip_comment()?,
                b'\\'
                    if matches!(
                        self.bytes.get(self.at + 1..self.at + 3),
                        Some([b'N' | b'F' | b'T', b'\\'])
                    ) =>
                {
                    self.at += 3;
                }
                0 if !self.at_end() => self.at += 1,
                _ => return Ok(()),
            }
        }
    }

    fn skip_comment(&mut self) -> Result<(), &'static str> {
        let body = self.at + 2;
        // Of many comments without an end, only the first is searched.
        let found = (body < self.uncommented)
            .then(|| self.bytes.get(body..).and_then(|rest| rest.windows(2).position(|pair| pair == b"*/")));
        match found.flatten() {
            Some(length) => {
                self.at = body + length + 2;
                Ok(())
            }
            None => {
                self.uncommented = self.uncommented.min(body);
                Err("the comment has no end")
            }
        }
    }

    /// Takes the next byte if it is `byte`.
    #[inline]
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let is_next = self.peek() == byte && !self.at_end();
        self.at += usize::from(is_next);
        is_next
    }

    /// Skips spaces and takes the byte that must follow; `expected` is the error.
    pub(super) fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), &'static str> {
        self.skip_space()?;
        if self.take(byte) { Ok(()) } else { Err(expected) }
    }

    /// Letters, digits, `_` and `-`, perhaps after `!`; empty if there are none.
    pub(super) fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        self.at += usize::from(self.peek() == b'!');
        while matches!(self.peek(), b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-') {
            self.at += 1;
        }
        self.since(start)
    }

    /// The digits of an instance number, behind its `#`.
    pub(super) fn instance_number(&mut self) -> Result<u64, &'static str> {
        let start = self.at;
        let mut number = 0_u64;
        while let digit @ b'0'..=b'9' = self.peek() {
            let next = number.checked_mul(10).and_then(|n| n.checked_add(u64::from(digit - b'0')));
            number = next.ok_or("the instance number is 2^64 or more")?;
            self.at += 1;
        }
        if self.at == start { Err("\"#\" needs a number") } else { Ok(number) }
    }

    /// An integer or a real number.
    pub(super) fn number(&mut self) -> Result<ScannedNumber, &'static str> {
        let start = self.at;
        let mut is_real = false;
        loop {
            match self.peek() {
                b'0'..=b'9' | b'+' | b'-' => {}
                b'.' | b'e' | b'E' => is_real = true,
                _ => break,
            }
            self.at += 1;
        }
        let text = std::str::from_utf8(self.since(start)).unwrap_or_default();
        if !is_real && let Ok(integer) = text.parse::<i64>() {
            return Ok(ScannedNumber::Integer(integer));
        }
        match text.parse::<f64>() {
            Ok(real) if real.is_finite() => Ok(ScannedNumber::Real(real)),
            Ok(_) => Err("the number is too large"),
            Err(_) => Err("the number cannot be read"),
        }
    }

    /// The inside of a string, from its opening quote; two quotes in it are one.
    pub(super) fn string(&mut self) -> Result<TextSpan, &'static str> {
        self.at += 1;
        let start = self.at;
        loop {
            let Some(length) = self.rest().iter().position(|&b| b == b'\'') else {
                self.at = self.bytes.len();
                return Err("the string has no end");
            };
            self.at += length + 1;
            if !self.take(b'\'') {
                return Ok(span(start, self.at - 1));
            }
        }
    }

    /// The inside of an enumeration, from its first dot.
    pub(super) fn enumeration(&mut self) -> Result<TextSpan, &'static str> {
        self.at += 1;
        let start = self.at;
        while matches!(self.peek(), b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'_') {
            self.at += 1;
        }
        if self.take(b'.') { Ok(span(start, self.at - 1)) } else { Err("the enumeration has no second dot") }
    }

    /// Skips a binary, from its opening quote.
    pub(super) fn binary(&mut self) -> Result<(), &'static str> {
        self.at += 1;
        while self.peek().is_ascii_hexdigit() {
            self.at += 1;
        }
        if self.take(b'"') { Ok(()) } else { Err("the binary has no second quote") }
    }

    /// The first position from `from` of an instance `#n=` or an `ENDSEC` behind a semicolon, or the end.
    ///
    /// Comments and spaces between are taken off `budget`; when it is used up, comments are no longer passed.
    pub(super) fn next_instance(&mut self, from: usize, budget: &mut usize) -> usize {
        let mut at = from;
        while let Some(length) = self.bytes.get(at..).and_then(|rest| rest.iter().position(|&b| b == b';')) {
            at += length + 1;
            let passes_comments = *budget > 0;
            let uncommented = if passes_comments { self.uncommented } else { 0 };
            let mut ahead = Scanner { bytes: self.bytes, at, uncommented };
            let space = ahead.skip_space();
            *budget = budget.saturating_sub(ahead.at - at);
            if passes_comments {
                self.uncommented = ahead.uncommented;
            }
            if space.is_err() {
                continue;
            }
            let rest = ahead.rest();
            if rest.starts_with(b"ENDSEC") || rest.starts_with(b"END-ISO") || self.is_instance(ahead.at) {
                return ahead.at;
            }
        }
        self.bytes.len()
    }

    /// A scanner at a position that passes no comments, so that its way is short.
    fn ahead(&self, at: usize) -> Self {
        Scanner { bytes: self.bytes, at, uncommented: 0 }
    }

    /// Whether an instance `#n=` begins at a position.
    pub(super) fn is_instance(&self, at: usize) -> bool {
        let mut ahead = self.ahead(at);
        let has_number = ahead.take(b'#') && ahead.instance_number().is_ok();
        has_number && ahead.skip_space().is_ok() && ahead.peek() == b'='
    }

    /// Whether the keyword of a data section begins at a position: `DATA;` or `DATA(`.
    pub(super) fn is_data(&self, at: usize) -> bool {
        let mut ahead = self.ahead(at);
        if !ahead.rest().starts_with(b"DATA") {
            return false;
        }
        let before = at.checked_sub(1).and_then(|before| self.bytes.get(before));
        ahead.at += 4;
        !before.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_')
            && ahead.skip_space().is_ok()
            && matches!(ahead.peek(), b';' | b'(')
    }
}

/// A span of a file whose length fits 32 bits.
pub(super) fn span(start: usize, end: usize) -> TextSpan {
    TextSpan { start: start as u32, length: (end - start) as u32 }
}
