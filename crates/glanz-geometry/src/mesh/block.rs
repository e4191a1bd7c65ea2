//! Triangles in blocks of four, tested at once.

use glanz_math::{DVec3, Ray};

use super::vector_list::VectorList;
use crate::bvh::query::HitCollector;
use crate::bvh::simd::Simd;
use crate::bvh::{Bvh, PARALLEL_CHUNK, parallel_map};
use crate::hit::Hit;
use crate::triangle::{GRAZING, ShearedRay};

/// Triangles in a block: the `f64` lanes of a vector register.
pub(super) const LANES: usize = 4;

/// A number type of stored coordinates.
pub(super) trait Coordinate: Copy + Send + Sync {
    /// The value of unused lanes: no comparison with it is ever true, so they are never hit.
    const NONE: Self;
    /// The nearest stored number.
    fn from_f64(value: f64) -> Self;
    /// The stored number.
    fn to_f64(self) -> f64;
    /// Four of them.
    fn widen<S: Simd>(simd: S, lanes: &[Self; LANES]) -> S::F64;
}

impl Coordinate for f32 {
    const NONE: Self = Self::NAN;
    fn from_f64(value: f64) -> Self {
        value as Self
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn widen<S: Simd>(simd: S, lanes: &[Self; LANES]) -> S::F64 {
        simd.widen(lanes)
    }
}

impl Coordinate for f64 {
    const NONE: Self = Self::NAN;
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn widen<S: Simd>(simd: S, lanes: &[Self; LANES]) -> S::F64 {
        simd.load64(lanes)
    }
}

/// Four triangles, by vertex, axis and triangle.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock<T> {
    corners: [[[T; LANES]; 3]; 3],
    faces: [u32; LANES],
}

impl<T: Coordinate> TriangleBlock<T> {
    /// A block of up to four triangles, given by face number and vertices.
    fn new(triangles: impl Iterator<Item = (u32, [DVec3; 3])>) -> Self {
        let mut block = Self { corners: [[[T::NONE; LANES]; 3]; 3], faces: [u32::MAX; LANES] };
        for (lane, (face, vertices)) in triangles.take(LANES).enumerate() {
            block.faces[lane] = face;
            for (corner, vertex) in block.corners.iter_mut().zip(vertices) {
                for (axis, x) in corner.iter_mut().zip(vertex.to_array()) {
                    axis[lane] = T::from_f64(x);
                }
            }
        }
        block
    }

    /// Prefetches this block.
    #[inline(always)]
    pub(super) fn prefetch<S: Simd>(&self, simd: S) {
        for corner in &self.corners {
            simd.prefetch(corner);
        }
        simd.prefetch(&self.faces);
    }

    /// Its triangles by face number, with their vertices.
    #[inline(always)]
    pub(super) fn triangles(&self) -> impl Iterator<Item = (u32, [DVec3; 3])> + '_ {
        let used = self.faces.iter().enumerate().take_while(|&(_, &face)| face != u32::MAX);
        used.map(|(lane, &face)| (face, self.triangle(lane)))
    }

    #[inline(always)]
    fn triangle(&self, lane: usize) -> [DVec3; 3] {
        [self.vertex(0, lane), self.vertex(1, lane), self.vertex(2, lane)]
    }

    /// A vertex of a triangle, number by number: `map` over the arrays would copy the whole block.
    #[inline(always)]
    fn vertex(&self, corner: usize, lane: usize) -> DVec3 {
        let ([x, y, z], lane) = (&self.corners[corner], lane & (LANES - 1));
        DVec3::new(x[lane].to_f64(), y[lane].to_f64(), z[lane].to_f64())
    }

    /// A vertex of all triangles in the sheared frame of the ray; see [`ShearedRay::vertex`].
    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, ray: &BlockRay<S>, corner: usize) -> [S::F64; 3] {
        let [x, y, z] = ray.sheared.axes;
        let x = self.coordinate(simd, ray, corner, x, 0);
        let y = self.coordinate(simd, ray, corner, y, 1);
        let z = self.coordinate(simd, ray, corner, z, 2);
        [
            simd.sub64(x, simd.mul64(ray.shear[0], z)),
            simd.sub64(y, simd.mul64(ray.shear[1], z)),
            simd.mul64(ray.shear[2], z),
        ]
    }

    /// The coordinate `axis` of a vertex relative to the origin of the ray, which stores it at the position `sheared`.
    #[inline(always)]
    fn coordinate<S: Simd>(
        &self,
        simd: S,
        ray: &BlockRay<S>,
        corner: usize,
        axis: usize,
        sheared: usize,
    ) -> S::F64 {
        // The axes are 0, 1 and 2; the test lets the compiler omit the bounds check.
        let axis = if axis < 3 { axis } else { 0 };
        simd.sub64(T::widen(simd, &self.corners[corner][axis]), ray.origin[sheared])
    }

    /// The lanes that the ray hits with `0 < t <= t_max`, as bits, with their parameters.
    ///
    /// Computes the same bits as [`ShearedRay::intersect`], except for its exact fallback: lanes with a zero edge function
    /// and those seen nearly edge-on are candidates here, and [`TriangleBlock::hits`] repeats them with the scalar test.
    #[inline(always)]
    fn intersect<S: Simd>(&self, simd: S, ray: &BlockRay<S>, t_max: f64) -> Option<BlockHits> {
        let [a, b, c] = [self.corner(simd, ray, 0), self.corner(simd, ray, 1), self.corner(simd, ray, 2)];
        let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
        let zero = simd.splat64(0.0);
        let some_negative = simd.less64(simd.min64(simd.min64(u, v), w), zero);
        let some_positive = simd.less64(zero, simd.max64(simd.max64(u, v), w));
        let inside = !(some_negative & some_positive) & ((1 << LANES) - 1);
        if inside == 0 {
            return None;
        }
        let determinant = simd.add64(simd.add64(u, v), w);
        let height = simd.add64(simd.add64(simd.mul64(u, a[2]), simd.mul64(v, b[2])), simd.mul64(w, c[2]));
        let t = simd.div64(height, determinant);
        let within = simd.less64(zero, t) & simd.at_most64(t, simd.splat64(t_max));
        // A zero determinant may be a zero only of rounding, at the tip of a sliver.
        let product = simd.mul64(simd.mul64(u, v), w);
        let at_edge = simd.at_most64(product, zero) & simd.at_most64(zero, product);
        // Seen nearly edge-on, t itself has lost its digits.
        let shares = [simd.mul64(c[0], b[1]), simd.mul64(a[0], c[1]), simd.mul64(b[0], a[1])];
        let [p, q, r] = [simd.abs64(shares[0]), simd.abs64(shares[1]), simd.abs64(shares[2])];
        let limit = simd.mul64(simd.splat64(GRAZING), simd.add64(simd.add64(p, q), r));
        let unsure = at_edge | simd.at_most64(simd.abs64(determinant), limit);
        let hits = inside & (within | unsure);
        if hits == 0 {
            return None;
        }
        // Not in a closure, which would not be compiled for the instructions of `simd`.
        let (t, determinant) = (simd.store64(t), simd.store64(determinant));
        Some(BlockHits { hits, unsure, t, v: simd.store64(v), w: simd.store64(w), determinant })
    }

    /// Adds every hit with `0 < t <= collector.end()`, by lane, until the search is over.
    #[inline(always)]
    pub(super) fn hits<S: Simd>(&self, simd: S, ray: &BlockRay<S>, collector: &mut impl HitCollector) {
        let end = collector.end();
        let Some(lanes) = self.intersect(simd, ray, end) else { return };
        let mut hits = lanes.hits;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & (LANES - 1);
            hits &= hits - 1;
            let mut hit = Hit::new(
                lanes.t[lane],
                lanes.v[lane] / lanes.determinant[lane],
                lanes.w[lane] / lanes.determinant[lane],
                self.faces[lane],
            );
            if lanes.unsure >> lane & 1 != 0 {
                let [a, b, c] = self.triangle(lane);
                // The end is included, as for the other lanes.
                match ray.sheared.intersect(a, b, c, end.next_up()) {
                    Some((t, u, v)) => hit = Hit { t, u, v, ..hit },
                    None => continue,
                }
            }
            collector.add(hit);
            if collector.end() < 0.0 {
                return;
            }
        }
    }
}

/// The edge function of two sheared vertices; its sign is the side of the edge on which the ray passes.
#[inline(always)]
fn edge<S: Simd>(simd: S, p: [S::F64; 3], q: [S::F64; 3]) -> S::F64 {
    simd.sub64(simd.mul64(p[0], q[1]), simd.mul64(p[1], q[0]))
}

/// Hits of a ray in a block.
struct BlockHits {
    hits: u32,
    /// Lanes that the scalar test has to decide.
    unsure: u32,
    t: [f64; LANES],
    v: [f64; LANES],
    w: [f64; LANES],
    determinant: [f64; LANES],
}

/// The axes in the order that makes a given one the last. A `static`: a constant would be copied for every ray.
pub(super) static AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// A ray prepared for blocks.
pub(super) struct BlockRay<S: Simd> {
    pub(super) simd: S,
    sheared: ShearedRay,
    origin: [S::F64; 3],
    shear: [S::F64; 3],
}

impl<S: Simd> BlockRay<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, sheared: &ShearedRay) -> Self {
        let origin = sheared.axes.map(|axis| sheared.origin.to_array()[if axis < 3 { axis } else { 0 }]);
        let shear = splat(simd, sheared.shear.to_array());
        Self { simd, sheared: *sheared, origin: splat(simd, origin), shear }
    }
}

impl ShearedRay {
    /// As [`ShearedRay::new`], but without branches: which axis is the longest cannot be predicted.
    #[inline(always)]
    pub(super) fn without_branches(ray: &Ray) -> Self {
        let [x, y, z] = ray.direction.abs().to_array();
        let (longest, size) = if x >= y { (0, x) } else { (1, y) };
        let longest: usize = if size >= z { longest } else { 2 };
        let axes = AXES[longest];
        let [x, y, z] = axes.map(|axis| ray.direction.to_array()[axis]);
        Self { origin: ray.origin, axes, shear: DVec3::new(x / z, y / z, 1.0 / z) }
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, v: [f64; 3]) -> [S::F64; 3] {
    [simd.splat64(v[0]), simd.splat64(v[1]), simd.splat64(v[2])]
}

/// The blocks of a mesh; block `i` holds the triangles of leaf `i`.
#[derive(Clone, Debug)]
pub(super) enum TriangleBlocks {
    /// Every coordinate is an `f32`: half the memory, and not one bit is lost.
    Single(Vec<TriangleBlock<f32>>),
    /// Some are not.
    Double(Vec<TriangleBlock<f64>>),
}

impl TriangleBlocks {
    /// Lays out the triangles of `bvh`'s leaves.
    pub(super) fn new(positions: &VectorList<DVec3>, indices: &[[u32; 3]], bvh: &Bvh) -> Self {
        match positions {
            VectorList::Single(_) => Self::Single(lay_out(positions, indices, bvh)),
            VectorList::Double(_) => Self::Double(lay_out(positions, indices, bvh)),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Single(blocks) => size_of_val(&**blocks),
            Self::Double(blocks) => size_of_val(&**blocks),
        }
    }
}

fn lay_out<T: Coordinate>(
    positions: &VectorList<DVec3>,
    indices: &[[u32; 3]],
    bvh: &Bvh,
) -> Vec<TriangleBlock<T>> {
    let leaves: Vec<_> = bvh.leaves().collect();
    let block = |&leaf: &_| {
        TriangleBlock::new(bvh.leaf(leaf).iter().map(|&face| {
            (face, indices[face as usize].map(|vertex| positions.get(vertex).unwrap_or_default()))
        }))
    };
    parallel_map(&leaves, PARALLEL_CHUNK, block)
}
