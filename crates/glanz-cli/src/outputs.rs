//! The files that a command writes: looked at before the work starts, written when it is done.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Format, write_atomically};
use glanz_light::{Pixels, Tone, ToneCurve};

use crate::arguments::ToneName;
use crate::messages::Failure;

/// Pictures to write, each in the format of its extension.
#[derive(Debug)]
pub(crate) struct Outputs {
    files: Vec<(PathBuf, Format)>,
    tone: Tone,
}

impl Outputs {
    /// Checks that each of `paths` has an extension Glanz writes and lies in a folder it can write to.
    ///
    /// # Errors
    /// What is wrong with the first path that cannot be written.
    pub(crate) fn try_new(paths: &[PathBuf], tone: Tone) -> Result<Self, Failure> {
        let mut files: Vec<(PathBuf, Format)> = Vec::new();
        for path in paths {
            let Some(format) = Format::from_path(path).filter(|format| is_written(*format)) else {
                return Err(Failure::usage(format!(
                    "{}: no picture format has this extension",
                    path.display()
                ))
                .with_help("the extension decides: .exr, .png, .hdr or .pfm"));
            };
            if files.iter().any(|(other, _)| other == path) {
                return Err(Failure::usage(format!("{}: named twice as output", path.display())));
            }
            check_writable(path)?;
            files.push((path.clone(), format));
        }
        Ok(Self { files, tone })
    }

    /// Whether any of the files keeps channels beside the colour.
    pub(crate) fn keep_channels(&self) -> bool {
        self.files.iter().any(|(_, format)| *format == Format::Exr)
    }

    /// The names of the files, as given.
    pub(crate) fn names(&self) -> Vec<String> {
        self.files.iter().map(|(path, _)| path.display().to_string()).collect()
    }

    /// Writes `pixels` to every file, also if one of them fails.
    ///
    /// # Errors
    /// What went wrong, one line per file that is not written.
    pub(crate) fn write(
        &self,
        pixels: &Pixels,
        attributes: &BTreeMap<String, String>,
    ) -> Result<(), Failure> {
        let failures: Vec<String> = self
            .files
            .iter()
            .filter_map(|(path, format)| {
                let bytes = image::write(pixels, *format, &self.tone, attributes);
                match bytes {
                    Ok(bytes) => write_atomically(path, &bytes).err().map(|error| error.to_string()),
                    Err(error) => Some(format!("{}: {error}", path.display())),
                }
            })
            .collect();
        if failures.is_empty() { Ok(()) } else { Err(Failure::new(failures.join("\n"))) }
    }
}

fn is_written(format: Format) -> bool {
    matches!(format, Format::Exr | Format::Png | Format::Hdr | Format::Pfm)
}

/// Exposure and curve as the command line names them.
pub(crate) fn tone(exposure_stops: f32, name: ToneName) -> Tone {
    let curve = match name {
        ToneName::Linear => ToneCurve::Linear,
        ToneName::Reinhard => ToneCurve::Reinhard,
        ToneName::Filmic => ToneCurve::Filmic,
    };
    Tone { exposure_stops, curve }
}

/// Where the picture of `scene` goes if the command line does not say: under the film's file name, in the current
/// folder, as EXR if the name's format is not written.
pub(crate) fn default_path(film_name: Option<&str>, scene: &Path) -> PathBuf {
    let named = film_name.map(Path::new).and_then(Path::file_name).or(scene.file_name());
    let path = named.map_or_else(|| PathBuf::from("picture"), PathBuf::from);
    if Format::from_path(&path).is_some_and(is_written) { path } else { path.with_extension("exr") }
}

/// Whether a file `path` can be made or replaced, found out without touching it.
///
/// # Errors
/// Why not.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    let refused =
        |error: &std::io::Error| Failure::new(format!("{}: cannot be written: {error}", path.display()));
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Failure::new(format!("{}: there is no folder {}", path.display(), folder.display()))
            .with_help("make the folder first, or name another"));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            return Err(Failure::new(format!("{}: this is a folder, not a file", path.display())));
        }
        Ok(found) if found.permissions().readonly() => {
            return Err(Failure::new(format!("{}: this file is write-protected", path.display())));
        }
        _ => {}
    }
    // Permissions alone do not tell (read-only file systems, access lists): try it, under a name of our own.
    let probe = folder.join(format!(".glanz-{}.tmp", std::process::id()));
    File::create(&probe).map_err(|error| refused(&error))?;
    fs::remove_file(&probe).map_err(|error| refused(&error))
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
            Outputs::try_new(&paths, Tone::default()).map(|_| ()).map_err(|failure| failure.usage)
        };
        assert_eq!(outputs(&["a.exr", "a.png", "a.hdr"]), Ok(()));
        assert_eq!(outputs(&["a.tiff"]), Err(true));
        assert_eq!(outputs(&["a"]), Err(true));
        assert_eq!(outputs(&["a.jpg"]), Err(true));
        assert_eq!(outputs(&["a.exr", "a.exr"]), Err(true));
        assert_eq!(outputs(&["no such folder/a.exr"]), Err(false));
    }
}
