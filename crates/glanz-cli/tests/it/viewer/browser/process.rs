//! Headless Chromium with OpenGL in software, driven over the DevTools protocol.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::devtools::DevTools;

/// Time limit for the start.
const PATIENCE: Duration = Duration::from_secs(60);

/// Names of the program in the distributions.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Allows one browser at a time, because OpenGL in software uses all processors.
static TURN: Mutex<()> = Mutex::new(());

/// A browser with a new profile; dropping the value ends the process and deletes the profile.
pub(crate) struct Browser {
    pub(crate) devtools: DevTools,
    process: Process,
    _turn: MutexGuard<'static, ()>,
}

struct Process {
    child: Child,
    profile: TempDir,
}

impl Browser {
    /// Starts a browser.
    pub(crate) fn start() -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let program = find();
        let profile = TempDir::with_prefix("glanz-browser-").expect("a folder for the browser");
        let child = Command::new(&program)
            .args([
                "--headless=new",
                "--remote-debugging-port=0",
                "--no-first-run",
                "--no-default-browser-check",
            ])
            // Most containers do not permit the sandbox; only the project's own page is opened here.
            .args([
                "--no-sandbox",
                "--disable-dev-shm-usage",
                "--disable-breakpad",
                "--disable-background-networking",
            ])
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--force-device-scale-factor=1"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
        let mut process = Process { child, profile };
        let (port, path) = process.address().unwrap_or_else(|why| panic!("{}: {why}", program.display()));
        Self { devtools: DevTools::connect(port, &path), process, _turn: turn }
    }

    /// A folder for downloads, deleted with the browser.
    pub(crate) fn downloads(&self) -> PathBuf {
        self.process.profile.path().join("saved by pages")
    }
}

impl Process {
    /// Port and path of the DevTools socket, which the browser writes into its profile.
    fn address(&mut self) -> Result<(u16, String), String> {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait().map_err(|error| error.to_string())? {
                return Err(format!("it ended at once: {status}"));
            }
            let text =
                std::fs::read_to_string(self.profile.path().join("DevToolsActivePort")).unwrap_or_default();
            if let Some((port, path)) = text.split_once('\n')
                && let Ok(port) = port.trim().parse()
                && !path.trim().is_empty()
            {
                return Ok((port, path.trim().to_owned()));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Err("it does not listen".to_owned())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The child processes end after the main process has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        // They may still write files until then.
        for _ in 0..50 {
            if std::fs::remove_dir_all(self.profile.path()).is_ok() {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// The program: the value of `CHROMIUM`, or the first in the search path. `cargo xtask test` sets `CHROMIUM` to the one it has found or installed.
fn find() -> PathBuf {
    if let Some(chosen) = std::env::var_os("CHROMIUM") {
        return chosen.into();
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut places = std::env::split_paths(&path).flat_map(|folder| NAMES.map(|name| folder.join(name)));
    places.find(|place| place.is_file()).unwrap_or_else(|| {
        panic!(
            "Chromium is missing: cargo xtask test installs one; or name one in the environment variable CHROMIUM"
        )
    })
}
