//! Reloads a scene when one of its files changes.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use tokio::task::spawn_blocking;
use tokio::time::sleep;

use super::SceneUpdate;
use super::state::{AppState, ServedDesign};
use super::viewer_scene::{ViewerScene, refusal};

/// Interval between snapshots of the files.
const INTERVAL: Duration = Duration::from_millis(500);

/// When each file was last written, and its length; `None` where there is none.
type Snapshot = Vec<Option<(SystemTime, u64)>>;

fn snapshot(paths: &[PathBuf]) -> Snapshot {
    let stamp = |path: &PathBuf| {
        let found = std::fs::metadata(path).ok()?;
        Some((found.modified().ok()?, found.len()))
    };
    paths.iter().map(stamp).collect()
}

/// Decides when to read: when the files differ from those read and were equal in two snapshots, because programs write in pieces.
#[derive(Debug)]
struct ChangeDebouncer {
    read: Snapshot,
    seen: Snapshot,
}

impl ChangeDebouncer {
    fn new(read: Snapshot) -> Self {
        Self { seen: read.clone(), read }
    }

    /// Records a snapshot and returns true if it is time to read.
    fn observe(&mut self, now: Snapshot) -> bool {
        let is_time = now != self.read && now == self.seen;
        if is_time {
            self.read.clone_from(&now);
        }
        self.seen = now;
        is_time
    }
}

/// Polls the files of a design until the task is aborted; reports to the pages when it was read again, or why it cannot be.
pub(crate) async fn watch(app: Arc<AppState>, number: usize) {
    let Some(design) = app.designs.get(number) else { return };
    let mut paths = design.published().viewer_scene.paths.clone();
    let mut debouncer = ChangeDebouncer::new(snapshot(&paths));
    loop {
        sleep(INTERVAL).await;
        if !debouncer.observe(snapshot(&paths)) {
            continue;
        }
        let update = read(&app, number, design).await;
        if let SceneUpdate::Reloaded(viewer_scene) = &update {
            let same = viewer_scene.paths() == paths;
            if !same {
                paths = viewer_scene.paths().to_vec();
                debouncer = ChangeDebouncer::new(snapshot(&paths));
            }
        }
        app.publish(number, update);
    }
}

/// Reads a design within the memory that the other one leaves.
async fn read(app: &AppState, number: usize, design: &ServedDesign) -> SceneUpdate {
    let others = app.designs.iter().enumerate().filter(|(other, _)| *other != number);
    let others: u64 = others.map(|(_, other)| other.published().viewer_scene.memory()).sum();
    let (path, options, overlay) = (design.path.clone(), app.options.clone(), design.overlay.clone());
    let read = move || ViewerScene::read_beside(&path, &options, overlay.as_deref(), others);
    match spawn_blocking(read).await {
        Ok(Ok(viewer_scene)) => SceneUpdate::Reloaded(Arc::new(viewer_scene)),
        Ok(Err(diagnostics)) => SceneUpdate::Refused(diagnostics),
        Err(error) => SceneUpdate::Refused(refusal(&design.path.display().to_string(), error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_when_they_have_changed_and_settled() {
        let at = |second: u64| vec![Some((SystemTime::UNIX_EPOCH + Duration::from_secs(second), 1))];
        let mut debouncer = ChangeDebouncer::new(at(1));
        let looks = [at(1), at(2), at(3), at(3), at(3), vec![None], vec![None], at(3), at(3)];
        let read = looks.map(|now| debouncer.observe(now));
        assert_eq!(read, [false, false, false, true, false, false, true, false, true]);
    }

    #[test]
    fn a_file_that_goes_or_grows_has_changed() {
        let folder = tempfile::TempDir::new().unwrap();
        let paths = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&paths[0], "x").unwrap();
        let first = snapshot(&paths);
        assert!(first[0].is_some() && first[1].is_none());
        std::fs::write(&paths[0], "xy").unwrap();
        let second = snapshot(&paths);
        assert_ne!(first, second);
        std::fs::remove_file(&paths[0]).unwrap();
        assert_eq!(snapshot(&paths), [None, None]);
    }
}
