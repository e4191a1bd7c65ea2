//! Errors of OBJ and MTL files.

use glanz_job::BudgetError;

/// Error of reading a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column}: {kind}")]
pub struct ObjError {
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Kind.
    pub kind: ObjErrorKind,
}

/// Kinds of errors of OBJ and MTL files.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjErrorKind {
    /// Text that is not a finite number.
    #[error("{0:?} is not a finite number")]
    Number(String),
    /// Text that is not the reference of a corner.
    #[error("{0:?} is not a vertex; corners are written as 1, 1/2, 1//3 or 1/2/3")]
    Corner(String),
    /// A reference to something that does not exist.
    #[error("{what} {index} does not exist; {count} precede this line")]
    Index {
        /// What is numbered.
        what: &'static str,
        /// Its number: from 1, or from -1 backwards.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// Too few values in a statement.
    #[error("\"{statement}\" has {found} values; it needs at least {needed}")]
    Count {
        /// The statement.
        statement: String,
        /// Number of values.
        found: usize,
        /// Least number.
        needed: usize,
    },
    /// A degree out of range.
    #[error("the degree is {0}; it must be at least 1 and at most 100")]
    Degree(String),
    /// A surface whose points do not match its parameters.
    #[error("the surface has {found} points; its degrees and parameters need {u} times {v}")]
    SurfacePoints {
        /// Number of points.
        found: usize,
        /// Number along u.
        u: usize,
        /// Number along v.
        v: usize,
    },
    /// Too few parameters for the degree.
    #[error("{found} parameters along {axis} are too few for degree {degree}")]
    Parameters {
        /// `u` or `v`.
        axis: char,
        /// Number of parameters.
        found: usize,
        /// The degree.
        degree: usize,
    },
    /// Parameters that decrease.
    #[error("parameters must not decrease, but {after} follows {before}")]
    Decreasing {
        /// A parameter ...
        before: f64,
        /// ... and the next one.
        after: f64,
    },
    /// An empty range.
    #[error("the range from {0} to {1} is empty, or outside the parameters")]
    Range(f64, f64),
    /// Loops that use the same curves again and again.
    #[error("trimming loops use the same curves too often; give each loop its own curves")]
    CurveUses,
    /// A material statement before the first material.
    #[error("{0:?} precedes the first \"newmtl\"")]
    NoMaterial(String),
    /// More vertices than 32 bits can number.
    #[error("the file has more than 2^32 vertices")]
    TooMany,
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}
