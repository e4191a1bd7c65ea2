//! Mutants of every target.

use super::{run, text};

/// Number of mutants of a reader; the nightly run has more.
fn cases() -> String {
    std::env::var("GLANZ_FUZZ_CASES").unwrap_or_else(|_| "1500".to_owned())
}

#[test]
fn mutants_end_in_a_value_or_an_error_within_the_limits() {
    let (output, keep) = run("mutants", &["--cases", &cases()]);
    println!("{}", text(&output));
    assert!(output.status.success(), "{}see {}", text(&output), keep.display());
}
