//! The process of `glanz view`, on a free port.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use tempfile::TempDir;

use super::upload::ANY_FILES;

/// Time limit until a scene is served; debug builds run in parallel with other tests.
const PATIENCE: Duration = Duration::from_secs(120);

/// Path of a scene file of the repository.
pub(crate) fn scene_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

/// A server process, ended when the value is dropped.
pub(crate) struct ViewServer {
    child: Child,
    said: Arc<Mutex<String>>,
    /// `127.0.0.1:PORT`.
    pub(crate) host: String,
}

impl ViewServer {
    /// Serves a scene and waits until the address is printed.
    pub(crate) fn start(scene: &Path) -> Self {
        Self::start_with(scene, &[])
    }

    /// The same with these environment variables.
    pub(crate) fn start_with(scene: &Path, variables: &[(&str, &Path)]) -> Self {
        Self::start_with_arguments(scene, &[], variables)
    }

    /// The same with more arguments.
    pub(crate) fn start_with_arguments(
        scene: &Path,
        arguments: &[&OsStr],
        variables: &[(&str, &Path)],
    ) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_glanz"))
            .arg("view")
            .arg(scene)
            .args(["--no-open", "--port", "0"])
            .args(arguments)
            .envs(variables.iter().copied())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let said = Arc::new(Mutex::new(String::new()));
        let (sender, hosts) = mpsc::channel();
        listen(child.stdout.take().expect("a pipe"), &said, sender.clone());
        listen(child.stderr.take().expect("a pipe"), &said, sender);
        let mut served = Self { child, said, host: String::new() };
        match hosts.recv_timeout(PATIENCE) {
            Ok(host) => served.host = host,
            Err(why) => panic!("glanz view {} gives no address: {why}\n{}", scene.display(), served.said()),
        }
        served
    }

    /// The printed address.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/", self.host)
    }

    /// All output so far.
    pub(crate) fn said(&self) -> String {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether the process is still running.
    pub(crate) fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// The process id.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for ViewServer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A folder for temporary files of a server.
pub(crate) fn temporary_folder() -> TempDir {
    TempDir::with_prefix("glanz-test-").expect("a folder for temporary files")
}

/// Serves a scene, with temporary files in this folder.
pub(crate) fn serve_in(folder: &TempDir) -> ViewServer {
    let arguments = ANY_FILES.map(OsStr::new);
    ViewServer::start_with_arguments(&scene_file("teapot.pbrt"), &arguments, &[("TMPDIR", folder.path())])
}

/// Number of files and folders in a folder.
pub(crate) fn entries(folder: &TempDir) -> usize {
    std::fs::read_dir(folder.path()).expect("the folder").count()
}

/// Stores the output and sends the host of the first address in it.
fn listen(pipe: impl Read + Send + 'static, said: &Arc<Mutex<String>>, hosts: mpsc::Sender<String>) {
    let said = Arc::clone(said);
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).lines().map_while(Result::ok) {
            if let Some((_, rest)) = line.split_once("http://") {
                let host = rest.split(|c: char| c == '/' || c.is_whitespace()).next().unwrap_or_default();
                // The receiver is dropped after the first address.
                let _ = hosts.send(host.to_owned());
            }
            let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
            said.push_str(&line);
            said.push('\n');
        }
    });
}
