//! Directory entries and their parameters.

use std::cell::Cell;
use std::collections::HashMap;

use glanz_brep::model::EntityId;
use glanz_job::ResourceBudget;

use super::entity::IgesEntity;
use super::error::IgesError;
use super::global::GlobalSection;
use super::records::{IgesRecord, IgesSections};
use super::values::{FreeText, FreeValue, IgesValue, ValueEnd};
use crate::cad::{EntityNote, NoteList, ReadingReport};

/// Columns of a record with parameters; the others refer back to the directory.
const PARAMETER_COLUMNS: usize = 64;

/// An entry of the directory, with the place of its parameters.
#[derive(Clone, Debug)]
pub(super) struct DirectoryEntry {
    /// Its number in the file.
    pub(super) number: u32,
    pub(super) kind: u32,
    pub(super) form: i64,
    /// Whether it is blanked.
    pub(super) hidden: bool,
    /// How other entities use it: 0 for geometry that is shown.
    pub(super) usage: u8,
    pub(super) matrix: i64,
    pub(super) color: i64,
    pub(super) level: i64,
    pub(super) label: String,
    /// Its values, of which the first is the type again.
    values: [usize; 2],
}

/// A file as entries with values.
#[derive(Debug)]
pub(super) struct IgesFile {
    pub(super) global: GlobalSection,
    pub(super) entries: Vec<DirectoryEntry>,
    /// Entries by their numbers.
    numbers: HashMap<u32, usize>,
    values: Vec<IgesValue>,
    texts: Vec<String>,
    /// Whether an entity that was read refers to the entry.
    used: Vec<Cell<bool>>,
    /// Bytes of the file.
    pub(super) size: usize,
}

impl IgesFile {
    /// The entries of a file; what is damaged is in the report.
    ///
    /// # Errors
    /// Those of [`IgesSections::parse`], [`IgesError::Budget`].
    pub(super) fn parse(
        bytes: &[u8],
        report: &mut ReadingReport,
        budget: &ResourceBudget,
    ) -> Result<Self, IgesError> {
        let sections = IgesSections::parse(bytes, &mut report.faults)?;
        let global = GlobalSection::parse(&sections.global, report);
        let mut parser = ParameterParser::new(&sections, &global);
        let mut entries = Vec::with_capacity(sections.directory.len() / 2);
        let mut records = sections.directory.iter().peekable();
        while let Some(first) = records.next() {
            budget.check()?;
            // Entries have two records, from an odd number on; by their numbers a lost record costs one entry only.
            let is_second = |second: &&IgesRecord<'_>| {
                first.number % 2 == 1 && Some(second.number) == first.number.checked_add(1)
            };
            if let Some(second) = records.next_if(is_second) {
                entries.push(parser.entry([first, second], &mut report.faults));
            } else {
                let position = Some([first.line, 1]);
                let reason = "the other record of the directory entry is missing; it is left out".to_owned();
                report.faults.push_with(|| EntityNote { entity: None, position, reason });
            }
        }
        let mut numbers = HashMap::with_capacity(entries.len());
        for (i, entry) in entries.iter().enumerate() {
            numbers.entry(entry.number).or_insert(i);
        }
        let (values, texts) = (parser.values, parser.texts);
        let used = vec![Cell::new(false); entries.len()];
        Ok(Self { global, entries, numbers, values, texts, used, size: bytes.len() })
    }

    /// All entities, in the order of the file.
    pub(super) fn entities(&self) -> impl Iterator<Item = IgesEntity<'_>> {
        self.entries.iter().enumerate().map(|(index, entry)| IgesEntity { file: self, index, entry })
    }

    /// The entity with a number.
    pub(super) fn entity(&self, number: u32) -> Option<IgesEntity<'_>> {
        let index = *self.numbers.get(&number)?;
        Some(IgesEntity { file: self, index, entry: self.entries.get(index)? })
    }

    /// The values of an entry, the type first.
    pub(super) fn values(&self, entry: &DirectoryEntry) -> &[IgesValue] {
        let [first, end] = entry.values;
        self.values.get(first..end).unwrap_or_default()
    }

    pub(super) fn text(&self, index: u32) -> &str {
        self.texts.get(index as usize).map_or("", String::as_str)
    }

    /// Marks an entry as part of another.
    pub(super) fn mark(&self, index: usize) {
        if let Some(used) = self.used.get(index) {
            used.set(true);
        }
    }

    /// Makes an entry one that stands by itself again.
    pub(super) fn unmark(&self, index: usize) {
        if let Some(used) = self.used.get(index) {
            used.set(false);
        }
    }

    /// Whether the entry is part of another that was read.
    pub(super) fn is_used(&self, index: usize) -> bool {
        self.used.get(index).is_some_and(Cell::get)
    }
}

/// The reader of parameters.
struct ParameterParser<'a, 'b> {
    records: &'b [IgesRecord<'a>],
    /// Records by their numbers.
    numbers: HashMap<u32, usize>,
    delimiters: [u8; 2],
    /// What was read from a record on, so that it is read once.
    known: HashMap<usize, [usize; 2]>,
    values: Vec<IgesValue>,
    texts: Vec<String>,
    /// Characters that may still be read, and values that may still be shared: entries may claim the same records, and readers go
    /// through the values of each entry.
    characters_left: usize,
}

impl<'a, 'b> ParameterParser<'a, 'b> {
    fn new(sections: &'b IgesSections<'a>, global: &GlobalSection) -> Self {
        let records = sections.parameters.as_slice();
        let mut numbers = HashMap::with_capacity(records.len());
        for (i, record) in records.iter().enumerate() {
            numbers.entry(record.number).or_insert(i);
        }
        Self {
            records,
            numbers,
            delimiters: global.delimiters,
            known: HashMap::new(),
            values: Vec::new(),
            texts: Vec::new(),
            characters_left: 2 * PARAMETER_COLUMNS * records.len(),
        }
    }

    /// The entry of two records of the directory.
    fn entry(&mut self, [first, second]: [&IgesRecord<'a>; 2], faults: &mut NoteList) -> DirectoryEntry {
        let number = first.number;
        let mut field = |record: &IgesRecord<'a>, i: usize| {
            let text = record.text.get(8 * i..).unwrap_or_default();
            let text = text.get(..text.len().min(8)).unwrap_or_default().trim_ascii();
            if text.is_empty() {
                return 0;
            }
            let value = std::str::from_utf8(text).ok().and_then(|text| text.parse::<i64>().ok());
            value.unwrap_or_else(|| {
                faults.push_with(|| EntityNote {
                    entity: Some(EntityId(number.into())),
                    position: Some([record.line, 8 * i as u32 + 1]),
                    reason: "the field is no integer; 0 is taken".to_owned(),
                });
                0
            })
        };
        let [kind, pointer, level, matrix] = [0, 1, 4, 6].map(|i| field(first, i));
        let [color, count, form] = [2, 3, 4].map(|i| field(second, i));
        let digit =
            |i: usize| first.text.get(64 + i).copied().filter(u8::is_ascii_digit).unwrap_or(b'0') - b'0';
        let label = second.text.get(56..64).unwrap_or_default();
        let mut entry = DirectoryEntry {
            number,
            kind: u32::try_from(kind).unwrap_or_default(),
            form,
            hidden: 10 * digit(0) + digit(1) == 1,
            usage: 10 * digit(4) + digit(5),
            matrix,
            color,
            level,
            label: String::from_utf8_lossy(label).trim().to_owned(),
            values: [0, 0],
        };
        // Type 0 is the null entity, which deleted ones leave.
        if entry.kind != 0 {
            let at = u32::try_from(pointer).ok().and_then(|pointer| self.numbers.get(&pointer)).copied();
            match at {
                Some(at) => {
                    entry.values = self.parameters(at, usize::try_from(count).unwrap_or(1), &entry, faults)
                }
                None => faults.push_with(|| EntityNote {
                    entity: Some(EntityId(number.into())),
                    position: Some([first.line, 9]),
                    reason: format!("its parameters are in record {pointer}, which is missing"),
                }),
            }
        }
        entry
    }

    /// The range of the values in the records from `at` on.
    fn parameters(
        &mut self,
        at: usize,
        count: usize,
        entry: &DirectoryEntry,
        faults: &mut NoteList,
    ) -> [usize; 2] {
        let mut fault = |position, reason: String| {
            let entity = Some(EntityId(entry.number.into()));
            faults.push_with(|| EntityNote { entity, position, reason });
        };
        let [first, end] = match self.known.get(&at).copied() {
            Some([first, end]) if end - first > self.characters_left => {
                let position = self.records.get(at).map(|record| [record.line, 1]);
                fault(position, "many entries share these parameters; they are left out".to_owned());
                return [0, 0];
            }
            Some([first, end]) => {
                self.characters_left -= end - first;
                [first, end]
            }
            None => self.new_parameters(at, count, &mut fault),
        };
        self.known.insert(at, [first, end]);
        let own = IgesValue::Number(entry.kind.into());
        if self.values.get(first..end).and_then(<[IgesValue]>::first) != Some(&own) {
            let position = self.records.get(at).map(|record| [record.line, 1]);
            fault(position, format!("the parameters are not those of an entity of type {}", entry.kind));
            return [0, 0];
        }
        [first, end]
    }

    /// The range of the values in records that were not read before; faults have a line and a column.
    fn new_parameters(
        &mut self,
        at: usize,
        count: usize,
        mut fault: impl FnMut(Option<[u32; 2]>, String),
    ) -> [usize; 2] {
        let records = self.records.get(at..).unwrap_or_default();
        let wanted = count.clamp(1, records.len().max(1));
        // Beyond, each of many entries would read all records.
        let allowed = wanted.min(self.characters_left / PARAMETER_COLUMNS);
        let records = records.get(..allowed).unwrap_or_default();
        let mut text = FreeText::new(records, PARAMETER_COLUMNS, self.delimiters);
        let first = self.values.len();
        if allowed < wanted {
            let position = self.records.get(at).map(|record| [record.line, 1]);
            fault(position, "many entries share these parameters; they are cut off".to_owned());
        }
        // Records of which there are fewer than the directory tells.
        let is_short = wanted < count && allowed == wanted;
        let behind = records.last().filter(|_| is_short).map(|last| last.number.saturating_add(1));
        loop {
            let position = text.position();
            let (value, end) = text.value();
            if let (ValueEnd::Missing, Some(lost)) = (end, text.lost.or(behind)) {
                fault(
                    position,
                    format!("record {lost} of the parameters is missing; they end in front of it"),
                );
                self.values.push(IgesValue::Invalid);
                break;
            }
            let value = match value {
                // Behind the last value there may be blanks only.
                FreeValue::Missing if end == ValueEnd::Missing => break,
                FreeValue::Missing => IgesValue::Missing,
                FreeValue::Number(value) => IgesValue::Number(value),
                FreeValue::Text(text) => {
                    self.texts.push(text);
                    IgesValue::Text(self.texts.len() as u32 - 1)
                }
                FreeValue::Invalid(reason) => {
                    fault(position, reason.to_owned());
                    IgesValue::Invalid
                }
            };
            self.values.push(value);
            match end {
                ValueEnd::Parameter => {}
                ValueEnd::Record => break,
                ValueEnd::Missing => {
                    fault(position, "the parameters have no end".to_owned());
                    break;
                }
            }
        }
        self.characters_left = self.characters_left.saturating_sub(text.passed);
        [first, self.values.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_twice_at_most() {
        // Every entry claims all records from its own on, each of which begins a text that never ends.
        let count = 1000;
        let mut text = format!("{:<72}S0000001\n{:<72}G0000001\n", "", ",,;");
        for i in 1..=count {
            text += &format!("{:8}{i:8}{:56}D{:07}\n", 116, "", 2 * i - 1);
            text += &format!("{:8}{:16}{count:8}{:40}D{:07}\n", 116, "", "", 2 * i);
        }
        for i in 1..=count {
            text += &format!("{:<64}{:8}P{i:07}\n", "99999999H", 2 * i - 1);
        }
        let mut report = ReadingReport::default();
        let file = IgesFile::parse(text.as_bytes(), &mut report, &ResourceBudget::default()).unwrap();
        assert_eq!((file.entries.len(), file.values.len()), (count, 3));
    }

    #[test]
    fn entries_that_share_parameters_have_no_more_values_than_characters() {
        // Each is an assembly of the same 1000 items, of which every reader would go through all.
        let (entries, items) = (1000, 1000);
        let mut text = format!("{:<72}S0000001\n{:<72}G0000001\n", "", ",,;");
        let parameters = format!("184,{items},{}0;", "1,".repeat(items));
        let records: Vec<&[u8]> = parameters.as_bytes().chunks(PARAMETER_COLUMNS).collect();
        for i in 1..=entries {
            text += &format!("{:8}{:8}{:56}D{:07}\n", 184, 1, "", 2 * i - 1);
            text += &format!("{:8}{:16}{:8}{:40}D{:07}\n", 184, "", records.len(), "", 2 * i);
        }
        for (record, i) in records.iter().zip(1..) {
            text += &format!("{:<64}{:8}P{i:07}\n", str::from_utf8(record).unwrap(), 1);
        }
        let mut report = ReadingReport::default();
        let file = IgesFile::parse(text.as_bytes(), &mut report, &ResourceBudget::default()).unwrap();
        let values: usize = file.entries.iter().map(|entry| file.values(entry).len()).sum();
        let characters = PARAMETER_COLUMNS * records.len();
        assert!((2 * items..=2 * characters).contains(&values), "{values} values, {characters} characters");
        assert!(report.faults.notes()[0].reason.contains("many entries share these parameters"));
    }
}
