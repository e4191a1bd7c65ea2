//! `glanz view`: the page that shows a scene.

use std::sync::Arc;

use glanz::LightOverlay;
use glanz::formats::Options;
use glanz::viewer::server::{Dress, News, Server, ServerError, ServerSettings, Shown};
use glanz_terminal::messages::{Failure, Messages};
use glanz_terminal::{Ending, interrupt};

use crate::arguments::ViewArguments;
use crate::browser;
use crate::failure::failure;
use crate::notes::note_diagnostics;
use crate::report;

/// Serves the page until it is interrupted.
///
/// # Errors
/// A scene or file that is refused, or an address that cannot be served from.
pub(crate) fn run(arguments: &ViewArguments, messages: Messages) -> Result<Ending, Failure> {
    let cancel = interrupt::listen()?;
    let options = Options { strict: arguments.strictness.strict, ..Options::default() };
    let overlay = overlay(arguments).map_err(failure(messages))?;
    let overlay: Option<Arc<dyn Dress>> = match overlay.is_empty() {
        true => None,
        false => Some(Arc::new(overlay)),
    };
    let settings = ServerSettings {
        host: arguments.host.clone(),
        port: arguments.port,
        threads: arguments.threads.count(),
        integrator: arguments.integrator.into(),
        options: options.clone(),
        dress: overlay.clone(),
        watch: arguments.watch,
        ..ServerSettings::default()
    };
    let scene = &arguments.scene.scene;
    let shown = Shown::read(scene, &options, overlay.as_deref())
        .map_err(|diagnostics| failure(messages)(glanz::Error::Scene(diagnostics)))?;
    note_diagnostics(shown.warnings(), messages);
    let name = scene.display().to_string();
    let listener = Box::new(move |news: &News| note_news(&name, news, messages));
    let server = Server::bind(&settings, scene, shown, listener).map_err(|error| server_failure(&error))?;
    report::print_text(&format!("{}\n", server.address()))?;
    messages.note("Ctrl-C ends the page");
    if !arguments.no_open {
        open_browser(server.address(), messages);
    }
    server.run(&cancel).map_err(|error| server_failure(&error))?;
    // Nothing was cut short: this is how the command ends.
    Ok(Ending::Done)
}

/// What the arguments add to the scene.
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

fn server_failure(error: &ServerError) -> Failure {
    let failure = Failure::new(error.to_string());
    match error {
        ServerError::Address { .. } => failure
            .with_help("choose another port with --port, or a name or number of this machine with --host"),
        _ => failure,
    }
}

/// Reports that the scene was read again after its files changed.
fn note_news(name: &str, news: &News, messages: Messages) {
    match news {
        News::Read(shown) => {
            note_diagnostics(shown.warnings(), messages);
            messages.note(&format!("{name}: read again"));
        }
        News::Refused(diagnostics) => {
            note_diagnostics(diagnostics, messages);
            messages.note(&format!("{name}: the page keeps what it shows"));
        }
    }
}

/// Opens the browser. Where that fails, the address can be copied.
fn open_browser(address: &str, messages: Messages) {
    if let Err(error) = browser::open(address) {
        messages.warning(&format!("the browser cannot be opened: {error}; open the address yourself"));
    }
}
