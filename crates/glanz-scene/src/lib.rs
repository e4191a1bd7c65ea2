#![doc = include_str!("../README.md")]

mod alpha;
mod area;
mod batch;
mod builder;
pub mod camera;
pub mod description;
pub mod diagnostic;
mod differential;
mod edge_section;
pub mod error;
mod hit;
mod hit_location;
mod interaction;
pub mod light;
pub mod medium;
mod object;
pub mod parameterization;
mod path_batch;
mod placed;
mod placed_area;
mod placed_edges;
mod receiver;
mod resolve;
mod scene;
mod section;
mod solid;
mod statistics;
pub mod studio;
mod surface_detail;
pub mod tessellation;

pub use builder::{SceneBuilder, ShapeMaterial};
pub use camera::{Camera, CameraRay, FilmProjection};
pub use description::{Description, Location};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use differential::{RayDifferential, SurfaceDifferential};
pub use error::{SceneError, SceneErrorKind, SceneWarning};
pub use hit::SceneHit;
pub use hit_location::HitLocation;
pub use interaction::{Interaction, LightSampleContext};
pub use light::{
    IncidentLight, Light, LightId, LightRange, LightRay, LightSample, MAX_LIGHT_GROUPS, SelectedLight,
};
pub use medium::{Medium, MediumId};
pub use object::SceneObject;
pub use parameterization::ShapeParameterization;
pub use path_batch::BatchedPath;
pub use placed::{ParametricPoint, PlacedPoint, PlacedSurface};
pub use placed_edges::PlacedEdges;
pub use receiver::NamedReceiver;
pub use scene::{MAX_NESTING, Scene};
pub use statistics::SceneStatistics;
