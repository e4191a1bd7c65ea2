//! Whether a folder of pbrt scenes loads.

use std::path::Path;

use crate::workspace;

/// Runs `glanz info` on every pbrt file below `folder` that is a scene of its own (one with a `WorldBegin`) and
/// prints one line each.
///
/// # Errors
/// How many scenes did not load, or why nothing could be tried.
pub(crate) fn load_all(folder: &Path) -> Result<String, String> {
    // The build runs in the workspace; the scenes are named relative to where the user stands.
    let build = workspace::cargo(["build", "--release", "--quiet", "--package", "glanz-cli"]).status();
    match build {
        Ok(status) if status.success() => {}
        Ok(_) => return Err("glanz does not build".to_owned()),
        Err(error) => return Err(format!("cargo: {error}")),
    }
    let (mut loaded, mut failed) = (0, 0);
    for file in workspace::files_below(folder, "pbrt") {
        let text = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        if !String::from_utf8_lossy(&text).contains("WorldBegin") {
            continue;
        }
        let file = file.canonicalize().map_err(|error| format!("{}: {error}", file.display()))?;
        let said = workspace::cargo(["run", "--release", "--quiet", "--package", "glanz-cli", "--", "info"])
            .arg(&file)
            .output()
            .map_err(|error| format!("cargo: {error}"))?;
        let warnings = String::from_utf8_lossy(&said.stderr);
        if said.status.success() {
            loaded += 1;
            let count = warnings.lines().filter(|line| line.starts_with("warning:")).count();
            println!("ok      {} ({count} warnings)", file.display());
        } else {
            failed += 1;
            println!("FAILED  {}\n{}", file.display(), warnings.trim_end());
        }
    }
    match (loaded, failed) {
        (0, 0) => Err(format!("{}: no pbrt scene found", folder.display())),
        (_, 0) => Ok(format!("scenes: {loaded} passed, 0 failed")),
        _ => Err(format!("{failed} of {} scenes do not load", loaded + failed)),
    }
}
