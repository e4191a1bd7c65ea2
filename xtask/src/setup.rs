//! The tools that checks need beyond Rust: which are there, and how the others are installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;

use crate::{chromium, web, workspace};

/// Installs every tool that can be installed.
///
/// # Errors
/// The tools that are missing, with how to get them.
pub(crate) fn install() -> Result<String, String> {
    let toolbox = Toolbox::prepare(Tool::ALL);
    let missing: Vec<String> = Tool::ALL.iter().filter_map(|tool| toolbox.missing(*tool)).collect();
    if !missing.is_empty() {
        return Err(missing.join("\n"));
    }
    let browser =
        chromium::find().map_or(String::new(), |program| format!("; the browser is {}", program.display()));
    Ok(format!("setup: every tool is there{browser}"))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tool {
    Rustfmt,
    Clippy,
    /// Node.js and npm.
    Node,
    /// The npm packages that check the viewer's page.
    NodePackages,
    Chromium,
    /// The programs of a cluster, for `farm`.
    Slurm,
    /// The program that runs jobs of Open Job Description, for `farm`.
    OpenJobDescription,
    /// The tracer of system calls, for `failures`.
    Strace,
    /// The checker of memory, for `memory`.
    Valgrind,
}

/// Tools of a run, some of which may still be on their way.
pub(crate) struct Toolbox {
    /// What could not be installed, known when the installation has ended.
    installation: Mutex<Installation>,
}

enum Installation {
    Running(JoinHandle<Vec<MissingTool>>),
    Done(Vec<MissingTool>),
}

#[derive(Clone)]
struct MissingTool {
    tool: Tool,
    why: String,
}

impl Toolbox {
    /// Reports at once what is missing and how to get it, and starts to install what can be installed: the components of the
    /// toolchain before this returns, everything else beside the checks.
    pub(crate) fn prepare(needs: impl IntoIterator<Item = Tool>) -> Self {
        let mut absent: Vec<Tool> = needs.into_iter().filter(|tool| !tool.is_there()).collect();
        absent.dedup();
        for tool in &absent {
            match tool.installer() {
                Some(installer) => println!("setup: {} missing; installing with {installer}", tool.name()),
                None => println!("setup: {}", tool.described("").why),
            }
        }
        let (available, unavailable): (Vec<Tool>, Vec<Tool>) =
            absent.into_iter().partition(|tool| tool.installer().is_some());
        let (components, others): (Vec<Tool>, Vec<Tool>) =
            available.into_iter().partition(|tool| matches!(tool, Tool::Rustfmt | Tool::Clippy));
        let mut missing: Vec<MissingTool> = unavailable.into_iter().map(|tool| tool.described("")).collect();
        missing.extend(install_all(&components));
        let installation = if others.is_empty() {
            Installation::Done(missing)
        } else {
            Installation::Running(std::thread::spawn(move || {
                missing.extend(install_all(&others));
                missing
            }))
        };
        Self { installation: Mutex::new(installation) }
    }

    /// Why a tool is missing and how to get it; `None` if it is there. Waits for the installation of tools other than components.
    pub(crate) fn missing(&self, tool: Tool) -> Option<String> {
        let mut installation = self.installation.lock().unwrap_or_else(PoisonError::into_inner);
        if matches!(tool, Tool::Rustfmt | Tool::Clippy) && tool.is_there() {
            return None;
        }
        if let Installation::Running(_) = *installation
            && let Installation::Running(thread) =
                std::mem::replace(&mut *installation, Installation::Done(Vec::new()))
            // A thread that died installed nothing: whatever is not there then is found missing by the checks.
            && let Ok(missing) = thread.join()
        {
            *installation = Installation::Done(missing);
        }
        match &*installation {
            Installation::Done(missing) => missing.iter().find(|m| m.tool == tool).map(|m| m.why.clone()),
            Installation::Running(_) => None,
        }
    }
}

/// Installs tools in this order; those that are missing after that, with the reasons.
fn install_all(tools: &[Tool]) -> Vec<MissingTool> {
    let outcome = |&tool: &Tool| {
        let result = tool.install();
        if tool.is_there() {
            println!("setup: {} now there", tool.name());
            return None;
        }
        let missing = tool.described(&result.err().map_or(String::new(), |why| format!(" ({why})")));
        println!("setup: {}", missing.why);
        Some(missing)
    };
    tools.iter().filter_map(outcome).collect()
}

impl Tool {
    /// Those of the checks of a change.
    const ALL: [Self; 5] = [Self::Rustfmt, Self::Clippy, Self::Node, Self::NodePackages, Self::Chromium];

    /// Name and verb of a sentence.
    fn name(self) -> &'static str {
        match self {
            Self::Rustfmt => "rustfmt is",
            Self::Clippy => "clippy is",
            Self::Node => "Node.js 18 or later with npm is",
            Self::NodePackages => "the npm packages that check the page are",
            Self::Chromium => "Chromium is",
            Self::Slurm => "Slurm with munge is",
            Self::OpenJobDescription => "openjd is",
            Self::Strace => "strace is",
            Self::Valgrind => "valgrind is",
        }
    }

    fn described(self, reason: &str) -> MissingTool {
        let why = format!("{} missing{reason}; get it with: {}", self.name(), self.remedy());
        MissingTool { tool: self, why }
    }

    fn is_there(self) -> bool {
        let cargo_has = |subcommand| {
            let version = workspace::cargo([subcommand, "--version"]).output();
            version.is_ok_and(|output| output.status.success())
        };
        match self {
            Self::Rustfmt => cargo_has("fmt"),
            Self::Clippy => cargo_has("clippy"),
            Self::Node => {
                find_program("npm").is_some() && node_version().is_some_and(|version| version >= 18)
            }
            Self::NodePackages => web::packages_are_installed(),
            Self::Chromium => chromium::find().is_some(),
            // Debian has them where only the superuser's search path leads.
            Self::Slurm => ["slurmctld", "slurmd", "munged"]
                .iter()
                .all(|name| find_program(name).is_some() || Path::new("/usr/sbin").join(name).is_file()),
            Self::OpenJobDescription => openjd().is_some(),
            Self::Strace => find_program("strace").is_some(),
            Self::Valgrind => find_program("valgrind").is_some(),
        }
    }

    /// The program that [`Self::install`] installs it with, if it can.
    fn installer(self) -> Option<&'static str> {
        match self {
            Self::Rustfmt | Self::Clippy => find_program("rustup").map(|_| "rustup"),
            Self::Node => may_use_apt().then_some("apt-get"),
            Self::NodePackages => (Self::Node.is_there() || may_use_apt()).then_some("npm ci"),
            Self::Chromium if chromium::has_package() && Self::NodePackages.installer().is_some() => {
                Some("npm")
            }
            Self::Chromium | Self::Slurm | Self::Strace | Self::Valgrind => {
                may_use_apt().then_some("apt-get")
            }
            Self::OpenJobDescription => find_program("python3").map(|_| "pip"),
        }
    }

    fn install(self) -> Result<(), String> {
        match self {
            Self::Rustfmt => run_quietly(Command::new("rustup").args(["component", "add", "rustfmt"])),
            Self::Clippy => run_quietly(Command::new("rustup").args(["component", "add", "clippy"])),
            Self::Node => apt_install(&["nodejs", "npm"]),
            Self::NodePackages => run_quietly(&mut web::npm(&["ci", "--no-audit", "--no-fund"])),
            // A package of npm changes nothing outside of this folder, and comes in seconds.
            Self::Chromium => chromium::install_package()
                .or_else(|why| apt_install(&["chromium"]).map_err(|other| format!("{why}; {other}"))),
            Self::Slurm => apt_install(&["slurm-wlm", "munge"]),
            Self::Strace => apt_install(&["strace"]),
            Self::Valgrind => apt_install(&["valgrind"]),
            Self::OpenJobDescription => {
                let folder = in_target(OPENJD_FOLDER);
                run_quietly(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
                run_quietly(Command::new(folder.join("bin/pip")).args(["install", "--quiet", "openjd-cli"]))
            }
        }
    }

    /// The command that a person installs it with.
    fn remedy(self) -> String {
        match self {
            Self::Rustfmt => "rustup component add rustfmt".to_owned(),
            Self::Clippy => "rustup component add clippy".to_owned(),
            Self::NodePackages => format!("npm ci --prefix {}", web::FOLDER),
            Self::Node => by_package_manager(|manager| manager.node, "an installer from nodejs.org"),
            Self::Chromium => by_package_manager(
                |manager| manager.chromium,
                "any way, and its path in the variable CHROMIUM",
            ),
            Self::Slurm => "sudo apt-get install slurm-wlm munge (Debian), as root".to_owned(),
            Self::OpenJobDescription => "pip install openjd-cli".to_owned(),
            Self::Strace => "sudo apt-get install strace (Debian)".to_owned(),
            Self::Valgrind => "sudo apt-get install valgrind (Debian)".to_owned(),
        }
    }
}

/// A package manager and its arguments that install tools.
struct PackageManager {
    program: &'static str,
    needs_root: bool,
    node: &'static str,
    chromium: &'static str,
}

const PACKAGE_MANAGERS: &[PackageManager] = &[
    PackageManager {
        program: "apt-get",
        needs_root: true,
        node: "install nodejs npm",
        chromium: "install chromium",
    },
    PackageManager {
        program: "dnf",
        needs_root: true,
        node: "install nodejs npm",
        chromium: "install chromium",
    },
    PackageManager { program: "pacman", needs_root: true, node: "-S nodejs npm", chromium: "-S chromium" },
    PackageManager { program: "apk", needs_root: true, node: "add nodejs npm", chromium: "add chromium" },
    PackageManager {
        program: "brew",
        needs_root: false,
        node: "install node",
        chromium: "install --cask chromium",
    },
    PackageManager {
        program: "winget",
        needs_root: false,
        node: "install OpenJS.NodeJS.LTS",
        chromium: "install Hibbiki.Chromium",
    },
];

fn by_package_manager(arguments: fn(&PackageManager) -> &'static str, otherwise: &str) -> String {
    let manager = PACKAGE_MANAGERS.iter().find(|manager| find_program(manager.program).is_some());
    manager.map_or_else(
        || otherwise.to_owned(),
        |manager| {
            let sudo = if manager.needs_root && !is_root() { "sudo " } else { "" };
            format!("{sudo}{} {}", manager.program, arguments(manager))
        },
    )
}

/// The file that a name stands for on the search path.
pub(crate) fn find_program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let endings: &[&str] = if cfg!(windows) { &["exe", "cmd"] } else { &[""] };
    let files = std::env::split_paths(&path)
        .flat_map(|folder| endings.iter().map(move |ending| folder.join(name).with_extension(ending)));
    files.into_iter().find(|file| file.is_file())
}

/// The program of the command line, when [`glanz_build`] has run.
pub(crate) fn glanz_program() -> PathBuf {
    in_target(&format!("release/glanz{}", std::env::consts::EXE_SUFFIX))
}

/// The command that builds it.
pub(crate) fn glanz_build() -> Command {
    workspace::cargo(["build", "--release", "--package", "glanz-cli"])
}

/// Folder of the Python environment with `openjd`, below that of build outputs.
const OPENJD_FOLDER: &str = "openjd-venv";

/// The program `openjd`.
pub(crate) fn openjd() -> Option<PathBuf> {
    let own = in_target(OPENJD_FOLDER).join("bin/openjd");
    if own.is_file() { Some(own) } else { find_program("openjd") }
}

/// The number before the first point of Node.js' version.
fn node_version() -> Option<u32> {
    let output = Command::new("node").arg("--version").output().ok()?;
    String::from_utf8_lossy(&output.stdout).trim().strip_prefix('v')?.split('.').next()?.parse().ok()
}

pub(crate) fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn may_use_apt() -> bool {
    find_program("apt-get").is_some() && is_root()
}

fn apt_install(packages: &[&str]) -> Result<(), String> {
    if !may_use_apt() {
        return Err("there is no apt-get, or no right to use it".to_owned());
    }
    let apt = || {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    // Old lists may do.
    let _ = run_quietly(apt().args(["update", "-qq"]));
    run_quietly(apt().args(["install", "-qq", "-y", "--no-install-recommends"]).args(packages))
}

/// Runs a command without showing its output.
///
/// # Errors
/// The last line that it wrote to standard error, or the system's message.
pub(crate) fn run_quietly(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().to_string_lossy().into_owned();
    match command.stdin(Stdio::null()).output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr);
            Err(format!("{program}: {}", text.trim_end().lines().next_back().unwrap_or("failed")))
        }
        Err(error) => Err(format!("{program}: {error}")),
    }
}

/// A file below the folder of build outputs.
pub(crate) fn in_target(name: &str) -> PathBuf {
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace::root().join("target"), PathBuf::from);
    Path::new(&target).join(name)
}
