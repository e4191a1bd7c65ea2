//! Facts about a calculation for its reports.

use std::ffi::{OsStr, OsString};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use chrono::DateTime;
use glanz_illumination::daylight::OUTDOOR_LUX;
use glanz_illumination::{FarFieldResolution, GridResolution};
use glanz_job::{current_version, processor_name};
use glanz_report::{FactList, FactValue};

use super::{IlluminateMethod, IlluminateOptions};

/// Environment variable with the date of reports that are to be the same for equal calculations: seconds since 1970, as
/// <https://reproducible-builds.org/specs/source-date-epoch/> has it.
const FIXED_DATE: &str = "SOURCE_DATE_EPOCH";

/// Facts of a calculation.
#[derive(Debug, Default)]
pub(super) struct CalculationFacts {
    /// Settings and results: the same for equal calculations.
    pub(super) result: FactList,
    /// Times, rates and the machine, which differ from run to run.
    pub(super) run: FactList,
}

impl CalculationFacts {
    /// Program, scene, and all settings that decide the result.
    pub(super) fn of_settings(scene: &str, content_hash: u128, options: &IlluminateOptions) -> Self {
        let mut facts = FactList::default();
        facts.push("Glanz version", "glanz_version", current_version());
        facts.push("scene", "scene", scene);
        facts.push("content hash of the scene", "scene_content_hash", format!("{content_hash:032x}"));
        facts.push("method", "method", options.method.name());
        match options.resolution {
            GridResolution::Cells([u, v]) => facts.push("cells", "cells", format!("{u} x {v}")),
            GridResolution::Longer(cells) => {
                facts.push("cells along the longer side", "cells_along_longer_side", u64::from(cells));
            }
            GridResolution::Texel(length) => facts.push("length of cells, m", "cell_m", length),
        }
        if options.daylight {
            facts.push("daylight: illuminance of the open ground, lx", "outdoor_lux", OUTDOOR_LUX);
        }
        if let Some(room) = options.room {
            facts.push("room", "room_m", FactValue::Lengths(room.to_array()));
        }
        if options.method != IlluminateMethod::Trace {
            facts.push(
                "tolerance of the integration",
                "relative_tolerance",
                FactValue::Fraction(options.integration_tolerance()),
            );
        }
        if options.method != IlluminateMethod::Integrate {
            let goal = &options.goal;
            if let Some(particles) = goal.particles {
                facts.push("goal: particles", "goal_particles", particles);
            }
            if let Some(error) = goal.error {
                facts.push("goal: relative error", "goal_relative_error", FactValue::Fraction(error));
            }
            if let Some(time) = goal.time {
                facts.push("goal: time", "goal_seconds", FactValue::Seconds(time.as_secs_f64()));
            }
            if let Some(part) = options.part {
                facts.push("part", "part", part.to_string());
            }
            facts.push("seed", "seed", FactValue::Whole(options.seed));
            facts.push("largest depth", "max_depth", u64::from(options.max_depth));
            facts.push("far field counted", "far_field", options.far_field.is_some());
            if let Some(FarFieldResolution::Steps { gamma, plane }) = options.far_field {
                facts.push("step of gamma, degrees", "far_field_gamma_degrees", gamma.degrees());
                facts.push("step from plane to plane, degrees", "far_field_plane_degrees", plane.degrees());
            }
        }
        Self { result: facts, run: FactList::default() }
    }

    /// Adds a rate to the run.
    pub(super) fn push_rate(&mut self, name: &'static str, key: &'static str, count: u64, time: Duration) {
        self.run.push(name, key, count as f64 / time.as_secs_f64());
    }

    /// All facts, with the machine and the date, after a calculation of this time by `threads`.
    ///
    /// With [`FIXED_DATE`] these are the facts of the result and that date.
    pub(super) fn finish(self, time: Duration, threads: usize) -> FactList {
        let fixed = std::env::var_os(FIXED_DATE);
        let Self { result: mut facts, mut run } = self;
        if fixed.is_none() {
            run.push("time", "seconds", FactValue::Seconds(time.as_secs_f64()));
            run.push("threads", "threads", threads as u64);
            if let Some(processor) = processor_name() {
                run.push("processor", "processor", processor);
            }
            facts.append(run);
        }
        if let Some(date) = date(fixed, SystemTime::now()) {
            facts.push("end, UTC", "end_utc", date);
        }
        facts
    }
}

/// The fixed date, or that of the clock, as of [`date`].
#[cfg(feature = "formats")]
pub(super) fn date_now() -> Option<String> {
    date(std::env::var_os(FIXED_DATE), SystemTime::now())
}

/// The fixed date, or that of the clock, after ISO 8601: `2026-11-26T16:05:00Z`; `None` for one that is no number of seconds.
fn date(fixed: Option<OsString>, clock: SystemTime) -> Option<String> {
    let seconds = match fixed.as_deref().map(OsStr::to_str) {
        Some(text) => text?.parse().ok()?,
        None => clock.duration_since(UNIX_EPOCH).ok()?.as_secs().try_into().ok()?,
    };
    Some(format!("{:?}Z", DateTime::from_timestamp(seconds, 0)?.naive_utc()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_fixed_by_the_environment_and_otherwise_of_the_clock() {
        let clock = UNIX_EPOCH + Duration::from_millis(951_782_400_999);
        let of = |fixed: Option<&str>| date(fixed.map(OsString::from), clock);
        // 2000 was a leap year.
        assert_eq!(of(None).as_deref(), Some("2000-02-29T00:00:00Z"));
        assert_eq!(of(Some("0")).as_deref(), Some("1970-01-01T00:00:00Z"));
        assert_eq!(of(Some("4102444799")).as_deref(), Some("2099-12-31T23:59:59Z"));
        for senseless in ["", "now", "1e9", "99999999999999999999", "9999999999999999"] {
            assert_eq!(of(Some(senseless)), None, "{senseless}");
        }
    }
}
