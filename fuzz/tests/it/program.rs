//! Faults of each kind, which the program has to find.

use super::{run, text};

/// Runs a target that fails on purpose; returns the output and the kept files.
fn found(target: &str) -> (String, Vec<Vec<u8>>) {
    let (output, keep) = run(target, &[target, "--cases", "400", "--jobs", "1"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let files = std::fs::read_dir(keep).unwrap().map(|file| file.unwrap());
    let files = files.filter(|file| !file.file_name().to_string_lossy().ends_with("slowest"));
    (text(&output), files.map(|file| std::fs::read(file.path()).unwrap()).collect())
}

#[test]
fn panics_are_found_and_their_files_made_small() {
    let (output, files) = found("faulty-panic");
    assert!(output.contains("self_test.rs:") && output.contains("on purpose"), "{output}");
    assert_eq!(files, [b"fault"]);
}

#[test]
fn large_peaks_of_memory_are_found() {
    let (output, files) = found("faulty-memory");
    assert!(output.contains("fault: 68.2 MB at the peak, of 67.1 MB"), "{output}");
    assert_eq!(files, [b"fault"]);
}

#[test]
fn exhausted_stacks_are_found_and_the_next_process_continues() {
    let (output, files) = found("faulty-stack");
    assert!(output.contains("fault: the process ended by"), "{output}");
    assert_eq!(files, [b"fault"]);
}

#[test]
fn process_that_ends_before_its_first_case_is_an_error_and_other_targets_have_their_reports() {
    let (output, _) = run("faulty-seeds", &["faulty-seeds", "mtl", "--cases", "100", "--jobs", "1"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("faulty-seeds: no case began"), "{}", text(&output));
    assert!(text(&output).contains("mtl               100 mutants"), "{}", text(&output));
}

#[test]
fn slow_files_are_found() {
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("slow");
    std::fs::write(&file, "fault").unwrap();
    let (output, _) = run("faulty-time", &["faulty-time", "--replay", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(text(&output).contains("slow: 1.1"), "{}", text(&output));
}

#[test]
fn targets_without_a_fault_pass() {
    let (output, keep) = run("mtl", &["mtl", "--cases", "300"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(text(&output).starts_with("mtl               300 mutants"), "{}", text(&output));
    assert!(keep.join("mtl.slowest").is_file());
}

#[test]
fn unknown_targets_are_refused_with_the_known_ones() {
    let (output, _) = run("unknown", &["ply", "plx"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("there is no target \"plx\", choose from pbrt, "), "{}", text(&output));
}
