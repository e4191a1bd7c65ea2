//! Reports of a calculation of illuminance: tables and pictures for people, numbers for programs.
//!
//! The functions convert data to text, bytes or pixels and write no files. For one receiver there are [`csv`], the pixels
//! of [`false_colour()`] and [`lux_pixels`], and the drawing [`isolux()`]. A [`LuxReport`] of a whole calculation becomes
//! a table for a terminal, a page of HTML, or JSON by `serde`; a [`LuxComparison`] compares two designs.
//! The page of HTML begins with the sheets that a client gets: summary, luminaires, plan, requirements, assumptions, areas, other surfaces. [`PolarPlot`] draws the candela distribution of a luminaire.
//!
//! ```
//! use glanz_illumination::LuxMap;
//! use glanz_illumination::report::{LuxReport, csv, isolux, lux_scale};
//! use glanz_math::DVec3;
//!
//! // 1000 cd, 2 m above the middle of two squares of 1 m: 1000 * 2 / (4 + 0.5^2)^1.5 in the middle of each.
//! let lux = 2000.0 / 4.25_f64.powf(1.5);
//! let desk = LuxMap {
//!     name: "desk".into(),
//!     cells: [2, 1],
//!     size: [2.0, 1.0],
//!     positions: vec![DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0)],
//!     areas: vec![1.0; 2],
//!     lux: vec![lux; 2],
//!     errors: vec![0.0; 2],
//!     statistics: None,
//! };
//! assert_eq!(csv(&desk).lines().count(), 3);
//! assert!(isolux(&desk, &lux_scale(&[&desk])).starts_with("<svg"));
//! let report = LuxReport { title: "Office".into(), maps: vec![desk], ..LuxReport::default() };
//! assert!(report.text().contains("228.3"));
//! assert!(report.html().contains("<h1>Office</h1>"));
//! ```

mod client_area;
mod client_assumptions;
mod client_page;
mod client_room;
#[cfg(test)]
mod client_tests;
mod compare;
mod csv;
mod false_colour;
mod html;
mod isolux;
mod json;
mod lit_quantity;
mod polar;
mod scale;
mod text;

use glanz_report::FactList;

use crate::planning::{InstalledPower, OtherLight, PlanReport, PlanningSettings, RoomLayout};
use crate::{DaylightFactors, FarFieldSummary, FluxBalance, LuxMap};
use glanz_scene::description::ZoneKind;

pub use compare::{LuxComparison, ReceiverPair};
pub use csv::csv;
pub use false_colour::{false_colour, lux_pixels};
pub use isolux::{isolux, isolux_at};
pub use lit_quantity::LitQuantity;
pub use polar::PolarPlot;
pub use scale::lux_scale;
pub(crate) use text::{printable, shown_vector};

/// The results of a calculation of illuminance.
///
/// Its fields in JSON: `title`; `receivers`, each with `name`, `cells`, `size_m` and the fields of
/// [`LuxSummary`](crate::LuxSummary); `flux_balance` with the fields of [`FluxBalance`] or null; `far_field` with
/// the fields of [`FarFieldSummary`] or null; `daylight_factors`, if there are any, each with the fields of [`DaylightFactors`]; `plan`, if there is one, see [`PlanReport`]; if the room is
/// known, `room`, `luminaires` and `other_lights`, see [`RoomLayout`], and `power`, if it is stated, with `power_w`, `area_m2`, `w_m2`, and `w_m2_100lx` of `reference`; `shown`, see
/// [`LitQuantity`]; `facts`, an object of the facts by their keys. Receivers have the illuminance of the new installation, and under `shown` the figures that the pages for a client have. Numbers that are not finite, which JSON cannot represent, become null.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LuxReport {
    /// The name of the design.
    pub title: String,
    /// The receivers, in the order of the report.
    pub maps: Vec<LuxMap>,
    /// Balance of the flux; `None` for an integration of illuminance, which does not determine it.
    pub balance: Option<FluxBalance>,
    /// Figures of the light that left the scene, if it was counted by direction.
    pub far_field: Option<FarFieldSummary>,
    /// Daylight factors of the receivers; empty if they were not asked for.
    pub daylight: Vec<DaylightFactors>,
    /// Figures of the standards for a planned room; `None` if none was asked for.
    pub plan: Option<PlanReport>,
    /// Task and maintenance factor that were asked for, whether or not anything was rated by them.
    pub planning: PlanningSettings,
    /// The room with its luminaires; `None` if it is unknown.
    pub layout: Option<RoomLayout>,
    /// Facts about the calculation: program, scene, settings, particles, time.
    pub facts: FactList,
    /// Candela distributions of the whole optic or of its lamps.
    pub polars: Vec<PolarPlot>,
}

impl LuxReport {
    /// The maintenance factor; 1 for one out of range, by which nothing can be rated.
    #[must_use]
    pub fn maintenance_factor(&self) -> f64 {
        self.planning.maintenance.value().unwrap_or(1.0)
    }

    /// Electric power of the installation, which refers to the maintained illuminance of the task area of the plan, or else of the first receiver of a task area or the highest level
    /// one that faces up; `None` if the room is unknown, or the power of one of its lights.
    #[must_use]
    pub fn installed_power(&self) -> Option<InstalledPower> {
        let layout = self.layout.as_ref()?;
        let (watts, area) = (layout.watts()?, layout.floor_area());
        let level = || layout.receivers.iter().filter(|place| place.is_level);
        let task = level().find(|place| place.kind == Some(ZoneKind::Task));
        let place = task.or_else(|| level().max_by(|a, b| a.height.total_cmp(&b.height)));
        let of_place = || {
            let map = self.maps.get(place?.number)?;
            Some((map.name.clone(), self.maintenance_factor() * map.summary().mean))
        };
        let of_plan = self.plan.as_ref().and_then(|plan| plan.task_illuminance);
        // Daylight costs no power.
        let is_electric = layout.other_lights.iter().all(OtherLight::is_electric);
        let reference = of_plan.map(|lux| ("task area".to_owned(), lux)).or_else(of_place);
        let reference = reference.filter(|_| is_electric);
        Some(InstalledPower { watts, area, reference })
    }
}
