//! The checks that run programs, and the test run that strings all checks together.

use std::io::{BufRead, BufReader, IsTerminal, Write};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use crate::{layers, references, web, workspace};

/// What became of a step of the test run.
struct Outcome {
    name: &'static str,
    passed: bool,
    took: Duration,
    /// A figure worth a word in the summary.
    remark: String,
}

type Step = (&'static str, fn() -> Result<String, String>);

const STEPS: &[Step] = &[
    ("format", format),
    ("clippy", clippy),
    ("layers", || layers::check().map_err(|breaches| breaches.join("\n"))),
    ("references", || references::check().map_err(|missing| missing.join("\n"))),
    ("web", web::check),
    ("docs", docs),
    ("browser", browser),
    ("tests", tests),
];

/// Runs the steps of these names, or all if there are none, also after one has failed; the summary stands last.
///
/// # Errors
/// A name that is no step.
pub(crate) fn test(names: &[&str]) -> Result<ExitCode, String> {
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|(step, _)| step != *name)) {
        let known: Vec<&str> = STEPS.iter().map(|(step, _)| *step).collect();
        return Err(format!("there is no step \"{unknown}\", choose from {}", known.join(", ")));
    }
    let chosen = STEPS.iter().filter(|(step, _)| names.is_empty() || names.contains(step));
    let outcomes: Vec<Outcome> = chosen.map(run).collect();
    println!();
    for outcome in &outcomes {
        let verdict = if outcome.passed { "passed" } else { "FAILED" };
        println!("{:<10} {verdict} {:>7.1} s  {}", outcome.name, outcome.took.as_secs_f64(), outcome.remark);
    }
    let passed = outcomes.iter().filter(|outcome| outcome.passed).count();
    let failed = outcomes.len() - passed;
    println!("test: {passed} passed, {failed} failed");
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn run(&(name, step): &Step) -> Outcome {
    println!("== {name}");
    let start = Instant::now();
    let result = step();
    let took = start.elapsed();
    match result {
        Ok(remark) => Outcome { name, passed: true, took, remark },
        Err(why) => {
            println!("{why}");
            let remark = why.lines().next().unwrap_or_default().to_owned();
            Outcome { name, passed: false, took, remark }
        }
    }
}

fn format() -> Result<String, String> {
    ensure_component("rustfmt", "fmt")?;
    succeed(
        workspace::cargo().args(["fmt", "--all", "--check"]),
        "some files are not formatted: cargo fmt --all",
    )
}

fn clippy() -> Result<String, String> {
    ensure_component("clippy", "clippy")?;
    let mut command = workspace::cargo();
    command.args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]);
    succeed(&mut command, "clippy has complaints, see above")
}

fn docs() -> Result<String, String> {
    let mut command = workspace::cargo();
    command.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    succeed(&mut command, "the documentation has faults, see above")
}

/// Whether there is a browser for the tests of the viewer, and which.
fn browser() -> Result<String, String> {
    // The names that the tests look for.
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let chosen = std::env::var("CHROMIUM");
    let programs = chosen.as_deref().map_or(names.to_vec(), |chosen| vec![chosen]);
    let version = programs.iter().find_map(|program| Command::new(program).arg("--version").output().ok());
    match version {
        Some(said) if said.status.success() => Ok(String::from_utf8_lossy(&said.stdout).trim().to_owned()),
        _ => Err("Chromium is missing, which tests of the viewer drive: apt-get install chromium, or name one in CHROMIUM"
            .to_owned()),
    }
}

/// Runs all tests, those in documentation too, shows what they print as it comes, and counts them.
fn tests() -> Result<String, String> {
    let mut command = workspace::cargo();
    command.args(["test", "--workspace", "--no-fail-fast"]).stdout(Stdio::piped());
    if std::io::stdout().is_terminal() {
        command.env("CARGO_TERM_COLOR", "always");
    }
    let mut child = command.spawn().map_err(|error| format!("cargo: {error}"))?;
    let (mut passed, mut failed) = (0, 0);
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).split(b'\n') {
            let line = line.map_err(|error| format!("output of the tests: {error}"))?;
            let line = String::from_utf8_lossy(&line);
            // A closed pipe behind us is no reason to stop testing.
            let _ = writeln!(std::io::stdout(), "{line}");
            if let Some((p, f)) = test_counts(&line) {
                passed += p;
                failed += f;
            }
        }
    }
    let status = child.wait().map_err(|error| format!("cargo: {error}"))?;
    let counts = format!("{passed} tests passed, {failed} failed");
    if status.success() { Ok(counts) } else { Err(counts) }
}

/// The numbers in `test result: ok. 12 passed; 0 failed; ...`.
fn test_counts(line: &str) -> Option<(u64, u64)> {
    let number_before =
        |word| line.split(word).next()?.rsplit([' ', ';']).find(|w| !w.is_empty())?.parse().ok();
    line.starts_with("test result:").then_some(())?;
    Some((number_before(" passed;")?, number_before(" failed;")?))
}

/// The surface contract with `rays` random rays per kind of surface.
///
/// # Errors
/// A sentence if it is broken or cannot be run.
pub(crate) fn contract(rays: u64) -> Result<String, String> {
    let mut command = optimised_test("contract::");
    succeed(
        command.env("GLANZ_CONTRACT_RAYS", rays.to_string()),
        "the surface contract is broken, see above",
    )?;
    Ok(format!("contract: kept by every surface over {rays} rays per kind"))
}

/// The zoo of patches with `rays` random and `adversarial` hard rays, and the bicubic patches of these files.
///
/// # Errors
/// A sentence if a root is missed, doubled or invented, or if it cannot be run.
pub(crate) fn zoo(rays: u64, adversarial: u64, patches: &[&str]) -> Result<String, String> {
    let mut paths = Vec::new();
    for file in patches {
        // The test runs in the folder of its crate.
        let path = std::path::absolute(file).map_err(|error| format!("{file}: {error}"))?;
        paths.push(path.display().to_string());
    }
    let mut command = optimised_test("zoo::");
    command.env("GLANZ_ZOO_RAYS", rays.to_string());
    command.env("GLANZ_ZOO_ADVERSARIAL", adversarial.to_string());
    command.env("GLANZ_ZOO_PATCHES", paths.join(":"));
    succeed(&mut command, "the zoo has faults, see above")?;
    Ok(format!("zoo: no root missed, doubled or invented in {rays} random and {adversarial} hard rays"))
}

/// The seam of two trimmed faces with `rays` rays across it.
///
/// # Errors
/// A sentence if one slips through, or if it cannot be run.
pub(crate) fn seam(rays: u64) -> Result<String, String> {
    let mut command = optimised_test("seam::");
    succeed(command.env("GLANZ_SEAM_RAYS", rays.to_string()), "the seam has gaps, see above")?;
    Ok(format!("seam: none of {rays} rays slips through"))
}

/// `guided` and `light` against `path` in all scenes with so many samples of each pixel.
///
/// # Errors
/// A sentence if pictures differ, or if it cannot be run.
pub(crate) fn unbiased(samples: u32) -> Result<String, String> {
    let mut command = optimised_test_of("glanz-study", "unbiased::");
    command.env("GLANZ_UNBIASED_SAMPLES", samples.to_string());
    succeed(&mut command, "pictures are not those of path, see above")?;
    Ok(format!(
        "unbiased: guided pictures and those of light are those of path at {samples} samples per pixel"
    ))
}

/// Light maps against path tracing at so many points with so many paths each.
///
/// # Errors
/// A sentence if they are too far apart, or if it cannot be run.
pub(crate) fn bake([points, samples]: [u32; 2]) -> Result<String, String> {
    let mut command = optimised_test_of("glanz-cli", "bake_reference::");
    command.env("GLANZ_BAKE_POINTS", points.to_string()).env("GLANZ_BAKE_SAMPLES", samples.to_string());
    succeed(&mut command, "light maps are not what path tracing finds, see above")?;
    Ok(format!("bake: light maps are what path tracing finds at {points} points with {samples} paths each"))
}

/// Pages that come and go for so many seconds.
///
/// # Errors
/// A sentence if the server dies, keeps something or puts up with mischief, or if it cannot be run.
pub(crate) fn soak([pages, seconds]: [u32; 2]) -> Result<String, String> {
    let mut command = optimised_test_of("glanz-cli", "pages_that_come_and_go_leave_nothing_behind");
    command.env("GLANZ_SOAK_PAGES", pages.to_string()).env("GLANZ_SOAK_SECONDS", seconds.to_string());
    succeed(&mut command, "the viewer's server does not get over it, see above")?;
    Ok(format!("soak: {pages} pages came and went for {seconds} s and left nothing behind"))
}

/// The integration tests of the surfaces whose names contain `filter`, optimised.
fn optimised_test(filter: &str) -> Command {
    optimised_test_of("glanz-geometry", filter)
}

/// The same of any package.
fn optimised_test_of(package: &str, filter: &str) -> Command {
    let mut command = workspace::cargo();
    command.args(["test", "--release", "--package", package, "--test", "it", filter, "--", "--nocapture"]);
    command
}

/// Runs a command that says itself what is wrong.
///
/// # Errors
/// `otherwise` if it fails, the system's words if it cannot be run.
pub(crate) fn succeed(command: &mut Command, otherwise: &str) -> Result<String, String> {
    match command.status() {
        Ok(status) if status.success() => Ok(String::new()),
        Ok(_) => Err(otherwise.to_owned()),
        Err(error) => Err(format!("{}: {error}", command.get_program().to_string_lossy())),
    }
}

/// Has rustup install a component of the toolchain if cargo lacks its subcommand.
fn ensure_component(component: &str, subcommand: &str) -> Result<(), String> {
    let there = workspace::cargo().args([subcommand, "--version"]).output().is_ok_and(|o| o.status.success());
    if there {
        return Ok(());
    }
    let mut rustup = Command::new("rustup");
    rustup.current_dir(workspace::root()).args(["component", "add", component]);
    succeed(&mut rustup, "it could not be added")
        .map(|_| ())
        .map_err(|why| format!("{component} is missing, and rustup cannot add it: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read_from_the_line_that_libtest_prints() {
        let line = "test result: FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s";
        assert_eq!(test_counts(line), Some((12, 3)));
        assert_eq!(test_counts("test a_fact ... ok"), None);
        assert_eq!(test_counts("12 passed; 3 failed; said by a test"), None);
    }
}
