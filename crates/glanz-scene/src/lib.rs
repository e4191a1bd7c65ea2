//! From a description to a scene that cannot be wrong.

pub mod description;
pub mod error;

pub use description::{Description, Location};
pub use error::{SceneError, SceneErrorKind, SceneWarning};
