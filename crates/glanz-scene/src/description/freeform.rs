//! Freeform surfaces.

/// A rational spline surface.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsDescription {
    /// Degree along u.
    pub degree_u: usize,
    /// Degree along v.
    pub degree_v: usize,
    /// Knots along u, `degree_u + 1` more than points; they do not decrease.
    pub knots_u: Vec<f64>,
    /// Knots along v, `degree_v + 1` more than points; they do not decrease.
    pub knots_v: Vec<f64>,
    /// Homogeneous control points (w x, w y, w z, w), index `i * count_v + j` with i along u.
    pub points: Vec<[f64; 4]>,
    /// The part kept, `[[u0, u1], [v0, v1]]`; `None`: the whole domain.
    pub domain: Option<[[f64; 2]; 2]>,
}

/// Rational Bézier patches over the unit square, all of the same degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatchesDescription {
    /// Degree along u.
    pub degree_u: usize,
    /// Degree along v.
    pub degree_v: usize,
    /// Per patch `(degree_u + 1) * (degree_v + 1)` homogeneous points (w x, w y, w z, w), index
    /// `i * (degree_v + 1) + j`, i along u.
    pub patches: Vec<Vec<[f64; 4]>>,
}

/// Rational Bézier patches over a triangle with barycentric coordinates (r, s, t), all of the same degree.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierTrianglesDescription {
    /// Total degree.
    pub degree: usize,
    /// Per patch `(degree + 1) * (degree + 2) / 2` homogeneous points (w x, w y, w z, w) of the terms r^i s^j t^k: by
    /// descending i, then descending j. The first is the corner r = 1, the last the corner t = 1.
    pub patches: Vec<Vec<[f64; 4]>>,
}
