//! Processes that read: a process may panic, exhaust its stack or its memory, or never end, and the next one continues.
//!
//! Before each case, a process writes it into a file, so that the case it died of is known.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use glanz::job::CancelFlag;

use crate::campaign::{Campaign, CampaignFigures};
use crate::limits;
use crate::measurement::Measurement;
use crate::progress::CampaignProgress;
use crate::targets::{FOLDER_VARIABLE, Target, memory_folder};

/// Part of a campaign that one process runs after the other.
#[derive(Clone, Debug)]
pub struct MutantRun {
    /// Target.
    pub target: &'static Target,
    /// Number of mutants.
    pub cases: u64,
    /// Longest time, if it is limited.
    pub seconds: Option<f64>,
    /// Seed of the mutants.
    pub seed: u64,
}

/// A fault with a file that has it.
#[derive(Clone, Debug)]
pub struct FaultReport {
    /// Name of the target.
    pub target: &'static str,
    /// What distinguishes it from others of the target.
    pub signature: String,
    /// What happened.
    pub text: String,
    /// The bytes that were read.
    pub bytes: Vec<u8>,
}

/// What the processes of a task found.
#[derive(Clone, Debug, Default)]
pub struct WorkerReport {
    /// Figures of all processes that ended by themselves, and the numbers of cases of the others.
    pub figures: CampaignFigures,
    /// Faults, one of each signature.
    pub faults: Vec<FaultReport>,
    /// The slowest file.
    pub slowest: Vec<u8>,
}

/// Longest time before the first case of a process, in which it makes its seeds.
const START: Duration = Duration::from_secs(120);

/// Longest time that a process has to end by itself after a signal.
const END: Duration = Duration::from_secs(3);

/// Number of processes that may die for one task.
const DEATHS: u64 = 8;

/// Number of faults after which a process ends.
const FAULTS: usize = 8;

const CURRENT: &str = "current";
const SLOWEST: &str = "slowest";

/// Runs the mutants of a task in this process until they end or `cancel` is raised, with files of its own in `folder`, and prints what it finds for [`run`].
///
/// # Errors
/// Files in the folder cannot be written.
pub fn work(task: &MutantRun, folder: &Path, cancel: &CancelFlag) -> io::Result<()> {
    let mut campaign = Campaign::new(task.target, task.seed);
    let mut current = File::create(folder.join(CURRENT))?;
    let (start, mut shown) = (Instant::now(), Instant::now());
    let mut signatures: Vec<String> = Vec::new();
    while campaign.figures.cases < task.cases
        && task.seconds.is_none_or(|seconds| start.elapsed().as_secs_f64() < seconds)
        && signatures.len() < FAULTS
        && !cancel.is_cancelled()
    {
        let bytes = campaign.next_mutant();
        let head = [campaign.figures.cases.to_le_bytes(), (bytes.len() as u64).to_le_bytes()];
        current.seek(SeekFrom::Start(0))?;
        current.write_all(&[head.as_flattened(), &bytes].concat())?;
        let measurement = Measurement::of(task.target, &bytes);
        if let Some(fault) = &measurement.fault {
            let signature = fault.signature();
            if !signatures.contains(&signature) {
                let path = folder.join(format!("fault-{}", signatures.len()));
                fs::write(&path, &bytes)?;
                println!(
                    "fault\t{}\t{}\t{}",
                    one_line(&signature),
                    one_line(&fault.to_string()),
                    path.display()
                );
                signatures.push(signature);
            }
        }
        if measurement.time > campaign.figures.slowest {
            fs::write(folder.join(SLOWEST), &bytes)?;
        }
        campaign.add(&bytes, &measurement);
        if shown.elapsed() > Duration::from_millis(500) {
            let CampaignFigures { cases, slowest, peak, .. } = campaign.figures;
            println!("cases\t{cases}\t{}\t{peak}", slowest.as_micros());
            shown = Instant::now();
        }
    }
    let CampaignFigures { cases, read, classes, slowest, peak, peak_factor } = campaign.figures;
    println!("done\t{cases}\t{read}\t{classes}\t{}\t{peak}\t{peak_factor}", slowest.as_secs_f64());
    Ok(())
}

/// Reads one file in this process, and prints the result for [`replay`].
pub fn read_once(measurement: &Measurement) {
    match &measurement.fault {
        Some(fault) => {
            println!("fault\t{}\t{}\t", one_line(&fault.signature()), one_line(&fault.to_string()))
        }
        None => println!(
            "fine\t{:?}\t{:.3} s\t{} bytes",
            measurement.outcome,
            measurement.time.as_secs_f64(),
            measurement.peak
        ),
    }
}

/// Prints why this process has no result, for [`run`] and [`replay`].
pub fn print_error(reason: &str) {
    println!("error\t{}", one_line(reason));
}

/// A text without ends of lines and tabs, of limited length: the pipe is read when the process has ended.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(2000).collect()
}

/// This program with these arguments and a limited memory, with one thread wherever readers divide their work. `files`: folder for its files,
/// which stay behind if it is killed.
fn command(arguments: &[&str], files: &Path) -> io::Result<Command> {
    let program = std::env::current_exe()?;
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        let script = format!("ulimit -v {} 2>/dev/null; exec \"$0\" \"$@\"", limits::PROCESS_KIB);
        shell.args(["-c", &script]).arg(program);
        shell
    } else {
        Command::new(program)
    };
    command.args(arguments).env("RAYON_NUM_THREADS", "1").env(FOLDER_VARIABLE, files);
    // Seeds that Glanz writes have the same date in all processes.
    command.env("SOURCE_DATE_EPOCH", "1700000000");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    Ok(command)
}

/// Reads a file in a process of its own: its fault, if it has one, as signature and text.
///
/// # Errors
/// The process cannot be started, or it cannot read the file.
pub fn replay(target: &str, file: &Path) -> io::Result<Option<[String; 2]>> {
    let files = memory_folder()?;
    let mut child = command(&[target, "--replay-here", &file.to_string_lossy()], files.path())?.spawn()?;
    let start = Instant::now();
    let status = loop {
        match child.try_wait()? {
            Some(status) => break status,
            None if start.elapsed() > limits::HANG => {
                end(&mut child);
                return Ok(Some(hang()));
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let mut output = String::new();
    if let Some(mut stdout) = child.stdout.take() {
        stdout.read_to_string(&mut output)?;
    }
    let words: Vec<&str> = output.trim_end_matches('\n').split('\t').collect();
    Ok(match words[..] {
        ["fault", signature, text, ..] => Some([signature.to_owned(), text.to_owned()]),
        ["fine", ..] => None,
        ["error", reason] => return Err(io::Error::other(reason)),
        _ => Some(death(status)),
    })
}

fn hang() -> [String; 2] {
    ["no end".to_owned(), format!("no end within {} s", limits::HANG.as_secs())]
}

fn death(status: ExitStatus) -> [String; 2] {
    ["end of the process".to_owned(), format!("the process ended by {status}: out of stack or memory")]
}

/// Ends a process and waits for it.
fn end(child: &mut Child) {
    // It may have ended by itself meanwhile.
    let _ = child.kill();
    let _ = child.wait();
}

/// Runs a task in processes with files in `folder`, counts its cases in `progress`, and adds what it finds to the report.
///
/// # Errors
/// A process cannot be started, it ends before its first case, or files cannot be read or written.
pub fn run(
    task: &MutantRun,
    folder: &Path,
    progress: &CampaignProgress,
    report: &mut WorkerReport,
) -> io::Result<()> {
    let result = run_processes(task, folder, progress, report);
    progress.add_work(task.target, task.cases.saturating_sub(report.figures.cases));
    result
}

fn run_processes(
    task: &MutantRun,
    folder: &Path,
    progress: &CampaignProgress,
    report: &mut WorkerReport,
) -> io::Result<()> {
    let start = Instant::now();
    for process in 0..DEATHS {
        let left = MutantRun {
            cases: task.cases.saturating_sub(report.figures.cases),
            seconds: task.seconds.map(|seconds| seconds - start.elapsed().as_secs_f64()),
            seed: task.seed.wrapping_add(process << 32),
            ..*task
        };
        let is_out_of_time = left.seconds.is_some_and(|seconds| seconds <= 0.0);
        if left.cases == 0 || is_out_of_time || progress.cancel.is_cancelled() {
            break;
        }
        // Removed with the process, however it ends.
        let files = tempfile::tempdir_in(folder)?;
        let mut child = spawn(&left, folder, files.path())?;
        let result = follow(&mut child, &left, folder, progress, report);
        if result.is_err() {
            end(&mut child);
        }
        if result? {
            break;
        }
    }
    Ok(())
}

fn spawn(task: &MutantRun, folder: &Path, files: &Path) -> io::Result<Child> {
    // The case of the process before is not one of this.
    if let Err(error) = fs::remove_file(folder.join(CURRENT))
        && error.kind() != io::ErrorKind::NotFound
    {
        return Err(error);
    }
    let [cases, seed, seconds] =
        [task.cases.to_string(), task.seed.to_string(), task.seconds.unwrap_or(f64::MAX).to_string()];
    let folder = folder.to_string_lossy();
    let arguments =
        [task.target.name, "--worker", &folder, "--cases", &cases, "--seed", &seed, "--seconds", &seconds];
    command(&arguments, files)?.spawn()
}

/// Adds what a process prints to the report; ends a process that hangs. Returns whether the task is over: the process ended by itself, or after a signal.
fn follow(
    child: &mut Child,
    task: &MutantRun,
    folder: &Path,
    progress: &CampaignProgress,
    report: &mut WorkerReport,
) -> io::Result<bool> {
    let (sender, lines) = mpsc::channel();
    let stdout = child.stdout.take();
    let reader = std::thread::spawn(move || {
        for line in stdout.into_iter().flat_map(|stdout| BufReader::new(stdout).lines()).map_while(Result::ok)
        {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let mut add = |[signature, text]: [String; 2], bytes: Vec<u8>| {
        if report.faults.iter().all(|fault| fault.signature != signature) {
            report.faults.push(FaultReport { target: task.target.name, signature, text, bytes });
        }
    };
    let (mut shown, mut is_complete) = (0, false);
    let mut count = |cases: u64| {
        progress.add(task.target, cases.saturating_sub(shown));
        shown = shown.max(cases);
    };
    // The case that runs, and since when.
    let (mut case, mut since) = (None, Instant::now());
    let mut is_hanging = false;
    let mut reason: Option<String> = None;
    let mut cancelled: Option<Instant> = None;
    loop {
        match lines.recv_timeout(Duration::from_millis(250)) {
            Ok(line) => match line.split('\t').collect::<Vec<_>>()[..] {
                ["cases", cases, slowest, peak] => {
                    count(cases.parse().unwrap_or_default());
                    progress.raise(slowest.parse().unwrap_or_default(), peak.parse().unwrap_or_default());
                }
                ["error", text] => reason = Some(text.to_owned()),
                ["fault", signature, text, path] => {
                    add([signature.to_owned(), text.to_owned()], fs::read(path)?);
                }
                ["done", ref numbers @ ..] => {
                    is_complete = true;
                    if let Some(figures) = figures(numbers) {
                        count(figures.cases);
                        progress.raise(figures.slowest.as_micros() as u64, figures.peak);
                        if figures.slowest > report.figures.slowest {
                            report.slowest = fs::read(folder.join(SLOWEST)).unwrap_or_default();
                        }
                        report.figures.add(&figures);
                    }
                }
                _ => {}
            },
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let now = current(folder).map(|(number, _)| number);
        let longest = if case.is_none() { START } else { limits::HANG };
        if now != case {
            (case, since) = (now, Instant::now());
        } else if since.elapsed() > longest && !is_complete {
            is_hanging = true;
            end(child);
        }
        if progress.cancel.is_cancelled()
            && cancelled.get_or_insert_with(Instant::now).elapsed() > END
            && !is_complete
        {
            end(child);
        }
    }
    let status = child.wait()?;
    // It ends with the output of the process.
    let _ = reader.join();
    if is_complete {
        return Ok(true);
    }
    let case = current(folder);
    if progress.cancel.is_cancelled() {
        // The case that was ended with its process does not count.
        let cases = case.map_or(0, |(number, _)| number);
        count(cases);
        report.figures.cases += cases;
        return Ok(true);
    }
    let (number, bytes) = match (case, reason) {
        (Some(case), None) => case,
        (Some((number, _)), Some(reason)) => {
            count(number);
            report.figures.cases += number;
            return Err(io::Error::other(reason));
        }
        (None, Some(reason)) => return Err(io::Error::other(format!("no case began: {reason}"))),
        (None, None) if is_hanging => {
            return Err(io::Error::other(format!("no case began within {} s", START.as_secs())));
        }
        (None, None) => return Err(io::Error::other(format!("no case began ({status})"))),
    };
    add(if is_hanging { hang() } else { death(status) }, bytes);
    count(number + 1);
    report.figures.cases += number + 1;
    Ok(false)
}

/// The case that a process works on.
fn current(folder: &Path) -> Option<(u64, Vec<u8>)> {
    let bytes = fs::read(folder.join(CURRENT)).ok()?;
    let (number, rest) = bytes.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let bytes = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    Some((u64::from_le_bytes(*number), bytes.to_vec()))
}

fn figures(words: &[&str]) -> Option<CampaignFigures> {
    let [cases, read, classes, slowest, peak, peak_factor] = *words else { return None };
    Some(CampaignFigures {
        cases: cases.parse().ok()?,
        read: read.parse().ok()?,
        classes: classes.parse().ok()?,
        slowest: Duration::try_from_secs_f64(slowest.parse().ok()?).ok()?,
        peak: peak.parse().ok()?,
        peak_factor: peak_factor.parse().ok()?,
    })
}

impl WorkerReport {
    /// Adds the report of another part of the campaign.
    pub fn add(&mut self, other: Self) {
        if other.figures.slowest > self.figures.slowest {
            self.slowest = other.slowest;
        }
        self.figures.add(&other.figures);
        for fault in other.faults {
            if self.faults.iter().all(|known| known.signature != fault.signature) {
                self.faults.push(fault);
            }
        }
    }
}

/// The path of the file in which `name` of a target is kept in `folder`.
#[must_use]
pub fn kept_path(folder: &Path, target: &str, name: &str) -> PathBuf {
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    folder.join(format!("{target}.{name}"))
}
