//! `glanz info --files`: the files that a scene needs.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use glanz::Error;
use glanz::formats::photometry;
use glanz::formats::{Diagnostics, FileKind, SceneFile, SceneFileList, Severity, read_file};
use glanz::job::ResourceBudget;
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::InfoArguments;
use crate::command::luminaire;
use crate::command_error::command_error;
use crate::input;
use crate::report;

/// A file in the output of `--json`.
#[derive(Serialize)]
struct FileEntry {
    /// Absolute.
    path: PathBuf,
    kind: &'static str,
    /// Null if it is missing.
    bytes: Option<u64>,
    exists: bool,
}

impl FileEntry {
    fn of(file: &SceneFile) -> Self {
        let path = std::path::absolute(&file.path).map_or_else(|_| file.path.clone(), |path| tidy(&path));
        let metadata = file.exists.then(|| std::fs::metadata(&file.path).ok()).flatten();
        let bytes = metadata.map(|metadata| metadata.len());
        Self { path, kind: file.kind.name(), bytes, exists: file.exists }
    }
}

/// Prints the files; missing ones and other faults make the outcome a refusal.
///
/// # Errors
/// A scene file that cannot be read, or a closed stream.
pub(super) fn run(arguments: &InfoArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let SceneFileList { mut files, diagnostics } = list(arguments, messages)?;
    // What follows a limit is not in the list.
    if diagnostics.end().is_some() {
        return Err(command_error(messages)(Error::Scene(diagnostics)));
    }
    let mut known = BTreeSet::new();
    files.retain(|file| known.insert(tidy(&file.path)));
    // A line that names another file would send the wrong ones.
    if let Some(file) = files.iter().find(|file| file.path.to_str().is_none_or(|path| path.contains('\n'))) {
        let path = file.path.display();
        return Err(CommandError::new(format!("{path}: paths of a list are UTF-8 text without line ends")));
    }
    if arguments.json {
        report::print(&files.iter().map(FileEntry::of).collect::<Vec<_>>())?;
    } else {
        let lines = files.iter().map(|file| format!("{}\n", tidy(&file.path).display()));
        report::print_text(&lines.collect::<String>())?;
    }
    // Warnings are about pictures that are only listed.
    for error in diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error) {
        messages.diagnostic(error.severity, &error.to_string());
    }
    let mut missing = files.iter().filter(|file| !file.exists).peekable();
    let is_complete = !diagnostics.has_errors() && missing.peek().is_none();
    missing.for_each(|file| {
        messages.warning(&format!(
            "{}: the {} is missing or cannot be read",
            tidy(&file.path).display(),
            file.kind.name()
        ));
    });
    Ok(if is_complete { CommandOutcome::Done } else { CommandOutcome::Refused })
}

fn list(arguments: &InfoArguments, messages: Messages) -> Result<SceneFileList, CommandError> {
    let path = &arguments.scene;
    let options = arguments.reading.options(&interrupt::listen()?);
    if luminaire::is_photometric(path) {
        let budget = ResourceBudget::new(options.limits, options.cancel);
        return of_luminaire(path, &budget, messages);
    }
    glanz::formats::list_files(path, &options).map_err(Error::Scene).map_err(command_error(messages))
}

/// A photometric file, and the file of its tilt data if it names one.
fn of_luminaire(
    path: &Path,
    budget: &ResourceBudget,
    messages: Messages,
) -> Result<SceneFileList, CommandError> {
    let bytes = input::read(path, budget, messages)?;
    let file = |path: PathBuf| SceneFile { kind: FileKind::Luminaire, exists: path.is_file(), path };
    let mut files = vec![file(path.to_owned())];
    // Faults of the file matter to those who read its light, limits to all.
    let _ = photometry::read_with(&bytes, &mut |name| {
        let tilt = path.with_file_name(name);
        let bytes = read_file(&tilt, budget).map_err(|error| error.to_string());
        files.push(file(tilt));
        bytes
    });
    if let Some(end) = budget.failure() {
        return Err(input::with_limit_help(CommandError::new(format!("{}: {end}", path.display())), end));
    }
    Ok(SceneFileList { files, diagnostics: Diagnostics::default() })
}

/// The same path without `.`, and without `NAME/..` where NAME is no link, so that archives keep the layout.
fn tidy(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for component in path.components() {
        let is_folder = matches!(tidy.components().next_back(), Some(Component::Normal(_)));
        match component {
            Component::CurDir => {}
            Component::ParentDir if is_folder && !tidy.is_symlink() => {
                tidy.pop();
            }
            component => tidy.push(component),
        }
    }
    tidy
}
