//! The roots of one ray with one leaf: excluded, certified, or split.
//!
//! A leaf is asked in three steps, each dearer than the last and rarer.
//!
//! 1. *The thick parallelogram.* Seen along the ray it is a parallelogram in the plane, thickened by its reach; if the
//!    ray passes outside, there is no root.
//! 2. *Certified.* If the Jacobian of the leaf, seen along the ray, strays from that of the parallelogram by a factor
//!    q < 1, the map is injective and its simplified Newton step contracts by q; projected on the parameter square it
//!    still does, so that its fixed point is the only root or proof that there is none.
//! 3. *Split* (`cells`): the coefficients are halved until every cell is excluded, certified, or of the size of rounding.

use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3, Frame as Axes, Ray};

use super::cells::{self, Patch};
use super::leaf::Frame;
use super::net::{bernstein, with_room};
use super::view::Place;
use crate::line::Line;

/// Largest factor q at which step 2 is taken; above, halving is cheaper than many steps.
const CERTIFIED: f64 = 0.5;

/// Steps of Newton's method before what contracts slowly is called undecided: (1/2)^60 is below rounding.
const MOST_STEPS: usize = 80;

/// The coefficients of a leaf, one list per coordinate, that of (i, j) at j (p + 1) + i: the four of bicubic ones that
/// are added up are neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Net<'a> {
    /// Degrees.
    pub(super) degrees: (usize, usize),
    /// x, y, z and, of rational leaves, w.
    pub(super) lists: &'a [f64],
    /// Whether there is a list for w.
    pub(super) rational: bool,
}

/// Is told of roots. Not a closure, which would not be compiled for the instruction set of the search.
pub(super) trait OnRoot {
    /// Takes a root.
    fn root(&mut self, root: Root);
}

/// A ray in the frame of the search: two planes through it, and its origin next to the surface.
pub(super) struct Probe {
    pub(super) line: Line,
    /// Unit vectors across the ray.
    pub(super) axes: [DVec3; 2],
    /// Metres that a computed point of the surface may be off across the ray, by rounding.
    pub(super) noise: f64,
}

/// A root in the parameters of its leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Root {
    /// Arc length along [`Probe::line`], metres.
    pub(super) s: f64,
    /// In [0, 1].
    pub(super) x: f64,
    pub(super) y: f64,
    /// By how much rounding may move it, in the leaf's parameters.
    pub(super) blur: DVec2,
    /// The same in metres along the surface.
    pub(super) reach: f64,
}

/// Point and first derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent {
    pub(super) s: DVec3,
    pub(super) su: DVec3,
    pub(super) sv: DVec3,
}

/// What all rays of a surface share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    center: DVec3,
    /// From farther away than this from the centre, squared, rays are moved next to it.
    far_squared: f64,
    /// Largest coordinate, metres.
    size: f64,
    /// Rounding of a point, relative to its coordinates and those of the ray.
    relative: f64,
}

impl Sight {
    /// `size` bounds the coordinates of the surface in `bounds`, `degrees` those of its patches.
    pub(super) fn new(bounds: &Bounds3, size: f64, (p, q): (usize, usize)) -> Self {
        let radius_squared = 0.25 * bounds.diagonal().length_squared();
        let relative = gamma(4 * (p + q) as u32 + 24);
        Self { center: bounds.center(), far_squared: 16.0 * radius_squared, size, relative }
    }

    /// Largest noise of a ray that starts within the surface, metres.
    pub(super) fn noise_within(&self) -> f64 {
        self.relative * 2.0 * self.size
    }

    #[inline(always)]
    pub(super) fn probe(&self, ray: &Ray) -> Probe {
        // From far away digits are lost; from near the surface the origin must stay where it is.
        let far = ray.origin.distance_squared(self.center) > self.far_squared;
        let line = if far { Line::nearest_to(ray, self.center) } else { Line::new(ray, 0.0) };
        let axes = Axes::from_z(line.direction);
        let noise = self.relative * (self.size + line.origin.abs().max_element());
        Probe { line, axes: [axes.x, axes.y], noise }
    }
}

impl Probe {
    /// A direction as it is seen along the ray.
    #[inline(always)]
    pub(super) fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.axes[0].dot(v), self.axes[1].dot(v))
    }
}

impl Net<'_> {
    #[inline(always)]
    pub(super) fn tangent(&self, x: f64, y: f64) -> Tangent {
        with_room!(self.degrees.0.max(self.degrees.1), N => self.tangent_in::<N>(x, y))
    }

    #[inline(always)]
    fn tangent_in<const N: usize>(&self, x: f64, y: f64) -> Tangent {
        let (p, q) = self.degrees;
        let ([bx, dx, _], [by, dy, _]) = (bernstein::<N>(p, x), bernstein::<N>(q, y));
        let mut sums = [[0.0; 3]; 4];
        for (sum, list) in sums.iter_mut().zip(self.lists.chunks_exact((p + 1) * (q + 1))) {
            *sum = weighted(list, p + 1, &bx, &dx, &by, &dy);
        }
        let [x, y, z, w] = sums;
        let tangent = Tangent::of([x, y, z]);
        if self.rational { tangent.over(w) } else { tangent }
    }
}

impl Patch for Net<'_> {
    fn degrees(&self) -> (usize, usize) {
        self.degrees
    }

    fn project(&self, probe: &Probe, cells: &mut Vec<f64>) -> f64 {
        cells.clear();
        let n = (self.degrees.0 + 1) * (self.degrees.1 + 1);
        let o = probe.line.origin;
        let mut lists = self.lists.chunks_exact(n);
        let (Some(x), Some(y), Some(z)) = (lists.next(), lists.next(), lists.next()) else { return 0.0 };
        let weights = lists.next();
        let weight = |k: usize| weights.map_or(1.0, |w| w[k]);
        for axis in probe.axes {
            cells.extend((0..n).map(|k| {
                let w = weight(k);
                (x[k] - o.x * w) * axis.x + (y[k] - o.y * w) * axis.y + (z[k] - o.z * w) * axis.z
            }));
        }
        2.0 * probe.noise * (0..n).fold(0.0, |most: f64, k| most.max(weight(k)))
    }

    fn tangent(&self, x: f64, y: f64) -> Tangent {
        Net::tangent(self, x, y)
    }

    fn noise(&self, probe: &Probe) -> f64 {
        probe.noise
    }
}

/// Sums of a list by bases: value, derivative by x, by y.
#[inline(always)]
pub(super) fn weighted<const N: usize>(
    list: &[f64],
    stride: usize,
    bx: &[f64; N],
    dx: &[f64; N],
    by: &[f64; N],
    dy: &[f64; N],
) -> [f64; 3] {
    // Over the rows first, whose entries are neighbours.
    let (mut values, mut rises) = ([0.0; N], [0.0; N]);
    for ((row, by), dy) in list.chunks_exact(stride).zip(by).zip(dy) {
        for ((value, rise), coefficient) in values.iter_mut().zip(&mut rises).zip(row) {
            *value += coefficient * by;
            *rise += coefficient * dy;
        }
    }
    let mut sums = [0.0; 3];
    for i in 0..N {
        sums[0] += values[i] * bx[i];
        sums[1] += values[i] * dx[i];
        sums[2] += rises[i] * bx[i];
    }
    sums
}

impl Tangent {
    #[inline(always)]
    fn of([x, y, z]: [[f64; 3]; 3]) -> Self {
        let at = |k: usize| DVec3::new(x[k], y[k], z[k]);
        Self { s: at(0), su: at(1), sv: at(2) }
    }

    /// The quotient by a weight with its derivatives.
    #[inline(always)]
    fn over(self, [w, wu, wv]: [f64; 3]) -> Self {
        let per = 1.0 / w;
        let s = self.s * per;
        Self { s, su: (self.su - s * wu) * per, sv: (self.sv - s * wv) * per }
    }
}

/// The z component of the cross product.
#[inline(always)]
pub(super) fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// What a search may need more than once.
#[derive(Default)]
pub(super) struct Scratch {
    /// Coefficients of cells.
    pub(super) cells: Vec<f64>,
    /// Roots of the present leaf, in its own parameters.
    pub(super) places: Vec<Place>,
    /// The same as they are reported.
    pub(super) roots: Vec<Root>,
    /// Leaves whose cells were given up.
    pub(super) undecided: u64,
}

/// Reports every root of the leaf, in no order.
#[inline(always)]
pub(super) fn roots<'a>(
    frame: &Frame,
    net: impl FnOnce() -> Net<'a>,
    probe: &Probe,
    scratch: &mut Scratch,
    report: &mut impl OnRoot,
) {
    let c = probe.across(frame.center - probe.line.origin);
    let (a, b) = (probe.across(frame.along_u), probe.across(frame.along_v));
    let det = cross(a, b);
    let (s, t) = (-cross(c, b), -cross(a, c));
    let (a2, b2) = (a.length_squared(), b.length_squared());
    let reach = frame.reach + probe.noise;
    // |s| > 1 + reach |b| / |det| without a division; squares would need a root either way.
    let outside = |s: f64, across: f64| {
        let beyond = s.abs() - det.abs();
        beyond > 0.0 && beyond * beyond > reach * reach * across
    };
    if outside(s, b2) || outside(t, a2) {
        return;
    }
    let net = &net();
    // Where rounding moves the root by more than a part of the leaf, nothing is certified.
    let unsure = 16.0 * probe.noise;
    let q2 = (frame.stray_squared + unsure * unsure) * (a2 + b2);
    if q2 < CERTIFIED * CERTIFIED * det * det {
        match certified(frame, net, probe, [a, b], DVec2::new(s, t) / det) {
            Ok(Some(root)) => report.root(root),
            Ok(None) => {}
            Err(Undecided) => scratch.undecided += 1,
        }
    } else {
        cells::roots(net, probe, scratch);
        for root in scratch.roots.drain(..) {
            report.root(root);
        }
    }
}

/// The steps did not end.
struct Undecided;

/// The root of a leaf that has at most one, from the place where its parallelogram has it.
#[inline(always)]
fn certified(
    frame: &Frame,
    net: &Net<'_>,
    probe: &Probe,
    [a, b]: [DVec2; 2],
    start: DVec2,
) -> Result<Option<Root>, Undecided> {
    let per = 1.0 / cross(a, b);
    let (a2, b2) = (a.length_squared(), b.length_squared());
    let q = (frame.stray_squared * (a2 + b2)).sqrt() * per.abs();
    // Parameters that rounding may move a step by.
    let blur = DVec2::new(b2, a2).map(f64::sqrt) * (2.0 * probe.noise * per.abs());
    let mut x = start.clamp(DVec2::NEG_ONE, DVec2::ONE);
    let mut last = f64::INFINITY;
    let mut ends = false;
    for _ in 0..MOST_STEPS {
        let tangent = net.tangent(0.5 + 0.5 * x.x, 0.5 + 0.5 * x.y);
        let from = tangent.s - probe.line.origin;
        let f = probe.across(from);
        let along = |s: DVec3| probe.line.direction.dot(s);
        // The simplified step: the root lies in a ball of radius q / (1 - q) of its length around its end.
        let simple = DVec2::new(cross(f, b), cross(a, f)) * per;
        let length = simple.length();
        let end = (x - simple).abs().max_element();
        if end > 1.0 + length * (q / (1.0 - q)) + blur.max_element() {
            return Ok(None);
        }
        if f.length_squared() <= probe.noise * probe.noise {
            return Ok(Some(root(frame, x, along(from), blur)));
        }
        // The true one, with derivatives by (s, t): half of those by (x, y).
        let (ju, jv) = (probe.across(tangent.su) * 0.5, probe.across(tangent.sv) * 0.5);
        let newton = DVec2::new(cross(f, jv), cross(ju, f)) / cross(ju, jv);
        let step = if length < 0.75 * last { newton } else { simple };
        last = length;
        let next = (x - step).clamp(DVec2::NEG_ONE, DVec2::ONE);
        let moved = next - x;
        // At a border the steps end; in the last bits they may go round.
        let met = f.length_squared() <= 16.0 * probe.noise * probe.noise;
        ends = moved.abs().cmple(blur).all();
        if moved == DVec2::ZERO || (met && ends) {
            return Ok(met.then(|| root(frame, x, along(from), blur)));
        }
        // A step whose error by curvature is below rounding needs no look at its end.
        if next == x - step && step == newton && frame.bend * moved.length_squared() <= probe.noise {
            let s = along(from) + 0.5 * (along(tangent.su) * moved.x + along(tangent.sv) * moved.y);
            return Ok(Some(root(frame, next, s, blur)));
        }
        x = next;
    }
    if ends { Ok(None) } else { Err(Undecided) }
}

#[inline(always)]
fn root(frame: &Frame, x: DVec2, s: f64, blur: DVec2) -> Root {
    let reach = blur.x * frame.along_u.length() + blur.y * frame.along_v.length();
    // From parameters in [-1, 1] to those in [0, 1].
    Root { s, x: 0.5 + 0.5 * x.x, y: 0.5 + 0.5 * x.y, blur: 0.5 * blur, reach }
}
