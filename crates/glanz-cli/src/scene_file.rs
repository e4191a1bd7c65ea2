//! A scene from its file to the validated scene, and what there is to say about it on the way.

use std::path::Path;

use glanz_formats::{Diagnostic, Diagnostics, Options, Severity, Sources, load, load_str};
use glanz_scene::{Description, Location, Scene};

use crate::messages::{Failure, Messages};

/// Where a scene comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Input<'a> {
    /// A file.
    File(&'a Path),
    /// A text built into the program.
    Text {
        /// What messages call it.
        name: &'a str,
        /// The scene.
        text: &'a str,
    },
}

impl Input<'_> {
    /// The name in messages.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::File(path) => path.to_str().unwrap_or("scene"),
            Self::Text { name, .. } => name,
        }
    }
}

/// A scene that was read.
#[derive(Debug)]
pub(crate) struct SceneFile {
    pub(crate) description: Description,
    /// Fingerprint of all files read.
    pub(crate) content_hash: u128,
    sources: Sources,
    warnings: Vec<String>,
}

impl SceneFile {
    /// Reads `input` and says its warnings. `strict`: a stand-in is an error.
    ///
    /// # Errors
    /// The faults have been said already.
    pub(crate) fn read(input: &Input<'_>, strict: bool, messages: Messages) -> Result<Self, Failure> {
        let options = Options { strict, ..Options::default() };
        let loaded = match input {
            Input::File(path) => load(path, &options),
            Input::Text { name, text } => load_str(name, text, &options),
        };
        let loaded = loaded.map_err(|diagnostics| {
            say_all(&diagnostics, messages);
            Failure::said()
        })?;
        say_all(&loaded.diagnostics, messages);
        let warnings = loaded.diagnostics.iter().map(sentence).collect();
        Ok(Self {
            description: loaded.description,
            content_hash: loaded.content_hash,
            sources: loaded.sources,
            warnings,
        })
    }

    /// The picture that the scene names.
    pub(crate) fn film_name(&self) -> Option<&str> {
        self.description.film.file_name.as_deref()
    }

    /// The scene, with the warnings of its making said. `strict`: they are errors.
    ///
    /// # Errors
    /// Why the description is not a scene, with its place.
    pub(crate) fn resolve(&mut self, strict: bool, messages: Messages) -> Result<Scene, Failure> {
        let description = std::mem::take(&mut self.description);
        let (scene, warnings) = Scene::resolve(description)
            .map_err(|error| self.failure(error.location, &error.kind.to_string()))?;
        let severity = if strict { Severity::Error } else { Severity::Warning };
        let refused = strict && !warnings.is_empty();
        let mut diagnostics = Diagnostics::default();
        for warning in warnings {
            diagnostics.push(self.sources.diagnostic(severity, "scene", warning.location, warning.message));
        }
        say_all(&diagnostics, messages);
        if refused {
            return Err(Failure::said());
        }
        self.warnings.extend(diagnostics.iter().map(sentence));
        Ok(scene)
    }

    /// A fault at a place of the scene.
    pub(crate) fn failure(&self, location: Option<Location>, message: &str) -> Failure {
        let diagnostic = self.sources.diagnostic(Severity::Error, "scene", location, message.to_owned());
        let text = diagnostic.to_string();
        Failure::new(text.trim_end().strip_prefix("error: ").unwrap_or(&text))
    }

    /// Says a warning that is about no place of the scene.
    pub(crate) fn warn(&mut self, text: &str, messages: Messages) {
        messages.warning(text);
        self.warnings.push(text.to_owned());
    }

    /// All warnings so far, a sentence each.
    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings
    }
}

/// Says all messages about a scene, and how many there are beside.
pub(crate) fn say_all(diagnostics: &Diagnostics, messages: Messages) {
    for diagnostic in diagnostics {
        messages.diagnostic(diagnostic.severity, &diagnostic.to_string());
    }
    for (severity, kind, count) in diagnostics.omitted() {
        messages
            .diagnostic(severity, &format!("{severity}: {count} more of the kind \"{kind}\" are not shown"));
    }
}

/// Place and message in one line.
fn sentence(diagnostic: &Diagnostic) -> String {
    let (file, message) = (&diagnostic.file, &diagnostic.message);
    match diagnostic.location {
        Some(location) => format!("{file}:{}:{}: {message}", location.line, location.column),
        None => format!("{file}: {message}"),
    }
}
