//! Scene files, read with their diagnostics printed.

use std::path::Path;

use glanz::formats::Options;
use glanz::job::CancelFlag;
use glanz::scene::studio::StudioSettings;
use glanz::{Error, LoadedScene};
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::{ModelArgument, ReadingArguments, RenderCommandArguments};
use crate::command_error::command_error;
use crate::notes::note_diagnostics;

/// Reads a scene file and prints its warnings; `cancel` ends it.
///
/// # Errors
/// The faults, which have been printed.
pub(crate) fn open(
    path: &Path,
    arguments: &ReadingArguments,
    cancel: &CancelFlag,
    messages: Messages,
) -> Result<LoadedScene, CommandError> {
    print_diagnostics(glanz::open_with(path, &arguments.options(cancel)), messages)
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
    let loaded = print_diagnostics(glanz::open_with(scene, &options), messages)?;
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
