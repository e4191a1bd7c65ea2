//! The syntax of STEP files: the exchange structure of @iso10303-21, editions 1 to 3.
//!
//! One pass over the bytes fills one tape of parameters and a list of instances; nothing is copied but numbers. Memory is at most 16 bytes
//! per token, and a token has at least two bytes. A damaged instance is reported, and reading continues with the next one.

mod alphabets;
mod entity;
mod keyword;
mod parser;
mod scanner;
mod tape;
#[cfg(test)]
mod tests;
mod text;

pub(super) use entity::{Entity, EntityAttributes};
pub(super) use keyword::Keyword;
pub(super) use parser::SyntaxFault;
pub(super) use tape::{EntityInstance, TapeItems, TapeToken, TextSpan};
pub(super) use text::decode;

use glanz_job::ResourceBudget;
use parser::StructureParser;

use super::error::StepError;
pub(super) use crate::cad::Refusal;

/// The instances of a file.
#[derive(Debug)]
pub(super) struct ExchangeFile<'a> {
    bytes: &'a [u8],
    tape: Vec<TapeToken>,
    /// By number.
    instances: Vec<EntityInstance>,
    index: InstanceIndex,
    /// The names of `FILE_SCHEMA`.
    pub(super) schemas: Vec<String>,
    /// Errors in the syntax, the first ones.
    pub(super) faults: Vec<SyntaxFault>,
    /// Number of all errors in the syntax.
    pub(super) fault_count: usize,
}

/// The way from a number to an instance.
#[derive(Debug)]
enum InstanceIndex {
    /// Numbers with few gaps: positions plus one by number, from the first number on; 0 in a gap.
    Dense { first: u64, positions: Vec<u32> },
    /// A search in the sorted list.
    Sparse,
}

impl InstanceIndex {
    fn new(instances: &[EntityInstance]) -> Self {
        let (Some(first), Some(last)) = (instances.first(), instances.last()) else { return Self::Sparse };
        let length = (last.number - first.number).saturating_add(1);
        // With fewer gaps than this a table is not larger than the list.
        if length > 6 * instances.len() as u64 {
            return Self::Sparse;
        }
        let mut positions = vec![0; length as usize];
        for (i, instance) in instances.iter().enumerate() {
            if let Some(position) = positions.get_mut((instance.number - first.number) as usize) {
                *position = i as u32 + 1;
            }
        }
        Self::Dense { first: first.number, positions }
    }

    fn find(&self, instances: &[EntityInstance], number: u64) -> Option<usize> {
        match self {
            Self::Dense { first, positions } => {
                let at = usize::try_from(number.checked_sub(*first)?).ok()?;
                (*positions.get(at)? as usize).checked_sub(1)
            }
            Self::Sparse => instances.binary_search_by_key(&number, |instance| instance.number).ok(),
        }
    }
}

impl<'a> ExchangeFile<'a> {
    /// Reads the syntax of a file.
    ///
    /// # Errors
    /// [`StepError::NotStep`] without the first line of a STEP file, [`StepError::NoData`] without a data section,
    /// [`StepError::TooLarge`] from 4 GiB on, [`StepError::Budget`].
    pub(super) fn parse(bytes: &'a [u8], budget: &'a ResourceBudget) -> Result<Self, StepError> {
        if u32::try_from(bytes.len()).is_err() {
            return Err(StepError::TooLarge(bytes.len()));
        }
        let start = behind_magic(bytes).ok_or(StepError::NotStep)?;
        let mut parser = StructureParser::new(bytes, budget);
        parser.sections(start);
        budget.check()?;
        if !parser.has_data {
            return Err(StepError::NoData);
        }
        let mut instances = std::mem::take(&mut parser.instances);
        if !instances.is_sorted_by_key(|instance| instance.number) {
            instances.sort_by_key(|instance| instance.number);
        }
        let mut doubles = Vec::new();
        instances.dedup_by(|second, first| {
            let is_double = second.number == first.number;
            if is_double {
                doubles.push(*second);
            }
            is_double
        });
        doubles.sort_by_key(|instance| instance.offset);
        for double in doubles {
            let reason = "another instance has this number; the first one counts";
            parser.fault(double.offset as usize, Some(double.number), reason.to_owned());
        }
        let index = InstanceIndex::new(&instances);
        let StructureParser { tape, faults, fault_count, header, .. } = parser;
        let mut file = Self { bytes, tape, instances, index, schemas: Vec::new(), faults, fault_count };
        file.schemas = file.header_schemas(&header);
        Ok(file)
    }

    /// The names in `FILE_SCHEMA(('...'))`.
    fn header_schemas(&self, header: &[(Keyword, u32)]) -> Vec<String> {
        let records = header.iter().filter(|(keyword, _)| *keyword == Keyword::FileSchema);
        let lists = records.flat_map(|(_, first)| self.items(*first)).flat_map(|list| self.items(list));
        let names = lists.filter_map(|at| match self.token(at) {
            TapeToken::Text(span) => Some(decode(self.text(span))),
            _ => None,
        });
        names.collect()
    }

    /// The token at a position of the tape.
    #[inline]
    pub(super) fn token(&self, at: u32) -> TapeToken {
        self.tape.get(at as usize).copied().unwrap_or(TapeToken::Missing)
    }

    /// The items of the list at a position; none if there is no list.
    #[inline]
    pub(super) fn items(&self, at: u32) -> TapeItems<'_> {
        let end = match self.token(at) {
            TapeToken::List { end } | TapeToken::Typed { end, .. } => end,
            _ => at,
        };
        TapeItems { tape: &self.tape, at: at + 1, end }
    }

    /// The bytes of a span.
    pub(super) fn text(&self, span: TextSpan) -> &'a [u8] {
        let start = span.start as usize;
        self.bytes.get(start..start + span.length as usize).unwrap_or_default()
    }

    /// The instance with a number.
    #[inline]
    pub(super) fn find(&self, number: u64) -> Option<Entity<'_>> {
        let instance = *self.instances.get(self.index.find(&self.instances, number)?)?;
        Some(Entity { file: self, instance })
    }

    /// All instances, by number.
    pub(super) fn entities(&self) -> impl Iterator<Item = Entity<'_>> {
        self.instances.iter().map(|instance| Entity { file: self, instance: *instance })
    }

    /// Number of bytes of the file.
    pub(super) fn size(&self) -> usize {
        self.bytes.len()
    }
}

/// The position behind `ISO-10303-21;`.
fn behind_magic(bytes: &[u8]) -> Option<usize> {
    let mut scanner = scanner::Scanner::new(bytes);
    scanner.at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    scanner.skip_space().ok()?;
    let is_magic = scanner.word() == b"ISO-10303-21";
    (is_magic && scanner.expect(b';', "").is_ok()).then_some(scanner.at)
}
