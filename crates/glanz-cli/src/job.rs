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
    let mut progress = Progress::start(messages);
    let mut events = |event: JobEvent<'_>| note_event(event, &name, messages);
    let options = JobOptions::default()
        .threads(arguments.threads.count())
        .checkpoint(arguments.checkpoint.checkpoint.clone())
        .resume(arguments.checkpoint.resume)
        .cancel(cancel)
        .on_progress(&mut progress)
        .on_event(&mut events);
    let result = run(scene, options);
    progress.finish();
    result
}
