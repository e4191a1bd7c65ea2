//! How far a job is: a bar on a terminal, plain lines elsewhere, nothing if quiet.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use glanz_job::{JobProgress, ProgressSink};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use glanz_report::number::duration;

use crate::messages::Messages;

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Steps of the bar: finer than its width on any terminal.
const STEPS: u64 = 1000;

/// Shows how far a job is.
pub struct Progress {
    shown: Shown,
}

enum Shown {
    Bar(ProgressBar),
    Lines { messages: Messages, last: Instant },
    Nothing,
}

impl Progress {
    /// Shows nothing yet; the first plain line comes after a while.
    pub fn start(messages: Messages) -> Self {
        let shown = if messages.is_quiet() {
            Shown::Nothing
        } else if std::io::stderr().is_terminal() {
            Shown::Bar(bar())
        } else {
            Shown::Lines { messages, last: Instant::now() }
        };
        Self { shown }
    }

    /// Shows how far the job is.
    pub fn show(&mut self, progress: &JobProgress<'_>) {
        let (text, fraction) = (text(progress), progress.fraction);
        match &mut self.shown {
            Shown::Bar(bar) => {
                bar.set_position((fraction * STEPS as f64) as u64);
                bar.set_message(text);
            }
            Shown::Lines { messages, last } => {
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    messages.note(&format!("{:3.0} % {text}", 100.0 * fraction));
                }
            }
            Shown::Nothing => {}
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Shown::Bar(bar) = self.shown {
            bar.finish_and_clear();
        }
    }
}

impl ProgressSink for Progress {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.show(progress);
    }
}

/// What is done, and the time left.
fn text(progress: &JobProgress<'_>) -> String {
    let mut text = match (progress.count, progress.step) {
        (Some(count), _) => count.to_string(),
        (None, [_, 1]) => progress.phase.to_owned(),
        (None, [number, phases]) => format!("{number} of {phases}: {}", progress.phase),
    };
    if let Some(error) = progress.error {
        text += &format!(", {:.2} % error", 100.0 * error);
    }
    if let Some(remaining) = progress.remaining {
        text += &format!(", {} left", duration(remaining.as_secs_f64()));
    }
    text
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    // The template is a constant; were it refused, indicatif's own style would do.
    if let Ok(style) = ProgressStyle::with_template("{percent:>3} % [{bar:32}] {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}
