//! The pictures that a command writes: checked before the work starts, written when it is done.

use std::path::{Path, PathBuf};

use glanz::file::FileUses;
use glanz::formats::image::Format;
use glanz::light::Tone;
use glanz::{Error, Picture, picture_format};
use glanz_terminal::messages::{CommandError, Messages};

use crate::command_error::command_error;

/// Pictures to write, each in the format of its extension.
#[derive(Debug)]
pub(crate) struct Outputs {
    files: Vec<(PathBuf, Format)>,
    tone: Tone,
}

impl Outputs {
    /// Checks that each of `paths` has an extension that Glanz writes and lies in a folder it can write to, and adds it to the files of the command.
    ///
    /// # Errors
    /// What is wrong with the first path that cannot be written.
    pub(crate) fn try_new(
        paths: &[PathBuf],
        tone: Tone,
        uses: &mut FileUses,
        messages: Messages,
    ) -> Result<Self, CommandError> {
        let checked = paths.iter().map(|path| {
            let format = picture_format(path)?;
            uses.add_output(path)?;
            Ok((path.clone(), format))
        });
        let files = checked.collect::<Result<_, Error>>().map_err(command_error(messages))?;
        Ok(Self { files, tone })
    }

    /// Whether any of the files holds channels beside the colour.
    pub(crate) fn keep_channels(&self) -> bool {
        self.files.iter().any(|(_, format)| *format == Format::Exr)
    }

    /// The names of the files, as given.
    pub(crate) fn names(&self) -> Vec<String> {
        self.files.iter().map(|(path, _)| path.display().to_string()).collect()
    }

    /// Writes the picture to every file, even if one of them fails.
    ///
    /// # Errors
    /// What went wrong, one line per file that is not written.
    pub(crate) fn write(&self, picture: &Picture) -> Result<(), CommandError> {
        let saved = self.files.iter().map(|(path, _)| picture.save_with(path, &self.tone));
        let failures: Vec<String> = saved.filter_map(Result::err).map(|error| error.to_string()).collect();
        if failures.is_empty() { Ok(()) } else { Err(CommandError::new(failures.join("\n"))) }
    }
}

/// The file for the picture of `scene` unless the command line names one: in the current folder under the film's file name, as EXR if
/// the format of that name is not written.
pub(crate) fn default_path(film_name: Option<&str>, scene: &Path) -> PathBuf {
    let named = film_name.map(Path::new).and_then(Path::file_name).or(scene.file_name());
    let path = named.map_or_else(|| PathBuf::from("picture"), PathBuf::from);
    if picture_format(&path).is_ok() { path } else { path.with_extension("exr") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_goes_to_the_current_folder_under_the_name_in_the_scene() {
        let path = |name, scene| default_path(name, Path::new(scene));
        assert_eq!(path(Some("renders/box.png"), "scenes/box.pbrt"), Path::new("box.png"));
        assert_eq!(path(Some("box.tga"), "scenes/box.pbrt"), Path::new("box.exr"));
        assert_eq!(path(None, "scenes/box.pbrt"), Path::new("box.exr"));
        assert_eq!(path(Some(""), "scenes/box.pbrt"), Path::new("box.exr"));
    }

    #[test]
    fn outputs_that_cannot_be_written_are_refused_before_the_work() {
        let folder = std::env::temp_dir();
        let outputs = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
            Outputs::try_new(&paths, Tone::default(), &mut FileUses::default(), Messages::new(true))
                .map(|_| ())
                .map_err(|failure| failure.usage)
        };
        assert_eq!(outputs(&["a.exr", "a.png", "a.hdr"]), Ok(()));
        assert_eq!(outputs(&["a.tiff"]), Err(true));
        assert_eq!(outputs(&["a"]), Err(true));
        assert_eq!(outputs(&["a.jpg"]), Err(true));
        assert_eq!(outputs(&["a.exr", "a.exr"]), Err(true));
        assert_eq!(outputs(&["no such folder/a.exr"]), Err(false));
    }
}
