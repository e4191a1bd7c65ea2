//! Progress of a job: a bar on a terminal, plain lines elsewhere, messages for a render farm, nothing if quiet.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use glanz_job::{JobProgress, ProgressSink};
use glanz_report::number::duration;

use crate::messages::{CLEAR_LINE, Messages};
use crate::{ProgressFormat, openjd};

/// Time between two plain lines, or messages for a render farm.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Smallest time between two updates of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);

/// Characters of the bar between its brackets.
const BAR_WIDTH: usize = 32;

/// Width of a terminal that does not report it.
const USUAL_WIDTH: usize = 80;

/// Display of the progress of a job.
pub struct Progress {
    display: ProgressDisplay,
}

enum ProgressDisplay {
    Bar { drawn: Option<Instant> },
    Lines { messages: Messages, last: Instant },
    RenderFarm { messages: Messages, sent: Option<Instant> },
    Nothing,
}

impl Progress {
    /// Starts without output; the first plain line follows after an interval.
    pub fn start(messages: Messages) -> Self {
        let display = if messages.is_quiet() {
            ProgressDisplay::Nothing
        } else if messages.format() == ProgressFormat::OpenJobDescription {
            ProgressDisplay::RenderFarm { messages, sent: None }
        } else if std::io::stderr().is_terminal() {
            ProgressDisplay::Bar { drawn: None }
        } else {
            ProgressDisplay::Lines { messages, last: Instant::now() }
        };
        Self { display }
    }

    /// Shows the progress.
    pub fn show(&mut self, progress: &JobProgress<'_>) {
        let (text, fraction) = (text(progress), progress.fraction);
        match &mut self.display {
            ProgressDisplay::Bar { drawn } => {
                if drawn.is_none_or(|drawn| drawn.elapsed() >= BAR_INTERVAL) {
                    *drawn = Some(Instant::now());
                    let width = terminal_size::terminal_size_of(std::io::stderr());
                    let width = width.map_or(USUAL_WIDTH, |(width, _)| usize::from(width.0));
                    draw(&bar(fraction, &text, width));
                }
            }
            ProgressDisplay::Lines { messages, last } => {
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    messages.note(&format!("{:3.0} % {text}", 100.0 * fraction));
                }
            }
            ProgressDisplay::RenderFarm { messages, sent } => {
                if sent.is_none_or(|sent| sent.elapsed() >= LINE_INTERVAL) {
                    *sent = Some(Instant::now());
                    openjd::progress(*messages, overall(progress.step, fraction));
                    openjd::status(*messages, &text);
                }
            }
            ProgressDisplay::Nothing => {}
        }
    }

    /// Removes the bar.
    pub fn finish(self) {
        if matches!(self.display, ProgressDisplay::Bar { drawn: Some(_) }) {
            draw("");
        }
    }
}

impl ProgressSink for Progress {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        self.show(progress);
    }
}

/// Completed work and remaining time.
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

/// Share of all phases that is done, as if they took the same time: it never decreases from phase to phase.
fn overall([number, phases]: [u32; 2], fraction: f64) -> f64 {
    (f64::from(number.saturating_sub(1)) + fraction.clamp(0.0, 1.0)) / f64::from(phases.max(1))
}

/// A line of a terminal of `width` characters.
fn bar(fraction: f64, text: &str, width: usize) -> String {
    let done = (fraction.clamp(0.0, 1.0) * BAR_WIDTH as f64) as usize;
    let head = if done < BAR_WIDTH { ">" } else { "" };
    let bar = format!("{}{head}", "=".repeat(done));
    let line = format!("{:>3.0} % [{bar:BAR_WIDTH$}] {text}", 100.0 * fraction);
    // A line that fills the terminal would begin another one.
    line.chars().take(width.saturating_sub(1)).collect()
}

/// Replaces the line of the terminal.
fn draw(line: &str) {
    let mut stream = std::io::stderr().lock();
    // If this stream is closed, errors cannot be reported.
    let _ = write!(stream, "{CLEAR_LINE}{line}").and_then(|()| stream.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_share_the_whole() {
        assert_eq!([overall([1, 1], 0.25), overall([1, 4], 1.0), overall([2, 4], 0.0)], [0.25; 3]);
        assert_eq!([overall([4, 4], 1.0), overall([1, 1], 2.0)], [1.0; 2]);
    }

    #[test]
    fn bar_fills_with_the_work_and_stays_in_its_line() {
        assert_eq!(bar(0.0, "a", 80), format!("  0 % [>{}] a", " ".repeat(31)));
        assert_eq!(bar(0.5, "a", 80), format!(" 50 % [{}>{}] a", "=".repeat(16), " ".repeat(15)));
        assert_eq!(bar(1.0, "a", 80), format!("100 % [{}] a", "=".repeat(32)));
        assert_eq!(bar(0.5, "a text that is far too long", 50).chars().count(), 49);
    }
}
