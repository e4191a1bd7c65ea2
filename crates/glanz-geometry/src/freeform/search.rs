//! The roots of one ray with one leaf of any degree: excluded, certified, or split.
//!
//! A leaf is asked in three steps, each dearer than the last and rarer.
//!
//! 1. *The thick parallelogram.* Seen along the ray it is a parallelogram in the plane, thickened by its reach; if the
//!    ray passes outside, there is no root.
//! 2. *Certified.* If the Jacobian of the leaf, seen along the ray, strays from that of the parallelogram by a factor
//!    q < 1, the map is injective and its simplified Newton step contracts by q; projected on the parameter square it
//!    still does, so that its fixed point is the only root or proof that there is none.
//! 3. *Split* (`cells`): the coefficients are halved until every cell is excluded, certified, or of the size of rounding.

use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3, Frame as Axes, Ray};

use super::cells::{self, Patch};
use super::contract::{GaveUp, Jet, Limits, Map, Place, contract};
use super::leaf::{Leaf, Look};
use super::net;
use super::part::Part;
use crate::bvh::simd::Simd;
use crate::ray_line::RayLine;

/// Steps in a certified leaf. Those of the contraction alone would be more; then the slow way is taken.
const MOST_STEPS: usize = 24;

/// The homogeneous coefficients of a leaf, that of (i, j) at i (q + 1) + j.
#[derive(Clone, Copy, Debug)]
pub(super) struct Net<'a> {
    /// Degrees.
    pub(super) degrees: (usize, usize),
    pub(super) points: &'a [DVec4],
}

/// Is told of roots. Not a closure, which would not be compiled for the instruction set of the search.
pub(super) trait OnRoot {
    /// Takes a root.
    fn root(&mut self, root: Root);
}

/// A ray in the frame of the search: two planes through it, and its origin next to the surface.
pub(super) struct Probe {
    pub(super) line: RayLine,
    /// Unit vectors across the ray.
    pub(super) axes: [DVec3; 2],
    /// The centre of the surface as it is seen along the ray.
    pub(super) center: DVec2,
    /// Metres that a computed point of the surface may be off across the ray, by rounding.
    pub(super) noise: f64,
}

/// A root in the parameters of its subpatch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Root {
    /// Arc length along [`Probe::line`], metres.
    pub(super) s: f64,
    /// In [0, 1]^2.
    pub(super) at: DVec2,
    /// By how much rounding may move it, in the same parameters.
    pub(super) blur: DVec2,
    /// The same in metres along the surface.
    pub(super) reach: f64,
}

impl Root {
    /// From the parameters of a part to those of the whole.
    #[inline(always)]
    pub(super) fn of_part(self, part: Part) -> Self {
        Self { at: part.at(self.at), blur: self.blur * part.width(), ..self }
    }
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
    pub(super) center: DVec3,
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
        let line = if far { RayLine::nearest_to(ray, self.center) } else { RayLine::new(ray, 0.0) };
        let axes = Axes::from_z(line.direction);
        let noise = self.relative * (self.size + line.origin.abs().max_element());
        let from = self.center - line.origin;
        let center = DVec2::new(axes.x.dot(from), axes.y.dot(from));
        Probe { line, axes: [axes.x, axes.y], center, noise }
    }
}

impl Probe {
    /// A direction as it is seen along the ray.
    #[inline(always)]
    pub(super) fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.axes[0].dot(v), self.axes[1].dot(v))
    }
}

/// A leaf of any degree: a part of a net.
#[derive(Clone, Copy, Debug)]
struct NetLeaf<'a> {
    net: Net<'a>,
    part: Part,
}

impl Patch for NetLeaf<'_> {
    fn degrees(&self) -> (usize, usize) {
        self.net.degrees
    }

    fn project(&self, probe: &Probe, cells: &mut Vec<f64>) -> f64 {
        cells.clear();
        let Net { degrees: (p, q), points } = self.net;
        let o = probe.line.origin;
        for axis in probe.axes {
            for j in 0..=q {
                let column = points.iter().skip(j).step_by(q + 1).take(p + 1);
                cells.extend(column.map(|h| axis.dot(h.truncate() - o * h.w)));
            }
        }
        if points.iter().any(|h| h.w != 1.0) {
            for j in 0..=q {
                cells.extend(points.iter().skip(j).step_by(q + 1).take(p + 1).map(|h| h.w));
            }
        }
        cells::restrict(cells, (p, q), self.part);
        2.0 * probe.noise
    }

    fn tangent(&self, x: f64, y: f64) -> Tangent {
        let (at, width) = (self.part.at(DVec2::new(x, y)), self.part.width());
        let net::Jet { s, su, sv, .. } = net::jet(self.net.points, self.net.degrees, at.x, at.y);
        Tangent { s, su: su * width.x, sv: sv * width.y }
    }

    fn noise(&self, probe: &Probe) -> f64 {
        probe.noise
    }
}

/// A leaf of any degree as what a certificate is about: it is seen along the ray point by point.
struct Seen<'a, S> {
    simd: S,
    net: Net<'a>,
    /// Its middle and half its sides, in [0, 1]^2.
    middle: DVec2,
    half: DVec2,
    probe: &'a Probe,
}

impl<S: Simd> Map for Seen<'_, S> {
    #[inline(always)]
    fn jet(&self, x: DVec2) -> Jet {
        let Tangent { s, su, sv } = self.tangent(x);
        let Self { half, probe, .. } = self;
        Jet {
            f: probe.across(s - probe.line.origin),
            fs: half.x * probe.across(su),
            ft: half.y * probe.across(sv),
        }
    }

    #[inline(always)]
    fn weight(&self, _: DVec2) -> f64 {
        1.0
    }
}

impl<S: Simd> Seen<'_, S> {
    /// At a place of the leaf, with the derivatives by the parameters of the net.
    #[inline(always)]
    fn tangent(&self, x: DVec2) -> Tangent {
        let Self { simd, net: Net { degrees, points }, middle, half, .. } = *self;
        let at = middle + half * x;
        let [h, hu, hv] = net::first_order(simd, points, degrees, at.x, at.y);
        let per = 1.0 / h.w;
        let s = h.truncate() * per;
        let part = |d: DVec4| (d.truncate() - s * d.w) * per;
        Tangent { s, su: part(hu), sv: part(hv) }
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

/// Reports every root of the leaf of `net`, in no order.
#[inline(always)]
pub(super) fn roots<S: Simd>(
    simd: S,
    net: Net<'_>,
    leaf: &Leaf,
    look: &Look,
    probe: &Probe,
    scratch: &mut Scratch,
    report: &mut impl OnRoot,
) {
    let part = leaf.part;
    if look.certified {
        let limits = Limits { noise: probe.noise, bend: leaf.bend(), weights: [1.0; 2], steps: MOST_STEPS };
        let half = 0.5 * part.width();
        let map = Seen { simd, net, middle: part.at(DVec2::splat(0.5)), half, probe };
        match contract(&map, &look.certificate, &limits, look.flat) {
            Ok(None) => return,
            Ok(Some(place)) => {
                let Tangent { s, su, sv } = map.tangent(place.at);
                let (at, blur) = (map.middle + half * place.at, half * place.blur);
                let reach = blur.x * su.length() + blur.y * sv.length();
                report.root(Root { s: probe.line.direction.dot(s - probe.line.origin), at, blur, reach });
                return;
            }
            Err(GaveUp) => {}
        }
    }
    cells::roots(&NetLeaf { net, part }, probe, scratch);
    for root in scratch.roots.drain(..) {
        report.root(root.of_part(part));
    }
}
