//! Reads mutants of files by every reader of Glanz, and reports those that break a promise.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::Parser;
use glanz::job::CancelFlag;
use glanz_fuzz::corpus::{self, CorpusEntry};
use glanz_fuzz::limits;
use glanz_fuzz::measurement::{Measurement, last_panic, record_panics};
use glanz_fuzz::minimize::minimize;
use glanz_fuzz::progress::{CampaignExtent, CampaignProgress};
use glanz_fuzz::targets::{Target, memory_folder, target, targets};
use glanz_fuzz::worker::{self, FaultReport, MutantRun, WorkerReport, kept_path};
use glanz_terminal::interrupt;

/// Reads mutants of files by every reader of Glanz; the exit code is 1 if one panics, takes too long or too much memory, and 2 if a target could not be tested.
#[derive(Debug, Parser)]
#[command(name = "glanz-fuzz")]
struct FuzzArguments {
    /// Names of targets; all without one.
    targets: Vec<String>,
    /// Number of mutants of each target; jobs behind readers take a part of it. By default 10,000, or any number within `--seconds`.
    #[arg(long, value_name = "N")]
    cases: Option<u64>,
    /// Longest time for each target.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Seed of the mutants.
    #[arg(long, value_name = "X", default_value_t = 0)]
    seed: u64,
    /// Folder for files with faults, and for the slowest one of each target.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Number of processes at a time; by default one for each processor.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Lists the targets.
    #[arg(long)]
    list: bool,
    /// Reads this file instead, in a process of its own.
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    /// Reads the files of the corpus instead.
    #[arg(long)]
    corpus: bool,
    /// Reads the files with known faults instead, which are those that are not mended.
    #[arg(long, conflicts_with = "corpus")]
    pending: bool,
    #[arg(long, hide = true)]
    replay_here: Option<PathBuf>,
    #[arg(long, hide = true)]
    worker: Option<PathBuf>,
}

impl FuzzArguments {
    /// Number of mutants of each target; `None`: only the time is limited.
    fn limited_cases(&self) -> Option<u64> {
        self.cases.or_else(|| self.seconds.is_none().then_some(10_000))
    }
}

fn main() -> ExitCode {
    let arguments = FuzzArguments::parse();
    let cancel = match interrupt::listen() {
        Ok(cancel) => cancel,
        Err(error) => {
            eprintln!("error: {}", error.message);
            return ExitCode::from(2);
        }
    };
    match run(&arguments, &cancel) {
        Ok(_) if cancel.is_cancelled() => {
            eprintln!("stopped by a signal");
            ExitCode::from(interrupt::exit_code())
        }
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Runs the command; returns whether there was no fault.
fn run(arguments: &FuzzArguments, cancel: &CancelFlag) -> Result<bool, String> {
    let chosen = chosen(&arguments.targets)?;
    if arguments.list {
        chosen.iter().for_each(|target| println!("{}", target.name));
        return Ok(true);
    }
    if let Some(folder) = &arguments.worker {
        let [target] = chosen[..] else { return Err("a worker has one target".to_owned()) };
        let &FuzzArguments { seconds, seed, .. } = arguments;
        let cases = arguments.limited_cases().unwrap_or(u64::MAX);
        let task = MutantRun { target, cases, seconds, seed };
        record_panics();
        return reported(with_small_stack(|| worker::work(&task, folder, cancel)));
    }
    if let Some(file) = &arguments.replay_here {
        let [target] = chosen[..] else { return Err("a file has one target".to_owned()) };
        record_panics();
        return reported(with_small_stack(|| read_here(target, file)));
    }
    if let Some(file) = &arguments.replay {
        let [target] = chosen[..] else { return Err("name the target of the file".to_owned()) };
        return replayed(target.name, &file.display().to_string(), file);
    }
    if arguments.corpus || arguments.pending {
        let of_target = if arguments.corpus { corpus::entries } else { corpus::pending };
        let entries: Vec<_> = chosen
            .iter()
            .flat_map(|target| of_target(target.name).into_iter().map(|e| (target.name, e)))
            .collect();
        let faults = replayed_at_a_time(&entries, slots(arguments), cancel)?;
        println!("{} files, {faults} with a fault", entries.len());
        return Ok(faults == 0);
    }
    mutants(&chosen, arguments, cancel)
}

fn chosen(names: &[String]) -> Result<Vec<&'static Target>, String> {
    if names.is_empty() {
        return Ok(targets().collect());
    }
    let find = |name: &String| {
        target(name).ok_or_else(|| {
            let known: Vec<&str> = targets().map(|target| target.name).collect();
            format!("there is no target {name:?}, choose from {}", known.join(", "))
        })
    };
    names.iter().map(find).collect()
}

/// Calls `work` on a thread with the smallest stack that the product has.
fn with_small_stack(work: impl FnOnce() -> io::Result<()> + Send) -> Result<(), String> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(limits::STACK).spawn_scoped(scope, work);
        let result = thread.map_err(|error| error.to_string())?.join();
        result.map_err(|_| format!("panic at {}", last_panic()))?.map_err(|error| error.to_string())
    })
}

/// Prints the error of a process that reads, whose standard error stream nobody reads.
fn reported(result: Result<(), String>) -> Result<bool, String> {
    if let Err(reason) = &result {
        worker::print_error(reason);
    }
    result.map(|()| true)
}

/// Reads a file in this process, with the files that belong to it if it is the scene of a folder of the corpus.
fn read_here(target: &Target, file: &Path) -> io::Result<()> {
    let measurement = if corpus::is_scene_of_folder(target.name, file) {
        Measurement::of_scene(target, file)
    } else {
        Measurement::of(target, &fs::read(file)?)
    };
    worker::read_once(&measurement);
    Ok(())
}

fn replayed(target: &str, name: &str, file: &Path) -> Result<bool, String> {
    let fault = worker::replay(target, file).map_err(|error| format!("{name}: {error}"))?;
    match fault {
        None => println!("{name}: fine"),
        Some([_, ref text]) => println!("{name}: {text}"),
    }
    Ok(fault.is_none())
}

/// Reads the entries of these targets, several at a time; returns the number of those with a fault.
fn replayed_at_a_time(
    entries: &[(&str, CorpusEntry)],
    slots: usize,
    cancel: &CancelFlag,
) -> Result<usize, String> {
    let faults = AtomicUsize::new(0);
    let errors = for_each_at_a_time(entries, slots, |(target, entry)| {
        if !cancel.is_cancelled() {
            let is_fine = replayed(target, &entry.name, &entry.file)?;
            faults.fetch_add(usize::from(!is_fine), Ordering::Relaxed);
        }
        Ok(())
    });
    if errors.is_empty() { Ok(faults.into_inner()) } else { Err(listed(&errors)) }
}

/// Calls `work` for every item, also after one has failed, `slots` at a time; returns the errors that differ, in the order of time.
fn for_each_at_a_time<T: Sync>(
    items: &[T],
    slots: usize,
    work: impl Fn(&T) -> Result<(), String> + Sync,
) -> Vec<String> {
    let (next, errors) = (AtomicUsize::new(0), Mutex::new(Vec::<String>::new()));
    let add = |error: String| {
        let mut errors = errors.lock().unwrap_or_else(PoisonError::into_inner);
        if !errors.contains(&error) {
            errors.push(error);
        }
    };
    let run = || {
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            work(item).unwrap_or_else(&add);
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..slots).map(|_| scope.spawn(run)).collect();
        for thread in threads {
            thread.join().unwrap_or_else(|_| add("a thread panicked".to_owned()));
        }
    });
    errors.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// A line for each error, of which `main` prints the first label.
fn listed(errors: &[String]) -> String {
    errors.join("\nerror: ")
}

/// Prints a line to the standard output. One that nobody reads any longer, after a test was ended, is no reason to lose the files of faults.
fn print_line(line: &str) {
    let _ = writeln!(io::stdout(), "{line}");
}

/// Number of processes at a time.
fn slots(arguments: &FuzzArguments) -> usize {
    arguments.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)).max(1)
}

/// Runs mutants of the targets, and prints a line for each target and each fault, also if `cancel` ends them early.
fn mutants(
    chosen: &[&'static Target],
    arguments: &FuzzArguments,
    cancel: &CancelFlag,
) -> Result<bool, String> {
    let slots = slots(arguments);
    let keep = arguments.keep.clone().unwrap_or_else(|| PathBuf::from("target/fuzz"));
    fs::create_dir_all(&keep).map_err(|error| format!("{}: {error}", keep.display()))?;
    let mut is_fine = true;
    let start = Instant::now();
    let tasks = tasks(chosen, arguments, slots);
    let progress = CampaignProgress { cancel: cancel.clone(), ..CampaignProgress::default() };
    let mut reports: Vec<TargetReport> = chosen.iter().map(|_| TargetReport::default()).collect();
    let extent = CampaignExtent::of(&tasks, slots, arguments.limited_cases().is_some());
    let (found, errors) = run_tasks(&tasks, chosen, slots, &progress, &extent);
    for (index, report, took) in found {
        if let Some(target) = reports.get_mut(index) {
            target.report.add(report);
            target.took += took;
        }
    }
    for (target, TargetReport { report, took }) in chosen.iter().zip(reports) {
        print_figures(target, &report, took);
        let figures = report.figures;
        if !report.slowest.is_empty() {
            write(&kept_path(&keep, target.name, "slowest"), &report.slowest)?;
        }
        // Of processes that a signal or an error ended, only the numbers of cases are known.
        let is_blunt = !cancel.is_cancelled()
            && errors.is_empty()
            && (figures.read == 0 || figures.read == figures.cases);
        if figures.cases >= 1000 && report.faults.is_empty() && is_blunt {
            print_line(&format!(
                "  fault: {} of {} mutants are read, which tests little",
                figures.read, figures.cases
            ));
            is_fine = false;
        }
        for fault in report.faults {
            is_fine = false;
            report_fault(fault, &keep, cancel)?;
        }
    }
    let cases = progress.cases.load(Ordering::Relaxed);
    print_line(&format!("{cases} mutants in {:.1} s", start.elapsed().as_secs_f64()));
    if errors.is_empty() { Ok(is_fine) } else { Err(listed(&errors)) }
}

/// What all processes of a target found, and their time.
#[derive(Default)]
struct TargetReport {
    report: WorkerReport,
    took: Duration,
}

/// The parts of the campaigns: one for each process if there are many cases.
fn tasks(chosen: &[&'static Target], arguments: &FuzzArguments, slots: usize) -> Vec<MutantRun> {
    let of_target = |target: &&'static Target| {
        let target = *target;
        let cases = arguments.limited_cases().map_or(u64::MAX, |cases| cases.div_ceil(target.divisor));
        let parts = if cases < 10_000 { 1 } else { slots as u64 };
        let &FuzzArguments { seconds, seed, .. } = arguments;
        (0..parts).map(move |part| MutantRun {
            target,
            cases: cases / parts + u64::from(part < cases % parts),
            seconds,
            seed: seed.wrapping_mul(1000).wrapping_add(part),
        })
    };
    chosen.iter().flat_map(of_target).collect()
}

/// Runs the tasks, `slots` at a time; returns the number of the target, the report and the time of each, and the errors. Those that fail have a
/// report, too, and the others go on.
fn run_tasks(
    tasks: &[MutantRun],
    chosen: &[&'static Target],
    slots: usize,
    progress: &CampaignProgress,
    extent: &CampaignExtent,
) -> (Vec<(usize, WorkerReport, Duration)>, Vec<String>) {
    let (reports, is_over) = (Mutex::new(Vec::new()), AtomicBool::new(false));
    let run = |task: &MutantRun| -> Result<(), String> {
        if progress.cancel.is_cancelled() {
            return Ok(());
        }
        let named = |error: io::Error| format!("{}: {error}", task.target.name);
        let folder = memory_folder().map_err(named)?;
        let (start, mut report) = (Instant::now(), WorkerReport::default());
        let result = worker::run(task, folder.path(), progress, &mut report);
        let index = chosen.iter().position(|target| target.name == task.target.name).unwrap_or_default();
        reports.lock().unwrap_or_else(PoisonError::into_inner).push((index, report, start.elapsed()));
        result.map_err(named)
    };
    let errors = std::thread::scope(|scope| {
        scope.spawn(|| extent.show(progress, &is_over));
        let errors = for_each_at_a_time(tasks, slots, run);
        is_over.store(true, Ordering::Relaxed);
        errors
    });
    (reports.into_inner().unwrap_or_else(PoisonError::into_inner), errors)
}

fn print_figures(target: &Target, report: &WorkerReport, took: Duration) {
    let figures = &report.figures;
    print_line(&format!(
        "{:<11} {:>9} mutants {:>7.0}/s {:>4.0} % read {:>4} outcomes, slowest {:.3} s, peak {:.1} MB, {:.0} bytes per byte",
        target.name,
        figures.cases,
        figures.cases as f64 / took.as_secs_f64().max(1e-9),
        100.0 * figures.read as f64 / figures.cases.max(1) as f64,
        figures.classes,
        figures.slowest.as_secs_f64(),
        figures.peak as f64 * 1e-6,
        figures.peak_factor,
    ));
}

/// Makes the file of a fault smaller until `cancel` is raised, keeps it, and prints it.
fn report_fault(fault: FaultReport, keep: &Path, cancel: &CancelFlag) -> Result<(), String> {
    let FaultReport { target, signature, text, bytes } = fault;
    let path = kept_path(keep, target, &signature);
    let length = bytes.len();
    write(&path, &bytes)?;
    let trial = kept_path(keep, target, "trial");
    let fails = |bytes: &[u8]| {
        if cancel.is_cancelled() {
            return false;
        }
        let found =
            fs::write(&trial, bytes).ok().and_then(|()| worker::replay(target, &trial).ok().flatten());
        // A process that a signal ended says nothing.
        found.is_some_and(|[found, _]| found == signature) && !cancel.is_cancelled()
    };
    // A fault that does not come again, such as one of time on a busy machine, keeps its file.
    let smallest = minimize(bytes, fails);
    let _ = fs::remove_file(&trial);
    write(&path, &smallest)?;
    print_line(&format!("  fault: {text}\n    {} ({} of {length} bytes)", path.display(), smallest.len()));
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_alone_limits_no_number_of_cases() {
        let cases = |line: &str| FuzzArguments::parse_from(line.split(' ')).limited_cases();
        assert_eq!(cases("glanz-fuzz"), Some(10_000));
        assert_eq!(cases("glanz-fuzz --seconds 5"), None);
        assert_eq!(cases("glanz-fuzz --seconds 5 --cases 7"), Some(7));
    }

    #[test]
    fn all_errors_are_returned_once_and_the_others_go_on() {
        let calls = AtomicUsize::new(0);
        let mut errors = for_each_at_a_time(&[1, 2, 3, 1], 2, |number| {
            calls.fetch_add(1, Ordering::Relaxed);
            if *number == 2 { Ok(()) } else { Err(format!("{number} fails")) }
        });
        errors.sort();
        assert_eq!(errors, ["1 fails", "3 fails"]);
        assert_eq!(calls.into_inner(), 4);
    }
}
