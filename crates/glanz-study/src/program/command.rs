//! One study from its arguments to its report.

use std::path::Path;
use std::time::Instant;

use glanz_report::Table;
use glanz_report::number::duration;
use glanz_study::{Settings, Study, StudyError, StudyOption, named, studies};
use glanz_terminal::CommandOutcome;
use glanz_terminal::interrupt;
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::output;
use glanz_terminal::progress::Progress;
use serde::Serialize;

use crate::arguments::StudyArguments;

/// JSON output of a study.
#[derive(Serialize)]
struct StudySummary<'a> {
    study: &'static str,
    out: String,
    files: Vec<String>,
    seed: u64,
    /// Wall time.
    seconds: f64,
    summary: &'a Table,
    tables: Tables<'a>,
}

/// Tables under their names.
struct Tables<'a>(Vec<&'a Table>);

impl Serialize for Tables<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|table| (table.name(), table)))
    }
}

/// JSON output of the list of studies.
#[derive(Serialize)]
struct StudyEntry {
    name: &'static str,
    description: &'static str,
}

/// Runs the study and writes its report, or lists the studies.
///
/// # Errors
/// An option that the study does not use, or a file that cannot be written.
pub(crate) fn run(arguments: &StudyArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let (Some(name), Some(out)) = (&arguments.name, &arguments.out) else {
        return list(arguments.verbosity.json);
    };
    let study = named(name).ok_or_else(|| CommandError::usage(format!("there is no study \"{name}\"")))?;
    check_options(study, arguments)?;
    let cancel = interrupt::listen()?;
    // Before the work, so that a folder that cannot be created is reported at once.
    glanz_job::make_folder(out).map_err(|error| CommandError::new(format!("{}: {error}", out.display())))?;
    let settings = Settings {
        rays: arguments.rays,
        size: arguments.size,
        triangles: arguments.triangles.clone(),
        rooms: arguments.rooms.clone(),
        methods: arguments.methods.clone(),
        samples: arguments.samples,
        references: arguments.references,
        elements: arguments.elements,
        rounds: arguments.rounds,
        seconds: arguments.time.map(|time| time.as_secs_f64()),
        threads: arguments.threads.map(usize::from),
        full: arguments.full,
        cache: Some(out.clone()),
        seed: arguments.seed,
        cancel,
    };
    let begun = Instant::now();
    let mut progress = Progress::start(messages);
    let outcome = study.run(&settings, &mut progress);
    progress.finish();
    let report = match outcome {
        Ok(report) => report,
        Err(StudyError::Interrupted(_)) => {
            messages.note(if study.caches {
                "interrupted; no report was written; the same command continues from the cached results"
            } else {
                "interrupted; nothing was written"
            });
            return Ok(CommandOutcome::Interrupted);
        }
        Err(error @ StudyError::Setting { .. }) => return Err(CommandError::usage(error.to_string())),
        Err(error) => return Err(CommandError::new(format!("study {name}: {error}"))),
    };
    let files = report.write(out).map_err(|error| CommandError::new(error.to_string()))?;
    let seconds = begun.elapsed().as_secs_f64();
    messages.note(&format!(
        "wrote {} and {} more files in {}",
        out.join("report.md").display(),
        files.len().saturating_sub(1),
        duration(seconds)
    ));
    if arguments.verbosity.json {
        output::print(&StudySummary {
            study: study.name,
            out: shown_path(out),
            files,
            seed: arguments.seed,
            seconds,
            summary: report.summary(),
            tables: Tables(report.tables().collect()),
        })?;
    } else {
        output::print_text(&format!("{}\n\n{}", report.summary().caption(), report.summary().plain()))?;
    }
    Ok(CommandOutcome::Done)
}

fn list(json: bool) -> Result<CommandOutcome, CommandError> {
    let listed =
        studies().iter().map(|study| StudyEntry { name: study.name, description: study.description });
    if json {
        output::print(&listed.collect::<Vec<_>>())?;
    } else {
        let width = studies().iter().map(|study| study.name.len()).max().unwrap_or_default();
        let lines = listed.map(|s| format!("{:width$}  {}\n", s.name, s.description));
        output::print_text(&lines.collect::<String>())?;
    }
    Ok(CommandOutcome::Done)
}

fn check_options(study: &Study, arguments: &StudyArguments) -> Result<(), CommandError> {
    let given = [
        ("--rays", StudyOption::Rays, arguments.rays.is_some()),
        ("--size", StudyOption::Size, arguments.size.is_some()),
        ("--triangles", StudyOption::Triangles, arguments.triangles.is_some()),
        ("--rooms", StudyOption::Rooms, arguments.rooms.is_some()),
        ("--methods", StudyOption::Methods, arguments.methods.is_some()),
        ("--samples", StudyOption::Samples, arguments.samples.is_some()),
        ("--references", StudyOption::References, arguments.references.is_some()),
        ("--elements", StudyOption::Elements, arguments.elements.is_some()),
        ("--rounds", StudyOption::Rounds, arguments.rounds.is_some()),
        ("--time", StudyOption::Seconds, arguments.time.is_some()),
        ("--threads", StudyOption::Threads, arguments.threads.is_some()),
        ("--full", StudyOption::Full, arguments.full),
    ];
    match given.iter().find(|(_, option, given)| *given && !study.options.contains(option)) {
        Some((name, ..)) => Err(CommandError::usage(format!("the study {} does not use {name}", study.name))),
        None => Ok(()),
    }
}

fn shown_path(path: &Path) -> String {
    path.display().to_string()
}
