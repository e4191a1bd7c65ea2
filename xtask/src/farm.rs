//! Jobs in parts on render farms, against single runs: `cargo xtask farm`.
//!
//! The templates and scripts of `farm/` divide small jobs into tasks; a task of the first picture is interrupted once and killed once.
//! The results must have the bits of one run.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use crate::setup::{self, Tool, Toolbox, in_target};
use crate::suite::{self, Check, Verdict, succeed};
use crate::workspace;

/// A job of both farms.
struct FarmJob {
    /// Mode of the script for Slurm, and name of the template.
    mode: &'static str,
    /// Command of glanz.
    command: &'static str,
    scene: &'static str,
    /// Options of the command.
    options: &'static [&'static str],
    /// Parameters of the template that set the same.
    parameters: &'static [&'static str],
    /// Parameter that names the output.
    output_parameter: &'static str,
    output: &'static str,
    parts: u32,
    /// Whether a task is interrupted and killed.
    is_disturbed: bool,
}

impl FarmJob {
    /// Folder for its checkpoints, with a name that shells would misread.
    fn work_folder(&self, out: &Path) -> PathBuf {
        out.join(format!("it's {}", self.output))
    }
}

const JOBS: [FarmJob; 4] = [
    FarmJob {
        mode: "picture",
        command: "render",
        scene: "scenes/rooms/uplights.pbrt",
        options: &["--size", "96x72", "--spp", "384"],
        parameters: &["Size=96x72", "SamplesPerPixel=384", "Options=--threads 1"],
        output_parameter: "OutputFile",
        output: "picture.exr",
        parts: 4,
        is_disturbed: true,
    },
    FarmJob {
        mode: "picture",
        command: "render",
        scene: "scenes/rooms/uplights.pbrt",
        options: &["--size", "96x72", "--spp", "16", "--exposure", "1"],
        parameters: &["Size=96x72", "SamplesPerPixel=16", "Options=--exposure 1"],
        output_parameter: "OutputFile",
        output: "picture.png",
        parts: 3,
        is_disturbed: false,
    },
    FarmJob {
        mode: "lux",
        command: "illuminate",
        scene: "scenes/reflector.pbrt",
        options: &["--rays", "200000", "--room", "10", "10", "10"],
        parameters: &["Rays=200000", "Options=--room 10 10 10"],
        output_parameter: "OutputFolder",
        output: "lux",
        parts: 7,
        is_disturbed: false,
    },
    FarmJob {
        mode: "bake",
        command: "bake",
        scene: "scenes/rooms/direct.pbrt",
        options: &["--texels-per-metre", "4", "--rays", "64"],
        parameters: &["TexelsPerMetre=4", "Options=--rays 64"],
        output_parameter: "OutputFile",
        output: "model.glb",
        parts: 5,
        is_disturbed: false,
    },
];

/// Time limit of a job on the cluster.
const PATIENCE: Duration = Duration::from_secs(900);

/// Time that the tasks of a job that is cancelled may take to end.
const CANCEL_PATIENCE: Duration = Duration::from_secs(60);

/// Runs the jobs of these names, or all if there are none, on both farms and prints a table.
///
/// # Errors
/// A name that is no job.
pub(crate) fn run(names: &[&str]) -> Result<ExitCode, String> {
    if let Some(unknown) = names.iter().find(|name| JOBS.iter().all(|job| job.mode != **name)) {
        let known: BTreeSet<&str> = JOBS.iter().map(|job| job.mode).collect();
        let known: Vec<&str> = known.into_iter().collect();
        return Err(format!("there is no job \"{unknown}\", choose from {}", known.join(", ")));
    }
    let jobs: Vec<&FarmJob> =
        JOBS.iter().filter(|job| names.is_empty() || names.contains(&job.mode)).collect();
    let checks = [
        Check { name: "one run", run: Box::new(|| single_runs(&jobs)) },
        Check { name: "openjd", run: Box::new(|| openjd(&jobs)) },
        Check { name: "slurm", run: Box::new(|| slurm(&jobs)) },
    ];
    Ok(suite::run("farm", &checks))
}

/// All jobs as a part of the nightly checks.
///
/// # Errors
/// The first fault.
pub(crate) fn check() -> Result<Verdict, String> {
    let jobs: Vec<&FarmJob> = JOBS.iter().collect();
    single_runs(&jobs)?;
    let verdicts = [("OpenJD", openjd(&jobs)?), ("Slurm", slurm(&jobs)?)];
    let is_run = verdicts.iter().any(|(_, verdict)| matches!(verdict, Verdict::Passed(_)));
    let remarks = verdicts.map(|(name, verdict)| match verdict {
        Verdict::Passed(times) => format!("{name}: {times}"),
        Verdict::Skipped(why) => why,
    });
    let remarks = remarks.join("; ");
    Ok(if is_run { Verdict::Passed(remarks) } else { Verdict::Skipped(remarks) })
}

/// The folder of a farm's work, below that of build outputs.
fn folder(name: &str) -> PathBuf {
    let path = in_target("farm").join(name);
    std::path::absolute(&path).unwrap_or(path)
}

/// The same, empty.
fn empty_folder(name: &str) -> Result<PathBuf, String> {
    let path = folder(name);
    let fault = |error| format!("{}: {error}", path.display());
    if path.exists() {
        std::fs::remove_dir_all(&path).map_err(fault)?;
    }
    std::fs::create_dir_all(&path).map_err(fault)?;
    Ok(path)
}

/// The program of the variable `GLANZ`, or the one that [`single_runs`] builds.
fn program() -> PathBuf {
    let path = std::env::var_os("GLANZ").map_or_else(setup::glanz_program, PathBuf::from);
    std::path::absolute(&path).unwrap_or(path)
}

/// Computes every job in one run.
fn single_runs(jobs: &[&FarmJob]) -> Result<Verdict, String> {
    if std::env::var_os("GLANZ").is_none() {
        succeed(&mut setup::glanz_build(), "the program does not build")?;
    }
    let out = empty_folder("one")?;
    timed(jobs, |job| {
        let mut command = Command::new(program());
        command.arg(job.command).arg(workspace::root().join(job.scene)).args(job.options);
        command.arg("-o").arg(out.join(job.output)).arg("-q");
        succeed(&mut command, &format!("{}: one run fails", job.output))
    })
}

/// Runs every job as one of Open Job Description. A task that fails ends the session; it starts again, as on a farm.
fn openjd(jobs: &[&FarmJob]) -> Result<Verdict, String> {
    if let Some(why) = Toolbox::prepare([Tool::OpenJobDescription]).missing(Tool::OpenJobDescription) {
        return Ok(Verdict::Skipped(why));
    }
    let openjd = setup::openjd().ok_or("openjd is missing")?;
    let out = empty_folder("openjd")?;
    timed(jobs, |job| {
        let glanz = disturbing_program(&out, job, &[("TERM", "$$"), ("KILL", "$$")])?;
        let run = || {
            let mut command = Command::new(&openjd);
            command.arg("run").arg(workspace::root().join(format!("farm/openjd/{}.yaml", job.mode)));
            let parameters = [
                format!("SceneFile={}", workspace::root().join(job.scene).display()),
                format!("{}={}", job.output_parameter, out.join(job.output).display()),
                format!("WorkFolder={}", job.work_folder(&out).display()),
                format!("Parts={}", job.parts),
                format!("Glanz={}", glanz.display()),
            ];
            let parameters = parameters.iter().map(String::as_str).chain(job.parameters.iter().copied());
            parameters.for_each(|parameter| {
                command.args(["--job-param", parameter]);
            });
            setup::run_quietly(&mut command)
        };
        let failures = if job.is_disturbed { SIGNAL_COUNT } else { 0 };
        for _ in 0..failures {
            if run().is_ok() {
                return Err(format!("{}: a task that is killed does not fail", job.output));
            }
        }
        run()?;
        compare(&out, job)
    })
}

/// Runs every job on a cluster of one node. Slurm queues tasks again that are interrupted or killed.
fn slurm(jobs: &[&FarmJob]) -> Result<Verdict, String> {
    if let Some(why) = Toolbox::prepare([Tool::Slurm]).missing(Tool::Slurm) {
        return Ok(Verdict::Skipped(why));
    }
    if !setup::is_root() {
        return Ok(Verdict::Skipped("a cluster of one's own needs root".to_owned()));
    }
    // One that an interrupted run has left.
    drop(LocalCluster { folder: folder("slurm").join("cluster") });
    let out = empty_folder("slurm")?;
    let cluster = LocalCluster::start(&out.join("cluster"))?;
    cancelled(&cluster, &out)?;
    timed(jobs, |job| {
        // The script, which started the program, gets the signal that announces the time limit.
        let glanz = disturbing_program(&out, job, &[("USR1", "$PPID"), ("KILL", "$$")])?;
        let numbers = cluster.submit(&out, job, job.options, &glanz)?;
        cluster.wait(&numbers, PATIENCE)?;
        compare(&out, job)
    })
}

/// Cancels a job when its tasks run, which must end it.
fn cancelled(cluster: &LocalCluster, out: &Path) -> Result<(), String> {
    let endless = ["--spp", "10000000"];
    let job = FarmJob { output: "cancelled.exr", parts: 2, is_disturbed: false, ..JOBS[0] };
    let numbers = cluster.submit(out, &job, &endless, &program())?;
    let start = Instant::now();
    while !(1..=2).all(|part| job.work_folder(out).join(format!("part-{part}.log")).exists()) {
        if start.elapsed() > CANCEL_PATIENCE {
            return Err(format!("jobs {numbers} of Slurm do not start"));
        }
        std::thread::sleep(Duration::from_millis(250));
    }
    std::thread::sleep(Duration::from_secs(1));
    succeed(cluster.command("scancel").args(numbers.split(',')), "scancel fails")?;
    cluster.wait(&numbers, CANCEL_PATIENCE)
}

/// A cluster that is stopped at the end.
struct LocalCluster {
    folder: PathBuf,
}

impl LocalCluster {
    fn start(folder: &Path) -> Result<Self, String> {
        let cluster = Self { folder: folder.to_owned() };
        let mut command = cluster.script("start");
        command.arg("4");
        succeed(&mut command, "the cluster does not start").map(|()| cluster)
    }

    fn script(&self, action: &str) -> Command {
        let mut command = Command::new(workspace::root().join("farm/slurm/local.sh"));
        command.arg(action).arg(&self.folder);
        command
    }

    fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// Submits a job with these options; the numbers of its jobs, with commas between.
    fn submit(&self, out: &Path, job: &FarmJob, options: &[&str], glanz: &Path) -> Result<String, String> {
        let mut command = self.command(workspace::root().join("farm/slurm/submit.sh"));
        command.arg(job.mode).arg(workspace::root().join(job.scene)).arg(out.join(job.output));
        command.arg(job.parts.to_string()).arg(job.work_folder(out)).args(options);
        Ok(text_of(command.env("GLANZ", glanz))?.trim().replace(' ', ","))
    }

    /// Waits until all these jobs have ended.
    fn wait(&self, numbers: &str, patience: Duration) -> Result<(), String> {
        let start = Instant::now();
        while start.elapsed() < patience {
            let queued = text_of(self.command("squeue").args(["--noheader", "--jobs", numbers]))?;
            if queued.trim().is_empty() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(250));
        }
        Err(format!("jobs {numbers} of Slurm do not end"))
    }
}

impl Drop for LocalCluster {
    fn drop(&mut self) {
        // What remains is named by the script.
        let _ = self.script("stop").status();
    }
}

/// Number of signals that the disturbed task gets, one in each run.
const SIGNAL_COUNT: usize = 2;

/// The program, or a script in its place that sends signals in the midst of the first runs of the third task, each to a process:
/// `$$` is the program, `$PPID` the one that started it.
fn disturbing_program(
    out: &Path,
    job: &FarmJob,
    signals: &[(&str, &str); SIGNAL_COUNT],
) -> Result<PathBuf, String> {
    if !job.is_disturbed {
        return Ok(program());
    }
    let path = out.join("disturbed");
    let text = format!(
        "#!/bin/bash\n\
         glanz='{}'\n\
         [[ \" $* \" == *' --part 3/'* ]] || exec \"$glanz\" \"$@\"\n\
         runs=$(cat \"$0.runs\" 2>/dev/null || echo 0)\n\
         echo $((runs + 1)) >\"$0.runs\"\n\
         signals=({}) targets=({})\n\
         if [ \"$runs\" -lt ${{#signals[@]}} ]; then\n\
         (sleep 0.7; kill -\"${{signals[runs]}}\" \"${{targets[runs]}}\") &\n\
         exec \"$glanz\" \"$@\"\n\
         fi\n\
         exec \"$glanz\" \"$@\" > >(tee \"$0.log\") 2>&1\n",
        program().display(),
        signals.map(|(signal, _)| signal).join(" "),
        signals.map(|(_, target)| target).join(" ")
    );
    let fault = |error| format!("{}: {error}", path.display());
    std::fs::write(&path, text).map_err(fault)?;
    succeed(Command::new("chmod").arg("+x").arg(&path), "chmod fails")?;
    Ok(path)
}

/// Compares the result of a job with that of one run; a disturbed task must have had a run for each signal, and one more that
/// goes on from its checkpoint.
fn compare(out: &Path, job: &FarmJob) -> Result<(), String> {
    if job.is_disturbed {
        let runs = std::fs::read_to_string(out.join("disturbed.runs")).unwrap_or_default();
        if runs.trim() != (SIGNAL_COUNT + 1).to_string() {
            return Err(format!("{}: the disturbed task has run {} times", job.output, runs.trim()));
        }
        let log = std::fs::read_to_string(out.join("disturbed.log")).unwrap_or_default();
        if !log.contains("continuing with samples") {
            return Err(format!("{}: the disturbed task does not go on from its checkpoint", job.output));
        }
    }
    let [expected, found] = [folder("one"), out.to_owned()].map(|folder| results(&folder.join(job.output)));
    let (expected, found) = (expected?, found?);
    match expected.iter().find(|(name, bytes)| found.get(*name) != Some(bytes)) {
        Some((name, _)) => Err(format!("{}: {name} differs from one run, or is missing", job.output)),
        None if expected.is_empty() => Err(format!("{}: there are no results", job.output)),
        None => Ok(()),
    }
}

/// The bytes of a file, of a model also those of its light maps, or those of the maps in a folder: reports beside them have times.
fn results(path: &Path) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let fault = |error| format!("{}: {error}", path.display());
    let mut files = Vec::new();
    if path.is_dir() {
        for entry in std::fs::read_dir(path).map_err(fault)? {
            files.push(entry.map_err(fault)?.path());
        }
        files.retain(|file| matches!(file.extension().and_then(OsStr::to_str), Some("csv" | "exr")));
    } else {
        files.push(path.to_owned());
        // The light maps, of which a model has pictures.
        let is_model = path.extension().is_some_and(|extension| extension == "glb");
        files.extend(is_model.then(|| path.with_extension("exr")));
    }
    let name = |file: &Path| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    files.iter().map(|file| Ok((name(file), std::fs::read(file).map_err(fault)?))).collect()
}

/// Does the same with every job; the times as a remark.
fn timed(jobs: &[&FarmJob], run: impl Fn(&FarmJob) -> Result<(), String>) -> Result<Verdict, String> {
    let mut times = Vec::new();
    for job in jobs {
        let start = Instant::now();
        run(job)?;
        times.push(format!("{} {:.1} s", job.output, start.elapsed().as_secs_f64()));
        println!("{}", times.last().map_or("", String::as_str));
    }
    Ok(Verdict::Passed(times.join(", ")))
}

/// The standard output of a command.
fn text_of(command: &mut Command) -> Result<String, String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| format!("{program}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{program}: {}", String::from_utf8_lossy(&output.stderr).trim()))
    }
}
