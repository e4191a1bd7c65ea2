//! Joining of particle tallies.

use std::path::{Path, PathBuf};

use glanz_illumination::Tally;
use glanz_job::{IdentityMismatch, JobIdentity, JobPart};
use glanz_report::number::grouped;
use glanz_transport::ParticleRanges;

use super::tally_file::{self, TallyFile, TallyPlan};
use crate::error::Error;
use crate::event::Warning;
use crate::merge::{JoinError, MergeOptions, MissingPart, PartFile, PartKind, check_missing, readable};
use crate::running_job::RunningJob;

/// The particles of joined parts of a calculation of illuminance.
#[derive(Clone, Debug)]
pub struct JoinedTally {
    file: TallyFile,
    /// Warnings of parts that were left out or are missing.
    pub warnings: Vec<Warning>,
}

impl JoinedTally {
    /// Sums of all particles, with their numbers.
    #[must_use]
    pub fn tally(&self) -> &Tally {
        &self.file.tally
    }

    /// Writes a checkpoint, from which [`IlluminateBuilder`](super::IlluminateBuilder) makes the reports, and traces what is missing.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_checkpoint(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let TallyFile { identity, plan, tally } = &self.file;
        tally_file::write(path.as_ref(), identity, *plan, tally)
    }
}

/// Joins parts of one calculation. They are read one after the other, so that two tallies are in memory.
pub(crate) fn join(
    parts: Vec<PartFile>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<JoinedTally, Error> {
    let mut joined: Option<(TallyFile, TallyPlan)> = None;
    let mut taken: Vec<(PathBuf, ParticleRanges)> = Vec::new();
    for part in parts {
        job.options.cancel.check()?;
        let path = part.path.clone();
        let read = part.bytes().and_then(|bytes| TallyFile::from_bytes(&path, &bytes));
        let Some(next) = readable(read, options, job)? else { continue };
        let Some(plan) = next.plan else { return Err(JoinError::NoPart { part: path }.into()) };
        let particles = next.tally.particles().clone();
        match &mut joined {
            None => joined = Some((next, TallyPlan { part: None, ..plan })),
            Some((whole, of_whole)) => add(whole, *of_whole, &next, plan, &path, &taken)?,
        }
        taken.push((path, particles));
    }
    let (file, plan) = joined.ok_or(JoinError::Empty)?;
    check_missing(missing(plan, file.tally.particles()), options, job)?;
    let file = TallyFile { plan: Some(plan), ..file };
    Ok(JoinedTally { file, warnings: std::mem::take(&mut job.warnings) })
}

/// Adds a part; `taken`: the parts before it, with their particles.
fn add(
    whole: &mut TallyFile,
    of_whole: TallyPlan,
    next: &TallyFile,
    plan: TallyPlan,
    path: &Path,
    taken: &[(PathBuf, ParticleRanges)],
) -> Result<(), Error> {
    let first = || taken.first().map(|(path, _)| path.clone()).unwrap_or_default();
    let foreign = |mismatch: IdentityMismatch| JoinError::Identity {
        kind: PartKind::Illuminance,
        parts: [first(), path.to_owned()],
        mismatch: Box::new(mismatch),
    };
    next.identity.check(&whole.identity).map_err(foreign)?;
    TallyPlan { part: None, ..plan }.check(&of_whole).map_err(foreign)?;
    if !next.tally.has_shape_of(&whole.tally) {
        return Err(TallyFile::senseless(path));
    }
    whole.tally.merge(&next.tally).map_err(|shared| {
        let other = taken.iter().find(|(_, particles)| particles.overlap(next.tally.particles()).is_some());
        JoinError::Overlap {
            parts: [other.map(|(path, _)| path.clone()).unwrap_or_default(), path.to_owned()],
            common: format!("particles {} to {}", grouped(shared.start), grouped(shared.end - 1)),
        }
    })?;
    Ok(())
}

/// The parts of which particles are missing.
fn missing(plan: TallyPlan, particles: &ParticleRanges) -> Vec<MissingPart> {
    let of_part = |number| {
        let part = JobPart::try_new(number, plan.count)?;
        let share = part.share(0..plan.particles);
        let gaps = particles.missing(share.clone());
        if gaps.is_empty() {
            return None;
        }
        let ranges: Vec<String> =
            gaps.iter().map(|gap| format!("{}..{}", grouped(gap.start), grouped(gap.end))).collect();
        let missing = format!("particles {}", ranges.join(", "));
        Some(MissingPart { part, missing, is_whole: gaps == [share] })
    };
    (1..=plan.count).filter_map(of_part).collect()
}
