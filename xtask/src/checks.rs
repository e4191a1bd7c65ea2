//! The checks of `cargo xtask test`.

use std::io::{BufRead, BufReader, IsTerminal, Write};
use std::process::{Command, ExitCode, Stdio};

use crate::setup::{Tool, Toolbox};
use crate::suite::{self, Check, Verdict, succeed};
use crate::{chromium, layers, references, web, words, workspace};

/// A check that needs tools.
struct Step {
    name: &'static str,
    needs: &'static [Tool],
    run: fn() -> Result<String, String>,
}

const STEPS: &[Step] = &[
    Step { name: "format", needs: &[Tool::Rustfmt], run: format },
    Step { name: "layers", needs: &[], run: layers::check },
    Step { name: "references", needs: &[], run: references::check },
    Step { name: "words", needs: &[], run: words::check },
    Step { name: "clippy", needs: &[Tool::Clippy], run: clippy },
    Step { name: "docs", needs: &[], run: docs },
    Step { name: "tests", needs: &[], run: tests },
    Step { name: "web", needs: &[Tool::Node, Tool::NodePackages], run: web::check },
    Step { name: "browser", needs: &[Tool::Chromium], run: browser },
];

/// Runs the steps of these names, or all if there are none. A step whose tools are neither there nor can be installed is skipped.
///
/// # Errors
/// A name that is no step.
pub(crate) fn test(names: &[&str]) -> Result<ExitCode, String> {
    if let Some(unknown) = names.iter().find(|name| STEPS.iter().all(|step| step.name != **name)) {
        let known: Vec<&str> = STEPS.iter().map(|step| step.name).collect();
        return Err(format!("there is no step \"{unknown}\", choose from {}", known.join(", ")));
    }
    let chosen: Vec<&Step> =
        STEPS.iter().filter(|step| names.is_empty() || names.contains(&step.name)).collect();
    let toolbox = Toolbox::prepare(chosen.iter().flat_map(|step| step.needs).copied());
    let checks: Vec<Check<'_>> = chosen
        .iter()
        .map(|step| Check {
            name: step.name,
            run: Box::new(|| match step.needs.iter().find_map(|tool| toolbox.missing(*tool)) {
                Some(why) => Ok(Verdict::Skipped(why)),
                None => (step.run)().map(Verdict::Passed),
            }),
        })
        .collect();
    Ok(suite::run("test", &checks))
}

fn format() -> Result<String, String> {
    let mut command = workspace::cargo(["fmt", "--all", "--check"]);
    succeed(&mut command, "some files are not formatted: cargo fmt --all").map(|()| String::new())
}

fn clippy() -> Result<String, String> {
    let mut command = workspace::cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]);
    succeed(&mut command, "clippy has complaints, see above").map(|()| String::new())
}

fn docs() -> Result<String, String> {
    let mut command = workspace::cargo(["doc", "--workspace", "--no-deps"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    succeed(&mut command, "the documentation has faults, see above").map(|()| String::new())
}

/// The beginning of the names of tests that drive a browser.
pub(crate) const BROWSER_TESTS: &str = "viewer::browser::";

/// Part of the names of tests that only the nightly run takes.
pub(crate) const HEAVY_TESTS: &str = "heavy::";

/// Runs all tests but those of the browser and the heavy ones, then the examples in the documentation.
fn tests() -> Result<String, String> {
    let tests = run_tests(all_tests().args(["--", "--skip", BROWSER_TESTS, "--skip", HEAVY_TESTS]));
    let documented = run_tests(&mut workspace::cargo(["test", "--workspace", "--no-fail-fast", "--doc"]));
    let counts = format!("{}; documentation: {}", text(&tests), text(&documented));
    if tests.is_ok() && documented.is_ok() { Ok(counts) } else { Err(counts) }
}

fn browser() -> Result<String, String> {
    run_tests(all_tests().args(["--", BROWSER_TESTS, "--skip", HEAVY_TESTS]))
}

/// Cargo with the unit and integration tests of the workspace, always of the same targets, so that nothing is built twice. Examples
/// are compiled by clippy only.
pub(crate) fn all_tests() -> Command {
    let mut command =
        workspace::cargo(["test", "--workspace", "--no-fail-fast", "--lib", "--bins", "--tests"]);
    if let Some(program) = chromium::find() {
        command.env("CHROMIUM", program);
    }
    command
}

fn text(result: &Result<String, String>) -> &str {
    match result {
        Ok(text) | Err(text) => text,
    }
}

/// Runs tests, prints their output as it comes, and counts them.
pub(crate) fn run_tests(command: &mut Command) -> Result<String, String> {
    command.stdout(Stdio::piped());
    if std::io::stdout().is_terminal() {
        command.env("CARGO_TERM_COLOR", "always");
    }
    let mut child = command.spawn().map_err(|error| format!("cargo: {error}"))?;
    let mut sum = [0; 3];
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).split(b'\n') {
            let line = line.map_err(|error| format!("output of the tests: {error}"))?;
            let line = String::from_utf8_lossy(&line);
            // A closed pipe behind us is no reason to stop testing.
            let _ = writeln!(std::io::stdout(), "{line}");
            if let Some(counts) = test_counts(&line) {
                sum = std::array::from_fn(|i| sum[i] + counts[i]);
            }
        }
    }
    let status = child.wait().map_err(|error| format!("cargo: {error}"))?;
    let [passed, failed, ignored] = sum;
    let ignored = if ignored > 0 { format!(", {ignored} left to nightly") } else { String::new() };
    let counts = format!("{passed} passed, {failed} failed{ignored}");
    if status.success() { Ok(counts) } else { Err(counts) }
}

/// The numbers of passed, failed and ignored tests in `test result: ok. 12 passed; 0 failed; 1 ignored; ...`.
fn test_counts(line: &str) -> Option<[u64; 3]> {
    let counts = line.strip_prefix("test result: ")?.split_once(". ")?.1;
    let mut numbers =
        counts.split("; ").map(|part| part.split_once(' ').map_or("", |(number, _)| number).parse());
    let mut next = || numbers.next()?.ok();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read_from_the_line_that_libtest_prints() {
        let line = "test result: FAILED. 12 passed; 3 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s";
        assert_eq!(test_counts(line), Some([12, 3, 1]));
        assert_eq!(test_counts("test a_fact ... ok"), None);
        assert_eq!(test_counts("12 passed; 3 failed; 0 ignored; printed by a test"), None);
    }
}
