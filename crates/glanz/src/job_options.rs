//! Options that every job takes.

use std::path::PathBuf;

use glanz_job::{CancelFlag, ProgressSink};

use crate::event::JobEvent;
use crate::running_job::RunningJob;

/// The methods of [`JobOptions`], which all builders have over their field `job`.
macro_rules! job_methods {
    ($lifetime:lifetime $(, $job:ident)?) => {
        /// Runs with `count` threads; 0, the default, uses all processors. The result does not depend on the number.
        pub fn threads(mut self, count: usize) -> Self {
            self$(.$job)?.threads = count;
            self
        }

        /// Saves the state of the job in this file: a second after the start, then at growing intervals of up to 30 seconds (less often if writing takes more than 5 % of the time), and at
        /// the end; by default in none. No other process may write it meanwhile.
        pub fn checkpoint(mut self, path: impl Into<Option<std::path::PathBuf>>) -> Self {
            self$(.$job)?.checkpoint = path.into();
            self
        }

        /// Whether to resume from the checkpoint if it exists; otherwise an existing one is an error.
        pub fn resume(mut self, resume: bool) -> Self {
            self$(.$job)?.resume = resume;
            self
        }

        /// Reports the progress to `sink`.
        pub fn on_progress(mut self, sink: &$lifetime mut (dyn glanz_job::ProgressSink + Send)) -> Self {
            self$(.$job)?.sink = Some(sink);
            self
        }

        /// Reports warnings and other events to `events` as they occur.
        pub fn on_event(
            mut self,
            events: &$lifetime mut (dyn FnMut($crate::JobEvent<'_>) + Send),
        ) -> Self {
            self$(.$job)?.events = Some(events);
            self
        }

        /// Ends the job when `flag` is raised.
        pub fn cancel(mut self, flag: glanz_job::CancelFlag) -> Self {
            self$(.$job)?.cancel = flag;
            self
        }
    };
}

pub(crate) use job_methods;

/// Options that every job takes; the builders have the same methods.
///
/// A function that starts any of the jobs can set them as one value, for the method `job` of the builders:
///
/// ```
/// use glanz::job::CancelFlag;
/// use glanz::scene::SceneBuilder;
/// use glanz::scene::description::{LightDescription, MaterialKind, ShapeDescription};
/// use glanz::{JobEvent, JobOptions, LoadedScene};
///
/// # fn main() -> Result<(), glanz::Error> {
/// let description = SceneBuilder::new()
///     .resolution(8, 6)
///     .shape(ShapeDescription::sphere(1.0).translated([0.0, 0.0, 3.0]), MaterialKind::diffuse(0.5))
///     .light(LightDescription::point([0.0, 0.0, 0.0], 1.0))
///     .describe()?;
/// let cancel = CancelFlag::default(); // another thread may raise it
/// let mut warnings = Vec::new();
/// let mut events = |event: JobEvent<'_>| {
///     if let JobEvent::Warning(warning) = event {
///         warnings.push(warning.to_string());
///     }
/// };
/// let options = JobOptions::default().threads(1).cancel(cancel.clone()).on_event(&mut events);
/// let picture = LoadedScene::from_description("ball", description).render().samples(1).job(options).run()?;
/// assert_eq!(picture.warnings().len(), warnings.len());
/// # Ok(())
/// # }
/// ```
#[derive(Default)]
#[must_use = "options have no effect before they are given to a builder"]
pub struct JobOptions<'a> {
    /// 0: all processors of the machine.
    pub(crate) threads: usize,
    pub(crate) checkpoint: Option<PathBuf>,
    pub(crate) resume: bool,
    pub(crate) cancel: CancelFlag,
    pub(crate) sink: Option<&'a mut (dyn ProgressSink + Send)>,
    pub(crate) events: Option<&'a mut (dyn FnMut(JobEvent<'_>) + Send)>,
}

impl<'a> JobOptions<'a> {
    job_methods!('a);

    /// The job with these options.
    pub(crate) fn start(self) -> RunningJob<'a> {
        RunningJob { options: self, warnings: Vec::new(), lock: None }
    }
}
