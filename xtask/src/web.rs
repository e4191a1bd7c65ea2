//! The code of the viewer's page: its types, its format, its tests that need no browser.

use std::fs;
use std::process::Command;
use std::time::SystemTime;

use crate::suite::succeed;
use crate::workspace;

/// The folder that npm works in, from the root.
pub(crate) const FOLDER: &str = "crates/glanz-viewer";

/// What npm runs, and what it means if that fails.
const SCRIPTS: [(&str, &str); 3] = [
    ("types", "the page's types do not fit together, see above"),
    ("format", "some files of the page are not formatted: npx prettier --write . in crates/glanz-viewer"),
    ("test", "tests of the page's code failed, see above"),
];

/// Checks the code of the page.
///
/// # Errors
/// A sentence for every check that fails.
pub(crate) fn check() -> Result<String, String> {
    let outcomes =
        SCRIPTS.map(|(script, otherwise)| succeed(&mut npm(&["run", "--silent", script]), otherwise));
    let faults: Vec<String> = outcomes.into_iter().filter_map(Result::err).collect();
    if faults.is_empty() { Ok(String::new()) } else { Err(faults.join("\n")) }
}

/// Whether npm has installed the packages of the present lock file.
pub(crate) fn packages_are_installed() -> bool {
    let folder = workspace::root().join(FOLDER);
    let changed = |file: &str| fs::metadata(folder.join(file)).and_then(|data| data.modified()).ok();
    // npm lists what it has installed in a file of its own.
    let installed: Option<SystemTime> = changed("node_modules/.package-lock.json");
    installed.is_some() && installed >= changed("package-lock.json")
}

/// npm in the folder of the page.
pub(crate) fn npm(arguments: &[&str]) -> Command {
    // On Windows it is a script of the command line.
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.current_dir(workspace::root().join(FOLDER)).args(arguments);
    command
}
