//! The long checks: the parts of `cargo xtask nightly`, some of which are also commands.

use std::process::{Command, ExitCode};

use crate::checks::{BROWSER_TESTS, HEAVY_TESTS, all_tests, run_tests};
use crate::setup::{Tool, Toolbox};
use crate::suite::{self, Check, Verdict, succeed};
use crate::{chromium, farm, publish, python, workspace};

/// Integration tests that take their extent from environment variables, optimised.
struct NightlyPart {
    name: &'static str,
    package: &'static str,
    /// Cargo's profile.
    profile: &'static str,
    /// What the names of its tests contain.
    filter: &'static str,
    /// Divisor of the numbers of the settings in `nightly`, so that it ends in a night on two cores.
    nightly_divisor: u64,
    settings: &'static [Setting],
    /// Files of the caller that it takes as well.
    files: Option<FileList>,
    /// The tool that its tests need beyond Rust.
    needs: Option<Tool>,
    help: &'static str,
}

/// Files that the last option of the command names.
struct FileList {
    option: &'static str,
    /// Their absolute paths with colons between.
    variable: &'static str,
}

/// A number that an option of the command sets.
struct Setting {
    option: &'static str,
    variable: &'static str,
    number: u64,
}

const fn setting(option: &'static str, variable: &'static str, number: u64) -> Setting {
    Setting { option, variable, number }
}

const RELEASE: &str = "release";

const PARTS: &[NightlyPart] = &[
    NightlyPart {
        name: "contract",
        package: "glanz-geometry",
        profile: RELEASE,
        filter: "contract::",
        nightly_divisor: 10,
        settings: &[setting("--rays", "GLANZ_CONTRACT_RAYS", 10_000_000)],
        files: None,
        needs: None,
        help: "the contract of every kind of surface over random rays",
    },
    NightlyPart {
        name: "zoo",
        package: "glanz-geometry",
        profile: RELEASE,
        filter: "zoo::",
        nightly_divisor: 10,
        settings: &[
            setting("--rays", "GLANZ_ZOO_RAYS", 10_000_000),
            setting("--adversarial", "GLANZ_ZOO_ADVERSARIAL", 1_000_000),
            setting("--hard", "GLANZ_ZOO_HARD", 100_000),
        ],
        files: Some(FileList { option: "--patches", variable: "GLANZ_ZOO_PATCHES" }),
        needs: None,
        help: "roots of rays with freeform patches against a reference of interval arithmetic; --patches FILE... adds patches; --hard: rays through each of 60 pathological surfaces, their cost",
    },
    NightlyPart {
        name: "seam",
        package: "glanz-geometry",
        profile: RELEASE,
        filter: "seam::",
        nightly_divisor: 10,
        settings: &[setting("--rays", "GLANZ_SEAM_RAYS", 100_000_000)],
        files: None,
        needs: None,
        help: "rays across the seam of two trimmed faces",
    },
    NightlyPart {
        name: "unbiased",
        package: "glanz-study",
        profile: RELEASE,
        filter: "unbiased::",
        nightly_divisor: 1,
        settings: &[setting("--samples", "GLANZ_UNBIASED_SAMPLES", 16_384)],
        files: None,
        needs: None,
        help: "a Z-test of `guided` and `light` against `path` in all scenes, with this number of samples per pixel",
    },
    NightlyPart {
        name: "bake",
        package: "glanz-cli",
        profile: RELEASE,
        filter: "bake_reference::",
        nightly_divisor: 1,
        settings: &[
            setting("--points", "GLANZ_BAKE_POINTS", 1000),
            setting("--samples", "GLANZ_BAKE_SAMPLES", 8192),
            setting("--density", "GLANZ_BAKE_DENSITY", 25),
            setting("--rays", "GLANZ_BAKE_RAYS", 512),
        ],
        files: None,
        needs: None,
        help: "light maps of both methods, with this density (texels per metre) and number of gather rays, against path tracing at random points",
    },
    NightlyPart {
        name: "failures",
        package: "glanz-cli",
        profile: RELEASE,
        filter: "failures::",
        nightly_divisor: 1,
        settings: &[
            setting("--kills", "GLANZ_FAILURES_KILLS", 100),
            setting("--calls", "GLANZ_FAILURES_CALLS", 1000),
        ],
        files: None,
        needs: Some(Tool::Strace),
        help: "commands whose calls of the system fail, at most this number of each kind, or that are killed at random moments; needs strace",
    },
    NightlyPart {
        name: "mutants",
        package: "glanz-fuzz",
        // It also looks for overflows, which `release` does not check.
        profile: "fuzz",
        filter: "mutants::",
        nightly_divisor: 10,
        settings: &[setting("--cases", "GLANZ_FUZZ_CASES", 10_000_000)],
        files: None,
        needs: None,
        help: "mutated files of every format; a panic, more than a second and too much memory are faults",
    },
    NightlyPart {
        name: "soak",
        package: "glanz-cli",
        profile: RELEASE,
        filter: "viewer::soak::",
        nightly_divisor: 1,
        settings: &[
            setting("--pages", "GLANZ_SOAK_PAGES", 100),
            setting("--seconds", "GLANZ_SOAK_SECONDS", 300),
            setting("--uploads", "GLANZ_SOAK_UPLOADS", 300),
        ],
        files: None,
        needs: None,
        help: "clients of `glanz view` that connect, misbehave, upload hostile files and disconnect; threads, memory, files and processes must be released",
    },
    NightlyPart {
        name: "cad",
        package: "glanz-cli",
        profile: RELEASE,
        filter: "viewer::browser::cad::step_files_",
        nightly_divisor: 1,
        settings: &[setting("--seconds", "GLANZ_CAD_SECONDS", 3)],
        files: Some(FileList { option: "--files", variable: "GLANZ_CAD_FILES" }),
        needs: Some(Tool::Chromium),
        help: "a STEP file opened on the page: first picture within this time, no gaps, drawn where rays meet it; --files FILE... adds files",
    },
];

/// A check of `nightly` without settings that needs a tool beyond Rust.
#[derive(Clone, Copy)]
struct ToolCheck {
    name: &'static str,
    tool: Tool,
}

const BROWSER: ToolCheck = ToolCheck { name: "browser", tool: Tool::Chromium };

const MEMORY: ToolCheck = ToolCheck { name: "memory", tool: Tool::Valgrind };

/// The tools that the chosen checks of `nightly` need, each once.
fn needed(is_chosen: impl Fn(&str) -> bool) -> Vec<Tool> {
    let of_parts = PARTS.iter().filter_map(|part| Some((part.name, part.needs?)));
    let mut tools: Vec<Tool> = Vec::new();
    for (name, tool) in of_parts.chain([BROWSER, MEMORY].map(|check| (check.name, check.tool))) {
        if is_chosen(name) && !tools.contains(&tool) {
            tools.push(tool);
        }
    }
    tools
}

/// What is installed for tests that need a tool: npm brings the browser.
fn installed_for(tool: Tool) -> impl Iterator<Item = Tool> {
    (tool == Tool::Chromium).then_some(Tool::Node).into_iter().chain([tool])
}

/// The command of each part with its default numbers, and its purpose.
pub(crate) fn help() -> String {
    let line = |part: &NightlyPart| {
        let options: String = part.settings.iter().map(|s| format!(" [{} {}]", s.option, s.number)).collect();
        format!("  {}{options}\n                       {}\n", part.name, part.help)
    };
    PARTS.iter().map(line).collect()
}

/// Runs a part with the numbers that these words set.
///
/// # Errors
/// An option is unknown or wrong. `None`: there is no part of that name.
pub(crate) fn part(name: &str, options: &[&str]) -> Option<Result<ExitCode, String>> {
    let part = PARTS.iter().find(|part| part.name == name)?;
    Some(part.command(options).map(|mut command| {
        let toolbox = Toolbox::prepare(part.needs.into_iter().flat_map(installed_for));
        if let Some(why) = part.missing(&toolbox) {
            eprintln!("error: {name}: {why}");
            return ExitCode::FAILURE;
        }
        match part.run(&mut command) {
            Ok(counts) => {
                println!("{name}: {counts}");
                ExitCode::SUCCESS
            }
            Err(counts) => {
                eprintln!("error: {name}: {counts}, see above");
                ExitCode::FAILURE
            }
        }
    }))
}

/// Runs the parts of these names, or all if there are none.
///
/// # Errors
/// An unknown name.
pub(crate) fn nightly(names: &[&str]) -> Result<ExitCode, String> {
    let is_chosen = |name: &str| names.is_empty() || names.contains(&name);
    let toolbox = Toolbox::prepare(needed(is_chosen).into_iter().flat_map(installed_for));
    let with_tool = |check: ToolCheck, run: fn() -> Result<Verdict, String>| {
        let toolbox = &toolbox;
        let run = move || toolbox.missing(check.tool).map_or_else(run, |why| Ok(Verdict::Skipped(why)));
        Check { name: check.name, run: Box::new(run) }
    };
    let mut checks: Vec<Check<'_>> = vec![
        Check { name: "heavy", run: Box::new(|| selected_tests(&[HEAVY_TESTS, "--skip", BROWSER_TESTS])) },
        with_tool(BROWSER, || selected_tests(&[BROWSER_TESTS])),
        with_tool(MEMORY, checked_memory),
        Check { name: "benches", run: Box::new(benches) },
        Check { name: "publish", run: Box::new(|| publish::dry_run().map(Verdict::Passed)) },
        Check { name: "farm", run: Box::new(farm::check) },
        Check { name: "python", run: Box::new(python::verdict) },
    ];
    checks.extend(PARTS.iter().map(|part| Check {
        name: part.name,
        run: Box::new(|| match part.missing(&toolbox) {
            Some(why) => Ok(Verdict::Skipped(why)),
            None => {
                part.nightly_command().and_then(|mut command| part.run(&mut command)).map(Verdict::Passed)
            }
        }),
    }));
    if let Some(unknown) = names.iter().find(|name| checks.iter().all(|check| check.name != **name)) {
        let known: Vec<&str> = checks.iter().map(|check| check.name).collect();
        return Err(format!("there is no part \"{unknown}\", choose from {}", known.join(", ")));
    }
    checks.retain(|check| is_chosen(check.name));
    Ok(suite::run("nightly", &checks))
}

/// Tests that these arguments select.
fn selected_tests(arguments: &[&str]) -> Result<Verdict, String> {
    run_tests(all_tests().arg("--").args(arguments)).map(Verdict::Passed)
}

/// Tests of the vector instructions and their unsafe code, under valgrind, which knows them up to AVX2.
fn checked_memory() -> Result<Verdict, String> {
    let runner = "target.'cfg(all())'.runner = ['valgrind', '--quiet', '--error-exitcode=9']";
    let mut command = workspace::cargo(["--config", runner, "test", "--package", "glanz-geometry", "--lib"]);
    command.args(["--", "bvh::", "instruction_set", "ray_lanes"]);
    let counts = run_tests(&mut command)?;
    if counts.starts_with("0 passed") {
        Err("no test has these names".to_owned())
    } else {
        Ok(Verdict::Passed(counts))
    }
}

/// Links examples and benchmarks, which clippy only checks.
fn benches() -> Result<Verdict, String> {
    let mut command = workspace::cargo(["build", "--release", "--workspace", "--examples", "--benches"]);
    succeed(&mut command, "an example or a benchmark does not build").map(|()| Verdict::Passed(String::new()))
}

impl NightlyPart {
    /// Why it cannot run; `None` if it can. Waits for tools that are being installed.
    fn missing(&self, toolbox: &Toolbox) -> Option<String> {
        self.needs.and_then(|tool| toolbox.missing(tool))
    }

    /// Runs its command. The browser is looked for here, since it may have been installed meanwhile.
    fn run(&self, command: &mut Command) -> Result<String, String> {
        if self.needs == Some(Tool::Chromium)
            && let Some(program) = chromium::find()
        {
            command.env("CHROMIUM", program);
        }
        run_tests(command)
    }

    /// The command with the numbers of `nightly`.
    fn nightly_command(&self) -> Result<Command, String> {
        let number = |setting: &Setting| (setting.number / self.nightly_divisor).to_string();
        let numbers: Vec<(&str, String)> = self.settings.iter().map(|s| (s.option, number(s))).collect();
        let options: Vec<&str> = numbers.iter().flat_map(|(option, number)| [*option, number]).collect();
        self.command(&options)
    }

    /// The command that runs it, its tests' figures printed.
    fn command(&self, mut options: &[&str]) -> Result<Command, String> {
        let mut command =
            workspace::cargo(["test", "--profile", self.profile, "--package", self.package, "--test", "it"]);
        command.args([self.filter, "--", "--nocapture"]);
        for setting in self.settings {
            command.env(setting.variable, setting.number.to_string());
        }
        if let Some(FileList { option, variable }) = &self.files
            && let Some(at) = options.iter().position(|word| word == option)
        {
            let (before, files) = options.split_at(at);
            if files.len() == 1 {
                return Err(format!("{}: \"{option}\" needs files", self.name));
            }
            command.env(variable, paths(&files[1..])?);
            options = before;
        }
        loop {
            options = match *options {
                [] => return Ok(command),
                [option, number, ref rest @ ..] => {
                    let setting = self.settings.iter().find(|setting| setting.option == option);
                    let setting =
                        setting.ok_or_else(|| format!("{}: there is no option \"{option}\"", self.name))?;
                    let number: u64 = number.parse().map_err(|_| format!("\"{number}\" is not a number"))?;
                    command.env(setting.variable, number.to_string());
                    rest
                }
                [option] => return Err(format!("{}: \"{option}\" needs a number", self.name)),
            };
        }
    }
}

/// Absolute paths with colons between; the test runs in the folder of its crate.
fn paths(files: &[&str]) -> Result<String, String> {
    let absolute = |file: &&str| match std::path::absolute(file) {
        Ok(path) => Ok(path.display().to_string()),
        Err(error) => Err(format!("{file}: {error}")),
    };
    Ok(files.iter().map(absolute).collect::<Result<Vec<_>, _>>()?.join(":"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// The value of a variable that a part's tests get, with these options.
    fn variable(name: &str, options: &[&str], variable: &str) -> Result<String, String> {
        let part = PARTS.iter().find(|part| part.name == name).expect("a part");
        let command = part.command(options)?;
        let value = command.get_envs().find(|(name, _)| *name == variable).and_then(|(_, value)| value);
        Ok(value.expect("a value").to_string_lossy().into_owned())
    }

    #[test]
    fn options_come_in_any_order_and_keep_the_numbers_that_are_not_named() {
        assert_eq!(variable("soak", &[], "GLANZ_SOAK_PAGES"), Ok("100".to_owned()));
        let options = ["--seconds", "5", "--pages", "7"];
        assert_eq!(variable("soak", &options, "GLANZ_SOAK_PAGES"), Ok("7".to_owned()));
        assert_eq!(variable("soak", &options[..2], "GLANZ_SOAK_PAGES"), Ok("100".to_owned()));
        assert_eq!(variable("soak", &options[..2], "GLANZ_SOAK_SECONDS"), Ok("5".to_owned()));
        for wrong in [&["--pages"][..], &["--pages", "many"], &["--points", "7"], &["7"], &["--patches", "a"]]
        {
            assert!(variable("soak", wrong, "GLANZ_SOAK_PAGES").is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn mutants_have_overflow_checks() {
        let profile = |name: &str| {
            let part = PARTS.iter().find(|part| part.name == name).expect("a part");
            let command = part.command(&[]).expect("a command");
            command.get_args().any(|argument| argument == "fuzz")
        };
        assert!(profile("mutants") && !profile("seam"));
    }

    #[test]
    fn tools_are_those_of_the_chosen_checks_each_once() {
        assert_eq!(needed(|_| true), [Tool::Strace, Tool::Chromium, Tool::Valgrind]);
        assert_eq!(needed(|name| name == "browser"), [Tool::Chromium]);
        assert_eq!(needed(|name| name == "failures" || name == "seam"), [Tool::Strace]);
        assert!(needed(|name| name == "seam").is_empty());
    }

    #[test]
    fn nightly_divides_the_numbers() {
        let part = PARTS.iter().find(|part| part.name == "seam").expect("a part");
        let command = part.nightly_command().expect("a command");
        let rays = command.get_envs().find(|(name, _)| *name == "GLANZ_SEAM_RAYS");
        assert_eq!(rays.and_then(|(_, value)| value), Some("10000000".as_ref()));
    }

    #[test]
    fn files_stand_last() {
        let options = ["--adversarial", "5", "--patches", "/a.rib", "/b.txt"];
        assert_eq!(variable("zoo", &options, "GLANZ_ZOO_ADVERSARIAL"), Ok("5".to_owned()));
        assert_eq!(variable("zoo", &options, "GLANZ_ZOO_PATCHES"), Ok("/a.rib:/b.txt".to_owned()));
        assert!(variable("zoo", &["--patches"], "GLANZ_ZOO_RAYS").is_err());
        let options = ["--seconds", "5", "--files", "/a.step"];
        assert_eq!(variable("cad", &options, "GLANZ_CAD_FILES"), Ok("/a.step".to_owned()));
        assert!(variable("zoo", &options[2..], "GLANZ_ZOO_RAYS").is_err());
    }

    #[test]
    fn workflow_runs_every_part() {
        let workflow = workspace::root().join(".github/workflows/ci.yml");
        let workflow = std::fs::read_to_string(workflow).unwrap();
        let list = workflow.lines().find_map(|line| line.trim().strip_prefix("part: [")?.strip_suffix(']'));
        let listed: BTreeSet<&str> = list.unwrap().split(", ").collect();
        let others = ["heavy", "browser", "memory", "benches", "publish", "farm", "python"];
        let parts: BTreeSet<&str> = PARTS.iter().map(|part| part.name).chain(others).collect();
        assert_eq!(listed, parts);
    }
}
