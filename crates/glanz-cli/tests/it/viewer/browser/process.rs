//! A Chromium without a window and with OpenGL in software, driven over the DevTools protocol.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::devtools::DevTools;

/// How long it may take to start.
const PATIENCE: Duration = Duration::from_secs(60);

/// What the browser is called in the distributions.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// One at a time: OpenGL in software takes every processor that there is.
static TURN: Mutex<()> = Mutex::new(());

/// A browser with a fresh profile. It ends with its value, and its profile goes with it.
pub(crate) struct Browser {
    pub(crate) devtools: DevTools,
    process: Process,
    _turn: MutexGuard<'static, ()>,
}

struct Process {
    child: Child,
    profile: PathBuf,
}

impl Browser {
    /// Starts one.
    pub(crate) fn start() -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let program = find();
        let profile = fresh_folder();
        let child = Command::new(&program)
            .args([
                "--headless=new",
                "--remote-debugging-port=0",
                "--no-first-run",
                "--no-default-browser-check",
            ])
            // Containers seldom let it have a sandbox; it shows nothing but our own page here.
            .args([
                "--no-sandbox",
                "--disable-dev-shm-usage",
                "--disable-breakpad",
                "--disable-background-networking",
            ])
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--force-device-scale-factor=1"])
            .arg(format!("--user-data-dir={}", profile.display()))
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

    /// A folder that goes with the browser, for what pages save.
    pub(crate) fn downloads(&self) -> PathBuf {
        self.process.profile.join("saved by pages")
    }
}

impl Process {
    /// Where it listens: it writes port and path into its profile.
    fn address(&mut self) -> Result<(u16, String), String> {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait().map_err(|error| error.to_string())? {
                return Err(format!("it ended at once: {status}"));
            }
            let text = std::fs::read_to_string(self.profile.join("DevToolsActivePort")).unwrap_or_default();
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
        // Its own children notice that it is gone.
        let _ = self.child.kill();
        let _ = self.child.wait();
        // They may be writing while they notice.
        for _ in 0..50 {
            if std::fs::remove_dir_all(&self.profile).is_ok() {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// The program: the one that `CHROMIUM` names, or the first on the search path. `cargo xtask test` names the one that it has found or installed.
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

fn fresh_folder() -> PathBuf {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let number = COUNTER.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("glanz-browser-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the browser");
    folder
}
