//! `glanz render --turntable`: pictures of a turn around a model.

use std::path::{Path, PathBuf};

use glanz::LoadedScene;
use glanz::file::FileUses;
use glanz::scene::studio::{StudioSettings, TurntableFrame};
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::{CommandError, Messages};

use crate::arguments::RenderArguments;
use crate::command::render::render_scene;
use crate::command_error::command_error;
use crate::outputs::{default_path, is_stream};

/// Renders `count` pictures of the model; `stem`: their name if the arguments have none.
///
/// # Errors
/// A scene, which has a camera of its own; a setting or file that is refused.
pub(crate) fn run(
    scene: LoadedScene,
    arguments: &RenderArguments,
    count: u32,
    stem: &str,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let Some(settings) = scene.studio_settings().cloned() else {
        let name = scene.name();
        return Err(CommandError::usage(format!(
            "--turntable: {name} is not a model; it has its own camera"
        )));
    };
    let mut outputs = arguments.output.clone();
    if outputs.is_empty() {
        outputs.push(default_path(None, Path::new(stem)));
    }
    if outputs.iter().any(|path| is_stream(path)) {
        return Err(CommandError::usage("--turntable: the standard output can take one picture only"));
    }
    let mut files = FileUses::default();
    let inputs = [arguments.guide_in.as_ref(), arguments.light_in.as_ref()].into_iter().flatten();
    files.add_inputs(inputs.chain(scene.paths())).map_err(command_error(messages))?;
    let mut frames =
        (0..count).flat_map(|number| outputs.iter().map(move |path| frame_path(path, number, count)));
    frames.try_for_each(|path| files.add_result(&path)).map_err(command_error(messages))?;
    for number in 0..count {
        let mut arguments = arguments.clone();
        arguments.output = outputs.iter().map(|path| frame_path(path, number, count)).collect();
        let turntable = Some(TurntableFrame { number, count });
        let frame = scene.clone().studio(StudioSettings { turntable, ..settings.clone() });
        if render_scene(&arguments, None, None, messages, |_| Ok(frame))? == CommandOutcome::Interrupted {
            return Ok(CommandOutcome::Interrupted);
        }
    }
    Ok(CommandOutcome::Done)
}

/// The file of a picture: with its number from 1, as many digits as the last one has.
fn frame_path(path: &Path, number: u32, count: u32) -> PathBuf {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, extension) = (text(path.file_stem()), text(path.extension()));
    let digits = count.to_string().len();
    path.with_file_name(format!("{stem}-{:0digits$}.{extension}", number + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_in_the_order_of_their_names() {
        let name = |number, count| frame_path(Path::new("a/turn.x.png"), number, count).display().to_string();
        assert_eq!([name(0, 9), name(8, 9)], ["a/turn.x-1.png", "a/turn.x-9.png"]);
        assert_eq!([name(0, 36), name(35, 36)], ["a/turn.x-01.png", "a/turn.x-36.png"]);
    }
}
