//! The parameters of all instances, one after the other.

use super::keyword::Keyword;

/// A part of the file's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::step) struct TextSpan {
    /// Its first byte.
    pub(super) start: u32,
    /// Its number of bytes.
    pub(super) length: u32,
}

/// A parameter, or the head of a list, whose contents follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::step) enum TapeToken {
    /// `$`.
    Missing,
    /// `*`.
    Derived,
    /// An integer.
    Integer(i64),
    /// A real number, finite.
    Real(f64),
    /// `#5`.
    Reference(u64),
    /// `.T.`, without the dots.
    Enumeration(TextSpan),
    /// `'text'`, without the outer quotes.
    Text(TextSpan),
    /// `"1A"`, without the quotes.
    Binary,
    /// A list, or the parameters of an instance.
    List {
        /// Position on the tape behind it.
        end: u32,
    },
    /// A typed parameter, or one of the types of a complex instance, with its parameters.
    Typed {
        /// Its type.
        keyword: Keyword,
        /// Position on the tape behind it.
        end: u32,
    },
}

/// An instance of the data sections.
#[derive(Clone, Copy, Debug)]
pub(in crate::step) struct EntityInstance {
    /// Its number.
    pub(in crate::step) number: u64,
    /// Position of its `#` in the file.
    pub(super) offset: u32,
    /// Position of its list of parameters on the tape.
    pub(super) first: u32,
    /// Its type.
    pub(in crate::step) keyword: Keyword,
}

/// Positions of the items of a list.
#[derive(Clone, Debug)]
pub(in crate::step) struct TapeItems<'a> {
    pub(super) tape: &'a [TapeToken],
    pub(super) at: u32,
    pub(super) end: u32,
}

impl TapeItems<'_> {
    /// Number of items.
    pub(in crate::step) fn count_items(&self) -> usize {
        self.clone().count()
    }
}

impl Iterator for TapeItems<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.at >= self.end {
            return None;
        }
        let at = self.at;
        self.at = match self.tape.get(at as usize)? {
            TapeToken::List { end } | TapeToken::Typed { end, .. } => *end,
            _ => at + 1,
        };
        Some(at)
    }
}
