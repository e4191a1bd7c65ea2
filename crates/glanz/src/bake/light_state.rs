//! Parts of a bake, and joined parts.

use std::path::{Path, PathBuf};

use glanz_job::{IdentityMismatch, JobIdentity};
use glanz_radiosity::bake::{
    BakeConflict, BakeError, BakePart, BakeParts, BakeSettings, BakeState, bake_part,
};
use glanz_radiosity::elements::Elements;

use super::light_file::{self, BakeStart, LightFile, LightIdentity};
use super::start_of;
use crate::error::{Error, FileFault};
use crate::event::Warning;
use crate::merge::{JoinError, MergeOptions, MissingPart, PartFile, PartKind, check_missing, readable};
use crate::running_job::{JobSink, RunningJob};

/// The light of a part of a bake, or of joined parts.
#[derive(Clone, Debug)]
pub struct LightState {
    identity: LightIdentity,
    state: BakeState,
    /// Warnings, in order of occurrence.
    pub warnings: Vec<Warning>,
}

impl LightState {
    /// Number of texels with direct light, and of points at which indirect light was gathered.
    #[must_use]
    pub fn amounts(&self) -> [usize; 2] {
        [self.state.direct_texels(), self.state.points()]
    }

    /// Writes a checkpoint, from which [`BakeBuilder::run`](super::BakeBuilder::run) makes the light maps, and computes what is missing.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_checkpoint(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        light_file::write_state(path.as_ref(), &self.identity, &self.state)
    }
}

/// Computes a part from the checkpoint of the job, or else from the light of the file `input`.
pub(super) fn computed(
    identity: LightIdentity,
    elements: &Elements<'_>,
    settings: &BakeSettings,
    part: BakePart,
    input: Option<&Path>,
    job: &mut RunningJob<'_>,
) -> Result<LightState, Error> {
    let state = start(&identity, elements, part, input, job)?;
    let (cancel, path) = (job.options.cancel.clone(), job.options.checkpoint.clone());
    let write = |path: &Path, state: &BakeState| {
        elements.scene.check_textures()?;
        light_file::write_state(path, &identity, state)
    };
    let mut sink = JobSink::new(job, path.clone(), write);
    let state = match bake_part(state, elements, settings, part, &mut sink, &cancel) {
        Ok(state) => state,
        Err(BakeError::Interrupted(interrupted)) => return sink.written.and(Err(interrupted.into())),
        Err(error) => return Err(Error::Bake(error)),
    };
    elements.scene.check_textures()?;
    let light = LightState { identity, state, warnings: std::mem::take(&mut job.warnings) };
    path.map_or(Ok(()), |path| light.save_checkpoint(path))?;
    Ok(light)
}

/// The state from which a part is computed.
fn start(
    identity: &LightIdentity,
    elements: &Elements<'_>,
    part: BakePart,
    input: Option<&Path>,
    job: &mut RunningJob<'_>,
) -> Result<BakeState, Error> {
    let no_part =
        |path: Option<&Path>| JoinError::NoPart { part: path.map(Path::to_owned).unwrap_or_default() };
    let checkpoint = job.options.checkpoint.clone().filter(|path| job.options.resume && path.exists());
    if checkpoint.is_none()
        && let Some(path) = input
    {
        return match LightFile::read(path)?.start(identity, elements)? {
            BakeStart::State(mut state) => {
                state.parts = None;
                Ok(state)
            }
            BakeStart::Finished(_) => Err(no_part(Some(path)).into()),
        };
    }
    let BakeStart::State(state) = start_of(identity, elements, job)? else {
        return Err(no_part(checkpoint.as_deref()).into());
    };
    match checkpoint {
        Some(path) if !state.parts.as_ref().is_some_and(|parts| parts.is_only(part)) => {
            Err(FileFault::Identity(IdentityMismatch {
                foreign: LightIdentity::FOREIGN,
                what: "the part",
                found: state.parts.as_ref().map_or_else(|| "all of it".to_owned(), named),
                wanted: named(&BakeParts::of(part, false)),
            })
            .of(&path))
        }
        _ => Ok(state),
    }
}

/// Parts in words.
fn named(parts: &BakeParts) -> String {
    let direct = if parts.direct_only { " of the direct light" } else { "" };
    match parts.finished.keys().next() {
        Some(number) if parts.finished.len() == 1 => format!("{number}/{}{direct}", parts.count),
        _ => format!("joined from {}{direct}", parts.count),
    }
}

/// Joins parts of one bake. They are read one after the other, so that the whole and one part are in memory.
pub(crate) fn join(
    parts: Vec<PartFile>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<LightState, Error> {
    let mut joined: Option<(LightIdentity, BakeState, BakeParts)> = None;
    let mut taken: Vec<(PathBuf, BakeParts)> = Vec::new();
    for part in parts {
        job.options.cancel.check()?;
        let path = part.path.clone();
        let read = part.bytes().and_then(|bytes| LightFile::from_bytes(&path, &bytes));
        let Some(file) = readable(read, options, job)? else { continue };
        let of_part =
            file.into_state().and_then(|(identity, state)| Some((identity, state.parts.clone()?, state)));
        let Some((identity, of_part, state)) = of_part else {
            return Err(JoinError::NoPart { part: path }.into());
        };
        match &mut joined {
            None => joined = Some((identity, state, of_part.clone())),
            Some((wanted, whole, first)) => {
                check(&identity, &of_part, wanted, first).map_err(|mismatch| JoinError::Identity {
                    kind: PartKind::Light,
                    parts: [taken.first().map(|(path, _)| path.clone()).unwrap_or_default(), path.clone()],
                    mismatch: Box::new(mismatch),
                })?;
                whole.merge(state).map_err(|conflict| conflict_of(conflict, &path, &taken))?;
            }
        }
        taken.push((path, of_part));
    }
    let (identity, state, _) = joined.ok_or(JoinError::Empty)?;
    let missing: Vec<MissingPart> =
        state.parts.iter().flat_map(BakeParts::missing).map(missing_part).collect();
    check_missing(missing, options, job)?;
    Ok(LightState { identity, state, warnings: std::mem::take(&mut job.warnings) })
}

fn missing_part((part, has_begun): (glanz_job::JobPart, bool)) -> MissingPart {
    let missing = if has_begun { "some texels" } else { "all its texels" }.to_owned();
    MissingPart { part, missing, is_whole: !has_begun }
}

/// Refuses a part of another bake, or of another division of it.
fn check(
    identity: &LightIdentity,
    parts: &BakeParts,
    wanted: &LightIdentity,
    first: &BakeParts,
) -> Result<(), IdentityMismatch> {
    identity.check(wanted)?;
    let end = |parts: &BakeParts| if parts.direct_only { "the direct light" } else { "all light" }.to_owned();
    let fields = [
        ("the number of parts", parts.count.to_string(), first.count.to_string()),
        ("the light of the parts", end(parts), end(first)),
    ];
    match fields.into_iter().find(|(_, found, wanted)| found != wanted) {
        Some((what, found, wanted)) => {
            Err(IdentityMismatch { foreign: LightIdentity::FOREIGN, what, found, wanted })
        }
        None => Ok(()),
    }
}

/// The error with the files that cause it.
fn conflict_of(conflict: BakeConflict, path: &Path, taken: &[(PathBuf, BakeParts)]) -> JoinError {
    let first = taken.first();
    let with = |other: Option<&(PathBuf, BakeParts)>| {
        [other.map(|(path, _)| path.clone()).unwrap_or_default(), path.to_owned()]
    };
    match conflict {
        BakeConflict::Part(number) => {
            let other = taken.iter().find(|(_, parts)| parts.finished.contains_key(&number));
            let count = other.map_or(0, |(_, parts)| parts.count);
            JoinError::Overlap { parts: with(other), common: format!("part {number}/{count}") }
        }
        BakeConflict::Division => {
            JoinError::Contradiction { parts: with(first), what: "the division into parts" }
        }
        BakeConflict::Light(what) => JoinError::Contradiction { parts: with(first), what },
    }
}
