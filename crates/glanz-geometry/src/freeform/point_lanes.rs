//! Points of eight hits of one patch at once: [`Freeform::point_at`] lane by lane, with the same bits.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::Freeform;
use super::net_lanes::{BasisLanes, MOST_DEGREE};
use super::parameter_rect::ParameterRect;
use super::patch_list::PatchCoefficients;
use super::ray_lanes::{cross, dot3};
use super::surface_patch::PatchPlacement;
use super::surface_point::{COLLAPSED, nowhere};
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::{Simd, Task};
use crate::hit::{Hit, SurfacePoint};

/// Number of hits of a patch from which on lanes are faster than points one by one.
const LEAST_HITS: usize = 3;

/// The points of hits, in their order, into an empty list.
pub(super) struct PointBatch<'a> {
    pub(super) surface: &'a Freeform,
    pub(super) hits: &'a [Hit],
    pub(super) points: &'a mut Vec<SurfacePoint>,
}

impl Task for PointBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { surface, hits, points } = self;
        let changes = hits.windows(2).filter(|pair| pair[0].face != pair[1].face).count();
        if LANES * changes < hits.len() {
            points.reserve(hits.len());
            for run in hits.chunk_by(|a, b| a.face == b.face) {
                for eight in run.chunks(LANES) {
                    surface.append_points(simd, eight, points);
                }
            }
            return;
        }
        // Hits in no order are sorted by patch.
        let mut order: Vec<u32> = (0..hits.len() as u32).collect();
        order.sort_unstable_by_key(|&k| hits[k as usize].face);
        points.resize(hits.len(), nowhere());
        let mut found = Vec::with_capacity(LANES);
        for run in order.chunk_by(|&a, &b| hits[a as usize].face == hits[b as usize].face) {
            for eight in run.chunks(LANES) {
                let mut of_patch = [hits[eight[0] as usize]; LANES];
                for (hit, &k) in of_patch.iter_mut().zip(eight) {
                    *hit = hits[k as usize];
                }
                found.clear();
                surface.append_points(simd, &of_patch[..eight.len()], &mut found);
                for (&k, point) in eight.iter().zip(&found) {
                    points[k as usize] = *point;
                }
            }
        }
    }
}

impl Freeform {
    /// Appends the points of up to eight hits of one patch.
    #[inline(always)]
    fn append_points<S: Simd>(&self, simd: S, hits: &[Hit], points: &mut Vec<SurfacePoint>) {
        // The lanes do not add the origin of a surface with coordinates of its own.
        let first = hits.first().filter(|_| hits.len() >= LEAST_HITS && !self.frame.is_moved());
        let in_lanes = first.and_then(|&Hit { face, .. }| {
            let (placement, coefficients) = (self.patches.placement(face)?, self.coefficients(face)?);
            let (p, q) = placement.degrees();
            let rectangle = placement.rectangle().filter(|_| p.max(q) <= MOST_DEGREE)?;
            Some((placement, coefficients, rectangle))
        });
        let Some((placement, coefficients, rectangle)) = in_lanes else {
            points.extend(hits.iter().map(|hit| self.point_at(hit.face, hit.u, hit.v)));
            return;
        };
        let mut at = [[0.5; LANES]; 2];
        for (k, hit) in hits.iter().enumerate() {
            (at[0][k], at[1][k]) = (hit.u, hit.v);
        }
        let jet = jet(simd, coefficients, &at);
        let lanes = EightPoints::new(simd, self, placement, jet, rectangle, &at);
        for (k, hit) in hits.iter().enumerate() {
            points.push(match lanes.regular >> k & 1 {
                0 => self.point_at(hit.face, hit.u, hit.v),
                _ => lanes.point(k, self.error()),
            });
        }
    }
}

/// Eight points of a patch.
struct EightPoints {
    /// Lanes in which the patch is not collapsed.
    regular: u32,
    position: [[f64; LANES]; 3],
    normal: [[f64; LANES]; 3],
    uv: [[f64; LANES]; 2],
    dpdu: [[f64; LANES]; 3],
    dpdv: [[f64; LANES]; 3],
}

impl EightPoints {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        surface: &Freeform,
        placement: &PatchPlacement,
        [s, su, sv]: [[S::Wide; 3]; 3],
        rectangle: &ParameterRect,
        [u, v]: &[[f64; LANES]; 2],
    ) -> Self {
        let n = cross3(simd, su, sv);
        let length = simd.sqrt8(dot3(simd, n, n));
        let (extent, one) = (placement.extent(), simd.splat8(1.0));
        let regular = simd.less8(simd.splat8(COLLAPSED * extent * extent), length);
        let normal = scaled(simd, n, simd.div8(one, length));
        let steep = 1e2 * surface.error();
        let [by_u, by_v] = placement.rates(0.5, 0.5);
        let sx = tangent(simd, su, normal, steep * steep);
        let sy = tangent(simd, sv, normal, steep * steep);
        let dpdu = along(simd, [sx, sy], by_u);
        let dpdv = along(simd, [sx, sy], by_v);
        let bounds = surface.bvh.bounds();
        let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
        let mut position = s;
        for k in 0..3 {
            let x = simd.max8(s[k], simd.splat8(low[k]));
            position[k] = simd.min8(x, simd.splat8(high[k]));
        }
        let (u, v) = (simd.load8(u), simd.load8(v));
        Self {
            regular,
            position: stored(simd, position),
            normal: stored(simd, normal),
            uv: [interpolated(simd, rectangle.u, u), interpolated(simd, rectangle.v, v)],
            dpdu: stored(simd, dpdu),
            dpdv: stored(simd, dpdv),
        }
    }

    #[inline(always)]
    fn point(&self, lane: usize, error: f64) -> SurfacePoint {
        let vector = |v: &[[f64; LANES]; 3]| DVec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let normal = vector(&self.normal);
        SurfacePoint {
            position: vector(&self.position),
            error: DVec3::splat(error),
            normal,
            shading_normal: normal,
            uv: DVec2::new(self.uv[0][lane], self.uv[1][lane]),
            dpdu: vector(&self.dpdu),
            dpdv: vector(&self.dpdv),
        }
    }
}

/// The point and its derivatives by the parameters of the patch, as by [`Freeform::first_order`].
#[inline(always)]
fn jet<S: Simd>(
    simd: S,
    coefficients: PatchCoefficients<'_>,
    [u, v]: &[[f64; LANES]; 2],
) -> [[S::Wide; 3]; 3] {
    let at = [simd.load8(u), simd.load8(v)];
    match coefficients {
        PatchCoefficients::Powers(patch) => patch.tangent_lanes(simd, at),
        // The most frequent ones, with loops of a fixed length.
        PatchCoefficients::Net { points, degrees: (3, 3) } => jet_of::<S, 4>(simd, points, (3, 3), at),
        PatchCoefficients::Net { points, degrees: (5, 5) } => jet_of::<S, 6>(simd, points, (5, 5), at),
        PatchCoefficients::Net { points, degrees } => {
            jet_of::<S, { MOST_DEGREE + 1 }>(simd, points, degrees, at)
        }
    }
}

#[inline(always)]
fn jet_of<S: Simd, const N: usize>(
    simd: S,
    points: &[DVec4],
    (p, q): (usize, usize),
    [u, v]: [S::Wide; 2],
) -> [[S::Wide; 3]; 3] {
    let (by_u, by_v) = (BasisLanes::<S, N>::new(simd, p, u), BasisLanes::<S, N>::new(simd, q, v));
    let zero = simd.splat8(0.0);
    let (mut h, mut hu, mut hv) = ([zero; 4], [zero; 4], [zero; 4]);
    for (i, row) in points.chunks_exact(q + 1).take(p + 1).enumerate() {
        let (mut along, mut rise) = ([zero; 4], [zero; 4]);
        for (j, point) in row.iter().enumerate() {
            let coordinates = point.to_array();
            for k in 0..4 {
                let x = simd.splat8(coordinates[k]);
                along[k] = simd.mul_add8(x, by_v.values[j], along[k]);
                rise[k] = simd.mul_add8(x, by_v.derivatives[j], rise[k]);
            }
        }
        for k in 0..4 {
            h[k] = simd.mul_add8(along[k], by_u.values[i], h[k]);
            hu[k] = simd.mul_add8(along[k], by_u.derivatives[i], hu[k]);
            hv[k] = simd.mul_add8(rise[k], by_u.values[i], hv[k]);
        }
    }
    let per = simd.div8(simd.splat8(1.0), h[3]);
    let [mut s, mut su, mut sv] = [[zero; 3]; 3];
    for k in 0..3 {
        s[k] = simd.mul8(h[k], per);
        su[k] = simd.mul8(simd.sub8(hu[k], simd.mul8(s[k], hu[3])), per);
        sv[k] = simd.mul8(simd.sub8(hv[k], simd.mul8(s[k], hv[3])), per);
    }
    [s, su, sv]
}

/// As [`ParameterRect::at`] in one direction.
#[inline(always)]
fn interpolated<S: Simd>(simd: S, [a, b]: [f64; 2], x: S::Wide) -> [f64; LANES] {
    let one = simd.splat8(1.0);
    let inside = simd.add8(simd.mul8(simd.splat8(b - a), x), simd.splat8(a));
    let at_end = simd.at_most8(x, one) & simd.at_most8(one, x);
    simd.store8(simd.select8(at_end, simd.splat8(b), inside))
}

#[inline(always)]
fn stored<S: Simd>(simd: S, [x, y, z]: [S::Wide; 3]) -> [[f64; LANES]; 3] {
    [simd.store8(x), simd.store8(y), simd.store8(z)]
}

/// The vector product.
#[inline(always)]
fn cross3<S: Simd>(simd: S, a: [S::Wide; 3], b: [S::Wide; 3]) -> [S::Wide; 3] {
    let [ax, ay, az] = a;
    let [bx, by, bz] = b;
    [cross(simd, [ay, az], [by, bz]), cross(simd, [az, ax], [bz, bx]), cross(simd, [ax, ay], [bx, by])]
}

#[inline(always)]
fn scaled<S: Simd>(simd: S, [x, y, z]: [S::Wide; 3], factor: S::Wide) -> [S::Wide; 3] {
    [simd.mul8(x, factor), simd.mul8(y, factor), simd.mul8(z, factor)]
}

/// The part of `s` across the unit vector `normal`; zero if `s` is not longer than the root of `least`.
#[inline(always)]
fn tangent<S: Simd>(simd: S, s: [S::Wide; 3], normal: [S::Wide; 3], least: f64) -> [S::Wide; 3] {
    let is_long = simd.less8(simd.splat8(least), dot3(simd, s, s));
    let off = scaled(simd, normal, dot3(simd, normal, s));
    let mut across = s;
    for k in 0..3 {
        across[k] = simd.select8(is_long, simd.sub8(s[k], off[k]), simd.splat8(0.0));
    }
    across
}

/// The derivative by a parameter of the surface, by which those of the patch change at `rate`.
#[inline(always)]
fn along<S: Simd>(simd: S, [sx, sy]: [[S::Wide; 3]; 2], rate: DVec2) -> [S::Wide; 3] {
    let mut sum = scaled(simd, sx, simd.splat8(rate.x));
    let other = scaled(simd, sy, simd.splat8(rate.y));
    for k in 0..3 {
        sum[k] = simd.add8(sum[k], other[k]);
    }
    sum
}
