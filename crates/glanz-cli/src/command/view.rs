//! `glanz view`: the page that shows a scene.

use std::sync::Arc;

use glanz::denoise::DenoiseError;
use glanz::formats::Options;
use glanz::viewer::server::{SceneOverlay, SceneUpdate, Server, ServerError, ServerSettings, ViewerScene};
use glanz::viewer::stream::ViewDenoiser;
use glanz::{LibraryDenoiser, LightOverlay};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};

use crate::arguments::ViewArguments;
use crate::browser;
use crate::command_error::command_error;
use crate::notes::note_diagnostics;
use crate::report;

/// Serves the page until it is interrupted.
///
/// # Errors
/// A scene or file that is refused, or an address at which the server cannot listen.
pub(crate) fn run(arguments: &ViewArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let cancel = interrupt::listen()?;
    let (strict, studio) = (arguments.strictness.strict, arguments.model.studio.settings());
    let options = Options { strict, studio, ..Options::default() };
    let overlay = overlay(arguments).map_err(command_error(messages))?;
    let overlay: Option<Arc<dyn SceneOverlay>> = match overlay.is_empty() {
        true => None,
        false => Some(Arc::new(overlay)),
    };
    let settings = ServerSettings {
        host: arguments.host.clone(),
        port: arguments.port,
        threads: arguments.threads.count(),
        integrator: arguments.integrator.into(),
        options: options.clone(),
        overlay: overlay.clone(),
        denoiser: Some(denoiser()),
        watch: arguments.watch,
        ..ServerSettings::default()
    };
    let scene = &arguments.model.scene;
    let viewer_scene = ViewerScene::read(scene, &options, overlay.as_deref())
        .map_err(|diagnostics| command_error(messages)(glanz::Error::Scene(diagnostics)))?;
    note_diagnostics(viewer_scene.warnings(), messages);
    if !viewer_scene.is_model() {
        arguments.model.studio.warning().into_iter().for_each(|warning| messages.warning(&warning));
    }
    let name = scene.display().to_string();
    let listener = Box::new(move |update: &SceneUpdate| note_update(&name, update, messages));
    let server =
        Server::bind(&settings, scene, viewer_scene, listener).map_err(|error| server_failure(&error))?;
    report::print_text(&format!("{}\n", server.address()))?;
    messages.note("Ctrl-C ends the server");
    if !arguments.no_open {
        open_browser(server.address(), messages);
    }
    server.run(&cancel).map_err(|error| server_failure(&error))?;
    // Cancelling is the normal end of this command.
    Ok(CommandOutcome::Done)
}

/// The overlay of the arguments.
fn overlay(arguments: &ViewArguments) -> Result<LightOverlay, glanz::Error> {
    let mut overlay = LightOverlay::default();
    if let Some(size) = arguments.room.size() {
        overlay = overlay.room(size);
    }
    match (&arguments.light, &arguments.lux) {
        (Some(path), _) => overlay.baked(path),
        (None, Some(folder)) => overlay.lux(folder),
        (None, None) => Ok(overlay),
    }
}

/// The denoiser, or the reason why there is none, as pages show it.
fn denoiser() -> Result<Arc<dyn ViewDenoiser>, String> {
    match LibraryDenoiser::load() {
        Ok(denoiser) => Ok(Arc::new(denoiser)),
        // Without the files that were tried, which are of no interest on another machine.
        Err(DenoiseError::NotFound { .. }) => Err(
            "Open Image Denoise was not found: install it (https://www.openimagedenoise.org), set OIDN_DIR to its folder, and start glanz view again"
                .to_owned(),
        ),
        Err(DenoiseError::Version { function, .. }) => Err(format!(
            "Open Image Denoise has no function {function:?}; version 2 is needed: install it, set OIDN_DIR to its folder, and start glanz view again"
        )),
        Err(error) => Err(error.to_string()),
    }
}

fn server_failure(error: &ServerError) -> CommandError {
    let failure = CommandError::new(error.to_string());
    match error {
        ServerError::Address { .. } => failure.with_help(
            "choose another port with --port, or a host name or IP address of this machine with --host",
        ),
        _ => failure,
    }
}

/// Reports that the scene was read again after its files changed.
fn note_update(name: &str, update: &SceneUpdate, messages: Messages) {
    match update {
        SceneUpdate::Reloaded(viewer_scene) => {
            note_diagnostics(viewer_scene.warnings(), messages);
            messages.note(&format!("{name}: read again"));
        }
        SceneUpdate::Refused(diagnostics) => {
            note_diagnostics(diagnostics, messages);
            messages.note(&format!("{name}: the page keeps the previous scene"));
        }
    }
}

/// Opens the browser. Where that fails, the address can be copied.
fn open_browser(address: &str, messages: Messages) {
    if let Err(error) = browser::open(address) {
        messages.warning(&format!("the browser cannot be opened: {error}; open the address yourself"));
    }
}
