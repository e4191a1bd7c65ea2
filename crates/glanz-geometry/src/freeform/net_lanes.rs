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

impl<S: Simd> SurfaceLanes<S> {
    /// Evaluates the surface at a point of the leaf in the lanes `open`, of which those in `old` keep their derivatives. Returns the points
    /// of the derivatives, which were those at `at`.
    #[inline(always)]
    fn move_to<const COORDINATES: usize>(
        &mut self,
        simd: S,
        net: &NetLanes<'_, S, impl PointLanes<S>, COORDINATES>,
        x: [S::Wide; 2],
        [open, old]: [u32; 2],
        at: [S::Wide; 2],
    ) -> [S::Wide; 2] {
        if open & !old == 0 {
            self.s = net.surface::<false>(simd, x).s;
            return at;
        }
        let new = net.surface::<true>(simd, x);
        self.s = new.s;
        for k in 0..3 {
            self.su[k] = simd.select8(old, self.su[k], new.su[k]);
            self.sv[k] = simd.select8(old, self.sv[k], new.sv[k]);
        }
        [simd.select8(old, at[0], x[0]), simd.select8(old, at[1], x[1])]
    }
}

/// The nets and the leaves of eight pairs. They have 3 coordinates, or 4 if weights differ.
struct NetLanes<'a, S: Simd, P, const COORDINATES: usize> {
    points: &'a [P],
    degrees: (usize, usize),
    /// Centre and half sides of the leaves, in [0, 1]^2.
    middle: [S::Wide; 2],
    half: [S::Wide; 2],
}

impl<S: Simd, P: PointLanes<S>, const COORDINATES: usize> NetLanes<'_, S, P, COORDINATES> {
    /// The parameters in the net of a point of the leaf.
    #[inline(always)]
    fn at(&self, simd: S, x: [S::Wide; 2]) -> [S::Wide; 2] {
        [
            simd.add8(self.middle[0], simd.mul8(self.half[0], x[0])),
            simd.add8(self.middle[1], simd.mul8(self.half[1], x[1])),
        ]
    }

    /// The surface at a point of the leaf; its derivatives are zero without `DERIVATIVES`.
    #[inline(always)]
    fn surface<const DERIVATIVES: bool>(&self, simd: S, x: [S::Wide; 2]) -> SurfaceLanes<S> {
        match self.degrees.1 {
            // The most frequent ones, with loops of a fixed length.
            4 => self.surface_in::<DERIVATIVES, 5>(simd, 4, x),
            5 => self.surface_in::<DERIVATIVES, 6>(simd, 5, x),
            6 => self.surface_in::<DERIVATIVES, 7>(simd, 6, x),
            7 => self.surface_in::<DERIVATIVES, 8>(simd, 7, x),
            8 => self.surface_in::<DERIVATIVES, 9>(simd, 8, x),
            9 => self.surface_in::<DERIVATIVES, 10>(simd, 9, x),
            q => self.surface_in::<DERIVATIVES, { MOST_DEGREE + 1 }>(simd, q, x),
        }
    }

    /// The same for the degree `q` along v, less than `N`.
    #[inline(always)]
    fn surface_in<const DERIVATIVES: bool, const N: usize>(
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
        let (mut h, mut hu, mut hv) = ([zero; COORDINATES], [zero; COORDINATES], [zero; COORDINATES]);
        for (i, row) in self.points.chunks_exact(q + 1).take(p + 1).enumerate() {
            let (mut along, mut rise) = ([zero; COORDINATES], [zero; COORDINATES]);
            for (j, point) in row.iter().enumerate() {
                let coordinates = point.coordinates(simd);
                let (value, derivative) = (by_v.values[j], by_v.derivatives[j]);
                for k in 0..COORDINATES {
                    along[k] = simd.mul_add8(coordinates[k], value, along[k]);
                    if DERIVATIVES {
                        rise[k] = simd.mul_add8(coordinates[k], derivative, rise[k]);
                    }
                }
            }
            let (value, derivative) = (by_u.values[i], by_u.derivatives[i]);
            for k in 0..COORDINATES {
                h[k] = simd.mul_add8(along[k], value, h[k]);
                if DERIVATIVES {
                    hu[k] = simd.mul_add8(along[k], derivative, hu[k]);
                    hv[k] = simd.mul_add8(rise[k], value, hv[k]);
                }
            }
        }
        let (mut s, mut su, mut sv) = ([h[0], h[1], h[2]], [hu[0], hu[1], hu[2]], [hv[0], hv[1], hv[2]]);
        if COORDINATES == 4 {
            let (w, wu, wv) = (h[COORDINATES - 1], hu[COORDINATES - 1], hv[COORDINATES - 1]);
            let per = simd.div8(simd.splat8(1.0), w);
            for k in 0..3 {
                s[k] = simd.mul8(s[k], per);
                if DERIVATIVES {
                    su[k] = simd.mul8(simd.sub8(su[k], simd.mul8(s[k], wu)), per);
                    sv[k] = simd.mul8(simd.sub8(sv[k], simd.mul8(s[k], wv)), per);
                }
            }
        }
        SurfaceLanes { s, su, sv }
    }

    /// The map to the plane across the rays.
    #[inline(always)]
    fn jet(&self, simd: S, pairs: &PairLanes<S>, surface: &SurfaceLanes<S>) -> JetLanes<S> {
        let SurfaceLanes { s, su, sv } = *surface;
        let from = from(simd, pairs, s);
        let [a, b] = pairs.rays.axes;
        let [hu, hv] = self.half;
        JetLanes {
            f: [dot3(simd, a, from), dot3(simd, b, from)],
            fs: [simd.mul8(hu, dot3(simd, a, su)), simd.mul8(hu, dot3(simd, b, su))],
            ft: [simd.mul8(hv, dot3(simd, a, sv)), simd.mul8(hv, dot3(simd, b, sv))],
        }
    }

    /// Arc lengths along the rays at the end of a short step from a point where the surface is given.
    #[inline(always)]
    fn along(&self, simd: S, pairs: &PairLanes<S>, surface: &SurfaceLanes<S>, step: [S::Wide; 2]) -> S::Wide {
        let SurfaceLanes { s, su, sv } = *surface;
        let along = pairs.rays.direction;
        let by = [simd.mul8(self.half[0], step[0]), simd.mul8(self.half[1], step[1])];
        let sum = dot3(simd, along, from(simd, pairs, s));
        let sum = simd.add8(sum, simd.mul8(dot3(simd, along, su), by[0]));
        simd.add8(sum, simd.mul8(dot3(simd, along, sv), by[1]))
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
        Some(roots_of(simd, first.rational, &first.net, degrees, leaves, pairs))
    } else {
        let points = buffer.fill(simd, list, first, leaves)?;
        Some(roots_of(simd, first.rational, points, degrees, leaves, pairs))
    }
}

/// The same for given nets, in 4 coordinates if they are rational.
#[inline(always)]
fn roots_of<S: Simd>(
    simd: S,
    rational: bool,
    points: &[impl PointLanes<S>],
    degrees: (usize, usize),
    leaves: &[&PatchLeaf; LANES],
    pairs: &PairLanes<S>,
) -> RootLanes<S> {
    if rational {
        roots_in::<S, 4>(simd, points, degrees, leaves, pairs)
    } else {
        roots_in::<S, 3>(simd, points, degrees, leaves, pairs)
    }
}

/// The same in this number of coordinates.
#[inline(always)]
fn roots_in<S: Simd, const COORDINATES: usize>(
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
    let net = NetLanes::<_, _, COORDINATES> {
        points,
        degrees,
        middle: [simd.load8(mx), simd.load8(my)],
        half: [simd.load8(hx), simd.load8(hy)],
    };
    let one = simd.splat8(1.0);
    let bounds =
        BoundLanes { noise: pairs.rays.noise, curvature_bound: simd.load8(curvature), weights: [one; 2] };
    contract(simd, &net, pairs, &bounds)
}

/// The steps of [`contract`](super::contraction::contract) that are Newton's.
#[inline(always)]
fn contract<S: Simd, const COORDINATES: usize>(
    simd: S,
    net: &NetLanes<'_, S, impl PointLanes<S>, COORDINATES>,
    pairs: &PairLanes<S>,
    bounds: &BoundLanes<S>,
) -> RootLanes<S> {
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
    let (mut open, mut converged, mut excluded, mut root, mut s) = (pairs.mask, 0, 0, x, last);
    // The lanes that keep their derivatives for another step, and the points of the derivatives.
    let (mut old, mut at) = (0, x);
    let mut surface = SurfaceLanes { s: [last; 3], su: [last; 3], sv: [last; 3] };
    for _ in 0..MAX_LANE_STEPS {
        at = surface.move_to(simd, net, x, [open, old], at);
        let jet = net.jet(simd, pairs, &surface);
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
        let away_from_old = [simd.sub8(x[0], at[0]), simd.sub8(x[1], at[1])];
        let ended = open & inside & jet.ends_from(simd, bounds, det, step, away_from_old);
        let (mut next, mut moving) = (to, 0);
        for k in 0..2 {
            next[k] = simd.min8(simd.max8(to[k], minus), one);
            root[k] = simd.select8(ended, next[k], root[k]);
            moving |= simd.less8(unsure[k], simd.abs8(simd.sub8(next[k], x[k])));
        }
        if ended != 0 {
            // The last step is so short that the surface is straight along it, to within rounding.
            let step = [simd.sub8(next[0], x[0]), simd.sub8(next[1], x[1])];
            s = simd.select8(ended, net.along(simd, pairs, &surface, step), s);
        }
        converged |= ended;
        open &= !ended & moving;
        old = open & inside & !old & jet.next_ends(simd, bounds, det, step);
        if open == 0 {
            break;
        }
        x = next;
    }
    RootLanes { converged, excluded, s, at: net.at(simd, root) }
}
