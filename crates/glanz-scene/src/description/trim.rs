//! Trimming.

/// A part of a parameter domain inside closed loops of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimDescription {
    /// The loops, at least one.
    pub loops: Vec<TrimLoopDescription>,
    /// Factors, > 0, from u and from v to the lengths in which widths of curves are measured.
    pub scale: [f64; 2],
    /// Two corners (u, v) of the part of the domain in which loops count; what lies beyond is kept or not as the nearest point of it is.
    /// `None`: a box around the loops.
    pub domain: Option<[[f64; 2]; 2]>,
}

impl From<Vec<TrimLoopDescription>> for TrimDescription {
    /// The part inside these loops, with widths in parameters.
    fn from(loops: Vec<TrimLoopDescription>) -> Self {
        Self { loops, scale: [1.0; 2], domain: None }
    }
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
    /// Distance from the curve within which points are kept on both sides, after the scale of the trimming; `None`: 1e-9 of the extent
    /// of all loops.
    pub width: Option<f64>,
    /// The edge of which it is the image, where several surfaces share it.
    pub edge: Option<TrimEdgeDescription>,
}

/// A part of an edge that shapes of one group share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimEdgeDescription {
    /// Its number in the group.
    pub edge: u32,
    /// Numbers of the vertices in the group where the edge starts and ends.
    pub vertices: [u32; 2],
    /// The fractions of the edge, 0 at its start and 1 at its end, at which the trimming curve starts and ends.
    pub range: [f64; 2],
}
