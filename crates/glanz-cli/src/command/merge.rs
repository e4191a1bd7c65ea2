//! `glanz merge`: joins the separately computed parts of a job.

use std::path::Path;

use glanz::file::FileUses;
use glanz::{Error, JobEvent, JobOptions, MergeOptions, MergeOutcome, MissingParts, Warning};
use glanz_terminal::CommandOutcome;
use glanz_terminal::interrupt;
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::progress::Progress;
use serde::Serialize;

use crate::arguments::MergeArguments;
use crate::command_error::command_error;
use crate::notes::note_event;
use crate::outputs::Outputs;
use crate::report::{self, plural};

/// The output of `--json`.
#[derive(Serialize)]
struct MergeReport {
    /// picture, illuminance or light.
    kind: String,
    outputs: Vec<String>,
    checkpoint: Option<String>,
    /// Parts that were joined.
    parts: usize,
    #[serde(flatten)]
    content: MergeContent,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    /// What is missing.
    missing: Vec<String>,
    /// The same in one sentence, and parts that were left out.
    warnings: Vec<String>,
}

/// What was joined.
#[derive(Serialize)]
#[serde(untagged)]
enum MergeContent {
    Picture { samples_per_pixel: u64, samples: String },
    Illuminance { particles: u64, particle_ranges: String },
    Light { direct_texels: usize, points: usize },
}

impl MergeContent {
    fn of(outcome: &MergeOutcome) -> Option<Self> {
        Some(match outcome {
            MergeOutcome::Picture(picture) => {
                let samples = picture.film().samples();
                Self::Picture { samples_per_pixel: samples.total(), samples: samples.to_string() }
            }
            MergeOutcome::Illuminance(joined) => {
                let particles = joined.tally().particles();
                Self::Illuminance { particles: particles.total(), particle_ranges: particles.to_string() }
            }
            MergeOutcome::Light(joined) => {
                let [direct_texels, points] = joined.amounts();
                Self::Light { direct_texels, points }
            }
            _ => return None,
        })
    }

    /// The same in words.
    fn words(&self) -> String {
        match self {
            Self::Picture { samples, .. } => format!("samples {samples}"),
            Self::Light { direct_texels, points } => format!(
                "direct light of {} and indirect light at {}",
                plural(*direct_texels as u64, "texel", "texels"),
                plural(*points as u64, "point", "points")
            ),
            Self::Illuminance { particles, .. } => plural(*particles, "particle", "particles"),
        }
    }
}

/// Joins the parts, and writes pictures and checkpoint.
///
/// # Errors
/// Parts that do not belong together, or a file that cannot be read or written.
pub(crate) fn run(arguments: &MergeArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let cancel = interrupt::listen()?;
    let start = std::time::Instant::now();
    let mut files = FileUses::default();
    files.add_inputs(&arguments.parts).map_err(command_error(messages))?;
    let outputs = Outputs::try_new(&arguments.output, arguments.tone.tone(), &mut files, messages)?;
    outputs.check_stream(arguments.verbosity)?;
    let checkpoint = arguments.checkpoint.as_deref();
    checkpoint.map_or(Ok(()), |path| files.add_output(path)).map_err(command_error(messages))?;
    // A running job would replace it by its own state.
    let claimed = checkpoint.map_or(Ok(None), glanz::file::claim_checkpoint);
    let _claim = claimed.map_err(command_error(messages))?;
    let mut progress = Progress::start(messages);
    let mut events = |event: JobEvent<'_>| note_event(event, "", messages);
    let job = JobOptions::default()
        .threads(arguments.threads.count())
        .cancel(cancel)
        .on_progress(&mut progress)
        .on_event(&mut events);
    let options = MergeOptions {
        partial: arguments.partial,
        picture: !arguments.output.is_empty(),
        film_memory: arguments.memory.map(|memory| memory / 2),
    };
    let merged = glanz::merge(&arguments.parts, options, job);
    progress.finish();
    let merged = match merged {
        Err(Error::Interrupted(_)) => {
            messages.note("interrupted; nothing was written");
            return Ok(CommandOutcome::Interrupted);
        }
        merged => merged.map_err(command_error(messages))?,
    };
    if let Some(path) = &arguments.checkpoint {
        merged.save_checkpoint(path).map_err(command_error(messages))?;
    }
    if let MergeOutcome::Picture(picture) = &merged {
        outputs.write(picture, messages)?;
    }
    finish(&merged, arguments, &outputs, start.elapsed().as_secs_f64(), messages)
}

/// Reports what was written.
fn finish(
    merged: &MergeOutcome,
    arguments: &MergeArguments,
    outputs: &Outputs,
    seconds: f64,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let Some(content) = MergeContent::of(merged) else { return Ok(CommandOutcome::Done) };
    let checkpoint = arguments.checkpoint.as_deref().map(Path::display).map(|path| path.to_string());
    let written: Vec<String> = outputs.names().into_iter().chain(checkpoint.clone()).collect();
    let warnings = merged.warnings();
    let left_out = warnings.iter().filter(|warning| matches!(warning, Warning::PartLeftOut { .. })).count();
    let parts = arguments.parts.len() - left_out;
    let missing = warnings.iter().filter_map(|warning| match warning {
        Warning::PartsMissing(MissingParts(parts)) => Some(parts.iter().map(ToString::to_string)),
        _ => None,
    });
    messages.note(&format!(
        "joined {} with {} into {}",
        plural(parts as u64, "part", "parts"),
        content.words(),
        written.join(", ")
    ));
    if arguments.verbosity.json {
        report::print(&MergeReport {
            kind: merged.kind().to_string(),
            outputs: outputs.names(),
            checkpoint,
            parts,
            content,
            seconds,
            peak_memory_bytes: report::peak_memory_bytes(),
            missing: missing.flatten().collect(),
            warnings: warnings.iter().map(ToString::to_string).collect(),
        })?;
    }
    Ok(CommandOutcome::Done)
}
