//! `glanz view`: the page that shows a scene.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glanz::denoise::{DIRECTORY_VARIABLE, DenoiseError};
use glanz::formats::Options;
use glanz::job::CancelFlag;
use glanz::viewer::server::{
    ComparedDesign, SceneOverlay, SceneUpdate, Server, ServerError, ServerSettings, ViewerScene,
    WorkerCommand, WorkerSettings, run_worker, worker_folder,
};
use glanz::viewer::stream::ViewDenoiser;
use glanz::{LibraryDenoiser, LightOverlay, is_lux_folder, lux_folder_content_hash};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};

use crate::arguments::ViewArguments;
use crate::browser;
use crate::command_error::{command_error, note_limit};
use crate::file_help::with_file_help;
use crate::notes::note_diagnostics;
use crate::report;
use crate::scene_file::{is_scene, is_standard_input};

/// Serves the page until it is interrupted. In the process of a scene that a page has opened, serves that scene instead.
///
/// # Errors
/// A scene or file that is refused, or an address at which the server cannot listen.
pub(crate) fn run(arguments: &ViewArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let studio = arguments.studio.settings();
    if let Some(folder) = worker_folder() {
        let options = Options { studio, ..arguments.reading.options(&CancelFlag::default()) };
        return serve_opened_scene(arguments, options, &folder);
    }
    let scenes = [Some(&arguments.scene), arguments.compare.as_ref()];
    if scenes.into_iter().flatten().any(|path| is_standard_input(path)) {
        return Err(CommandError::usage("view shows scene files, not the standard input"));
    }
    let cancel = interrupt::listen()?;
    let options = Options { studio, ..arguments.reading.options(&cancel) };
    let (lux, second_lux) = lux_folders(arguments)?;
    let second = arguments.compare.as_ref().or_else(|| second_lux.as_ref().map(|_| &arguments.scene));
    let overlay = overlay(arguments, lux.as_deref()).map_err(command_error(messages))?;
    let read = |scene: &Path, overlay: &Option<Arc<dyn SceneOverlay>>, others: u64| {
        ViewerScene::read_beside(scene, &options, overlay.as_deref(), others)
            .map_err(|diagnostics| command_error(messages)(glanz::Error::Scene(diagnostics)))
            .map_err(|error| with_file_help(error, scene, is_scene))
    };
    let scene = &arguments.scene;
    let viewer_scene = read(scene, &overlay, 0)?;
    note_diagnostics(viewer_scene.warnings(), messages);
    let compared = match second {
        Some(path) => {
            let overlay = self::overlay(arguments, second_lux.as_deref()).map_err(command_error(messages))?;
            let viewer_scene = read(path, &overlay, viewer_scene.memory())?;
            // Those of the same file are known.
            if path != scene {
                note_diagnostics(viewer_scene.warnings(), messages);
            }
            Some(ComparedDesign { path: path.clone(), viewer_scene: Arc::new(viewer_scene), overlay })
        }
        None => None,
    };
    let is_model =
        viewer_scene.is_model() || compared.as_ref().is_some_and(|design| design.viewer_scene.is_model());
    let settings = ServerSettings {
        host: arguments.host.clone(),
        port: arguments.port,
        threads: arguments.threads.count(),
        integrator: arguments.integrator.into(),
        options: options.clone(),
        overlay,
        compared,
        denoiser: Some(denoiser()),
        worker: Some(worker_command()?),
        watch: arguments.watch,
        ..ServerSettings::default()
    };
    if !is_model {
        arguments.studio.warning().into_iter().for_each(|warning| messages.warning(&warning));
    }
    let listener =
        Box::new(move |path: &Path, update: &SceneUpdate| note_update(&path.display(), update, messages));
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

/// This program, which with the same arguments reads files in the same way.
fn worker_command() -> Result<WorkerCommand, CommandError> {
    WorkerCommand::this_program(std::env::args_os().skip(1).collect())
        .map_err(|error| CommandError::new(format!("the path of this program is unknown: {error}")))
}

/// Serves a scene that a page has opened, in a process of its own that the server has started.
fn serve_opened_scene(
    arguments: &ViewArguments,
    options: Options,
    folder: &Path,
) -> Result<CommandOutcome, CommandError> {
    let settings = WorkerSettings {
        options,
        threads: arguments.threads.count(),
        integrator: arguments.integrator.into(),
        denoiser: Some(denoiser()),
        libraries: library_folders(),
    };
    run_worker(folder, settings).map_err(|error| CommandError::new(error.to_string()))?;
    Ok(CommandOutcome::Done)
}

/// Folders in which the denoiser and the libraries that it needs may be, besides those of the system.
fn library_folders() -> Vec<PathBuf> {
    let denoiser = std::env::var_os(DIRECTORY_VARIABLE).map(PathBuf::from);
    let searched = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    // An empty name is the current folder, which is none of libraries.
    let searched = std::env::split_paths(&searched).filter(|folder| !folder.as_os_str().is_empty());
    denoiser.into_iter().chain(searched).collect()
}

/// The folders of lux maps of the design and of the second one: those that are named, or the two in a folder of a comparison.
fn lux_folders(arguments: &ViewArguments) -> Result<(Option<PathBuf>, Option<PathBuf>), CommandError> {
    let is_compared = arguments.compare.is_some();
    let (first, second) = match arguments.lux.as_slice() {
        [] => return Ok((None, None)),
        [folder] => match ["a", "b"].map(|name| folder.join(name)) {
            // With two scenes, a report beside the two folders is one of an earlier calculation.
            [a, b] if is_lux_folder(&a) && is_lux_folder(&b) && (is_compared || !is_lux_folder(folder)) => {
                (a, Some(b))
            }
            _ => (folder.clone(), None),
        },
        [first, second] => (first.clone(), Some(second.clone())),
        [_, _, third, ..] => {
            let error = CommandError::new(format!("{}: the third folder of lux maps", third.display()));
            return Err(error.with_help("two designs can be compared: give --lux twice at most"));
        }
    };
    match &second {
        None if is_compared => {
            let error =
                CommandError::new(format!("{}: there are no lux maps of the second design", first.display()));
            return Err(error.with_help(
                "give --lux twice, or the folder that `glanz illuminate A --compare B -o DIR` has written",
            ));
        }
        Some(second) if !is_compared => {
            let hashes = [&first, second].map(|folder| lux_folder_content_hash(folder));
            if matches!(hashes, [Some(first), Some(second)] if first != second) {
                let folders = format!("{} and {}", first.display(), second.display());
                let error = CommandError::new(format!("{folders}: these are lux maps of two scenes"));
                return Err(error.with_help("give the second scene with --compare"));
            }
        }
        _ => {}
    }
    Ok((Some(first), second))
}

/// The overlay of the arguments with the lux maps of a folder; `None` if it adds nothing.
fn overlay(
    arguments: &ViewArguments,
    lux: Option<&Path>,
) -> Result<Option<Arc<dyn SceneOverlay>>, glanz::Error> {
    let mut overlay = LightOverlay::default();
    if let Some(size) = arguments.room.size() {
        overlay = overlay.room(size);
    }
    overlay = match (&arguments.light, lux) {
        (Some(path), _) => overlay.baked(path)?,
        (None, Some(folder)) => overlay.lux(folder)?,
        (None, None) => overlay,
    };
    Ok(if overlay.is_empty() { None } else { Some(Arc::new(overlay)) })
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
fn note_update(name: &impl Display, update: &SceneUpdate, messages: Messages) {
    match update {
        SceneUpdate::Reloaded(viewer_scene) => {
            note_diagnostics(viewer_scene.warnings(), messages);
            messages.note(&format!("{name}: read again"));
        }
        SceneUpdate::Refused(diagnostics) => {
            match diagnostics.limit() {
                Some(limit) => note_limit(diagnostics, limit, messages),
                None => note_diagnostics(diagnostics, messages),
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct ViewCommand {
        #[command(flatten)]
        view: ViewArguments,
    }

    #[test]
    fn folders_of_lux_maps_are_those_of_the_designs() {
        let folder = std::env::temp_dir().join(format!("glanz-lux-folders-{}", std::process::id()));
        let write = |name: &str, report: &str| {
            let folder = folder.join(name);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join("report.json"), report).unwrap();
        };
        ["designs/a", "designs/b", "one"].into_iter().for_each(|name| write(name, "{}"));
        for (name, hash) in [("other/a", "0a"), ("other/b", "0b"), ("same/a", "0a"), ("same/b", "0a")] {
            write(name, &format!(r#"{{"facts": {{"scene_content_hash": "{hash}"}}}}"#));
        }
        let folders = |arguments: &str| {
            let words = arguments.split_whitespace().map(|word| match word.strip_prefix('/') {
                Some(name) => folder.join(name).display().to_string(),
                None => word.to_owned(),
            });
            let command =
                ViewCommand::parse_from(["view".to_owned(), "a.pbrt".to_owned()].into_iter().chain(words));
            lux_folders(&command.view).map_err(|error| error.message)
        };
        let path = |name: &str| Some(folder.join(name));
        assert_eq!(folders(""), Ok((None, None)));
        assert_eq!(folders("--lux /one"), Ok((path("one"), None)));
        assert_eq!(folders("--lux /designs"), Ok((path("designs/a"), path("designs/b"))));
        assert_eq!(folders("--lux /one --lux /designs/b"), Ok((path("one"), path("designs/b"))));
        assert_eq!(folders("--compare b.pbrt --lux /designs"), folders("--lux /designs"));
        assert!(folders("--compare b.pbrt --lux /one").unwrap_err().contains("no lux maps of the second"));
        assert_eq!(
            folders("--lux 1 --lux 2 --lux 3 --lux 4").unwrap_err(),
            "3: the third folder of lux maps"
        );
        // Maps of two scenes are not shown on one.
        assert_eq!(folders("--lux /same"), Ok((path("same/a"), path("same/b"))));
        for arguments in ["--lux /other", "--lux /other/a --lux /other/b"] {
            assert!(folders(arguments).unwrap_err().contains("of two scenes"), "{arguments}");
            let both = Ok((path("other/a"), path("other/b")));
            assert_eq!(folders(&format!("--compare b.pbrt {arguments}")), both);
        }
        // A report of an earlier calculation lies beside the folders of the comparison.
        write("designs", "{}");
        assert_eq!(folders("--lux /designs"), Ok((path("designs"), None)));
        assert_eq!(folders("--compare b.pbrt --lux /designs"), Ok((path("designs/a"), path("designs/b"))));
        // The reader of the folder names what is missing.
        assert_eq!(folders("--lux /nowhere"), Ok((path("nowhere"), None)));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
