//! The Python package: built into a fresh virtual environment, and its tests.

use std::process::Command;
use std::time::Instant;

use crate::setup::{self, find_program, in_target};
use crate::suite::{Verdict, succeed};
use crate::workspace;

/// Names of Python, by preference.
const INTERPRETERS: [&str; 2] = ["python3", "python"];

/// Builds and installs the package, runs its tests and notebooks, and checks its types.
///
/// # Errors
/// The step that failed.
pub(crate) fn check() -> Result<String, String> {
    match verdict()? {
        Verdict::Passed(times) => Ok(format!("python: {times}")),
        Verdict::Skipped(why) => Err(why),
    }
}

/// The same as a part of `nightly`, which is skipped without Python.
///
/// # Errors
/// The step that failed.
pub(crate) fn verdict() -> Result<Verdict, String> {
    let Some(python) = INTERPRETERS.into_iter().find_map(find_program) else {
        return Ok(Verdict::Skipped("Python 3.10 or later is missing; install it".to_owned()));
    };
    let (folder, package) = (in_target("python"), workspace::root().join("python"));
    let program = |name: &str| {
        let (folder, name) = if cfg!(windows) {
            (folder.join("Scripts"), format!("{name}.exe"))
        } else {
            (folder.join("bin"), name.to_owned())
        };
        folder.join(name)
    };
    let mut times = Vec::new();
    let mut step = |name: &str, command: &mut Command| {
        println!("-- {name}");
        let begun = Instant::now();
        succeed(command, &format!("python: the step \"{name}\" failed, see above"))?;
        times.push(format!("{name} {:.0} s", begun.elapsed().as_secs_f64()));
        Ok::<_, String>(())
    };
    step("program", &mut setup::glanz_build())?;
    step("venv", Command::new(python).args(["-m", "venv", "--clear"]).arg(&folder))?;
    let interpreter = program("python");
    let mut pip = Command::new(&interpreter);
    pip.args(["-m", "pip", "install", "--quiet"]).arg(format!("{}[test,peers]", package.display()));
    step("pip install", &mut pip)?;
    // Outside the package's folder, so that the installed package is tested.
    let tests = |arguments: &[&str]| {
        let mut command = Command::new(&interpreter);
        command
            .args(arguments)
            .current_dir(&folder)
            .env("GLANZ_PROGRAM", setup::glanz_program())
            .env("MPLBACKEND", "Agg");
        command
    };
    let list = package.join("tests").display().to_string();
    step("pytest", &mut tests(&["-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", &list]))?;
    let mut types = Command::new(program("pyright"));
    types.arg("--pythonpath").arg(&interpreter).current_dir(&package);
    step("pyright", &mut types)?;
    Ok(Verdict::Passed(times.join(", ")))
}
