//! Files that were read wrongly once, and files that are.

use std::path::{Path, PathBuf};

/// A file of the corpus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CorpusEntry {
    /// Name of its target, and its own below the folder of that.
    pub name: String,
    /// The file to read. An entry of several files is a folder with one named `scene` and any extension.
    pub file: PathBuf,
    /// Whether other files belong to it.
    pub is_folder: bool,
}

/// The folder of this package.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The entries of a target, by name. Those of a target without a folder are none.
#[must_use]
pub fn entries(target: &str) -> Vec<CorpusEntry> {
    of_folder(&root().join("corpus"), target)
}

/// The entries of a target whose faults are known and not yet mended.
#[must_use]
pub fn pending(target: &str) -> Vec<CorpusEntry> {
    of_folder(&root().join("pending"), target)
}

/// Whether a file is the scene of an entry that is a folder.
#[must_use]
pub fn is_scene_of_folder(target: &str, file: &Path) -> bool {
    let is_same = |entry: &CorpusEntry| {
        let [own, other] = [entry.file.as_path(), file].map(std::fs::canonicalize);
        own.is_ok_and(|own| other.is_ok_and(|other| own == other))
    };
    entries(target).iter().chain(&pending(target)).any(|entry| entry.is_folder && is_same(entry))
}

fn of_folder(folder: &Path, target: &str) -> Vec<CorpusEntry> {
    let mut entries: Vec<CorpusEntry> = files(&folder.join(target))
        .into_iter()
        .filter_map(|path| {
            let name = format!("{target}/{}", path.file_name()?.to_string_lossy());
            let is_folder = path.is_dir();
            let scene =
                || files(&path).into_iter().find(|file| file.file_stem().is_some_and(|stem| stem == "scene"));
            let file = if is_folder { scene()? } else { path };
            Some(CorpusEntry { name, file, is_folder })
        })
        .collect();
    entries.sort_by(|a, b| a.name.cmp(&b.name));
    entries
}

/// What is in a folder, if there is one.
fn files(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_folders_of_the_corpus_have_scenes() {
        let folders: Vec<CorpusEntry> = entries("pbrt").into_iter().filter(|entry| entry.is_folder).collect();
        assert!(!folders.is_empty());
        assert!(folders.iter().all(|entry| is_scene_of_folder("pbrt", &entry.file)));
        assert!(folders.iter().all(|entry| !is_scene_of_folder("render", &entry.file)));
        assert!(!is_scene_of_folder("pbrt", Path::new("scene.pbrt")));
    }
}
