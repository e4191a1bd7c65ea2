//! Interpolations for each division.

use glanz_radiosity::reconstruct::{Border, Interpolation};

/// Divisions of a floor into elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FloorDivision {
    /// 16 x 16 equal ones.
    Grid,
    /// Small ones where light changes.
    Quadtree,
}

impl FloorDivision {
    pub(super) const ALL: [Self; 2] = [Self::Grid, Self::Quadtree];

    /// Name in tables and files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Quadtree => "quadtree",
        }
    }
}

/// An interpolation with or without samples at the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InterpolationMethod {
    pub(super) interpolation: Interpolation,
    pub(super) border: Border,
}

/// Interpolations of scattered samples, which the document compares on both divisions.
pub(super) const SCATTERED: [Interpolation; 3] = [
    Interpolation::Shepard { exponent: 4.0 },
    Interpolation::Multiquadrics { exponent: 0.5 },
    Interpolation::NaturalNeighbour,
];

impl InterpolationMethod {
    /// Name in tables.
    pub(super) fn name(self) -> &'static str {
        name(self.interpolation)
    }

    /// Whether the method is measured with and without border samples.
    pub(super) fn is_scattered(self) -> bool {
        SCATTERED.contains(&self.interpolation)
    }
}

/// Name of an interpolation in reports.
pub(super) fn name(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Constant => "constant",
        Interpolation::Bilinear => "bilinear",
        Interpolation::Spline => "bicubic spline",
        Interpolation::Shepard { .. } => "Shepard",
        Interpolation::Multiquadrics { .. } => "multiquadrics",
        Interpolation::NaturalNeighbour => "natural neighbours",
    }
}

/// All methods of a division, in the order of the document's tables.
pub(super) fn methods(division: FloorDivision) -> Vec<InterpolationMethod> {
    let open = |interpolation| InterpolationMethod { interpolation, border: Border::Open };
    let mut all = vec![open(Interpolation::Constant)];
    if division == FloorDivision::Grid {
        all.extend([Interpolation::Bilinear, Interpolation::Spline].map(open));
    }
    for border in [Border::Open, Border::Sampled] {
        all.extend(SCATTERED.map(|interpolation| InterpolationMethod { interpolation, border }));
    }
    all
}
