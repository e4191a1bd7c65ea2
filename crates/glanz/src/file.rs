//! Files: checks before the work starts, reading, and atomic replacement.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use glanz_job::WriteError;

use crate::error::{Error, FileFault};

/// Checks that the file `path` can be created or replaced, without changing it.
///
/// # Errors
/// [`Error::File`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(FileFault::NoFolder(folder.to_owned()).of(path));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(FileFault::IsFolder.of(path)),
        Ok(found) if found.permissions().readonly() => return Err(FileFault::ReadOnly.of(path)),
        Err(error) if path.is_symlink() => return Err(FileFault::NotWritable(error).of(path)),
        _ => {}
    }
    // Permissions alone do not suffice (read-only file systems, access lists): a file with a unique name is created as a test.
    let probe = folder.join(format!(".glanz-{}.tmp", std::process::id()));
    File::create(&probe)
        .and_then(|_| fs::remove_file(&probe))
        .map_err(|error| FileFault::NotWritable(error).of(path))
}

/// Checks that the checkpoint `path` can be written without losing an existing one; `resume`: whether an existing one is resumed.
///
/// # Errors
/// [`Error::File`].
pub fn check_checkpoint(path: &Path, resume: bool) -> Result<(), Error> {
    check_writable(path)?;
    if path.exists() && !resume { Err(FileFault::Exists.of(path)) } else { Ok(()) }
}

/// The files of a command, none of which may be used in two ways.
#[derive(Debug, Default)]
pub struct FileUses {
    inputs: Vec<FileIdentity>,
    outputs: Vec<(FileIdentity, PathBuf)>,
}

impl FileUses {
    /// Adds a file that is read. Devices and pipes are no files here.
    ///
    /// # Errors
    /// [`FileFault::IsInput`] if it is an output, also by another name or link.
    pub fn add_input(&mut self, path: &Path) -> Result<(), Error> {
        let Some(identity) = FileIdentity::of(path) else { return Ok(()) };
        match self.outputs.iter().find(|(other, _)| *other == identity) {
            Some((_, output)) => Err(FileFault::IsInput.of(output)),
            None => {
                self.inputs.push(identity);
                Ok(())
            }
        }
    }

    /// Adds files that are read.
    ///
    /// # Errors
    /// That of [`FileUses::add_input`].
    pub fn add_inputs<P: AsRef<Path>>(&mut self, paths: impl IntoIterator<Item = P>) -> Result<(), Error> {
        paths.into_iter().try_for_each(|path| self.add_input(path.as_ref()))
    }

    /// Adds a file that is written, and checks that it can be created or replaced, without changing it.
    ///
    /// # Errors
    /// Those of [`check_writable`] and [`FileUses::add_result`].
    pub fn add_output(&mut self, path: &Path) -> Result<(), Error> {
        check_writable(path)?;
        self.add_result(path)
    }

    /// Adds a file that is written in a folder that may still have to be made.
    ///
    /// # Errors
    /// [`FileFault::IsInput`] and [`FileFault::IsOutput`] for a file that is used already, also by another name or link.
    pub fn add_result(&mut self, path: &Path) -> Result<(), Error> {
        let Some(identity) = FileIdentity::of(path) else { return Ok(()) };
        if self.inputs.contains(&identity) {
            return Err(FileFault::IsInput.of(path));
        }
        if self.outputs.iter().any(|(other, _)| *other == identity) {
            return Err(FileFault::IsOutput.of(path));
        }
        self.outputs.push((identity, path.to_owned()));
        Ok(())
    }

    /// Adds a checkpoint; `resume`: whether an existing one is resumed.
    ///
    /// # Errors
    /// Those of [`FileUses::add_output`], and [`FileFault::Exists`] for an existing one that is not to be resumed.
    pub fn add_checkpoint(&mut self, path: &Path, resume: bool) -> Result<(), Error> {
        check_checkpoint(path, resume)?;
        self.add_result(path)
    }
}

/// A path by which a file is recognised: without links, also where only its folder exists. Files are replaced as a whole, so that another hard
/// link keeps its content.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FileIdentity(PathBuf);

impl FileIdentity {
    /// `None` for devices and pipes, which may be used more than once, and for a file without a folder.
    fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) if !found.is_file() => None,
            Ok(_) => fs::canonicalize(path).ok().map(Self),
            Err(_) => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
                let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
                Some(Self(folder.join(path.file_name()?)))
            }
        }
    }
}

/// Whether the file `path` is there and is no regular one, as a pipe or a device.
pub(crate) fn is_pipe(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file())
}

/// The bytes of the file `path`.
///
/// # Errors
/// [`Error::File`].
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(Error::of_file(path))
}

/// Writes `bytes` to the file `path`, which keeps its old content until all bytes are written.
///
/// # Errors
/// [`Error::File`].
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_with(path, |out| out.write_all(bytes))
}

/// As [`write()`], of bytes that `content` writes, in blocks.
///
/// # Errors
/// [`Error::File`].
pub fn write_with(
    path: &Path,
    content: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
) -> Result<(), Error> {
    write_file_with(path, |file| content(file))
}

/// As [`write_with`], where `content` may return to earlier bytes.
///
/// # Errors
/// [`Error::File`].
pub(crate) fn write_file_with(
    path: &Path,
    content: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), Error> {
    let written = glanz_job::write_file_atomically(path, content);
    written.map_err(|WriteError { path, source }| FileFault::Io(source).of(&path))
}

/// Creates the folder if it does not exist.
///
/// # Errors
/// [`Error::File`].
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|error| FileFault::NotMade(error).of(folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The faults of files that are added as inputs (true) or outputs, in this order.
    fn faults(uses: &[(&Path, bool)]) -> Vec<Option<FileFault>> {
        let mut files = FileUses::default();
        let added = uses.iter().map(|(path, is_input)| match is_input {
            true => files.add_input(path),
            false => files.add_output(path),
        });
        added
            .map(|added| match added {
                Err(Error::File { fault, .. }) => Some(fault),
                Err(other) => panic!("{other}"),
                Ok(()) => None,
            })
            .collect()
    }

    #[test]
    fn files_used_in_two_ways_are_refused_by_any_name() {
        let folder = std::env::temp_dir().join(format!("glanz-file-uses-{}", std::process::id()));
        fs::create_dir_all(folder.join("inner")).unwrap();
        let [scene, other, new] = ["scene", "other", "new"].map(|name| folder.join(name));
        fs::write(&scene, "scene").unwrap();
        fs::write(&other, "other").unwrap();
        let around = folder.join("inner/../new");
        // Reading twice is no fault, nor is writing two files.
        assert!(
            faults(&[(&scene, true), (&scene, true), (&other, false), (&new, false)])
                .iter()
                .all(Option::is_none)
        );
        assert!(matches!(faults(&[(&scene, true), (&scene, false)])[1], Some(FileFault::IsInput)));
        assert!(matches!(faults(&[(&other, false), (&other, true)])[1], Some(FileFault::IsInput)));
        assert!(matches!(faults(&[(&other, false), (&other, false)])[1], Some(FileFault::IsOutput)));
        assert!(matches!(faults(&[(&new, false), (&around, false)])[1], Some(FileFault::IsOutput)));
        #[cfg(unix)]
        {
            let [soft, dangling] = ["soft", "dangling"].map(|name| folder.join(name));
            std::os::unix::fs::symlink(&scene, &soft).unwrap();
            assert!(matches!(faults(&[(&scene, true), (&soft, false)])[1], Some(FileFault::IsInput)));
            std::os::unix::fs::symlink(folder.join("missing"), &dangling).unwrap();
            assert!(matches!(faults(&[(&dangling, false)])[0], Some(FileFault::NotWritable(_))));
            assert_eq!(FileIdentity::of(Path::new("/dev/null")), None);
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
