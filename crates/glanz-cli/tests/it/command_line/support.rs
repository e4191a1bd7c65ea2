//! A temporary folder for each test, and runs of the program in it.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use glanz_formats::image;
use glanz_light::Pixels;
use tempfile::TempDir;

use crate::PROGRAM;

/// Time limit of a run.
const PATIENCE: Duration = Duration::from_secs(120);

/// A temporary folder, deleted at the end of the test.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(TempDir::with_prefix("glanz-test-").expect("a folder for the test"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a file of the test");
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// The names of all files, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder of the test");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    pub(crate) fn picture(&self, name: &str) -> Pixels {
        let image = image::read(&self.bytes(name), Some(Path::new(name)), image::Encoding::Srgb);
        image.unwrap_or_else(|error| panic!("{name}: {error}")).pixels
    }

    /// The program with the blank-separated arguments of `line`, in this folder.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(PROGRAM);
        command.current_dir(self.0.path()).args(line.split_whitespace()).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Starts the program.
    pub(crate) fn start(&self, line: &str) -> Child {
        self.command(line).spawn().expect("the program starts")
    }

    /// Runs the program to its end.
    pub(crate) fn run(&self, line: &str) -> ProgramOutput {
        self.run_with(&[], line)
    }

    /// Runs the program with variables of the environment.
    pub(crate) fn run_with(&self, variables: &[(&str, &str)], line: &str) -> ProgramOutput {
        let variables = variables.iter().copied();
        finish(self.command(line).envs(variables).spawn().expect("the program starts"), line)
    }

    /// Runs the program and expects success.
    pub(crate) fn succeed(&self, line: &str) -> ProgramOutput {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "glanz {line}\n{}{}", ran.stdout, ran.stderr);
        ran
    }
}

/// Exit code and output of a run.
pub(crate) struct ProgramOutput {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl ProgramOutput {
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error} in {}", self.stdout))
    }

    /// Expects a failure with exit code `code`, each of `words` in the message, and no panic.
    pub(crate) fn refused(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}{}", self.stdout, self.stderr);
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "\"{word}\" is not in:\n{}", self.stderr);
        }
    }
}

/// Waits for the end; a run that hangs is killed and fails the test.
pub(crate) fn finish(child: Child, line: &str) -> ProgramOutput {
    let id = child.id();
    let (sender, receiver) = std::sync::mpsc::channel();
    let waiting = std::thread::spawn(move || sender.send(child.wait_with_output()));
    let output: Output = match receiver.recv_timeout(PATIENCE) {
        Ok(output) => output.expect("the output of the program"),
        Err(_) => {
            let _ = Command::new("kill").args(["-9", &id.to_string()]).status();
            panic!("glanz {line} hangs");
        }
    };
    waiting.join().expect("the waiting thread").expect("a listener");
    ProgramOutput {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("text"),
        stderr: String::from_utf8(output.stderr).expect("text"),
    }
}

/// Waits until `condition` is true.
pub(crate) fn wait_until(what: &str, condition: impl Fn() -> bool) {
    wait_within(PATIENCE, what, condition);
}

/// Waits until `condition` is true, for `patience` at most.
pub(crate) fn wait_within(patience: Duration, what: &str, condition: impl Fn() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < patience, "{what} does not happen");
        std::thread::sleep(Duration::from_millis(5));
    }
}
