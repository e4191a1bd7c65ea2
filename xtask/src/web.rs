//! The code of the viewer's page: its types, its format, its tests that need no browser.

use std::process::Command;

use crate::steps::succeed;
use crate::workspace;

/// The folder that npm works in, from the root.
const FOLDER: &str = "crates/glanz-viewer";

/// What npm runs, and what it means if that fails.
const SCRIPTS: [(&str, &str); 3] = [
    ("types", "the page's types do not fit together, see above"),
    ("format", "some files of the page are not formatted: npx prettier --write . in crates/glanz-viewer"),
    ("test", "tests of the page's code failed, see above"),
];

/// Checks the code of the page.
///
/// # Errors
/// A sentence for every check that fails, or one that says what is missing to run them, and how to get it.
pub(crate) fn check() -> Result<String, String> {
    let there = npm().arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        return Err(
            "npm is missing: install Node.js 18 or later, for example apt-get install nodejs npm".to_owned()
        );
    }
    // npm lists what it has installed in this file.
    let installed = workspace::root().join(FOLDER).join("node_modules/.package-lock.json");
    if !installed.exists() {
        return Err(format!("the packages that check the page are missing: npm ci --prefix {FOLDER}"));
    }
    let outcomes =
        SCRIPTS.map(|(script, otherwise)| succeed(npm().args(["run", "--silent", script]), otherwise));
    let faults: Vec<String> = outcomes.into_iter().filter_map(Result::err).collect();
    if faults.is_empty() { Ok(String::new()) } else { Err(faults.join("\n")) }
}

/// npm in the folder of the page.
fn npm() -> Command {
    // On Windows it is a script of the command line.
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.current_dir(workspace::root().join(FOLDER));
    command
}
