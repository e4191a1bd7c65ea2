//! A leaf of the hierarchy, and its projection along a ray, which most often excludes it.

use glanz_math::{DVec2, DVec3};

use super::bicubic::POWERS;
use super::contraction::{Certificate, MapBounds};
use super::leaf_builder::{LeafBuilder, ThickParallelogram};
use super::parameter_rect::DyadicRect;
use super::ray_space::{RaySpace, cross};
use crate::bvh::simd::Simd;

/// Largest bound on the change of the Jacobian, relative to that at the centre, at which a leaf is certified.
pub(super) const CERTIFIED: f64 = 0.85;

/// A part of a subpatch as a [`ThickParallelogram`], in one cache line.
///
/// Its numbers are rounded to `f32`; thickness and deviation are enlarged by the rounding.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct PatchLeaf {
    /// By coordinate: the centre, relative to that of the surface; the half tangents along u and v; and in the fourth lanes
    /// thickness, squared deviation and curvature bound, rounded up.
    pub(super) rows: [[f32; 4]; 3],
    pub(super) subpatch: u32,
    /// Position of its [`ReducedNet`](super::reduced_net::ReducedNet) in those of the surface, [`PatchLeaf::NO_NET`] without one.
    pub(super) reduced_net: u32,
    pub(super) part: DyadicRect,
    /// Whether a trimming curve crosses it, so that each root must be classified.
    pub(super) crossed: bool,
}

/// A leaf, projected along a ray that may meet it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafProjection {
    /// Its half tangents, and the bound on the deviation of its Jacobian from them.
    pub(super) certificate: Certificate,
    /// Inverse of their determinant.
    pub(super) inverse_determinant: f64,
    /// The intersection of the ray with the parallelogram, in (s, t).
    pub(super) start: DVec2,
    /// Whether it has one root at most.
    pub(super) certified: bool,
}

/// The nearest vector of type `f32`, and its distance.
fn rounded(v: DVec3) -> ([f32; 3], f64) {
    let nearest = v.to_array().map(|x| x as f32);
    (nearest, (v - DVec3::from(nearest.map(f64::from))).length())
}

fn up(x: f64) -> f32 {
    (x as f32).next_up()
}

impl LeafProjection {
    /// Bound on the shift of a root by rounding.
    #[inline(always)]
    pub(super) fn uncertainty(&self, bounds: &MapBounds) -> DVec2 {
        self.certificate.uncertainty(self.inverse_determinant, bounds)
    }
}

impl PatchLeaf {
    /// The position of no net.
    pub(super) const NO_NET: u32 = u32::MAX;

    /// The leaf, with coordinates relative to `origin`, the centre of the surface.
    pub(super) fn new(leaf: &LeafBuilder, origin: DVec3) -> Self {
        let ThickParallelogram {
            center,
            along_u,
            along_v,
            thickness,
            tangent_deviation_squared,
            curvature_bound,
        } = leaf.parallelogram;
        let ((c, off_c), (u, off_u), (v, off_v)) =
            (rounded(center - origin), rounded(along_u), rounded(along_v));
        // The difference itself is rounded as well.
        let size = center.abs().max(origin.abs()).max_element();
        let thickness = thickness + off_c + off_u + off_v + 4.0 * f64::EPSILON * size;
        let deviation = tangent_deviation_squared.sqrt() + off_u.hypot(off_v);
        let last = [up(thickness), up(deviation * deviation * (1.0 + 1e-12)), up(curvature_bound)];
        Self {
            rows: [0, 1, 2].map(|k| [c[k], u[k], v[k], last[k]]),
            subpatch: leaf.subpatch,
            reduced_net: Self::NO_NET,
            part: leaf.part,
            crossed: leaf.crossed,
        }
    }

    /// Bound on half of the second derivative in any direction of (s, t).
    #[inline(always)]
    pub(super) fn curvature_bound(&self) -> f64 {
        self.rows[2][3].into()
    }

    /// The projection along the ray; `None` if the ray misses the leaf.
    #[inline(always)]
    pub(super) fn project<S: Simd>(&self, simd: S, space: &RaySpace) -> Option<LeafProjection> {
        let [x, y, z] = &self.rows;
        let rows = [simd.widen(x), simd.widen(y), simd.widen(z)];
        let [first, second] = space.axes;
        let (p, q) = (along(simd, &rows, first), along(simd, &rows, second));
        let c = DVec2::new(p[0], q[0]) + space.center;
        let (a, b) = (DVec2::new(p[1], q[1]), DVec2::new(p[2], q[2]));
        let det = cross(a, b);
        let (s, t) = (-cross(c, b), -cross(a, c));
        let (a2, b2) = (a.length_squared(), b.length_squared());
        // For both ways in which the leaf may be evaluated.
        let noise = POWERS * space.noise;
        let thickness = f64::from(x[3]) + noise;
        // |s| > 1 + thickness |b| / |det| without a division; squares would need a root either way.
        let outside = |s: f64, across: f64| {
            let beyond = s.abs() - det.abs();
            beyond > 0.0 && beyond * beyond > thickness * thickness * across
        };
        if outside(s, b2) || outside(t, a2) {
            return None;
        }
        // If rounding moves the root by more than a part of the leaf, nothing is certified; nor is NaN.
        let unsure = 16.0 * noise;
        let q2 = (f64::from(y[3]) + unsure * unsure) * (a2 + b2);
        let inverse_determinant = 1.0 / det;
        Some(LeafProjection {
            certificate: Certificate { a, b, q: q2.sqrt() * inverse_determinant.abs() },
            inverse_determinant,
            start: DVec2::new(s, t) * inverse_determinant,
            certified: q2 < CERTIFIED * CERTIFIED * det * det,
        })
    }
}

/// Columns of `rows` along a direction.
#[inline(always)]
fn along<S: Simd>(simd: S, [x, y, z]: &[S::F64; 3], axis: DVec3) -> [f64; 4] {
    let sum = simd.mul64(*x, simd.splat64(axis.x));
    let sum = simd.mul_add64(*y, simd.splat64(axis.y), sum);
    simd.store64(simd.mul_add64(*z, simd.splat64(axis.z), sum))
}
