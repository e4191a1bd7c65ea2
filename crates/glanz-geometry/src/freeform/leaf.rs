//! A leaf of the hierarchy: the first look of a ray, which most often is the last one.

use glanz_math::{DVec2, DVec3};

use super::bicubic::POWERS;
use super::contract::{Certificate, Limits};
use super::draft::{Draft, Frame};
use super::part::Part;
use super::search::{Probe, cross};
use crate::bvh::simd::Simd;

/// Largest bound on the change of the Jacobian, relative to that at the centre, at which a leaf is certified.
const CERTIFIED: f64 = 0.85;

/// A part of a subpatch as a thick parallelogram ([`Frame`]), in one cache line.
///
/// Its numbers are rounded to `f32`, which the reach and the strays make up for.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Leaf {
    /// By coordinate: the centre, from that of the surface; the half tangents along u and v; and in the fourth lanes reach,
    /// stray squared and bend, rounded up.
    rows: [[f32; 4]; 3],
    pub(super) subpatch: u32,
    pub(super) part: Part,
    /// Whether a trimming curve crosses it, so that its points must be asked for one by one.
    pub(super) crossed: bool,
}

/// A leaf as seen along a ray that may meet it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Its half tangents, and how far its Jacobian strays from them, at most.
    pub(super) certificate: Certificate,
    /// Inverse of their determinant.
    pub(super) per: f64,
    /// Where the ray meets the parallelogram, in (s, t).
    pub(super) flat: DVec2,
    /// Whether it has one root at most.
    pub(super) certified: bool,
}

/// The nearest, and by how much it is off.
fn rounded(v: DVec3) -> ([f32; 3], f64) {
    let nearest = v.to_array().map(|x| x as f32);
    (nearest, (v - DVec3::from(nearest.map(f64::from))).length())
}

fn up(x: f64) -> f32 {
    (x as f32).next_up()
}

impl Look {
    /// By how much rounding may move a root.
    #[inline(always)]
    pub(super) fn blur(&self, limits: &Limits) -> DVec2 {
        self.certificate.blur(self.per, limits)
    }
}

impl Leaf {
    /// `origin` is the centre of the surface.
    pub(super) fn new(draft: &Draft, origin: DVec3) -> Self {
        let Frame { center, along_u, along_v, reach, stray_squared, bend } = draft.frame;
        let ((c, off_c), (u, off_u), (v, off_v)) =
            (rounded(center - origin), rounded(along_u), rounded(along_v));
        // The difference itself is rounded as well.
        let size = center.abs().max(origin.abs()).max_element();
        let reach = reach + off_c + off_u + off_v + 4.0 * f64::EPSILON * size;
        let stray = stray_squared.sqrt() + off_u.hypot(off_v);
        let last = [up(reach), up(stray * stray * (1.0 + 1e-12)), up(bend)];
        Self {
            rows: [0, 1, 2].map(|k| [c[k], u[k], v[k], last[k]]),
            subpatch: draft.subpatch,
            part: draft.part,
            crossed: draft.crossed,
        }
    }

    /// Bound on the half of any second derivative by (s, t); infinite if weights differ.
    #[inline(always)]
    pub(super) fn bend(&self) -> f64 {
        self.rows[2][3].into()
    }

    /// `None` if the ray passes it.
    #[inline(always)]
    pub(super) fn look<S: Simd>(&self, simd: S, probe: &Probe) -> Option<Look> {
        let [x, y, z] = &self.rows;
        let rows = [simd.widen(x), simd.widen(y), simd.widen(z)];
        let [first, second] = probe.axes;
        let (p, q) = (along(simd, &rows, first), along(simd, &rows, second));
        let c = DVec2::new(p[0], q[0]) + probe.center;
        let (a, b) = (DVec2::new(p[1], q[1]), DVec2::new(p[2], q[2]));
        let det = cross(a, b);
        let (s, t) = (-cross(c, b), -cross(a, c));
        let (a2, b2) = (a.length_squared(), b.length_squared());
        // Whichever way the leaf is evaluated.
        let noise = POWERS * probe.noise;
        let reach = f64::from(x[3]) + noise;
        // |s| > 1 + reach |b| / |det| without a division; squares would need a root either way.
        let outside = |s: f64, across: f64| {
            let beyond = s.abs() - det.abs();
            beyond > 0.0 && beyond * beyond > reach * reach * across
        };
        if outside(s, b2) || outside(t, a2) {
            return None;
        }
        // Where rounding moves the root by more than a part of the leaf, nothing is certified. NaN says no.
        let unsure = 16.0 * noise;
        let q2 = (f64::from(y[3]) + unsure * unsure) * (a2 + b2);
        let per = 1.0 / det;
        Some(Look {
            certificate: Certificate { a, b, q: q2.sqrt() * per.abs() },
            per,
            flat: DVec2::new(s, t) * per,
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
