//! What was read of a file, mended, and left out.

use std::fmt;

use glanz_brep::model::{BrepModel, EntityId};

use super::refusal::Refusal;

/// A CAD file that was read.
#[derive(Clone, Debug, Default)]
pub struct BrepFile {
    /// Its shapes.
    pub model: BrepModel,
    /// What was read, mended and left out.
    pub report: ReadingReport,
}

/// What was read of a file, mended, and left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadingReport {
    /// Names of its schemas, such as `AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }`, or its version of IGES.
    pub schemas: Vec<String>,
    /// Faces by what became part of the model.
    pub faces: FaceCounts,
    /// Damaged instances, by line and column.
    pub faults: NoteList,
    /// What is not in the model.
    pub omissions: NoteList,
    /// What is in the model other than the file says.
    pub repairs: NoteList,
}

impl ReadingReport {
    /// Notes that an entity is not in the model.
    pub(crate) fn omit(&mut self, entity: EntityId, refusal: &Refusal) {
        self.omissions.push_with(|| {
            let cause =
                if refusal.entity == entity { String::new() } else { format!("{}: ", refusal.entity) };
            EntityNote { entity: Some(entity), position: None, reason: format!("{cause}{}", refusal.reason) }
        });
    }

    /// Notes that an entity was mended.
    pub(crate) fn mend(&mut self, entity: EntityId, refusal: &Refusal, remedy: &str) {
        let reason = || format!("{}: {}; {remedy}", refusal.entity, refusal.reason);
        self.repairs.push_with(|| EntityNote { entity: Some(entity), position: None, reason: reason() });
    }
}

/// Numbers of face entities of a file; `total` is the sum of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceCounts {
    /// Faces in the file.
    pub total: usize,
    /// Faces in the model.
    pub read: usize,
    /// Faces that cannot be read, each with its reason in [`ReadingReport::omissions`].
    pub refused: usize,
    /// Faces that the file hides.
    pub hidden: usize,
    /// Faces of no shape that the file shows.
    pub unreachable: usize,
}

/// Notes, of which the first are stored and all are counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NoteList {
    notes: Vec<EntityNote>,
    count: usize,
}

impl NoteList {
    /// Notes stored, at most.
    pub const CAPACITY: usize = 1000;

    /// The first notes, and the last one about the whole file.
    #[must_use]
    pub fn notes(&self) -> &[EntityNote] {
        &self.notes
    }

    /// Number of all notes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds the note that `note` makes, as long as there is room.
    pub(crate) fn push_with(&mut self, note: impl FnOnce() -> EntityNote) {
        self.count += 1;
        if self.notes.len() < Self::CAPACITY {
            self.notes.push(note());
        }
    }

    /// Adds a note about the whole file, which is stored however many notes there are.
    pub(crate) fn push_whole(&mut self, reason: &str) {
        self.count += 1;
        self.notes.truncate(Self::CAPACITY - 1);
        self.notes.push(EntityNote { entity: None, position: None, reason: reason.to_owned() });
    }

    /// Adds a note about an entity.
    pub(crate) fn push(&mut self, entity: EntityId, reason: impl Into<String>) {
        self.push_with(|| EntityNote { entity: Some(entity), position: None, reason: reason.into() });
    }

    /// Adds the notes of another list.
    pub(crate) fn append(&mut self, other: Self) {
        self.count += other.count;
        let room = Self::CAPACITY.saturating_sub(self.notes.len());
        self.notes.extend(other.notes.into_iter().take(room));
    }

    /// Counts notes that are not stored.
    pub(crate) fn add_uncounted(&mut self, count: usize) {
        self.count += count;
    }
}

/// A remark about an entity of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntityNote {
    /// Number of the entity.
    pub entity: Option<EntityId>,
    /// Line and column from 1, of errors in the syntax.
    pub position: Option<[u32; 2]>,
    /// The remark.
    pub reason: String,
}

impl fmt::Display for EntityNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some([line, column]) = self.position {
            write!(f, "{line}:{column}: ")?;
        }
        if let Some(entity) = self.entity {
            write!(f, "{entity}: ")?;
        }
        f.write_str(&self.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn note_about_the_whole_file_is_stored_behind_any_number_of_others() {
        for others in [0, 1, NoteList::CAPACITY, NoteList::CAPACITY + 5] {
            let mut list = NoteList::default();
            (0..others).for_each(|i| list.push(EntityId(i as u64), "mended"));
            list.push_whole("too many");
            assert_eq!(list.count(), others + 1);
            assert_eq!(list.notes().len(), (others + 1).min(NoteList::CAPACITY));
            assert_eq!(list.notes().last().unwrap().to_string(), "too many");
        }
    }
}
