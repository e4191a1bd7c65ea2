//! The pictures that a command writes: checked before the work starts, written when it is done.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use glanz::file::FileUses;
use glanz::formats::image::Format;
use glanz::light::Tone;
use glanz::{Error, FileFault, Picture, picture_format};
use glanz_terminal::Verbosity;
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::output::unwritten;

use crate::command_error::command_error;

/// The name of the standard output in messages.
const STANDARD_OUTPUT: &str = "standard output";

/// Pictures to write, each in the format of its extension.
#[derive(Debug)]
pub(crate) struct Outputs {
    files: Vec<(PathBuf, Format)>,
    /// Format of the picture on the standard output, if there is one.
    stream: Option<Format>,
    tone: Tone,
}

impl Outputs {
    /// Checks that each of `paths` has an extension that Glanz writes and lies in a folder it can write to, and adds it to the files of the command. The
    /// standard output is called by its format: `png:-`.
    ///
    /// # Errors
    /// What is wrong with the first path that cannot be written.
    pub(crate) fn try_new(
        paths: &[PathBuf],
        tone: Tone,
        uses: &mut FileUses,
        messages: Messages,
    ) -> Result<Self, CommandError> {
        let mut outputs = Self { files: Vec::new(), stream: None, tone };
        for path in paths {
            let added = match stream_format(path)? {
                Some(format) => {
                    if outputs.stream.replace(format).is_some() {
                        return Err(CommandError::usage("-o: the standard output can take one picture only"));
                    }
                    Ok(())
                }
                None => outputs.add_file(path, uses),
            };
            added.map_err(command_error(messages))?;
        }
        Ok(outputs)
    }

    fn add_file(&mut self, path: &Path, uses: &mut FileUses) -> Result<(), Error> {
        let format = picture_format(path)?;
        uses.add_output(path)?;
        self.files.push((path.to_owned(), format));
        Ok(())
    }

    /// Refuses a picture on a terminal, or on a standard output that has messages for programs.
    ///
    /// # Errors
    /// The option that is in the way.
    pub(crate) fn check_stream(&self, verbosity: Verbosity) -> Result<(), CommandError> {
        if self.stream.is_none() {
            return Ok(());
        }
        if verbosity.is_for_programs() {
            let message = "-o: the standard output has the messages of --json or --progress openjd already";
            return Err(CommandError::usage(message).with_help("write the picture to a file"));
        }
        if io::stdout().is_terminal() {
            let help = "connect it to a program or a file: glanz render SCENE -o png:- | PROGRAM";
            return Err(CommandError::usage("-o: a picture cannot be written to a terminal").with_help(help));
        }
        Ok(())
    }

    /// Whether any of the files holds channels beside the colour.
    pub(crate) fn keep_channels(&self) -> bool {
        self.files.iter().map(|(_, format)| format).chain(&self.stream).any(|format| *format == Format::Exr)
    }

    /// The names of the files, as given.
    pub(crate) fn names(&self) -> Vec<String> {
        let files = self.files.iter().map(|(path, _)| path.display().to_string());
        files.chain(self.stream.map(|_| STANDARD_OUTPUT.to_owned())).collect()
    }

    /// Writes the picture to every file, even if one of them fails.
    ///
    /// # Errors
    /// What went wrong, one line per file that is not written.
    pub(crate) fn write(&self, picture: &Picture, messages: Messages) -> Result<(), CommandError> {
        let saved = self.files.iter().map(|(path, _)| picture.save_with(path, &self.tone));
        let mut failures: Vec<CommandError> =
            saved.filter_map(Result::err).map(command_error(messages)).collect();
        let streamed = self.stream.map_or(Ok(()), |format| self.write_stream(picture, format, messages));
        failures.extend(streamed.err());
        joined(failures)
    }

    fn write_stream(
        &self,
        picture: &Picture,
        format: Format,
        messages: Messages,
    ) -> Result<(), CommandError> {
        let (mut stream, name) = (io::stdout().lock(), Path::new(STANDARD_OUTPUT));
        match picture.write_to(&mut stream, name, format, &self.tone) {
            Err(Error::File { fault: FileFault::Io(error), .. }) => Err(unwritten(&error)),
            written => written.map_err(command_error(messages)),
        }
    }
}

/// The failures as one, with a line for each. A reader that has gone is no failure beside another.
///
/// # Errors
/// Unless there is none.
pub(crate) fn joined(failures: Vec<CommandError>) -> Result<(), CommandError> {
    let (closed, others): (Vec<_>, Vec<_>) = failures.into_iter().partition(|failure| failure.is_closed_pipe);
    let sentences: Vec<&str> = others.iter().map(|failure| failure.message.as_str()).collect();
    match others.first() {
        None => closed.into_iter().next().map_or(Ok(()), Err),
        Some(first) => {
            Err(CommandError { help: first.help.clone(), ..CommandError::new(sentences.join("\n")) })
        }
    }
}

/// The format of a picture on the standard output; `None` for a file.
///
/// # Errors
/// A format that is missing or unknown.
fn stream_format(path: &Path) -> Result<Option<Format>, CommandError> {
    let Some(name) = path.to_str() else { return Ok(None) };
    let format = match name.strip_suffix(":-") {
        _ if name == "-" => None,
        Some(format) => picture_format(Path::new(&format!("picture.{format}"))).ok(),
        None => return Ok(None),
    };
    match format {
        Some(format) => Ok(Some(format)),
        None => {
            Err(CommandError::usage(format!("-o {name}: a picture on the standard output needs a format"))
                .with_help("choose one: -o png:-, exr:-, hdr:- or pfm:-"))
        }
    }
}

/// Whether the picture of this name goes to the standard output.
pub(crate) fn is_stream(path: &Path) -> bool {
    path.to_str().is_some_and(|name| name == "-" || name.ends_with(":-"))
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

    #[test]
    fn closed_pipes_hide_no_other_failure() {
        let closed = || CommandError { is_closed_pipe: true, ..CommandError::new("closed") };
        let full = || CommandError::new("a.exr: full").with_help("free some space");
        assert!(joined(Vec::new()).is_ok());
        assert!(joined(vec![closed()]).is_err_and(|failure| failure.is_closed_pipe));
        let both = joined(vec![closed(), full(), CommandError::new("b")]).unwrap_err();
        assert_eq!(
            (both.message.as_str(), both.help.as_deref()),
            ("a.exr: full\nb", Some("free some space"))
        );
        assert!(!both.is_closed_pipe);
    }

    #[test]
    fn standard_output_is_called_by_its_format() {
        let outputs = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            Outputs::try_new(&paths, Tone::default(), &mut FileUses::default(), Messages::new(true))
        };
        let picture = outputs(&["png:-"]).unwrap();
        assert_eq!((picture.stream, picture.files.len()), (Some(Format::Png), 0));
        assert_eq!((picture.names(), picture.keep_channels()), (vec![STANDARD_OUTPUT.to_owned()], false));
        assert!(outputs(&["EXR:-"]).unwrap().keep_channels());
        for wrong in [&["-"][..], &["jpg:-"], &[":-"], &["png:-", "exr:-"]] {
            assert!(outputs(wrong).is_err_and(|failure| failure.usage), "{wrong:?}");
        }
    }
}
