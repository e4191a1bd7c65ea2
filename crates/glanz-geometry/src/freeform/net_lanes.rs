//! The iteration of [`net_search`](super::net_search) for eight pairs of a ray and a certified leaf at once, with the same bits,
//! for nets of degrees up to [`MOST_DEGREE`].
//!
//! Pairs of one subpatch share its control points; those of other pairs are transposed into lanes. Lanes in which the iteration does
//! more than Newton's steps inside the leaf are left to the search for a single pair.

use glanz_math::glam::DVec4;

use super::control_net::BINOMIALS;
use super::leaf::PatchLeaf;
use super::pair_lanes::{BoundLanes, JetLanes, PairLanes, RootLanes};
use super::ray_lanes::{cross, dot2, dot3};
use super::subpatches::Subpatch;
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;

/// Largest degree in one direction; nets of higher degrees are searched one by one.
pub(super) const MOST_DEGREE: usize = 9;

/// Largest number of steps of eight pairs; those that need more are searched one by one.
const MAX_LANE_STEPS: usize = 8;

/// A control point of eight pairs.
trait PointLanes<S: Simd> {
    /// Its homogeneous coordinates.
    fn coordinates(&self, simd: S) -> [S::Wide; 4];
}

/// The same point in all lanes.
impl<S: Simd> PointLanes<S> for DVec4 {
    #[inline(always)]
    fn coordinates(&self, simd: S) -> [S::Wide; 4] {
        [simd.splat8(self.x), simd.splat8(self.y), simd.splat8(self.z), simd.splat8(self.w)]
    }
}

/// The coordinates of a point per lane.
type DifferentPoints = [[f64; LANES]; 4];

impl<S: Simd> PointLanes<S> for DifferentPoints {
    #[inline(always)]
    fn coordinates(&self, simd: S) -> [S::Wide; 4] {
        let [x, y, z, w] = self;
        [simd.load8(x), simd.load8(y), simd.load8(z), simd.load8(w)]
    }
}

/// Memory for the control points of eight pairs of different subpatches, in lanes: four coordinates per point.
#[derive(Default)]
pub(super) struct NetBuffer {
    lanes: Vec<DifferentPoints>,
}

impl NetBuffer {
    /// The control points of nets of the same degrees.
    #[inline(always)]
    fn fill<S: Simd>(
        &mut self,
        simd: S,
        list: &[Subpatch],
        first: &Subpatch,
        leaves: &[&PatchLeaf; LANES],
    ) -> Option<&[DifferentPoints]> {
        let mut nets = [&*first.net; LANES];
        for (net, leaf) in nets.iter_mut().zip(leaves) {
            let subpatch = list.get(leaf.subpatch as usize)?;
            if subpatch.degrees != first.degrees {
                return None;
            }
            *net = &subpatch.net;
        }
        self.lanes.clear();
        for start in (0..first.net.len()).step_by(2) {
            // Two points; behind the last one it is repeated.
            let mut rows = [[0.0; LANES]; LANES];
            for (row, net) in rows.iter_mut().zip(nets) {
                let (p, q) = (net.get(start)?, net.get(start + 1).or(net.get(start))?);
                *row = [p.x, p.y, p.z, p.w, q.x, q.y, q.z, q.w];
            }
            let [a, b, c, d, e, f, g, h] = &rows;
            let columns = simd.columns8(&[a, b, c, d, e, f, g, h]);
            for half in columns.as_chunks::<4>().0 {
                let [x, y, z, w] = *half;
                self.lanes.push([simd.store8(x), simd.store8(y), simd.store8(z), simd.store8(w)]);
            }
        }
        Some(&self.lanes)
    }
}

/// The Bernstein polynomials of a degree less than `N`, and their derivatives.
pub(super) struct BasisLanes<S: Simd, const N: usize> {
    pub(super) values: [S::Wide; N],
    pub(super) derivatives: [S::Wide; N],
}

impl<S: Simd, const N: usize> BasisLanes<S, N> {
    /// In the order of [`BernsteinPowers`](super::control_net::BernsteinPowers).
    #[inline(always)]
    pub(super) fn new(simd: S, degree: usize, at: S::Wide) -> Self {
        match degree {
            // The most frequent ones, with loops of a fixed length.
            3 => Self::of_degree(simd, 3, at),
            4 => Self::of_degree(simd, 4, at),
            5 => Self::of_degree(simd, 5, at),
            6 => Self::of_degree(simd, 6, at),
            7 => Self::of_degree(simd, 7, at),
            _ => Self::of_degree(simd, degree, at),
        }
    }

    #[inline(always)]
    fn of_degree(simd: S, degree: usize, at: S::Wide) -> Self {
        // Half-open ranges: loops over inclusive ones are not unrolled.
        let one = simd.splat8(1.0);
        let (mut x, mut y) = ([one; N], [one; N]);
        let rest = simd.sub8(one, at);
        for i in 1..N {
            x[i] = simd.mul8(x[i - 1], at);
            y[i] = simd.mul8(y[i - 1], rest);
        }
        let zero = simd.splat8(0.0);
        let (mut values, mut lower) = ([zero; N], [zero; N]);
        for i in 0..degree + 1 {
            let binomial = simd.splat8(BINOMIALS[degree][i]);
            values[i] = simd.mul8(simd.mul8(binomial, x[i]), y[degree - i]);
        }
        for i in 0..degree {
            let binomial = simd.splat8(BINOMIALS[degree - 1][i]);
            lower[i] = simd.mul8(simd.mul8(binomial, x[i]), y[degree - 1 - i]);
        }
        let mut derivatives = [zero; N];
        let factor = simd.splat8(degree as f64);
        derivatives[0] = simd.mul8(simd.splat8(-(degree as f64)), lower[0]);
        for i in 1..degree + 1 {
            derivatives[i] = simd.mul8(factor, simd.sub8(lower[i - 1], lower[i]));
        }
        Self { values, derivatives }
    }
}

/// Points and first derivatives by the parameters of the nets.
struct SurfaceLanes<S: Simd> {
    s: [S::Wide; 3],
    su: [S::Wide; 3],
    sv: [S::Wide; 3],
}

/// The nets and the leaves of eight pairs.
struct NetLanes<'a, S: Simd, P> {
    points: &'a [P],
    degrees: (usize, usize),
    /// Centre and half sides of the leaves, in [0, 1]^2.
    middle: [S::Wide; 2],
    half: [S::Wide; 2],
}

impl<S: Simd, P: PointLanes<S>> NetLanes<'_, S, P> {
    /// The parameters in the net of a point of the leaf.
    #[inline(always)]
    fn at(&self, simd: S, x: [S::Wide; 2]) -> [S::Wide; 2] {
        [
            simd.add8(self.middle[0], simd.mul8(self.half[0], x[0])),
            simd.add8(self.middle[1], simd.mul8(self.half[1], x[1])),
        ]
    }

    /// The surface at a point of the leaf; its derivatives are zero if they are not `WANTED`.
    #[inline(always)]
    fn surface<const WANTED: bool>(&self, simd: S, x: [S::Wide; 2]) -> SurfaceLanes<S> {
        match self.degrees.1 {
            // The most frequent ones, with loops of a fixed length.
            4 => self.surface_in::<WANTED, 5>(simd, 4, x),
            5 => self.surface_in::<WANTED, 6>(simd, 5, x),
            6 => self.surface_in::<WANTED, 7>(simd, 6, x),
            7 => self.surface_in::<WANTED, 8>(simd, 7, x),
            q => self.surface_in::<WANTED, { MOST_DEGREE + 1 }>(simd, q, x),
        }
    }

    /// The same for the degree `q` along v, less than `N`.
    #[inline(always)]
    fn surface_in<const WANTED: bool, const N: usize>(
        &self,
        simd: S,
        q: usize,
        x: [S::Wide; 2],
    ) -> SurfaceLanes<S> {
        let [u, v] = self.at(simd, x);
        let p = self.degrees.0;
        let by_u = BasisLanes::<S, { MOST_DEGREE + 1 }>::new(simd, p, u);
        let by_v = BasisLanes::<S, N>::new(simd, q, v);
        let zero = simd.splat8(0.0);
        let (mut h, mut hu, mut hv) = ([zero; 4], [zero; 4], [zero; 4]);
        for (i, row) in self.points.chunks_exact(q + 1).take(p + 1).enumerate() {
            let (mut along, mut rise) = ([zero; 4], [zero; 4]);
            for (j, point) in row.iter().enumerate() {
                let coordinates = point.coordinates(simd);
                let (value, derivative) = (by_v.values[j], by_v.derivatives[j]);
                for k in 0..4 {
                    let coordinate = coordinates[k];
                    along[k] = simd.mul_add8(coordinate, value, along[k]);
                    if WANTED {
                        rise[k] = simd.mul_add8(coordinate, derivative, rise[k]);
                    }
                }
            }
            let (value, derivative) = (by_u.values[i], by_u.derivatives[i]);
            for k in 0..4 {
                h[k] = simd.mul_add8(along[k], value, h[k]);
                if WANTED {
                    hu[k] = simd.mul_add8(along[k], derivative, hu[k]);
                    hv[k] = simd.mul_add8(rise[k], value, hv[k]);
                }
            }
        }
        let per = simd.div8(simd.splat8(1.0), h[3]);
        let (mut s, mut su, mut sv) = ([zero; 3], [zero; 3], [zero; 3]);
        for k in 0..3 {
            s[k] = simd.mul8(h[k], per);
            if WANTED {
                su[k] = simd.mul8(simd.sub8(hu[k], simd.mul8(s[k], hu[3])), per);
                sv[k] = simd.mul8(simd.sub8(hv[k], simd.mul8(s[k], hv[3])), per);
            }
        }
        SurfaceLanes { s, su, sv }
    }

    /// The map to the plane across the rays.
    #[inline(always)]
    fn jet(&self, simd: S, pairs: &PairLanes<S>, x: [S::Wide; 2]) -> JetLanes<S> {
        let SurfaceLanes { s, su, sv } = self.surface::<true>(simd, x);
        let from = from(simd, pairs, s);
        let [a, b] = pairs.rays.axes;
        let [hu, hv] = self.half;
        JetLanes {
            f: [dot3(simd, a, from), dot3(simd, b, from)],
            fs: [simd.mul8(hu, dot3(simd, a, su)), simd.mul8(hu, dot3(simd, b, su))],
            ft: [simd.mul8(hv, dot3(simd, a, sv)), simd.mul8(hv, dot3(simd, b, sv))],
        }
    }
}

/// The vectors from the origins of the rays.
#[inline(always)]
fn from<S: Simd>(simd: S, pairs: &PairLanes<S>, s: [S::Wide; 3]) -> [S::Wide; 3] {
    let [x, y, z] = pairs.rays.origin;
    [simd.sub8(s[0], x), simd.sub8(s[1], y), simd.sub8(s[2], z)]
}

/// The roots of eight pairs of a ray and a certified leaf; `None` for nets that are not searched in lanes.
#[inline(always)]
pub(super) fn roots<S: Simd>(
    simd: S,
    buffer: &mut NetBuffer,
    list: &[Subpatch],
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> Option<RootLanes<S>> {
    let first = list.get(leaves[0].subpatch as usize)?;
    let degrees = first.degrees;
    if degrees.0.max(degrees.1) > MOST_DEGREE {
        return None;
    }
    if leaves.iter().all(|leaf| leaf.subpatch == leaves[0].subpatch) {
        Some(roots_of(simd, &first.net, degrees, leaves, pairs))
    } else {
        let points = buffer.fill(simd, list, first, leaves)?;
        Some(roots_of(simd, points, degrees, leaves, pairs))
    }
}

/// The same for given nets.
#[inline(always)]
fn roots_of<S: Simd>(
    simd: S,
    points: &[impl PointLanes<S>],
    degrees: (usize, usize),
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> RootLanes<S> {
    let mut numbers = [[0.0; LANES]; 5];
    for (k, leaf) in leaves.iter().enumerate() {
        let middle = leaf.part.at(glanz_math::DVec2::splat(0.5));
        let half = 0.5 * leaf.part.width();
        let row = [middle.x, middle.y, half.x, half.y, leaf.curvature_bound()];
        for (list, x) in numbers.iter_mut().zip(row) {
            list[k] = x;
        }
    }
    let [mx, my, hx, hy, curvature] = &numbers;
    let net = NetLanes {
        points,
        degrees,
        middle: [simd.load8(mx), simd.load8(my)],
        half: [simd.load8(hx), simd.load8(hy)],
    };
    let one = simd.splat8(1.0);
    let bounds =
        BoundLanes { noise: pairs.rays.noise, curvature_bound: simd.load8(curvature), weights: [one; 2] };
    let (converged, excluded, x) = contract(simd, &net, pairs, &bounds);
    let s = net.surface::<false>(simd, x).s;
    let s = dot3(simd, pairs.rays.direction, from(simd, pairs, s));
    RootLanes { converged, excluded, s, at: net.at(simd, x) }
}

/// The steps of [`contract`](super::contraction::contract) that are Newton's: the lanes with a root, those without one, and the roots.
#[inline(always)]
fn contract<S: Simd>(
    simd: S,
    net: &NetLanes<'_, S, impl PointLanes<S>>,
    pairs: &PairLanes<S>,
    bounds: &BoundLanes<S>,
) -> (u32, u32, [S::Wide; 2]) {
    let PairLanes { a, b, q, inverse_determinant: per, .. } = *pairs;
    let (one, minus) = (simd.splat8(1.0), simd.splat8(-1.0));
    let ball = simd.div8(q, simd.sub8(one, q));
    let factor = simd.mul8(simd.mul8(simd.splat8(2.0), bounds.noise), simd.abs8(per));
    let unsure =
        [simd.mul8(simd.sqrt8(dot2(simd, b, b)), factor), simd.mul8(simd.sqrt8(dot2(simd, a, a)), factor)];
    let most_unsure = simd.max8(unsure[0], unsure[1]);
    let mut x = pairs.start;
    for x in &mut x {
        *x = simd.min8(simd.max8(*x, minus), one);
    }
    let mut last = simd.splat8(f64::INFINITY);
    let (mut open, mut converged, mut excluded, mut root) = (pairs.mask, 0, 0, x);
    for _ in 0..MAX_LANE_STEPS {
        let jet = net.jet(simd, pairs, x);
        let simple = [simd.mul8(cross(simd, jet.f, b), per), simd.mul8(cross(simd, a, jet.f), per)];
        let length = simd.sqrt8(dot2(simd, simple, simple));
        let away = simd.max8(simd.abs8(simd.sub8(x[0], simple[0])), simd.abs8(simd.sub8(x[1], simple[1])));
        let limit = simd.add8(simd.add8(one, simd.mul8(length, ball)), most_unsure);
        let outside = open & simd.less8(limit, away);
        excluded |= outside;
        open &= !outside;
        let det = cross(simd, jet.fs, jet.ft);
        let step = jet.newton_step(simd, det);
        let finite = simd
            .less8(simd.max8(simd.abs8(step[0]), simd.abs8(step[1])), simd.splat8(f64::INFINITY))
            & simd.at_most8(step[0], step[0])
            & simd.at_most8(step[1], step[1]);
        open &= finite & simd.less8(length, simd.mul8(simd.splat8(0.75), last));
        last = length;
        let to = [simd.sub8(x[0], step[0]), simd.sub8(x[1], step[1])];
        let inside = simd.at_most8(minus, to[0])
            & simd.at_most8(minus, to[1])
            & simd.at_most8(to[0], one)
            & simd.at_most8(to[1], one);
        let ended = open & inside & jet.ends(simd, bounds, det, step, [one; 2]);
        let (mut next, mut moving) = (to, 0);
        for k in 0..2 {
            next[k] = simd.min8(simd.max8(to[k], minus), one);
            root[k] = simd.select8(ended, next[k], root[k]);
            moving |= simd.less8(unsure[k], simd.abs8(simd.sub8(next[k], x[k])));
        }
        converged |= ended;
        open &= !ended & moving;
        if open == 0 {
            break;
        }
        x = next;
    }
    (converged, excluded, root)
}
