//! Eight pairs of a ray and a leaf, and what their solvers share.

use super::contraction::ROUNDED;
use super::ray_lanes::{RaySpaceLanes, cross, dot2};
use crate::bvh::simd::Simd;

/// Eight pairs of a ray and a certified leaf.
pub(super) struct PairLanes<S: Simd> {
    /// The lanes in use.
    pub(super) mask: u32,
    pub(super) rays: RaySpaceLanes<S>,
    /// The projection of the leaf; see [`LeafProjection`](super::leaf::LeafProjection).
    pub(super) a: [S::Wide; 2],
    pub(super) b: [S::Wide; 2],
    pub(super) q: S::Wide,
    pub(super) inverse_determinant: S::Wide,
    pub(super) start: [S::Wide; 2],
}

/// Results of eight pairs.
pub(super) struct RootLanes<S: Simd> {
    /// Pairs with a root.
    pub(super) converged: u32,
    /// Pairs without one.
    pub(super) excluded: u32,
    /// Arc length along the ray.
    pub(super) s: S::Wide,
    /// Parameters in [0, 1]^2.
    pub(super) at: [S::Wide; 2],
}

/// Value and derivatives of a map of eight pairs.
pub(super) struct JetLanes<S: Simd> {
    pub(super) f: [S::Wide; 2],
    pub(super) fs: [S::Wide; 2],
    pub(super) ft: [S::Wide; 2],
}

/// Bounds of eight pairs; see [`MapBounds`](super::contraction::MapBounds).
pub(super) struct BoundLanes<S: Simd> {
    pub(super) noise: S::Wide,
    pub(super) curvature_bound: S::Wide,
    pub(super) weights: [S::Wide; 2],
}

impl<S: Simd> JetLanes<S> {
    /// The step of Newton's method.
    #[inline(always)]
    pub(super) fn newton_step(&self, simd: S, det: S::Wide) -> [S::Wide; 2] {
        let Self { f, fs, ft } = *self;
        let per = simd.div8(simd.splat8(1.0), det);
        [simd.mul8(cross(simd, f, ft), per), simd.mul8(cross(simd, fs, f), per)]
    }

    /// Lanes in which the end of a step needs no evaluation.
    #[inline(always)]
    pub(super) fn ends(
        &self,
        simd: S,
        bounds: &BoundLanes<S>,
        det: S::Wide,
        step: [S::Wide; 2],
        per_unit: [S::Wide; 2],
    ) -> u32 {
        let relative = [simd.mul8(step[0], per_unit[0]), simd.mul8(step[1], per_unit[1])];
        let curved = simd.mul8(bounds.curvature_bound, dot2(simd, relative, relative));
        self.is_below_noise(simd, bounds, curved, det, step)
    }

    /// The same for steps with the derivatives of points this far away in s and t; see [`MapBounds`](super::contraction::MapBounds).
    #[inline(always)]
    pub(super) fn ends_from(
        &self,
        simd: S,
        bounds: &BoundLanes<S>,
        det: S::Wide,
        step: [S::Wide; 2],
        away: [S::Wide; 2],
    ) -> u32 {
        let length = simd.sqrt8(dot2(simd, step, step));
        let away = simd.mul8(simd.splat8(2.0), simd.sqrt8(dot2(simd, away, away)));
        let curved = simd.mul8(bounds.curvature_bound, simd.mul8(length, simd.add8(length, away)));
        self.is_below_noise(simd, bounds, curved, det, step)
    }

    /// Lanes in which the error `curved` of the step by curvature, and that by rounding, are below the noise.
    #[inline(always)]
    fn is_below_noise(
        &self,
        simd: S,
        bounds: &BoundLanes<S>,
        curved: S::Wide,
        det: S::Wide,
        step: [S::Wide; 2],
    ) -> u32 {
        let noise = simd.mul8(bounds.noise, bounds.weights[0]);
        let length_squared = dot2(simd, step, step);
        let (s2, t2) = (dot2(simd, self.fs, self.fs), dot2(simd, self.ft, self.ft));
        let rounded = simd.mul8(simd.mul8(simd.splat8(ROUNDED * ROUNDED), s2), t2);
        let rounded = simd.mul8(simd.mul8(rounded, simd.add8(s2, t2)), length_squared);
        let clear = simd.mul8(simd.mul8(simd.mul8(noise, noise), det), det);
        simd.at_most8(curved, noise) & simd.at_most8(rounded, clear)
    }

    /// Lanes in which the next step is expected to be the last, with the same derivatives.
    #[inline(always)]
    pub(super) fn next_ends(&self, simd: S, bounds: &BoundLanes<S>, det: S::Wide, step: [S::Wide; 2]) -> u32 {
        let noise = simd.mul8(bounds.noise, bounds.weights[0]);
        let length_squared = dot2(simd, step, step);
        let per = simd.add8(dot2(simd, self.fs, self.fs), dot2(simd, self.ft, self.ft));
        let curved = simd.mul8(simd.splat8(2.0), simd.mul8(bounds.curvature_bound, bounds.curvature_bound));
        let error = simd.mul8(simd.mul8(curved, curved), simd.mul8(length_squared, length_squared));
        let error = simd.mul8(simd.mul8(error, length_squared), per);
        simd.at_most8(error, simd.mul8(simd.mul8(noise, noise), simd.mul8(det, det)))
    }
}
