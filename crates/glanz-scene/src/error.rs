//! What can be wrong with a description.

use glanz_geometry::SurfaceError;
use glanz_math::TransformError;
use glanz_shading::MaterialError;

use crate::description::Location;

/// Why a [`crate::description::Description`] is not a scene, and where it said so.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{kind}")]
pub struct SceneError {
    /// The part of the input at fault, if it has a place there.
    pub location: Option<Location>,
    /// What is wrong.
    pub kind: SceneErrorKind,
}

/// What is wrong with a description.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// A matrix that is not an invertible affine map.
    #[error("{what}: {source}")]
    Transform {
        /// What it places.
        what: &'static str,
        /// Why not.
        source: TransformError,
    },
    /// A surface with impossible parameters.
    #[error("shape: {0}")]
    Surface(#[from] SurfaceError),
    /// Trimming loops that are invalid.
    #[error("trimming: {0}")]
    Trim(SurfaceError),
    /// A parameter outside its range.
    #[error("{what} is {value}, it must be {range}")]
    Range {
        /// The parameter.
        what: &'static str,
        /// Its value.
        value: String,
        /// What it must be.
        range: &'static str,
    },
    /// An index that names nothing; a fault of the reader.
    #[error("{what} number {index} does not exist (there are {count})")]
    Reference {
        /// Kind of thing referred to.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A name that a [`SceneBuilder`](crate::SceneBuilder) does not know.
    #[error("there is no {what} \"{name}\"; add it before it is used")]
    Name {
        /// Kind of thing referred to.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// Groups nested beyond the limit.
    #[error("groups are nested more than {0} deep")]
    Nesting(usize),
    /// A receiver in a group that is copied.
    #[error(
        "receiver \"{0}\": a shape of an object cannot be one, for every copy would be the same receiver; put it into the world"
    )]
    ReceiverInGroup(String),
    /// A material with impossible parameters.
    #[error("material {name}: {reason}")]
    Material {
        /// Its name, quoted.
        name: String,
        /// Why not.
        reason: MaterialError,
    },
    /// A texture that cannot be built.
    #[error("texture \"{name}\": {reason}")]
    Texture {
        /// Its name.
        name: String,
        /// Why not.
        reason: String,
    },
}

/// Something odd that was mended or left out, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWarning {
    /// The part of the input, if it has a place there.
    pub location: Option<Location>,
    /// What was found and what was done.
    pub message: String,
}
