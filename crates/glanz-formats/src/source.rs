//! The files of a scene, and messages about positions in them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glanz_job::{BudgetError, Resource, ResourceBudget};
use glanz_scene::Location;
use glanz_scene::description::FileId;
use glanz_scene::diagnostic::{Diagnostic, Diagnostics, Excerpt, Severity};

/// The files read, in order; the scene file is the first. Index is [`FileId`].
///
/// Bytes of files on disk are released after reading, but for the scene file of an inverse design; for the excerpt of a later message the file is read again.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
    paths: Vec<PathBuf>,
}

#[derive(Clone, Debug)]
struct SourceFile {
    name: String,
    path: Option<PathBuf>,
    bytes: Option<Arc<[u8]>>,
}

impl Sources {
    /// The names of the files for messages.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|f| f.name.clone()).collect()
    }

    /// The paths of all files on disk that were read: those with [names](Sources::names), meshes, pictures, spectra and so on.
    #[must_use]
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Whether the scene file on disk differs from the bytes that were read, or is gone. Known of scenes with an inverse design only, whose bytes are kept; of
    /// others `false`.
    #[must_use]
    pub fn scene_has_changed(&self) -> bool {
        match self.files.first() {
            Some(SourceFile { path: Some(path), bytes: Some(bytes), .. }) => {
                std::fs::read(path).map_or(true, |now| now[..] != bytes[..])
            }
            _ => false,
        }
    }

    /// Stores the paths of the files that were read.
    pub(crate) fn set_paths(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        self.paths = paths.into_iter().collect();
    }

    /// A message about a position in one of the files, with the line if it can still be read.
    ///
    /// It serves errors of a description that are found after reading. Without `location` the message is about the scene
    /// file as a whole.
    #[must_use]
    pub fn diagnostic(
        &self,
        severity: Severity,
        kind: &'static str,
        location: Option<Location>,
        message: String,
    ) -> Diagnostic {
        let source = self.files.get(location.map_or(0, |l| l.file.0 as usize));
        let bytes = source.and_then(SourceFile::bytes);
        let excerpt = location.zip(bytes).and_then(|(l, bytes)| {
            let line = bytes.split(|&b| b == b'\n').nth(l.line.checked_sub(1)? as usize)?;
            let offset = offset_of_column(line, l.column);
            Some(Excerpt::of_line(l.line, without_return(line), offset, word_length(line, offset)))
        });
        let file = source.map_or_else(String::new, |s| s.name.clone());
        Diagnostic { severity, kind, file, location, message, excerpt, help: None }
    }

    /// The message that resolving the scene has ended at a position in one of the files.
    #[must_use]
    pub fn end_of_resolving(&self, location: Option<Location>, end: BudgetError) -> Diagnostics {
        let place = self.diagnostic(Severity::Error, "scene", location, String::new());
        let diagnostic = Diagnostic { location, excerpt: place.excerpt, ..end_of_reading(place.file, end) };
        Diagnostics::of_end(diagnostic, end)
    }

    /// Makes the bytes of a file available under a new number or, for a known name, its old number.
    pub(crate) fn open(&mut self, name: &str, path: Option<&Path>, bytes: &Arc<[u8]>) -> FileId {
        let bytes = Some(Arc::clone(bytes));
        if let Some(i) = self.files.iter().position(|f| f.name == name) {
            self.files[i].bytes = bytes;
            return FileId(i as u32);
        }
        self.files.push(SourceFile { name: name.to_owned(), path: path.map(Path::to_owned), bytes });
        FileId((self.files.len() - 1) as u32)
    }

    /// Releases the bytes of a file that is also on disk.
    pub(crate) fn close(&mut self, file: FileId) {
        if let Some(source) = self.files.get_mut(file.0 as usize)
            && source.path.is_some()
        {
            source.bytes = None;
        }
    }

    fn excerpt(&self, place: &Span) -> Option<Excerpt> {
        let bytes = self.bytes(place.location.file)?;
        let offset = place.offset.min(bytes.len());
        let start = bytes.get(..offset)?.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let rest = bytes.get(start..)?;
        let line = rest.split(|&b| b == b'\n').next().unwrap_or_default();
        Some(Excerpt::of_line(place.location.line, without_return(line), offset - start, place.length))
    }

    /// The bytes of a file, if they can still be read.
    pub(crate) fn bytes(&self, file: FileId) -> Option<Arc<[u8]>> {
        self.files.get(file.0 as usize).and_then(SourceFile::bytes)
    }

    fn name(&self, file: FileId) -> String {
        self.files.get(file.0 as usize).map_or_else(String::new, |f| f.name.clone())
    }
}

impl SourceFile {
    fn bytes(&self) -> Option<Arc<[u8]>> {
        match (&self.bytes, &self.path) {
            (Some(bytes), _) => Some(Arc::clone(bytes)),
            (None, Some(path)) => std::fs::read(path).ok().map(Arc::from),
            (None, None) => None,
        }
    }
}

fn without_return(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Line and column, both from 1, of a byte; the column counts bytes.
pub(crate) fn line_and_column(bytes: &[u8], at: usize) -> (u32, u32) {
    let before = bytes.get(..at).unwrap_or(bytes);
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    let lines = before.iter().filter(|&&b| b == b'\n').count();
    let from_one = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).saturating_add(1);
    (from_one(lines), from_one(before.len() - line_start))
}

/// Byte offset of a column, which counts characters from 1.
fn offset_of_column(line: &[u8], column: u32) -> usize {
    let starts = line.iter().enumerate().filter(|(_, b)| **b & 0xC0 != 0x80);
    starts.map(|(i, _)| i).nth(column.saturating_sub(1) as usize).unwrap_or(line.len())
}

/// Bytes of the word or quoted text that starts at `offset`.
fn word_length(line: &[u8], offset: usize) -> usize {
    let rest = line.get(offset..).unwrap_or_default();
    match rest.first() {
        Some(b'"') => rest.iter().skip(1).position(|&b| b == b'"').map_or(1, |i| i + 2),
        _ => rest.iter().position(|b| b.is_ascii_whitespace() || b"[]\"#".contains(b)).unwrap_or(rest.len()),
    }
}

/// A range of bytes of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Start.
    pub(crate) location: Location,
    /// Start in bytes from the beginning of the file.
    pub(crate) offset: usize,
    /// Its bytes.
    pub(crate) length: usize,
}

/// Proof that an error has been reported; the receiver only has to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReportedError;

/// The result of a step whose failure is already among the diagnostics.
pub(crate) type ParseResult<T> = Result<T, ReportedError>;

/// Number of errors after which reading ends.
pub(crate) const MAX_ERRORS: usize = 20;

/// Collector of messages during reading.
#[derive(Debug, Default)]
pub(crate) struct Reporter {
    pub(crate) sources: Sources,
    pub(crate) diagnostics: Diagnostics,
    /// Whether a substitute is an error.
    pub(crate) strict: bool,
    /// Whether files are only listed; messages about those that are not available are left out.
    pub(crate) lists: bool,
    /// What reading may still use.
    pub(crate) budget: ResourceBudget,
}

/// Kind of the messages about files that are not available.
pub(crate) const MISSING_FILE: &str = "missing-file";

impl Reporter {
    /// Reports an error, which makes the scene unusable.
    pub(crate) fn error(
        &mut self,
        place: &Span,
        kind: &'static str,
        message: impl Into<String>,
    ) -> ReportedError {
        self.report(Severity::Error, place, kind, message.into(), None);
        ReportedError
    }

    /// As the method above, with a remedy.
    pub(crate) fn error_with_help(
        &mut self,
        place: &Span,
        kind: &'static str,
        message: impl Into<String>,
        help: Option<String>,
    ) -> ReportedError {
        self.report(Severity::Error, place, kind, message.into(), help);
        ReportedError
    }

    /// Reports a harmless irregularity.
    pub(crate) fn warning(&mut self, place: &Span, kind: &'static str, message: impl Into<String>) {
        self.report(Severity::Warning, place, kind, message.into(), None);
    }

    /// As the method above, with a remedy.
    pub(crate) fn warning_with_help(
        &mut self,
        place: &Span,
        kind: &'static str,
        message: impl Into<String>,
        help: Option<String>,
    ) {
        self.report(Severity::Warning, place, kind, message.into(), help);
    }

    /// Reports that something was replaced by a substitute or left out; an error in strict mode.
    pub(crate) fn stand_in(&mut self, place: &Span, kind: &'static str, message: impl Into<String>) {
        let severity = if self.strict { Severity::Error } else { Severity::Warning };
        self.report(severity, place, kind, message.into(), None);
    }

    /// Whether reading ends here: too many errors, or the budget is used up.
    pub(crate) fn is_full(&self) -> bool {
        self.diagnostics.end().is_some() || self.diagnostics.count(Severity::Error) >= MAX_ERRORS
    }

    /// Whether reading may go on; reports at `place` why not.
    pub(crate) fn check(&mut self, place: &Span) -> ParseResult<()> {
        self.budget.check().map_err(|end| self.end(place, end))
    }

    /// Spends from the budget; reports at `place` that it is used up.
    pub(crate) fn spend(&mut self, place: &Span, resource: Resource, amount: u64) -> ParseResult<()> {
        self.budget.spend(resource, amount).map_err(|end| self.end(place, end))
    }

    /// Replaces all messages by the one that reading has ended, with the place where it did.
    pub(crate) fn end(&mut self, place: &Span, end: BudgetError) -> ReportedError {
        if self.diagnostics.end().is_none() {
            let (file, excerpt) = (self.sources.name(place.location.file), self.sources.excerpt(place));
            let diagnostic =
                Diagnostic { location: Some(place.location), excerpt, ..end_of_reading(file, end) };
            self.diagnostics = Diagnostics::of_end(diagnostic, end);
        }
        ReportedError
    }

    fn report(
        &mut self,
        severity: Severity,
        place: &Span,
        kind: &'static str,
        message: String,
        help: Option<String>,
    ) {
        // Whatever a reader makes of a budget that is used up, that is the reason.
        if let Some(end) = self.budget.failure() {
            self.end(place, end);
            return;
        }
        if self.lists && kind == MISSING_FILE {
            return;
        }
        if self.diagnostics.admit(severity, kind) {
            let file = self.sources.name(place.location.file);
            let excerpt = self.sources.excerpt(place);
            let location = Some(place.location);
            self.diagnostics.push_admitted(Diagnostic {
                severity,
                kind,
                file,
                location,
                message,
                excerpt,
                help,
            });
        }
    }
}

/// The message that reading of a file has ended, without a place.
pub(crate) fn end_of_reading(file: String, end: BudgetError) -> Diagnostic {
    let (kind, message, help) = (end.kind(), end.to_string(), end.help());
    Diagnostic { severity: Severity::Error, kind, file, location: None, message, excerpt: None, help }
}

/// Text of a file for a message, truncated to a readable length.
pub(crate) fn shortened(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((i, _)) => format!("{}...", text.get(..i).unwrap_or_default()),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use glanz_job::LimitError;

    use super::*;

    #[test]
    fn interruption_is_no_limit() {
        let sources = Sources::default();
        let limit = LimitError { resource: Resource::Objects, limit: 1, needed: None };
        for (end, kind, help) in [
            (BudgetError::Interrupted, "interrupted", None),
            (BudgetError::Limit(limit), "limit", Some(limit.help())),
        ] {
            let ended = sources.end_of_resolving(None, end);
            assert_eq!(ended.end(), Some(end));
            let diagnostics: Vec<_> = ended.iter().map(|d| (d.kind, d.help.clone())).collect();
            assert_eq!(diagnostics, [(kind, help)]);
        }
    }

    #[test]
    fn a_later_message_shows_the_word_at_its_location() {
        let mut sources = Sources::default();
        let bytes: Arc<[u8]> = Arc::from(&b"first\r\n\xc3\xa4 Shape \"sphere\" x\r\n"[..]);
        let file = sources.open("a.pbrt", None, &bytes);
        sources.close(file);
        let location = Location { file, line: 2, column: 9 };
        let d = sources.diagnostic(Severity::Error, "k", Some(location), "bad".to_owned());
        assert_eq!(
            d.to_string(),
            "error: a.pbrt:2:9: bad\n  2 | \u{e4} Shape \"sphere\" x\n    |         ^^^^^^^^\n"
        );
    }

    #[test]
    fn a_location_outside_the_file_is_reported_without_a_line() {
        let mut sources = Sources::default();
        let file = sources.open("a.pbrt", None, &Arc::from(&b"x"[..]));
        let location = Location { file, line: 7, column: 1 };
        let d = sources.diagnostic(Severity::Warning, "k", Some(location), "odd".to_owned());
        assert_eq!(d.to_string(), "warning: a.pbrt:7:1: odd\n");
        let nowhere = Location { file: FileId(9), line: 1, column: 1 };
        assert_eq!(
            sources.diagnostic(Severity::Error, "k", Some(nowhere), "odd".into()).to_string(),
            "error: :1:1: odd\n"
        );
    }
}
