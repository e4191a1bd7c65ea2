//! Trimming.

/// A part of a parameter domain inside closed loops of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimDescription {
    /// The loops, at least one.
    pub loops: Vec<TrimLoopDescription>,
}

/// A closed chain of curves; material is on its left.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoopDescription {
    /// The curves; each ends where the next begins, the last where the first does.
    pub curves: Vec<TrimCurveDescription>,
}

/// A rational spline curve in a parameter domain.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurveDescription {
    /// Degree.
    pub degree: usize,
    /// Knots, `degree + 1` more than points; they do not decrease.
    pub knots: Vec<f64>,
    /// Homogeneous (w u, w v, w).
    pub points: Vec<[f64; 3]>,
}
