//! Scene files, read with their diagnostics printed.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use glanz::formats::{ContentKind, Diagnostic, Diagnostics, Options, Severity};
use glanz::job::{BudgetError, CancelFlag, IoFault, LimitError, Resource, ResourceLimits};
use glanz::scene::studio::StudioSettings;
use glanz::{Error, LoadedScene};
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::{ModelArgument, ReadingArguments, RenderCommandArguments};
use crate::command_error::command_error;
use crate::file_help::with_file_help;
use crate::notes::note_diagnostics;

/// The name for a scene from the standard input.
const STANDARD_INPUT: &str = "-";

/// Its name in messages.
const INPUT_NAME: &str = "standard input";

/// Time between two tests of the flag that ends reading.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Whether the scene comes from the standard input.
pub(crate) fn is_standard_input(scene: &Path) -> bool {
    scene == Path::new(STANDARD_INPUT)
}

/// The file from which the scene is read: that of the standard input if it comes from there, where the system names it.
pub(crate) fn source(scene: &Path) -> &Path {
    if is_standard_input(scene) { Path::new("/dev/stdin") } else { scene }
}

/// Reads a scene or a model from its file, or from the standard input, where it names files in the current folder.
fn load(path: &Path, options: Options, messages: Messages) -> Result<LoadedScene, CommandError> {
    if !is_standard_input(path) {
        return print_diagnostics(glanz::open_with(path, &options), messages);
    }
    let start = Instant::now();
    let bytes = read_standard_input(&options, start, messages)?;
    // The limit of time is one of the input and of reading it together; what follows has its own.
    let (limits, cancel) = (options.limits.clone(), options.cancel.clone());
    let time = limits.time.saturating_sub(start.elapsed());
    let rest = ResourceLimits { time, ..limits.clone() };
    let options = Options { folder: Some(PathBuf::from(".")), limits: rest, ..options };
    let whole = LimitError { resource: Resource::Time, limit: limits.get(Resource::Time), needed: None };
    let opened = glanz::open_bytes(INPUT_NAME, bytes, &options);
    let opened = opened.map(|scene| scene.limits(limits, cancel)).map_err(|error| match &error {
        Error::Scene(diagnostics) if is_end_of_time(diagnostics) => beyond_limit(whole),
        _ => error,
    });
    print_diagnostics(opened, messages)
}

/// The bytes of the standard input, at most as many as the limits of files and of memory allow, if they come within the limit of time after `start`.
fn read_standard_input(
    options: &Options,
    start: Instant,
    messages: Messages,
) -> Result<Vec<u8>, CommandError> {
    let failed =
        |error: &std::io::Error| CommandError::new(format!("{INPUT_NAME}: {}", IoFault::sentence(error)));
    let resource =
        if options.limits.bytes < options.limits.memory { Resource::Bytes } else { Resource::Memory };
    let limit = options.limits.get(resource);
    let (sender, receiver) = mpsc::channel();
    // Waiting for input cannot be interrupted: this thread then ends with the process.
    let reading = std::thread::Builder::new().spawn(move || {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().take(limit.saturating_add(1)).read_to_end(&mut bytes);
        // The receiver is gone if the flag was raised.
        let _ = sender.send(read.map(|_| bytes));
    });
    reading.map_err(|error| failed(&error))?;
    let bytes = loop {
        match receiver.recv_timeout(POLL_INTERVAL) {
            Ok(read) => break read.map_err(|error| failed(&error))?,
            Err(RecvTimeoutError::Timeout) if options.cancel.is_cancelled() => {
                return Err(CommandError::interrupted("interrupted; nothing was written"));
            }
            Err(RecvTimeoutError::Timeout) if start.elapsed() > options.limits.time => {
                let (resource, limit) = (Resource::Time, options.limits.get(Resource::Time));
                let limit = LimitError { resource, limit, needed: None };
                return Err(command_error(messages)(beyond_limit(limit)));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(CommandError::new(format!("{INPUT_NAME}: it cannot be read")));
            }
        }
    };
    if bytes.len() as u64 > limit {
        return Err(command_error(messages)(beyond_limit(LimitError { resource, limit, needed: None })));
    }
    Ok(bytes)
}

fn is_end_of_time(diagnostics: &Diagnostics) -> bool {
    matches!(diagnostics.end(), Some(BudgetError::Limit(limit)) if limit.resource == Resource::Time)
}

/// The error of an input beyond a limit.
fn beyond_limit(limit: LimitError) -> Error {
    let diagnostic = Diagnostic {
        severity: Severity::Error,
        kind: "limit",
        file: INPUT_NAME.to_owned(),
        location: None,
        message: limit.to_string(),
        excerpt: None,
        help: None,
    };
    Error::Scene(Diagnostics::of_end(diagnostic, BudgetError::Limit(limit)))
}

/// Reads a scene file, or the standard input for `-`, and prints its warnings; `cancel` ends it.
///
/// # Errors
/// The faults, which have been printed.
pub(crate) fn open(
    path: &Path,
    arguments: &ReadingArguments,
    cancel: &CancelFlag,
    messages: Messages,
) -> Result<LoadedScene, CommandError> {
    let opened = load(path, arguments.options(cancel), messages);
    opened.map_err(|error| with_scene_help(error, path))
}

/// The error about a scene, with advice on the content of its file; the standard input has none.
fn with_scene_help(error: CommandError, path: &Path) -> CommandError {
    if is_standard_input(path) { error } else { with_file_help(error, path, is_scene) }
}

/// Whether a file can be read as a scene, so that its faults are others.
pub(crate) fn is_scene(kind: &ContentKind) -> bool {
    matches!(kind, ContentKind::Scene(_))
}

/// Reads the scene file or the model of a render and prints its warnings, also that of options that have no effect on a scene.
///
/// # Errors
/// The faults, which have been printed; a section through a scene.
pub(crate) fn open_cut_model(
    arguments: &RenderCommandArguments,
    cancel: &CancelFlag,
    messages: Messages,
) -> Result<LoadedScene, CommandError> {
    let ModelArgument { scene, studio } = &arguments.model;
    let settings = StudioSettings { section: arguments.section, ..studio.settings() };
    let edges = arguments.render.draws_edges();
    let options = Options { studio: settings, edges, ..arguments.render.job.reading.options(cancel) };
    let loaded = load(scene, options, messages);
    let loaded = loaded.map_err(|error| with_scene_help(error, scene))?;
    if loaded.studio_settings().is_none() {
        if arguments.section.is_some() {
            let message = format!("--section: {} is not a model", loaded.name());
            return Err(CommandError::usage(message));
        }
        studio.warning().into_iter().for_each(|warning| messages.warning(&warning));
    }
    Ok(loaded)
}

/// Prints the warnings or errors of reading a scene.
///
/// # Errors
/// The faults, which have been printed.
pub(crate) fn print_diagnostics(
    opened: Result<LoadedScene, Error>,
    messages: Messages,
) -> Result<LoadedScene, CommandError> {
    let scene = opened.map_err(command_error(messages))?;
    note_diagnostics(scene.diagnostics(), messages);
    Ok(scene)
}
