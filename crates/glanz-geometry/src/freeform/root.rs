//! Roots of a ray with a leaf, and the memory that their search reuses.

use glanz_math::{DVec2, DVec3};

use super::contraction::LocalRoot;
use super::parameter_rect::DyadicRect;

/// A root in the parameters of its subpatch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceRoot {
    /// Arc length along [`RaySpace::line`](super::ray_space::RaySpace::line), metres.
    pub(super) s: f64,
    /// Parameters in [0, 1]^2.
    pub(super) at: DVec2,
    /// Bound on the shift of the root by rounding, in the same parameters.
    pub(super) uncertainty: DVec2,
    /// The same in metres along the surface.
    pub(super) distance_uncertainty: f64,
}

impl SurfaceRoot {
    /// The root of a part in the parameters of the whole.
    #[inline(always)]
    pub(super) fn of_part(self, part: DyadicRect) -> Self {
        Self { at: part.at(self.at), uncertainty: self.uncertainty * part.width(), ..self }
    }
}

/// Point and first derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstOrderJet {
    pub(super) s: DVec3,
    pub(super) su: DVec3,
    pub(super) sv: DVec3,
}

/// Memory and counters that the searches in all leaves of a ray share.
#[derive(Default)]
pub(super) struct SearchScratch {
    /// Coefficients of cells.
    pub(super) cells: Vec<f64>,
    /// Roots of the current leaf, in its own parameters.
    pub(super) local_roots: Vec<LocalRoot>,
    /// The same in the parameters of the subpatch.
    pub(super) roots: Vec<SurfaceRoot>,
    /// Cells that subdivisions examined.
    pub(super) examined: u64,
    /// Leaves whose subdivision was given up.
    pub(super) undecided: u64,
}
