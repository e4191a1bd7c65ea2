//! Figures of lighting planners after European standards.
//!
//! | figure | module | standard |
//! |---|---|---|
//! | unified glare rating of observers | [`glare`] | EN 12464-1, clause on discomfort glare; CIE 117 |
//! | table of UGR of a luminaire | [`ugr_table`] | CIE 117, CIE 190 |
//! | cylindrical and semi-cylindrical illuminance, modelling | [`point_illuminance`] | EN 12665, EN 12464-1 |
//! | maintenance factor | [`maintenance`] | CIE 97 |
//! | luminance, illuminance and glare of roads | [`road`] | EN 13201-2, EN 13201-3 |
//! | escape routes, open areas, disability glare | [`emergency`] | EN 1838 |
//! | requirements of tasks, verdicts | [`requirement`] | EN 12464-1 |
//!
//! Surfaces that emit light glare by each of their parts.
//!
//! A [`RoomPlan`] is a plain room with luminaires on a grid; a [`PlanningRequest`] says what is to be rated in a scene, and makes a
//! [`PlanReport`] of it.
//!
//! The texts of these standards were not available when this was written. Formulas and limits are from open secondary literature, which
//! each module names; whoever signs a plan compares them with the text. `docs/lighting.md` has examples calculated by hand.

pub mod emergency;
pub mod glare;
pub mod luminaire;
pub mod luminaire_list;
pub mod maintenance;
mod plan_outline;
pub mod plan_report;
pub mod point_illuminance;
pub mod power;
pub mod request;
pub mod requirement;
pub mod road;
pub mod room;
pub mod room_layout;
mod room_shapes;
mod room_walls;
pub mod ugr_table;

#[cfg(test)]
pub(crate) mod test_luminaires;

pub use glare::{GlareError, GlareObserver, GlareRating, GlareSource, unified_glare_rating};
pub use luminaire::{PlacedLuminaire, projected_area};
pub use luminaire_list::{LuminaireGroup, LuminairePlace, OtherLight};
pub use maintenance::{MaintenanceError, MaintenanceFactor};
pub use plan_report::{CylindricalPoint, PlanReport};
pub use point_illuminance::{PointGather, PointIlluminance, PointReceiver};
pub use power::InstalledPower;
pub use request::{LitZone, PlanningError, PlanningRequest, PlanningSettings, ZoneKind};
pub use requirement::{
    LightingCriterion, LightingTask, OFFICE_TASKS, Requirement, RequirementVerdict, VerdictOutcome,
};
pub use room::{LuminaireKind, RoomPlan, RoomPlanError};
pub use room_layout::{ReceiverPlace, RoomLayout, RoomSurface, RoomSurfaceKind};
pub use ugr_table::{LuminaireAxis, UgrTable};
