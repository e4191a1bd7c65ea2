//! Joining of checkpoints: the parts of one job that were computed separately.

mod error;
mod films;
mod part_file;

use std::path::Path;

use glanz_job::ResourceLimits;

#[cfg(feature = "radiosity")]
use crate::bake::{self, LightState};
use crate::error::Error;
use crate::event::Warning;
#[cfg(feature = "illumination")]
use crate::illuminate::{self, JoinedTally};
use crate::job_options::JobOptions;
use crate::render::Picture;
use crate::running_job::RunningJob;

pub use error::{JoinError, MissingPart, MissingParts};
pub(crate) use part_file::PartFile;
pub use part_file::PartKind;
use part_file::common_kind;

/// Options of [`merge`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MergeOptions {
    /// Whether parts that are missing or damaged are left out, with a [`Warning`], instead of being errors.
    pub partial: bool,
    /// Whether the result must be a picture.
    pub picture: bool,
    /// Memory that the film of the whole may take, bytes: a larger one is in a temporary file. `None`: half of the [limit](glanz_job::ResourceLimits::memory).
    pub film_memory: Option<u64>,
}

impl MergeOptions {
    fn memory_of_film(&self) -> u64 {
        self.film_memory.unwrap_or_else(|| ResourceLimits::default().memory / 2)
    }
}

/// The whole, or what is there of it, joined by [`merge`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum MergeOutcome {
    /// A picture, of parts that were rendered.
    Picture(Box<Picture>),
    /// Particles, of parts of a calculation of illuminance.
    #[cfg(feature = "illumination")]
    Illuminance(Box<JoinedTally>),
    /// Light, of parts of a bake.
    #[cfg(feature = "radiosity")]
    Light(Box<LightState>),
}

impl MergeOutcome {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> PartKind {
        match self {
            Self::Picture(_) => PartKind::Picture,
            #[cfg(feature = "illumination")]
            Self::Illuminance(_) => PartKind::Illuminance,
            #[cfg(feature = "radiosity")]
            Self::Light(_) => PartKind::Light,
        }
    }

    /// Warnings of parts that were left out or are missing.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        match self {
            Self::Picture(picture) => picture.warnings(),
            #[cfg(feature = "illumination")]
            Self::Illuminance(joined) => &joined.warnings,
            #[cfg(feature = "radiosity")]
            Self::Light(joined) => &joined.warnings,
        }
    }

    /// Writes a checkpoint like that of a single run, to be resumed or joined with others.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_checkpoint(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        match self {
            Self::Picture(picture) => picture.save_checkpoint(path),
            #[cfg(feature = "illumination")]
            Self::Illuminance(joined) => joined.save_checkpoint(path),
            #[cfg(feature = "radiosity")]
            Self::Light(joined) => joined.save_checkpoint(path),
        }
    }
}

/// Joins the checkpoints `paths`, parts of one job that have nothing in common, to the same bits as one run of the whole. Of `job`, threads, progress, events and
/// cancelling have an effect; the result is saved by its own methods.
///
/// # Errors
/// [`Error::File`] for a checkpoint that cannot be read, [`Error::Join`] for parts that do not belong together, [`Error::Interrupted`].
pub fn merge<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    options: MergeOptions,
    job: JobOptions<'_>,
) -> Result<MergeOutcome, Error> {
    let mut job = job.start();
    let mut parts = Vec::new();
    for path in paths {
        job.options.cancel.check()?;
        parts.extend(readable(PartFile::open(path.as_ref()), options, &mut job)?);
    }
    let kind = common_kind(&parts)?;
    job.in_pool(|job| match kind {
        PartKind::Picture => Ok(MergeOutcome::Picture(Box::new(films::join(parts, options, job)?))),
        kind if options.picture => Err(JoinError::NoPicture { kind }.into()),
        #[cfg(feature = "illumination")]
        PartKind::Illuminance => {
            Ok(MergeOutcome::Illuminance(Box::new(illuminate::join(parts, options, job)?)))
        }
        #[cfg(feature = "radiosity")]
        PartKind::Light => Ok(MergeOutcome::Light(Box::new(bake::join(parts, options, job)?))),
        #[cfg(not(all(feature = "illumination", feature = "radiosity")))]
        kind => Err(JoinError::Unsupported { kind }.into()),
    })
}

/// An error if parts are missing, or a warning if only what is there is joined.
pub(crate) fn check_missing(
    missing: Vec<MissingPart>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<(), Error> {
    match missing.is_empty() {
        true => {}
        false if options.partial => job.warn(Warning::PartsMissing(MissingParts(missing))),
        false => return Err(JoinError::Missing(MissingParts(missing)).into()),
    }
    Ok(())
}

/// What was read of a part, or `None` for a part that is left out.
pub(crate) fn readable<T>(
    read: Result<T, Error>,
    options: MergeOptions,
    job: &mut RunningJob<'_>,
) -> Result<Option<T>, Error> {
    match read {
        Err(error @ Error::File { .. }) if options.partial => {
            job.warn(Warning::PartLeftOut { reason: error.to_string() });
            Ok(None)
        }
        read => read.map(Some),
    }
}
