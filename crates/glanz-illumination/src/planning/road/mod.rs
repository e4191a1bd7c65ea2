//! Figures of road lighting.
//!
//! x is the direction of travel, y to its left, z up; the carriageway reaches from y = 0 to its width. [`RoadLayout`] places luminaires in endless rows, a [`RoadSurface`] is
//! an r-table, and [`RoadLayout::rate`] computes a [`RoadReport`] in the field between two luminaires of a row:
//!
//! - points: along the road 10, or as many as make their distance 3 m at most; across it 3 in each lane for luminances, and for illuminances at least 3 that are 1.5 m apart at most;
//!   each in the middle of its part of the field;
//! - observers: 1.5 m high, in the middle of each lane, 60 m before the field; the figure of the worst one counts;
//! - luminance: the sum of `I r / H^2` over luminaires, with r for the angle beta between the directions to the point and on to the luminaire, and tan epsilon, the distance of the
//!   luminaire's foot over its height;
//! - [`ThresholdIncrement`]: an observer from 2.75 (H - 1.5 m) before the field on, in steps of the points; the line of sight is 1 degree below the horizontal; luminaires up to 500 m
//!   ahead count, except those above a plane that rises by 20 degrees from the eye, where the roof of the car is;
//! - edge illuminance ratio: mean illuminance of a strip beside the carriageway, as wide as a lane, over that of the strip within; the smaller one of both edges.
//!
//! # Source
//! EN 13201-2 and EN 13201-3 of 2015 (@en13201), which were not available: from open secondary literature and general knowledge of the field. The r-tables of CIE 144 (R1 to R4, C1, C2)
//! were not found in a source that can be trusted with every number; a file has to provide them.

mod class;
mod layout;
mod r_table;
mod rating;
mod threshold_increment;

pub use class::RoadClass;
pub use layout::{LuminaireRow, RoadError, RoadLayout, RowArrangement};
pub use r_table::{RTableError, RoadSurface};
pub use rating::{RoadLuminance, RoadRatingError, RoadReport};
pub use threshold_increment::{OBSERVER_AGE, ThresholdIncrement, threshold_increment, veiling_luminance};
