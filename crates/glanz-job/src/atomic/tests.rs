//! Files that are there as a whole or not at all.

use super::*;

/// An empty folder, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glanz-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn entries(&self) -> usize {
        fs::read_dir(&self.0).unwrap().count()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn atomic_write_makes_and_replaces_a_file_and_leaves_nothing_else() {
    let folder = Folder::new("replace");
    let file = folder.0.join("picture.exr");
    write_atomically(&file, b"first").unwrap();
    write_atomically(&file, b"second").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"second");
    assert_eq!(folder.entries(), 1);
}

#[test]
fn content_that_fails_half_way_leaves_the_old_file_and_nothing_else() {
    let folder = Folder::new("half");
    let file = folder.0.join("state");
    write_atomically(&file, b"old").unwrap();
    let failed = write_atomically_with(&file, |out| {
        out.write_all(b"ne")?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    });
    assert_eq!(failed.unwrap_err().source.kind(), io::ErrorKind::StorageFull);
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert_eq!(folder.entries(), 1);
}

#[test]
fn atomic_write_into_a_missing_folder_or_over_a_folder_fails() {
    let folder = Folder::new("missing");
    assert!(matches!(write_atomically(&folder.0.join("no/file"), b"x"), Err(WriteError { .. })));
    fs::create_dir(folder.0.join("taken")).unwrap();
    assert!(write_atomically(&folder.0.join("taken"), b"x").is_err());
    assert_eq!(folder.entries(), 1);
}

#[cfg(unix)]
#[test]
fn atomic_write_keeps_permissions_and_links_and_respects_read_only_files() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::new("permissions");
    let (file, link) = (folder.0.join("file"), folder.0.join("link"));
    write_atomically(&file, b"old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("file", &link).unwrap();
    write_atomically(&link, b"new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o440)).unwrap();
    assert!(write_atomically(&file, b"newer").is_err());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(folder.entries(), 2);
}
