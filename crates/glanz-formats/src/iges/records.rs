//! Records of 80 characters, by section.

use crate::cad::{EntityNote, NoteList};

use super::error::IgesError;

/// Columns in front of the letter of the section.
const COLUMNS: usize = 72;

/// A record without its section and number.
#[derive(Clone, Copy, Debug)]
pub(super) struct IgesRecord<'a> {
    /// At most 72 characters.
    pub(super) text: &'a [u8],
    /// From 1.
    pub(super) line: u32,
    /// Its number in its section.
    pub(super) number: u32,
}

/// The sections of a file that are read.
#[derive(Debug, Default)]
pub(super) struct IgesSections<'a> {
    pub(super) global: Vec<IgesRecord<'a>>,
    pub(super) directory: Vec<IgesRecord<'a>>,
    pub(super) parameters: Vec<IgesRecord<'a>>,
}

/// The letter and the number of a record; `None` if it has neither.
fn section(record: &[u8]) -> Option<(u8, Option<u32>)> {
    let letter = *record.get(COLUMNS)?;
    let number = record.get(COLUMNS + 1..)?.trim_ascii();
    let number = number.get(..number.len().min(7))?;
    let number = std::str::from_utf8(number).ok()?.parse().ok();
    letter.is_ascii_uppercase().then_some((letter, number))
}

/// Whether a file begins with a record of IGES.
pub(crate) fn is_iges(bytes: &[u8]) -> bool {
    let head = bytes.get(..bytes.len().min(160)).unwrap_or_default();
    let line = head.split(|b| *b == b'\n').next().unwrap_or_default();
    let line = line.get(..line.len().min(80)).unwrap_or_default();
    matches!(section(line), Some((b'S' | b'G' | b'C', Some(_))))
}

impl<'a> IgesSections<'a> {
    /// The sections of a file; lines that are no records are faults.
    ///
    /// # Errors
    /// [`IgesError::NotIges`], [`IgesError::Compressed`], [`IgesError::NoDirectory`], [`IgesError::TooLarge`].
    pub(super) fn parse(bytes: &'a [u8], faults: &mut NoteList) -> Result<Self, IgesError> {
        if u32::try_from(bytes.len()).is_err() {
            return Err(IgesError::TooLarge(bytes.len()));
        }
        if !is_iges(bytes) {
            return Err(IgesError::NotIges);
        }
        let mut sections = Self::default();
        if bytes.get(COLUMNS) == Some(&b'C') {
            return Err(IgesError::Compressed);
        }
        // Some files have no ends of lines.
        let has_lines = bytes.get(..bytes.len().min(160)).unwrap_or_default().contains(&b'\n');
        if has_lines {
            for (i, line) in bytes.split(|b| *b == b'\n').enumerate() {
                sections.add(line, i as u32 + 1, faults);
            }
        } else {
            for (i, line) in bytes.chunks(80).enumerate() {
                sections.add(line, i as u32 + 1, faults);
            }
        }
        if sections.directory.is_empty() { Err(IgesError::NoDirectory) } else { Ok(sections) }
    }

    fn add(&mut self, record: &'a [u8], line: u32, faults: &mut NoteList) {
        let mut fault = |column: usize, reason: &str| {
            faults.push_with(|| EntityNote {
                entity: None,
                position: Some([line, column as u32 + 1]),
                reason: reason.to_owned(),
            });
        };
        if record.trim_ascii().is_empty() {
            return;
        }
        let list = match section(record) {
            Some((b'G', _)) => &mut self.global,
            Some((b'D', _)) => &mut self.directory,
            Some((b'P', _)) => &mut self.parameters,
            Some((b'S' | b'T', _)) => return,
            Some(_) => return fault(COLUMNS, "the section of the record is unknown; it is left out"),
            None => return fault(record.len(), "the record has no section in column 73; it is left out"),
        };
        let number = match section(record) {
            Some((_, Some(number))) => number,
            _ => {
                fault(COLUMNS + 1, "the record has no number; it is taken to be the next one");
                list.last().map_or(0, |last| last.number).saturating_add(1)
            }
        };
        list.push(IgesRecord { text: record.get(..COLUMNS).unwrap_or_default(), line, number });
    }
}
