//! Joining of films.

use std::path::PathBuf;

use glanz_transport::{Checkpoint, MergeError};

use super::part_file::PartFile;
use super::{JoinError, MergeOptions, PartKind, readable};
use crate::error::Error;
use crate::render::{Picture, RenderStatistics};
use crate::running_job::RunningJob;

/// The picture of all parts.
pub(super) fn join(
    parts: Vec<PartFile>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<Picture, Error> {
    let paths: Vec<PathBuf> = parts.iter().map(|part| part.path.clone()).collect();
    // Parts are read one after the other, so that at most two are in memory; the first that cannot be read ends the merge.
    let mut unreadable = None;
    let read = parts.into_iter().map_while(|part| {
        let path = part.path.clone();
        let bytes = part.bytes();
        let part = bytes.and_then(|bytes| Checkpoint::from_bytes(&bytes).map_err(Error::of_file(&path)));
        readable(part, options, job).map_err(|error| unreadable = Some(error)).ok()
    });
    let merged = glanz_transport::merge(read.flatten());
    match unreadable {
        Some(error) => Err(error),
        None => {
            let Checkpoint { identity, film } = merged.map_err(|error| with_paths(error, &paths))?;
            Ok(Picture::new(identity, film, RenderStatistics::default(), std::mem::take(&mut job.warnings)))
        }
    }
}

/// The error with the files that cause it.
fn with_paths(error: MergeError, paths: &[PathBuf]) -> JoinError {
    let path = |part: usize| paths.get(part).cloned().unwrap_or_default();
    match error {
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
        MergeError::Film { part, error } => JoinError::Film { parts: [path(0), path(part)], error },
        _ => JoinError::Empty,
    }
}
