//! Mutants of every target.

use std::process::Stdio;

use super::{run_with_errors, text};

#[test]
fn mutants_end_in_a_value_or_an_error_within_the_limits() {
    // The nightly run has more mutants, and takes hours: its progress is shown.
    let cases = std::env::var("GLANZ_FUZZ_CASES").ok();
    let errors = if cases.is_some() { Stdio::inherit() } else { Stdio::piped() };
    let (output, keep) = run_with_errors("mutants", &["--cases", cases.as_deref().unwrap_or("1500")], errors);
    println!("{}", text(&output));
    assert!(output.status.success(), "{}see {}", text(&output), keep.display());
}
