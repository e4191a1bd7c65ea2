//! Files: checks before the work starts, reading, and atomic replacement.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use glanz_job::{CheckpointLock, WriteError};

use crate::error::{Error, FileFault};

/// Checks that the file `path` can be created or replaced, without changing it, and [removes](glanz_job::remove_orphans) what killed runs have left in its folder.
///
/// # Errors
/// [`Error::File`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    // A link stays, and the file that it names is replaced in the folder of that file. Devices are written directly; a dangling link is refused below.
    let named = fs::canonicalize(path).ok().filter(|named| path.is_symlink() && named.is_file());
    let file = named.as_deref().unwrap_or(path);
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(FileFault::NoFolder(folder.to_owned()).of(path));
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(FileFault::IsFolder.of(path)),
        Ok(found) if found.permissions().readonly() => return Err(FileFault::ReadOnly.of(path)),
        Err(error) if error.kind() != io::ErrorKind::NotFound || path.is_symlink() => {
            return Err(FileFault::NotWritable(error).of(path));
        }
        _ => {}
    }
    glanz_job::remove_orphans(folder);
    glanz_job::check_creatable(file).map_err(|error| FileFault::NotWritable(error).of(path))
}

/// Checks that the checkpoint `path` can be written without losing an existing one; `resume`: whether an existing one is resumed.
///
/// # Errors
/// [`Error::File`].
pub fn check_checkpoint(path: &Path, resume: bool) -> Result<(), Error> {
    check_writable(path)?;
    check_resumable(path, resume)
}

/// Refuses an existing checkpoint that is not resumed.
pub(crate) fn check_resumable(path: &Path, resume: bool) -> Result<(), Error> {
    if path.exists() && !resume { Err(FileFault::Exists.of(path)) } else { Ok(()) }
}

/// Claims the checkpoint `path` until the result is dropped, so that no other process writes it.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Lock`] if another process has it.
pub fn claim_checkpoint(path: &Path) -> Result<Option<CheckpointLock>, Error> {
    CheckpointLock::acquire(path).map_err(Error::of_file(path))
}

/// The files of a command, none of which may be used in two ways.
#[derive(Clone, Debug, Default)]
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
        match self.outputs.iter().find(|(other, _)| other.is_same(&identity)) {
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
        self.check_not_input(path)?;
        if self.outputs.iter().any(|(other, _)| other.is_same(&identity)) {
            return Err(FileFault::IsOutput.of(path));
        }
        self.outputs.push((identity, path.to_owned()));
        Ok(())
    }

    /// Refuses a file that is an input, for an output whose other names are not known yet.
    ///
    /// # Errors
    /// [`FileFault::IsInput`].
    pub fn check_not_input(&self, path: &Path) -> Result<(), Error> {
        let identity = FileIdentity::of(path);
        match identity.is_some_and(|identity| self.inputs.iter().any(|other| other.is_same(&identity))) {
            true => Err(FileFault::IsInput.of(path)),
            false => Ok(()),
        }
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

/// What a file is recognised by: its path without links, also where only its folder exists, and its place on the disk, which its hard links share.
#[derive(Clone, Debug)]
struct FileIdentity {
    path: PathBuf,
    /// Numbers of device and inode of an existing file; `None` where the system has none.
    place: Option<[u64; 2]>,
}

impl FileIdentity {
    /// `None` for devices and pipes, which may be used more than once, and for a file without a folder.
    fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) if !found.is_file() => None,
            Ok(found) => Some(Self { path: fs::canonicalize(path).ok()?, place: place(&found) }),
            Err(_) => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
                let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
                Some(Self { path: folder.join(path.file_name()?), place: None })
            }
        }
    }

    /// Whether both are one file. One of them may have been created since the other was looked up.
    fn is_same(&self, other: &Self) -> bool {
        self.path == other.path || self.place.is_some() && self.place == other.place
    }
}

#[cfg(unix)]
fn place(found: &fs::Metadata) -> Option<[u64; 2]> {
    use std::os::unix::fs::MetadataExt;
    Some([found.dev(), found.ino()])
}

#[cfg(not(unix))]
fn place(_: &fs::Metadata) -> Option<[u64; 2]> {
    None
}

/// Whether the file `path` is there and is no regular one, as a pipe or a device.
pub(crate) fn is_pipe(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
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

/// Creates the folder if it does not exist, and [removes](glanz_job::remove_orphans) what killed runs have left in it.
///
/// # Errors
/// [`Error::File`].
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    glanz_job::make_folder(folder).map_err(|error| FileFault::NotMade(error).of(folder))
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
            let left = folder.join("inner/.glanz-1-1.tmp");
            let [target, link] = ["inner/target", "link"].map(|name| folder.join(name));
            fs::write(&left, "left by a killed run").unwrap();
            fs::write(&target, "target").unwrap();
            std::os::unix::fs::symlink(&target, &link).unwrap();
            assert!(faults(&[(&link, false)])[0].is_none() && !left.exists(), "the folder of the file");
            assert!(FileIdentity::of(Path::new("/dev/null")).is_none());
            let hard = folder.join("hard");
            fs::hard_link(&scene, &hard).unwrap();
            assert!(matches!(faults(&[(&scene, true), (&hard, false)])[1], Some(FileFault::IsInput)));
            assert!(matches!(faults(&[(&hard, false), (&scene, false)])[1], Some(FileFault::IsOutput)));
            let long = folder.join("x".repeat(300));
            assert!(matches!(faults(&[(&long, false)])[0], Some(FileFault::NotWritable(_))));
        }
        // A file that is created later is still the same output.
        let mut files = FileUses::default();
        files.add_output(&new).unwrap();
        fs::write(&new, "new").unwrap();
        assert!(files.add_output(&new).is_err() && files.check_not_input(&new).is_ok());
        fs::remove_dir_all(&folder).unwrap();
    }
}
