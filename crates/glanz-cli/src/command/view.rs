//! `glanz view`: the page that shows a scene.

use std::sync::Arc;

use glanz_formats::{Diagnostics, Options};
use glanz_viewer::server::{Dress, News, Server, ServerError, ServerSettings, Shown};

use crate::Ending;
use crate::arguments::ViewArguments;
use crate::interrupt;
use crate::messages::{Failure, Messages};
use crate::report;
use crate::scene_file::say_all;
use crate::surface_light::SurfaceLight;

/// Serves the page until it is interrupted.
///
/// # Errors
/// Why there is nothing to show, or no way to.
pub(crate) fn run(arguments: &ViewArguments, messages: Messages) -> Result<Ending, Failure> {
    let cancel = interrupt::listen()?;
    let options = Options { strict: arguments.strict, ..Options::default() };
    let light: Option<Arc<dyn Dress>> = match SurfaceLight::read(arguments)? {
        Some(light) => Some(Arc::new(light)),
        None => None,
    };
    let settings = ServerSettings {
        host: arguments.host.clone(),
        port: arguments.port,
        threads: arguments.threads.map_or(0, usize::from),
        integrator: arguments.integrator.into(),
        options: options.clone(),
        dress: light.clone(),
        watch: arguments.watch,
        ..ServerSettings::default()
    };
    let shown = Shown::read(&arguments.scene, &options, light.as_deref())
        .map_err(|diagnostics| refused(&diagnostics, messages))?;
    say_all(shown.warnings(), messages);
    let name = arguments.scene.display().to_string();
    let listener = Box::new(move |news: &News| tell(&name, news, messages));
    let server =
        Server::bind(&settings, &arguments.scene, shown, listener).map_err(|error| failure(&error))?;
    report::print_text(&format!("{}\n", server.address()))?;
    messages.note("Ctrl-C ends the page");
    if !arguments.no_open {
        show(server.address(), messages);
    }
    server.run(&cancel).map_err(|error| failure(&error))?;
    // Nothing was cut short: this is how the command ends.
    Ok(Ending::Done)
}

/// Says why a scene is none.
fn refused(diagnostics: &Diagnostics, messages: Messages) -> Failure {
    say_all(diagnostics, messages);
    Failure::said()
}

fn failure(error: &ServerError) -> Failure {
    let failure = Failure::new(error.to_string());
    match error {
        ServerError::Address { .. } => failure
            .with_help("choose another port with --port, or a name or number of this machine with --host"),
        _ => failure,
    }
}

/// Says what became of the scene whose files changed.
fn tell(name: &str, news: &News, messages: Messages) {
    match news {
        News::Read(shown) => {
            say_all(shown.warnings(), messages);
            messages.note(&format!("{name}: read again"));
        }
        News::Refused(diagnostics) => {
            say_all(diagnostics, messages);
            messages.note(&format!("{name}: the page keeps what it shows"));
        }
    }
}

/// Opens the browser. Where that cannot be done the address is there to be copied.
fn show(address: &str, messages: Messages) {
    if let Err(error) = open::that_detached(address) {
        messages.warning(&format!("the browser cannot be opened: {error}; open the address yourself"));
    }
}
