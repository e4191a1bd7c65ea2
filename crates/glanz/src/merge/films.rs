//! Joining of films: all heads first, then the sums of one file after the other.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use glanz_job::{Interrupted, JobProgress, WorkCount};
use glanz_transport::{
    Checkpoint, CheckpointError, CheckpointHead, FilmJoin, MergeChecks, MergeError, MissingSamples,
};

use super::part_file::{PartFile, PartInput};
use super::{JoinError, MergeOptions, MissingPart, PartKind, check_missing, readable};
use crate::error::{Error, FileFault};
use crate::render::{Picture, RenderStatistics};
use crate::running_job::RunningJob;

/// A part of a picture whose head was read.
struct FilmPart {
    path: PathBuf,
    head: CheckpointHead,
    /// The rest of a pipe.
    pipe: Option<PartInput>,
}

/// The picture of all parts.
pub(super) fn join(
    files: Vec<PartFile>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<Picture, Error> {
    let mut parts: Vec<FilmPart> = Vec::new();
    let mut checks = MergeChecks::default();
    for file in files {
        job.options.cancel.check()?;
        let Some(mut part) = readable(FilmPart::read(file), options, job)? else { continue };
        let admitted = checks.admit(parts.len(), &mut part.head);
        parts.push(part);
        admitted.map_err(|error| with_paths(error, &parts))?;
    }
    let missing = missing_parts(checks.missing_samples());
    if !options.partial {
        check_missing(missing, options, job)?;
    }
    let mut join =
        FilmJoin::try_new(checks, options.memory_of_film()).map_err(|error| with_paths(error, &parts))?;
    let mut progress = MergeProgress::new(&parts);
    for part in parts {
        let path = part.path.clone();
        let added = part.add_to(&mut join, options.partial, &mut progress, job);
        let added = added.map_err(|error| match error {
            CheckpointError::Interrupted(interrupted) => Error::Interrupted(interrupted),
            // A fault of the film of all parts, which leaving out this part would not mend.
            CheckpointError::Film(error) => JoinError::Whole(error).into(),
            error => FileFault::from(error).of(&path),
        });
        readable(added, options, job)?;
        progress.parts += 1;
    }
    let Checkpoint { identity, film } = join.finish();
    if film.samples().is_empty() {
        return Err(JoinError::Empty.into());
    }
    check_missing(missing_parts(film.missing_samples()), options, job)?;
    Ok(Picture::new(identity, film, RenderStatistics::default(), std::mem::take(&mut job.warnings)))
}

impl FilmPart {
    /// Reads the head of a file.
    fn read(file: PartFile) -> Result<Self, Error> {
        let path = file.path.clone();
        let (mut reader, found) = file.reader()?;
        let head = CheckpointHead::read(&mut reader).map_err(Error::of_file(&path))?;
        found.map_or(Ok(()), |found| head.check_length(found)).map_err(Error::of_file(&path))?;
        let pipe = found.is_none().then_some(reader);
        Ok(Self { path, head, pipe })
    }

    /// Adds its sums.
    fn add_to(
        self,
        join: &mut FilmJoin,
        hold: bool,
        progress: &mut MergeProgress,
        job: &mut RunningJob<'_>,
    ) -> Result<(), CheckpointError> {
        let Self { path, head, pipe } = self;
        let input = match pipe {
            Some(pipe) => pipe,
            None => {
                let opened = File::open(&path).and_then(|mut file| {
                    file.seek(SeekFrom::Start(head.before_sums()))?;
                    Ok(file)
                });
                Box::new(opened.map_err(CheckpointError::from)?)
            }
        };
        join.add(&head, input, hold, |bytes| progress.advance(bytes, job))
    }
}

/// Progress of a merge.
struct MergeProgress {
    parts: u64,
    all_parts: u64,
    bytes: u64,
    all_bytes: u64,
    start: Instant,
    reported: Instant,
}

/// Time between two reports.
const REPORT_INTERVAL: Duration = Duration::from_millis(500);

impl MergeProgress {
    fn new(parts: &[FilmPart]) -> Self {
        let all_bytes = parts.iter().map(|part| part.head.length() - part.head.before_sums()).sum();
        let start = Instant::now();
        Self { parts: 0, all_parts: parts.len() as u64, bytes: 0, all_bytes, start, reported: start }
    }

    /// Reports the next `bytes`.
    fn advance(&mut self, bytes: u64, job: &mut RunningJob<'_>) -> Result<(), Interrupted> {
        job.options.cancel.check()?;
        self.bytes += bytes;
        if self.reported.elapsed() >= REPORT_INTERVAL
            && let Some(sink) = &mut job.options.sink
        {
            self.reported = Instant::now();
            let count = WorkCount { done: self.parts, wanted: Some(self.all_parts), unit: ["part", "parts"] };
            let fraction = self.bytes as f64 / self.all_bytes as f64;
            let progress = JobProgress::by_work("merging", fraction.min(1.0), self.start.elapsed());
            sink.on_progress(&progress.with_count(count));
        }
        Ok(())
    }
}

fn missing_parts(missing: Vec<MissingSamples>) -> Vec<MissingPart> {
    let named = missing.into_iter().map(|MissingSamples { part, samples, is_whole }| MissingPart {
        part,
        missing: format!("samples {samples}"),
        is_whole,
    });
    named.collect()
}

/// The error with the files that cause it.
fn with_paths(error: MergeError, files: &[FilmPart]) -> Error {
    let path = |part: usize| files.get(part).map_or_else(PathBuf::new, |part| part.path.clone());
    let error = match error {
        MergeError::Picture { part, mismatch } => JoinError::Identity {
            kind: PartKind::Picture,
            parts: [path(0), path(part)],
            mismatch: Box::new(mismatch),
        },
        MergeError::Ordered { part } => JoinError::Ordered { part: path(part) },
        MergeError::Overlap { first, second, samples } => JoinError::Overlap {
            parts: [path(first), path(second)],
            common: format!("samples {} to {}", samples.start, samples.end - 1),
        },
        MergeError::Film { part: 0, error } => JoinError::Whole(error),
        MergeError::Film { part, error } => JoinError::Film { parts: [path(0), path(part)], error },
        _ => JoinError::Empty,
    };
    error.into()
}
