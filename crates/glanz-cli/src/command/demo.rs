//! `glanz demo`: the built-in scene, rendered as any scene file would be.

use std::path::Path;

use crate::Ending;
use crate::arguments::DemoArguments;
use crate::command::render::render_input;
use crate::messages::{Failure, Messages};
use crate::scene_file::Input;

/// The scene; it needs no other file.
const SCENE: &str = include_str!("../../scenes/demo.pbrt");

/// Where the picture goes if the command line does not say.
const PICTURE: &str = "glanz-demo.png";

/// Renders the built-in scene and says what it shows.
///
/// # Errors
/// Why there is no picture.
pub(crate) fn run(arguments: &DemoArguments, messages: Messages) -> Result<Ending, Failure> {
    messages.note(
        "The demo: surfaces without facets. A glass sphere, a silver torus, a golden surface of degree four,\n\
         a hyperboloid, paraboloid, cylinder and cone, each met by the rays itself and cut exactly,\n\
         lit by area lights through path tracing.",
    );
    let input = Input::Text { name: "demo.pbrt", text: SCENE };
    render_input(&input, &arguments.options, Some(Path::new(PICTURE)), messages)
}
