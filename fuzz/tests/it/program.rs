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
fn processes_that_end_before_their_first_case_are_errors_with_reasons_and_other_targets_have_their_reports() {
    let targets = ["faulty-seeds", "faulty-start", "mtl", "--cases", "100", "--jobs", "1"];
    let (output, _) = run("faulty-seeds", &targets);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    let error = String::from_utf8_lossy(&output.stderr);
    let place = |line: &&str| line.starts_with("error: faulty-seeds: no case began: panic at ");
    assert!(error.lines().find(place).is_some_and(|line| line.ends_with(": on purpose")), "{error}");
    assert!(error.contains("error: faulty-start: no case began ("), "{error}");
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
fn files_that_cannot_be_read_have_the_reason() {
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("missing");
    let (output, _) = run("missing", &["mtl", "--replay", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.starts_with("error: ") && !error.contains("out of stack"), "{error}");
}

#[test]
#[cfg(unix)]
fn signals_end_a_run_with_the_report_so_far() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let keep = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("signal");
    let _ = std::fs::remove_dir_all(&keep);
    let mut command = Command::new(env!("CARGO_BIN_EXE_glanz-fuzz"));
    command.args(["mtl", "--seconds", "600", "--jobs", "1", "--keep"]).arg(&keep);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The program makes the folder after it has begun to listen to signals.
    let start = Instant::now();
    while !keep.is_dir() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));
    assert!(text(&output).starts_with("mtl "), "{}", text(&output));
    assert!(text(&output).contains("stopped by a signal"), "{}", text(&output));
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
