//! Runs of the program in scripts and with variables, and the content of a folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use super::support::{Folder, ProgramOutput, finish};
use crate::PROGRAM;

impl Folder {
    /// The content of all files, also in folders, by their paths.
    pub(crate) fn content(&self) -> BTreeMap<String, Vec<u8>> {
        let mut content = BTreeMap::new();
        add_content(&self.path("."), "", &mut content);
        content
    }

    /// A command in this folder without input, whose output is kept.
    #[cfg(unix)]
    pub(crate) fn prepared(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.path(".")).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs a script of a shell, in which `$GLANZ` is the program.
    #[cfg(unix)]
    pub(crate) fn run_script(&self, script: &str) -> ProgramOutput {
        let mut command = self.prepared("sh");
        command.args(["-c", script]).env("GLANZ", PROGRAM);
        finish(command.spawn().expect("a shell"), script)
    }
}

/// Adds the content of all files in `folder`, whose names begin with `prefix`.
fn add_content(folder: &Path, prefix: &str, content: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the test") {
        let entry = entry.expect("an entry");
        let (path, name) = (entry.path(), format!("{prefix}{}", entry.file_name().to_string_lossy()));
        if path.is_dir() {
            add_content(&path, &format!("{name}/"), content);
        } else {
            content.insert(name, std::fs::read(&path).expect("a file of the test"));
        }
    }
}
