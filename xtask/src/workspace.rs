//! Where the workspace is, what is in it, and how to run cargo there.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The root of the workspace: the folder above this crate's.
///
/// `cargo run` says where that is now; where it was built tells only what else runs the program.
pub(crate) fn root() -> &'static Path {
    static ROOT: OnceLock<PathBuf> = OnceLock::new();
    ROOT.get_or_init(|| {
        let built = || PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let own = std::env::var_os("CARGO_MANIFEST_DIR").map_or_else(built, PathBuf::from);
        own.parent().map_or_else(|| own.clone(), Path::to_owned)
    })
}

/// The cargo that runs this program, to be run with these arguments in the workspace root.
pub(crate) fn cargo<const N: usize>(arguments: [&str; N]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(arguments);
    command
}

/// All files below `folder` whose name ends with `.extension`, sorted; folders that cannot be read are empty.
pub(crate) fn files_below(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for entry in entries.flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
