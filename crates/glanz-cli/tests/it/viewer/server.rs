//! `glanz view` as a user starts it, on a port of its own.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

/// How long a scene may take to be served: builds that are not optimised run beside others here.
const PATIENCE: Duration = Duration::from_secs(120);

/// A file of the repository's scenes.
pub(crate) fn scene_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

/// A server that ends with its value.
pub(crate) struct ViewServer {
    child: Child,
    said: Arc<Mutex<String>>,
    /// `127.0.0.1:PORT`.
    pub(crate) host: String,
}

impl ViewServer {
    /// Serves a scene, and waits until it says where.
    pub(crate) fn start(scene: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_glanz"))
            .arg("view")
            .arg(scene)
            .args(["--no-open", "--port", "0"])
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

    /// The address that it printed.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/", self.host)
    }

    /// All that it has printed.
    pub(crate) fn said(&self) -> String {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether it still runs.
    pub(crate) fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// The number of the process.
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

/// Keeps what is said, and passes on the host of the first address in it.
fn listen(pipe: impl Read + Send + 'static, said: &Arc<Mutex<String>>, hosts: mpsc::Sender<String>) {
    let said = Arc::clone(said);
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).lines().map_while(Result::ok) {
            if let Some((_, rest)) = line.split_once("http://") {
                let host = rest.split(|c: char| c == '/' || c.is_whitespace()).next().unwrap_or_default();
                // Nobody listens any more after the first.
                let _ = hosts.send(host.to_owned());
            }
            let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
            said.push_str(&line);
            said.push('\n');
        }
    });
}
