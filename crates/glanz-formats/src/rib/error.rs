//! Errors of RIB files.

use glanz_job::BudgetError;

use super::state::MAX_DEPTH;

/// Error of reading a RIB file, with its position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column}: {kind}")]
pub struct RibError {
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Kind.
    pub kind: RibErrorKind,
}

/// Kinds of errors of RIB files.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RibErrorKind {
    /// Bytes that are not text.
    #[error("this is a binary or compressed file; only text is supported")]
    Binary,
    /// Something other than expected.
    #[error("expected {wanted}, found {found:?}")]
    Unexpected {
        /// The text found.
        found: String,
        /// The expected item.
        wanted: &'static str,
    },
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
    /// A number that is not finite.
    #[error("{0:?} is not finite")]
    NotFinite(String),
    /// A text without an end.
    #[error("the text that begins here has no closing quote")]
    OpenText,
    /// An array without an end.
    #[error("the array that begins here has no closing bracket")]
    OpenArray,
    /// A block without an end.
    #[error("{0}Begin has no {0}End")]
    OpenBlock(&'static str),
    /// An end of a block that is not the innermost.
    #[error("{name}End closes {}", open.map_or("nothing".to_owned(), |o| format!("{o}Begin")))]
    StrayEnd {
        /// The block that ends, without `End`.
        name: &'static str,
        /// The innermost block, if there is one.
        open: Option<&'static str>,
    },
    /// Blocks within blocks.
    #[error("blocks are nested more than {MAX_DEPTH} deep")]
    TooDeep,
    /// An unsupported request that changes the position of surfaces.
    #[error("{0} is not supported; surfaces in it would have wrong positions")]
    Unsupported(String),
    /// A matrix that is not affine.
    #[error("the last numbers of the rows are {0:?}; those of an affine transformation are 0 0 0 1")]
    NotAffine([f64; 4]),
    /// An argument is missing or of the wrong kind.
    #[error("{request} needs {wanted}")]
    RibArgument {
        /// The request.
        request: String,
        /// The argument expected.
        wanted: &'static str,
    },
    /// A wrong number of items.
    #[error("{request} has {found} {what}; {needed} are needed")]
    Count {
        /// The request.
        request: String,
        /// The counted items.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The number expected.
        needed: usize,
    },
    /// A number of points that does not give whole patches.
    #[error("{count} points along {axis} do not make a whole number of patches in steps of {step}")]
    MeshSize {
        /// u or v.
        axis: char,
        /// Points along it.
        count: usize,
        /// Step in points to the next patch.
        step: usize,
    },
    /// A knot smaller than the one before.
    #[error("knot {after} follows {before}; knots must not decrease")]
    KnotsDecrease {
        /// The knot before.
        before: f64,
        /// The knot.
        after: f64,
    },
    /// An invalid range of parameters.
    #[error("the range from {min} to {max} is empty or extends beyond the knots, which span {low} to {high}")]
    Range {
        /// Its start.
        min: f64,
        /// Its end.
        max: f64,
        /// Lower end of the knots' valid range.
        low: f64,
        /// Upper end of the knots' valid range.
        high: f64,
    },
    /// A weight that is not positive.
    #[error("a weight of the control points is {0}; it must be positive")]
    Weight(f64),
    /// A point out of the range of numbers.
    #[error("a control point is out of range once it is transformed")]
    OutOfRange,
}

impl RibErrorKind {
    /// Remedy, unless it is obvious.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        Some(match self {
            Self::Binary => "unpack the file, or write it as text (catrib does)",
            Self::OpenText | Self::OpenArray | Self::OpenBlock(_) => "check whether the file is complete",
            Self::Unsupported(_) => "write the file without motion, objects and solids",
            Self::NotAffine(_) => "leave the projection to the camera of the scene",
            Self::MeshSize { .. } => "the steps are those of Basis, 3 for Bézier patches",
            Self::KnotsDecrease { .. } => "sort the knots, or check a missing value",
            Self::Weight(_) => "\"Pw\" has four numbers per point, w x, w y, w z and w",
            _ => return None,
        })
    }
}
