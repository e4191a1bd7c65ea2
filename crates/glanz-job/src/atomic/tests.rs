//! Files that are there as a whole or not at all.

use super::temporary::START;
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

#[test]
fn files_of_killed_processes_are_removed_and_no_others() {
    let folder = Folder::new("orphans");
    let path = |name: &str| folder.0.join(name);
    // Nobody has a lock on these two.
    let lock = format!("{START}{:032x}.lock", 7);
    for name in [".glanz-12-0.tmp", &lock] {
        fs::write(path(name), "left").unwrap();
    }
    let others = [
        "picture.exr",
        ".picture.exr.12-0.tmp",
        ".glanz-12.tmp",
        ".glanz-12-0.tmp.exr",
        ".glanz-a-0.tmp",
        ".glanz-7.lock",
    ];
    for name in others {
        fs::write(path(name), "of others").unwrap();
    }
    fs::create_dir(path(".glanz-13-0.tmp")).unwrap();
    let alive = TemporaryFile::create_beside(&path("new")).unwrap();
    let claim =
        CheckpointLock::acquire(&path("state")).unwrap().expect("locks in the folder of temporary files");
    remove_orphans(&folder.0);
    assert_eq!(folder.entries(), others.len() + 3);
    assert!(!path(".glanz-12-0.tmp").exists() && !path(&lock).exists());
    drop((alive, claim));
    assert_eq!(folder.entries(), others.len() + 1);
    // A folder that does not exist has no files.
    remove_orphans(&path("no"));
}

#[cfg(unix)]
#[test]
fn links_that_look_like_temporary_files_are_left_with_what_they_name() {
    let folder = Folder::new("orphan-links");
    let file = folder.0.join("file");
    fs::write(&file, "content").unwrap();
    std::os::unix::fs::symlink(&file, folder.0.join(".glanz-1-1.tmp")).unwrap();
    remove_orphans(&folder.0);
    assert_eq!(folder.entries(), 2);
}

#[test]
fn one_of_many_claims_of_a_checkpoint_succeeds() {
    let folder = Folder::new("claims");
    let state = folder.0.join("state");
    for round in 0..5 {
        let start = std::sync::Barrier::new(4);
        let claims: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4)
                .map(|_| {
                    scope.spawn(|| {
                        start.wait();
                        CheckpointLock::acquire(&state)
                    })
                })
                .collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!(claims.iter().filter(|claim| claim.is_ok()).count(), 1, "round {round}");
        let own = std::process::id();
        for error in claims.into_iter().filter_map(Result::err) {
            assert!(matches!(error, CheckpointLockError::Taken { process: Some(process) } if process == own));
        }
        assert_eq!(folder.entries(), 0, "the claim is dropped");
    }
}

#[test]
fn claim_survives_the_replacement_of_the_checkpoint() {
    let folder = Folder::new("claim-replaced");
    let state = folder.0.join("state");
    let claim = CheckpointLock::acquire(&state).unwrap();
    for content in ["1", "2"] {
        write_atomically(&state, content.as_bytes()).unwrap();
        assert!(CheckpointLock::acquire(&state).is_err());
        #[cfg(unix)]
        {
            let link = folder.0.join(format!("link-{content}"));
            std::os::unix::fs::symlink(&state, &link).unwrap();
            assert!(CheckpointLock::acquire(&link).is_err(), "another name of the same file");
        }
    }
    assert!(CheckpointLock::acquire(&folder.0.join("other")).is_ok_and(|other| other.is_some()));
    drop(claim);
    assert!(CheckpointLock::acquire(&state).is_ok());
    assert!(CheckpointLock::acquire(Path::new("/no such folder/state")).is_err());
    #[cfg(unix)]
    assert!(CheckpointLock::acquire(Path::new("/dev/null")).is_ok_and(|claim| claim.is_none()));
}

/// Root may write the files of all users, and finds the same.
#[cfg(unix)]
#[test]
fn lock_files_that_may_only_be_read_are_replaced_and_removed() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("lock-of-others");
    let state = folder.0.join("state");
    let claim = CheckpointLock::acquire(&state).unwrap();
    let lock = fs::read_dir(&folder.0).unwrap().next().unwrap().unwrap().path();
    let protect = || fs::set_permissions(&lock, fs::Permissions::from_mode(0o444)).unwrap();
    protect();
    assert!(matches!(CheckpointLock::acquire(&state), Err(CheckpointLockError::Taken { process: Some(_) })));
    remove_orphans(&folder.0);
    assert!(lock.exists());
    drop(claim);
    assert_eq!(folder.entries(), 0);
    fs::write(&lock, "1").unwrap();
    protect();
    assert!(CheckpointLock::acquire(&state).is_ok_and(|claim| claim.is_some()));
    assert_eq!(folder.entries(), 0);
    fs::write(&lock, "1").unwrap();
    protect();
    remove_orphans(&folder.0);
    assert_eq!(folder.entries(), 0);
}

#[test]
fn lock_errors_are_sentences() {
    let error = CheckpointLockError::Io(io::Error::from(io::ErrorKind::StorageFull));
    assert!(error.to_string().starts_with("cannot be locked: the disk is full ("), "{error}");
}
