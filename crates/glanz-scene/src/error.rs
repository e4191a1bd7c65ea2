//! Errors and warnings of descriptions.

use glanz_geometry::SurfaceError;
use glanz_job::BudgetError;
use glanz_light::SkyError;
use glanz_math::TransformError;
use glanz_shading::MaterialError;

use crate::description::Location;

/// The reason that a [`crate::description::Description`] is not a scene, and its place in the input.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{kind}")]
pub struct SceneError {
    /// The place at fault, if the part was read from a file.
    pub location: Option<Location>,
    /// The reason.
    pub kind: SceneErrorKind,
}

/// Faults of descriptions.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// A matrix that is not an invertible affine map.
    #[error("{what}: {source}")]
    Transform {
        /// The part that it transforms.
        what: &'static str,
        /// The reason.
        source: TransformError,
    },
    /// A surface with invalid parameters.
    #[error("shape: {0}")]
    Surface(#[from] SurfaceError),
    /// Trimming loops that are invalid.
    #[error("trimming: {0}")]
    Trim(SurfaceError),
    /// A parameter outside its range.
    #[error("{what} is {value}; it must be {range}")]
    Range {
        /// The parameter.
        what: &'static str,
        /// Its value.
        value: String,
        /// The allowed range.
        range: &'static str,
    },
    /// A sky with invalid parameters.
    #[error("sky: {0}")]
    Sky(#[from] SkyError),
    /// An index without an entry; a fault of the reader.
    #[error("{what} number {index} does not exist; there are {count}")]
    Reference {
        /// Kind of the entry.
        what: &'static str,
        /// The index.
        index: usize,
        /// Number of entries.
        count: usize,
    },
    /// A mixture of materials without an end.
    #[error(
        "material {name} is a mixture of itself, or one of more than {limit} mixtures within each other; use other materials"
    )]
    Mixture {
        /// Name of the material in quotation marks.
        name: String,
        /// The largest depth.
        limit: usize,
    },
    /// A name unknown to a [`SceneBuilder`](crate::SceneBuilder).
    #[error("there is no {what} \"{name}\"; add it before it is used")]
    Name {
        /// Kind of the entry.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The budget is used up, or its flag was raised.
    #[error(transparent)]
    Budget(#[from] BudgetError),
    /// Groups nested beyond the limit.
    #[error("groups are nested more deeply than the {0} levels allowed; merge some of them")]
    Nesting(usize),
    /// More copies of surfaces than can be numbered.
    #[error("instances of instances make 2^63 surfaces or more; use fewer of them")]
    TooManyCopies,
    /// A receiver in a group that is copied.
    #[error(
        "receiver \"{0}\": a shape in a group cannot be a receiver, because all instances would share it; add the shape to the world"
    )]
    ReceiverInGroup(String),
    /// A material with invalid parameters.
    #[error("material {name}: {reason}")]
    Material {
        /// Its name, quoted.
        name: String,
        /// The reason.
        reason: MaterialError,
    },
    /// A texture that cannot be built.
    #[error("texture \"{name}\": {reason}")]
    Texture {
        /// Its name.
        name: String,
        /// The reason.
        reason: String,
    },
}

/// A fault that was repaired or left out, and its place in the input.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWarning {
    /// The place concerned, if the part was read from a file.
    pub location: Option<Location>,
    /// The fault and the remedy taken.
    pub message: String,
}
