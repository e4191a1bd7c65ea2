//! The boundaries of trimmed patches.

use std::sync::Arc;

use glanz_geometry::SurfaceError;
use glanz_geometry::spline::{KnotVector, NurbsCurve};
use glanz_geometry::trim::TrimRegion;
use glanz_math::DVec2;
use glanz_math::glam::DVec4;

use crate::description::{TrimCurveDescription, TrimDescription, TrimEdgeDescription};
use crate::resolve::trim_region;

/// The boundary of a trimmed patch.
pub(super) struct PatchTrim {
    pub(super) loops: Vec<Vec<PatchCurve>>,
    pub(super) region: Arc<TrimRegion>,
    /// The part of the parameters in which curves count; `None` for all.
    pub(super) domain: Option<[DVec2; 2]>,
}

/// A curve of a boundary, over [0, 1].
pub(super) struct PatchCurve {
    curve: NurbsCurve,
    pub(super) edge: Option<TrimEdgeDescription>,
}

impl PatchCurve {
    /// The parameters at `t`.
    pub(super) fn at(&self, t: f64) -> DVec2 {
        let [from, to] = self.curve.knots().domain();
        self.curve
            .point(if t > 0.5 { to - (to - from) * (1.0 - t) } else { from + (to - from) * t })
            .truncate()
    }

    /// Its knots as fractions.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let [from, to] = self.curve.knots().domain();
        let inner = self.curve.knots().breaks().into_iter().map(|knot| (knot - from) / (to - from));
        inner.filter(|t| *t > 0.0 && *t < 1.0).collect()
    }

    /// Parameters of points from its start to its end, dense enough to tell where it leaves a window, and on which side of it a point
    /// lies that is not near it.
    pub(super) fn places(&self) -> Vec<f64> {
        /// Parts of a span.
        const PARTS: usize = 12;
        let ends: Vec<f64> = [0.0].into_iter().chain(self.breaks()).chain([1.0]).collect();
        let spans = ends.windows(2).flat_map(|span| {
            let at = |i: usize| span[0] + (span[1] - span[0]) * i as f64 / PARTS as f64;
            (0..PARTS).map(at).collect::<Vec<f64>>()
        });
        spans.chain([1.0]).collect()
    }
}

impl PatchTrim {
    pub(super) fn try_new(trim: &TrimDescription) -> Result<Self, SurfaceError> {
        let curve = |curve: &TrimCurveDescription| {
            let knots = KnotVector::try_new(curve.degree, curve.knots.clone())?;
            let points = curve.points.iter().map(|&[u, v, w]| DVec4::new(u, v, 0.0, w)).collect();
            Ok(PatchCurve { curve: NurbsCurve::from_knots(knots, points)?, edge: curve.edge })
        };
        let loops = trim.loops.iter().map(|l| l.curves.iter().map(curve).collect());
        Ok(Self {
            loops: loops.collect::<Result<_, SurfaceError>>()?,
            region: trim_region(trim.clone())?,
            domain: trim.domain.map(|corners| corners.map(DVec2::from_array)),
        })
    }
}
