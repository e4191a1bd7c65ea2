//! `glanz demo`: the built-in scene, rendered as any scene file would be.

use std::path::Path;

use glanz::job::CancelFlag;
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::DemoArguments;
use crate::command::render::render_scene;
use crate::scene_file::print_diagnostics;

/// The scene; it needs no other file.
const SCENE: &str = include_str!("../../scenes/demo.pbrt");

/// The picture, unless the command line names another.
const PICTURE: &str = "glanz-demo.png";

/// Renders the built-in scene, after a note on its content.
///
/// # Errors
/// A setting or file that is refused.
pub(crate) fn run(arguments: &DemoArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    messages.note(
        "The demo: surfaces without facets. A glass sphere, a silver torus, a golden surface of degree four,\n\
         a hyperboloid, a paraboloid, a cylinder and a cone, intersected and clipped exactly,\n\
         lit by area lights and rendered by path tracing.",
    );
    let open = |cancel: &CancelFlag| {
        let options = arguments.render.job.reading.options(cancel);
        print_diagnostics(glanz::open_str("demo.pbrt", SCENE, &options), messages)
    };
    render_scene(&arguments.render, None, Some(Path::new(PICTURE)), messages, open)
}
