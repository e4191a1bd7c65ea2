//! What was read of a file, mended, and left out.

use std::fmt;

use glanz_brep::model::{BrepModel, EntityId};

/// A STEP file that was read.
#[derive(Clone, Debug, Default)]
pub struct StepFile {
    /// Its shapes.
    pub model: BrepModel,
    /// What was read, mended and left out.
    pub report: StepReport,
}

/// Errors of reading a STEP file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The first line of a STEP file is missing.
    #[error("the file does not begin with ISO-10303-21; it is no STEP file")]
    NotStep,
    /// There is no data section.
    #[error("the file has no section DATA; it may be incomplete")]
    NoData,
    /// The file is too large.
    #[error("the file has {0} bytes; fewer than 2^32 can be read")]
    TooLarge(usize),
}

/// What was read of a file, mended, and left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepReport {
    /// Names of its schemas, such as `AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }`.
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

/// Numbers of face entities of a file; `total` is the sum of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceCounts {
    /// Faces in the file.
    pub total: usize,
    /// Faces in the model.
    pub read: usize,
    /// Faces that cannot be read, each with its reason in [`StepReport::omissions`].
    pub refused: usize,
    /// Faces that the file hides.
    pub hidden: usize,
    /// Faces of no shape that the file shows.
    pub unreachable: usize,
}

/// Notes, of which the first are stored and all are counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NoteList {
    notes: Vec<StepNote>,
    count: usize,
}

impl NoteList {
    /// Notes stored, at most.
    pub const CAPACITY: usize = 1000;

    /// The first notes.
    #[must_use]
    pub fn notes(&self) -> &[StepNote] {
        &self.notes
    }

    /// Number of all notes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds the note that `note` makes, as long as there is room.
    pub(super) fn push_with(&mut self, note: impl FnOnce() -> StepNote) {
        self.count += 1;
        if self.notes.len() < Self::CAPACITY {
            self.notes.push(note());
        }
    }

    /// Adds a note about an entity.
    pub(super) fn push(&mut self, entity: EntityId, reason: impl Into<String>) {
        self.push_with(|| StepNote { entity: Some(entity), position: None, reason: reason.into() });
    }

    /// Adds the notes of another list.
    pub(super) fn append(&mut self, other: Self) {
        self.count += other.count;
        let room = Self::CAPACITY.saturating_sub(self.notes.len());
        self.notes.extend(other.notes.into_iter().take(room));
    }

    /// Counts notes that are not stored.
    pub(super) fn add_uncounted(&mut self, count: usize) {
        self.count += count;
    }
}

/// A remark about an entity of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepNote {
    /// Number of the entity.
    pub entity: Option<EntityId>,
    /// Line and column from 1, of errors in the syntax.
    pub position: Option<[u32; 2]>,
    /// The remark.
    pub reason: String,
}

impl fmt::Display for StepNote {
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
