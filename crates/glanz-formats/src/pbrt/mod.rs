//! pbrt's scene language, versions 1 to 4.
//!
//! `lexer` reads words, `parameters` typed lists of them, `parser` the directives, and `state` holds the graphics state that they change;
//! `lower` creates the description, by the rules of the `dialect`; `write` makes a text of a model again,
//! `rewrite` one of a scene with the results of an inverse design.
//! `docs/scene-format.md` lists the supported features and the substitutes for others.
//!
//! # Source
//! @pbrtformat; defaults as documented there for version 3 and version 4.

mod color_space;
mod dialect;
mod lexer;
mod lower;
mod parameters;
mod parser;
mod rewrite;
mod state;
mod write;

use std::path::Path;
use std::sync::Arc;

use glanz_job::ResourceBudget;
use glanz_scene::studio::StudioSettings;
use glanz_scene::{Diagnostic, Diagnostics, Severity};

use crate::file_list::SceneFileList;
use crate::finder::FileFinder;
use crate::registry::{Loaded, Options};
use crate::source::Reporter;
use lower::Lowering;
use parser::Parser;

pub use rewrite::{RewriteError, rewrite};
pub use write::{PbrtWriteError, write};

/// Whether the first word of a text is a directive.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    while rest.starts_with(b"#") {
        let line = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        rest = rest.get(line..).unwrap_or_default().trim_ascii_start();
    }
    let length = rest.iter().position(|b| !b.is_ascii_alphabetic()).unwrap_or(rest.len());
    let word = rest.get(..length).unwrap_or_default();
    parser::DIRECTIVES.iter().any(|directive| directive.as_bytes() == word)
}

/// Reads a scene from the bytes of its file. `name`: its name in messages; `path`: its path, if it is a file.
pub(crate) fn load(
    name: &str,
    path: Option<&Path>,
    bytes: Arc<[u8]>,
    options: &Options,
    budget: &ResourceBudget,
) -> Result<Loaded, Diagnostics> {
    let finder = FileFinder::of_scene(name, path, &bytes, options, budget)?;
    let (lowering, is_understood) = lower(name, path, bytes, options, finder);
    let Lowering { description, mut reporter, finder, studio_up, .. } = lowering;
    let is_lit = !description.lights.is_empty();
    if let Some((_, place)) = studio_up.filter(|_| is_lit || description.camera.location.is_some()) {
        let message = "Option \"studio\": the scene is a model; a studio replaces its camera and adds light";
        reporter.stand_in(&place, "stand-in-studio", message);
    }
    reporter.sources.set_paths(finder.paths());
    if reporter.diagnostics.has_errors() {
        return Err(if is_understood { reporter.diagnostics } else { no_scene(&reporter.diagnostics) });
    }
    Ok(Loaded {
        description,
        diagnostics: reporter.diagnostics,
        content_hash: finder.hash.value(),
        sources: reporter.sources,
        studio: studio_up.map(|(up, _)| {
            let given = &options.studio;
            StudioSettings { up: given.up.or(Some(up)), ..given.clone() }
        }),
        cad: None,
        budget: budget.clone(),
    })
}

/// Lists the files that a scene needs.
pub(crate) fn list_files(
    name: &str,
    path: &Path,
    bytes: Arc<[u8]>,
    options: &Options,
    budget: &ResourceBudget,
) -> Result<SceneFileList, Diagnostics> {
    let mut finder = FileFinder::of_scene(name, Some(path), &bytes, options, budget)?;
    finder.lists = true;
    let (Lowering { finder, reporter, .. }, _) = lower(name, Some(path), bytes, options, finder);
    Ok(finder.into_list(reporter.diagnostics))
}

/// Reads and lowers a scene and all files that it names. The second value tells whether there was a directive.
fn lower(
    name: &str,
    path: Option<&Path>,
    bytes: Arc<[u8]>,
    options: &Options,
    finder: FileFinder,
) -> (Lowering, bool) {
    let (strict, lists, budget) = (options.strict, finder.lists, finder.budget.clone());
    let reporter = Reporter { strict, lists, budget, ..Reporter::default() };
    let dialect = dialect::detect(&bytes, &reporter.budget);
    let lowering = Lowering { edges: options.edges, ..Lowering::new(reporter, dialect, finder) };
    let mut parser = Parser::new(lowering);
    parser.run(name, path, bytes);
    (parser.lowering, parser.is_understood)
}

/// The first error of a file without any directive, for which all others are the same.
fn no_scene(diagnostics: &Diagnostics) -> Diagnostics {
    if diagnostics.end().is_some() {
        return diagnostics.clone();
    }
    let mut first = Diagnostics::default();
    let help = "no directive of pbrt's language was found; the file may be something else than a scene";
    for error in diagnostics.iter().filter(|d| d.severity == Severity::Error).take(1) {
        first.push(Diagnostic { help: error.help.clone().or(Some(help.to_owned())), ..error.clone() });
    }
    first
}
