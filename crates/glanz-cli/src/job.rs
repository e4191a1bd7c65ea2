//! Jobs with the options of their command.

use glanz::job::CancelFlag;
use glanz::{Error, JobEvent, JobOptions, LoadedScene};
use glanz_terminal::messages::Messages;
use glanz_terminal::progress::Progress;

use crate::arguments::JobArguments;
use crate::notes::note_event;

/// Runs a job of the scene with the options of the command; messages report its progress and its events.
///
/// # Errors
/// Those of `run`.
pub(crate) fn run_job<T>(
    scene: LoadedScene,
    arguments: &JobArguments,
    cancel: CancelFlag,
    messages: Messages,
    run: impl FnOnce(LoadedScene, JobOptions<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let name = scene.name().to_owned();
    run_named_job(&name, arguments, cancel, messages, |options| run(scene, options))
}

/// As [`run_job`], of a scene of this name.
///
/// # Errors
/// Those of `run`.
pub(crate) fn run_named_job<T>(
    name: &str,
    arguments: &JobArguments,
    cancel: CancelFlag,
    messages: Messages,
    run: impl FnOnce(JobOptions<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let mut progress = Progress::start(messages);
    let mut events = |event: JobEvent<'_>| note_event(event, name, messages);
    let options = JobOptions::default()
        .threads(arguments.threads.count())
        .checkpoint(arguments.checkpoint.checkpoint.clone())
        .resume(arguments.checkpoint.resume)
        .cancel(cancel)
        .on_progress(&mut progress)
        .on_event(&mut events);
    let result = run(options);
    progress.finish();
    result
}
