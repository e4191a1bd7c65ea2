//! The light that leaves a scene as a ray file.

use std::path::Path;

use glanz_formats::photometry::tm25::{RayWriter, SourceDescriptions};
use glanz_illumination::escaped_rays;
use glanz_job::{JobEnd, current_version};

use super::design::Design;
use super::{IlluminateOutcome, facts};
use crate::error::{Error, FileFault};
use crate::event::Warning;
use crate::file;
use crate::job_options::JobOptions;
use crate::running_job::{JobSink, RunningJob};

/// Refuses an extension that is not that of ray files.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Extension`].
pub fn check_ray_path(path: &Path) -> Result<(), Error> {
    let is_known = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tm25ray"));
    if is_known { Ok(()) } else { Err(FileFault::Extension("rays").of(path)) }
}

impl IlluminateOutcome {
    /// Writes the rays of all particles that leave the scene to a ray file of IES TM-25, from their last surface or their light, in the frame of the scene, and adds their
    /// number and flux to the facts of the report.
    ///
    /// The particles are traced once more for it, so that it does not depend on a checkpoint. Of the options of `job`, those of checkpoints have no effect. A cancelled job
    /// leaves an old file as it is.
    ///
    /// # Errors
    /// [`Error::NoRayFile`] if the scene was not kept ([`IlluminateBuilder::ray_file`](super::IlluminateBuilder::ray_file)) or the calculation was cancelled, [`Error::File`]; the
    /// illuminance is not lost by them.
    pub fn save_ray_file(&mut self, path: impl AsRef<Path>, job: JobOptions<'_>) -> Result<JobEnd, Error> {
        let path = path.as_ref();
        check_ray_path(path)?;
        file::check_writable(path)?;
        let design = self.design.clone().ok_or(Error::NoRayFile)?;
        let particles = design.options.goal.particles.ok_or(Error::RayGoal)?;
        let mut job = job.start();
        let written = job.in_pool(|job| write(&design, particles, path, job))?;
        self.warnings.append(&mut job.warnings);
        let Some((count, lumens)) = written else { return Ok(JobEnd::Interrupted) };
        self.rays = Some(count);
        self.report.facts.push("rays in the ray file", "ray_file_rays", count);
        self.report.facts.push("flux of the ray file, lm", "ray_file_lm", lumens);
        Ok(JobEnd::Complete)
    }
}

/// Writes the rays of `particles` particles that leave the scene; returns their number and their flux, lm, or `None` if the job was cancelled, when an old file
/// keeps its content.
fn write(
    design: &Design,
    particles: u64,
    path: &Path,
    job: &mut RunningJob<'_>,
) -> Result<Option<(u64, f64)>, Error> {
    let settings = design.trace_settings(job);
    let descriptions = SourceDescriptions {
        name: design.name.clone(),
        file_creator: format!("Glanz {}", current_version()),
        information: format!("Light that leaves the scene, by {particles} particles, seed {}", settings.seed),
        ..SourceDescriptions::default()
    };
    let date = facts::date_now().unwrap_or_default();
    let cancel = job.options.cancel.clone();
    let mut sink = JobSink::new(job, None, |_: &Path, (): &()| Ok(()));
    let (mut end, mut written) = (JobEnd::Complete, (0, 0.0));
    let replaced = file::write_file_with(path, |file| {
        let mut rays = RayWriter::new(file, &descriptions, &date)?;
        end = escaped_rays(&design.scene, &settings, particles, &mut sink, &cancel, |ray| {
            rays.ray(ray.origin, ray.direction, ray.lumens as f32)
        })?;
        if end == JobEnd::Interrupted {
            return Err(std::io::ErrorKind::Interrupted.into());
        }
        written = rays.finish()?;
        Ok(())
    });
    if end == JobEnd::Interrupted {
        return Ok(None);
    }
    replaced?;
    if written.0 == 0 {
        job.warn(Warning::NoRays);
    }
    Ok(Some(written))
}
