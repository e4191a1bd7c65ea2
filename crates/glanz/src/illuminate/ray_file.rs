//! The light that leaves a scene as a ray file.

use std::io;
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

/// Refuses an extension that is not that of ray files, and a pipe or a device, in which their header could not be completed at the end.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Extension`] or [`FileFault::NotRegular`].
pub fn check_ray_path(path: &Path) -> Result<(), Error> {
    let is_known = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tm25ray"));
    if !is_known {
        return Err(FileFault::Extension("rays").of(path));
    }
    match std::fs::metadata(path) {
        Ok(found) if !found.is_file() && !found.is_dir() => Err(FileFault::NotRegular.of(path)),
        _ => Ok(()),
    }
}

/// Facts of a ray file, for [`IlluminateOutcome::add_rays`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SavedRays {
    /// Number of rays; if it is 0, no file was written.
    pub count: u64,
    /// Their flux, lm.
    pub lumens: f64,
    /// Warnings of the job.
    pub warnings: Vec<Warning>,
}

impl IlluminateOutcome {
    /// Writes the rays of all particles that leave the scene to a ray file of IES TM-25, from their last surface or their light, in the frame of the scene, and adds their
    /// number and flux to the facts of the report: [`IlluminateOutcome::write_ray_file`] and [`IlluminateOutcome::add_rays`].
    ///
    /// # Errors
    /// Those of [`IlluminateOutcome::write_ray_file`].
    pub fn save_ray_file(&mut self, path: impl AsRef<Path>, job: JobOptions<'_>) -> Result<JobEnd, Error> {
        let Some(rays) = self.write_ray_file(path, job)? else { return Ok(JobEnd::Interrupted) };
        self.add_rays(rays);
        Ok(JobEnd::Complete)
    }

    /// Writes the ray file of [`IlluminateOutcome::save_ray_file`] without a change of the result; returns `None` if the job was cancelled.
    ///
    /// The particles are traced once more for it, so that it does not depend on a checkpoint. Of the options of `job`, those of checkpoints have no effect. A cancelled job
    /// leaves an old file as it is, and so does a scene that no light leaves, with [`Warning::NoRays`].
    ///
    /// # Errors
    /// [`Error::NoRayFile`] if the scene was not kept ([`IlluminateBuilder::ray_file`](super::IlluminateBuilder::ray_file)) or the calculation was cancelled, [`Error::File`]; the
    /// illuminance is not lost by them.
    pub fn write_ray_file(
        &self,
        path: impl AsRef<Path>,
        job: JobOptions<'_>,
    ) -> Result<Option<SavedRays>, Error> {
        let path = path.as_ref();
        check_ray_path(path)?;
        file::check_writable(path)?;
        let design = self.design.as_deref().ok_or(Error::NoRayFile)?;
        let particles = design.options.goal.particles.ok_or(Error::RayGoal)?;
        let mut job = job.start();
        let written = job.in_pool(|job| write(design, particles, path, job))?;
        Ok(written.map(|(count, lumens)| SavedRays { count, lumens, warnings: job.warnings }))
    }

    /// Adds the facts and warnings of a ray file to the result.
    pub fn add_rays(&mut self, rays: SavedRays) {
        let SavedRays { count, lumens, warnings } = rays;
        self.warnings.extend(warnings);
        self.rays = Some(count);
        self.report.facts.push("rays in the ray file", "ray_file_rays", count);
        self.report.facts.push("flux of the ray file, lm", "ray_file_lm", lumens);
    }
}

/// Writes the rays of `particles` particles that leave the scene; returns their number and their flux, lm, or `None` if the job was cancelled. An old file keeps its
/// content then, and without rays.
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
    let (mut end, mut written, mut textures) = (JobEnd::Complete, None, Ok(()));
    let replaced = file::write_file_with(path, |file| {
        let mut rays = RayWriter::new(file, &descriptions, &date)?;
        end = escaped_rays(&design.scene, &settings, particles, &mut sink, &cancel, |ray| {
            rays.ray(ray.origin, ray.direction, ray.lumens as f32)
        })?;
        // An error keeps the old file.
        if end == JobEnd::Interrupted {
            return Err(io::ErrorKind::Interrupted.into());
        }
        textures = design.scene.check_textures();
        if textures.is_err() {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let (count, lumens) = rays.finish()?;
        written = Some((count, lumens));
        if count == 0 { Err(io::ErrorKind::InvalidData.into()) } else { Ok(()) }
    });
    textures?;
    match written {
        _ if end == JobEnd::Interrupted => return Ok(None),
        Some((0, _)) => job.warn(Warning::NoRays),
        _ => replaced?,
    }
    Ok(written)
}
