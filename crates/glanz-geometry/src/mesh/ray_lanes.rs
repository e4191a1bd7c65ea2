//! Eight rays and a triangle.

use glanz_math::DVec3;

use super::block::AXES;
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::{ALL, LANES};
use crate::hit::Hit;
use crate::triangle::{GRAZING, ShearedRay};

/// A [`ShearedRay`] as a row of numbers, of which eight are transposed into lanes: origin, shear, number of the axis along which the
/// direction is longest.
pub(super) type ShearedRow = [f64; LANES];

/// The row of a ray.
#[inline(always)]
pub(super) fn row(ray: &ShearedRay) -> ShearedRow {
    let (o, s) = (ray.origin, ray.shear);
    [o.x, o.y, o.z, s.x, s.y, s.z, ray.axes[2] as f64, 0.0]
}

/// The ray of a row.
#[inline(always)]
pub(super) fn sheared(row: &ShearedRow) -> ShearedRay {
    let [x, y, z, sx, sy, sz, longest, _] = *row;
    let axes = AXES[(longest as usize).min(2)];
    ShearedRay { origin: DVec3::new(x, y, z), axes, shear: DVec3::new(sx, sy, sz) }
}

/// Eight rays, ray by lane.
pub(super) struct ShearedLanes<S: Simd> {
    simd: S,
    origin: [S::Wide; 3],
    shear: [S::Wide; 3],
    /// Rays whose direction is longest along x.
    along_x: u32,
    /// Those whose direction is longest along y.
    along_y: u32,
}

impl<S: Simd> ShearedLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rows: &[&ShearedRow; LANES]) -> Self {
        let [ox, oy, oz, sx, sy, sz, longest, _] = simd.columns8(rows);
        let along_x = simd.less8(longest, simd.splat8(0.5));
        let along_y = simd.less8(longest, simd.splat8(1.5)) & !along_x;
        Self { simd, origin: [ox, oy, oz], shear: [sx, sy, sz], along_x, along_y }
    }

    /// A vertex in the frame of each ray; the bits of [`ShearedRay::vertex`].
    #[inline(always)]
    fn vertex(&self, point: DVec3) -> [S::Wide; 3] {
        let Self { simd, origin: [ox, oy, oz], shear, along_x, along_y } = *self;
        let x = simd.sub8(simd.splat8(point.x), ox);
        let y = simd.sub8(simd.splat8(point.y), oy);
        let z = simd.sub8(simd.splat8(point.z), oz);
        let [x, y, z] = match (along_x, along_y) {
            (ALL, _) => [y, z, x],
            (_, ALL) => [z, x, y],
            (0, 0) => [x, y, z],
            _ => [self.select(y, z, x), self.select(z, x, y), self.select(x, y, z)],
        };
        [simd.sub8(x, simd.mul8(shear[0], z)), simd.sub8(y, simd.mul8(shear[1], z)), simd.mul8(shear[2], z)]
    }

    /// The rays in the mask that hit the triangle `corners` with `0 < t <= ends`, each with its hit: the bits of
    /// [`TriangleBlock::hits`](super::block::TriangleBlock::hits), whose comments apply.
    #[inline(always)]
    pub(super) fn hits(&self, corners: [DVec3; 3], ends: S::Wide, mask: u32) -> Option<TriangleHits> {
        let simd = self.simd;
        let [a, b, c] = [self.vertex(corners[0]), self.vertex(corners[1]), self.vertex(corners[2])];
        let (u, v, w) = (self.edge(c, b), self.edge(a, c), self.edge(b, a));
        let zero = simd.splat8(0.0);
        let some_negative = simd.less8(simd.min8(simd.min8(u, v), w), zero);
        let some_positive = simd.less8(zero, simd.max8(simd.max8(u, v), w));
        let inside = mask & !(some_negative & some_positive);
        if inside == 0 {
            return None;
        }
        let determinant = simd.add8(simd.add8(u, v), w);
        let height = simd.add8(simd.add8(simd.mul8(u, a[2]), simd.mul8(v, b[2])), simd.mul8(w, c[2]));
        let t = simd.div8(height, determinant);
        let within = simd.less8(zero, t) & simd.at_most8(t, ends);
        let product = simd.mul8(simd.mul8(u, v), w);
        let at_edge = simd.at_most8(product, zero) & simd.at_most8(zero, product);
        let p = simd.abs8(simd.mul8(c[0], b[1]));
        let q = simd.abs8(simd.mul8(a[0], c[1]));
        let r = simd.abs8(simd.mul8(b[0], a[1]));
        let limit = simd.mul8(simd.splat8(GRAZING), simd.add8(simd.add8(p, q), r));
        let unsure = at_edge | simd.at_most8(simd.abs8(determinant), limit);
        let mask = inside & (within | unsure);
        if mask == 0 {
            return None;
        }
        let (u, v) = (simd.div8(v, determinant), simd.div8(w, determinant));
        Some(TriangleHits { mask, unsure, t: simd.store8(t), u: simd.store8(u), v: simd.store8(v) })
    }

    /// The first of the three for rays along x, the second for those along y, else the third.
    #[inline(always)]
    fn select(&self, along_x: S::Wide, along_y: S::Wide, along_z: S::Wide) -> S::Wide {
        let others = self.simd.select8(self.along_y, along_y, along_z);
        self.simd.select8(self.along_x, along_x, others)
    }

    /// The edge function of two vertices.
    #[inline(always)]
    fn edge(&self, p: [S::Wide; 3], q: [S::Wide; 3]) -> S::Wide {
        let simd = self.simd;
        simd.sub8(simd.mul8(p[0], q[1]), simd.mul8(p[1], q[0]))
    }
}

/// Hits of eight rays with a triangle.
pub(super) struct TriangleHits {
    /// The rays that hit it, or may hit it.
    pub(super) mask: u32,
    /// Rays that the scalar test has to decide.
    unsure: u32,
    t: [f64; LANES],
    u: [f64; LANES],
    v: [f64; LANES],
}

impl TriangleHits {
    /// The hit of the ray `row` in a lane, whose end is `end`.
    #[inline(always)]
    pub(super) fn hit(
        &self,
        lane: usize,
        (face, corners): (u32, [DVec3; 3]),
        row: &ShearedRow,
        end: f64,
    ) -> Option<Hit> {
        if self.unsure >> lane & 1 == 0 {
            return Some(Hit::new(self.t[lane], self.u[lane], self.v[lane], face));
        }
        let [a, b, c] = corners;
        // The end is included, as for the other lanes.
        let (t, u, v) = sheared(row).intersect(a, b, c, end.next_up())?;
        Some(Hit::new(t, u, v, face))
    }
}
