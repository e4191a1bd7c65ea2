//! Jobs that report to Python and end when Python is interrupted.

use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use glanz::job::{CancelFlag, JobProgress, ProgressSink};
use glanz::{Error, JobEvent, JobOptions, LoadedScene};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::Whole;
use crate::error::{LineOrigins, failure, os_error, py_error, warn};

/// Time between two checks for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Stack of the thread of a job, bytes.
const STACK: usize = 16 << 20;

/// Largest number of threads.
const MAX_THREADS: u32 = 65_535;

/// Process that uses the engine: its threads do not exist in a process that is forked from it, where a job would wait for them forever.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Notes that this process uses the engine.
///
/// # Errors
/// `GlanzError` if it was forked from one that does.
pub(crate) fn check_process(py: Python<'_>) -> PyResult<()> {
    let process = std::process::id();
    if *PROCESS.get_or_init(|| process) == process {
        return Ok(());
    }
    Err(failure(
        py,
        "this process was forked from one that has used Glanz, and has none of its threads; start processes by \
         multiprocessing.get_context(\"spawn\")"
            .to_owned(),
    ))
}

/// Arguments of every job.
pub(crate) struct JobArguments<'py> {
    pub(crate) threads: Option<Whole>,
    pub(crate) checkpoint: Option<PathBuf>,
    pub(crate) resume: bool,
    pub(crate) progress: Option<Bound<'py, PyAny>>,
}

/// Message of the thread of a job.
enum JobMessage {
    Progress(OwnedProgress),
    Warning(String),
}

/// [`JobProgress`] with a phase of its own.
struct OwnedProgress {
    phase: String,
    progress: JobProgress<'static>,
}

/// Receiver of progress: a function of Python, and the one that ends its display.
struct ProgressReporter<'py> {
    class: Bound<'py, PyAny>,
    report: Bound<'py, PyAny>,
    close: Bound<'py, PyAny>,
}

impl<'py> ProgressReporter<'py> {
    /// `None` without a receiver.
    fn new(py: Python<'py>, progress: Option<Bound<'py, PyAny>>) -> PyResult<Option<Self>> {
        let is_off = |progress: &Bound<'_, PyAny>| progress.extract::<bool>().is_ok_and(|on| !on);
        let Some(progress) = progress.filter(|progress| !is_off(progress)) else { return Ok(None) };
        let module = py.import("glanz._progress")?;
        let (report, close) = module.call_method1("reporter", (progress,))?.extract()?;
        Ok(Some(Self { class: module.getattr("Progress")?, report, close }))
    }

    fn report(&self, OwnedProgress { phase, progress }: OwnedProgress) -> PyResult<()> {
        let values = PyDict::new(self.class.py());
        values.set_item("phase", phase)?;
        values.set_item("step", progress.step[0])?;
        values.set_item("steps", progress.step[1])?;
        values.set_item("fraction", progress.fraction)?;
        values.set_item("elapsed", progress.elapsed.as_secs_f64())?;
        values.set_item("remaining", progress.remaining.map(|time| time.as_secs_f64()))?;
        values.set_item("error", progress.error)?;
        values.set_item("done", progress.count.map(|count| count.done))?;
        values.set_item("wanted", progress.count.and_then(|count| count.wanted))?;
        values.set_item("unit", progress.count.map_or("", |count| count.unit[1]))?;
        self.report.call1((self.class.call((), Some(&values))?,)).map(drop)
    }
}

/// Sends progress to the thread that waits for the job.
struct ChannelSink(mpsc::Sender<JobMessage>);

impl ProgressSink for ChannelSink {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        let phase = progress.phase.to_owned();
        let progress = JobProgress { phase: "", ..*progress };
        // The receiver outlives the job.
        let _ = self.0.send(JobMessage::Progress(OwnedProgress { phase, progress }));
    }
}

/// Runs a job in a thread of its own. The calling thread waits without the interpreter lock, reports progress, and checks for Ctrl-C, which
/// Python handles in its main thread only; an exception ends the job after the step under way, and is returned when it has saved its state.
pub(crate) fn run_job<T: Send>(
    py: Python<'_>,
    arguments: JobArguments<'_>,
    origins: &LineOrigins,
    run: impl FnOnce(JobOptions<'_>) -> Result<T, Error> + Send,
) -> PyResult<T> {
    check_process(py)?;
    let JobArguments { threads, checkpoint, resume, progress } = arguments;
    if resume && checkpoint.is_none() {
        return Err(PyValueError::new_err("resume=True needs the checkpoint to resume from"));
    }
    let threads = threads.map_or(Ok(0), |threads| threads.within("threads", 1..=MAX_THREADS))?;
    let reporter = ProgressReporter::new(py, progress)?;
    let cancel = CancelFlag::default();
    let (sender, receiver) = mpsc::channel();
    let job = {
        let cancel = cancel.clone();
        move || {
            let mut sink = ChannelSink(sender.clone());
            let mut events = move |event: JobEvent<'_>| {
                if let JobEvent::CheckpointFailed(error) = event {
                    let _ = sender.send(JobMessage::Warning(format!("checkpoint: {error}")));
                }
            };
            let options =
                JobOptions::default().threads(threads as usize).checkpoint(checkpoint).resume(resume);
            run(options.cancel(cancel).on_progress(&mut sink).on_event(&mut events))
        }
    };
    let (ended, waited) = thread::scope(|scope| {
        let handle = match thread::Builder::new().stack_size(STACK).spawn_scoped(scope, job) {
            Ok(handle) => handle,
            Err(error) => return (None, Err(os_error("thread".as_ref(), &error))),
        };
        let waited = wait(py, receiver, reporter.as_ref(), &cancel);
        (Some(py.detach(|| handle.join())), waited)
    });
    let closed = reporter.map_or(Ok(()), |reporter| reporter.close.call0().map(drop));
    match ended {
        Some(Ok(outcome)) => {
            let outcome = outcome
                .map_err(|error| (matches!(error, Error::Interrupted(_)), py_error(py, error, origins)));
            match (waited, outcome) {
                (Ok(()), Ok(result)) => closed.map(|()| result),
                (Ok(()), Err((_, error))) => Err(error),
                (Err(stop), Err((false, error))) => {
                    stop.set_cause(py, Some(error));
                    Err(stop)
                }
                (Err(stop), _) => Err(stop),
            }
        }
        Some(Err(_)) => {
            Err(failure(py, "the job ended by a fault of the program; please report it".to_owned()))
        }
        None => waited.and_then(|()| Err(failure(py, "the job did not start".to_owned()))),
    }
}

/// Reads a scene in a thread of its own, while the calling thread checks for Ctrl-C, which raises the flag.
pub(crate) fn run_reading(
    py: Python<'_>,
    cancel: &CancelFlag,
    origins: &LineOrigins,
    read: impl FnOnce() -> Result<LoadedScene, Error> + Send,
) -> PyResult<LoadedScene> {
    check_process(py)?;
    let (sender, receiver) = mpsc::channel::<JobMessage>();
    let (ended, waited) = thread::scope(|scope| {
        let work = move || {
            // Dropped at the end, which the other thread waits for.
            let _sender = sender;
            read()
        };
        match thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work) {
            Ok(handle) => {
                let waited = wait(py, receiver, None, cancel);
                (Some(py.detach(|| handle.join())), waited)
            }
            Err(error) => (None, Err(os_error("thread".as_ref(), &error))),
        }
    });
    waited?;
    match ended {
        Some(Ok(outcome)) => outcome.map_err(|error| py_error(py, error, origins)),
        _ => Err(failure(py, "reading ended by a fault of the program; please report it".to_owned())),
    }
}

/// Passes the messages of a job on until it ends.
fn wait(
    py: Python<'_>,
    mut receiver: mpsc::Receiver<JobMessage>,
    reporter: Option<&ProgressReporter<'_>>,
    cancel: &CancelFlag,
) -> PyResult<()> {
    let mut result = Ok(());
    loop {
        let message;
        (receiver, message) = py.detach(move || {
            let mut message = receiver.recv_timeout(SIGNAL_INTERVAL);
            // A function slower than the progress gets the newest one.
            while let Ok(JobMessage::Progress(_)) = message
                && let Ok(next) = receiver.try_recv()
            {
                message = Ok(next);
            }
            (receiver, message)
        });
        let passed = match message {
            Err(RecvTimeoutError::Disconnected) => return result,
            _ if result.is_err() => continue,
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Ok(JobMessage::Warning(text)) => warn(py, [text]),
            Ok(JobMessage::Progress(progress)) => {
                reporter.map_or(Ok(()), |reporter| reporter.report(progress))
            }
        };
        result = passed.and_then(|()| py.check_signals());
        if result.is_err() {
            cancel.cancel();
        }
    }
}
