#![doc = include_str!("../README.md")]

mod area;
mod builder;
pub mod camera;
pub mod chart;
pub mod description;
pub mod diagnostic;
pub mod error;
mod interaction;
pub mod light;
mod object;
mod placed;
mod placed_area;
mod receiver;
mod resolve;
mod scene;
mod statistics;

pub use builder::{SceneBuilder, ShapeMaterial};
pub use camera::{Camera, Projected};
pub use chart::Chart;
pub use description::{Description, Location};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use error::{SceneError, SceneErrorKind, SceneWarning};
pub use interaction::{Interaction, Reference};
pub use light::{IncidentLight, Light, LightId, LightRay, LightSample, MAX_LIGHT_GROUPS};
pub use object::Object;
pub use placed::{Place, PlacedPoint, PlacedSurface};
pub use receiver::NamedReceiver;
pub use scene::{MAX_NESTING, Scene};
pub use statistics::Statistics;
