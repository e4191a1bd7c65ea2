//! Ratings of a lit scene by standards.

use std::time::Instant;

use glanz_illumination::planning::{PlanningError, PlanningRequest, PlanningSettings};
use glanz_job::{JobEnd, JobProgress};

use super::IlluminateOutcome;
use super::design::Design;
use crate::error::Error;
use crate::event::Warning;
use crate::running_job::RunningJob;

/// Adds the rating to the report. A calculation that was cancelled, or is while it is rated, has none.
pub(super) fn rate(
    design: &Design,
    request: &PlanningRequest,
    settings: &PlanningSettings,
    outcome: &mut IlluminateOutcome,
    job: &mut RunningJob<'_>,
) -> Result<(), Error> {
    if outcome.end == JobEnd::Interrupted {
        return Ok(());
    }
    let start = Instant::now();
    let cancel = job.options.cancel.clone();
    let rated = job.in_pool(|job| {
        let mut on_progress = |share: f64| {
            if let Some(sink) = &mut job.options.sink {
                sink.on_progress(&JobProgress::by_work("glare and cylinders", share, start.elapsed()));
            }
        };
        Ok(request.rate(&design.scene, &outcome.report.maps, settings, &mut on_progress, &cancel))
    })?;
    design.scene.check_textures()?;
    match rated {
        Ok(report) => {
            if let Some(reason) = &report.glare_refusal {
                job.warn(Warning::GlareNotRated { reason: reason.clone() });
            }
            outcome.report.plan = Some(report);
            Ok(())
        }
        Err(PlanningError::Interrupted(_)) => {
            outcome.end = JobEnd::Interrupted;
            // The figures of the light are complete.
            outcome.report.facts.push("rating interrupted", "rating_interrupted", true);
            Ok(())
        }
        Err(error) => Err(error.into()),
    }
}
