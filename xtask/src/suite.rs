//! A list of checks that are run one after another, and the table of their results.

use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

/// The result of a check that did not fail.
pub(crate) enum Verdict {
    /// It holds; a figure for the table, or nothing.
    Passed(String),
    /// It could not be run: the reason.
    Skipped(String),
}

/// A check with its name in the table. A failure is a text whose first line goes into the table.
pub(crate) struct Check<'a> {
    pub(crate) name: &'static str,
    pub(crate) run: Box<dyn Fn() -> Result<Verdict, String> + 'a>,
}

/// A row of the table.
struct CheckResult {
    name: &'static str,
    verdict: &'static str,
    took: Duration,
    remark: String,
}

/// Runs every check, also after one has failed, and prints the table last.
pub(crate) fn run(title: &str, checks: &[Check<'_>]) -> ExitCode {
    let start = Instant::now();
    let results: Vec<CheckResult> = checks.iter().map(run_check).collect();
    println!();
    for CheckResult { name, verdict, took, remark } in &results {
        println!("{}", format!("{name:<10} {verdict:<7} {:>7.1} s  {remark}", took.as_secs_f64()).trim_end());
    }
    println!("{:<18} {:>7.1} s", "total", start.elapsed().as_secs_f64());
    let count = |verdict| results.iter().filter(|result| result.verdict == verdict).count();
    let (failed, skipped) = (count(FAILED), count(SKIPPED));
    let skips = if skipped > 0 { format!(", {skipped} skipped") } else { String::new() };
    println!("{title}: {} passed, {failed} failed{skips}", count(PASSED));
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

const PASSED: &str = "passed";
const FAILED: &str = "FAILED";
const SKIPPED: &str = "skipped";

fn run_check(Check { name, run }: &Check<'_>) -> CheckResult {
    println!("== {name}");
    let start = Instant::now();
    let result = run();
    let took = start.elapsed();
    let (verdict, remark) = match result {
        Ok(Verdict::Passed(remark)) => (PASSED, remark),
        Ok(Verdict::Skipped(why)) => {
            println!("skipped: {why}");
            (SKIPPED, why)
        }
        Err(why) => {
            println!("{why}");
            (FAILED, why.lines().next().unwrap_or_default().to_owned())
        }
    };
    CheckResult { name, verdict, took, remark }
}

/// Runs a command that reports its own faults.
///
/// # Errors
/// `otherwise` if it fails, the system's message if it cannot be run.
pub(crate) fn succeed(command: &mut Command, otherwise: &str) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(otherwise.to_owned()),
        Err(error) => Err(format!("{}: {error}", command.get_program().to_string_lossy())),
    }
}
