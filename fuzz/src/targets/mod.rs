//! The table of everything that takes files: readers, and the jobs behind them.

mod model;
mod model_seeds;
mod photometry;
mod picture;
mod scene;
mod self_test;
mod stored;

use std::cell::RefCell;
use std::io;
use std::path::Path;

use glanz::formats::{Diagnostics, Loaded, Options, Severity, load};
use tempfile::TempDir;

use crate::limits;
use crate::mutation::Syntax;

/// A reader, or a job that begins with one.
#[derive(Debug)]
pub struct Target {
    /// Name on the command line and of its folder in the corpus.
    pub name: &'static str,
    /// What changes of its files know of the format.
    pub syntax: Syntax,
    /// Right files, from which mutants are made.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads a file; panics if it breaks a promise of the reader.
    pub run: fn(&[u8]) -> ReadOutcome,
    /// Bytes of memory that the peak may have per byte of the file, above [`crate::limits::MEMORY`].
    pub memory_factor: usize,
    /// Divisor of the number of cases: of a job that takes that much longer than a reader.
    pub divisor: u64,
}

/// The result of reading a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReadOutcome {
    /// It was read, with what was noticed.
    Read(String),
    /// It was refused, with the reason.
    Refused(String),
}

impl ReadOutcome {
    /// Whether the file was read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        matches!(self, Self::Read(_))
    }

    /// Number of the class: outcomes whose texts differ in numbers and names only have the same.
    #[must_use]
    pub fn class(&self) -> u64 {
        let (Self::Read(text) | Self::Refused(text)) = self;
        let mut is_quoted = false;
        let words = text.chars().filter(|c| {
            is_quoted ^= *c == '"';
            !is_quoted && c.is_alphabetic()
        });
        words.take(500).fold(u64::from(self.is_read()), |hash, c| {
            glanz::sampling::hash::combine(hash, u64::from(u32::from(c)))
        })
    }
}

impl<T, E: std::fmt::Display> From<Result<T, E>> for ReadOutcome {
    fn from(result: Result<T, E>) -> Self {
        match result {
            Ok(_) => Self::Read(String::new()),
            Err(error) => {
                let reason = error.to_string();
                assert!(!reason.is_empty(), "a file is refused without a reason");
                Self::Refused(reason)
            }
        }
    }
}

/// All targets but those that fail on purpose.
pub fn targets() -> impl Iterator<Item = &'static Target> {
    [scene::TARGETS, model::TARGETS, photometry::TARGETS, picture::TARGETS, stored::TARGETS]
        .into_iter()
        .flatten()
}

/// The target of this name, also of those that fail on purpose.
#[must_use]
pub fn target(name: &str) -> Option<&'static Target> {
    targets().chain(self_test::TARGETS).find(|target| target.name == name)
}

/// The variable that names the folder for the files of a process; its parent removes it.
pub(crate) const FOLDER_VARIABLE: &str = "GLANZ_FUZZ_FOLDER";

/// A folder for temporary files. In memory, if the system has such a folder: disks take ten times as long as reading.
///
/// # Errors
/// There is no space for temporary files.
pub fn memory_folder() -> io::Result<TempDir> {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir())
}

thread_local! {
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// Calls `work` with a folder of this thread for files of a case.
///
/// # Panics
/// There is no space for temporary files.
fn with_folder<T>(work: impl FnOnce(&Path) -> T) -> T {
    let path = FOLDER.with_borrow_mut(|folder| {
        let new = || std::env::var_os(FOLDER_VARIABLE).map_or_else(memory_folder, tempfile::tempdir_in);
        let folder = folder.get_or_insert_with(|| new().unwrap_or_else(|error| unusable(&error)));
        folder.path().to_owned()
    });
    work(&path)
}

/// Calls `work` with the path of a file of these bytes.
fn with_file<T>(name: &str, bytes: &[u8], work: impl FnOnce(&Path) -> T) -> T {
    with_folder(|folder| {
        let path = folder.join(name);
        if let Err(error) = std::fs::write(&path, bytes) {
            unusable(&error);
        }
        work(&path)
    })
}

#[expect(clippy::panic, reason = "a case that cannot be made says nothing about the reader")]
fn unusable(error: &io::Error) -> ! {
    panic!("temporary files cannot be written: {error}")
}

/// Reads bytes as they are and with right checksums; the outcome is the second.
fn of_both(bytes: &[u8], sealed: &[u8], read: fn(&[u8]) -> ReadOutcome) -> ReadOutcome {
    if sealed != bytes {
        read(bytes);
    }
    read(sealed)
}

/// Checks a scene against the length of its file.
fn loaded(result: Result<Loaded, Diagnostics>, length: usize) -> ReadOutcome {
    match result {
        Ok(loaded) => {
            // No number makes more than one entry, nothing makes an entry of no bytes, and a directive makes at most
            // a material and two textures.
            let size = scene::size(&loaded.description);
            assert!(size <= 3 * length + 1, "{size} entries of {length} bytes");
            assert!(!loaded.diagnostics.has_errors(), "a scene is read with errors");
            let text = loaded.diagnostics.to_string();
            assert!(text.len() <= 1_000 * (length + 1), "{} bytes of warnings", text.len());
            ReadOutcome::Read(gist(&loaded.diagnostics))
        }
        Err(errors) => {
            assert!(errors.has_errors(), "a scene is refused without an error");
            ReadOutcome::Refused(gist(&errors))
        }
    }
}

/// Reads a scene file and all files that it names; `length`: bytes of all of them.
#[must_use]
pub fn read_scene(file: &Path, length: usize) -> ReadOutcome {
    let options = Options { limits: limits::of_reading(), ..Options::default() };
    loaded(load(file, &options), length)
}

/// The first error, or the kinds of the first warnings.
fn gist(diagnostics: &Diagnostics) -> String {
    match diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error) {
        Some(error) => format!("{} {}", error.kind, error.message),
        None => {
            let mut kinds: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.kind).take(3).collect();
            kinds.dedup();
            kinds.join(" ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_reads_its_seeds() {
        for target in targets() {
            let seeds = (target.seeds)();
            assert!(!seeds.is_empty(), "{} has no seeds", target.name);
            for (i, seed) in seeds.iter().enumerate() {
                assert!(!seed.is_empty(), "{} {i}: an empty seed", target.name);
                let outcome = (target.run)(seed);
                assert!(outcome.is_read(), "{} {i}: {outcome:?}", target.name);
            }
        }
    }

    #[test]
    fn names_of_targets_are_unique() {
        let mut names: Vec<&str> = targets().chain(self_test::TARGETS).map(|target| target.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn classes_ignore_numbers_and_quoted_names() {
        let class = |text: &str| ReadOutcome::Refused(text.to_owned()).class();
        assert_eq!(class("line 3: \"a\" has 7 points"), class("line 12: \"bcd\" has 8 points"));
        assert_ne!(class("line 3: \"a\" has 7 points"), class("line 3: \"a\" has 7 knots"));
        assert_ne!(class("x"), ReadOutcome::Read("x".to_owned()).class());
    }
}
